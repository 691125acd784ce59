#!/usr/bin/env python3
"""Tests that docs/site/modules.py copies the sources, and refuses what it does not know. Standard library only."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "docs/site"))
import modules  # noqa: E402

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

class ModulePagesTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = modules.ROOT = pathlib.Path(folder.name)
        self.write("rtl/common/sp_spec_pkg.sv", PACKAGE)
        self.write("rtl/MATH/sp_add.sv", MODULE)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def test_says_what_the_source_says(self):
        self.assertEqual(list(modules.pages()), ["sp_add.md"])
        text = modules.page("sp_add")
        for line in ("# sp_add", "Adds. Guarantees: `sum_o` is right.", "clk_i   _/1\\_/2\\_",
                     "* A first point, which goes on in the next line.",
                     "| `Width` | `2048` | of both |", "| `Fast` | `1` |  |", "| `clk_i` | in | 1 |  |",
                     "| *What comes in, both at once* | | | |", "| `a_i` | in | `Width` | see `sum_o` |",
                     "| `sum_o` | out | 8 | modulo 256 |"):
            self.assertIn(line, text.splitlines())
        self.assertNotIn("`Sum`", text)
        self.assertNotIn("`f_any_o`", text)

    def test_bits(self):
        for msb, lsb, bits in ((None, None, "1"), ("7", "0", "8"), ("Width-1", "0", "`Width`"), ("Width", "0", "`Width + 1`"),
                               ("Shown-1", "Known", "`Shown - Known`")):
            self.assertEqual(modules.bits_of(msb, lsb), bits)

    def test_refuses_what_is_not_there_or_not_known(self):
        with self.assertRaisesRegex(modules.SourceError, "no module sp_sub under rtl/"):
            modules.page("sp_sub")
        self.write("rtl/MATH/sp_add.sv", MODULE.replace("input  wire logic [Width-1:0] b_i", "inout wire b_io"))
        with self.assertRaisesRegex(modules.SourceError, "sp_add: cannot read 'inout wire b_io'"):
            modules.page("sp_add")


if __name__ == "__main__":
    unittest.main()
