"""The whole line for a long time: boards into a ring and over the network, parts, page, Modbus and files, while boards
and programs are ended, killed and started again, and clients are slow, silent and greedy."""
import contextlib
import json
import os
import pathlib
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import traceback

import hostile
from clients import Controller, HostileClients, descriptors, free_port, memory_mib, new_browser
from programs import Fault
from rings import Rings

SMALL_RATE, WIDE_RATE = 1000, 2000  # profiles a second of each board
PATIENCE = 5  # seconds that a good client waits, on a machine that has other work
# How much more memory in MiB and open files a program may have in the last quarter of a round than in the second, the
# least of each: in a long round, and in a short one, in which clients are still coming.
FLAT, SHORT = (8, 8), (50, 40)
LONG_ROUND = 120  # seconds
STALL = 6  # seconds that a program is held up while a board ends, more than socket and ring hold
STARTING = 3  # seconds in which a board may end without a word, as a signal comes before it has begun
SENT = re.compile(r"(\d+) packets, (?:\d+ lost in the full ring|(\d+) datagrams)")


class Line:
    """What a round of a line has counted."""

    def __init__(self):
        self.sent = self.delivered = self.lost = self.parts = 0
        self.lost_last = 0  # what boards sent last, for which the receiver's socket had no room: no later number tells it
        self.pieces = 0  # datagrams of a packet
        self.rounds = self.boards_killed = self.hosts_killed = self.held_up = self.exact_rounds = 0
        self.growth_mib = 0.0
        self.growth_files = 0
        self.answers = 0


class Soak(HostileClients):

    def __init__(self, attacker, made, wide):
        super().__init__(attacker, made, wide)
        self.rings = Rings(attacker, made)
        self.rings.name = f"soak-{os.getpid()}"
        self.rings.file = self.rings.file.with_name(f"selfproj-ring-{self.rings.name}")
        self.rate = WIDE_RATE if wide else SMALL_RATE
        self.seconds = 0
        self.end = 0.0
        self.local = threading.local()  # the programs of a line

    def measure(self, seconds):
        return self.attacker.case("soak", "measure", self.measured, seconds)

    def measured(self, seconds):
        if self.wide:
            self.make_wide()
        self.seconds = seconds
        self.end = time.monotonic() + seconds
        results, faults = {}, []

        def run(name, way):
            try:
                with self.attacker.scratch() as folder, self.none_left():
                    results[name] = way(folder, random.Random(f"{self.attacker.seed} {name}"))
            except Fault as fault:
                faults.append(f"{name}: {fault}")
            except Exception:  # of this script
                faults.append(f"{name}: {traceback.format_exc()}")
            if faults:
                self.end = 0.0

        threads = [threading.Thread(target=run, args=work) for work in (("ring", self.by_ring), ("udp", self.by_udp))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if faults:
            raise Fault("; ".join(faults))
        figures = {"seconds": seconds, "columns": 512 if self.wide else 64, "rate_per_s": self.rate}
        figures |= {name: {key: round(value, 3) for key, value in vars(line).items()} for name, line in results.items()}
        print(json.dumps(figures), flush=True)
        return figures

    # --- boards and programs ---

    def files(self):
        return self.made / ("wide" if self.wide else "parts"), \
            self.made / ("wide-tolerance.yaml" if self.wide else "tolerance.yaml")

    @contextlib.contextmanager
    def none_left(self):
        """Programs that a fault has left running are killed."""
        self.local.programs = []
        try:
            yield
        finally:
            for program in self.local.programs:
                if program.poll() is None:
                    program.kill()
                    program.communicate()

    def start(self, words, folder):
        self.local.programs = [one for one in self.local.programs if one.poll() is None]
        self.local.programs.append(self.attacker.start(words, folder))
        return self.local.programs[-1]

    def board(self, folder, *to):
        parts, _ = self.files()
        words = ["selfproj-sim", "board", "--replay", f"{parts}.bin", "--rate", self.rate, "--loop", *to]
        return self.start(words, folder)

    def host(self, folder, number, page, modbus, *device):
        parts, tolerance = self.files()
        return self.start(["selfproj", "inspect", "--rig", f"{parts}.yaml", *device, "--tolerance", tolerance,
                           "--parts", f"parts-{number}", "--keep-parts", "4", "--json", f"{number}.json",
                           "--live", page, "--modbus", modbus], folder)

    @staticmethod
    def ended(process, how, what):
        """Ends a program. Returns what it has printed."""
        process.send_signal(how)
        try:
            out, err = process.communicate(timeout=30)
        except Exception:
            process.kill()
            process.communicate()
            raise Fault(f"{what} does not end on signal {how}") from None
        if process.returncode not in ((-how,) if how == signal.SIGKILL else (0, -how)):
            raise Fault(f"{what}: status {process.returncode}: {err.decode(errors='replace')[-300:]}")
        return out.decode(errors="replace")

    def play(self, line, chance, seconds, kills, start_board, host, page, modbus):
        """Boards one after the other, and good clients beside, until the round ends. Returns the packets of the boards
        that said how many they had sent, and how many boards were killed."""
        until = min(time.monotonic() + seconds, self.end)
        begin, sent, killed = time.monotonic(), 0, 0
        least = {}  # memory and open files, by quarter
        controller = None
        while time.monotonic() < until:
            board, started = start_board(), time.monotonic()
            board_until = min(until, time.monotonic() + chance.uniform(0.1, 0.4) * seconds)
            while time.monotonic() < board_until:
                if host.poll() is not None:
                    raise Fault(f"the program has ended: {host.communicate()[1].decode(errors='replace')[-300:]}")
                try:
                    controller = controller or Controller(modbus)
                    asked = controller.ask()[1]
                    if asked > PATIENCE or new_browser(page) > PATIENCE:
                        raise Fault("a good client waits for too long")
                    line.answers += 1
                except ConnectionRefusedError:  # the program is still starting
                    controller = None
                time.sleep(0.1)
                quarter = int(4 * (time.monotonic() - begin) / seconds)
                now = memory_mib(host.pid), descriptors(host.pid)
                least[quarter] = tuple(map(min, now, least.get(quarter, now)))
            held_up = self.wide and chance.random() < 0.3
            if held_up:
                host.send_signal(signal.SIGSTOP)
                time.sleep(STALL)
            if kills and chance.random() < 0.5:
                self.ended(board, signal.SIGKILL, "a board")
                killed += 1
            else:
                out = self.ended(board, chance.choice((signal.SIGINT, signal.SIGTERM)), "a board")
                said = SENT.search(out)
                if said is None and time.monotonic() - started > STARTING:
                    raise Fault(f"a board does not say what it has sent: {out[-300:]!r}")
                packets, datagrams = said.groups() if said else (0, None)
                sent += int(packets)
                if datagrams and int(packets):
                    line.pieces = int(datagrams) // int(packets)
            if held_up:
                host.send_signal(signal.SIGCONT)
                line.held_up += 1
        line.boards_killed += killed
        if controller is None:
            raise Fault("the Modbus server never answered")
        if 1 in least and 3 in least:
            growth, files = (after - before for before, after in zip(least[1], least[3]))
            line.growth_mib = max(line.growth_mib, growth)
            line.growth_files = max(line.growth_files, files)
            most = FLAT if seconds >= LONG_ROUND else SHORT
            if growth > most[0] or files > most[1]:
                raise Fault(f"{growth:.1f} MiB and {files} open files more at the end of a round of {seconds:.0f} s")
        return sent, killed

    def end_of_round(self, line, folder, number, host):
        """Ends the program or kills it; checks its files. Returns its counters, or nothing if it was killed."""
        how = (signal.SIGTERM, signal.SIGINT, signal.SIGKILL)[number % 3]
        self.ended(host, how, "the program")
        line.rounds += 1
        lines = (folder / f"parts-{number}" / "parts.jsonl").read_bytes().split(b"\n")
        numbers = [json.loads(text)["part"] for text in lines[:-1]]
        if numbers != list(range(1, len(numbers) + 1)) or (lines[-1] and how != signal.SIGKILL):
            raise Fault(f"parts.jsonl of round {number} is not whole")
        line.parts += len(numbers)
        if how == signal.SIGKILL:
            line.hosts_killed += 1
            return None
        counters = json.loads((folder / f"{number}.json").read_text())
        if counters["parts"] != len(numbers):
            raise Fault(f"{len(numbers)} lines of {counters['parts']} parts in round {number}")
        return counters

    @contextlib.contextmanager
    def clients(self, page, modbus):
        """Two of each kind, who come again when the program does."""
        words = [f"{kind}=2" for kind in (*hostile.PAGE, *hostile.MODBUS)]
        process = subprocess.Popen([sys.executable, hostile.__file__, str(page), str(modbus), *words],
                                   stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
        try:
            yield
        finally:
            process.kill()
            process.communicate()

    def seconds_of_round(self):
        return min(900, self.seconds / 8)

    # --- through a ring: every packet in it is read by a reader that lives, or was by one that was killed ---

    def by_ring(self, folder, chance):
        line = Line()
        page, modbus = free_port(), free_port()
        device = ["--device", f"ring:{self.rings.name}"]
        self.rings.clear()
        try:
            self.ended(self.first_board(folder), signal.SIGINT, "a board")
            killed = reported = lost = 0
            number = 0
            with self.clients(page, modbus):
                while time.monotonic() < self.end - self.seconds_of_round() / 2:
                    number += 1
                    read = self.rings.header()["read"]
                    host = self.host(folder, number, page, modbus, *device, "--wait-for-board")
                    self.play(line, chance, self.seconds_of_round(), number % 2 == 0,
                              lambda: self.board(folder, "--ring", self.rings.name, "--keep"), host, page, modbus)
                    counters = self.end_of_round(line, folder, number, host)
                    if counters is None:
                        killed += self.rings.header()["read"] - read
                    else:
                        line.exact_rounds += 1
                        reported += counters["delivered"] + counters["bad"] + counters["repeated"]
                        lost += counters["lost_ring"]
            last = self.drained(device)
            reported += last["delivered"] + last["bad"] + last["repeated"]
            lost += last["lost_ring"]
            header = self.rings.header()
            line.sent, line.delivered, line.lost = header["written"] + header["lost"], reported + killed, lost
            if reported + killed != header["written"] or header["read"] != header["written"]:
                raise Fault(f"{header['written']} packets in the ring, {header['read']} read, {reported} reported and "
                            f"{killed} by programs that were killed")
            if lost != header["lost"]:
                raise Fault(f"{header['lost']} lost in the ring, {lost} reported")
        finally:
            self.rings.clear()
        return line

    def first_board(self, folder):
        """Makes the ring."""
        board = self.board(folder, "--ring", self.rings.name, "--keep", "--slots", "4096")
        self.rings.wait_for_ring()
        return board

    def drained(self, device):
        """What a last reader counts, without a board."""
        parts, _ = self.files()
        with self.attacker.scratch() as folder:
            self.good(["selfproj", "inspect", "--rig", f"{parts}.yaml", *device, "--json", "last.json"], folder)
            return json.loads((folder / "last.json").read_text())

    # --- over the network: a program that listens all along delivers each packet, or counts it as lost ---

    def by_udp(self, folder, chance):
        line = Line()
        page, modbus = free_port(), free_port()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        number = 0
        with self.clients(page, modbus):
            while time.monotonic() < self.end - self.seconds_of_round() / 2:
                number += 1
                host = self.host(folder, number, page, modbus, "--device", f"udp:127.0.0.2:{port}", "--control", "none")
                self.wait_for_port(port, host)
                sent, killed = self.play(
                    line, chance, self.seconds_of_round(), number % 2 == 0,
                    lambda: self.board(folder, "--udp", f"127.0.0.1:{port}", "--from", "127.0.0.2"), host, page, modbus)
                dropped = self.drained_socket(port)
                counters = self.end_of_round(line, folder, number, host)
                if counters is None:
                    continue
                got = counters["delivered"] + counters["bad"]
                lost = counters["lost_network"]
                line.delivered += got
                line.lost += lost
                # Datagrams that the kernel dropped or the program refused, and no gap in the numbers shows.
                unseen = dropped - counters["datagrams_lost"] + counters["datagrams_refused"]
                last = max(0, sent - got - lost)
                account = (f"{sent} packets sent, {got} delivered, {lost} lost; the socket had no room for {dropped} "
                           f"datagrams, {counters['datagrams_lost']} of which are told, "
                           f"{counters['datagrams_refused']} were refused")
                if last > 0 and last * line.pieces > unseen:
                    raise Fault(account)
                line.lost_last += last
                if killed == 0:
                    line.exact_rounds += 1
                    line.sent += sent
                    if got + lost + last != sent:
                        raise Fault(account)
                else:  # nobody knows how many a board had sent that was killed
                    line.sent += got + lost + last
        return line

    @staticmethod
    def drained_socket(port):
        """Waits until the program has read all that has come. Returns the datagrams for which there was no room."""
        end = time.monotonic() + 120
        while True:
            sockets = [line.split() for line in pathlib.Path("/proc/net/udp").read_text().splitlines()
                       if f":{port:04X} " in line]
            if all(one[4].endswith(":00000000") for one in sockets):
                break
            if time.monotonic() > end:
                raise Fault("the program does not read its socket")
            time.sleep(0.02)
        time.sleep(0.5)  # for what it has read
        return sum(int(one[-1]) for one in sockets)

    @staticmethod
    def wait_for_port(port, host):
        end = time.monotonic() + 20
        while f":{port:04X} " not in pathlib.Path("/proc/net/udp").read_text():
            if time.monotonic() > end or host.poll() is not None:
                raise Fault("the program does not listen")
            time.sleep(0.02)
