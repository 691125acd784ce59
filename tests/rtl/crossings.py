#!/usr/bin/env python3
"""Lists every signal that crosses between two clocks of the project's circuits, and why the crossing is safe.

    crossings.py                                           every top that the project ships (TOPS)
    crossings.py --top MODULE [--parameters NAME=VALUE ...]  one module of rtl/, such as the front end of a camera
    crossings.py --target FILE... [--parameters ...]         the module of the first FILE, with what it needs beside rtl/

A crossing is a register or memory of one clock whose inputs depend on a register or memory of another, in the netlist
of Yosys. Each must be a synchronizer's first flop (sp_sync) with no logic before it, or stand in rtl/crossings.txt or,
for the clocks of cameras, in rtl/camera/crossings.txt. Their lines are

    from | to | why it is safe

with regular expressions for the two names, without the instances in which both of them are; an indented line continues
the one before. Exit status 1 and one line for each crossing that is neither. With all tops, also for each line that
fits none, and for each module that has two clocks, or is of a board, and is in no top. Cells of the vendors and the
generated cores (OUTSIDE) are left out like the pins of a top. `--rtl FOLDER` reads another copy of rtl/. Standard
library only.
"""

import argparse
import collections
import concurrent.futures
import dataclasses
import json
import os
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import reason_list, rtl_tree, tools, yosys  # noqa: E402

LISTS = [ROOT / "rtl" / "crossings.txt", ROOT / "rtl" / "camera" / "crossings.txt"]


@dataclasses.dataclass(frozen=True)
class Top:
    module: str
    parameters: tuple = ()  # of "NAME=VALUE"
    files: tuple = ()       # that it needs beside rtl/, below constraints/


LVDS = ("Columns=16", "Burst=16")
START = "common/ecp5_gearing_start.sv"
BOARD = ("common/sp_board_bus_pins.sv", "common/sp_board_pins.sv")
TOPS = [
    Top("sp_board"),
    Top("sp_board", ("MaxColumns=64", "MaxRows=40", "Codes=1'b1", "Verdict=1'b1", "VerdictLogSections=1")),
    Top("sp_parallel_sensor"),
    Top("sp_replay", ("MaxColumns=40", "MaxRows=9")),
    *(Top("sp_camera_link", (f"Taps={taps}",)) for taps in (1, 2, 3, 4, 8, 10)),
    Top("sp_camera_link", ("Taps=8", "Bits=10")),
    Top("sp_lvds_sensor", LVDS),
    Top("sp_lvds_sensor", ("Lanes=2", *LVDS)),
    Top("sp_lvds_sensor", ("Codes=1'b1",)),
    Top("sp_board_pins", ("MaxColumns=64", "MaxRows=40"), ("common/sp_board_pins.sv",)),
    Top("acorn", (), ("acorn/acorn.sv", "acorn/acorn_system.sv", "acorn/acorn_dma.sv")),
    Top("ecpix5", ("Sensor=1'b1",), ("ecpix5/ecpix5.sv", "ecpix5/ecpix5_system.sv")),
    Top("ecp5_camera_link_pins", ("Taps=10",), ("common/ecp5_pll.sv", START, *(
        f"camera_link/ecp5_{name}.sv" for name in ("camera_link_pins", "camera_link", "channel_link")))),
    Top("ecp5_camera_link_bank_pins", (), ("common/ecp5_pll.sv", START,
                                           "camera_link/ecp5_camera_link_bank_pins.sv",
                                           "camera_link/ecp5_camera_link_bank.sv")),
    Top("ecp5_camera_link_board", ("MaxColumns=64", "MaxRows=40"), (
        "common/ecp5_pll.sv", START, *BOARD, "camera_link/ecp5_camera_link_board.sv",
        "camera_link/ecp5_camera_link_bank.sv")),
    Top("ecp5_lvds_sensor", LVDS, (START, "lvds_sensor/ecp5_lvds_sensor.sv")),
    Top("ecp5_lvds_sensor_board", ("MaxColumns=64", "MaxRows=40", "Columns=16", "Burst=16"), (
        START, *BOARD, "lvds_sensor/ecp5_lvds_sensor_board.sv", "lvds_sensor/ecp5_lvds_sensor.sv")),
    Top("ecp5_lvds_sensor_pll", (), ("common/ecp5_pll.sv", START, "lvds_sensor/ecp5_lvds_sensor_pll.sv",
                                     "lvds_sensor/ecp5_lvds_sensor.sv")),
]
OUTSIDE = ["selfproj_liteeth", "litepcie_core", "BUFG", "IBUFDS", "MMCME2_ADV", "PLLE2_BASE", "EHXPLLL", "ECLKSYNCB",
           "CLKDIVF", "DELAYF", "DELAYG", "IDDR71B", "IDDRX2F"]


def netlist(rtl, top, parameters, target):
    """The flattened module after `proc` and `memory`, as Yosys's JSON. `target`: files that it needs beside rtl/."""
    files = [path.resolve() for name in [top, *(path.stem for path in target)]
             for path in rtl_tree.sources_of(name, rtl, target)]
    files = list(dict.fromkeys(files))
    kept = "".join(f"setattr -set keep 1 t:{cell}; " for cell in OUTSIDE if target)
    commands = (rtl_tree.read_command(top, parameters, files=files) + f"hierarchy -top {top}; proc; flatten; {kept}"
                # all of `opt -full` but opt_merge: equal registers keep their names
                "opt_expr -full; opt_muxtree; opt_reduce -full; opt_dff; opt_clean; opt_expr -full; opt_clean; "
                "memory_dff; memory_collect; opt_clean; write_json board.json")
    module = yosys.top_of(json.loads(tools.in_folder({}, ["yosys", "-q", "-p", commands], ["board.json"])[1]))
    for cell in module["cells"].values():
        if not cell["type"].startswith("$") and cell["type"] not in OUTSIDE:
            raise ValueError(f"{top}: there is no module {cell['type']}")
    return module


class Graph:
    """Registers, memories and the logic between them, bit by bit."""

    def __init__(self, module):
        self.names = {}   # bit: name of its wire, the shortest of those that were written down
        for name, net in module["netnames"].items():
            if net.get("hide_name"):
                continue
            for bit in net["bits"]:
                if isinstance(bit, int) and len(name) < len(self.names.get(bit, " " * 1000)):
                    self.names[bit] = name
        self.driver = {}  # bit: (register, clock) or the bits it follows from
        self.inputs = collections.defaultdict(set)  # (register, clock): bits
        for name, cell in module["cells"].items():
            self.add(name, cell)

    def add(self, name, cell):
        kind, bits = cell["type"], cell["connections"]
        if not kind.startswith("$"):
            return  # outside
        directions = cell["port_directions"]
        inputs = [bit for port, value in bits.items() if directions[port] == "input" for bit in value]
        outputs = [bit for port, value in bits.items() if directions[port] == "output" for bit in value]
        if re.match(r"\$(a|s)?(al)?dff", kind):
            clock = self.names.get(bits["CLK"][0])
            key = (self.names.get(outputs[0], name), clock)
            for bit in outputs:
                self.driver[bit] = key
            self.inputs[key] |= {bit for bit in inputs if isinstance(bit, int)} - set(bits["CLK"])
        elif kind.startswith("$mem"):
            self.add_memory(name, cell)
        elif kind.startswith(("$assert", "$assume", "$cover", "$print", "$check", "$scopeinfo", "$meminit")):
            return
        else:
            for bit in outputs:
                self.driver[bit] = [bit for bit in inputs if isinstance(bit, int)]

    def add_memory(self, name, cell):
        bits, parameters = cell["connections"], cell["parameters"]
        name = parameters.get("MEMID", name).lstrip("\\")
        write = (name, self.names.get(bits["WR_CLK"][0])) if bits["WR_CLK"] else (name, None)
        self.inputs[write] |= {
            bit for port in ("WR_EN", "WR_ADDR", "WR_DATA") for bit in bits[port] if isinstance(bit, int)
        }
        address = [bit for port in ("RD_ADDR", "RD_EN") for bit in bits[port] if isinstance(bit, int)]
        if "1" in parameters["RD_CLK_ENABLE"]:
            read = (name + " (read)", self.names.get(bits["RD_CLK"][0]))
            self.inputs[read] |= set(address)
            if read[1] != write[1]:
                self.inputs[read].add(("memory", write))
            for bit in bits["RD_DATA"]:
                self.driver[bit] = read
        else:
            for bit in bits["RD_DATA"]:
                self.driver[bit] = [*address, ("memory", write)]

    def sources(self, key, direct=True):
        """Returns the registers and memories that drive the inputs of a register; without `direct`, those that do so
        through logic."""
        left = [bit for bit in self.inputs[key] if direct or not isinstance(self.driver.get(bit), tuple)]
        found, seen = set(), set()
        while left:
            bit = left.pop()
            if bit in seen:
                continue
            seen.add(bit)
            if isinstance(bit, tuple):
                found.add(bit[1])
                continue
            driver = self.driver.get(bit)
            if isinstance(driver, tuple):
                found.add(driver)
            elif driver:
                left.extend(driver)
        return found

    def crossings(self):
        """(from, its clock, to, its clock), sorted."""
        return sorted({(*source, *key) for key in self.inputs for source in self.sources(key) if source[1] != key[1]},
                      key=str)


def without_shared(source, target):
    """Yields the two names, first whole, then without one more of the instances in which both are."""
    yield source, target
    while "." in source and "." in target and source.split(".")[0] == target.split(".")[0]:
        source, target = source.split(".", 1)[1], target.split(".", 1)[1]
        yield source, target


def judge(graph, rules):
    """Returns a line for each crossing, one for each that is not safe, and the numbers of the rules that fit one."""
    lines, wrong, used = [], [], set()
    for source, source_clock, target, target_clock in graph.crossings():
        if re.search(r"\.meta_q$", target):
            if (source, source_clock) in graph.sources((target, target_clock), direct=False):
                wrong.append(f"{source} -> {target}: logic before the synchronizer")
            how = "synchronizer " + target.rsplit(".", 1)[0]
        else:
            names = list(without_shared(source, target))
            fitting = [i for i, (of, to, _) in enumerate(rules)
                       if any(of.fullmatch(name) and to.fullmatch(other) for name, other in names)]
            if not fitting:
                wrong.append(f"{source} ({source_clock}) -> {target} ({target_clock}): neither a synchronizer nor in "
                             + " or ".join(str(path.relative_to(ROOT)) for path in LISTS))
                continue
            used.update(fitting)
            how = rules[fitting[0]][2]
        lines.append(f"{source} ({source_clock}) -> {target} ({target_clock}): {how}")
    if not lines:
        wrong.append("no crossing found at all")
    return lines, wrong, used


def boards():
    """Returns the sources of constraints/, without the models of cells."""
    return [path for path in sorted((ROOT / "constraints").rglob("*.sv")) if not path.stem.endswith("_cells")]


def missing(tops, rtl):
    """Yields each module with two clocks, or of a board, that is in none of the tops."""
    texts = {path: path.read_text(encoding="utf-8") for path in [*rtl_tree.sources(rtl), *boards()]}
    part = set()
    for top in tops:
        own = {path: text for path, text in texts.items()
               if rtl in path.parents or str(path.relative_to(ROOT / "constraints")) in top.files}
        for name in [top.module, *(pathlib.Path(file).stem for file in top.files)]:
            part.update(rtl_tree.needed(name, own))
    for path, text in texts.items():
        clocks = re.findall(r"^  input +wire +logic +(?:\[.*?\] *)?(\w*clk_i)\b", text, flags=re.M)
        if path not in part and (path in boards() or len(clocks) > 1):
            yield f"{path.stem}: in no top of TOPS"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rtl", type=pathlib.Path, default=ROOT / "rtl", metavar="FOLDER", help="default: rtl/")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--top", metavar="MODULE", help="default: all that the project ships",
                       choices=[path.stem for path in rtl_tree.sources()[1:]])
    which.add_argument("--target", nargs="+", type=pathlib.Path, metavar="FILE",
                       help="instead: the file of a module, and what it needs beside rtl/")
    parser.add_argument("--parameters", nargs="*", default=[], metavar="NAME=VALUE", help="of that module")
    arguments = parser.parse_args()
    if arguments.parameters and not (arguments.top or arguments.target):
        parser.error("--parameters needs --top or --target")
    if arguments.target:
        tops = [Top(arguments.target[0].stem, tuple(arguments.parameters), tuple(arguments.target))]
    else:
        tops = [Top(arguments.top, tuple(arguments.parameters))] if arguments.top else TOPS
    every = tops is TOPS

    def netlist_of(top):
        files = [pathlib.Path(ROOT / "constraints" if every else "") / file for file in top.files]
        return netlist(arguments.rtl, top.module, top.parameters, files)

    try:
        sizes = [reason_list.read(path) for path in LISTS]
        rules = [rule for one in sizes for rule in one]
        used, faults = set(), list(missing(tops, arguments.rtl)) if every else []
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for top, module in zip(tops, pool.map(netlist_of, tops)):
                lines, wrong, fitting = judge(Graph(module), rules)
                name = " ".join([top.module, *top.parameters])
                print(f"{name}:" if every else "", *lines, sep="\n  " if every else "\n")
                faults += [f"{name}: {text}" for text in wrong]
                used |= fitting
    except (tools.ToolError, OSError, ValueError) as error:
        print(f"crossings.py: {error}", file=sys.stderr)
        return 1
    if every:
        faults += [f"rtl: nothing crosses from {of.pattern} to {to.pattern}"
                   for i, (of, to, _) in enumerate(rules) if i not in used]
    for fault in faults:
        print(f"crossings.py: {fault}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
