#!/usr/bin/env python3
"""Watches `selfproj inspect --live`, by HTTP and with Chromium.

    live_page_test.py PROGRAMS MAKE_PARTS [--pictures DIR]

PROGRAMS is the folder of selfproj and selfproj-sim, MAKE_PARTS the program that makes packets. Without chromedriver
the tests with a browser are skipped. --pictures keeps what the browser shows.
"""

import http.client
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
import unittest

import chromium

PROGRAMS = MAKE_PARTS = PICTURES = None
RING = f"live-test-{os.getpid()}"


def message_of(read):
    """(JSON, floats) of the next message that is not empty; `read` returns so many bytes."""
    while True:
        size, floats = struct.unpack("<II", read(8))
        if size:
            head = json.loads(read(size))
            return head, struct.unpack(f"<{floats // 4}f", read(floats))
        read(floats)


class Line:
    """A board that repeats the parts, and `selfproj inspect` with the page. It classifies the parts, or not."""

    def __init__(self, folder, out, port, address="127.0.0.1", more=(), rate=1500, classifies=True):
        self.port = port
        parts = ["--tolerance", "tolerance.yaml", "--parts", out] if classifies else []
        self.board = subprocess.Popen([PROGRAMS / "selfproj-sim", "board", "--replay", "run.packets", "--ring", RING,
                                       "--rate", str(rate), "--loop"], cwd=folder, stdout=subprocess.DEVNULL)
        self.host = subprocess.Popen([PROGRAMS / "selfproj", "inspect", "--rig", "rig.yaml", "--device",
                                      "ring:" + RING, "--wait-for-board", *parts, "--json", out + ".json",
                                      "--live", f"{address}:{port}", *more],
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
        # The circuit looks at every other part: twice the counts from part to part.
        subprocess.run([PROGRAMS / "selfproj", "verdict", "table", "--rig", "rig.yaml", "--tolerance",
                        "tolerance.yaml", "--start", "0", "--pitch", "6000", "--out", "verdict.yaml"], cwd=cls.folder,
                       check=True, stdout=subprocess.DEVNULL)

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
        line = Line(self.folder, "http", chromium.free_port())
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
        # A client that never reads what it asked for, and clients that send invalid requests.
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
        self.assertEqual([part["part"] for part in written[:-1] if part["verdict"] == "inconclusive"], [])
        self.assertIn("live_dropped", counts)

    def test_another_address_needs_the_token(self):
        line = Line(self.folder, "token", chromium.free_port(), "0.0.0.0")
        self.addCleanup(lambda: line.host.poll() is None and line.stop())
        token = re.fullmatch(r"http://[\d.]+:\d+/\?token=([0-9a-f]{32})", line.url).group(1)
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


@unittest.skipUnless(chromium.THERE, "chromedriver is not installed")
class Browser(Made):
    def setUp(self):
        self.page = chromium.Chromium()
        self.addCleanup(self.page.close)

    ALWAYS = ["Profile now", "Difference, running", "The line"]
    OF_PARTS = ["Last part", "Over all parts", "Parts"]

    def sections(self):
        """The titles of the sections that are shown, those of parts last."""
        shown = self.page.script("return [...document.querySelectorAll('section h2')].filter(h => h.offsetParent)"
                                 ".map(h => h.textContent)")
        return sorted(shown, key=lambda title: (title in self.OF_PARTS, (self.ALWAYS + self.OF_PARTS).index(title)))

    def test_shows_no_parts_of_a_line_without_a_tolerance(self):
        line = Line(self.folder, "unjudged", chromium.free_port(), classifies=False)
        self.addCleanup(lambda: line.host.poll() is None and line.stop())
        self.page.open(line.url)
        self.page.wait_for("return document.querySelectorAll('#figures dd').length > 3", "no figures on the page")
        self.assertEqual(self.sections(), self.ALWAYS)
        self.assertFalse(self.page.script("return document.getElementById('last').offsetParent"))
        line.stop()

    def test_shows_what_the_files_tell(self):
        line = Line(self.folder, "first", chromium.free_port(), more=["--verdict", "verdict.yaml"])
        self.addCleanup(lambda: line.host.poll() is None and line.stop())
        self.page.open(line.url)
        self.page.wait_for("return document.querySelectorAll('#parts tbody tr').length >= 4", "no parts on the page")
        self.page.wait_for("return Number(document.getElementById('solid').dataset.triangles || 0) > 1000",
                           "no 3-D view")
        self.page.wait_for("const c = document.getElementById('waterfall');"
                           "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
                           "return d.some((v, i) => i % 4 === 3 && v === 255)", "no waterfall")
        for scheme in ("light", "dark"):
            for name, width in (("desktop", 1280), ("phone", 390)):
                self.page.show_as(scheme, width)
                time.sleep(0.3 if PICTURES else 0)
                self.assertLessEqual(self.page.script("return document.documentElement.scrollWidth"), width, name)
                if PICTURES:
                    self.page.picture(PICTURES / f"{name}-{scheme}.png")
        self.assertEqual(self.sections(), self.ALWAYS + self.OF_PARTS)
        shown = self.page.rows("parts")
        figures = self.page.figures()
        self.assertGreater(int(figures["profiles"]), 1000)
        self.assertEqual(figures["lost_ring"], "0")
        self.assertIn("verdict_parts_with_defect", figures)
        self.assertRegex(self.page.script("return document.getElementById('rate').textContent"),
                         r"^\d+ frames/s, nothing lost$")
        self.assertEqual(self.page.script("return document.querySelectorAll('#parts th:not([hidden])').length"), 8)
        # The program restarts, and the page finds it again.
        line.stop()
        written = self.parts("first")
        for row in shown:
            part = written[int(row[0]) - 1]
            self.assertEqual(row[1], part["verdict"])
            moments = part["moments"]
            self.assertEqual(row[2], "–" if moments["frames"] == 0 else "defect" if moments["defect"] else "good")
            self.assertEqual(row[3], str(len(part["defects"])))
            placed = [round(part["placement"][k], 2) + 0.0 for k in ("length_mm", "across_mm", "turn_deg")]
            for cell, value in zip(row[5:8], placed):
                self.assertNotRegex(cell, r"^-0\.0*$")
                self.assertAlmostEqual(float(cell), value, delta=0.011)  # halves may be rounded either way
        again = Line(self.folder, "again", line.port, rate=150)  # its parts stay few until the page is back
        self.addCleanup(lambda: again.host.poll() is None and again.stop())
        self.page.wait_for("const r = document.querySelector('#parts tbody tr td');"
                      "return document.getElementById('connection').textContent === 'connected'"
                      f" && r && Number(r.textContent) < {max(int(r[0]) for r in shown)}", "not connected again")
        self.assertEqual(self.page.script("return document.querySelectorAll('#parts th:not([hidden])').length"), 7)
        self.assertEqual(len(self.page.rows("parts")[0]), 7)
        again.stop()
        # No error but that of the time without a program, and nothing from elsewhere.
        self.assertEqual(self.page.errors(), [])
        asked = self.page.asked()
        self.assertTrue(asked)
        for url in asked:
            self.assertTrue(url.startswith(line.url), url)


    def test_shows_the_camera_while_one_sets_up(self):
        """Raw images: the line is drawn where it was found, and what is said of the exposure."""
        folder = self.folder / "camera"
        folder.mkdir()
        run = lambda *words: subprocess.run([PROGRAMS / words[0], *words[1:]], cwd=folder, check=True,
                                            stdout=subprocess.DEVNULL)
        run("selfproj-sim", "scene", "render", "stairs-marked", "--count", "4", "--out", "frames")
        frames = sorted(map(str, (folder / "frames").glob("frame_*.png")))
        board = subprocess.Popen([PROGRAMS / "selfproj-sim", "board", "--images", *frames, "--threshold", "20",
                                   "--ring", RING, "--rate", "100", "--loop"], cwd=folder,
                                 stdout=subprocess.DEVNULL)
        host = subprocess.Popen([PROGRAMS / "selfproj", "inspect", "--device", "ring:" + RING, "--wait-for-board",
                                 "--live", str(chromium.free_port()), "--json", "counts.json"], cwd=folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(lambda: [process.kill() for process in (board, host) if process.poll() is None])
        self.page.open(host.stderr.readline().split()[-1])
        self.page.wait_for("return Number(document.getElementById('camera').dataset.found || 0) > 300",
                           "no line in the camera's image")
        # The colour of the line is where the image is bright, not somewhere else.
        on_line = self.page.script(
            "const c = document.getElementById('camera'), g = c.getContext('2d');"
            "const d = g.getImageData(0, 0, c.width, c.height).data; let green = 0, near = 0;"
            "const grey = (x, y) => { const i = 4 * (y * c.width + x); return d[i] === d[i + 1] ? d[i] : 0; };"
            "for (let y = 1; y + 1 < c.height; ++y) for (let x = 0; x < c.width; ++x) {"
            "  const i = 4 * (y * c.width + x);"
            "  if (d[i + 1] < 150 || d[i] > 60) continue;"
            "  ++green; near += Math.max(grey(x, y - 1), grey(x, y + 1)) > 40; }"
            "return [green, near];")
        self.assertGreater(on_line[0], 300)
        self.assertGreater(on_line[1], 0.95 * on_line[0], on_line)
        self.assertIn("exposure", self.page.script("return document.getElementById('exposure').textContent"))
        self.assertRegex(self.page.script("return document.getElementById('shares').textContent"),
                         r"^frame \d+; line in \d+\.\d % of the columns, \d+\.\d % of it saturated$")
        first = self.page.script("return document.getElementById('shares').textContent")
        self.page.wait_for(f"return document.getElementById('shares').textContent !== {json.dumps(first)}",
                           "the image stands still")
        for scheme in ("light", "dark"):
            self.page.show_as(scheme, 1280)
            if PICTURES:
                time.sleep(0.3)
                self.page.picture(PICTURES / f"camera-{scheme}.png")
        self.assertEqual(self.page.errors(), [])
        board.send_signal(signal.SIGINT)
        self.assertEqual(board.wait(30), 0)
        host.send_signal(signal.SIGINT)
        host.stderr.close()
        self.assertEqual(host.wait(30), 0)
        counts = json.loads((folder / "counts.json").read_text())
        self.assertEqual(counts["lost_ring"] + counts["missing"] + counts["bad"], 0)

    def test_shows_the_image_of_a_camera_without_a_board(self):
        """The program makes the raw images' packets itself. Each image of Aravis' camera differs from the last one."""
        device = "camera:Fake_1?rate=50&image=yes&threshold=248"
        host = subprocess.Popen([PROGRAMS / "selfproj", "inspect", "--device", device, "--live",
                                 str(chromium.free_port()), "--json", "fake.json"], cwd=self.folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(lambda: host.poll() is None and (host.kill(), host.wait()))
        self.page.open(host.stderr.readline().split()[-1])
        self.page.wait_for("return document.getElementById('shares').textContent.startsWith('frame')", "no image")
        frame = lambda: int(self.page.script("return document.getElementById('shares').textContent.split(/[ ;]/)[1]"))
        grey = lambda: self.page.script(
            "const c = document.getElementById('camera'), g = c.getContext('2d');"
            "return [c.width, c.height, ...g.getImageData(0, 0, c.width, 1).data];")
        first, image = frame(), grey()
        self.assertEqual(image[:2], [512, 96])
        self.assertGreater(len(set(image[2::4])), 100, "the camera's ramp of grey values is not there")
        self.page.wait_for("return Number(document.getElementById('shares').textContent.split(/[ ;]/)[1])"
                           f" > {first + 50}", "the image stands still")
        self.assertNotEqual(grey(), image)
        # The threshold of the URI holds, not the rig's. Of every 255 grey values of the ramp six lie above it, so a
        # good third of the columns has a line.
        shares = self.page.script("return document.getElementById('shares').textContent")
        self.assertAlmostEqual(float(re.search(r"line in ([\d.]+) %", shares)[1]), 100 * 96 / 255, delta=5)
        self.assertIn("no line", self.page.script("return document.getElementById('exposure').textContent"))
        shown = self.page.figures()
        self.assertEqual(self.page.errors(), [])
        host.send_signal(signal.SIGINT)
        host.stderr.close()
        self.assertEqual(host.wait(30), 0)
        counts = json.loads((self.folder / "fake.json").read_text())
        self.assertGreaterEqual(counts["profiles"], int(shown["profiles"]))
        self.assertEqual(counts["missing"] + counts["bad"], 0)


if __name__ == "__main__":
    words = sys.argv[1:]
    if "--pictures" in words:
        at = words.index("--pictures")
        PICTURES = pathlib.Path(words[at + 1]).resolve()
        PICTURES.mkdir(parents=True, exist_ok=True)
        del words[at:at + 2]
    PROGRAMS, MAKE_PARTS = (pathlib.Path(word).resolve() for word in words[:2])
    unittest.main(argv=[sys.argv[0], *words[2:]])
