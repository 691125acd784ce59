"""Measures the memory and time of every file reader, with the largest inputs that it accepts and with hostile ones."""
import itertools
import os
import re
import struct
import subprocess
import zlib

from materials import CALIBRATION, JPEG, bmp, chunk, tiff_directory
from programs import Outcome, Part

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


IMAGE = "selfproj-sim moments --engine model --channel grey --out o.csv {file}"
DEPTH = "selfproj depth --bits 2 --out o"
FLOATS = f"{DEPTH} --rig {{m}}/scanner.yaml {{seen}} --background {{file}}"
RIG = "selfproj rig {file}"
CALIBRATE = f"{DEPTH} {{frames}} --calibration {{file}}"
CLOUD = f"{DEPTH} --rig {{m}}/scanner.yaml {{seen}} --compare {{file}}"
INSPECT = "selfproj inspect --rig {m}/rig.yaml"
BOARD = "selfproj-sim board --record o.bin --count 10 --replay {file}"
SCENE = ("selfproj-sim scene render --mm-per-pixel 1 --rig {m}/rig.yaml --count 1 --out o --height-map {file}")


class Limits(Part):

    def __init__(self, attacker, made):
        super().__init__(attacker, made)
        self.measured = {}

    def run(self):
        """Runs all cases. Returns their figures by number."""
        usual, self.attacker.memory = self.attacker.memory, 8 << 30  # above every limit, to measure what is used
        try:
            with self.attacker.scratch() as self.folder:
                for kind in (self.images, self.texts, self.clouds_and_recordings):
                    for what, file, data, command in kind():
                        if data is not None:
                            (self.folder / file).write_bytes(data)
                        call = [word.replace("{file}", file) for word in self.words(command)]
                        self.attacker.case("limits", what, self.measure, what, call)
        finally:
            self.attacker.memory = usual
        return self.measured

    # Cases: what it is, its file, what is in the file (None: it is there), the command with {file}.

    def images(self):
        gibibyte = zeros(1024)
        size = f"{SIDE} x {SIDE}"
        yield "PNG, largest: 2^28 pixels", "largest.png", png(SIDE, SIDE, zeros_of_rows(SIDE, SIDE), 8), IMAGE
        yield ("PNG, largest: 2^28 pixels of four times 16 bits", "largest.png",
               png(SIDE, SIDE, zeros_of_rows(8 * SIDE, SIDE), 16, 6), IMAGE)
        yield "PNG of 64 x 16 pixels with 1 GiB of data, compressed", "bomb.png", png(64, 16, gibibyte), IMAGE
        for kind in (b"zTXt", b"iCCP"):
            yield (f"PNG with 1 GiB in {kind.decode()}, compressed", "bomb.png",
                   png(64, 16, zlib.compress(bytes(65 * 16)), more=chunk(kind, b"a\0\0" + gibibyte)), IMAGE)
        yield ("PNG that says 2^31 x 2^30 pixels, 1 kB", "declared.png",
               png((1 << 31) - 1, 1 << 30, gibibyte[:1000], 16, 6), IMAGE)
        yield (f"PNG that says {size} pixels of four times 16 bits, 1 kB", "declared.png",
               png(SIDE, SIDE, gibibyte[:1000], 16, 6), IMAGE)
        yield "JPEG that says 65500 x 65500 pixels, 0.5 kB", "declared.jpg", jpeg_of_size(65500, 65500), IMAGE
        yield f"JPEG that says {size} pixels, 0.5 kB", "declared.jpg", jpeg_of_size(SIDE, SIDE), IMAGE
        data = bytearray(bmp([bytes(64)] * 16))
        data[18:26] = struct.pack("<ii", SIDE, -SIDE)
        yield f"BMP that says {size} pixels, 2 kB", "declared.bmp", data, IMAGE
        yield (f"PGM that says {size} pixels, 0.1 kB", "declared.pgm", b"P5\n%d %d\n255\n" % (SIDE, SIDE) + bytes(100),
               IMAGE)
        for name, columns, rows, strip in (("2^30 x 2^30 pixels", 1 << 30, 1 << 30, 64),
                                           (f"{size} pixels in one strip", SIDE, SIDE, 0x7FFFFFF0)):
            yield (f"TIFF that says {name} of 32 bits, 0.2 kB", "declared.tiff", b"II*\0" + struct.pack("<I", 72) +
                   bytes(64) + tiff_directory(columns, rows, 32, strip), FLOATS)
        yield ("TIFF with 1 GiB of data, compressed", "bomb.tiff", b"II*\0" + struct.pack("<I", 8 + len(gibibyte)) +
               gibibyte + tiff_directory(SIDE, SIDE, 8, len(gibibyte), compression=8), IMAGE)
        large_float_tiff(self.folder / "largest.tiff")
        for command in (FLOATS, SCENE):
            yield "TIFF of 32-bit numbers, largest: 1 GiB", "largest.tiff", None, command

    def texts(self):
        rig = (self.made / "rig.yaml").read_bytes()
        yield "rig, largest: 1 MiB", "largest.yaml", rig + b"#\n" * ((MIB - 2000) // 2), RIG
        yield "rig that never ends: /dev/zero", "/dev/zero", None, RIG
        for name, text in (("brackets, 1 MB deep", "[" * 1000000), ("maps, 1,000 deep", "".join(
                " " * i + "a:\n" for i in range(1000))), ("aliases of aliases", "a: &a [x]\n" + "".join(
                    f"b{i}: &b{i} [*{'b%d' % (i - 1) if i else 'a'}]\n" for i in range(30)))):
            yield f"rig of {name}", "deep.yaml", text.encode(), RIG
        yield ("calibration, largest: 1 MiB", "largest.yaml", CALIBRATION.encode() + b"#\n" * ((MIB - 2000) // 2),
               CALIBRATE)
        for name, text in (("JSON, 100,000 deep", '{"a":' * 100000),
                           ("XML, 300,000 deep", '<?xml version="1.0"?>' + "<a>" * 300000)):
            yield f"calibration of {name}", "deep.yaml", text.encode(), CALIBRATE
        rows = b"".join(b"%.3f,1167\n" % (i * 1e-4 - 500) for i in range(10000000))
        yield (f"table of heights, {len(rows) // MIB} MiB", "largest.csv", b"y_mm,z_mm\n" + rows,
               "selfproj pattern --rig {m}/rig.yaml --out o --reference {file}")
        yield ("table that never ends: /dev/zero", "/dev/zero", None,
               f"{INSPECT} --device file:{{m}}/packets.bin --reference {{file}}")

    def clouds_and_recordings(self):
        point = struct.pack("<fff", 1, 2, 500)
        count = (256 * MIB - 200) // len(point)
        yield ("cloud, largest: 256 MiB", "largest.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n"
               b"property float x\nproperty float y\nproperty float z\nend_header\n" % count + point * count, CLOUD)
        yield "cloud that never ends: /dev/zero", "/dev/zero", None, CLOUD
        recording = (self.made / "packets.bin").read_bytes()
        yield ("recording of 512 MiB", "large.bin", recording * (512 * MIB // len(recording)),
               f"{INSPECT} --device file:{{file}}")
        yield "recording of 512 MiB", "large.bin", None, BOARD
        yield "recording that never ends: /dev/zero", "/dev/zero", None, BOARD

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
        self.attacker.check_rules(Outcome(process.returncode, "", said, False), command, self.folder)


def reader_of(command):
    """The command and the option that reads the file."""
    words = [str(word) for word in command]
    name = list(itertools.takewhile(lambda word: re.fullmatch(r"[a-z-]+", word) and word[0] != "-", words))
    return " ".join(name + [word for word in words[-2:-1] if word.startswith("--")])
