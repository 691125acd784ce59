#!/usr/bin/env python3
"""Lists every signal that crosses between the clocks of sp_board, and why the crossing is safe.

    crossings.py [--rtl FOLDER] [--top MODULE | --target FILE...] [--parameters NAME=VALUE ...]

Yosys elaborates the board, or another module of rtl/, such as the front end of a camera, or the module of the first
FILE, which has the board as u_board. A crossing is a register or memory of one clock whose inputs depend on a register
or memory of another. Each must be a synchronizer's first flop (sp_sync) with no logic before it, or stand in
rtl/crossings.txt (for modules of rtl/camera, in crossings.txt there), whose lines are

    from | to | why it is safe

with regular expressions for the two names; an indented line continues the one before. Exit status 1 and one line for
each crossing that is neither, and for each line that fits none. Standard library only.
"""

import argparse
import collections
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import reason_list, rtl_tree, tools, yosys  # noqa: E402

BOARD = "sp_board"


def list_of(top):
    """Returns the path of the list that has the crossings of a module of rtl/."""
    folder = next(path for path in rtl_tree.sources() if path.stem == top).parent
    return (folder if folder.name == "camera" else ROOT / "rtl") / "crossings.txt"


def netlist(rtl, top, parameters, target):
    """The flattened module after `proc` and `memory`, as Yosys's JSON. `target`: files that it needs beside rtl/."""
    files = rtl_tree.sources_of(top, rtl, target)
    files += [path for path in target if path not in files]
    files = [path.resolve() for path in files]
    commands = (rtl_tree.read_command(top, parameters, files=files) + f"hierarchy -check -top {top}; proc; flatten; "
                "opt -full; memory_dff; memory_collect; opt_clean; write_json board.json")
    return yosys.top_of(json.loads(tools.in_folder({}, ["yosys", "-q", "-p", commands], ["board.json"])[1]))


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
        kind, bits, directions = cell["type"], cell["connections"], cell["port_directions"]
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rtl", type=pathlib.Path, default=ROOT / "rtl", metavar="FOLDER", help="default: rtl/")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--top", default=BOARD, metavar="MODULE", help=f"default: {BOARD}",
                       choices=[path.stem for path in rtl_tree.sources()[1:]])
    which.add_argument("--target", nargs="+", type=pathlib.Path, default=[], metavar="FILE",
                       help="instead: the file of a module that has sp_board as u_board, and what it needs")
    parser.add_argument("--parameters", nargs="*", default=[], metavar="NAME=VALUE", help="of that module")
    arguments = parser.parse_args()
    top = arguments.target[0].stem if arguments.target else arguments.top
    try:
        reasons = list_of(arguments.top)
        rules = reason_list.read(reasons)
        graph = Graph(netlist(arguments.rtl, top, arguments.parameters, arguments.target))
        crossings = graph.crossings()
    except (tools.ToolError, OSError, ValueError) as error:
        print(f"crossings.py: {error}", file=sys.stderr)
        return 1
    used = set()
    wrong = 0
    for source, source_clock, target, target_clock in crossings:
        if re.search(r"\.meta_q$", target):
            if (source, source_clock) in graph.sources((target, target_clock), direct=False):
                print(f"crossings.py: {source} -> {target}: logic before the synchronizer", file=sys.stderr)
                wrong += 1
            how = "synchronizer " + target.rsplit(".", 1)[0]
        else:
            names = source.removeprefix("u_board."), target.removeprefix("u_board.")
            fitting = [i for i, (of, to, _) in enumerate(rules) if of.fullmatch(names[0]) and to.fullmatch(names[1])]
            if not fitting:
                print(
                    f"crossings.py: {source} ({source_clock}) -> {target} ({target_clock}): "
                    f"neither a synchronizer nor in {reasons.relative_to(ROOT)}",
                    file=sys.stderr,
                )
                wrong += 1
                continue
            used.update(fitting)
            how = rules[fitting[0]][2]
        print(f"{source} ({source_clock}) -> {target} ({target_clock}): {how}")
    for i, (of, to, _) in enumerate(rules):
        if i not in used:
            print(
                f"crossings.py: {reasons.relative_to(ROOT)}: nothing crosses from {of.pattern} to {to.pattern}",
                file=sys.stderr,
            )
            wrong += 1
    if not crossings:
        print("crossings.py: no crossing found at all", file=sys.stderr)
        wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
