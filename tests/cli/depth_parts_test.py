#!/usr/bin/env python3
"""Parts of structured light on a running line: `selfproj match --tolerance`, its files, registers and page.

    depth_parts_test.py PROGRAMS MAKE_DEPTH_PARTS [--pictures DIR]

MAKE_DEPTH_PARTS writes packets of parts of which every third has a block 60 mm high, 90 mm wide, on it. Without
chromedriver the test with a browser is skipped. --pictures keeps what the browser shows.
"""

import http.client
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import chromium
from line_requests import modbus

PROGRAMS = MAKE_PARTS = PICTURES = None
RING = f"depth-parts-{os.getpid()}"
PAIRS = 12  # of a part
BITS = 4
VIEW = 64 * 550 * 0.08 / 6  # mm, the side of what the camera sees of the plane


class DepthParts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        subprocess.run([MAKE_PARTS, cls.folder], check=True)
        for rig in ("rig", "trigger"):
            cls.learned = cls.host("tolerance", "learn", "--rig", rig + ".yaml", "--reference", "reference", "--e", "4",
                                   "--device", "file:good.packets", "--out", rig + "-tolerance.yaml")
            assert cls.learned.returncode == 0, cls.learned.stderr

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def host(cls, *words):
        return subprocess.run([PROGRAMS / "selfproj", *words], cwd=cls.folder, capture_output=True, text=True,
                              check=False)

    @staticmethod
    def match(rig, *more):
        return ["match", "--rig", rig + ".yaml", "--reference", "reference", "--e", "4", "--tolerance",
                rig + "-tolerance.yaml", *more]

    def parts(self, out):
        return [json.loads(line) for line in (self.folder / out / "parts.jsonl").read_text().splitlines()]

    def board(self, *more):
        return subprocess.Popen([PROGRAMS / "selfproj-sim", "board", "--replay", "run.packets", "--ring", RING, *more],
                                cwd=self.folder, stdout=subprocess.DEVNULL)

    def registers_at_the_end(self, port):
        """The registers when everything that was in the ring is classified."""
        before = None
        while (now := modbus(port)[3:11]) != before:
            before = now
            time.sleep(1)
        return modbus(port)

    def expect_cycle(self, part, bad):
        """A part without the block is good; one with it has one defect, where the block stands and as high as it is."""
        self.assertEqual(part["verdict"], "bad" if bad else "good", part)
        if bad:
            defect = part["defects"][0]
            self.assertAlmostEqual(defect["along_mm"], VIEW / 2, delta=16)
            self.assertAlmostEqual(defect["across_mm"], 0, delta=16)
            self.assertAlmostEqual(defect["size_across_mm"], 90 * 550 / 490, delta=32)
            self.assertAlmostEqual(defect["depth_mm"], 60, delta=20)  # a code of this rig is 35 mm

    def test_parts_by_trigger(self):
        self.assertRegex(self.learned.stdout, r"^9 good parts; ")
        run = self.host(*self.match("trigger", "--device", "file:run.packets", "--parts", "by-trigger", "--out",
                                    "newest"))
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("9 parts: 6 good, 3 bad, 0 inconclusive; result after the last frame p50 ", run.stdout)
        parts = self.parts("by-trigger")
        self.assertEqual(len(parts), 9)
        for i, part in enumerate(parts):
            self.expect_cycle(part, i % 3 == 2)
            # The first depth image is of this part alone, and the last has its last frame.
            self.assertGreaterEqual(part["first_frame"], 2 * PAIRS * i)
            self.assertEqual(part["last_frame"], 2 * PAIRS * (i + 1) - 1)
            self.assertEqual(part["missing_frames"], 0)
        self.assertEqual(json.loads((self.folder / "newest/summary.json").read_text())["line"]["parts"], 9)
        for name in ("result.json", "difference.tiff", "difference.png", "height.tiff"):
            self.assertTrue((self.folder / "by-trigger/part_000003" / name).exists(), name)
        self.assertFalse((self.folder / "by-trigger/part_000001").exists())

    def test_every_depth_image_through_the_ring_as_from_the_file(self):
        run = self.host(*self.match("rig", "--device", "file:run.packets", "--parts", "of-file", "--out", "newest"))
        self.assertEqual(run.returncode, 0, run.stderr)
        board = self.board("--rate", "300", "--wait-for-reader", "--count", str(9 * 2 * PAIRS))
        images = 9 * PAIRS - BITS + 1
        on_line = self.host(*self.match("rig", "--device", "ring:" + RING, "--wait-for-board", "--count", str(images),
                                        "--parts", "of-ring", "--out", "newest"))
        self.assertEqual(board.wait(60), 0)
        self.assertEqual(on_line.returncode, 0, on_line.stderr)
        for name in ("parts.jsonl", "parts.csv", "statistics.json"):
            self.assertEqual((self.folder / "of-file" / name).read_text(), (self.folder / "of-ring" / name).read_text())
        parts = self.parts("of-ring")
        self.assertEqual(len(parts), images)
        for part in parts:
            first, last = part["first_frame"] // (2 * PAIRS), part["last_frame"] // (2 * PAIRS)
            if first == last:  # all of its frames show one part
                self.expect_cycle(part, first % 3 == 2)

    def test_refuses(self):
        def refused(words, *more):
            run = self.host(*words)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
            for text in more:
                self.assertIn(text, run.stderr)
            self.assertFalse((self.folder / "refused").exists())

        device = ["--device", "file:run.packets", "--out", "refused"]
        tolerance = (self.folder / "rig-tolerance.yaml").read_text()
        (self.folder / "edges-tolerance.yaml").write_text(tolerance.replace("place_by: belt", "place_by: edges"))
        (self.folder / "edges.yaml").write_text((self.folder / "rig.yaml").read_text())
        refused(self.match("edges", *device), "edges-tolerance.yaml", "place_by")
        other = re.sub(r"heights_mm: \[[^]]*\]", lambda m: re.sub(r"[-\d.]+", "44", m[0]), tolerance)
        (self.folder / "edges-tolerance.yaml").write_text(other)
        refused(self.match("edges", *device), "edges-tolerance.yaml", "is for another part")
        plain = (self.folder / "rig.yaml").read_text()
        (self.folder / "edges.yaml").write_text(plain[:plain.index("parts:")])
        refused(self.match("edges", *device), "section `parts`")
        (self.folder / "edges.yaml").write_text(plain.replace("cut: image", "cut: profile"))
        refused(self.match("edges", *device), "parts.cut", "image", "trigger")
        (self.folder / "edges.yaml").write_text(plain.replace("grid_mm: 8", "grid_mm: 5"))
        refused(self.match("edges", *device), "parts.grid_mm", "7.333")
        words = ["match", "--rig", "rig.yaml", "--reference", "reference", "--out", "refused"]
        refused([*words, "--device", "file:run.packets", "--parts", "refused-parts"], "--parts", "--tolerance")
        refused([*words, "--tolerance", "rig-tolerance.yaml", "a.png"], "--tolerance", "goes only with --device")

    @unittest.skipUnless(chromium.THERE, "chromedriver is not installed")
    def test_the_page_and_the_registers_show_what_the_files_tell(self):
        page, live, port = chromium.Chromium(), chromium.free_port(), chromium.free_port()
        self.addCleanup(page.close)
        board = self.board("--rate", "80", "--loop")
        host = subprocess.Popen([PROGRAMS / "selfproj", *self.match(
            "rig", "--device", "ring:" + RING, "--wait-for-board", "--parts", "seen", "--live", str(live), "--modbus",
            str(port), "--keep-parts", "4", "--out", "newest")], cwd=self.folder, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True)
        self.addCleanup(lambda: [(process.kill(), process.wait()) for process in (board, host)
                                 if process.poll() is None])
        page.open(host.stderr.readline().split()[-1])
        page.wait_for("return document.querySelectorAll('#parts tbody tr').length >= 20", "no parts on the page")
        page.wait_for("return [...document.querySelectorAll('#parts tbody tr')].some(r => r.cells[1].textContent ==="
                      " 'bad')", "no bad part on the page")
        page.wait_for("return Number(document.getElementById('solid').dataset.triangles || 0) > 1000", "no 3-D view")
        # The map shows the block while it is there: red in the middle, and nothing at the border.
        page.wait_for("const c = document.getElementById('waterfall'), g = c.getContext('2d');"
                      "const m = g.getImageData(c.width / 2, c.height / 2, 1, 1).data;"
                      "return c.width === 64 && c.height === 64 && m[0] > m[2] + 60", "no block on the map")
        self.assertTrue(page.script("return document.getElementById('profile-now').hidden"))
        for scheme in ("light", "dark"):
            for name, width in (("desktop", 1280), ("phone", 390)):
                page.show_as(scheme, width)
                time.sleep(0.3 if PICTURES else 0)
                self.assertLessEqual(page.script("return document.documentElement.scrollWidth"), width, name)
                if PICTURES:
                    page.picture(PICTURES / f"depth-{name}-{scheme}.png")
        shown, figures = page.rows("parts"), page.figures()
        self.assertGreater(int(figures["depth_images"]), 20)
        board.send_signal(signal.SIGINT)
        self.assertEqual(board.wait(30), 0)
        registers = self.registers_at_the_end(port)
        connection = http.client.HTTPConnection("127.0.0.1", live, timeout=10)
        connection.request("POST", "/")
        self.assertEqual(connection.getresponse().status, 405)
        connection.close()
        host.send_signal(signal.SIGINT)
        host.stderr.close()
        self.assertEqual(host.wait(30), 0)
        written = self.parts("seen")
        for row in shown:
            part = written[int(row[0]) - 1]
            self.assertEqual([row[1], row[2]], [part["verdict"], str(len(part["defects"]))])
        counted = [sum(part["verdict"] == verdict for part in written) for verdict in ("good", "bad", "inconclusive")]
        self.assertEqual([registers[i] * 65536 + registers[i + 1] for i in (5, 7, 9)], counted)
        self.assertEqual(registers[3] * 65536 + registers[4], len(written))
        self.assertGreater(counted[1], 0)
        self.assertEqual(page.errors(), [])


if __name__ == "__main__":
    words_ = sys.argv[1:]
    if "--pictures" in words_:
        at = words_.index("--pictures")
        PICTURES = pathlib.Path(words_[at + 1]).resolve()
        PICTURES.mkdir(parents=True, exist_ok=True)
        del words_[at:at + 2]
    PROGRAMS, MAKE_PARTS = (pathlib.Path(word).resolve() for word in words_[:2])
    unittest.main(argv=[sys.argv[0], *words_[2:]])
