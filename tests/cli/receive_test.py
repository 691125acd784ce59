#!/usr/bin/env python3
"""Every command that receives packets, with every option of a device.

    receive_test.py PROGRAMS MAKE_PARTS MAKE_DEPTH_PARTS

The makers write rigs and packets of good parts, for a light section and for a scanner.
"""

import concurrent.futures
import contextlib
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = MAKE_PARTS = MAKE_DEPTH_PARTS = None

SECTION = ("--rig", "section/rig.yaml")
SCANNER = ("--rig", "scanner/rig.yaml", "--reference", "scanner/reference")

# Name: its words without a device, its recording, what --count counts, and the number of these in its output. A learner
# prints good parts only.
COMMANDS = {
    "record": (("record", "--out", "out"), "section", "packets", r"^(\d+) packets"),
    "images": (("images", "--out", "out"), "scanner", "images", r"(\d+) code images"),
    "inspect": (("inspect", *SECTION), "section", "profiles", r"^(\d+) profiles"),
    # The recording is of self-projected patterns, whose codes alone do not run as the geometry says.
    "depth": (("depth", *SCANNER[:2], "--bits", "4", "--unchecked", "--out", "out"), "scanner", "depth images", r"^(\d+) depth images"),
    "match": (("match", *SCANNER, "--e", "4", "--out", "out"), "scanner", "depth images", r"^(\d+) depth images"),
    "learn": (("tolerance", "learn", *SECTION, "--out", "out"), "section", "profiles or depth images", None),
    "learn-scanner": (("tolerance", "learn", *SCANNER, "--e", "4", "--out", "out"), "scanner",
                      "profiles or depth images", None),
}


class Command:
    """One of the commands in a folder of its own. What fails names it."""

    def __init__(self, name, data, folder):
        self.name, self.folder = name, folder
        self.words, kind, self.things, self.number = COMMANDS[name]
        self.recording, self.damaged = f"{kind}/good.packets", f"{kind}/damaged.packets"
        self.ring = f"receive-{os.getpid()}-{name}"
        folder.mkdir()
        for kind in ("section", "scanner"):
            (folder / kind).symlink_to(data / kind)
        shutil.copy(data / "section" / "bar", folder / "bar")

    def start(self, *words, program="selfproj"):
        return subprocess.Popen([PROGRAMS / program, *words], cwd=self.folder, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def end(self, process, status=0):
        text = "".join(process.communicate(timeout=60))
        assert process.returncode == status, f"{self.name}: status {process.returncode}, not {status}: {text}"
        out = self.folder / "out"
        shutil.rmtree(out) if out.is_dir() else out.unlink(missing_ok=True)
        return text

    def run(self, *words, status=0):
        return self.end(self.start(*words), status)

    def receive(self, device, *more, status=0):
        return self.run(*self.words, "--device", device, *more, status=status)

    def says(self, pattern, text):
        found = re.search(pattern, text)
        assert found, f"{self.name}: {pattern} is not in: {text}"
        return found

    def made(self, text):
        return int(self.says(self.number, text).group(1))

    def board(self, *more):
        """Plays the recording into the ring."""
        return self.start("board", "--replay", self.recording, "--ring", self.ring, *more, program="selfproj-sim")

    @contextlib.contextmanager
    def from_pipe(self, *more):
        """The command at a pipe that stays open in the context: the process, when the recording has gone into it."""
        fifo = self.folder / "pipe"
        fifo.unlink(missing_ok=True)
        os.mkfifo(fifo)
        process = self.start(*self.words, "--device", "file:pipe", *more)
        with open(fifo, "wb", buffering=0) as pipe:
            with contextlib.suppress(BrokenPipeError):  # the command has ended before
                pipe.write((self.folder / self.recording).read_bytes())
            yield process


class Receive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.data = pathlib.Path(cls.scratch.name)
        for name, maker in (("section", MAKE_PARTS), ("scanner", MAKE_DEPTH_PARTS)):
            (cls.data / name).mkdir()
            subprocess.run([maker, cls.data / name], check=True)
            packets = (cls.data / name / "good.packets").read_bytes()
            middle = len(packets) // 2
            damaged = packets[:middle] + bytes([packets[middle] ^ 1]) + packets[middle + 1:]
            (cls.data / name / "damaged.packets").write_bytes(damaged)
        cls.commands = [Command(name, cls.data, cls.data / name) for name in COMMANDS]

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def each(self, check):
        """Calls `check` with each command, all at once: they wait a lot."""
        with concurrent.futures.ThreadPoolExecutor(len(self.commands)) as pool:
            for done in [pool.submit(check, command) for command in self.commands]:
                done.result()

    def test_count_and_check(self):
        def check(command):
            device = f"file:{command.recording}"
            whole = command.receive(device, "--check")
            missing = command.receive(device, "--check", "--count", "1000000", status=1)
            all_of_them = int(command.says(rf"--check: (\d+) {command.things} of 1000000, 0 faults", missing).group(1))
            if command.number is None:
                command.says("good parts came; at least 5", command.receive(device, "--count", "4", status=2))
                return
            assert command.made(whole) == all_of_them, command.name
            some = command.made(command.receive(device, "--check", "--count", str(all_of_them - 1)))
            assert some == all_of_them - 1, command.name

        self.each(check)

    def test_check_refuses_what_is_damaged(self):
        def check(command):
            command.receive(f"file:{command.damaged}")
            text = command.receive(f"file:{command.damaged}", "--check", status=1)
            command.says(rf"--check: \d+ {command.things}, [1-9]\d* faults", text)

        self.each(check)

    def test_seconds(self):
        def check(command):
            with command.from_pipe("--seconds", "2", "--check") as process:
                command.end(process)  # although the pipe is still open

        self.each(check)

    def test_wait(self):
        def check(command):
            for how in ("poll", "block", "poll-then-block"):
                command.receive(f"file:{command.recording}", "--wait", how, "--check")
            command.says("--wait: is 'sleep'", command.receive("file:x", "--wait", "sleep", status=2))

        self.each(check)

    def test_control_c(self):
        def check(command):
            with command.from_pipe() as process:
                process.send_signal(signal.SIGINT)
                text = command.end(process)
            assert command.number is None or command.made(text) > 0, text

        self.each(check)

    def test_silence_is_said(self):
        def check(command):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                probe.bind(("127.0.0.1", 0))
                device = f"udp:127.0.0.1:{probe.getsockname()[1]}"
            process = command.start(*command.words, "--device", device, "--control", "none")
            command.says(f"selfproj: {device}: no packet for a second: .*firewall", process.stderr.readline())
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)

        self.each(check)

    def test_wait_for_board(self):
        def check(command):
            device = f"ring:{command.ring}"
            command.says("no such ring", command.receive(device, status=2))
            process = command.start(*command.words, "--device", device, "--wait-for-board", "--seconds", "6", "--check")
            command.end(command.board("--wait-for-reader", "--rate", "4000"))
            command.end(process)

        self.each(check)

    def test_newest(self):
        def check(command):
            command.end(command.board("--rate", "0", "--keep"))
            process = command.start(*command.words, "--device", f"ring:{command.ring}", "--newest", "--check")
            text = "".join(process.communicate(timeout=60))
            command.says(rf"no packet came|no complete image came|--check: 0 {command.things}|delivered no|"
                         "0 good parts came", text)
            command.run("devices", "--remove", command.ring)

        self.each(check)

    def test_control(self):
        def check(command):
            device = f"file:{command.recording}"
            status = ("board", "status", "--device", "bar:bar")
            command.receive(device, "--control", "none")
            command.says("bar:nowhere: ", command.receive(device, "--control", "bar:nowhere", status=2))
            command.says("run=0", command.run(*status))
            with command.from_pipe("--control", "bar:bar") as process:
                command.says("run=1", command.run(*status))
            command.end(process)
            command.says("run=0", command.run(*status))

        self.each(check)

    def test_images_take_no_device(self):
        values = {"--count": "1", "--seconds": "1", "--control": "none", "--wait": "poll", "--save": "1"}
        parts = {"--tolerance": "t", "--parts": "p", "--keep-parts": "1", "--modbus": "1502", "--live": "8080"}
        flags = ("--check", "--newest", "--wait-for-board")

        def check(command):
            for option in (*values, *flags, *(parts if command.name == "match" else ())):
                value = {**values, **parts}.get(option)
                more = (option,) if value is None else (option, value)
                command.says(f"{option}: goes only with --device", command.run(*command.words, *more, "a.png", status=2))

        for command in self.commands:
            if command.name in ("depth", "match"):
                check(command)


if __name__ == "__main__":
    PROGRAMS, MAKE_PARTS, MAKE_DEPTH_PARTS = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
