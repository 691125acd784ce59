#!/usr/bin/env python3
"""Tests that scripts/module_tables.py copies the sources, and notices when a document differs. Standard library
only."""

import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import module_tables  # noqa: E402

PACKAGE = """package sp_spec_pkg;
  localparam int MaxColumns = 2048;
endpackage
"""
MODULE = """// Adds. Guarantees: sum_o is right.
//
//   clk_i   _/1\\_/2\\_
//
// * A first point, which goes on
//   in the next line.
`default_nettype none

module sp_add #(
  parameter int Width = sp_spec_pkg::MaxColumns,  // of both
  parameter bit Fast =
    1'b1,
  // derived, do not set
  parameter int Sum = Width + 1
) (
  input  wire logic             clk_i,
  // What comes in,
  // both at once
  input  wire logic [Width-1:0] a_i,   // see sum_o
  input  wire logic [Width-1:0] b_i,

  output logic      [7:0]       sum_o  // modulo 256
`ifdef FORMAL
  ,
  output logic f_any_o
`endif
);
endmodule
"""
DOCUMENT = """# Adding
<!-- BEGIN GENERATED head sp_add -->
<!-- END GENERATED head sp_add -->
<!-- BEGIN GENERATED parameters sp_add -->
<!-- END GENERATED parameters sp_add -->
<!-- BEGIN GENERATED ports sp_add -->
<!-- END GENERATED ports sp_add -->
<!-- BEGIN GENERATED file rtl/MATH/sp_add.sv -->
<!-- END GENERATED file rtl/MATH/sp_add.sv -->
The end
"""


class ModuleTablesTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = module_tables.ROOT = pathlib.Path(folder.name)
        self.write("rtl/common/sp_spec_pkg.sv", PACKAGE)
        self.write("rtl/MATH/sp_add.sv", MODULE)
        self.write("docs/adding.md", DOCUMENT)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def run_it(self, *arguments):
        """Exit status and message of the script."""
        sys.argv = ["module_tables.py", *arguments]
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            status = module_tables.main()
        return status, said.getvalue()

    def document(self):
        self.assertEqual(self.run_it(), (0, ""))
        return (self.root / "docs/adding.md").read_text(encoding="utf-8")

    def test_says_what_the_source_says(self):
        text = self.document()
        for line in ("Adds. Guarantees: `sum_o` is right.", "clk_i   _/1\\_/2\\_",
                     "* A first point, which goes on in the next line.",
                     "| `Width` | `2048` | of both |", "| `Fast` | `1` |  |", "| `clk_i` | in | 1 |  |",
                     "| *What comes in, both at once* | | | |", "| `a_i` | in | `Width` | see `sum_o` |",
                     "| `sum_o` | out | 8 | modulo 256 |", "module sp_add #(", "The end"):
            self.assertIn(line, text.splitlines())
        self.assertNotIn("`Sum`", text)
        self.assertNotIn("`f_any_o`", text)
        self.assertEqual(self.run_it("--check"), (0, ""))

    def test_sees_a_source_that_changed(self):
        for old, new in (("[7:0]", "[8:0]"), ("modulo 256", "modulo 512"), ("Adds.", "Subtracts."), ("// of both", "")):
            self.write("rtl/MATH/sp_add.sv", MODULE)
            self.document()
            self.write("rtl/MATH/sp_add.sv", MODULE.replace(old, new))
            status, said = self.run_it("--check")
            self.assertEqual(status, 1)
            self.assertIn("docs/adding.md differs", said)

    def test_refuses_what_is_not_there_or_not_known(self):
        self.write("docs/adding.md", DOCUMENT.replace("ports sp_add", "ports sp_sub"))
        self.assertEqual(self.run_it(), (2, "module_tables.py: no module sp_sub under rtl/\n"))
        self.write("docs/adding.md", DOCUMENT.replace("rtl/MATH/sp_add.sv", "rtl/MATH/gone.sv"))
        self.assertEqual(self.run_it(), (2, "module_tables.py: rtl/MATH/gone.sv: No such file or directory\n"))
        self.write("docs/adding.md", DOCUMENT)
        self.write("rtl/MATH/sp_add.sv", MODULE.replace("input  wire logic [Width-1:0] b_i", "inout wire b_io"))
        self.assertEqual(self.run_it(), (2, "module_tables.py: sp_add: cannot read 'inout wire b_io'\n"))


if __name__ == "__main__":
    unittest.main()
