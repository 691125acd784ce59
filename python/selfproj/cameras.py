"""Cameras of this machine and its network (docs/driver.md#a-camera-without-a-board).

    with selfproj.cameras.open("camera:192.168.1.20?exposure-us=500") as camera:
        camera.start()
        image = camera.next(timeout=1.0)       # image.pixels: uint8, (rows, columns)
"""

from . import pictures as _pictures
from ._core.cameras import Camera, CameraImage, list, open  # pylint: disable=redefined-builtin

__all__ = ["Camera", "CameraImage", "list", "open"]

_pictures.shows(CameraImage, lambda image: [_pictures.image_html(image.pixels, f"image {image.number}")])
