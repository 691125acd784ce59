#!/usr/bin/env python3
"""Planted faults: check_layers.py must find each kind of bad include in a small tree."""

import pathlib
import tempfile
import unittest

import check_layers

TABLE = {
    "folders": {"model": [], "host/io": ["model"], "host/rig": ["host/io", "model"],
              "sim/scene": ["host/rig", "host/io"]},
    "apart": [{"from": "sim/scene/*", "except": ["sim/scene/virtual_*"], "to": ["host/rig/lens*"], "reason": "apart"}],
}
GOOD = {
    "model/packet.h": "#include <vector>\n",
    "host/io/files.h": '#include "model/packet.h"\n',
    "host/rig/rig.h": '#include "host/io/files.h"\n',
    "host/rig/rig.cpp": '#include "host/rig/rig.h"\n',
    "host/rig/lens.h": "",
    "sim/scene/scene.cpp": '#include "host/rig/rig.h"\n',
    "sim/scene/virtual_capture.cpp": '#include "host/rig/lens.h"\n',
}


def problems_of(**changes):
    """Returns the findings in the good tree with some files changed; `__` in a name means `/`."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in {**GOOD, **changes}.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        return check_layers.problems(root, TABLE)


class CheckLayers(unittest.TestCase):
    def test_a_good_tree(self):
        self.assertEqual(problems_of(), [])

    def expect(self, text, **changes):
        found = problems_of(**changes)
        self.assertTrue(any(text in line for line in found), f"{text!r} is not in {found}")

    def test_an_include_upwards(self):
        self.expect("host/io may not include host/rig/rig.h", **{"host/io/other.cpp": '#include "host/rig/rig.h"\n'})

    def test_an_include_of_a_folder_that_is_not_there(self):
        self.expect("host/io may not include host/new/x.h", **{"host/io/other.cpp": '#include "host/new/x.h"\n'})

    def test_a_folder_that_is_not_in_the_table(self):
        self.expect("not in the table", **{"host/new/x.cpp": '#include "model/packet.h"\n'})

    def test_a_cycle_of_folders(self):
        self.expect("cycle of folders: host/io -> host/rig -> host/io",
                    **{"host/io/other.cpp": ' #  include "host/rig/rig.h"\n'})

    def test_a_cycle_of_files(self):
        self.expect("cycle of files: host/rig/lens -> host/rig/mount -> host/rig/tilt -> host/rig/lens",
                    **{"host/rig/lens.h": '#include "host/rig/mount.h"\n',
                       "host/rig/mount.cpp": '#include "host/rig/tilt.h"\n',
                       "host/rig/tilt.h": '#include "host/rig/lens.h"\n'})

    def test_what_is_to_be_apart(self):
        self.expect("must not include host/rig/lens.h: apart", **{"sim/scene/ray.h": '#include "host/rig/lens.h"\n'})

    def test_a_table_with_a_cycle(self):
        table = {"folders": {"model": ["host/io"], "host/io": ["model"]}, "apart": []}
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(check_layers.problems(pathlib.Path(folder), table),
                             ["cycle in the table: host/io -> model -> host/io"])


if __name__ == "__main__":
    unittest.main()
