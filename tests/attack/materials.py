"""Small good files of every kind that the programs read, made by the programs themselves if possible."""
import base64
import math
import pathlib
import re
import struct
import zlib

import screen

# A line of light of 64 x 16 pixels, written by libjpeg with restart markers.
JPEG = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAoHBwgHBgoICAgLCgoLDhgQDg0NDh0VFhEYIx8lJCIfIiEmKzcvJik0KSEiMEExNDk7Pj4+JS5ESU"
    "M8SDc9Pjv/wAALCAAQAEABAREA/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUFBAQAAAF9AQIDAAQRBRIh"
    "MUEGE1FhByJxFDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqDhI"
    "WGh4iJipKTlJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi4+Tl5ufo6erx8vP09fb3+Pn6/90ABAAC/9oACAEB"
    "AAA/APK7zTL2wkMdzbvGw9RVWv/Q8hqza6dd3sgS3geRj/dFf//R5fTfhpfyxifUpo7KLr+8bBrTHhjwXZDZdav5jjrsr//Sym8J+D78bbLWRG"
    "56b6yNU+G2qWiGayZLyHruiOa//9PBs/iPDeRiDXtOiul6F9uGq1s+H+pfPultWPVa/9TL8n4faf8AOZJbkj+Gq118RbSwjMOg6ZFbjoJCMtX/"
    "1fNdS8R6rqshe6u5Gz2zxWYWZjksTX//1vIldlOVYj8a19L8VavpDhra7cAfwk5Ff//Z")

# A segment that says: to be turned by 90 degrees (orientation 6).
EXIF_TURNED = b"\xff\xe1\0\x22Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"


WORLD = pathlib.Path(__file__).resolve().parents[2] / "sim" / "scene" / "world.yaml"

# How a light section is cut into parts.
PARTS = """parts:
  cut: profile
  belt: clock
  grid_mm: 0.25
  above_mm: 0.4
  min_width_mm: 1
  gap_mm: 1
  pause_ms: 5
  min_length_mm: 2
  length_mm: 12
"""


def line_rows(columns=64, rows=16, shift=0.0):
    """A line of light, row by row."""
    image = []
    for r in range(rows):
        image.append(
            bytes(
                int(10 + 200 * math.exp(-(((r - rows / 2 - rows / 4 * math.sin(0.1 * c + shift)) / 1.5)**2) / 2))
                for c in range(columns)))
    return image


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(rows):
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 0, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def png_is_whole(data):
    """Returns whether all chunks up to IEND are right."""
    at = 8
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        return False
    while at + 12 <= len(data):
        size = struct.unpack(">I", data[at:at + 4])[0]
        if at + 12 + size > len(data):
            return False
        if struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0] != zlib.crc32(data[at + 4:at + 8 + size]):
            return False
        if data[at + 4:at + 8] == b"IEND":
            return True
        at += 12 + size
    return False


def pgm(rows):
    return b"P5\n%d %d\n255\n" % (len(rows[0]), len(rows)) + b"".join(rows)


def bmp(rows):
    width, height = len(rows[0]), len(rows)
    palette = b"".join(bytes((i, i, i, 0)) for i in range(256))
    pixels = b"".join(row + b"\0" * (-width % 4) for row in reversed(rows))
    head = struct.pack("<IiiHHIIiiII", 40, width, height, 1, 8, 0, len(pixels), 2835, 2835, 256, 256)
    start = 14 + len(head) + len(palette)
    return b"BM" + struct.pack("<IHHI", start + len(pixels), 0, 0, start) + head + palette + pixels


def tiff_directory(columns, rows, bits, strip, orientation=1, compression=1):
    """The directory of a TIFF of one strip of so many bytes, which begins at byte 8. 32 bits are floating-point
    numbers."""
    tags = [(256, 4, columns), (257, 4, rows), (258, 3, bits), (259, 3, compression), (262, 3, 1), (273, 4, 8),
            (274, 3, orientation), (277, 3, 1), (278, 4, rows), (279, 4, strip), (284, 3, 1),
            (339, 3, 3 if bits == 32 else 1)]
    return struct.pack("<H", len(tags)) + b"".join(
        struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in tags) + struct.pack("<I", 0)


def tiff(rows, floats=False, orientation=1):
    """One uncompressed strip; `floats` are rows of numbers."""
    width, height = len(rows[0]), len(rows)
    data = b"".join(struct.pack(f"<{width}f", *row) if floats else row for row in rows)
    directory = tiff_directory(width, height, 32 if floats else 8, len(data), orientation)
    return b"II*\0" + struct.pack("<I", 8 + len(data)) + data + directory


CALIBRATION = """%YAML:1.0
---
cam_K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 80., 0., 31.5, 0., 80., 7.5, 0., 0., 1. ]
cam_kc: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 0.01, 0., 0., 0., 0. ]
pro_K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 80., 0., 8., 0., 80., 8., 0., 0., 1. ]
pro_kc: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -100., 0., 0. ]
"""

# Of the rigs: small cameras, and a small projector of the scanner.
SMALL = {"rows": "16", "columns": "64", "max_lit_px": "16"}
SMALL_SCANNER = {
    "rows": "32",
    "columns": "32",
    "columns2": "32",
    "lines": "32",
    "max_lit_px": "32",
    "pixel_pitch_um": "160",
    "line_pitch_um": "1015",
    "column_pitch_um": "1354",
    "max_z_per_line_mm": "100"
}


def with_values(rig, values):
    """Replaces the first key of each name (the camera's, if the projector has it, too), then all others of that
    name."""
    lines = []
    seen = set()
    for line in rig.splitlines():
        key = line.strip().split(":")[0]
        value = values.get(key) if key not in seen else values.get(key + "2")
        seen.add(key)
        lines.append(line.split(":")[0] + ": " + value if value else line)
    return "\n".join(lines) + "\n"


def quarter(rig):
    """The rig with a quarter of the rows and columns, and pixels four times as large."""
    lines = []
    for line in rig.splitlines():
        key, _, value = line.strip().partition(": ")
        if line.startswith("  ") and key in ("rows", "columns", "lines"):
            line = f"  {key}: {int(value) // 4}"
        elif line.startswith("  ") and key in ("pixel_pitch_um", "line_pitch_um", "column_pitch_um"):
            line = f"  {key}: {float(value) * 4}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def values_of(rig):
    """The numbers of a rig by section.key."""
    values, section = {}, ""
    for line in rig.splitlines():
        key, _, value = line.strip().partition(": ")
        if not line.startswith(" "):
            section = key.rstrip(":")
        elif re.fullmatch(r"[-\d.e]+", value):
            values[f"{section}.{key}"] = float(value)
        if line.startswith("plane_z_mm"):
            values["plane_z_mm"] = float(value)
    return values


def sweep(rig, every, height):
    """Names and images of a plate at this height under the lines of a light section's sweep."""
    value = values_of(rig)
    rows, columns = int(value["camera.rows"]), int(value["camera.columns"])
    z = value["plane_z_mm"] - height
    for line in range(every, int(value["projector.lines"]) - 2, every):
        place = value["projector.center_xp_mm"] + value["projector.line_pitch_um"] / 1000 * (
            line - (value["projector.lines"] - 1) / 2)
        theta = math.tan(
            math.radians(value["projector.tilt_deg"]) + math.atan(place / value["projector.focal_length_mm"]))
        alpha = (value["projector.x_mm"] - (z - value["projector.z_mm"]) * theta) / z
        row = (rows - 1) / 2 + alpha * value["camera.focal_length_mm"] * 1000 / value["camera.pixel_pitch_um"]
        yield f"line_{line}.png", png(
            [bytes([int(220 * math.exp(-(r - row)**2 / 5))]) * columns for r in range(rows)])


def blocks(count, cell):
    """The heights of so many parts on a belt, which lie a little beside each other, in cells of `cell` mm."""
    length, width, gap = round(5 / cell), round(8 / cell), round(3 / cell)
    rows = []
    for part in range(count):
        first = width + part % 3
        rows += [[0.0] * 3 * width] * gap
        rows += [[0.8 if first <= c < first + width else 0.0 for c in range(3 * width)]] * length
    return rows + [[0.0] * 3 * width] * gap


def registers(version, spec_hash):
    """The registers of a board that can do 2048 x 1023 pixels, grey moments and raw images, as a file."""
    capability = 2048 | 1023 << 12 | 3 << 22
    return struct.pack("<4sIII", b"SLFP", version, spec_hash, capability) + bytes(4096 - 16)


def make_parts(folder, run):
    """Packets of parts with edges, a rig that cuts them, the tolerance that they teach, and the table of a circuit."""
    rig = re.sub(r"frame_rate_hz: \d+", "frame_rate_hz: 5000", (folder / "rig.yaml").read_text())
    (folder / "parts.yaml").write_text(rig + PARTS)
    (folder / "blocks.tiff").write_bytes(tiff(blocks(6, 0.25), floats=True))
    run("selfproj-sim scene render --height-map blocks.tiff --mm-per-pixel 0.25 --rig parts.yaml --out passing")
    run("selfproj-sim cosim --engine model --frames passing/frame_*.png --rig parts.yaml --packets parts.bin")
    run("selfproj tolerance learn --device file:parts.bin --rig parts.yaml --out tolerance.yaml")
    (folder / "judged.yaml").write_text((folder / "parts.yaml").read_text().replace("belt: clock", "belt: encoder"))
    run("selfproj verdict table --rig judged.yaml --tolerance tolerance.yaml --play-across 0.05 --play-along 0.1 "
        "--start 0 --pitch 1000 --out verdict.yaml")
    (folder / "world.yaml").write_text(WORLD.read_text())
    (folder / "gamma.csv").write_text("grey,light\n0,3\n128,60\n255,250\n")


def make(attacker, folder, short):
    """Fills `folder`; its files are never changed afterwards. `short`: without those of long runs only."""
    folder = pathlib.Path(folder)

    def run(command):
        outcome = attacker.run(command.split(), folder)
        if outcome.status != 0:
            raise SystemExit(f"attack: cannot make its materials: {command}: {outcome.err}")
        return outcome.out

    frames = [line_rows(shift=0.2 * i) for i in range(4)]
    for i, frame in enumerate(frames):
        (folder / f"frame_{i + 1}.png").write_bytes(png(frame))
        (folder / f"grey_{i + 1}.pgm").write_bytes(pgm(frame))
    (folder / "a.jpg").write_bytes(JPEG)
    (folder / "a.bmp").write_bytes(bmp(frames[0]))
    (folder / "a.tiff").write_bytes(tiff(frames[0]))
    (folder / "heights.tiff").write_bytes(tiff([[5 + 0.1 * c for c in range(64)]] * 3, floats=True))
    (folder / "curve.csv").write_text("y_mm,z_mm\n-200,1167\n-2,1166\n2,1166\n200,1167\n")
    (folder / "calibration.yaml").write_text(CALIBRATION)
    (folder / "rig.yaml").write_text(with_values(run("selfproj rig light-section"), SMALL))
    (folder / "quarter.yaml").write_text(quarter(run("selfproj rig scanner")))
    (folder / "scanner.yaml").write_text(with_values(run("selfproj rig scanner"), SMALL_SCANNER))
    run("selfproj-sim board --line 64x16 --line-frames 20 --record packets.bin")
    version = re.search(r"specification (\d+)\.(\d+), hash 0x(\w+)", run("selfproj --version"))
    (folder / "bar.bin").write_bytes(
        registers(int(version[1]) << 8 | int(version[2]), int(version[3], 16)))
    make_parts(folder, run)
    run("selfproj pattern --rig rig.yaml --reference curve.csv --out reference")
    run("selfproj inspect --device file:packets.bin --rig rig.yaml --out inspection")
    run("selfproj pattern gray --rig scanner.yaml --out gray")
    run(f"selfproj pattern gray --projector {screen.COLUMNS}x{screen.ROWS} --out shown")
    run("selfproj-sim capture --rig scanner.yaml --patterns gray --scene desk --out seen")
    run("selfproj-sim cosim --engine model --scene fist --rig scanner.yaml --bits 2 --count 6 --packets codes.bin")
    run("selfproj pattern stripes --rig scanner.yaml --scan seen --gray-code --bits 2 --out stripes")
    run("selfproj pattern gray --rig quarter.yaml --out quarter")
    (folder / "white").mkdir()
    (folder / "white" / "pattern.png").write_bytes((folder / "quarter" / "pattern_32.png").read_bytes())
    for patterns, poses, out in (("quarter", 2, "chess"), ("white", 4, "views")):
        run(f"selfproj-sim capture --rig quarter.yaml --patterns {patterns} --chessboard 6x5 --square 30 "
            f"--poses {poses} --out {out}")
    plate = run("selfproj rig light-section").replace("  columns: 512\n", "  columns: 64\n", 1)
    (folder / "plate.yaml").write_text(plate)
    for height in (0, 10, 20):
        (folder / f"at{height}").mkdir()
        for name, image in sweep(plate, 16, height):
            (folder / f"at{height}" / name).write_bytes(image)
    if not short:  # rigs as the calibrations write them, which takes seconds
        run("selfproj calibrate --chessboard 6x5 --square 30 --projector 256x192 --rig quarter.yaml --out calibrated "
            "chess/pose_01 chess/pose_02")
        run("selfproj calibrate heights --rig plate.yaml --every 16 --heights 0,10,20 --out tied at0 at10 at20")
    return folder
