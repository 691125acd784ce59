"""selfproj for NumPy: the bit-exact model, packets, devices, light sections, structured light and calibration.

    import selfproj.model, selfproj.packets, selfproj.driver
    import selfproj.light_section, selfproj.structured_light, selfproj.calibration

Arrays are taken as they are, without a copy, and without a conversion: an array of another type is a TypeError, one of
another shape or a value out of range a ValueError. Long work runs without the GIL. Objects that keep state are for one
thread at a time, and say so.
"""

from . import calibration, driver, light_section, model, packets, structured_light
from ._core import SPEC_HASH, InputError, __version__, read_image

__all__ = ["InputError", "SPEC_HASH", "__version__", "calibration", "driver", "light_section", "model", "packets",
           "read_image", "structured_light"]
