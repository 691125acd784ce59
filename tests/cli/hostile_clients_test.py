#!/usr/bin/env python3
"""Clients that stay silent or drip, on `selfproj inspect` with its page and Modbus server.

    hostile_clients_test.py PROGRAMS MAKE_PARTS

PROGRAMS is the folder of selfproj and selfproj-sim, MAKE_PARTS the program that makes packets. tests/attack/clients.py
has many more such clients, and measures what they cost.
"""

import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import chromium

PROGRAMS = MAKE_PARTS = None
REQUEST = struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 0, 21)
ANSWER = 9 + 2 * 21
NO_WAIT = 4  # seconds: below what a server gives a client that makes no progress. How far below is the machine's matter


def connect(port, host="127.0.0.1"):
    return socket.create_connection((host, port), timeout=5)


def receive(client, count):
    data = b""
    while len(data) < count:
        more = client.recv(count - len(data))
        if not more:
            raise ConnectionError(f"closed after {data}")
        data += more
    return data


def get(port, path="/", host="localhost", headers="", address="127.0.0.1"):
    """The whole answer."""
    with connect(port, address) as client:
        client.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{headers}\r\n".encode())
        data = b""
        while more := client.recv(65536):
            data += more
        return data


class Line:
    """A board that plays without end, and the program."""

    def __init__(self, folder, name, live, *more):
        ring = f"hostile-{os.getpid()}-{name}"
        self.ring = pathlib.Path("/dev/shm/selfproj-ring-" + ring)
        self.board = subprocess.Popen([PROGRAMS / "selfproj-sim", "board", "--replay", "run.packets", "--ring", ring,
                                       "--rate", "1000", "--loop"], cwd=folder, stdout=subprocess.DEVNULL)
        self.host = subprocess.Popen([PROGRAMS / "selfproj", "inspect", "--rig", "rig.yaml", "--device", "ring:" + ring,
                                      "--wait-for-board", "--live", live, *more], cwd=folder,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.url = self.host.stderr.readline().split()[-1]

    def end(self, how=signal.SIGINT):
        """Seconds until the program has ended."""
        begin = time.monotonic()
        self.host.send_signal(how)
        self.host.communicate(timeout=30)
        seconds = time.monotonic() - begin
        self.kill()
        return seconds

    def kill(self):
        if self.board.poll() is None:
            self.board.send_signal(signal.SIGINT)
        self.board.communicate()
        if self.host.poll() is None:
            self.host.kill()
            self.host.communicate()
        self.ring.unlink(missing_ok=True)


class HostileClients(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        subprocess.run([MAKE_PARTS, cls.folder], check=True)
        subprocess.run([PROGRAMS / "selfproj", "tolerance", "learn", "--rig", "rig.yaml", "--device",
                        "file:good.packets", "--out", "tolerance.yaml"], cwd=cls.folder, check=True,
                       stdout=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def line(self, name, live, *more):
        line = Line(self.folder, name, live, *more)
        self.addCleanup(line.kill)
        return line

    def drip(self, port, text, pause):
        """Sends the text byte by byte, and again on a new connection, until the test ends."""
        end = threading.Event()

        def work():
            while not end.is_set():
                try:
                    with connect(port) as client:
                        for byte in text:
                            client.sendall(bytes([byte]))
                            if end.wait(pause):
                                return
                except OSError:
                    end.wait(pause)

        thread = threading.Thread(target=work)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(end.set)

    def without_waiting(self, work):
        """For a client that makes no progress."""
        begin = time.monotonic()
        result = work()
        self.assertLess(time.monotonic() - begin, NO_WAIT)
        return result

    def first(self, port):
        """A connection to a server that may not listen yet: the program says where the page is before that."""
        end = time.monotonic() + 10
        while True:
            try:
                return connect(port)
            except ConnectionRefusedError:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.01)

    def test_serves_others_and_ends(self):
        page, modbus = chromium.free_port(), chromium.free_port()
        line = self.line("both", str(page), "--tolerance", "tolerance.yaml", "--modbus", str(modbus))

        def ask():
            with connect(modbus) as client:
                client.sendall(REQUEST)
                return receive(client, ANSWER)

        controller = self.first(modbus)
        self.addCleanup(controller.close)
        for _ in range(20):
            self.drip(page, b"GET / HTTP/1.1\r\nHost: localhost\r\nX: yyyyyyyyyyyyyyyyyyyyyyyyyyyyy", 0.1)
            self.drip(modbus, REQUEST[:-1] * 5, 0.04)
        silent = [connect(port) for port in (page, modbus) for _ in range(100)]
        watching = [connect(page) for _ in range(20)]
        for client in watching:
            client.sendall(b"GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n")  # and reads nothing
        for _ in range(3):
            answer = self.without_waiting(lambda: get(page))
            self.assertTrue(answer.startswith(b"HTTP/1.1 200 "), answer[:100])
            self.assertEqual(self.without_waiting(ask)[7:9], b"\x04\x2a")
            for at in (7, 3):  # head and body 25 ms apart, as sockets with Nagle's algorithm send them
                controller.sendall(REQUEST[:at])
                time.sleep(0.025)
                controller.sendall(REQUEST[at:])
                self.assertEqual(self.without_waiting(lambda: receive(controller, ANSWER))[7:9], b"\x04\x2a")
        self.assertTrue(get(page, host="127.evil.example").startswith(b"HTTP/1.1 403 "))
        self.assertLess(line.end(signal.SIGTERM), NO_WAIT)
        self.assertIn(line.host.returncode, (0, -signal.SIGTERM))
        for client in silent + watching:
            client.close()

    def test_two_lines_with_tokens(self):
        """Each has its own cookie, though a browser sends both to both."""
        ports = chromium.free_port(), chromium.free_port()
        lines = [self.line(f"token{port}", f"0.0.0.0:{port}") for port in ports]
        cookies = []
        for line, port in zip(lines, ports):
            answer = get(port, line.url[line.url.rindex("/"):]).decode()
            cookies.append(re.search(r"Set-Cookie: ([^;]*);", answer)[1])
        self.assertEqual(len({cookie.split("=")[0] for cookie in cookies}), 2)
        for port in ports:
            self.assertIn(b" 200 ", get(port, "/part", "any", f"Cookie: {'; '.join(cookies)}\r\n")[:20])
            self.assertIn(b" 403 ", get(port, "/part", "any")[:20])
        self.assertLess(max(line.end() for line in lines), NO_WAIT)

    def test_names_and_ipv6(self):
        port = chromium.free_port()
        line = self.line("name", f"localhost:{port}")
        self.assertEqual(line.url, f"http://localhost:{port}/")
        self.assertIn(b" 200 ", get(port, host=f"localhost:{port}")[:20])
        line.end()
        try:
            socket.create_server(("::1", 0), family=socket.AF_INET6).close()
        except OSError:
            self.skipTest("this machine has no IPv6")
        line = self.line("six", f"[::1]:{port}")
        self.assertEqual(line.url, f"http://[::1]:{port}/")
        self.assertIn(b" 200 ", get(port, host=f"[::1]:{port}", address="::1")[:20])
        line.end()


if __name__ == "__main__":
    PROGRAMS, MAKE_PARTS = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
