"""icsc_replay_test.py RTL_BLOCKS FOLDER: hls/icsc/replay.py compares every output of a translated shell with the
recorded benches of the RTL.

ICSC is not here, so the RTL of the decoder stands in the place of its translation, whole and with a planted fault. The
decoder is the one of the four whose memory is outside in both.
"""
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCES = ["common/sp_spec_pkg.sv", "gray/sp_gray_sequence.sv", "gray/sp_gray_lane.sv", "gray/sp_gray_decoder.sv"]
PROGRAM, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])


class Replay(unittest.TestCase):
    def replay(self, name, old="", new=""):
        """Replays the decoder's benches in the RTL, in which `old` is replaced."""
        text = "\n".join((ROOT / "rtl" / source).read_text() for source in SOURCES)
        self.assertEqual(text.count("module sp_gray_decoder #("), 1)
        text = text.replace("module sp_gray_decoder #(", "module hls_GrayDecoderShell #(")
        if old:
            self.assertEqual(text.count(old), 1)
            text = text.replace(old, new)
        shells = FOLDER / name
        shells.mkdir(parents=True, exist_ok=True)
        (shells / "gray_decoder_shell.sv").write_text(text)
        return self.run_in(shells)

    def run_in(self, shells):
        # Simulations this short are compiled as fast as possible.
        environment = os.environ | {"SELFPROJ_RTL_BLOCKS": PROGRAM, "SELFPROJ_RECORD_STEPS": "4000",
                                    "MAKEFLAGS": "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0"}
        command = [sys.executable, "-B", ROOT / "hls/icsc/replay.py", shells, shells / "replay",
                   "GrayDecoder.WordsThatComeTooLate"]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    def test_equal_outputs(self):
        done = self.replay("whole")
        end = re.search(r"end: (\d+) evaluations, (\d+) outputs compared, 0 wrong", done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(int(end[1]), 4000)
        self.assertGreaterEqual(int(end[2]), 30000)

    def test_a_wrong_output_is_found(self):
        done = self.replay("broken", "negative_i && !lit_q && !dark_q", "negative_i && !lit_q")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"[1-9]\d* wrong")

    def test_a_missing_translation_is_named(self):
        empty = FOLDER / "empty"
        empty.mkdir(parents=True, exist_ok=True)
        done = self.run_in(empty)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"replay.py: {empty / 'gray_decoder_shell.sv'}: no such file\n")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
