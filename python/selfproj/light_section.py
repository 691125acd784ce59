"""Light sections: moments at the speed of memory, rigs, references and their patterns, profiles, height maps.

    rig = selfproj.light_section.load_rig("light-section")
    profiler = selfproj.light_section.Profiler(rig)
    height = rig.plane_z_mm - profiler.profile(packet).z

    reference = selfproj.light_section.reference_of_heights(rig, heights)      # or reference_of_sweep(rig, images)
    pattern = selfproj.light_section.pattern_of_reference(rig, reference)
"""

import numpy

from . import pictures as _pictures
from ._core.light_section import (HeightFit, Inspection, Profile, Profiler, Reference, Rig, Validity, fit_heights,
                                  load_reference, load_rig, load_tiff, moments, pattern_of_line, pattern_of_reference,
                                  reference_of_heights, reference_of_plane, reference_of_sweep, save_tiff, sweep_lines,
                                  without_residual)

__all__ = ["HeightFit", "Inspection", "Profile", "Profiler", "Reference", "Rig", "Validity", "fit_heights",
           "load_reference", "load_rig", "load_tiff", "moments", "pattern_of_line", "pattern_of_reference",
           "reference_of_heights", "reference_of_plane", "reference_of_sweep", "save_tiff", "sweep_lines",
           "without_residual"]


def _of_profile(profile):
    if profile.z.ndim == 2:
        steps = abs(numpy.diff(profile.y, axis=1))
        column_mm = float(numpy.nanmedian(steps)) if numpy.isfinite(steps).any() else 1.0
        return [_pictures.map_html(profile.z, "z by frame (down) and column", spacing=(0.0, column_mm))]
    return [_pictures.curve_html(profile.y, profile.z, "y (mm)", "z (mm)")]


_pictures.shows(Profile, _of_profile)
_pictures.shows(Reference, lambda reference: [_pictures.curve_html(range(1, len(reference) + 1), reference.z,
                                                                   "column", "z (mm)")])
_pictures.shows(Inspection, lambda inspection: [_pictures.map_html(inspection.height(), "height by frame and column",
                                                                   spacing=inspection.spacing_mm)]
                if len(inspection) else [])
_pictures.shows(HeightFit, lambda fit: [_pictures.table_html(fit.levels)])
_pictures.shows(Rig, lambda rig: [_pictures.text_html(rig.to_yaml())])
