"""Measures the memory and time of every file reader, with the largest inputs that it accepts and with hostile ones."""
import itertools
import os
import re
import struct
import subprocess
import zlib

from materials import CALIBRATION, JPEG, bmp, chunk, tiff_directory
from programs import Outcome

SIDE = 16384  # an image of SIDE x SIDE pixels is the largest
MIB = 1 << 20


def zeros(mib):
    """Returns this many MiB of zeros, compressed."""
    compress = zlib.compressobj(9)
    return b"".join(compress.compress(bytes(MIB)) for _ in range(mib)) + compress.flush()


def zeros_of_rows(size, rows):
    """Returns black rows of `size` bytes of a PNG, each with its filter byte, compressed."""
    compress = zlib.compressobj(9)
    return b"".join(compress.compress(bytes(1 + size)) for _ in range(rows)) + compress.flush()


def png(columns, rows, data, depth=8, kind=0, more=b""):
    header = struct.pack(">IIBBBBB", columns, rows, depth, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + more + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def jpeg_of_size(columns, rows):
    at = JPEG.index(b"\xff\xc0") + 5
    return JPEG[:at] + struct.pack(">HH", rows, columns) + JPEG[at + 4:]


def large_float_tiff(path):
    """Writes a TIFF as large as an image file may be. Its pixels are a hole in the file, so it takes no disk space."""
    rows = SIDE - 1
    size = SIDE * rows * 4
    with open(path, "wb") as file:
        file.write(b"II*\0" + struct.pack("<I", 8 + size))
        file.seek(8 + size)
        file.write(tiff_directory(SIDE, rows, 32, size))


class Limits:

    def __init__(self, attacker, made):
        self.attacker = attacker
        self.made = made
        self.measured = {}

    def run(self):
        """Runs all cases. Returns their figures by number."""
        usual, self.attacker.memory = self.attacker.memory, 8 << 30  # above every limit, to measure what is used
        try:
            with self.attacker.scratch() as self.folder:
                self.images()
                self.texts()
                self.clouds_and_recordings()
        finally:
            self.attacker.memory = usual
        return self.measured

    def images(self):
        m = self.made
        gibibyte = zeros(1024)
        image = ["selfproj-sim", "moments", "--engine", "model", "--channel", "grey", "--out", "o.csv"]
        seen = sorted((m / "seen").iterdir())[:4]
        floats = ["selfproj", "depth", "--rig", m / "scanner.yaml", "--bits", "2", "--out", "o", *seen, "--background"]
        size = f"{SIDE} x {SIDE}"

        self.file("largest.png", png(SIDE, SIDE, zeros_of_rows(SIDE, SIDE), 8))
        self.one("PNG, largest: 2^28 pixels", image + ["largest.png"])
        self.file("largest.png", png(SIDE, SIDE, zeros_of_rows(8 * SIDE, SIDE), 16, 6))
        self.one("PNG, largest: 2^28 pixels of four times 16 bits", image + ["largest.png"])
        self.file("bomb.png", png(64, 16, gibibyte))
        self.one("PNG of 64 x 16 pixels with 1 GiB of data, compressed", image + ["bomb.png"])
        for kind in (b"zTXt", b"iCCP"):
            self.file("bomb.png", png(64, 16, zlib.compress(bytes(65 * 16)), more=chunk(kind, b"a\0\0" + gibibyte)))
            self.one(f"PNG with 1 GiB in {kind.decode()}, compressed", image + ["bomb.png"])
        self.file("declared.png", png((1 << 31) - 1, 1 << 30, gibibyte[:1000], 16, 6))
        self.one("PNG that says 2^31 x 2^30 pixels, 1 kB", image + ["declared.png"])
        self.file("declared.png", png(SIDE, SIDE, gibibyte[:1000], 16, 6))
        self.one(f"PNG that says {size} pixels of four times 16 bits, 1 kB", image + ["declared.png"])
        self.file("declared.jpg", jpeg_of_size(65500, 65500))
        self.one("JPEG that says 65500 x 65500 pixels, 0.5 kB", image + ["declared.jpg"])
        self.file("declared.jpg", jpeg_of_size(SIDE, SIDE))
        self.one(f"JPEG that says {size} pixels, 0.5 kB", image + ["declared.jpg"])
        data = bytearray(bmp([bytes(64)] * 16))
        data[18:26] = struct.pack("<ii", SIDE, -SIDE)
        self.file("declared.bmp", data)
        self.one(f"BMP that says {size} pixels, 2 kB", image + ["declared.bmp"])
        self.file("declared.pgm", b"P5\n%d %d\n255\n" % (SIDE, SIDE) + bytes(100))
        self.one(f"PGM that says {size} pixels, 0.1 kB", image + ["declared.pgm"])
        for name, columns, rows, strip in (("2^30 x 2^30 pixels", 1 << 30, 1 << 30, 64),
                                           (f"{size} pixels in one strip", SIDE, SIDE, 0x7FFFFFF0)):
            self.file("declared.tiff", b"II*\0" + struct.pack("<I", 72) + bytes(64) +
                      tiff_directory(columns, rows, 32, strip))
            self.one(f"TIFF that says {name} of 32 bits, 0.2 kB", floats + ["declared.tiff"])
        self.file("bomb.tiff", b"II*\0" + struct.pack("<I", 8 + len(gibibyte)) + gibibyte +
                  tiff_directory(SIDE, SIDE, 8, len(gibibyte), compression=8))
        self.one("TIFF with 1 GiB of data, compressed", image + ["bomb.tiff"])
        large_float_tiff(self.folder / "largest.tiff")
        self.one("TIFF of 32-bit numbers, largest: 1 GiB", floats + ["largest.tiff"])
        self.one("TIFF of 32-bit numbers, largest: 1 GiB",
                 ["selfproj-sim", "scene", "render", "--mm-per-pixel", "1", "--rig", m / "rig.yaml", "--count", "1",
                  "--out", "o", "--height-map", "largest.tiff"])

    def texts(self):
        m = self.made
        frames = [m / f"frame_{i}.png" for i in range(1, 5)]
        rig = ["selfproj", "rig"]
        depth = ["selfproj", "depth", "--bits", "2", "--out", "o", *frames]
        inspect = ["selfproj", "inspect", "--rig", m / "rig.yaml"]
        self.file("largest.yaml", (m / "rig.yaml").read_bytes() + b"#\n" * ((MIB - 2000) // 2))
        self.one("rig, largest: 1 MiB", rig + ["largest.yaml"])
        self.one("rig that never ends: /dev/zero", rig + ["/dev/zero"])
        for name, text in (("brackets, 1 MB deep", "[" * 1000000), ("maps, 1,000 deep", "".join(
                " " * i + "a:\n" for i in range(1000))), ("aliases of aliases", "a: &a [x]\n" + "".join(
                    f"b{i}: &b{i} [*{'b%d' % (i - 1) if i else 'a'}]\n" for i in range(30)))):
            self.file("deep.yaml", text.encode())
            self.one(f"rig of {name}", rig + ["deep.yaml"])
        self.file("largest.yaml", CALIBRATION.encode() + b"#\n" * ((MIB - 2000) // 2))
        self.one("calibration, largest: 1 MiB", depth + ["--calibration", "largest.yaml"])
        for name, text in (("JSON, 100,000 deep", '{"a":' * 100000),
                           ("XML, 300,000 deep", '<?xml version="1.0"?>' + "<a>" * 300000)):
            self.file("deep.yaml", text.encode())
            self.one(f"calibration of {name}", depth + ["--calibration", "deep.yaml"])

        rows = b"".join(b"%.3f,1167\n" % (i * 1e-4 - 500) for i in range(10000000))
        self.file("largest.csv", b"y_mm,z_mm\n" + rows)
        self.one(f"table of heights, {len(rows) // MIB} MiB", ["selfproj", "pattern", "--rig", m / "rig.yaml",
                                                              "--out", "o", "--reference", "largest.csv"])
        self.one("table that never ends: /dev/zero",
                 inspect + ["--device", f"file:{m}/packets.bin", "--reference", "/dev/zero"])

    def clouds_and_recordings(self):
        m = self.made
        seen = sorted((m / "seen").iterdir())[:4]
        compare = ["selfproj", "depth", "--rig", m / "scanner.yaml", "--bits", "2", "--out", "o", *seen,
                   "--compare"]
        point = struct.pack("<fff", 1, 2, 500)
        count = (256 * MIB - 200) // len(point)
        self.file("largest.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\n"
                  b"property float y\nproperty float z\nend_header\n" % count + point * count)
        self.one("cloud, largest: 256 MiB", compare + ["largest.ply"])
        self.one("cloud that never ends: /dev/zero", compare + ["/dev/zero"])

        recording = (m / "packets.bin").read_bytes()
        self.file("large.bin", recording * (512 * MIB // len(recording)))
        board = ["selfproj-sim", "board", "--record", "o.bin", "--count", "10", "--replay"]
        self.one("recording of 512 MiB",
                 ["selfproj", "inspect", "--rig", m / "rig.yaml", "--device", "file:large.bin"])
        self.one("recording of 512 MiB", board + ["large.bin"])
        self.one("recording that never ends: /dev/zero", board + ["/dev/zero"])

    def file(self, name, data):
        (self.folder / name).write_bytes(data)

    def one(self, what, command):
        self.attacker.case("limits", what, self.measure, what, command)

    def measure(self, what, command):
        key = f"{len(self.measured) + 1:02}"
        process = self.attacker.start(command, self.folder, stdout=subprocess.DEVNULL)
        said = process.stderr.read().decode(errors="replace")
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.measured[key] = {
            "what": what,
            "command": reader_of(command),
            "status": process.returncode,
            "mib": round(usage.ru_maxrss / 1024),
            "cpu_s": round(usage.ru_utime + usage.ru_stime, 2)
        }
        print(f"{what}: {self.measured[key]}: {said.strip()}", flush=True)
        self.attacker.judge(Outcome(process.returncode, "", said, False), command, self.folder)


def reader_of(command):
    """The command and the option that reads the file."""
    words = [str(word) for word in command]
    name = list(itertools.takewhile(lambda word: re.fullmatch(r"[a-z-]+", word) and word[0] != "-", words))
    return " ".join(name + [word for word in words[-2:-1] if word.startswith("--")])
