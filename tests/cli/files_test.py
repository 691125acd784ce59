#!/usr/bin/env python3
"""Tests the files of every command: numbered inputs in natural order, missing parent folders of outputs.

    files_test.py PROGRAMS

PROGRAMS is the folder of selfproj and selfproj-sim.
"""

import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

programs = pathlib.Path()
ROWS, COLUMNS = 4, 8


class Files(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def shell(self, line, status=0, language="C"):
        environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "LC_ALL": language}
        done = subprocess.run(["bash", "-eu", "-c", line], cwd=self.folder, env=environment, capture_output=True,
                              text=True, timeout=300)
        self.assertEqual(done.returncode, status, f"{line}\n{done.stdout}{done.stderr}")
        return done.stderr

    def image(self, name, lit):
        """An image with this many lit pixels in each column."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = [b"\xff" * COLUMNS if row < lit else b"\x00" * COLUMNS for row in range(ROWS)]
        path.write_bytes(b"P5\n%d %d\n255\n" % (COLUMNS, ROWS) + b"".join(rows))

    def lit_of_frames(self, name):
        """The lit pixels of the first column of each frame of a table of moments."""
        with open(self.folder / name, encoding="utf-8") as file:
            return [int(row["n"]) for row in csv.DictReader(file) if row["column"] == "1"]

    def names(self):
        return sorted(path.relative_to(self.folder).as_posix() for path in self.folder.rglob("*"))


class NaturalOrder(Files):
    def setUp(self):
        super().setUp()
        for lit, name in enumerate(("img1.pgm", "img2.pgm", "img10.pgm"), 1):
            self.image(name, lit)

    def test_what_a_shell_expands(self):
        for language in ("C", "C.UTF-8", "en_US.UTF-8"):
            self.shell("selfproj-sim moments --engine model --out out.csv img*.pgm", language=language)
            self.assertEqual(self.lit_of_frames("out.csv"), [1, 2, 3])

    def test_what_a_user_lists(self):
        self.shell("selfproj-sim moments --engine model --out out.csv img2.pgm img10.pgm img1.pgm")
        self.assertEqual(self.lit_of_frames("out.csv"), [2, 3, 1])

    def test_cosim_takes_a_pattern_and_a_list_alike(self):
        for frames in ("'img*.pgm'", "img*.pgm", "img1.pgm 'img?.pgm' img10.pgm"):
            self.shell(f"selfproj-sim cosim --engine model --threshold 9 --frames {frames} --out out")
            self.assertEqual(self.lit_of_frames("out/moments.csv"), [1, 2, 3] if "?" not in frames else [1, 1, 2, 3])

    def test_poses_and_folders(self):
        """A file that is not an image is reported at its place in the order: pattern 2 before pattern 10."""
        self.shell("selfproj pattern gray --projector 512x512 --out patterns\n"
                   "cd patterns && for file in pattern_0*.png; do mv $file ${file/_0/_}; done\n"
                   "echo text > pattern_10.png; echo text > pattern_2.png")
        errors = self.shell("selfproj-sim capture --rig light-section --scene plane --patterns patterns --out out", 2)
        self.assertIn("patterns/pattern_2.png: ", errors)


class ParentFolders(Files):
    LINES = (
        "selfproj pattern gray --projector 8x4 --out a/b/gray",
        "selfproj pattern --line 3 --out a/b/line",
        "selfproj accuracy --out a/b/accuracy",
        "selfproj-sim scene render plane --count 1 --truth a/t/truth.tiff --out a/b/frames",
        "selfproj-sim moments --engine model --out a/m/moments.csv img.pgm",
        "selfproj-sim decode --engine model --bits 1 --out a/b/codes img.pgm img.pgm",
        "selfproj-sim cosim --engine model --threshold 9 --frames img.pgm --packets a/p/packets --out a/b/cosim",
        "selfproj-sim board --line 8x4 --line-frames 5 --record a/r/line.slfp",
        "selfproj inspect --device file:packets --json a/j/counts.json --out a/b/inspect",
    )

    def setUp(self):
        super().setUp()
        self.image("img.pgm", 2)
        self.shell("selfproj-sim cosim --engine model --count 2 --packets packets")

    def test_they_are_made(self):
        before = self.names()
        for line in self.LINES:
            with self.subTest(line):
                self.shell(line)
                made = [name for name in self.names() if name not in before]
                self.assertGreater(len(made), 2)
                self.assertEqual([name for name in made if pathlib.Path(name).name.startswith(".")], [])
                self.shell("rm -r a")

    def test_a_run_that_fails_leaves_none(self):
        before = self.names()
        for line in ("selfproj-sim moments --engine model --out a/b/out.csv img.pgm missing.pgm",
                     "selfproj-sim decode --engine model --bits 1 --out a/b/out img.pgm missing.pgm",
                     "selfproj-sim cosim --engine model --threshold 9 --frames img.pgm packets --out a/b/out",
                     "selfproj inspect --device file:packets --reference missing --json a/b/c.json --out a/b/out"):
            with self.subTest(line):
                self.shell(line, 2)
                self.assertEqual(self.names(), before)

    def test_a_file_is_no_parent(self):
        errors = self.shell("selfproj accuracy --out img.pgm/sub/out", 2)
        self.assertIn("img.pgm", errors)
        self.assertEqual(errors.count("\n"), 1)


if __name__ == "__main__":
    programs = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=1)
