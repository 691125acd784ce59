#!/usr/bin/env python3
"""Makes a picture small enough for a document: each K x K pixels become one.

    shrink_picture.py K FROM.png TO.png

FROM.png has 8 bits and three channels, as the programs write their pictures. docs/images/marks.png is made of
difference.png of the demonstration:

    scripts/demo.sh && scripts/shrink_picture.py 2 build/demo/stairs-marked/difference.png docs/images/marks.png
"""

import pathlib
import struct
import sys
import zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = 3


def predict(kind, left, up, corner):
    """Returns the value that a PNG filter predicts."""
    if kind == 4:
        base = left + up - corner
        return min((left, up, corner), key=lambda value: abs(base - value))
    return (0, left, up, (left + up) // 2)[kind]


def read(data):
    """(width, rows of bytes) of a picture; raises ValueError."""
    if not data.startswith(SIGNATURE):
        raise ValueError("is not a PNG file")
    at, packed, width, height = len(SIGNATURE), b"", 0, 0
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            if (depth, colour, interlaced) != (8, 2, 0):
                raise ValueError("has not 8 bits and three channels")
        elif kind == b"IDAT":
            packed += body
        at += size + 12
    raw, stride = zlib.decompress(packed), width * CHANNELS
    rows, above = [], bytes(stride)
    for number in range(height):
        kind, *line = raw[number * (stride + 1):(number + 1) * (stride + 1)]
        if kind != 0:
            for i in range(stride):
                left, corner = (line[i - CHANNELS], above[i - CHANNELS]) if i >= CHANNELS else (0, 0)
                line[i] = (line[i] + predict(kind, left, above[i], corner)) & 255
        above = bytes(line)
        rows.append(above)
    return width, rows


def shrunk(width, rows, k):
    """Returns the mean of each k x k pixels. Pixels left over at the right and at the bottom are cut off."""
    out = []
    for top in range(0, len(rows) - k + 1, k):
        line = bytearray()
        for left in range(0, width - k + 1, k):
            for channel in range(CHANNELS):
                total = sum(row[(left + i) * CHANNELS + channel] for row in rows[top:top + k] for i in range(k))
                line.append((2 * total + k * k) // (2 * k * k))
        out.append(bytes(line))
    return width // k, out


def write(width, rows):
    """A PNG file; each line gets the filter whose differences are the smallest."""
    raw, above = bytearray(), bytes(width * CHANNELS)
    for row in rows:
        lines = []
        for kind in range(5):
            line = bytes((value - predict(kind, row[i - CHANNELS] if i >= CHANNELS else 0, above[i],
                                          above[i - CHANNELS] if i >= CHANNELS else 0)) & 255
                         for i, value in enumerate(row))
            lines.append((sum(min(value, 256 - value) for value in line), kind, line))
        _, kind, line = min(lines)
        raw += bytes([kind]) + line
        above = row

    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    header = struct.pack(">IIBBBBB", width, len(rows), 8, 2, 0, 0, 0)
    return SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(raw), 9)) + chunk(b"IEND", b"")


def main():
    if len(sys.argv) != 4 or not sys.argv[1].isdigit() or int(sys.argv[1]) < 1:
        print("usage: shrink_picture.py K FROM.png TO.png", file=sys.stderr)
        return 2
    try:
        width, rows = read(pathlib.Path(sys.argv[2]).read_bytes())
        pathlib.Path(sys.argv[3]).write_bytes(write(*shrunk(width, rows, int(sys.argv[1]))))
    except (OSError, ValueError, zlib.error, struct.error) as error:
        print(f"shrink_picture.py: {sys.argv[2]}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
