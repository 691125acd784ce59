#!/usr/bin/env python3
"""Makes the bitstream for an ECPIX-5 with one seed, and checks the file. Status 77 if PyPI is not reached."""

import pathlib
import re
import subprocess
import sys
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BITSTREAM = ROOT / "build" / "ecpix5" / "ecpix5.bit"
CLOCKS = {"bus": 50, "pixel": 125, "rgmii": 125}  # MHz
UNREACHED = 77


class Bitstream(unittest.TestCase):
    def test_it_is_made_and_meets_every_clock(self):
        started = time.time()
        done = subprocess.run([ROOT / "constraints" / "ecpix5" / "bitstream.py"], capture_output=True, text=True,
                              check=False)
        print(done.stdout + done.stderr, end="", flush=True)
        if done.returncode == UNREACHED:
            sys.exit(UNREACHED)
        self.assertEqual(done.returncode, 0)

        clocks = re.findall(r"(\w+) ([\d.]+) MHz \(wanted: ([\d.]+)\)", done.stdout)
        self.assertEqual({name: float(wanted) for name, _, wanted in clocks}, CLOCKS)
        for name, reached, wanted in clocks:
            self.assertGreaterEqual(float(reached), float(wanted), name)

        # The file is new and for this part: comments come first, then the words with which a bitstream begins.
        self.assertGreaterEqual(BITSTREAM.stat().st_mtime, started - 1)
        data = BITSTREAM.read_bytes()
        comments, begins, rest = data.partition(b"\xff\xff\xbd\xb3")
        self.assertTrue(begins)
        self.assertIn(b"Part: LFE5UM5G-85F-8CABGA554\0", comments)
        self.assertGreater(len(rest), 100_000)


if __name__ == "__main__":
    unittest.main()
