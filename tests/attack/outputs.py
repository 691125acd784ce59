"""Attacks on outputs: onto inputs, onto failing devices, killed in the middle."""
import os
import shutil
import signal
import subprocess
import time

from options import commands_of
from programs import Fault, Part, fingerprint, temporaries


# Outputs that are inputs: files to copy from the materials (NAME:COPY), the command, the inputs that must stay as they
# are.
FRAMES = "frame_1.png frame_2.png frame_3.png frame_4.png"
COSIM = "selfproj-sim cosim --engine model --threshold 60 --frames frame_?.png"
ONTO_INPUTS = [
    (FRAMES, f"{COSIM} --out .", FRAMES),
    (FRAMES, f"{COSIM} --packets frame_2.png", FRAMES),
    (FRAMES, f"{COSIM} --packets hard", FRAMES),
    (FRAMES, f"selfproj-sim moments --engine model --out frame_1.png {FRAMES}", FRAMES),
    (FRAMES, f"selfproj-sim moments --engine model --out soft {FRAMES}", FRAMES),
    ("frame_1.png:code_0000.png frame_2.png",
     "selfproj-sim decode --engine model --bits 1 --out . code_0000.png frame_2.png", "code_0000.png frame_2.png"),
    ("packets.bin rig.yaml", "selfproj inspect --device file:packets.bin --rig rig.yaml --json packets.bin",
     "packets.bin"),
    ("packets.bin rig.yaml", "selfproj inspect --device file:packets.bin --rig rig.yaml --json rig.yaml", "rig.yaml"),
    ("packets.bin:moments.csv rig.yaml", "selfproj inspect --device file:moments.csv --rig rig.yaml --out .",
     "moments.csv"),
    ("packets.bin", "selfproj-sim board --replay packets.bin --record ./packets.bin", "packets.bin"),
    ("curve.csv:reference.csv rig.yaml", "selfproj pattern --rig rig.yaml --reference reference.csv --out .",
     "reference.csv"),
    ("heights.tiff:pattern.tiff rig.yaml", "selfproj pattern --rig rig.yaml --reference pattern.tiff --out .",
     "pattern.tiff"),
    ("scanner.yaml SEEN", "selfproj depth --rig scanner.yaml --bits 2 --out . NAMES", ""),
    ("scanner.yaml SEEN", "selfproj depth --rig scanner.yaml --bits 2 --out . --background depth.tiff NAMES",
     "depth.tiff"),
    ("scanner.yaml SEEN", "selfproj depth --rig scanner.yaml --bits 2 --out . --compare cloud.ply NAMES", "cloud.ply"),
    ("heights.tiff:frame_00001.png rig.yaml",
     "selfproj-sim scene render plane --rig rig.yaml --count 1 --pattern frame_00001.png --out .", "frame_00001.png"),
    ("heights.tiff rig.yaml", "selfproj-sim scene render --height-map heights.tiff --mm-per-pixel 1 --rig rig.yaml "
     "--count 1 --truth heights.tiff --out o", "heights.tiff")
]


def outputs_onto_inputs(made):
    names = [path.name for path in sorted((made / "seen").iterdir())[:4]]
    seen = "seen/" + " seen/".join(names)
    for case in ONTO_INPUTS:
        yield [text.replace("NAMES", " ".join(names)).replace("SEEN", seen).split() for text in case]


# Commands whose standard output fails
PRINTING = """
selfproj rig
selfproj rig light-section
selfproj --help
selfproj --version
selfproj inspect --help
selfproj devices
selfproj accuracy
selfproj-sim scene list
selfproj-sim --help
selfproj pattern gray --projector 8x4 --out o
selfproj inspect --device file:{m}/packets.bin --rig {m}/rig.yaml
selfproj-sim board --line 64x16 --count 5 --record o
selfproj-sim moments --engine model --out o {m}/frame_1.png
"""

# Commands that are killed over an older run of their own, with their good calls: what they write is a folder or a file
# `o`.
KILLED = """selfproj depth, selfproj match, selfproj pattern stripes, selfproj calibrate, selfproj calibrate camera,
selfproj calibrate heights, selfproj lines, selfproj images, selfproj-sim decode, selfproj-sim capture,
selfproj tolerance learn, selfproj accuracy"""
# and these
KILLED_ALSO = """
selfproj pattern --rig {m}/rig.yaml --reference {m}/curve.csv --out o
selfproj pattern --rig {m}/rig.yaml --sweep --every 64 --out o
selfproj inspect --device file:{m}/packets.bin --rig {m}/rig.yaml --out o
selfproj-sim scene render plane --rig {m}/rig.yaml --count 8 --out o
selfproj pattern gray --rig {m}/scanner.yaml --out o
"""


def without_good_call(attacker):
    """Commands whose calls do not succeed here. The program's simulated camera does not see what a display shows; the
    test LiveCapture has one that does. No camera is calibrated here whose belt could be; HiddenRig.laser does both. No
    board replays."""
    without = {("selfproj", "capture"), ("selfproj", "scan"), ("selfproj", "measure", "gamma"),
               ("selfproj", "calibrate", "belt"), ("selfproj", "board", "replay")}
    return without | set([] if attacker.screen else [("selfproj", "project")])


class Outputs(Part):

    def __init__(self, attacker, made):
        super().__init__(attacker, made)
        self.commands = commands_of(made)

    # --- an output that is an input ---

    def onto_inputs(self, share, pairs):
        """Runs a share of the cases above, and `pairs` inputs of any command in place of one of its outputs."""
        cases = list(outputs_onto_inputs(self.made))
        for number, case in enumerate(cases):
            if number % share:
                continue
            self.attacker.case("output onto input", f"case {number}: {' '.join(map(str, case[1][:3]))}",
                               self.onto_input, *case)
        left_out = without_good_call(self.attacker)
        known = [(command, name) for command in self.commands if command not in left_out
                 for name in self.inputs_of(command)]
        for command, name in known if pairs >= len(known) else self.random.sample(known, pairs):
            self.attacker.case("output onto input", f"{' '.join(command)}: {name}", self.onto_any, command, name)

    def onto_input(self, files, command, kept):
        with self.attacker.scratch() as folder:
            for name in files:
                source, _, target = name.partition(":")
                (folder / (target or source.split("/")[-1])).write_bytes((self.made / source).read_bytes())
            if "hard" in command:
                os.link(folder / "frame_3.png", folder / "hard")
            if "soft" in command:
                os.symlink("frame_3.png", folder / "soft")
            if "depth.tiff" in command or "cloud.ply" in command:
                first = [w for w in command if w not in ("--background", "depth.tiff", "--compare", "cloud.ply")]
                self.attacker.attack(first, folder)
            if "frame_00001.png" in kept:
                (folder / "frame_00001.png").write_bytes((self.made / "reference" / "pattern.png").read_bytes())
            inputs = [folder / name for name in kept]
            outcome = self.attacker.attack(command, folder, inputs)
            if kept and (outcome.status != 2 or "is an input of this command" not in outcome.err):
                raise Fault(f"status {outcome.status} where an output is an input: {outcome.err}")

    def inputs_of(self, command):
        """Names of the materials that a good call of the command reads."""
        words = [str(word).removeprefix("file:") for word in self.commands[command]]
        return sorted({word for word in words if word.startswith(f"{self.made}/") and os.path.exists(word)})

    def onto_any(self, command, name):
        """Each output of a good call takes the place of the input `name` in its folder. A folder of inputs becomes the
        folder of the outputs."""
        with self.attacker.scratch() as folder:
            if self.attacker.attack([*command, *self.commands[command]], folder).status != 0:
                raise Fault("a good call fails")
            outputs = [str(path.relative_to(folder)) for path in sorted(folder.rglob("*")) if path.is_file()]
        if os.path.isdir(name):
            outputs = ["o"]
        for output in outputs[:24]:
            with self.attacker.scratch() as folder:
                place = folder / output
                place.parent.mkdir(parents=True, exist_ok=True)
                if os.path.isdir(name):
                    shutil.copytree(name, place)
                else:
                    shutil.copy(name, place)
                before = fingerprint(place)
                words = [str(word).replace(name, output) if str(word).removeprefix("file:") == name else word
                         for word in self.commands[command]]
                outcome = self.attacker.attack([*command, *words], folder)
                if os.path.isdir(name):
                    for path in place.iterdir():
                        source = os.path.join(name, path.name)
                        if os.path.exists(source) and fingerprint(path) != fingerprint(source):
                            raise Fault(f"{output}/{path.name} was an input, and is another file now")
                elif fingerprint(place) != before:
                    raise Fault(f"{output} was an input, and is another file now")
                elif outcome.status != 2:
                    raise Fault(f"status {outcome.status} where {output} is an input: {outcome.err}")

    # --- standard output that fails ---

    def standard_output(self, share):
        """Of the three ways to fail, every command meets the first one. `share`: only each such case meets the others.
        """
        commands = [self.words(line) for line in PRINTING.strip().splitlines()]
        for number, command in enumerate(commands):
            for how in ("full", "closed", "pipe") if number % share == 0 else ("full",):
                self.attacker.case("standard output", f"{how}: {' '.join(command)}", self.failing_output, command,
                                   how)

    def failing_output(self, command, how):
        with self.attacker.scratch() as folder:
            if how == "full":
                with open("/dev/full", "w") as full:
                    outcome = self.attacker.attack(command, folder, stdout=full)
            elif how == "closed":
                shell = ["sh", "-c", 'exec "$@" >&-', "sh", self.attacker.program(command[0]), *command[1:]]
                done = subprocess.run(shell, cwd=folder, stderr=subprocess.PIPE, text=True, check=False)
                self.attacker.runs += 1
                outcome = done
                outcome.status, outcome.err = done.returncode, done.stderr
            else:
                reader, writer = os.pipe()
                os.close(reader)
                outcome = self.attacker.attack(command, folder, stdout=writer)
                os.close(writer)
            if outcome.status != 1 or outcome.err.count("\n") != 1:
                raise Fault(f"status {outcome.status}, {outcome.err!r}")

    # --- killed at a random moment ---

    def kills(self, count):
        commands = [self.words(line) for line in KILLED_ALSO.strip().splitlines()]
        killed = [tuple(command.split()) for command in KILLED.split(",")]
        commands += [[*command, *self.commands[command]] for command in killed]
        for i in range(count):
            command = commands[i % len(commands)]
            self.attacker.case("kills", f"{i}: {' '.join(map(str, command[:3]))} (seed {self.attacker.seed})",
                               self.kill, command)

    def kill(self, command):
        with self.attacker.scratch() as folder:
            begin = time.monotonic()
            self.attacker.attack(command, folder)
            whole = time.monotonic() - begin
            first = fingerprint(folder / "o")
            many = (folder / "o").is_dir()
            names = sorted(p.name for p in (folder / "o").iterdir()) if many else []
            for path in (folder / "o").iterdir() if many else [folder / "o"]:  # an older run: every file differs
                path.write_bytes(b"old")
            if many:
                (folder / "o" / "mine").write_bytes(b"mine")
            old = fingerprint(folder / "o")
            number = self.random.choice(
                (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL, signal.SIGKILL))
            process = self.attacker.start(command, folder)
            try:
                if self.random.randrange(4):
                    self.wait_for_temporary(process, folder)  # then soon: the exchange takes a moment
                    process.wait(timeout=self.random.random() * 0.01)
                else:
                    process.wait(timeout=self.random.random() * whole * 1.1)
            except subprocess.TimeoutExpired:
                process.send_signal(number)
            process.communicate(timeout=20)
            now = fingerprint(folder / "o")
            if now != old:
                if many:
                    (folder / "o" / "mine").unlink()
                if fingerprint(folder / "o") != first and not (many and self.same_names(folder / "o", names)):
                    raise Fault(f"signal {number} left old and new files mixed")
            left = temporaries(folder)
            if left and number != signal.SIGKILL:
                raise Fault(f"signal {number} left {left[0]}")
            self.attacker.attack(command, folder)  # and removes the files that SIGKILL left

    @staticmethod
    def wait_for_temporary(process, folder):
        end = time.monotonic() + 20
        while process.poll() is None and time.monotonic() < end:
            if any(entry.name.startswith(".selfproj-") for entry in os.scandir(folder)):
                return
            time.sleep(0.0005)

    @staticmethod
    def same_names(folder, names):
        """A whole new run; its report may contain the time."""
        return sorted(p.name for p in folder.iterdir()) == names and all(
            p.read_bytes() != b"old" for p in folder.iterdir())
