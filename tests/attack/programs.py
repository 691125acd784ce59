"""Runs the programs under attack, and checks the rules for every run."""
import contextlib
import dataclasses
import hashlib
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import tempfile

MEMORY = 4 << 30  # address space in bytes that a run may take
PATIENCE = 20  # seconds; a run that takes longer is asked to end (SIGTERM)


class Fault(Exception):
    """A program broke a rule."""


@dataclasses.dataclass
class Outcome:
    status: int
    out: str
    err: str
    asked: bool  # the program was asked to end


def words(text, made):
    """The words of a command. In `text`, {m} is the folder of the materials, {frames} are four frames of a line of
    light, {seen} the first four images of a sequence of Gray codes, and {views} one image of each of the chessboard's
    poses."""
    groups = {
        "{frames}": lambda: [made / f"frame_{i}.png" for i in range(1, 5)],
        "{seen}": lambda: sorted((made / "seen").iterdir())[:4],
        "{views}": lambda: [sorted(pose.iterdir())[0] for pose in sorted((made / "views").glob("pose_*"))]
    }
    found = []
    for word in text.split():
        found += map(str, groups[word]()) if word in groups else [word.replace("{m}", str(made))]
    return found


def limits(memory):
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def fingerprint(path):
    path = pathlib.Path(path)
    if path.is_file():
        return hashlib.sha256(path.read_bytes()).hexdigest()
    if path.is_dir():
        return json.dumps([[str(p.relative_to(path)), fingerprint(p)] for p in sorted(path.rglob("*")) if p.is_file()
                          ])
    return None


def temporaries(folder):
    return sorted(str(p) for p in pathlib.Path(folder).rglob(".selfproj-*"))


class Attacker:
    """The programs are in `programs`; all files are below `work`. `screen`: there is a display."""

    def __init__(self, programs, work, seed, screen):
        self.programs = pathlib.Path(programs)
        self.work = pathlib.Path(work)
        self.random = random.Random(seed)
        self.seed = seed
        self.screen = screen
        self.runs = 0
        self.faults = []
        self.cases = {}
        self.memory = MEMORY

    def program(self, name):
        return str(self.programs / name)

    def start(self, arguments, folder, **more):
        """Starts a program; `arguments` begin with its name."""
        self.runs += 1
        words = [self.program(arguments[0])] + [str(a) for a in arguments[1:]]
        pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **more}
        also = pipes.pop("preexec_fn", lambda: None)
        return subprocess.Popen(words, cwd=folder, preexec_fn=lambda: (limits(self.memory), also()), **pipes)

    def run(self, arguments, folder, patience=PATIENCE, **more):
        process = self.start(arguments, folder, **more)
        asked = False
        try:
            out, err = process.communicate(timeout=patience)
        except subprocess.TimeoutExpired:
            asked = True
            process.send_signal(signal.SIGTERM)
            try:
                out, err = process.communicate(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
                raise Fault(f"does not end on SIGTERM: {' '.join(map(str, arguments))}") from None
        text = [(part or b"").decode(errors="replace") for part in (out, err)]
        return Outcome(process.returncode, text[0], text[1], asked)

    def check_rules(self, outcome, arguments, folder):
        """Checks the rules for every run: no signal, a defined status, one line for an error, nothing left behind."""
        what = " ".join(repr(str(a)) if " " in str(a) or not str(a) else str(a) for a in arguments)
        if outcome.status < 0 and not (outcome.asked and outcome.status == -signal.SIGTERM):
            raise Fault(f"ended by signal {-outcome.status}: {what}")
        if outcome.status not in (0, 1, 2) and not outcome.asked:
            raise Fault(f"status {outcome.status}: {what}")
        lines = outcome.err.rstrip("\n").count("\n") + 1 if outcome.err else 0
        if outcome.status in (1, 2) and (lines != 1 or not outcome.err.startswith(str(arguments[0]) + ": ")):
            raise Fault(
                f"status {outcome.status} with {lines} lines on standard error: {what}: {outcome.err[:300]!r}")
        left = temporaries(folder)
        if left:
            raise Fault(f"left behind {left[0]}: {what}")

    def attack(self, arguments, folder, inputs=(), patience=PATIENCE, **more):
        """Runs a program, checks the rules, and checks that the inputs are unchanged."""
        before = [fingerprint(path) for path in inputs]
        outcome = self.run(arguments, folder, patience, **more)
        self.check_rules(outcome, arguments, folder)
        for path, was in zip(inputs, before):
            if fingerprint(path) != was:
                raise Fault(f"changed its input {path}: {' '.join(map(str, arguments))}")
        return outcome

    def case(self, part, name, function, *arguments):
        """Runs one case of a part. A fault is noted, and the next case follows."""
        count = self.cases.setdefault(part, {"cases": 0, "faults": 0})
        count["cases"] += 1
        try:
            return function(*arguments)
        except Fault as fault:
            count["faults"] += 1
            self.faults.append(f"{part}: {name}: {fault}")
            print(f"attack: {part}: {name}: {fault}", flush=True)
            return None

    @contextlib.contextmanager
    def scratch(self):
        """An empty folder for one case."""
        path = pathlib.Path(tempfile.mkdtemp(dir=self.work))
        try:
            yield path
        finally:
            for folder, _, _ in os.walk(path):
                os.chmod(folder, 0o700)
            shutil.rmtree(path, ignore_errors=True)


class Part:
    """Cases of one kind against the programs of `attacker`, with the materials in the folder `made`."""

    def __init__(self, attacker, made):
        self.attacker = attacker
        self.made = made
        self.random = attacker.random

    def words(self, text):
        return words(text, self.made)

    def said_of_commands(self, folder):
        """What --help-json says of every command of both programs."""
        return [command for program in ("selfproj", "selfproj-sim")
                for command in json.loads(self.attacker.run([program, "--help-json"], folder).out)]

    def good(self, command, folder, **more):
        """Runs a command that must succeed."""
        outcome = self.attacker.attack(command, folder, **more)
        if outcome.status != 0:
            raise Fault(f"status {outcome.status}: {' '.join(map(str, command))}: {outcome.err!r}")
        return outcome
