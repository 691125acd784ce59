"""Attacks on rings: damaged headers, and readers and boards that are killed and restarted, with an exact account of
every packet."""
import json
import os
import pathlib
import signal
import struct
import time

from programs import Fault, Part

FOLDER = pathlib.Path("/dev/shm")
# Offsets of host/driver/ring_memory.h.
WRITTEN, LOST, READ, READERS = 64, 72, 128, 144
WORDS = (0, 8, 12, 16, 20, 64, 72, 80, 84, 88, 92, 128, 136, 144, 148, 152, 156, 192, 196)


class Rings(Part):

    def __init__(self, attacker, made):
        super().__init__(attacker, made)
        self.name = f"attack-{os.getpid()}"
        self.file = FOLDER / f"selfproj-ring-{self.name}"

    def board(self, *more):
        return self.words(f"selfproj-sim board --line 64x16 --line-frames 20 --ring {self.name}") + list(more)

    def reader(self, *more):
        return self.words(f"selfproj inspect --device ring:{self.name} --rig {{m}}/rig.yaml") + list(more)

    def clear(self):
        self.file.unlink(missing_ok=True)

    def header(self):
        with open(self.file, "rb") as file:
            data = file.read(256)
        return {
            key: struct.unpack_from(kind, data, at)[0]
            for key, kind, at in (("written", "<Q", WRITTEN), ("lost", "<Q", LOST), ("read", "<Q", READ),
                                  ("readers", "<I", READERS))
        }

    # --- evil headers ---

    def repeat(self, part, count, function):
        for i in range(count):
            self.attacker.case(part, f"{i} (seed {self.attacker.seed})", function)
        self.clear()

    def evil(self):
        self.clear()
        with self.attacker.scratch() as folder:
            self.attacker.attack(self.board("--keep", "--slots", "16", "--count", "40", "--rate", "0"), folder)
            what = self.random.randrange(4)
            with open(self.file, "r+b") as file:
                if what < 3:
                    for _ in range(self.random.choice((1, 1, 2, 5))):
                        file.seek(self.random.choice(WORDS) if what else self.random.randrange(256, 20000))
                        file.write(
                            self.random.choice((b"\xff" * 8, b"\0" * 8, os.urandom(8), struct.pack("<Q", 17),
                                                struct.pack("<Q", 1 << 63), b"\xff" * 4)))
                else:
                    file.truncate(self.random.choice((0, 1, 255, 256, 300, 4096, 100000, 1 << 40)))
            outcome = self.attacker.attack(self.reader("--json", "o.json", "--out", "o"), folder)
            if outcome.asked:
                raise Fault("a reader of a damaged ring without a board does not end")
            if outcome.status == 0:
                counts = json.loads((folder / "o.json").read_text())
                wrong = [key for key, value in counts.items() if isinstance(value, int) and value < 0]
                if wrong:
                    raise Fault(f"{wrong[0]} is {counts[wrong[0]]}")
                if counts["profiles"] > 16 or (counts["profiles"] < 16 and
                                               not (counts["bad"] or counts["other_spec"]) and what == 0):
                    raise Fault(f"{counts['profiles']} profiles of 16, {counts['bad']} bad")
            self.attacker.attack(["selfproj", "devices"], folder)
            self.good(self.board("--slots", "16", "--count", "5", "--rate", "0"), folder)  # replaces the damaged ring

    # --- made shorter while both run ---

    def shortened(self):
        self.clear()
        with self.attacker.scratch() as folder:
            board = self.attacker.start(self.board("--slots", "64", "--rate", "2000", "--seconds", "1.5"), folder)
            self.wait_for_ring()
            reader = self.attacker.start(self.reader("--wait-for-board", "--json", "o.json"), folder)
            self.wait_for_reader()
            time.sleep(0.2 * self.random.random())
            os.truncate(self.file, self.random.choice((0, 100, 4096, 100000)))
            board.communicate(timeout=20)
            time.sleep(0.1)
            reader.send_signal(signal.SIGINT)
            reader.communicate(timeout=20)
            if board.returncode != 0 or reader.returncode != 0:
                raise Fault(f"board {board.returncode}, reader {reader.returncode}")
            counts = json.loads((folder / "o.json").read_text())
            if counts["bad"] + counts["lost_ring"] == 0:
                raise Fault("nothing is counted")

    def wait_for_ring(self):
        end = time.monotonic() + 10
        while time.monotonic() < end:
            try:
                with open(self.file, "rb") as file:
                    if file.read(8) == b"SLFPRING":
                        return
            except FileNotFoundError:
                pass
            time.sleep(0.002)
        raise Fault("no ring")

    def wait_for_reader(self):
        end = time.monotonic() + 10
        while self.header()["readers"] == 0:
            if time.monotonic() > end:
                raise Fault("no reader")
            time.sleep(0.002)

    # --- killed and started again ---

    def restarts(self, rounds=5):
        """A board plays. Readers and boards come, are killed or end, and the next one comes. At the end every packet of
        a board was read, or a reader that ended has counted it as lost."""
        self.clear()
        rate = 20000
        reported = {"delivered": 0, "lost_ring": 0, "other": 0}
        killed = 0
        with self.attacker.scratch() as folder:
            for number in range(rounds):
                board = self.attacker.start(
                    self.board("--keep", "--slots", "64", "--rate", str(rate), "--seconds", "30"), folder)
                self.wait_for_ring()
                for _ in range(3):
                    before = self.header()["read"]
                    file = folder / "o.json"
                    file.unlink(missing_ok=True)
                    reader = self.attacker.start(self.reader("--json", "o.json"), folder)
                    time.sleep(0.01 + 0.04 * self.random.random())
                    how = self.random.choice((signal.SIGKILL, signal.SIGINT, signal.SIGTERM))
                    reader.send_signal(how)
                    _, err = reader.communicate(timeout=20)
                    if file.exists():  # it ended by itself
                        self.add(reported, json.loads(file.read_text()))
                    else:
                        killed += self.header()["read"] - before
                        if how != signal.SIGKILL and reader.returncode not in (-how, 0):
                            raise Fault(f"reader: status {reader.returncode}: {err.decode()}")
                board.send_signal(signal.SIGKILL if number % 2 else signal.SIGINT)
                board.communicate(timeout=20)
            self.add(reported, self.counts_of(folder))
        header = self.header()
        if header["read"] != header["written"]:
            raise Fault(f"{header['written']} written, {header['read']} read")
        if reported["delivered"] + reported["other"] + killed != header["written"]:
            raise Fault(f"{header['written']} written, but {reported} and {killed} by readers that were killed")
        if reported["lost_ring"] != header["lost"]:
            raise Fault(f"{header['lost']} lost in the ring, {reported['lost_ring']} reported by readers that ended")

    @staticmethod
    def add(reported, counts):
        reported["delivered"] += counts["delivered"]
        reported["lost_ring"] += counts["lost_ring"]
        reported["other"] += counts["bad"] + counts["repeated"]

    # --- two readers one after the other, a ring that is renewed, a backlog ---

    def accounts(self):
        for name in ("two_readers", "renewed", "backlog"):
            self.attacker.case("accounts", name, getattr(self, name))
            self.clear()

    def counts_of(self, folder, *more):
        self.good(self.reader("--json", "o.json", *more), folder)
        return json.loads((folder / "o.json").read_text())

    def two_readers(self):
        self.clear()
        with self.attacker.scratch() as folder:
            self.attacker.attack(self.board("--keep", "--slots", "64", "--count", "1000", "--rate", "0"), folder)
            first = self.counts_of(folder, "--count", "10")
            second = self.counts_of(folder)
            got = first["delivered"] + second["delivered"] + first["lost_ring"] + second["lost_ring"]
            if got != 1000:
                raise Fault(f"1000 played, {got} accounted for")

    def renewed(self):
        """The board renews its ring with 16,384 slots under a reader that ends with the board."""
        self.clear()
        with self.attacker.scratch() as folder:
            board = self.attacker.start(
                self.board("--slots", "16384", "--rate", "10000", "--count", "12000", "--wait-for-reader"), folder)
            self.wait_for_ring()
            reader = self.attacker.start(self.reader("--json", "o.json"), folder)
            time.sleep(0.4)
            self.attacker.attack(["selfproj", "devices", "--remove", self.name], folder)
            board.communicate(timeout=30)
            reader.communicate(timeout=30)
            counts = json.loads((folder / "o.json").read_text())
            if counts["delivered"] + counts["lost_ring"] != 12000:
                raise Fault(f"12000 played, {counts['delivered']} delivered, {counts['lost_ring']} lost")

    def backlog(self):
        """--seconds counts from the first packet that is taken, not from the time when the board had it."""
        self.clear()
        with self.attacker.scratch() as folder:
            self.attacker.attack(self.board("--keep", "--slots", "64", "--count", "60", "--rate", "0"), folder)
            time.sleep(1.2)
            counts = self.counts_of(folder, "--seconds", "1")
            if counts["profiles"] != 60:
                raise Fault(f"{counts['profiles']} of 60 packets")
