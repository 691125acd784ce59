#!/usr/bin/env python3
"""Tests scripts/shrink_picture.py: pictures survive writing and reading, pixels become their means, bad files are
refused."""

import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/shrink_picture.py"
sys.path.insert(0, str(SCRIPT.parent))
sys.dont_write_bytecode = True

import shrink_picture  # noqa: E402


class ShrinkPicture(unittest.TestCase):
    def test_written_and_read(self):
        random.seed(1)
        smooth = [bytes((x * 3 + y) & 255 for x in range(21)) for y in range(9)]
        noise = [random.randbytes(21) for _ in range(9)]
        for rows in smooth, noise, smooth + noise:
            self.assertEqual(shrink_picture.read(shrink_picture.write(7, rows)), (7, rows))

    def test_means(self):
        rows = [bytes([0, 10, 255, 1, 20, 255, 9, 9, 9]), bytes([1, 30, 255, 0, 40, 254, 9, 9, 9]), bytes(9)]
        self.assertEqual(shrink_picture.shrunk(3, rows, 2), (1, [bytes([1, 25, 255])]))

    def test_what_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.png"
            grey = shrink_picture.write(1, [bytes(3)]).replace(b"\x08\x02\0\0\0", b"\x08\0\0\0\0", 1)
            for content, reason in [(b"text", "is not a PNG file"), (grey, "three channels"),
                                    (shrink_picture.SIGNATURE, "incomplete")]:
                file.write_bytes(content)
                done = subprocess.run([sys.executable, "-B", SCRIPT, "2", file, file.with_name("b.png")],
                                      capture_output=True, text=True)
                self.assertEqual(done.returncode, 2)
                self.assertIn(reason, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)
                self.assertFalse(file.with_name("b.png").exists())


if __name__ == "__main__":
    unittest.main()
