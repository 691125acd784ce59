"""Attacks every option of every command with malicious values."""
import json
import os
import re
import shutil

from programs import Fault, Part, words

VALUES = [
    "", " ", "nan", "-nan", "inf", "-inf", "-1", "-0", "0", "1", "2", "1e999", "1e-320", "1e-300", "1e308", "010",
    "0x10", "255", "256", "65536", "2147483647", "2147483648", "4294967296", "9223372036854775807",
    "9223372036854775808", "18446744073709551615", "18446744073709551616", "-9223372036854775809", "1.5", "1,2",
    "1 2", "1x1", "0x0", "-1x5", "99999999999x99999999999", "4294967808x96", "3x3x3", "x", "/", ".", "..",
    "/dev/null", "/dev/zero", "/dev/full", "/dev/stdin", "/proc/self/mem", "/no/such/file", "none", "%s%n", "\n",
    "a\nb", "é€", "--", "--help", "-", "*", "?", "ring:", "ring:x/y", "file:", "file:/dev/zero", "file:/", "sim:",
    "udp:", "udp:127.0.0.2:99999", "bar:", "bar:/dev/zero", "bar:/dev/null", "bar:bar.bin+4",
    "x" * 300, "x" * 5000, "rig.yaml", "frame_1.png", "packets.bin", "heights.tiff", "curve.csv", "verdict.yaml", "a.jpg",
    "reference", "grey", "rtl", "binary", "light-section", "scanner", "stairs-marked", "plane", "true", "1e1", "+5",
    "1_000", "1'000"
]
# Options whose value sets the length of a run: the run must end when it is asked to.
SLOW = 2  # seconds


# A good call of every command; a line that begins with a blank goes on.
GOOD_CALLS = """
selfproj rig: {m}/rig.yaml
selfproj inspect: --device file:{m}/parts.bin --rig {m}/parts.yaml --tolerance {m}/tolerance.yaml --parts p
  --json j.json --out o
selfproj tolerance learn: --device file:{m}/parts.bin --rig {m}/parts.yaml --out o
selfproj verdict table: --rig {m}/judged.yaml --tolerance {m}/tolerance.yaml --play-across 0.05 --play-along 0.1
  --start 0 --pitch 1000 --out o
selfproj verdict show: {m}/verdict.yaml
selfproj depth: --rig {m}/scanner.yaml --bits 2 --out o {seen}
selfproj match: --rig {m}/scanner.yaml --reference {m}/stripes --out o {seen}
selfproj pattern: --rig {m}/rig.yaml --reference {m}/curve.csv --out o
selfproj pattern chessboard: --out o.svg
selfproj pattern gray: --rig {m}/scanner.yaml --bits 8 --out o
selfproj pattern stripes: --rig {m}/scanner.yaml --scan {m}/seen --gray-code --bits 2 --out o
selfproj calibrate: --chessboard 6x5 --square 30 --projector 256x192 --rig {m}/quarter.yaml --out o
  {m}/chess/pose_01 {m}/chess/pose_02
selfproj calibrate belt: --rig {m}/rig.yaml --chessboard 6x5 --square 30 --out o {views}
selfproj calibrate camera: --chessboard 6x5 --square 30 --out o {views}
selfproj lines: --threshold 60 --out o {frames}
selfproj calibrate heights: --rig {m}/plate.yaml --every 16 --heights 0,10,20 --out o {m}/at0 {m}/at10 {m}/at20
selfproj accuracy: --out o
selfproj rows: --rig {m}/rig.yaml --rows 10 --out o.yaml
selfproj compare: --out o {m}/heights.tiff {m}/heights.tiff
selfproj devices:
selfproj project: --seconds 0.1 --gamma {m}/gamma.csv {m}/frame_1.png
selfproj capture: --camera camera:Fake_1 --patterns {m}/shown --out o
selfproj scan: --camera camera:Fake_1 --rig {m}/scanner.yaml --out o
selfproj measure gamma: --camera camera:Fake_1 --out o.csv
selfproj record: --device file:{m}/packets.bin --out o
selfproj images: --device file:{m}/codes.bin --out o
selfproj board info: --device bar:bar.bin
selfproj board status: --device bar:bar.bin
selfproj board set: --device bar:bar.bin size.columns=512
selfproj board start: --device bar:bar.bin
selfproj board stop: --device bar:bar.bin
selfproj board trigger: --device bar:bar.bin --period 15120
selfproj board selftest: --device bar:bar.bin
selfproj board source: --device udp:127.0.0.1 patterns
selfproj board replay: --device udp:127.0.0.1 {frames}
selfproj-sim moments: --engine model --out o.csv {frames}
selfproj-sim decode: --engine model --bits 2 --out o {frames}
selfproj-sim cosim: --engine model --threshold 60 --frames {m}/frame_?.png --out o
selfproj-sim board: --line 64x16 --line-frames 5 --record o
selfproj-sim scene render: plane --rig {m}/rig.yaml --count 1 --out o
selfproj-sim production: --good 1 --parts 1 --out o
selfproj-sim camera: --seconds 0.1 {frames}
selfproj-sim capture: --rig {m}/scanner.yaml --patterns {m}/gray --scene desk --out o
"""


def commands_of(made):
    """{words of a command: words of its good call}. No board answers those of udp:."""
    calls = (line.split(":", 1) for line in GOOD_CALLS.replace("\n  ", " ").strip().splitlines())
    return {tuple(command.split()): words(call, made) for command, call in calls}


class Options(Part):

    def __init__(self, attacker, made):
        super().__init__(attacker, made)
        self.commands = commands_of(made)
        self.flags = set()  # (command, option) without a value: what follows is another argument
        self.options = {command: self.options_of(command) for command in self.commands}
        self.check_that_none_is_missing()

    def check_that_none_is_missing(self):
        """A new command needs a good call above."""
        with self.attacker.scratch() as folder:
            for command in self.said_of_commands(folder):
                options = [one for group in command["groups"] if group["name"] != "Help" for one in group["options"]]
                if options and tuple(command["name"].split()) not in self.commands:
                    raise SystemExit(f"attack: options.py has no good call of {command['name']}")

    def options_of(self, command):
        """Returns all options of --help, including short ones, so that a new option is attacked automatically."""
        with self.attacker.scratch() as folder:
            text = self.attacker.run([*command, "--help"], folder).out
        found = re.findall(r"(?m)^\s+(?:-\w,\s*)?(--[a-z][a-z0-9-]*)(.*)$", text)
        names = [name for name, _ in found if name not in ("--help", "--version")]
        self.flags |= {(command, name) for name, rest in found if not re.match(r" \S", rest)}
        if not names and command != ("selfproj", "rig"):
            raise SystemExit(f"attack: no options of {' '.join(command)} in its --help")
        return sorted(set(names))

    def all_cases(self):
        for command, names in self.options.items():
            for name in names or [None]:
                for value in VALUES:
                    yield command, name, value

    def run(self, count):
        cases = list(self.all_cases())
        self.random.shuffle(cases)
        while len(cases) < count:  # then two at a time
            command, name, value = self.random.choice(cases[:2000])
            names = self.options[command]
            if names:
                cases.append((command, (name, self.random.choice(names)), (value, self.random.choice(VALUES))))
        for command, name, value in cases[:count]:
            self.attacker.case("options", f"{' '.join(command)} {name} {value!r:.80}", self.one, command, name, value)

    def with_option(self, command, name, value):
        base = list(self.commands[command])
        if name is None:
            return [*command, value]
        pairs = zip(name, value) if isinstance(name, tuple) else [(name, value)]
        for option, given in pairs:
            if option in base:
                base[base.index(option) + 1] = given
            else:
                base += [f"{option}={given}"] if self.random.randrange(2) else [option, given]
        return [*command, *base]

    def one(self, command, name, value):
        call = self.with_option(command, name, value)
        if any("\0" in str(word) for word in call):
            return
        ring = f"attack-options-{os.getpid()}"
        call = [ring if str(word) == "none" else word for word in call]
        with self.attacker.scratch() as folder:
            if command[1] == "board":  # writes into the registers
                shutil.copy(self.made / "bar.bin", folder)
            outcome = self.attacker.attack(call, folder, [self.made], patience=SLOW)
            if (command, name) not in self.flags:
                self.refused_numbers(outcome, call, name, value)
            for path in folder.rglob("*.json"):
                json.loads(path.read_text())
        for path in os.listdir("/dev/shm"):
            if path == f"selfproj-ring-{ring}" or path in ("selfproj-ring-1", "selfproj-ring-x"):
                os.unlink(os.path.join("/dev/shm", path))

    @staticmethod
    def refused_numbers(outcome, call, name, value):
        """A count that is not a count is refused, and the error names it."""
        numbers = ("--count", "--keep", "--threshold", "--bits", "--e", "--every", "--square", "--tilt", "--rate")
        if name in numbers and value in ("nan", "inf", "0x10", "1e999", "18446744073709551616", "-1x5", "1'000"):
            if outcome.status == 0:
                raise Fault(f"status 0 with {name} {value}: {' '.join(map(str, call))}")
            if name not in outcome.err and outcome.status == 2:
                raise Fault(f"does not name {name}: {outcome.err!r}")
        if name == "--count" and value == "-1" and outcome.status == 0:
            raise Fault(f"--count -1 is taken: {' '.join(map(str, call))}")
