#!/usr/bin/env python3
"""Tests what scripts/mutation.py writes where only some of the models have run. Standard library only."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import mutation  # noqa: E402

ENTRY = {"mutants": 10, "killed": 8, "by_time": 1, "equal": 1, "survive": 1, "score": 8 / 9}
FILE = {"date": "2026-01-02", "commit": "old", "results": {"all": {}, "models": {"Va": ENTRY, "Vb": ENTRY}}}
STAMP = {"date": "2026-03-04", "commit": "new"}


class Merged(unittest.TestCase):
    def test_only_the_models_of_the_run_change(self):
        mutants = [mutation.Mutant("Vb", n, "-mode inv -src rtl/x.sv:1", fate=fate)
                   for n, fate in enumerate(["killed", "hangs", "equal", "killed"], 1)]
        both = mutation.merged(FILE, mutation.figures_of(mutants), [], STAMP)
        self.assertEqual(both["models"]["Va"], ENTRY | {"date": "2026-01-02", "commit": "old"})
        self.assertEqual(both["models"]["Vb"], {"mutants": 4, "killed": 3, "by_time": 1, "equal": 1, "survive": 0,
                                                "score": 1.0, "survivors": []} | STAMP)
        self.assertEqual(both["all"], {"mutants": 14, "killed": 11, "by_time": 2, "equal": 2, "survive": 1,
                                       "score": 11 / 12})

    def test_an_entry_keeps_the_commit_of_its_own_run(self):
        first = FILE | {"results": mutation.merged(FILE, {"Va": ENTRY}, ["Va 3: inv", "Vab 1: inv"], STAMP)}
        second = mutation.merged(first | {"commit": "newest"}, {"Vb": ENTRY}, [], STAMP | {"commit": "newest"})
        self.assertEqual(second["models"]["Va"], ENTRY | STAMP | {"survivors": ["Va 3: inv"]})
        self.assertEqual(second["models"]["Vb"]["commit"], "newest")

    def test_without_an_earlier_file(self):
        alone = mutation.merged(None, {"Va": ENTRY}, [], STAMP)
        self.assertEqual([*alone["models"]], ["Va"])
        self.assertEqual(alone["all"]["score"], 8 / 9)


if __name__ == "__main__":
    unittest.main()
