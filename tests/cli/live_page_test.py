#!/usr/bin/env python3
"""Watches `selfproj inspect --live`, by HTTP and with Chromium.

    live_page_test.py PROGRAMS MAKE_PARTS [--pictures DIR]

PROGRAMS is the folder of selfproj and selfproj-sim, MAKE_PARTS the program that makes packets. Without chromedriver
the tests with a browser are skipped. --pictures keeps what the browser shows.
"""

import base64
import http.client
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAMS = MAKE_PARTS = PICTURES = None
RING = f"live-test-{os.getpid()}"


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def message_of(read):
    """(JSON, floats) of the next message that is not empty; `read` returns so many bytes."""
    while True:
        size, floats = struct.unpack("<II", read(8))
        if size:
            head = json.loads(read(size))
            return head, struct.unpack(f"<{floats // 4}f", read(floats))
        read(floats)


class Line:
    """A board that repeats the parts, and `selfproj inspect` with the page."""

    def __init__(self, folder, out, port, address="127.0.0.1", more=(), rate=1500):
        self.port = port
        self.board = subprocess.Popen([PROGRAMS / "selfproj-sim", "board", "--replay", "run.packets", "--ring", RING,
                                       "--rate", str(rate), "--loop"], cwd=folder, stdout=subprocess.DEVNULL)
        self.host = subprocess.Popen([PROGRAMS / "selfproj", "inspect", "--rig", "rig.yaml", "--device",
                                      "ring:" + RING, "--wait-for-board", "--tolerance", "tolerance.yaml", "--parts",
                                      out, "--json", out + ".json", "--live", f"{address}:{port}", *more],
                                     cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.url = self.host.stderr.readline().split()[-1]

    def stop_host(self):
        self.host.send_signal(signal.SIGINT)
        self.host.stderr.close()
        assert self.host.wait(30) == 0

    def stop(self):
        self.board.send_signal(signal.SIGINT)
        self.board.wait(30)
        self.stop_host()


class Made(unittest.TestCase):
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

    def parts(self, out):
        return [json.loads(line) for line in (self.folder / out / "parts.jsonl").read_text().splitlines()]


class Http(Made):
    def get(self, port, path, headers=None, method="GET"):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
        connection.request(method, path, headers=headers or {})
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer, body

    def test_tells_what_the_files_tell_and_takes_nothing(self):
        line = Line(self.folder, "http", free_port())
        self.addCleanup(lambda: line.host.poll() is None and line.stop())
        connection = http.client.HTTPConnection("127.0.0.1", line.port, timeout=10)
        connection.request("GET", "/stream")
        stream = connection.getresponse()
        head = {"parts": []}
        while len(head["parts"]) < 4:
            head, floats = message_of(stream.read)
            self.assertEqual(len(floats), (3 + head["rows"]) * head["columns"])
        connection.close()
        answer, page = self.get(line.port, "/")
        self.assertIn("default-src 'none'", answer.getheader("Content-Security-Policy"))
        self.assertNotRegex(page.decode(), r"https?://")
        self.assertEqual(self.get(line.port, "/", method="POST")[0].status, 405)
        self.assertEqual(self.get(line.port, "/", {"Host": "elsewhere.example"})[0].status, 403)
        self.assertEqual(self.get(line.port, "/../etc/passwd")[0].status, 404)
        # One that reads nothing, and requests that are none.
        idle = socket.create_connection(("127.0.0.1", line.port))
        idle.sendall(b"GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n")
        rng = random.Random(1)
        for i in range(200):
            with socket.create_connection(("127.0.0.1", line.port)) as rude:
                start = [b"", b"GET /stream HTTP/1.1\r\nHost: localhost\r\n", b"GET /part?"][i % 3]
                rude.sendall(start + rng.randbytes(rng.randrange(1, 400)))
        self.assertEqual(self.get(line.port, "/part")[0].status, 200)
        idle.close()
        line.stop()
        written = self.parts("http")
        for part in head["parts"]:
            self.assertEqual(part, written[part["part"] - 1])
        counts = json.loads((self.folder / "http.json").read_text())
        self.assertEqual(counts["lost_ring"] + counts["missing"] + counts["bad"], 0)
        # The last part may have been in the middle when the board stopped.
        self.assertEqual([part["part"] for part in written[:-1] if part["verdict"] == "cannot tell"], [])
        self.assertIn("live_dropped", counts)

    def test_another_address_needs_the_token(self):
        line = Line(self.folder, "token", free_port(), "0.0.0.0")
        self.addCleanup(lambda: line.host.poll() is None and line.stop())
        token = re.fullmatch(r"http://0\.0\.0\.0:\d+/\?token=([0-9a-f]{32})", line.url).group(1)
        self.assertEqual(self.get(line.port, "/")[0].status, 403)
        self.assertEqual(self.get(line.port, "/part?token=" + "0" * 32)[0].status, 403)
        answer, _ = self.get(line.port, "/?token=" + token)
        self.assertEqual(answer.status, 200)
        cookie = answer.getheader("Set-Cookie").split(";")[0]
        self.assertEqual(self.get(line.port, "/part", {"Cookie": cookie})[0].status, 200)
        line.stop()

    def test_a_port_that_is_taken(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            run = subprocess.run([PROGRAMS / "selfproj", "inspect", "--device", "file:run.packets", "--live",
                                  str(port)], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stderr),
                         (2, f"selfproj: --live 127.0.0.1:{port}: Address already in use\n"))


@unittest.skipUnless(shutil.which("chromedriver"), "chromedriver is not installed")
class Browser(Made):
    """Chromium, by the protocol of its driver."""

    def call(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.driver_port, timeout=60)
        connection.request(method, path, json.dumps(body) if body is not None else None,
                           {"Content-Type": "application/json"})
        answer = json.loads(connection.getresponse().read())
        connection.close()
        value = answer["value"]
        self.assertFalse(isinstance(value, dict) and "error" in value, answer)
        return value

    def in_session(self, method, path, body=None):
        return self.call(method, f"/session/{self.session}{path}", body)

    def script(self, text):
        return self.in_session("POST", "/execute/sync", {"script": text, "args": []})

    def command(self, name, parameters):
        return self.in_session("POST", "/goog/cdp/execute", {"cmd": name, "params": parameters})

    def setUp(self):
        self.driver_port = free_port()
        self.driver = subprocess.Popen(["chromedriver", f"--port={self.driver_port}"], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
        self.addCleanup(self.driver.wait)
        self.addCleanup(self.driver.terminate)
        for _ in range(200):
            try:
                self.call("GET", "/status")
                break
            except OSError:
                time.sleep(0.05)
        options = {"args": ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1280,1000",
                            "--enable-unsafe-swiftshader", "--disable-background-networking"]}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
        self.session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        self.addCleanup(lambda: self.in_session("DELETE", ""))

    def wait_for(self, text, what):
        for _ in range(400):
            if self.script(text):
                return
            time.sleep(0.05)
        self.fail(what)

    def picture(self, name):
        if PICTURES:
            data = self.command("Page.captureScreenshot", {"captureBeyondViewport": True})["data"]
            (PICTURES / f"{name}.png").write_bytes(base64.b64decode(data))

    def rows_shown(self):
        return self.script("return [...document.querySelectorAll('#parts tbody tr')]"
                           ".map(r => [...r.cells].map(c => c.textContent))")

    def test_shows_what_the_files_tell(self):
        line = Line(self.folder, "first", free_port())
        self.addCleanup(lambda: line.host.poll() is None and line.stop())
        self.in_session("POST", "/url", {"url": line.url})
        self.wait_for("return document.querySelectorAll('#parts tbody tr').length >= 4", "no parts on the page")
        self.wait_for("return Number(document.getElementById('solid').dataset.triangles || 0) > 1000", "no 3-D view")
        self.wait_for("const c = document.getElementById('waterfall');"
                      "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
                      "return d.some((v, i) => i % 4 === 3 && v === 255)", "no waterfall")
        for scheme in ("light", "dark"):
            self.command("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme",
                                                                      "value": scheme}]})
            for name, width in (("desktop", 1280), ("phone", 390)):
                self.command("Emulation.setDeviceMetricsOverride", {"width": width, "height": 1000,
                                                                    "deviceScaleFactor": 1, "mobile": width < 600})
                time.sleep(0.3 if PICTURES else 0)
                self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), width, name)
                self.picture(f"{name}-{scheme}")
        shown = self.rows_shown()
        figures = self.script("return Object.fromEntries([...document.querySelectorAll('#figures dd')]"
                              ".map(d => [d.dataset.key, d.textContent]))")
        self.assertGreater(int(figures["profiles"]), 1000)
        self.assertEqual(figures["lost_ring"], "0")
        # The program restarts, and the page finds it again.
        line.stop()
        written = self.parts("first")
        for row in shown:
            part = written[int(row[0]) - 1]
            self.assertEqual(row[1], part["verdict"])
            self.assertEqual(row[2:5], [f"{part['placement'][k] + 0.0:.3f}" for k in ("length_mm", "across_mm",
                                                                                      "turn_deg")])
            self.assertEqual(row[5], str(len(part["defects"])))
        again = Line(self.folder, "again", line.port, rate=150)  # its parts stay few until the page is back
        self.addCleanup(lambda: again.host.poll() is None and again.stop())
        self.wait_for("const r = document.querySelector('#parts tbody tr td');"
                      "return document.getElementById('connection').textContent === 'connected'"
                      f" && r && Number(r.textContent) < {max(int(r[0]) for r in shown)}", "not connected again")
        again.stop()
        # No error but that of the time without a program, and nothing from elsewhere.
        errors = [entry for entry in self.in_session("POST", "/se/log", {"type": "browser"})
                  if entry["level"] == "SEVERE" and "ERR_CONNECTION_REFUSED" not in entry["message"]
                  and "ERR_INCOMPLETE_CHUNKED_ENCODING" not in entry["message"]]
        self.assertEqual(errors, [])
        asked = [event["params"]["request"]["url"] for entry in self.in_session("POST", "/se/log",
                                                                                 {"type": "performance"})
                 for event in [json.loads(entry["message"])["message"]]
                 if event["method"] == "Network.requestWillBeSent"]
        self.assertTrue(asked)
        for url in asked:
            self.assertTrue(url.startswith(line.url), url)


if __name__ == "__main__":
    words = sys.argv[1:]
    if "--pictures" in words:
        at = words.index("--pictures")
        PICTURES = pathlib.Path(words[at + 1]).resolve()
        PICTURES.mkdir(parents=True, exist_ok=True)
        del words[at:at + 2]
    PROGRAMS, MAKE_PARTS = (pathlib.Path(word).resolve() for word in words[:2])
    unittest.main(argv=[sys.argv[0], *words[2:]])
