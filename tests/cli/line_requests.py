#!/usr/bin/env python3
"""Checks that invalid HTTP and Modbus requests do not disturb a running line, and measures how soon its results come.

    line_requests.py PROGRAMS MAKE_PARTS [--requests N] [--rate R] [--seconds S] [--browsers B] [--nice P] [--record]

A simulated board sends the same parts again and again through a ring. Every third part has a dent.

The first run lasts S seconds at R frames a second. B browsers show the page of the line. Each browser is a process of
its own without a window. The browsers have a lower priority than the line, because they draw in software, and on a real
line they would run on other machines. --nice P sets the niceness of the line itself; use a negative P on a machine that
has other work. Nothing may be lost. The line's memory is measured at the beginning, during the run and at the end.

The second run has 1,500 frames a second. N HTTP requests and N Modbus requests come. They are damaged, cut off, or
random bytes, or they ask for something that is not allowed, such as to write. Every part must be classified as usual, and
nothing may be lost. At the end, the page must answer, and the registers must have the same counts as the files.

--record keeps the figures in the folder results.
"""

import argparse
import json
import os
import pathlib
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"))
import chromium  # noqa: E402
import results  # noqa: E402

CYCLE = ["good", "good", "bad"]
REGISTERS = 21
BROWSER_NICENESS = 10
ATTACKED_RATE = 1500  # frames a second: low, because the second run does not measure speed


def modbus(port, function=4, first=0, count=REGISTERS):
    """Returns the registers as a list."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as client:
        client.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, function, first, count))
        answer = b""
        while len(answer) < 9 + 2 * count:
            more = client.recv(1024)
            if not more:
                raise ConnectionError("the Modbus server closed the connection")
            answer += more
    return list(struct.unpack(f">{count}H", answer[9:]))


def http(port, path):
    with socket.create_connection(("127.0.0.1", port), timeout=10) as client:
        client.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
        return client.recv(64).split(b" ")[1]


def damaged(rng, request):
    """Returns the request with some bytes changed, or cut off, or random bytes instead of it."""
    kind = rng.randrange(3)
    if kind == 0:
        request = bytearray(request)
        for _ in range(rng.randrange(1, 5)):
            request[rng.randrange(len(request))] = rng.randrange(256)
        return bytes(request)
    if kind == 1:
        return request[:rng.randrange(1, len(request))] + rng.randbytes(rng.randrange(3))
    return rng.randbytes(rng.randrange(1, 400))


def wrong_http(rng):
    heads = [b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc",
             b"PUT /part HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\n\r\n",
             b"DELETE /stream HTTP/1.1\r\nHost: localhost\r\n\r\n",
             b"GET /../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n",
             b"GET / HTTP/1.1\r\nHost: elsewhere.example\r\n\r\n",
             b"GET /" + b"a" * 9000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n"]
    request = rng.choice(heads)
    return request if rng.random() < 0.2 else damaged(rng, request)


def wrong_modbus(rng):
    write = struct.pack(">HHHBBHH", rng.randrange(65536), 0, 6, 1, rng.choice([5, 6, 8, 15, 16, 22, 43]),
                        rng.randrange(65536), rng.randrange(65536))
    beyond = struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, rng.randrange(REGISTERS, 65536), rng.randrange(1, 200))
    request = rng.choice([write, beyond])
    return request if rng.random() < 0.3 else damaged(rng, request)


def send(port, request):
    with socket.create_connection(("127.0.0.1", port), timeout=10) as rude:
        try:
            rude.sendall(request)
            if len(request) % 4 == 0:  # some clients wait for an answer, but most hang up
                rude.settimeout(0.02)
                rude.recv(256)
        except OSError:
            pass


class Line:
    """A simulated board, and `selfproj inspect` with its page and Modbus registers, running in a folder."""

    def __init__(self, programs, folder, out, rate, niceness=0):
        ring = f"requests-{os.getpid()}-{out}"
        self.folder, self.out, self.live, self.modbus = folder, out, chromium.free_port(), chromium.free_port()
        self.board = subprocess.Popen([programs / "selfproj-sim", "board", "--replay", "run.packets", "--ring", ring,
                                       "--rate", str(rate), "--loop", "--wait-for-reader"], cwd=folder,
                                      stdout=subprocess.DEVNULL)
        self.host = subprocess.Popen([programs / "selfproj", "inspect", "--rig", "rig.yaml", "--device", "ring:" + ring,
                                      "--wait-for-board", "--tolerance", "tolerance.yaml", "--parts", out, "--json",
                                      out + ".json", "--live", str(self.live), "--modbus", str(self.modbus),
                                      "--keep-parts", "4"],
                                     cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if niceness:
            for pid in (self.board.pid, self.host.pid):  # before they make threads
                os.setpriority(os.PRIO_PROCESS, pid, niceness)
        self.url = self.host.stderr.readline().split()[-1]
        self.wait_for_parts(1)

    def wait_for_parts(self, least):
        """Waits until at least so many parts are classified. The registers may not be available at first."""
        end = time.monotonic() + 120
        while time.monotonic() < end:
            try:
                if modbus(self.modbus, first=4, count=1)[0] >= least:
                    return
            except OSError:
                pass
            time.sleep(0.1)
        raise TimeoutError("no part was classified")

    def kill(self):
        for process in (self.board, self.host):
            process.kill()
            process.wait()

    def end(self):
        """Stops the board and then the host, and checks the results of the run. Returns its counts."""
        self.board.send_signal(signal.SIGINT)
        self.board.wait(60)
        time.sleep(0.5)  # until the host has classified what is still in the ring
        registers, status = modbus(self.modbus), http(self.live, "/")
        self.host.send_signal(signal.SIGINT)
        said = self.host.communicate(timeout=60)[1]
        counts = json.loads((self.folder / (self.out + ".json")).read_text(encoding="utf-8"))
        parts = [json.loads(line) for line in
                 (self.folder / self.out / "parts.jsonl").read_text(encoding="utf-8").splitlines()]
        assert self.host.returncode == 0, said
        assert status == b"200", status
        lost = {key: counts[key] for key in ("lost_board", "lost_ring", "missing", "bad", "flagged") if counts[key]}
        assert not lost, lost
        whole = parts[:-1]  # the board may have stopped in the middle of the last part
        wrong = [part["part"] for i, part in enumerate(whole) if part["verdict"] != CYCLE[i % len(CYCLE)]]
        assert whole and not wrong, f"{len(wrong)} of {len(whole)} parts are classified wrong, the first {wrong[:1]}"
        told = registers[5] * 65536 + registers[6], registers[7] * 65536 + registers[8]
        # The files may have one part more: the last one, which ended only when the stream ended.
        assert told[0] in (counts["parts_good"], counts["parts_good"] - 1), (told, counts)
        assert told[1] in (counts["parts_bad"], counts["parts_bad"] - 1), (told, counts)
        return counts


def resident_mib(pid):
    """Returns the memory of a process that is in RAM, in MiB."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    return int(re.search(r"^VmRSS:\s+(\d+) kB", status, re.M)[1]) / 1024


def watch(programs, folder, args):
    """Runs the line for args.seconds while args.browsers show its page. Returns the figures of the run."""
    pages = [chromium.Chromium(BROWSER_NICENESS) for _ in range(args.browsers)]
    line = None
    try:
        line = Line(programs, folder, "quiet", args.rate, args.nice)
        for page in pages:
            page.open(line.url)
        for page in pages:
            page.wait_for("return document.querySelectorAll('#parts tbody tr').length >= 4", "no parts on the page")
        seen = [int(page.figures()["profiles"]) for page in pages]
        begin = most = resident_mib(line.host.pid)
        load, end = [], time.monotonic() + args.seconds
        while time.monotonic() < end:
            time.sleep(min(1, args.seconds / 4))
            most = max(most, resident_mib(line.host.pid))
            load.append(os.getloadavg()[0])
        final = resident_mib(line.host.pid)
        # Every page is still live: its number of profiles has grown, and it shows no error.
        for page, before in zip(pages, seen):
            assert int(page.figures()["profiles"]) > before
            errors = page.errors()
            assert not errors, errors
    except BaseException:
        if line:
            line.kill()
        raise
    finally:
        for page in pages:
            page.close()
    counts = line.end()
    return {"profiles": counts["profiles"], "parts": counts["parts"], "rate_per_s": args.rate,
            "seconds": args.seconds, "browsers": args.browsers, "browser_niceness": BROWSER_NICENESS,
            "niceness": args.nice, "cores": os.cpu_count(),
            "load": round(sum(load) / len(load), 1), "result_delay_p50_ms": counts["result_delay_p50_ms"],
            "result_delay_p99_ms": counts["result_delay_p99_ms"], "delay_max_ms": counts["delay_max_us"] / 1000,
            "lost": 0, "pictures_dropped": counts["live_dropped"], "memory_begin_mib": round(begin, 1),
            "memory_most_mib": round(most, 1), "memory_end_mib": round(final, 1)}


def attack(line, requests, seed):
    rng = random.Random(seed)
    for i in range(requests):
        send(line.live, wrong_http(rng))
        send(line.modbus, wrong_modbus(rng))
        if i % 50 == 49:
            assert http(line.live, "/") == b"200"
            assert modbus(line.modbus)[0] == 1


def main():
    parser = argparse.ArgumentParser(description="Sends invalid requests to a running line.")
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("make_parts", type=pathlib.Path)
    parser.add_argument("--requests", type=int, default=100)
    parser.add_argument("--rate", type=int, default=10000)
    parser.add_argument("--seconds", type=float, default=0)
    parser.add_argument("--browsers", type=int, default=0)
    parser.add_argument("--nice", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--record", action="store_true")
    args = parser.parse_args()
    programs = args.programs.resolve()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        subprocess.run([args.make_parts.resolve(), folder], check=True)
        subprocess.run([programs / "selfproj", "tolerance", "learn", "--rig", "rig.yaml", "--device",
                        "file:good.packets", "--out", "tolerance.yaml"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        found = {}
        if args.seconds:
            name = "watched" if args.browsers else "undisturbed"
            found[name + "_with_priority" * (args.nice < 0)] = watch(programs, folder, args)
            print(json.dumps(found), flush=True)
        if args.requests:
            line = Line(programs, folder, "attacked", ATTACKED_RATE)
            try:
                attack(line, args.requests, args.seed)
                line.wait_for_parts(8)
            finally:
                counts = line.end()
            found["attacked"] = {"http_requests": args.requests, "modbus_requests": args.requests,
                                 "rate_per_s": ATTACKED_RATE, "parts": counts["parts"], "wrong": 0, "lost": 0,
                                 "result_delay_p99_ms": counts["result_delay_p99_ms"]}
    print(json.dumps(found, indent=1))
    if args.record:
        file = results.ROOT / "results/line_requests.json"
        command = "tests/cli/line_requests.py build/bin MAKE_PARTS " + " ".join(sys.argv[3:])
        if file.exists():  # keep the runs with other options, each with its own command and commit
            earlier = json.loads(file.read_text(encoding="utf-8"))
            of_file = {key: earlier[key] for key in ("command", "commit")}
            found = {name: of_file | entry for name, entry in earlier["results"].items()} | {
                name: {"command": command, "commit": results.commit(results.ROOT)} | entry
                for name, entry in found.items()}
        results.write("line_requests",
                      "A running line: how soon its results come, and whether invalid requests disturb it", command,
                      found, results.ROOT / "results")


if __name__ == "__main__":
    main()
