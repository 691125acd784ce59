"""A bench with or without a `timescale reads the circuits, which have none, without a message about time scales.

The options are those of docs/using-the-circuits.md. Without them a bench with a `timescale gets messages.
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import rtl_tree  # noqa: E402

EXAMPLE = ROOT / "tests" / "rtl" / "example"
BENCH = (EXAMPLE / "first_frame_tb.sv").read_text(encoding="utf-8")
CIRCUITS = [*map(str, rtl_tree.sources_of("sp_board")), str(EXAMPLE / "camera_to_dma.sv")]


def messages(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode:
        raise AssertionError(done.stdout)
    return [line for line in done.stdout.splitlines() if "timescale" in line.lower() or "explicit time unit" in line]


def verilator(files, *options):
    return messages(["verilator", "--lint-only", "--timing", "-Wall", "-Wno-fatal", *options,
                     "--top-module", "first_frame_tb", *files])


def icarus(files, *options):
    return messages(["iverilog", "-g2012", "-Wall", *options, "-t", "null", "-s", "first_frame_tb", *files])


class Timescale(unittest.TestCase):
    def orders(self, head):
        """The files with the bench first or last."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        bench = pathlib.Path(folder.name) / "bench.sv"
        bench.write_text(head + BENCH, encoding="utf-8")
        return [CIRCUITS[0], str(bench), *CIRCUITS[1:]], [*CIRCUITS, str(bench)]

    def test_with_the_options_nothing_is_said(self):
        for head in ("", "`timescale 1ns / 1ps\n"):
            for files in self.orders(head):
                with self.subTest(head=head):
                    self.assertEqual(verilator(files, "--timescale", "1ns/1ps"), [])
                    self.assertEqual(icarus(files, "-Wno-timescale"), [])

    def test_without_a_timescale_no_option_is_needed(self):
        for files in self.orders(""):
            self.assertEqual(verilator(files) + icarus(files), [])

    def test_without_the_options_something_is_said(self):
        for files in self.orders("`timescale 1ns / 1ps\n"):
            self.assertNotEqual(verilator(files), [])
            self.assertNotEqual(icarus(files), [])


if __name__ == "__main__":
    unittest.main()
