"""Attacks on a running line by clients of its page and Modbus server that are slow, silent or greedy."""
import contextlib
import json
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import time

import hostile
import materials
from programs import Fault, Part

REGISTERS = 21
SOON = 1.0  # a new browser and a new controller are served within so many seconds
END = 2.0  # and the program ends after Ctrl-C
LATE_MS = 50
GROWTH_MIB = 50
RATE = 10000  # profiles a second, of the rig's real size
SMALL_RATE = 1000  # of small ones, with many parts
CLIENTS = 100


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return taken.getsockname()[1]


def all_of(client, count):
    data = b""
    while len(data) < count:
        more = client.recv(count - len(data))
        if not more:
            raise Fault("a good client is closed")
        data += more
    return data


class Controller:
    """A good one, which stays connected."""

    def __init__(self, port):
        self.client = socket.create_connection(("127.0.0.1", port), timeout=5)

    def ask(self):
        """The number of the last part, and how long the answer took."""
        begin = time.monotonic()
        self.client.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 0, REGISTERS))
        answer = all_of(self.client, 9 + 2 * REGISTERS)
        return struct.unpack_from(">I", answer, 15)[0], time.monotonic() - begin


def new_controller(port):
    begin = time.monotonic()
    controller = Controller(port)
    controller.ask()
    controller.client.close()
    return time.monotonic() - begin


def new_browser(port):
    """Seconds until a browser that comes now has the page and the first message of its stream."""
    begin = time.monotonic()
    for path, least in (("/", 1000), ("/stream", 100)):
        with socket.create_connection(("127.0.0.1", port), timeout=5) as client:
            client.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
            answer = all_of(client, least)
            if not answer.startswith(b"HTTP/1.1 200 "):
                raise Fault(f"no {path} for a new browser: {answer}")
    return time.monotonic() - begin


def memory_mib(pid):
    """The program's own memory, without the ring that it shares with the board."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"^RssAnon:\s+(\d+) kB", status, re.M)[1]) / 1024


def descriptors(pid):
    return len(os.listdir(f"/proc/{pid}/fd"))


class HostileClients(Part):

    def __init__(self, attacker, made, wide):
        """`wide`: the profiles have 512 columns, not 64."""
        super().__init__(attacker, made)
        self.wide = wide

    def first(self):
        """The line with real-time priority, if the system allows it, as docs/parts.md says: the clients run on the same
        machine, which on a real line they do not. Its threads that serve clients do not inherit it."""
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
        except OSError:
            pass

    @contextlib.contextmanager
    def line(self, folder, rate):
        """A board and the program with page and Modbus server; yields the program and the two ports."""
        page, modbus, ring = free_port(), free_port(), f"clients-{os.getpid()}"
        parts = self.made / ("wide" if self.wide else "parts")
        tolerance = self.made / ("wide-tolerance.yaml" if self.wide else "tolerance.yaml")
        board = self.attacker.start(["selfproj-sim", "board", "--replay", f"{parts}.bin", "--ring", ring, "--rate",
                                     rate, "--loop", "--wait-for-reader"], folder, preexec_fn=self.first)
        host = self.attacker.start(["selfproj", "inspect", "--rig", f"{parts}.yaml", "--device", f"ring:{ring}",
                                    "--wait-for-board", "--tolerance", tolerance, "--parts", "parts", "--keep-parts",
                                    "4", "--json", "o.json", "--live", page, "--modbus", modbus], folder,
                                   preexec_fn=self.first)
        try:
            host.stderr.readline()  # the page's address
            end = time.monotonic() + 20
            while True:
                with contextlib.suppress(OSError):
                    if Controller(modbus).ask()[0] > 0:
                        break
                if time.monotonic() > end:
                    raise Fault("no part comes")
                time.sleep(0.05)
            yield host, page, modbus
        finally:
            board.send_signal(signal.SIGINT)
            board.communicate()
            host.kill()
            host.communicate()
            pathlib.Path(f"/dev/shm/selfproj-ring-{ring}").unlink(missing_ok=True)

    @contextlib.contextmanager
    def hostile(self, page, modbus, kinds):
        if not kinds:
            yield
            return
        words = [f"{kind}={count}" for kind, count in kinds.items()]
        process = subprocess.Popen([sys.executable, hostile.__file__, str(page), str(modbus), *words],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        try:
            process.stdout.readline()  # all are here
            yield
        finally:
            process.kill()
            process.communicate()

    @staticmethod
    def end(host, how):
        begin = time.monotonic()
        host.send_signal(how)
        try:
            host.wait(20)
        except subprocess.TimeoutExpired:
            raise Fault(f"does not end on signal {how}") from None
        seconds = time.monotonic() - begin
        if seconds > END:
            raise Fault(f"ends {seconds:.1f} s after the signal")
        if host.returncode not in (0, -how):
            raise Fault(f"status {host.returncode}")
        return seconds

    # --- one kind of clients after the other ---

    def run(self, count):
        kinds = [*hostile.PAGE, *hostile.MODBUS]
        self.random.shuffle(kinds)
        for kind in kinds[:count]:
            self.attacker.case("clients", kind, self.of_kind, kind)

    def of_kind(self, kind):
        with self.attacker.scratch() as folder, self.line(folder, SMALL_RATE) as (host, page, modbus):
            with self.hostile(page, modbus, {kind: CLIENTS}):
                time.sleep(1)
                for name, seconds in (("browser", new_browser(page)), ("controller", new_controller(modbus))):
                    if seconds > SOON:
                        raise Fault(f"a new {name} waits for {seconds:.1f} s")
                self.end(host, self.random.choice((signal.SIGINT, signal.SIGTERM)))

    # --- all kinds at once, and what it costs ---

    def measure(self, seconds):
        return self.attacker.case("hostile clients", "measure", self.measured, seconds)

    def measured(self, seconds):
        """The line alone, then with hostile clients. A machine on which the line alone loses or is late cannot tell."""
        if self.wide:
            self.make_wide()
        kinds = [*hostile.PAGE, *hostile.MODBUS]
        alone = self.figures_of(seconds, {})
        if self.wrong(alone):
            raise Fault(f"the line alone, without a hostile client: {self.wrong(alone)}; the machine has other work")
        figures = self.figures_of(
            seconds, {kind: CLIENTS // len(kinds) + (i < CLIENTS % len(kinds))
                      for i, kind in enumerate(kinds)})
        if self.wrong(figures):
            raise Fault(self.wrong(figures))
        return {"alone": alone, "attacked": figures}

    def wrong(self, figures):
        for wrong, what in ((figures["lost"], f"{figures['lost']} packets lost"),
                            (figures["profiles"] < 0.9 * figures["rate_per_s"] * figures["seconds"],
                             f"only {figures['profiles']} profiles"),
                            (self.wide and figures["delay_max_ms"] > LATE_MS,
                             f"a profile is {figures['delay_max_ms']} ms late"),
                            (figures["memory_more_mib"] > GROWTH_MIB, f"{figures['memory_more_mib']} MiB more memory"),
                            (figures["browser_s"] > SOON, f"a new browser waits for {figures['browser_s']} s"),
                            (figures["controller_s"] > SOON, f"a new controller waits for {figures['controller_s']} s"),
                            (figures["answer_s"] > SOON, f"a controller waits for {figures['answer_s']} s")):
            if wrong:
                return what
        return None

    def figures_of(self, seconds, counts):
        rate = RATE if self.wide else SMALL_RATE
        with self.attacker.scratch() as folder, self.line(folder, rate) as (host, page, modbus):
            stays = Controller(modbus)
            new_browser(page)
            before, files = memory_mib(host.pid), descriptors(host.pid)
            figures = {"browser_s": 0, "controller_s": 0, "answer_s": 0, "memory_mib": before, "descriptors": files}
            with self.hostile(page, modbus, counts):
                end = time.monotonic() + seconds
                while time.monotonic() < end:
                    time.sleep(0.2)
                    for name, value in (("browser_s", new_browser(page)), ("controller_s", new_controller(modbus)),
                                        ("answer_s", stays.ask()[1]), ("memory_mib", memory_mib(host.pid)),
                                        ("descriptors", descriptors(host.pid))):
                        figures[name] = max(figures[name], value)
                real_time = os.sched_getscheduler(host.pid) == os.SCHED_FIFO
                figures["end_s"] = self.end(host, signal.SIGINT)
            counters = json.loads((folder / "o.json").read_text())
        lost = sum(counters[key] for key in ("lost_board", "lost_ring", "missing", "bad"))
        figures |= {
            "clients": sum(counts.values()),
            "seconds": seconds,
            "columns": 512 if self.wide else 64,
            "rate_per_s": rate,
            "profiles": counters["profiles"],
            "parts": counters["parts"],
            "lost": lost,
            "delay_max_ms": counters["delay_max_us"] / 1000,
            "result_delay_p99_ms": counters["result_delay_p99_ms"],
            "memory_before_mib": before,
            "memory_more_mib": figures["memory_mib"] - before
        }
        figures = {key: round(value, 3) for key, value in figures.items()} | {"real_time": real_time}
        print(json.dumps(figures), flush=True)
        return figures

    def make_wide(self):
        """Two parts of a line in its real size, three times; each passes in 300 profiles."""
        if (self.made / "wide-tolerance.yaml").exists():
            return
        rig = self.attacker.run(["selfproj", "rig", "light-section"], self.made).out
        (self.made / "wide.yaml").write_text(rig + materials.PARTS.replace("length_mm: 12", "length_mm: 30"))
        empty, part = [0.0] * 100, [0.0] * 34 + [0.8] * 32 + [0.0] * 34
        rows = 2 * ([empty] * 10 + [part] * 20)  # of 1 mm
        (self.made / "two.tiff").write_bytes(materials.tiff(rows, floats=True))
        self.good("selfproj-sim scene render --height-map two.tiff --mm-per-pixel 1 --rig wide.yaml --out two".split(),
                  self.made, patience=300)
        frames = sorted((self.made / "two").glob("frame_*.png"))
        packets = "selfproj-sim cosim --engine model --rig wide.yaml --packets wide.bin --frames"
        self.good([*packets.split(), *frames * 3], self.made, patience=300)
        self.good("selfproj tolerance learn --device file:wide.bin --rig wide.yaml --out wide-tolerance.yaml".split(),
                  self.made)
