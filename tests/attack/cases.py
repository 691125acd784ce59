"""Cases that an attack has found, one by one, with the programs as they are. Each must fail without its mend."""
import json
import os
import re
import resource
import signal
import struct
import time

from files import check_outputs
from materials import EXIF_TURNED, JPEG, line_rows, tiff
from programs import Fault, Part, temporaries

NO_SUCH_NUMBERS = ["-1e308", "1e39", "1e-320", "nan"]


def replaced(text, old, new):
    if old not in text:
        raise SystemExit(f"attack: {old!r} is not in what is to be damaged")
    return text.replace(old, new, 1)


# Commands that are refused, and what their error names; {m}: the folder of the materials
INSPECT = "selfproj inspect --device file:{m}/packets.bin --json o.json"
DEPTH = "selfproj depth --bits 2 --out o"
MOMENTS = "selfproj-sim moments --engine model --threshold 60 --out o.csv"
REFUSED = [
    ("selfproj rig {m}", "{m}"),
    (f"{INSPECT} --rig {{m}}", "{m}"),
    (f"{DEPTH} --rig {{m}}/scanner.yaml --compare {{m}} {{seen}}", "{m}"),
    ("selfproj rig /dev/zero", "/dev/zero"),
    (f"{DEPTH} --rig {{m}}/scanner.yaml --compare /dev/zero {{seen}}", "/dev/zero"),
    (f"{DEPTH} --calibration /dev/zero {{seen}}", "/dev/zero"),
    (f"{MOMENTS} /dev/zero", "/dev/zero"),
    ("selfproj-sim board --line 64x16 --line-frames 5 --record o --count=-1", "--count"),
    ("selfproj-sim board --line 64x16 --line-frames 5 --record o --rate 1e-300", "--rate"),
    ("selfproj-sim board --line 4294967808x96 --record o", "--line"),
    ("selfproj-sim board --replay /dev/zero --record o", "/dev/zero"),
    (f"{INSPECT} --rig {{m}}/rig.yaml --count=-1", "--count"),
    (f"{INSPECT} --rig {{m}}/rig.yaml --count=18446744073709551616", "--count")
]


class Cases(Part):

    def run(self, counts):
        """`counts`: how many of the numbers of rigs, and of the options for numbers, are drawn."""
        case = self.attacker.case
        for command, name in REFUSED:
            case("cases", f"refused: {command}", self.is_refused, self.words(command), self.words(name)[0])
        for name, text in self.texts():
            case("cases", name, self.text_is_refused, *text)
        for number in self.drawn([(line, value) for line in self.lines_of_rig() for value in NO_SUCH_NUMBERS], counts):
            case("cases", f"rig: {number}", self.number_of_rig, *number)
        for command, name in self.drawn(self.options_for_numbers(), counts):
            case("cases", f"not a number: {command} {name}", self.is_refused,
                 [command.split()[0], "--check-usage", *command.split()[1:], name, "nan"], name)
        for name in ("jpeg", "orientation", "decimal_numbers", "file_size", "new_board", "lost_of_a_ring",
                     "recording_signals"):
            case("cases", name, getattr(self, name))

    def drawn(self, all_of_them, count):
        return all_of_them if count >= len(all_of_them) else self.random.sample(all_of_them, count)

    def is_refused(self, command, name, folder=None, text=None):
        if folder is None:
            with self.attacker.scratch() as folder:
                return self.is_refused(command, name, folder, text)
        outcome = self.attacker.attack(command, folder)
        if outcome.asked or outcome.status != 2 or name not in outcome.err or (text and text not in outcome.err):
            raise Fault(f"status {outcome.status}{', asked to end' if outcome.asked else ''}: {outcome.err!r}")
        return outcome

    # --- texts ---

    def texts(self):
        """Names of cases, and (name of the file, its text, command, what the error says)."""
        m = self.made
        inspect = self.words(f"{INSPECT} --rig {{m}}/rig.yaml --reference r.csv")
        reference = (m / "reference" / "reference.csv").read_text()
        row = re.search(r"\n9,([^,]+),([^,]+),([^\n]+)\n", reference)
        for value in ("-1e308", "1e39", "1e-320"):
            for field, what in ((1, "tan_theta"), (2, "z"), (3, "offset")):
                if value == "1e-320" and field != 2:
                    continue  # an angle and an offset may be 0
                fields = [row[1], row[2], row[3]]
                fields[field - 1] = value
                yield (f"reference.csv: {what} {value}",
                       ("r.csv", replaced(reference, row[0], f"\n9,{','.join(fields)}\n"), inspect, what))
            yield (f"curve.csv: z {value}",
                   ("c.csv", f"y_mm,z_mm\n-200,1167\n0,{value}\n200,1167\n",
                    self.words("selfproj pattern --rig {m}/rig.yaml --reference c.csv --out o"), "line 3"))
        rig = (m / "rig.yaml").read_text()
        yield "rig: a second document", ("r.yaml", f"{rig}---\n{rig}", ["selfproj", "rig", "r.yaml"], "second document")
        yield "rig: aliases", ("r.yaml", "a: &a [*a]\n", ["selfproj", "rig", "r.yaml"], "aliases")
        yield "rig: depth", ("r.yaml", "[" * 500000, ["selfproj", "rig", "r.yaml"], "deep")
        depth = self.words(f"{DEPTH} --calibration c.yaml {{frames}}")
        calibration = (m / "calibration.yaml").read_text()
        yield "calibration: a second document", ("c.yaml", calibration + "---\na: 1\n", depth, "second document")
        yield "calibration: octal", ("c.yaml", replaced(calibration, "[ 80.", "[ 0120"), depth, "0120")
        for name, text in (("yaml", "%YAML:1.0\n---\na: " + "[" * 500000), ("json", '{"a":' * 100000),
                           ("xml", '<?xml version="1.0"?><opencv_storage>' + "<a>" * 300000)):
            yield f"calibration: depth of {name}", ("c.yaml", text, depth, "deep")

    def text_is_refused(self, name, text, command, says):
        with self.attacker.scratch() as folder:
            (folder / name).write_text(text)
            self.is_refused(command, name, folder, says)

    # --- numbers ---

    def lines_of_rig(self):
        return [line for line in (self.made / "rig.yaml").read_text().splitlines() if re.search(r": -?\d", line)]

    def number_of_rig(self, line, value):
        """It is refused by its name, or the run is as good as with any other number."""
        key = line.split(":")[0]
        with self.attacker.scratch() as folder:
            text = (self.made / "rig.yaml").read_text()
            (folder / "r.yaml").write_text(replaced(text, f"\n{line}\n", f"\n{key}: {value}\n"))
            outcome = self.attacker.attack(self.words(f"{INSPECT} --rig r.yaml --out o"), folder)
            if outcome.status == 1 or outcome.asked or (outcome.status == 2 and key.strip() not in outcome.err):
                raise Fault(f"status {outcome.status}: {outcome.err!r}")
            if outcome.status == 0:
                check_outputs(folder)

    def options_for_numbers(self):
        found = []
        with self.attacker.scratch() as folder:
            for command in self.said_of_commands(folder):
                for option in (one for group in command["groups"] for one in group["options"]):
                    if re.search(r"\d", option["limits"]):
                        found.append((command["name"], option["name"].split(",")[-1].split()[0]))
        if len(found) < 50:
            raise SystemExit(f"attack: only {len(found)} options for numbers")
        return found

    def decimal_numbers(self):
        with self.attacker.scratch() as folder:
            text = (self.made / "rig.yaml").read_text()
            (folder / "r.yaml").write_text(replaced(text, "  rows: 16\n", "  rows: 016\n"))
            outcome = self.attacker.attack(self.words(f"{INSPECT} --rig r.yaml --count 010"), folder)
            if outcome.status != 0 or json.loads((folder / "o.json").read_text())["profiles"] != 10:
                raise Fault(f"016 rows and 010 profiles are not decimal: {outcome.err!r}")

    # --- images ---

    def jpeg(self):
        """A damaged JPEG where no file can be written, and without standard error."""
        def limits():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))

        with self.attacker.scratch() as folder:
            (folder / "cut.jpg").write_bytes(JPEG[:len(JPEG) * 2 // 3])
            outcome = self.attacker.attack(self.words(MOMENTS) + ["cut.jpg"], folder, preexec_fn=limits,
                                           env={**os.environ, "TMPDIR": "/nonexistent"})
            if outcome.status != 2 or "cut.jpg" not in outcome.err:
                raise Fault(f"a damaged JPEG where no file can be written: status {outcome.status}, {outcome.err!r}")
            if self.attacker.run(self.words(MOMENTS) + ["cut.jpg"], folder, preexec_fn=lambda: os.close(2)).status != 2:
                raise Fault("a damaged JPEG without standard error is taken")

    def orientation(self):
        with self.attacker.scratch() as folder:
            rows = line_rows()
            for kind, upright, turned in (("jpg", JPEG, JPEG[:2] + EXIF_TURNED + JPEG[2:]),
                                          ("tiff", tiff(rows), tiff(rows, orientation=6))):
                tables = []
                for data in (upright, turned):
                    (folder / f"a.{kind}").write_bytes(data)
                    outcome = self.attacker.attack(self.words(MOMENTS) + [f"a.{kind}"], folder)
                    tables.append((folder / "o.csv").read_text() if outcome.status == 0 else outcome.err)
                if tables[0] != tables[1]:
                    raise Fault(f"the orientation of a {kind} changes the moments")

    # --- outputs ---

    def file_size(self):
        """A limit on the size of files: one line, the old files, no signal, nothing left behind."""
        with self.attacker.scratch() as folder:
            (folder / "o").mkdir()
            (folder / "o" / "pattern_00000.png").write_bytes(b"old")
            outcome = self.attacker.attack(
                self.words("selfproj pattern gray --rig {m}/scanner.yaml --out o"), folder,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (60, 60)))
            if outcome.status != 2:
                raise Fault(f"status {outcome.status} with files of at most 60 bytes: {outcome.err!r}")
            if [(p.name, p.read_bytes()) for p in (folder / "o").iterdir()] != [("pattern_00000.png", b"old")]:
                raise Fault("a folder that could not be written is not as it was")

    def recording_signals(self):
        """A recording that is asked to end is whole; one that is killed is not there."""
        packets = (self.made / "packets.bin").read_bytes()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL):
            with self.attacker.scratch() as folder:
                os.mkfifo(folder / "pipe")
                process = self.attacker.start(self.words("selfproj record --device file:pipe --out o"), folder)
                with open(folder / "pipe", "wb") as pipe:
                    pipe.write(packets)
                    pipe.flush()
                    time.sleep(0.3)
                    process.send_signal(number)
                    process.communicate(timeout=20)
                there = (folder / "o").read_bytes() if (folder / "o").exists() else None
                if number == signal.SIGKILL:
                    good = there is None
                else:
                    good = process.returncode == 0 and there == packets and not temporaries(folder)
                if not good:
                    raise Fault(f"signal {number}: status {process.returncode}, {there and len(there)} bytes")

    # --- rings ---

    def ring(self):
        return f"attack-cases-{os.getpid()}"

    def counts_of_ring(self, folder):
        command = self.words(f"selfproj inspect --device ring:{self.ring()} --rig {{m}}/rig.yaml --json o.json")
        self.good(command, folder)
        return json.loads((folder / "o.json").read_text())

    def play(self, folder, count):
        self.good(self.words(f"selfproj-sim board --line 64x16 --line-frames 5 --ring {self.ring()} --keep --slots 16 "
                             f"--count {count}"), folder)

    def with_ring(self, then):
        file = f"/dev/shm/selfproj-ring-{self.ring()}"
        try:
            with self.attacker.scratch() as folder:
                then(folder, file)
        finally:
            if os.path.exists(file):
                os.unlink(file)

    def new_board(self):
        """The first packet of each board has the same number and time."""
        def then(folder, _file):
            for _ in range(3):
                self.play(folder, 1)
            counts = self.counts_of_ring(folder)
            if counts["delivered"] != 3 or counts["repeated"] != 0:
                raise Fault(f"{counts['delivered']} of the first packets of 3 boards, {counts['repeated']} repeated")

        self.with_ring(then)

    def lost_of_a_ring(self):
        """The ring's count of lost packets is 2^64 - 1."""
        def then(folder, file):
            self.play(folder, 3)
            with open(file, "r+b") as header:
                header.seek(72)
                header.write(struct.pack("<Q", (1 << 64) - 1))
            counts = self.counts_of_ring(folder)
            if counts["lost_ring"] < 0 or counts["bad"] == 0:
                raise Fault(f"{counts['lost_ring']} lost, {counts['bad']} bad")

        self.with_ring(then)
