"""Structured light: patterns, the decoder at full speed, depth images, clouds.

    scan = selfproj.structured_light.scan(["captures"], rig="scanner", bits=8, median=True)
    selfproj.structured_light.save_ply("cloud.ply", scan.points())
"""

from ._core.structured_light import (GrayDecoder, GraySequence, Scan, Triangulation, load_ply, save_ply, scan,
                                     triangulation)

__all__ = ["GrayDecoder", "GraySequence", "Scan", "Triangulation", "load_ply", "save_ply", "scan", "triangulation"]
