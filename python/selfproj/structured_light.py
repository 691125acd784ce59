"""Structured light: patterns, the decoder at full speed, depth images, clouds; self-projected stripes.

    scan = selfproj.structured_light.scan(images, rig="scanner", bits=8, median=True)     # uint8, (n, rows, columns)
    selfproj.structured_light.save_ply("cloud.ply", scan.points())

    stripes = selfproj.structured_light.stripes_of_scan(rig, images_of_the_reference)
    difference = selfproj.structured_light.StripeScanner(stripes).scan(images).difference
"""

from . import pictures as _pictures
from ._core.structured_light import (GrayDecoder, GraySequence, Scan, StripeReference, StripeScan, StripeScanner,
                                     Triangulation, load_ply, load_stripes, save_ply, scan, stripes_of_points,
                                     stripes_of_scan, triangulation)

__all__ = ["GrayDecoder", "GraySequence", "Scan", "StripeReference", "StripeScan", "StripeScanner", "Triangulation",
           "load_ply", "load_stripes", "save_ply", "scan", "stripes_of_points", "stripes_of_scan", "triangulation"]


def _of_depth(scan):
    spacing = _pictures.spacing_of_points(scan.depth, scan.points())
    stripes = isinstance(scan, StripeScan)
    axes = "xy" if stripes or scan.triangulation.rows_are_x else "yx"
    return [_pictures.map_html(scan.depth, "depth z", spacing=spacing, axes=axes)] + (
        [_pictures.map_html(scan.difference, "towards the camera", signed=True, spacing=spacing)] if stripes else [])


for _kind in (Scan, StripeScan):
    _pictures.shows(_kind, _of_depth)
_pictures.shows(StripeReference, lambda stripes: [_pictures.image_html(stripes.pattern(2 * bit), f"pattern {2 * bit}")
                                                  for bit in range(stripes.bits)])
_pictures.shows(GraySequence, lambda sequence: [_pictures.image_html(sequence.image(2 * bit), f"pattern {2 * bit}")
                                                for bit in range(min(4, sequence.column_bits))])
