"""Reads the 32-bit floating-point TIFF files that the programs write: one strip after another, not compressed."""

import array
import pathlib
import struct
import sys

SIZES = {1: 1, 2: 1, 3: 2, 4: 4}
FORMATS = {1: "B", 3: "H", 4: "I"}


def read(path):
    """Rows of numbers."""
    data = pathlib.Path(path).read_bytes()
    if data[:4] != b"II*\0":
        raise ValueError(f"{path}: no little-endian TIFF")
    at, = struct.unpack_from("<I", data, 4)
    count, = struct.unpack_from("<H", data, at)
    tags = {}
    for entry in range(count):
        tag, kind, number = struct.unpack_from("<HHI", data, at + 2 + 12 * entry)
        if kind in FORMATS:
            size = SIZES[kind] * number
            place = at + 10 + 12 * entry
            if size > 4:
                place, = struct.unpack_from("<I", data, place)
            tags[tag] = struct.unpack_from(f"<{number}{FORMATS[kind]}", data, place)
    width, height = tags[256][0], tags[257][0]
    if tags[258] != (32,) or tags.get(259, (1,)) != (1,) or tags.get(339) != (3,):
        raise ValueError(f"{path}: not an uncompressed image of 32-bit floats")
    values = array.array("f")
    for begin, size in zip(tags[273], tags[279]):
        values.frombytes(data[begin:begin + size])
    if sys.byteorder == "big":
        values.byteswap()
    return [values[row * width:(row + 1) * width] for row in range(height)]
