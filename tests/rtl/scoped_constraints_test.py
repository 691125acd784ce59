"""The constraints in constraints/xilinx7/scoped cover every crossing between clocks, of the board and of the front ends
of cameras, and name only what is in their modules. Without Vivado: the crossings are those that crossings.py finds, and
tclsh reads the files, where there is one.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "rtl"))
import crossings  # noqa: E402

XILINX = ROOT / "constraints" / "xilinx7"
FILES = sorted((XILINX / "scoped").glob("sp_*.xdc"))
# Commands of Vivado that the files use; each says what it was given.
STUBS = """
foreach name {set_max_delay set_bus_skew set_false_path add_files set_property} {
  proc $name {args} "puts \\"$name \\$args\\""
}
proc get_ports {name} { return "port:$name" }
proc get_clocks {args} { return "clock" }
proc get_files {name} { return $name }
proc get_cells {args} { return "cells:[lindex $args end]" }
proc get_property {args} { return 6.613 }
source [lindex $argv 0]
"""


def rules_of(text):
    """Yields (from, to) of the exceptions of a file: patterns of registers below the module, or None for a clock."""
    for command in re.findall(r"^(?:set_max_delay|set_false_path) .*", text.replace("\\\n", " "), flags=re.M):
        yield tuple(patterns(command, option) for option in ("-from", "-to"))


def patterns(command, option):
    cells = re.search(rf"{option} \[get_cells (?:-quiet )?\{{([^}}]*)\}}\]", command)
    if cells is None:
        return None
    return [name.replace("_reg[*]", "").removesuffix("_reg").replace("/", ".") for name in cells[1].split()]


class Design:
    """A flattened design: its crossings, and the instances of the modules that have constraints."""

    def __init__(self, top, parameters):
        module = crossings.netlist(ROOT / "rtl", top, parameters, [])
        self.crossings = crossings.Graph(module).crossings()
        self.bits = {name: tuple(net["bits"]) for name, net in module["netnames"].items()}
        self.names = {}
        for name, net in self.bits.items():
            self.names.setdefault(net, set()).add(name)
        self.places = set()  # (path with a point at its end, module)
        for file in FILES:
            text = next(path for path in crossings.rtl_tree.sources() if path.stem == file.stem).read_text()
            # An instance of the module is where all of its synchronizers and memories are.
            ends = [f"{name}.{'wr_clk_i' if kind == 'sp_ram' else 'clk_i'}" for kind, name in
                    re.findall(r"^  (sp_sync|sp_ram)\b[^;]*?\b(u_\w+) \(", text, flags=re.M)]
            paths = {name.removesuffix(ends[0]) for name in self.bits if f".{name}".endswith(f".{ends[0]}")}
            self.places |= {(path, file.stem) for path in paths if all(path + end in self.bits for end in ends)}

    def called(self, name):
        """Returns all names of a register, those that are known under another one included."""
        if name.endswith(" (read)"):
            name = name.removesuffix(" (read)").removesuffix("memory") + "rd_data_o"
        return {name} | self.names.get(self.bits.get(name, ()), set())

    def uncovered(self, rules):
        """Returns the crossings that no rule covers."""
        def fits(wanted, path, have):
            return wanted is None or any(path + name in have for name in wanted)

        return [(source, target) for source, _, target, _ in self.crossings
                if not any(fits(of, path, self.called(source)) and fits(to, path, self.called(target))
                           and (of is not None or source.startswith(path))
                           for path, kind in self.places for of, to in rules[kind])]


class Scoped(unittest.TestCase):
    def setUp(self):
        self.rules = {file.stem: list(rules_of(file.read_text())) for file in FILES}

    def test_every_crossing_is_covered(self):
        found = 0
        for top, parameters in ((top.module, top.parameters) for top in crossings.TOPS if not top.files):
            design = Design(top, parameters)
            found += len(design.crossings)
            self.assertEqual(design.uncovered(self.rules), [], top)
            own = {"sp_board": ["sp_async_fifo", "sp_packet_fifo", "sp_axil_bridge"], "sp_replay": ["sp_replay"],
                   "sp_parallel_sensor": ["sp_beat_crossing"]}
            if top in own:
                for kind in own[top]:
                    for at in range(len(self.rules[kind])):
                        less = self.rules | {kind: self.rules[kind][:at] + self.rules[kind][at + 1:]}
                        self.assertNotEqual(design.uncovered(less), [], f"{kind} without its rule {at}")
        self.assertGreater(found, 60)

    def test_every_name_is_a_register_of_the_module(self):
        for file in FILES:
            sources = {path.stem: path.read_text() for path in crossings.rtl_tree.sources()}
            self.assertTrue(self.rules[file.stem], file.name)
            for name in {name for rule in self.rules[file.stem] for part in rule if part for name in part}:
                *inner, register = name.split(".")
                module = file.stem
                for instance in inner:
                    module = re.search(rf"\b(sp_\w+) (?:#\((?:[^;]*?)\) )?{instance} \(", sources[module])[1]
                self.assertRegex(sources[module], rf"\b{register}\b[^;=]*<=", f"{file.name}: {name}")

    @unittest.skipUnless(shutil.which("tclsh"), "there is no tclsh")
    def test_files_are_tcl(self):
        with tempfile.TemporaryDirectory(prefix="scoped.") as folder:
            stubs = pathlib.Path(folder) / "stubs.tcl"
            stubs.write_text(STUBS)
            for file in [*FILES, XILINX / "scoped.tcl"]:
                done = subprocess.run(["tclsh", stubs, file], capture_output=True, text=True, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ""), file)
                if file.suffix == ".tcl":
                    for scoped in FILES:
                        self.assertIn(f"set_property SCOPED_TO_REF {scoped.stem} {scoped}\n", done.stdout)
                else:
                    self.assertRegex(done.stdout, r"^set_(max_delay|false_path) ")


if __name__ == "__main__":
    unittest.main()
