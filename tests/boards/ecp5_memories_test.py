#!/usr/bin/env python3
"""Tests that constraints/ecp5/ecp5_memories.py moves into block RAMs only the registers that may go there, and gives each
RAM its own site.

Tests of the kind ecp5 (netlist.py) check the behaviour of the registers inside. Standard library only.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = ROOT / "constraints" / "ecp5" / "ecp5_memories.py"

# A memory of 512 words, read one clock after its address; %s: what is behind it.
MEMORY = """
module top(input clk, other, reset, enable, enable2, write, read, input [8:0] wr_addr, rd_addr, input [%(last)d:0] data,
           output reg [%(last)d:0] q, output [%(last)d:0] q2);
  (* no_rw_check *) reg [%(last)d:0] memory[0:511];
  reg [%(last)d:0] word;
  always @(posedge clk) if (write) memory[wr_addr] <= data;
  always @(posedge clk) if (read) word <= memory[rd_addr];
  %(behind)s
endmodule
"""
ONE_LOAD = " assign q2 = 0;"


class Ecp5Memories(unittest.TestCase):
    def changed(self, behind, width=18, arguments=()):
        """The netlist after Yosys and the tool, and what the tool said."""
        with tempfile.TemporaryDirectory(prefix="ecp5_memories.") as name:
            folder = pathlib.Path(name)
            (folder / "top.v").write_text(MEMORY % {"last": width - 1, "behind": behind})
            subprocess.run(
                [
                    "yosys", "-q", "-p",
                    "read_verilog top.v; synth_ecp5 -no-rw-check -nolutram -top top; write_json top.json",
                ],
                cwd=folder,
                check=True,
            )
            before = json.loads((folder / "top.json").read_text())["modules"]["top"]["cells"]
            result = subprocess.run(
                [sys.executable, TOOL, "top.json", "to.json", *arguments],
                cwd=folder,
                capture_output=True,
                text=True,
                check=True,
            )
            after = json.loads((folder / "to.json").read_text())["modules"]["top"]["cells"]
            gone = int(re.match(r"\d+", result.stdout)[0])
            flip_flops = [sum(cell["type"] == "TRELLIS_FF" for cell in cells.values()) for cells in (before, after)]
            self.assertEqual(flip_flops[0] - flip_flops[1], gone)
            return after, gone

    def check(self, behind, gone, width=18):
        cells, went = self.changed(behind, width)
        self.assertEqual(went, gone, behind)
        for ram in [cell for cell in cells.values() if cell["type"] == "DP16KD"]:
            modes = {ram["parameters"][f"REGMODE_{side}"] for side in "AB"}
            self.assertEqual("OUTREG" in modes, gone > 0, behind)

    def test_registers_go_in(self):
        self.check("always @(posedge clk) q <= word;" + ONE_LOAD, 18)
        self.check("always @(posedge clk) if (enable) q <= word;" + ONE_LOAD, 18)

    def test_word_on_both_ports(self):
        cells, gone = self.changed("always @(posedge clk) if (enable) q <= word;" + ONE_LOAD, 36)
        self.assertEqual(gone, 36)
        ram = next(cell for cell in cells.values() if cell["type"] == "DP16KD")
        self.assertEqual([ram["parameters"][f"REGMODE_{side}"] for side in "AB"], ["OUTREG", "OUTREG"])
        self.assertEqual(ram["connections"]["OCEA"], ram["connections"]["OCEB"])
        self.assertIsInstance(ram["connections"]["OCEA"][0], int)

    def test_others_stay(self):
        self.check("always @(posedge clk) if (reset) q <= 0; else q <= word;" + ONE_LOAD, 0)
        self.check("always @(posedge other) q <= word;" + ONE_LOAD, 0)
        self.check("always @(negedge clk) q <= word;" + ONE_LOAD, 0)
        self.check("always @(posedge clk) q <= word; assign q2 = word;", 0)
        self.check(
            "always @(posedge clk) begin if (enable) q[8:0] <= word[8:0]; if (enable2) q[17:9] <= word[17:9]; end"
            + ONE_LOAD,
            0,
        )
        self.check("always @(posedge clk) q <= ~word;" + ONE_LOAD, 0)
        self.check("always @(posedge clk) q <= {word[17:9], data[8:0]}; assign q2 = word[8:0];", 0)

    def test_every_memory_has_its_own_site(self):
        cells, _ = self.changed("always @(posedge clk) q <= word;" + ONE_LOAD, 180, ["--sites"])
        sites = [cell["attributes"]["BEL"] for cell in cells.values() if cell["type"] == "DP16KD"]
        self.assertEqual(len(sites), 5)
        self.assertEqual(len(set(sites)), 5)

    def test_too_many_memories(self):
        with tempfile.TemporaryDirectory(prefix="ecp5_memories.") as name:
            folder = pathlib.Path(name)
            cells = {
                f"u_memory.gen_group[0].u_ram.{i}": {
                    "type": "DP16KD",
                    "attributes": {},
                    "parameters": {},
                    "connections": {},
                    "port_directions": {},
                }
                for i in range(209)
            }
            (folder / "full.json").write_text(
                json.dumps({"modules": {"top": {"attributes": {"top": "1"}, "ports": {}, "cells": cells}}})
            )
            result = subprocess.run(
                [sys.executable, TOOL, "full.json", "to.json", "--sites"],
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
            )
            self.assertEqual(result.returncode, 1)
            self.assertEqual(
                result.stderr, "ecp5_memories.py: full.json: 209 block RAMs have no room in 4 rows of 52\n"
            )
            self.assertFalse((folder / "to.json").exists())


if __name__ == "__main__":
    unittest.main()
