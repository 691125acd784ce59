"""Calibration of camera and projector from captures of a chessboard under Gray codes (docs/calibration.md).

    poses = [selfproj.calibration.decode_capture([folder], projector=(1024, 768)) for folder in folders]
    result = selfproj.calibration.calibrate(poses, corners=(9, 7), square_mm=21, projector=(1024, 768))
"""

from ._core.calibration import (Calibration, Capture, Result, calibrate, decode_capture, find_chessboard,
                                read_calibration)

__all__ = ["Calibration", "Capture", "Result", "calibrate", "decode_capture", "find_chessboard", "read_calibration"]
