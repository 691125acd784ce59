"""selfproj for NumPy: the bit-exact model, packets, devices, cameras, light sections, structured light, parts and
calibration.

    import selfproj.model, selfproj.packets, selfproj.driver, selfproj.cameras
    import selfproj.light_section, selfproj.structured_light, selfproj.parts, selfproj.calibration, selfproj.pictures

Arrays are taken as they are, without a copy, and without a conversion: an array of another type is a TypeError, one of
another shape or a value out of range a ValueError. Where images are taken they may be an array, arrays or files. Long
work runs without the GIL. Objects that keep state are for one thread at a time, and say so.
"""

from importlib.metadata import version as _version

from . import calibration, cameras, driver, light_section, model, packets, parts, pictures, structured_light
from ._core import SPEC_HASH, InputError, read_image

__version__ = _version("selfproj")

__all__ = ["InputError", "SPEC_HASH", "__version__", "calibration", "cameras", "driver", "light_section", "model",
           "packets", "parts", "pictures", "read_image", "structured_light"]
