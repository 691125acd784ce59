"""Light sections: moments at the speed of memory, rigs, profiles, height maps.

    rig = selfproj.light_section.load_rig("light-section")
    profiler = selfproj.light_section.Profiler(rig)
    height = rig.plane_z_mm - profiler.profile(packet).z
"""

from ._core.light_section import (Inspection, Profile, Profiler, Rig, Validity, load_rig, load_tiff, moments, save_tiff)

__all__ = ["Inspection", "Profile", "Profiler", "Rig", "Validity", "load_rig", "load_tiff", "moments", "save_tiff"]
