#!/usr/bin/env python3
"""Planted faults: files and names that do not exist, in comments of each kind, in a small tree."""

import pathlib
import subprocess
import tempfile
import unittest

import check_names

GOOD = {
    "README.md": "`host/io/files.h` has `read_file`; see [below](host/README.md), host/ and `--out`, f_R and "
                 "depth_KKKK.png.\n",
    "host/README.md": "`files.h`, ../README.md, `io/`\n",
    "host/io/files.h": "// What host/io/files is for: read_file() (README.md); vendor_name is somebody else's.\n"
                       "int read_file(const char* name);  // as Reader::next does\n",
    "host/io/reader.cpp": 'struct Reader { int next(); };\nconst char* option = "--out // host/none.h";\n',
    "rtl/sp_one.sv": "// sp_one: valid_q rises with start_i\n"
                     "module sp_one(input wire start_i); reg valid_q; endmodule\n",
    "scripts/run.sh": "# runs rtl/sp_one.sv\necho hls${x}\n",
}


def problems_of(external=("vendor_name",), **changes):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        subprocess.run(["git", "init", "-q", folder], check=True)
        for name, text in {**GOOD, **changes}.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        return check_names.problems(root, set(external))


class CheckNames(unittest.TestCase):
    def test_a_good_tree(self):
        self.assertEqual(problems_of(), [])

    def expect(self, text, **changes):
        found = problems_of(**changes)
        self.assertTrue(any(text in line for line in found), f"{text!r} is not in {found}")

    def test_a_folder_that_is_gone(self):
        self.expect("README.md:1: no file or folder host/optics/", **{"README.md": "see host/optics/ for more\n"})

    def test_a_file_that_is_gone(self):
        self.expect("host/io/a.h:1: no file or folder host/io/lost.h", **{"host/io/a.h": "// as host/io/lost.h\n"})
        self.expect("scripts/b.sh:2: no file or folder gone.py", **{"scripts/b.sh": "set -e\n# what gone.py wrote\n"})

    def test_a_link_to_the_wrong_folder(self):
        self.expect("no file or folder ../files.h", **{"host/README.md": "[files](../files.h)\n"})

    def test_a_name_that_is_gone(self):
        self.expect("no name write_file()", **{"host/io/a.h": "int a;  /* see write_file() */\n"})
        self.expect("no name Reader::last", **{"host/io/a.h": "// Reader::last ends it\n"})
        self.expect("no name ready_q", **{"rtl/sp_two.sv": "// ready_q is a clock late\nmodule sp_two; endmodule\n"})
        self.expect("no name --in", **{"README.md": "`--in FILE`\n"})
        self.expect("no name old_name", **{"scripts/c.py": '"""What old_name did."""\n'})

    def test_an_external_name_that_nobody_uses(self):
        self.assertEqual(problems_of(external=("vendor_name", "other_name")), ["external.txt: other_name is not used"])


if __name__ == "__main__":
    unittest.main()
