#!/usr/bin/env python3
"""Tests `selfproj compare`, references beside recordings, pages and clouds of depth images, the suggestions after a
typing error, and the completion in bash.

    compare_test.py PROGRAMS

PROGRAMS is the folder of selfproj and selfproj-sim.
"""

import json
import math
import os
import pathlib
import re
import socket
import struct
import subprocess
import sys
import tempfile
import unittest

programs = pathlib.Path()


def ply(points):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" + "".join(
        f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    return head + "".join(" ".join(f"{value:.6g}" for value in point) + "\n" for point in points)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_program(self, program, *words):
        done = subprocess.run([programs / program, *map(str, words)], cwd=self.folder, capture_output=True, text=True,
                              check=False)
        return done.returncode, done.stdout, done.stderr


class Compare(Case):
    def compare(self, *words):
        return self.run_program("selfproj", "compare", "--out", "out", *words)

    def summary(self):
        return json.loads((self.folder / "out/summary.json").read_text(encoding="utf-8"))

    def test_maps(self):
        for name, scene in (("good", "stairs"), ("marked", "stairs-marked")):
            self.assertEqual(self.run_program("selfproj-sim", "cosim", "--engine", "model", "--scene", scene, "--first",
                                              600, "--count", 200, "--out", name)[0], 0)
            (self.folder / name / "height.tiff").rename(self.folder / f"{name}.tiff")
        status, text, errors = self.compare("--within", "0.5", "good.tiff", "marked.tiff")
        self.assertEqual((status, errors), (0, ""))
        self.assertLessEqual(len(text.strip()), 100)
        summary = self.summary()
        self.assertAlmostEqual(summary["percentiles_mm"]["5"], -1, delta=0.05)  # marks are carved 1 mm deep
        self.assertAlmostEqual(summary["percentiles_mm"]["50"], 0, delta=0.01)
        self.assertGreater(summary["compared"], 900)
        rows = (self.folder / "out/histogram.csv").read_text(encoding="utf-8").splitlines()[1:]
        self.assertEqual(sum(int(row.split(",")[2]) for row in rows), summary["compared"])
        self.assertTrue((self.folder / "out/difference.png").read_bytes().startswith(b"\x89PNG"))
        self.assertIn("<svg", (self.folder / "out/report.html").read_text(encoding="utf-8"))
        self.assertEqual(self.compare("--check", "2", "good.tiff", "marked.tiff")[0], 0)
        status, _, errors = self.compare("--check", "0.5", "good.tiff", "marked.tiff")
        self.assertEqual(status, 1)
        self.assertRegex(errors, r"^selfproj: --check: 0.5 mm at most are allowed, and \d\.\d{3} were found\n$")
        self.assertEqual(self.compare("good.tiff", "good.tiff")[0], 0)
        same = self.summary()
        self.assertEqual((same["mean_mm"], same["largest_mm"], same["within"]), (0, 0, 1))
        self.assertNotRegex((self.folder / "out/report.html").read_text(encoding="utf-8"), r"-0\.0+\b")

    def test_clouds(self):
        grid = [(x, y, 500 + 0.1 * x) for x in range(20) for y in range(20)]
        moved = [(x, y, z + (0.3 if x < 2 else 0.1)) for x, y, z in grid]
        (self.folder / "a.ply").write_text(ply(grid), encoding="ascii")
        (self.folder / "b.ply").write_text(ply(moved), encoding="ascii")
        self.assertEqual(self.compare("--within", "0.2", "a.ply", "b.ply")[0], 0)
        summary = self.summary()
        self.assertEqual((summary["compared"], summary["of_a"], summary["within"]), (400, 400, 0.9))
        self.assertAlmostEqual(summary["percentiles_mm"]["50"], 0.1, delta=1e-4)
        self.assertAlmostEqual(summary["largest_mm"], 0.3, delta=1e-4)
        self.assertAlmostEqual(summary["rms_mm"], math.sqrt(0.1 * 0.09 + 0.9 * 0.01), delta=1e-4)
        cloud = (self.folder / "out/distance.ply").read_bytes()
        self.assertIn(b"element vertex 400\n", cloud)
        (self.folder / "out/distance.ply").rename(self.folder / "distance.ply")
        self.assertEqual(self.compare("a.ply", "distance.ply")[0], 0)

    def test_clouds_in_other_axes(self):
        grid = [(3 * x, 2 * y, 500 + 7 * x) for x in range(20) for y in range(20)]
        (self.folder / "a.ply").write_text(ply(grid), encoding="ascii")
        for option, seen in (("--exchange-xy", [(y, x, z) for x, y, z in grid]),
                             ("--opengl", [(x, -y, -z) for x, y, z in grid]),
                             ("--exchange-xy --opengl", [(y, -x, -z) for x, y, z in grid])):
            (self.folder / "b.ply").write_text(ply(seen), encoding="ascii")
            status, _, errors = self.compare("a.ply", "b.ply")
            self.assertEqual(status, 0)
            self.assertRegex(errors, r"^selfproj: b.ply: warning: its points are about \S+ mm from A as they are, and about "
                                     rf"0.000 mm with {option}: are the clouds in one frame\?\n$")
            self.assertIn(f"with {option}: are the clouds", self.summary()["doubts"][0])
            self.assertIn("are the clouds in one frame?", (self.folder / "out/report.html").read_text(encoding="utf-8"))
            status, _, errors = self.compare(*option.split(), "a.ply", "b.ply")
            summary = self.summary()
            self.assertEqual((status, errors, summary["largest_mm"]), (0, "", 0))
            self.assertNotIn("doubts", summary)
            self.assertEqual([name for name in ("exchange_xy", "opengl") if summary[name]],
                             [name[2:].replace("-", "_") for name in option.split()])

    def test_refusals(self):
        (self.folder / "a.ply").write_text(ply([(0, 0, 1)]), encoding="ascii")
        (self.folder / "none.ply").write_text(ply([]), encoding="ascii")
        for name, count in (("two", 2), ("three", 3)):
            self.run_program("selfproj-sim", "scene", "render", "plane", "--count", count, "--truth", name + ".tiff",
                             "--out", name)
        for words, reason in ((("a.ply", "none.ply"), "none.ply: has no points"),
                              (("two.tiff", "a.ply"), "a.ply: is a cloud, two.tiff a map"),
                              (("two.tiff", "three.tiff"), "three.tiff: has 512 x 3 values, two.tiff has 512 x 2"),
                              (("two.tiff", "missing.tiff"), "missing.tiff: "),
                              (("--opengl", "two.tiff", "two.tiff"), "--opengl: is for clouds")):
            status, text, errors = self.compare(*words)
            self.assertEqual((status, text), (2, ""))
            self.assertTrue(errors.startswith("selfproj: " + reason), errors)
            self.assertFalse((self.folder / "out").exists())


class References(Case):
    """Heights are measured by the reference under whose pattern packets and images were taken, and that is said."""

    def must(self, program, *words):
        status, text, errors = self.run_program(program, *words)
        self.assertEqual(status, 0, errors)
        return text

    def record(self):
        self.must("selfproj-sim", "cosim", "--engine", "model", "--scene", "stairs-marked", "--first", 700, "--count", 3,
                  "--out", "part", "--packets", "part.packets")

    def compared(self, folder):
        return self.run_program("selfproj", "compare", "--check", 0.001, "--out", "compared", "part/height.tiff",
                                folder + "/height.tiff")[0]

    def test_packets_of_a_co_simulation(self):
        self.record()
        text = self.must("selfproj", "inspect", "--device", "file:part.packets", "--out", "good")
        self.assertIn("\nreference: part.packets.reference.csv\n", text)
        self.assertIn(" frames/s, nothing lost\n", text)
        self.assertLess(max(map(len, text.splitlines())), 100)
        self.assertEqual(self.compared("good"), 0)
        (self.folder / "part.packets.reference.csv").rename(self.folder / "elsewhere.csv")
        text = self.must("selfproj", "inspect", "--device", "file:part.packets", "--out", "plane")
        self.assertIn("\nreference: none given: the empty plane under a straight line\n", text)
        self.assertEqual(self.compared("plane"), 1)
        (self.folder / "codes.packets.reference.csv").write_text("of another run", encoding="utf-8")
        status, _, errors = self.run_program("selfproj-sim", "cosim", "--engine", "model", "--scene", "fist", "--count",
                                             16, "--packets", "codes.packets")
        self.assertEqual(status, 2)
        self.assertIn("codes.packets.reference.csv lies beside it", errors)

    def test_images_under_a_pattern(self):
        (self.folder / "box.csv").write_text("y_mm,z_mm\n-55,1167\n-25,1167\n-25,1137\n25,1137\n25,1167\n55,1167\n",
                                             encoding="ascii")
        self.must("selfproj", "pattern", "--reference", "box.csv", "--out", "box")
        self.must("selfproj-sim", "scene", "render", "stairs", "--first", 700, "--count", 2, "--pattern",
                  "box/pattern.tiff", "--out", "seen")
        self.assertEqual((self.folder / "seen/reference.csv").read_bytes(),
                         (self.folder / "box/reference.csv").read_bytes())
        text = self.must("selfproj", "inspect", "--images", "seen", "--out", "inspected")
        self.assertIn("\nreference: seen/reference.csv\n", text)
        self.must("selfproj", "inspect", "--images", "seen/frame_00700.png", "--reference", "box", "--out", "inspected")
        self.must("selfproj-sim", "scene", "render", "mountain", "--first", 700, "--count", 1, "--truth", "m.tiff",
                  "--out", "mountain")
        self.must("selfproj", "pattern", "--reference", "m.tiff", "--out", "other")
        # Another one may be the same without its residual.
        text = self.must("selfproj", "inspect", "--images", "seen", "--reference", "other", "--out", "other2")
        self.assertIn("\nreference: other\n", text)

    def test_outputs_of_one_name_are_refused_before_anything_is_written(self):
        self.record()
        status, text, errors = self.run_program("selfproj", "inspect", "--device", "file:part.packets", "--out", "r",
                                                "--json", "r")
        self.assertEqual((status, text), (2, ""))
        self.assertIn("r: is already an output of this command", errors)
        self.assertFalse((self.folder / "r").exists())

    def test_the_address_of_a_live_page_can_be_opened(self):
        self.record()
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        errors = self.run_program("selfproj", "inspect", "--device", "file:part.packets", "--live",
                                  f"0.0.0.0:{port}")[2]
        address = re.search(rf"live page: http://([\d.]+):{port}/\?token=", errors)
        self.assertTrue(address, errors)
        self.assertNotEqual(address[1], "0.0.0.0")
        with socket.socket() as here:  # an address of this machine
            here.bind((address[1], 0))


class Depth(Case):
    def test_page_and_cloud(self):
        for words in (("selfproj-sim", "scene", "render", "desk", "--bits", 4, "--count", 8, "--out", "desk"),
                      ("selfproj", "depth", "--rig", "scanner", "--bits", 4, "--out", "depth", "desk"),
                      ("selfproj", "compare", "--check", 0.001, "--out", "same", "depth/cloud.ply", "depth/cloud.ply")):
            status, _, errors = self.run_program(*words)
            self.assertEqual(status, 0, errors)
        page = (self.folder / "depth/report.html").read_text(encoding="utf-8")
        for text in ("Depth image", "pixels with a depth", "not_measurable", "data:image/png"):
            self.assertIn(text, page)
        head, _, body = (self.folder / "depth/cloud.ply").read_bytes().partition(b"end_header\n")
        self.assertTrue(head.endswith(b"property float intensity\nproperty float quality\n"), head)
        points = list(struct.iter_unpack("<3f3B2f", body))
        self.assertEqual(len(points), int(re.search(rb"element vertex (\d+)", head)[1]))
        self.assertGreater(len(points), 1000)
        for *_, intensity, quality in points:
            self.assertTrue(0 <= quality <= intensity <= 255, (intensity, quality))
        # The decoder allows one pair that differs by less than the threshold of 5.
        self.assertLess(sum(point[-1] < 5 for point in points), 0.2 * len(points))


class CommandLine(Case):
    def test_suggestions(self):
        for line, suggested in (("dpeth", "depth"), ("inspct", "inspect"), ("depth --treshold 5", "--threshold"),
                                ("pattern stripe", "stripes"), ("depth --medain", "--median")):
            status, _, errors = self.run_program("selfproj", *line.split())
            self.assertEqual(status, 2)
            self.assertIn(f" (did you mean {suggested}?); see selfproj", errors)
        for line in ("bogus", "depth --bogus", "depth --xx"):
            self.assertNotIn("did you mean", self.run_program("selfproj", *line.split())[2])

    def test_versions(self):
        for program in ("selfproj", "selfproj-sim"):
            self.assertRegex(self.run_program(program, "--version")[1],
                             rf"^{program} \d+\.\d+(\.\d+)*, specification \d+\.\d+, hash 0x[0-9A-F]{{8}}\n$")

    def test_long_work_says_how_long_it_takes(self):
        terminal, end = os.openpty()
        self.addCleanup(os.close, terminal)
        with subprocess.Popen([programs / "selfproj-sim", "scene", "render", "stairs", "--count", "100000", "--threads",
                               "1", "--out", "long"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=end) as run:
            os.close(end)
            seen = b""
            try:
                while b" left" not in seen and len(seen) < 100_000:
                    seen += os.read(terminal, 4096)
            finally:
                run.terminate()
        self.assertRegex(seen, rb"frame \d+ of 100000, \d+ (s|min|h) left")
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_help_has_a_heading_for_each_job(self):
        text = self.run_program("selfproj", "--help")[1]
        commands = text.split("\nCommands:\n")[1].split("\n\n")[0].splitlines()
        headings = [line for line in commands if line.endswith(":")]
        self.assertEqual(len(headings), len(set(headings)))
        self.assertGreaterEqual(len(headings), 5)
        self.assertTrue(commands[0].endswith(":"))

    def complete(self, program, words):
        """What bash offers for the last of the words."""
        script = self.run_program(program, "completion", "bash")[1]
        (self.folder / "completion.bash").write_text(script, encoding="utf-8")
        function = "_" + program.replace("-", "_")
        asked = f"source completion.bash; COMP_WORDS=({' '.join(repr(word) for word in words)}); " \
                f"COMP_CWORD={len(words) - 1}; {function}; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        done = subprocess.run(["bash", "-c", asked], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split()

    def test_completion(self):
        self.assertEqual(self.complete("selfproj", ["selfproj", "ins"]), ["inspect"])
        self.assertEqual(self.complete("selfproj", ["selfproj", "pattern", "st"]), ["stripes"])
        self.assertIn("--threshold", self.complete("selfproj", ["selfproj", "depth", "--th"]))
        self.assertEqual(self.complete("selfproj", ["selfproj", "calibrate", "--corners", "h"]), ["homography"])
        self.assertEqual(self.complete("selfproj", ["selfproj", "depth", "--out", "x"]), [])  # bash offers files
        self.assertEqual(self.complete("selfproj-sim", ["selfproj-sim", "cos"]), ["cosim"])
        for program in ("selfproj", "selfproj-sim"):
            offered = set(self.complete(program, [program, ""]))
            text = self.run_program(program, "--help")[1].split("\nCommands:\n")[1].split("\n\n")[0]
            listed = {line.split()[0] for line in text.splitlines() if line.startswith("  ") and line[2].islower()}
            self.assertEqual(offered, listed)


if __name__ == "__main__":
    programs = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=1)
