#!/usr/bin/env python3
"""Counts Spartan-3 primitives in netlists of Yosys, as a Markdown table.

    resource_table.py --top MODULE [--depth N] [--sum TITLE=INSTANCE,...] BLOCKS.json FLAT.json
        one row for each block of BLOCKS.json (hierarchy kept), with all it contains, down to depth N;
        then the sums asked for, the total, and the total of FLAT.json (flattened)
    resource_table.py --insert NAME TEXT.md README.md
        puts TEXT.md between the markers `BEGIN GENERATED NAME` and `END GENERATED NAME` of README.md

Standard library only.
"""

import argparse
import collections
import json
import pathlib
import re
import sys

COLUMNS = ["LUT4", "of it RAM", "FF", "MUXF5-8", "carry", "RAMB16", "MULT18X18"]
# LUTs a distributed memory takes
LUT_RAM = {"RAM16X1S": 1, "RAM16X1D": 2, "RAM32X1S": 2, "RAM32X1D": 4, "RAM64X1S": 4, "RAM64X1D": 8}
NOT_COUNTED = re.compile(r"GND|VCC|BUFG\w*|IBUF\w*|OBUF\w*|\$scopeinfo")


class TableError(Exception):
    """The netlist or the file to change is not as expected."""


def cost(primitive):
    """What one primitive adds to the columns."""
    if re.fullmatch(r"LUT[1-4]|INV", primitive):
        return {"LUT4": 1}
    if re.fullmatch(r"FD\w*", primitive):
        return {"FF": 1}
    if re.fullmatch(r"MUXF[5-8]", primitive):
        return {"MUXF5-8": 1}
    if primitive in ("MUXCY", "XORCY", "MULT_AND", "ORCY"):
        return {"carry": 1} if primitive == "MUXCY" else {}
    if re.fullmatch(r"SRL16\w*", primitive):
        return {"LUT4": 1}
    if re.sub(r"_1$", "", primitive) in LUT_RAM:
        luts = LUT_RAM[re.sub(r"_1$", "", primitive)]
        return {"LUT4": luts, "of it RAM": luts}
    if primitive.startswith("RAMB16"):
        return {"RAMB16": 1}
    if primitive.startswith("MULT18X18"):
        return {"MULT18X18": 1}
    if NOT_COUNTED.fullmatch(primitive):
        return {}
    raise TableError(f"primitive {primitive} is in no column of the table")


class Netlist:
    """A netlist of Yosys; modules may be named $paramod...\\name..."""

    def __init__(self, path):
        modules = json.loads(pathlib.Path(path).read_text())["modules"]
        self.cells = {name: body["cells"] for name, body in modules.items()
                      if int(body["attributes"].get("blackbox", "0"), 2) == 0
                      and int(body["attributes"].get("whitebox", "0"), 2) == 0}

    def top(self, name):
        """The module's name in the netlist (a changed parameter renames it)."""
        if name in self.cells:
            return name
        found = [module for module in self.cells if plain_name(module) == name]
        if len(found) != 1:
            raise TableError(f"{len(found)} modules of the netlist are called {name}")
        return found[0]

    def total(self, module):
        """Sum over the module and all it contains."""
        total = collections.Counter()
        for cell in self.cells[module].values():
            kind = cell["type"]
            total.update(self.total(kind) if kind in self.cells else cost(kind))
        return total

    def children(self, module):
        """(instance, module) of the blocks directly inside, by instance name."""
        return sorted((name, cell["type"]) for name, cell in self.cells[module].items() if cell["type"] in self.cells)


def plain_name(module):
    """sp_fifo for $paramod$0123\\sp_fifo or $paramod\\sp_fifo\\Width=..."""
    match = re.match(r"\$paramod(?:\$\w+)?\\(\w+)", module)
    return match.group(1) if match else module


def row(name, counts):
    return f"| {name} | " + " | ".join(f"{counts[column]:,}" if counts[column] else "–" for column in COLUMNS) + " |"


def table(top, depth, sums, blocks, flat):
    lines = ["| block | " + " | ".join(COLUMNS) + " |", "|---|" + "---:|" * len(COLUMNS)]

    def descend(module, level):
        own = blocks.total(module)
        for instance, child in blocks.children(module):
            counts = blocks.total(child)
            own.subtract(counts)
            lines.append(row("&emsp;" * level + f"`{instance}` ({plain_name(child)})", counts))
            if level + 1 < depth and blocks.children(child):
                descend(child, level + 1)
        lines.append(row("&emsp;" * level + "own logic", own))

    root = blocks.top(top)
    descend(root, 0)
    children = dict(blocks.children(root))
    for title, instances in sums:
        if all(instance in children for instance in instances):
            counts = sum((blocks.total(children[instance]) for instance in instances), collections.Counter())
            lines.append(row(f"**{title}**", counts))
    lines.append(row("**all blocks**", blocks.total(root)))
    lines.append(row("**flattened**", flat.total(flat.top(top))))
    return "\n".join(lines)


def insert(name, text, readme):
    begin, end = f"<!-- BEGIN GENERATED {name} -->", f"<!-- END GENERATED {name} -->"
    old = readme.read_text()
    if old.count(begin) != 1 or old.count(end) != 1 or old.index(begin) > old.index(end):
        raise TableError(f"{readme} does not hold the two markers of {name} once each")
    head, rest = old.split(begin)
    readme.write_text(head + begin + "\n" + text.strip("\n") + "\n" + end + rest.split(end)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--top", help="the module")
    parser.add_argument("--depth", type=int, default=2, help="levels of blocks to list")
    parser.add_argument("--sum", metavar="TITLE=INSTANCE,...", action="append", default=[],
                        help="a row for the sum of these blocks of the top module, where it has them all")
    parser.add_argument("--insert", metavar="NAME", help="put the first file between the second one's markers")
    parser.add_argument("files", nargs=2, type=pathlib.Path)
    arguments = parser.parse_args()
    try:
        if arguments.insert:
            insert(arguments.insert, arguments.files[0].read_text(), arguments.files[1])
        elif arguments.top:
            sums = [(title, instances.split(",")) for title, instances in (text.split("=") for text in arguments.sum)]
            print(table(arguments.top, arguments.depth, sums, *map(Netlist, arguments.files)))
        else:
            parser.error("--top or --insert is needed")
    except (OSError, KeyError, ValueError, TableError) as error:
        print(f"resource_table.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
