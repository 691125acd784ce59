#!/usr/bin/env python3
"""The region follows parts that come too high or too low: `selfproj inspect --follow`, and a simulated board whose
camera obeys the register `region`.

    follow_test.py PROGRAMS
"""

import json
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAMS = None
FRAMES = 24  # of a part
RATE = 100   # so slow that a busy machine keeps up
ADDRESS = "127.0.0.11"
PLATE_MM = (130, 130)  # along and across the belt, more than the camera sees
ROWS = 16
SHIFT_MM = 3.2  # eight rows: some of the line is still in the region
OFF_MM = 0.1    # what noise and the straight line do to a height, at most


def write_tiff(file, rows, columns, value):
    """Writes a map of 32-bit floats."""
    tags = [(256, 4, columns), (257, 4, rows), (258, 3, 32), (259, 3, 1), (262, 3, 1), (273, 4, 8), (277, 3, 1),
            (278, 4, rows), (279, 4, 4 * rows * columns), (339, 3, 3)]
    data = struct.pack(f"<{rows * columns}f", *[value] * (rows * columns))
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", tag, kind, 1, v) for tag, kind, v in tags)
    file.write_bytes(b"II*\0" + struct.pack("<I", 8 + len(data)) + data + directory + bytes(4))


class Follow(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="selfproj_follow_")
        cls.folder = pathlib.Path(cls.scratch.name)
        write_tiff(cls.folder / "plate.tiff", *PLATE_MM, 0.1)
        cls.host("rows", "--rows", ROWS, "--rate", 50000, "--out", "few.yaml")
        cls.rows = int((cls.folder / "few.yaml").read_text().split("row_offset: ")[1].split()[0])
        for name, shift in (("high", SHIFT_MM), ("low", -SHIFT_MM)):
            cls.sim("scene", "render", "--height-map", "plate.tiff", "--mm-per-pixel", 1, "--rig", "light-section",
                    "--region-of", "few.yaml", "--uncropped", "--first", 3000, "--count", FRAMES, "--lift", shift,
                    "--truth", f"{name}.tiff", "--out", name)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def run_program(cls, program, words, status):
        done = subprocess.run([PROGRAMS / program, *map(str, words)], cwd=cls.folder, capture_output=True, text=True,
                              timeout=120, check=False)
        if done.returncode != status:
            raise AssertionError(f"{program} {words}: status {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    @classmethod
    def host(cls, *words, status=0):
        return cls.run_program("selfproj", words, status)

    @classmethod
    def sim(cls, *words, status=0):
        return cls.run_program("selfproj-sim", words, status)

    def inspect(self, name, images, *words, rig="few.yaml", status=0):
        """Inspects these images. Returns what was said, and the counts."""
        files = [file for folder in images for file in sorted((self.folder / folder).glob("*.png"))]
        board = subprocess.Popen([PROGRAMS / "selfproj-sim", "board", "--images", *files, "--sensor", "--rig",
                                  rig, "--rate", str(RATE), "--ring", f"follow-{name}", "--control", ADDRESS], cwd=self.folder,
                                 stdout=subprocess.DEVNULL)
        try:
            info = [PROGRAMS / "selfproj", "board", "info", "--device", f"udp:{ADDRESS}"]
            while subprocess.run(info, capture_output=True, check=False).returncode:
                self.assertIsNone(board.poll())
                time.sleep(0.05)
            said = self.host("inspect", "--rig", rig, "--device", f"ring:follow-{name}", "--control",
                             f"udp:{ADDRESS}", "--out", name, "--json", f"{name}.json", *words, status=status)
            if not status:
                self.assertEqual(board.wait(timeout=20), 0)
        finally:
            board.terminate()
            board.wait()
        file = self.folder / f"{name}.json"
        return said, json.loads(file.read_text()) if file.is_file() else None

    def off(self, name, part):
        """Compares the heights with the truth."""
        self.host("compare", "--out", f"{name}-compared", f"{part}.tiff", f"{name}/height.tiff")
        return json.loads((self.folder / f"{name}-compared/summary.json").read_text())

    def test_a_part_that_comes_shifted_is_measured(self):
        for part in ("high", "low"):
            _, fixed = self.inspect(f"{part}-fixed", [part], "--count", FRAMES)
            said, followed = self.inspect(f"{part}-followed", [part], "--follow", "--count", FRAMES)
            self.assertIn("region moved 1 times", said)
            self.assertEqual((followed["region_moves"], followed["region_moves_failed"]), (1, 0))
            self.assertEqual(followed["profiles"], FRAMES)
            self.assertEqual(fixed["points"], 0)
            found = self.off(f"{part}-followed", part)
            self.assertGreater(found["compared"], 0.6 * found["of_a"], found)
            self.assertLess(found["largest_mm"], OFF_MM, found)
            self.assertLess(found["rms_mm"], 0.3 * OFF_MM, found)
            # The images are of 50,000 frames a second, and the board plays them slowly: the encoder says where they lie.
            belt = json.loads((self.folder / f"{part}-followed/summary.json").read_text())["belt"]
            self.assertEqual(belt["x_from"], "encoder")
            self.assertAlmostEqual(belt["mm_per_frame"], 1000 / 50000)

    def test_a_part_of_twelve_bits(self):
        for name, rig in (("twelve", (self.folder / "few.yaml").read_text()), ("whole", self.host("rig", "light-section"))):
            threshold = int(re.search(r"  threshold: (\d+)", rig)[1])
            (self.folder / f"{name}.yaml").write_text(
                rig.replace(f"  threshold: {threshold}\n", f"  threshold: {16 * threshold}\n  pixel_bits: 12\n"))
        self.sim("scene", "render", "--height-map", "plate.tiff", "--mm-per-pixel", 1, "--rig", "whole.yaml",
                 "--region-of", "twelve.yaml", "--uncropped", "--first", 3000, "--count", FRAMES, "--lift", SHIFT_MM, "--out", "high-of-twelve")
        said, followed = self.inspect("twelve", ["high-of-twelve"], "--follow", "--count", FRAMES, rig="twelve.yaml")
        self.assertIn("region moved 1 times", said)
        self.assertEqual(followed["profiles"], FRAMES)
        found = self.off("twelve", "high")
        self.assertGreater(found["compared"], 0.6 * found["of_a"], found)
        self.assertLess(found["largest_mm"], OFF_MM, found)

    def test_part_after_part(self):
        parts = ["high", "low", "low", "high", "low"]
        said, found = self.inspect("parts", parts, "--follow", "--count", FRAMES * len(parts))
        # Once to the first part; each further shift is twice what the region sees, so it goes home first.
        self.assertIn(found["region_moves"], range(6, 9), said)
        self.assertGreater(found["points"], 0.6 * 512 * found["profiles"], said)
        self.assertEqual(found["lost_ring"] + found["missing"] + found["bad"], 0)

    def test_a_command_moves_the_camera(self):
        said, found = self.inspect("moved", ["high"], "--follow", "--move-camera", "sleep 0.08; echo >>rows", "--count",
                                   FRAMES - 14)
        rows = [int(row) for row in (self.folder / "rows").read_text().split()]
        self.assertEqual(len(rows), found["region_moves"], said)
        self.assertNotEqual(rows[0], self.rows)
        self.assertGreaterEqual(found["region_moving"], 4)  # frames while it ran are not measured

    def test_a_camera_that_cannot_be_moved_ends_the_run(self):
        said, _ = self.inspect("stuck", ["high"], "--follow", "--move-camera", "false", status=2)
        self.assertRegex(said, r"^selfproj: --move-camera false \d+: has failed; where the camera's region lies is not "
                               r"known any more$")
        self.assertFalse((self.folder / "stuck").exists())

    def test_refusals(self):
        said = self.host("inspect", "--rig", "light-section", "--device", "file:none", "--follow", status=2)
        self.assertEqual(said, "selfproj: --rig light-section: the rig has no region (camera.region); `selfproj rows` "
                               "writes one\n")
        self.sim("board", "--line", "512x96", "--count", 2, "--record", "line.packets")
        said = self.host("inspect", "--rig", "few.yaml", "--device", "file:line.packets", "--follow", status=2)
        self.assertEqual(said, "selfproj: --follow: needs a board with the register region beside file:line.packets "
                               "(--control)\n")
        for words in (["--line", "512x96"], ["--images", "high/*.png"]):
            said = self.sim("board", *words, "--sensor", "--ring", "follow-none", status=2)
            self.assertEqual(said, "selfproj-sim: --sensor: needs --images and --control, and goes neither with --bits "
                                   "nor with --record\n")
        said = self.sim("board", "--line", "512x96", "--rig", "few.yaml", "--ring", "follow-none", status=2)
        self.assertEqual(said, "selfproj-sim: --rig: goes only with --images\n")
        said = self.sim("scene", "render", "desk", "--lift", 1, "--count", 1, "--out", "desk", status=2)
        self.assertEqual(said, "selfproj-sim: --lift, --aside, --turn: the scene is no part on a conveyor\n")


if __name__ == "__main__":
    PROGRAMS = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
