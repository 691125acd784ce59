"""Attacks with mutated and cut files of every kind that the programs read."""
import collections
import csv
import json
import math
import re
import shutil
import struct

import materials
from programs import Fault, Part

NUMBERS = [
    "nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e39", "-1", "0", "1e999", "010", "0x10",
    "99999999999999999999", "2147483648", "-2147483649", "1e6", "1e-9", "", "'", "1,5", "[", "{", "&a", "*a", "\0",
    "1e4", "16385"
]


def cut(random, data):
    return data[:random.randrange(len(data))]


def flip(random, data):
    data = bytearray(data)
    for _ in range(random.choice((1, 1, 1, 2, 8, 64))):
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)
    return bytes(data)


def overwrite(random, data):
    at = random.randrange(len(data))
    size = random.choice((1, 2, 4, 8, 64))
    return data[:at] + random.choice((b"\0", b"\xff", b"\x80", b"\x7f")) * size + data[at + size:]


def remove(random, data):
    at = random.randrange(len(data))
    return data[:at] + data[at + random.choice((1, 2, 4, 100)):]


def insert(random, data):
    at = random.randrange(len(data))
    start = random.randrange(len(data))
    return data[:at] + data[start:start + random.choice((1, 2, 4, 100, 3000))] + data[at:]


def number(random, data):
    """Returns the text with another number, or with another number in the text at its beginning."""
    found = list(re.finditer(rb"-?\d+(\.\d*)?(e[-+]?\d+)?", data[:20000]))
    if not found:
        return flip(random, data)
    which = random.choice(found)
    return data[:which.start()] + random.choice(NUMBERS).encode() + data[which.end():]


def line(random, data):
    lines = data.split(b"\n")
    at = random.randrange(len(lines))
    what = random.randrange(3)
    if what == 0:
        del lines[at]
    elif what == 1:
        lines.insert(at, lines[random.randrange(len(lines))])
    else:
        lines[at] = b"---" if random.randrange(2) else b" " * random.randrange(1, 9) + lines[at]
    return b"\n".join(lines)


BINARY = (cut, flip, overwrite, remove, insert)
TEXT = BINARY + (number,) * 4 + (line,) * 2


def finite(text, what):
    if re.search(r"(?i)(?<![a-z])-?(nan|inf)(?![a-z])", text):
        raise Fault(f"a number that is none in {what}")


def check_word(packet):
    """The check word of a whole packet, as docs/packet-reference.md says it."""
    check = 0xFFFFFFFF
    for at in range(0, len(packet), 16):
        words = list(struct.unpack_from("<4I", packet, at))
        if at + 16 == len(packet):
            words[3] = 0  # the check word itself
        check = (check << 1 ^ (0x04C11DB7 if check >> 31 else 0)) & 0xFFFFFFFF
        for i, word in enumerate(words):
            check ^= (word << 8 * i | word >> 32 - 8 * i) & 0xFFFFFFFF
    return check


def missed_pairs(columns):
    """The share of all pairs of bits of a packet of grey moments which, both flipped, leave its check word right. As it
    is linear, these are the pairs of bits that change it alike."""
    change = [1 << (bit + 8 * (bit // 32)) % 32 for bit in range(128)]
    bits = 8 * (64 + 8 * columns + 16)
    counts = collections.Counter(change[:96] + [1 << bit for bit in range(32)])  # the trailer
    for _ in range(bits // 128 - 1):
        change = [(word << 1 ^ (0x04C11DB7 if word >> 31 else 0)) & 0xFFFFFFFF for word in change]
        counts.update(change)
    return sum(n * (n - 1) for n in counts.values()) / (bits * (bits - 1))


def damaged_unseen(whole, data, size):
    """The numbers of the packets of `size` bytes in which at least two bits differ, although the check word agrees. The
    check word finds each single flipped bit, but not all pairs: docs/limits.md. What is right in its check word and
    came from anywhere else is a fault."""
    found = []
    for at in range(0, len(whole), size) if len(whole) == len(data) else ():
        before, after = whole[at:at + size], data[at:at + size]
        if struct.unpack("<I", before[-4:])[0] != check_word(before):
            raise SystemExit("attack: its check word is not that of the packets")
        flips = sum((a ^ b).bit_count() for a, b in zip(before, after))
        if flips > 1 and struct.unpack("<I", after[-4:])[0] == check_word(after):
            found.append(at // size)
    return found


def check_outputs(folder):
    """Checks tables and counts that were written with status 0."""
    for path in folder.rglob("*"):
        if path.suffix == ".json":
            text = path.read_text()
            finite(text, path.name)
            counts = json.loads(text)
            for group in (counts, *(v for v in counts.values() if isinstance(v, dict))):
                for key, value in group.items():
                    if isinstance(value, (int, float)) and not isinstance(value, bool):
                        if not math.isfinite(value) or (isinstance(value, int) and value < 0 and
                                                        "encoder" not in key and "seed" not in key and
                                                        "offset" not in key):
                            raise Fault(f"{key} is {value} in {path.name}")
        elif path.suffix == ".csv":
            finite(path.read_text(), path.name)


def frames_of(path):
    """The rows of each frame of moments.csv, without its number."""
    frames = {}
    with open(path, newline="") as file:
        for row in list(csv.reader(file))[1:]:
            frames.setdefault(row[0], []).append(tuple(row[1:]))
    return list(frames.values())


INSPECT = "selfproj inspect --device file:{m}/packets.bin --json o.json --out o"
PARTS = "selfproj inspect --device file:{m}/parts.bin --json o.json --parts p"
PATTERN = "selfproj pattern --rig {m}/rig.yaml --out o --reference {file}"
DEPTH = "selfproj depth --bits 2 --out o"
MOMENTS = "selfproj-sim moments --engine model --threshold 60 --out o.csv {file}"
RIG = "selfproj rig {file}"
# kind, file to mutate, mutations, command with {file}, check of what it writes
READERS = [
    ("png", "frame_1.png", BINARY, MOMENTS, "image"),
    ("jpeg", "a.jpg", BINARY, MOMENTS, "image"),
    ("tiff", "a.tiff", BINARY, MOMENTS, "image"),
    ("bmp", "a.bmp", BINARY, MOMENTS, "image"),
    ("pnm", "grey_1.pgm", BINARY, MOMENTS, "image"),
    ("float tiff", "heights.tiff", BINARY, PATTERN, "tables"),
    ("height map", "heights.tiff", BINARY, "selfproj-sim scene render --height-map {file} --mm-per-pixel 1 "
     "--rig {m}/rig.yaml --count 1 --out o", "tables"),
    ("rig", "rig.yaml", TEXT, RIG, "rig"),
    ("rig", "rig.yaml", TEXT, f"{INSPECT} --rig {{file}}", "tables"),
    ("curve", "curve.csv", TEXT, PATTERN, "tables"),
    ("reference", "reference/reference.csv", TEXT, f"{INSPECT} --rig {{m}}/rig.yaml --reference {{file}}", "tables"),
    ("recording", "packets.bin", BINARY, "selfproj inspect --device file:{file} --rig {m}/rig.yaml --json o.json "
     "--out o", "recording"),
    ("recording", "packets.bin", BINARY, "selfproj-sim board --replay {file} --record o.bin", "tables"),
    ("recording", "packets.bin", BINARY, "selfproj record --device file:{file} --out o.bin", "tables"),
    ("parts", "parts.bin", BINARY, "selfproj tolerance learn --device file:{file} --rig {m}/parts.yaml --out o.yaml",
     "tables"),
    ("rig of parts", "parts.yaml", TEXT, RIG, "rig"),
    ("rig of parts", "parts.yaml", TEXT, f"{PARTS} --tolerance {{m}}/tolerance.yaml --rig {{file}}", "tables"),
    ("tolerance", "tolerance.yaml", TEXT, f"{PARTS} --rig {{m}}/parts.yaml --tolerance {{file}}", "tables"),
    ("verdict", "verdict.yaml", TEXT, "selfproj verdict show --higher 0.05 {file}", "tables"),
    ("verdict", "verdict.yaml", TEXT,
     f"{PARTS} --rig {{m}}/judged.yaml --tolerance {{m}}/tolerance.yaml --verdict {{file}}", "tables"),
    ("calibrated rig", "calibrated/rig.yaml", TEXT, RIG, "rig"),
    ("rig with heights", "tied/rig.yaml", TEXT, RIG, "rig"),
    ("world", "world.yaml", TEXT, "selfproj-sim scene render plane --rig {m}/rig.yaml --count 1 --disturb gloss "
     "--world {file} --out o", "tables"),
    ("gamma", "gamma.csv", TEXT, "selfproj project --seconds 0.01 --gamma {file} {m}/frame_1.png", "tables"),
    ("codes", "codes.bin", BINARY, "selfproj images --device file:{file} --out o", "tables"),
    ("codes", "codes.bin", BINARY, f"{DEPTH} --rig {{m}}/scanner.yaml --device file:{{file}}", "tables"),
    ("calibration", "calibration.yaml", TEXT, f"{DEPTH} --calibration {{file}} {{frames}}", "tables"),
    ("cloud", "inspection/cloud.ply", TEXT, f"{DEPTH} --rig {{m}}/scanner.yaml --compare {{file}} {{seen}}", "tables")
] + [
    ("stripes", f"stripes/{name}", TEXT if name.endswith("yaml") else BINARY,
     "selfproj match --unchecked --rig {m}/scanner.yaml --reference {folder} --out o {seen}", "tables")
    for name in ("reference.yaml", "x_r_line.tiff", "x_r_column.tiff", "f_r_row.tiff", "f_r_column.tiff",
                 "f_r_seen.png")
]


class Files(Part):

    def __init__(self, attacker, made):
        super().__init__(attacker, made)
        self.moments = {}
        self.unseen = 0  # packets whose damage the check word does not show
        self.frames = frames_of(made / "inspection" / "moments.csv")
        self.readers = [reader for reader in READERS
                        if (made / reader[1]).exists() and (reader[0] != "gamma" or attacker.screen)]

    def run(self, count):
        for reader in self.readers:  # whole files are read: else what is done to them would show nothing
            self.attacker.case("files", f"{reader[0]} {reader[1]} as it is", self.one, reader, None)
        for i in range(count):
            reader = self.readers[i % len(self.readers)]
            mutation = self.random.choice(reader[2])
            name = f"{reader[0]} {reader[1]} {mutation.__name__} (seed {self.attacker.seed}, case {i})"
            self.attacker.case("files", name, self.one, reader, mutation)

    def one(self, reader, mutation):
        kind, name, _, command, check = reader
        whole = (self.made / name).read_bytes()
        data = mutation(self.random, whole) if mutation else whole
        with self.attacker.scratch() as folder:
            file = folder / name.split("/")[-1]
            if kind == "stripes":
                shutil.copytree(self.made / "stripes", folder / "stripes")
                file = folder / name
            file.write_bytes(data)
            words = [w.replace("{file}", str(file)).replace("{folder}", str(file.parent)) for w in self.words(command)]
            outcome = self.attacker.attack(words, folder, [file])
            if outcome.asked:
                raise Fault(f"takes longer than it may: {' '.join(words)}")
            if mutation is None and outcome.status != 0:
                raise Fault(f"a good file is refused: {outcome.err}")
            if outcome.status == 0:
                getattr(self, check)(folder, kind, name, whole, data, mutation, outcome)

    def tables(self, folder, *_):
        check_outputs(folder)

    def image(self, folder, kind, name, whole, data, mutation, _outcome):
        result = (folder / "o.csv").read_text()
        if name not in self.moments:
            good = folder / ("good" + name)
            good.write_bytes(whole)
            self.attacker.attack(
                self.words(f"selfproj-sim moments --engine model --threshold 60 --out good.csv {good}"), folder)
            self.moments[name] = (folder / "good.csv").read_text()
        if result == self.moments[name]:
            return
        if kind == "png" and not materials.png_is_whole(data):
            raise Fault("a damaged PNG gives other moments with status 0")
        if mutation is cut:
            raise Fault(f"{name} cut to {len(data)} of {len(whole)} bytes gives other moments with status 0")

    def rig(self, folder, _kind, _name, _whole, _data, _mutation, outcome):
        finite(outcome.out, "the rig")
        (folder / "again.yaml").write_text(outcome.out)
        again = self.attacker.attack(["selfproj", "rig", "again.yaml"], folder)
        if again.status != 0 or again.out != outcome.out:
            raise Fault("a rig that was printed reads back as another one")

    def recording(self, folder, _kind, _name, whole, data, _mutation, _outcome):
        check_outputs(folder)
        counts = json.loads((folder / "o.json").read_text())
        given = frames_of(folder / "o" / "moments.csv") if (folder / "o" / "moments.csv").exists() else []
        unseen = damaged_unseen(whole, data, len(whole) // len(self.frames))
        self.unseen += len(unseen)
        if sum(frame not in self.frames for frame in given) > len(unseen):
            raise Fault("a frame that was never recorded")
        if unseen:
            return  # what such a packet says of its frame may be anything
        place = 0
        for frame in given:
            if frame not in self.frames[place:]:
                break  # repeated or moved: as good a recording as any
            place = self.frames.index(frame, place) + 1
        if len(given) < len(self.frames) and not any(
                counts[key] for key in ("bad", "bytes_discarded", "missing", "repeated", "restarts", "other_spec")):
            # If a file is cut between two packets, nothing shows what is missing at its end.
            if given != self.frames[:len(given)]:
                raise Fault(f"{len(self.frames) - len(given)} frames are gone, and nothing is counted")
