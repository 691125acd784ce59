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


class SameInput(Files):
    """The same input gives the same bytes; times are in times.json alone."""

    def contents(self, folder):
        return {path.relative_to(self.folder / folder).as_posix(): path.read_bytes()
                for path in (self.folder / folder).rglob("*") if path.is_file() and path.name != "times.json"}

    def test_gives_the_same_bytes(self):
        self.shell("selfproj-sim board --line 512x96 --line-frames 30 --record packets")
        for number in range(4):
            self.image(f"images/{number}.pgm", number)
        for command in ("selfproj inspect --device file:packets", "selfproj lines --threshold 20 images/*.pgm",
                        "selfproj-sim cosim --engine model --threshold 20 --frames images",
                        "selfproj-sim decode --engine model --bits 2 images", "selfproj accuracy"):
            with self.subTest(command):
                self.shell(f"{command} --out one; sleep 0.01; {command} --out two")
                one, two = self.contents("one"), self.contents("two")
                self.assertEqual(sorted(one), sorted(two))
                self.assertEqual([name for name in one if one[name] != two[name]], [])
                self.shell("rm -r one two")

    def test_times_are_in_one_place(self):
        self.shell("selfproj-sim board --line 512x96 --line-frames 30 --record packets")
        self.shell("selfproj inspect --device file:packets --out out --json counts.json")
        for name in ("out/times.json", "counts.json"):
            self.assertIn("delay_p99_us", (self.folder / name).read_text(encoding="utf-8"))
        for name in ("summary.json", "report.html"):
            self.assertNotIn("delay", (self.folder / "out" / name).read_text(encoding="utf-8"))


class Text(Files):
    def test_other_encodings_are_refused_with_their_line(self):
        self.shell("selfproj rig light-section > rig.yaml")
        lines = (self.folder / "rig.yaml").read_text(encoding="utf-8").splitlines()
        at = next(number for number, line in enumerate(lines) if line.startswith("name:"))
        lines[at] = "name: Fl\xe4che"
        self.shell("selfproj-sim board --line 512x96 --line-frames 3 --record packets")
        for encoding, good in (("utf-8", True), ("utf-8-sig", True), ("latin-1", False), ("utf-16", False)):
            (self.folder / "r.yaml").write_bytes("\n".join(lines).encode(encoding))
            errors = self.shell("selfproj inspect --device file:packets --rig r.yaml --out out", 0 if good else 2)
            if good:
                self.assertIn("Fl\xe4che", (self.folder / "out/summary.json").read_text(encoding="utf-8"))
            else:
                self.assertRegex(errors, r"^selfproj: r\.yaml: line \d+: .*UTF-8")
                self.assertEqual(errors.count("\n"), 1)

    def test_tables_with_a_byte_order_mark(self):
        (self.folder / "curve.csv").write_bytes(b"\xef\xbb\xbfy_mm,z_mm\r\n-200,1167\r\n200,1167\r\n")
        self.shell("selfproj pattern --rig light-section --reference curve.csv --out out")


class TallImages(Files):
    def test_are_measured_by_the_program_alone(self):
        rows = 3000
        (self.folder / "a.pgm").write_bytes(b"P5\n8 %d\n255\n" % rows + b"\0" * 8 * 2500 + b"\xff" * 8 +
                                            b"\0" * 8 * (rows - 2501))
        for select in ("strongest", "all"):
            errors = self.shell(f"selfproj lines --threshold 20 --select {select} --mode grey --out out a.pgm")
            self.assertIn("a board takes at most 2047", errors)
            with open(self.folder / "out/moments.csv", encoding="utf-8") as file:
                self.assertEqual({(row["m0"], row["m1"]) for row in csv.DictReader(file)}, {("255", str(255 * 2501))})
        self.shell("selfproj lines --threshold 20 --rows 1..2000 --out out a.pgm")
        (self.folder / "b.pgm").write_bytes(b"P5\n4 5804\n255\n" + b"\0" * 4 * 5804)
        self.assertIn("5803", self.shell("selfproj lines --threshold 20 --out out2 b.pgm", 2))


class FramesOfCosim(Files):
    def lit(self, frames):
        self.shell(f"selfproj-sim cosim --engine model --threshold 20 --mode binary --out out --frames {frames}")
        return self.lit_of_frames("out/moments.csv")

    def test_names_folders_and_patterns(self):
        for lit, name in enumerate(("run1/a.pgm", "run[1]/a.pgm", "run[1]/b*.pgm", "run[1]/bcd.pgm"), 1):
            self.image(name, lit)
        self.assertEqual(self.lit("'run[1]/*.pgm'"), [2, 3, 4])
        self.assertEqual(self.lit("'run[1]/b*.pgm'"), [3])
        self.assertEqual(self.lit("'run[1]'"), [2, 3, 4])
        self.assertEqual(self.lit("'run[12]/*.pgm'"), [1])
        self.assertIn("no file matches", self.shell("selfproj-sim cosim --engine model --out o --frames 'no*'", 2))


if __name__ == "__main__":
    programs = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=1)
