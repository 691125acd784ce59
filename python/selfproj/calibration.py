"""Calibration of camera and projector from captures of a chessboard under Gray codes; of a camera and its laser from
plain images (docs/calibration.md).

    poses = [selfproj.calibration.decode_capture(images, projector=(1024, 768)) for images in captures]
    result = selfproj.calibration.calibrate(poses, corners=(9, 7), square_mm=21, projector=(1024, 768))

    camera = selfproj.calibration.calibrate_camera(boards, corners=(9, 7), square_mm=21)
    rig = selfproj.calibration.laser_plane(camera, lines).rig(drawn)
    belt = selfproj.calibration.calibrate_belt(rig, belt_images, corners=(9, 7), square_mm=21, counts=counts)
"""

from . import pictures as _pictures
from ._core.calibration import (BeltResult, Calibration, CameraResult, Capture, LaserPlane, Result, calibrate,
                                calibrate_belt, calibrate_camera, decode_capture, find_chessboard, laser_plane,
                                read_calibration)

__all__ = ["BeltResult", "Calibration", "CameraResult", "Capture", "LaserPlane", "Result", "calibrate",
           "calibrate_belt", "calibrate_camera", "decode_capture", "find_chessboard", "laser_plane", "read_calibration"]

_pictures.shows(Result, lambda result: [_pictures.text_html(str(result))])
_pictures.shows(CameraResult, lambda camera: [_pictures.text_html("\n".join(f"{name}: {reason}" for name, reason in
                                                                            camera.left_out))])
_pictures.shows(BeltResult, lambda belt: [_pictures.table_html([{"place": place, "along_mm": along} for place, along in
                                                                enumerate(belt.along_mm, 1)]),
                                          _pictures.table_html(belt.heights)])
_pictures.shows(Capture, lambda capture: [_pictures.image_html(capture.mean, "mean of all images")])
