#!/usr/bin/env python3
"""Tests `selfproj compare`, the suggestions after a typing error, and the completion in bash.

    compare_test.py PROGRAMS

PROGRAMS is the folder of selfproj and selfproj-sim.
"""

import json
import math
import pathlib
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

    def test_refusals(self):
        (self.folder / "a.ply").write_text(ply([(0, 0, 1)]), encoding="ascii")
        (self.folder / "none.ply").write_text(ply([]), encoding="ascii")
        for name, count in (("two", 2), ("three", 3)):
            self.run_program("selfproj-sim", "scene", "render", "plane", "--count", count, "--truth", name + ".tiff",
                             "--out", name)
        for words, reason in ((("a.ply", "none.ply"), "none.ply: has no points"),
                              (("two.tiff", "a.ply"), "a.ply: is a cloud, two.tiff a map"),
                              (("two.tiff", "three.tiff"), "three.tiff: has 512 x 3 values, two.tiff has 512 x 2"),
                              (("two.tiff", "missing.tiff"), "missing.tiff: ")):
            status, text, errors = self.compare(*words)
            self.assertEqual((status, text), (2, ""))
            self.assertTrue(errors.startswith("selfproj: " + reason), errors)
            self.assertFalse((self.folder / "out").exists())


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
