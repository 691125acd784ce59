#!/usr/bin/env python3
"""Tests the search and the arithmetic of constraints/ecpix5/rates.py. With --simulate it runs the whole script, with
coarse settings.

    rates_test.py [--simulate]

The exit status is 77 if constraints/ecpix5/simulate.sh cannot run. SELFPROJ_PROGRAMS and SELFPROJ_BUILD name the programs, as
there.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "constraints" / "ecpix5" / "rates.py"
sys.path.insert(0, str(SCRIPT.parent))
import rates  # noqa: E402

UNREACHED = 77


def figures_with(limit):
    """Returns a trial of a link that loses packets with every period below `limit`, and the periods that were tried."""
    tried = []

    def trial(period):
        tried.append(period)
        return {"period": period, "lost_board": max(0, limit - period)}

    return trial, tried


class Search(unittest.TestCase):
    def test_the_rate_is_found_to_the_percent(self):
        for limit in (2049, 3000, 4096, 4097, 12_345, 700_001):
            for percent in (0.5, 1, 20):
                trial, tried = figures_with(limit)
                good, bad = rates.search(trial, 2048, percent)
                with self.subTest(limit=limit, percent=percent):
                    self.assertEqual((good["lost_board"], bad["lost_board"] > 0), (0, True))
                    self.assertLessEqual(bad["period"], limit)
                    self.assertGreaterEqual(good["period"], limit)
                    self.assertLessEqual(good["period"], max(bad["period"] * (1 + percent / 100), bad["period"] + 1))
                    self.assertEqual(len(tried), len(set(tried)))

    def test_a_link_that_loses_nothing_is_tried_once(self):
        trial, tried = figures_with(100)
        good, bad = rates.search(trial, 2048, 1)
        self.assertEqual((good["period"], bad, tried), (2048, None, [2048]))

    def test_bytes_on_the_cable(self):
        # By hand: 2,128, 4,176 and 592 bytes in 2, 3 and 1 datagrams with 82 bytes around each piece
        self.assertEqual(rates.cable_bytes("binary", 96, False), 2128 + 2 * 82)
        self.assertEqual(rates.cable_bytes("grey", 96, False), 4176 + 3 * 82)
        self.assertEqual(rates.cable_bytes("grey", 96, True), 4176 + 82)
        self.assertEqual(rates.cable_bytes("images", 96, False), 4176 + 3 * 82 + 96 * (592 + 82))

    def test_wrong_options_are_named(self):
        for words, said in ((["--kinds", "gray"], "'gray'"), (["--sizes", "4"], "'4'"), (["--sizes", "a,16"], "'a,16'"),
                            (["--percent", "0"], "'0'"), (["--percent", "x"], "'x'")):
            done = subprocess.run([sys.executable, "-B", SCRIPT, *words], capture_output=True, text=True, check=False)
            with self.subTest(words=words):
                self.assertEqual(done.returncode, 2)
                self.assertIn(f"argument {words[0]}: {said} is not", done.stderr.splitlines()[-1])


def simulate():
    """Looks for the rate of grey moments to 20 percent. The cable allows 28,267 frames a second."""
    with tempfile.TemporaryDirectory(prefix="target-rates.") as folder:
        file = pathlib.Path(folder) / "rates.json"
        status = subprocess.run([SCRIPT, "--kinds", "grey", "--sizes", "16", "--percent", "20", "--json", file],
                                check=False).returncode
        if status:
            sys.exit(status)
        found = json.loads(file.read_text(encoding="utf-8"))
    test, good = unittest.TestCase(), found["grey"]["16"]
    test.assertEqual(good["limit"], "link")
    test.assertEqual(good["lost_board"], 0)
    test.assertGreater(good["loses"]["lost_board"], 0)
    test.assertLessEqual(good["loses"]["per_s"], 1.21 * good["per_s"])
    test.assertGreater(good["cable"], 0.75)
    test.assertLess(good["cable"], 1.2)
    test.assertEqual(found["all"]["packets"], found["all"]["equal"])
    test.assertGreater(found["all"]["packets"], 100)


if __name__ == "__main__":
    if sys.argv[1:] == ["--simulate"]:
        simulate()
    else:
        unittest.main()
