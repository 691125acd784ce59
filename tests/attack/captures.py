"""Attacks with captures in wrong orders, full disks, and two outputs on one file."""
import json
import os
import resource
import shutil
import struct
import zlib

import materials
from programs import Fault, Part

BITS = 8
SCENES = ["desk", "cuboids", "keyboard", "fist", "block", "slider", "waves", "hands"]


def reversed_pairs(files):
    return [file for at in range(0, len(files), 2) for file in (files[at + 1], files[at])]


def least_first(files):
    return [file for at in range(len(files) - 2, -1, -2) for file in files[at:at + 2]]


def brightest_row(png):
    """The brightest row of an image that materials.png has made, or a row far away where all is dark."""
    size, = struct.unpack_from(">I", png, 33)
    data = zlib.decompress(png[41:41 + size])
    columns, = struct.unpack_from(">I", png, 16)
    column = data[1::columns + 1]
    return column.index(max(column)) if max(column) > 100 else 1000


class Captures(Part):

    def run(self, count):
        case = self.attacker.case
        for scene in self.random.sample(SCENES, min(count, len(SCENES))):
            with self.attacker.scratch() as folder:
                seed = self.random.randrange(1, 1000)
                self.good(["selfproj-sim", "scene", "render", scene, "--rig", "scanner", "--count", str(2 * BITS),
                           "--seed", str(seed), "--out", "seen"], folder)
                files = [f"seen/frame_{i + 1:05}.png" for i in range(2 * BITS)]
                case("captures", f"{scene} (seed {seed}) as it is", self.order, folder, files, True)
                for name, wrong in self.wrong_orders(files):
                    case("captures", f"{scene} (seed {seed}) {name}", self.order, folder, wrong, False)
                case("captures", f"{scene} (seed {seed}) white and black", self.white_and_black, folder, files)
        case("captures", "sweep", self.sweep)
        for name in ("recording_on_a_full_disk", "parts_on_a_full_disk", "two_outputs", "no_light"):
            case("captures", name, getattr(self, name))

    def wrong_orders(self, files):
        yield "reversed", files[::-1]
        yield "in lexical order", [files[int(i) - 1] for i in sorted(str(i + 1) for i in range(len(files)))]
        yield "least significant bit first", least_first(files)
        yield "positive and negative exchanged", reversed_pairs(files)
        yield "most significant pair exchanged", reversed_pairs(files[:2]) + files[2:]
        late = self.random.randrange(3, len(files))
        yield f"image {late} late", files[:late - 1] + [files[late - 2]] + files[late:]
        yield "white and black first", [files[0], files[0]] + files[:-2]

    def order(self, folder, files, good):
        outcome = self.attacker.attack(["selfproj", "depth", "--rig", "scanner", "--bits", str(BITS), "--out", "depth"] +
                                       files, folder)
        if good and (outcome.status != 0 or outcome.err):
            raise Fault(f"status {outcome.status}: {outcome.err!r}")
        if not good and outcome.status == 0:
            raise Fault(f"is taken: {outcome.out!r} {outcome.err!r}")
        shutil.rmtree(folder / "depth", ignore_errors=True)

    def white_and_black(self, folder, files):
        """In a folder, they must follow the codes."""
        (folder / "all").mkdir()
        for i, file in enumerate(files[:2] + files):
            shutil.copy(folder / file, folder / "all" / f"{i}.png")
        outcome = self.attacker.attack(["selfproj", "depth", "--rig", "scanner", "--bits", str(BITS), "--out", "o", "all"],
                                       folder)
        if outcome.status == 0 or "white and black" not in outcome.err:
            raise Fault(f"status {outcome.status}: {outcome.err!r}")

    def sweep(self):
        """Of lines over a flat plate, as it is, in another order, and with one image late."""
        with self.attacker.scratch() as folder:
            for height in (0, 10, 20):
                (folder / f"at{height}").mkdir()
                for name, image in materials.sweep((self.made / "plate.yaml").read_text(), 4, height):
                    (folder / f"at{height}" / name).write_bytes(image)
            files = sorted((folder / "at10").iterdir(), key=lambda file: int(file.stem.split("_")[1]))
            rows = [brightest_row(file.read_bytes()) for file in files]
            middle = min(range(len(files)), key=lambda i: abs(rows[i] - 48))
            for name, order, good in (("right", files, True), ("reversed", files[::-1], False),
                                      ("swapped", files[:middle] + [files[middle + 1], files[middle]] +
                                       files[middle + 2:], False),
                                      ("late", files[:middle] + [files[middle - 1]] + files[middle + 1:], False)):
                (folder / name).mkdir()
                for i, file in enumerate(order):
                    shutil.copy(file, folder / name / f"image_{i}.png")
                for command in (f"selfproj pattern --scan {name} --out o",
                                f"selfproj calibrate heights --heights 0,10,20 --out o at0 {name} at20"):
                    command = self.words(command + " --rig {m}/plate.yaml --every 4")
                    outcome = self.attacker.attack(command, folder)
                    if (outcome.status == 0) != good:
                        raise Fault(f"{name}: {command[1]}: status {outcome.status}: {outcome.err!r}")
                    shutil.rmtree(folder / "o", ignore_errors=True)

    def limited(self, text, size, folder):
        """A limit on the size of files stands for the full disk: the same error of the same write."""
        return self.attacker.attack(self.words(text), folder,
                                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))

    def recording_on_a_full_disk(self):
        packets = (self.made / "packets.bin").read_bytes()
        size = len(packets) // 2 + 5
        with self.attacker.scratch() as folder:
            outcome = self.limited("selfproj record --device file:{m}/packets.bin --out o", size, folder)
            kept = (folder / "o").read_bytes() if (folder / "o").exists() else b""
            if outcome.status == 0 or not kept or packets[:len(kept)] != kept:
                raise Fault(f"status {outcome.status}, {len(kept)} bytes kept: {outcome.err!r}")
            self.good(["selfproj", "record", "--device", "file:o", "--check", "--out", "again"], folder)

    def parts_on_a_full_disk(self):
        command = "selfproj inspect --device file:{m}/parts.bin --rig {m}/parts.yaml --tolerance {m}/tolerance.yaml " \
                  "--json o.json --parts p"
        with self.attacker.scratch() as folder:
            self.good(self.words(command), folder)
            lines = (folder / "p" / "parts.jsonl").read_text()
            size = len(lines.encode()) - 10  # Of the records the last is torn; the shorter statistics fit.
            shutil.rmtree(folder / "p")
            (folder / "o.json").unlink()
            outcome = self.attacker.run(
                self.words(command), folder,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
            if outcome.status == 0 or "parts.jsonl" not in outcome.err:
                raise Fault(f"status {outcome.status}: {outcome.err!r}")
            text = (folder / "p" / "parts.jsonl").read_text()
            parts = [json.loads(line) for line in text.splitlines()]
            if not text.endswith("\n") or not parts:
                raise Fault(f"parts.jsonl is torn: {text[-80:]!r}")
            for name in ("p/statistics.json", "o.json"):
                json.loads((folder / name).read_text())

    def two_outputs(self):
        inspect = "selfproj inspect --device file:{m}/parts.bin --rig {m}/parts.yaml --tolerance {m}/tolerance.yaml "
        for more in ("--parts p --json p/parts.csv", "--parts p --json p/parts.jsonl", "--parts p/ --json ./p/statistics.json",
                     "--parts link/p --json real/p/parts.csv", "--out o --json o/summary.json",
                     "--out link/o --json real/o/report.html"):
            with self.attacker.scratch() as folder:
                (folder / "real").mkdir()
                os.symlink("real", folder / "link")
                outcome = self.attacker.attack(self.words(inspect + more), folder)
                left = [str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()]
                if outcome.status != 2 or "already an output" not in outcome.err or left:
                    raise Fault(f"{more}: status {outcome.status}, {left}: {outcome.err!r}")

    def no_light(self):
        """Frames under a threshold that no pixel reaches."""
        with self.attacker.scratch() as folder:
            rig = (self.made / "rig.yaml").read_text().replace("  min_lit_px: 3\n", "  min_lit_px: 16\n")
            (folder / "r.yaml").write_text(rig)
            command = ["selfproj", "inspect", "--device", f"file:{self.made}/packets.bin", "--rig", "r.yaml", "--json", "o"]
            outcome = self.good(command, folder)
            if json.loads((folder / "o").read_text())["points"] == 0 and "warning" not in outcome.err:
                raise Fault(f"no word of 0 valid points: {outcome.err!r}")
            outcome = self.attacker.attack(command + ["--check"], folder)
            if json.loads((folder / "o").read_text())["points"] == 0 and outcome.status != 1:
                raise Fault(f"--check with 0 valid points: status {outcome.status}")
