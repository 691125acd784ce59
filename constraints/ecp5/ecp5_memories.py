#!/usr/bin/env python3
"""Between Yosys and nextpnr-ecp5: puts output registers into the block RAMs, and places the block RAMs on an LFE5U-85F.

    ecp5_memories.py NETLIST.json TO.json [--sites]

Registers. A DP16KD has a register at each output. From its clock edge a word takes 0.7 ns, instead of 4.3 ns from the
array itself. Yosys leaves the flip-flops that rtl/ has there outside, and the wires to them are the slowest of the
part. If every used output of a block RAM goes to a flip-flop of the same clock and enable, without a reset, and nowhere
else, this script removes the flip-flops, sets OUTREG on the block RAM, and connects the enable to OCE. The memory
behaves as before, except for its contents before the first word.

Sites, with --sites. The Gray decoder's memory takes most of the part. By itself the placer puts the other block RAMs
where there is room, far from their circuits. Here the four rows of 52 sites form a path that is two rows wide: along
the lower two and back along the upper two. The small memories come first, then the groups of the large one
(sp_gray_memory) from the last to the first. So every group is beside the next, and both ends are near the circuits that
read and write.

Standard library only.
"""

import argparse
import collections
import json
import pathlib
import re
import sys

OUTPUT = re.compile(r"DO([AB])\d+")

# x of the columns: EBR0 to EBR3 in every block of nine tiles, the clock spine between the seventh and the eighth
COLUMNS = [first + step for first in [*range(4, 59, 9), *range(69, 115, 9)] for step in (0, 2, 4, 6)]
LOWER, UPPER = (46, 22), (70, 82)  # y, the nearer to the middle first
FIRST = 4  # column of the lower rows with which the path begins


class NetlistError(Exception):
    """The netlist is not one that this understands."""


def top_of(netlist):
    tops = [body for body in netlist["modules"].values() if int(body["attributes"].get("top", "0"), 2)]
    if len(tops) != 1:
        raise NetlistError(f"{len(tops)} modules say that they are the top, not one")
    return tops[0]


def kind_of(register):
    """Returns the parameters, clock, enable and reset of a flip-flop as text."""
    pins = {pin: bits for pin, bits in register["connections"].items() if pin not in ("DI", "Q")}
    return json.dumps([register["parameters"], pins], sort_keys=True)


def absorb(module):
    """Moves the registers behind the block RAMs of module into them. Returns the number of flip-flops moved."""
    cells = module["cells"]
    outputs = [body for body in module["ports"].values() if body["direction"] != "input"]
    loads = collections.Counter(bit for body in outputs for bit in body["bits"])
    takers = {}
    for name, cell in cells.items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] == "input":
                for bit in bits:
                    loads[bit] += 1
                    takers[bit] = name, port
    gone = 0
    for ram in [cell for cell in cells.values() if cell["type"] == "DP16KD"]:
        pins = ram["connections"]
        used = {port: bits[0] for port, bits in pins.items() if OUTPUT.fullmatch(port) and bits and loads[bits[0]]}
        alone = {port: takers[bit] for port, bit in used.items() if loads[bit] == 1 and bit in takers}
        registers = {port: name for port, (name, pin) in alone.items()
                     if pin == "DI" and cells[name]["type"] == "TRELLIS_FF"}
        if not used or len(registers) != len(used):
            continue
        kinds = {kind_of(cells[name]) for name in registers.values()}
        like = cells[next(iter(registers.values()))]
        wide = int(ram["parameters"]["DATA_WIDTH_B"], 2) == 36
        sides = {"A", "B"} if wide else {OUTPUT.fullmatch(port)[1] for port in used}
        clocks = {tuple(pins[f"CLK{side}"]) for side in sides} | {tuple(like["connections"]["CLK"])}
        edges = {ram["parameters"].get(f"CLK{side}MUX", f"CLK{side}") == f"CLK{side}" for side in sides}
        edges.add(like["parameters"].get("CLKMUX", "CLK") == "CLK")
        # Yosys appends a blank to a text of digits.
        enable = {"CE": like["connections"].get("CE"), "1": ["1"]}.get(like["parameters"].get("CEMUX", "1").strip())
        has_reset = like["connections"].get("LSR", ["0"]) != ["0"]
        if len(kinds) != 1 or len(clocks) != 1 or len(edges) != 1 or has_reset or not enable:
            continue
        for side in sides:
            ram["parameters"][f"REGMODE_{side}"] = "OUTREG"
            pins[f"OCE{side}"] = enable
        for port, name in registers.items():
            pins[port] = cells.pop(name)["connections"]["Q"]
            gone += 1
    return gone


def sites(module):
    """Gives every block RAM of module its site on an LFE5U-85F."""
    def numbers(name):
        return [int(number) for number in re.findall(r"\d+", name)]

    large = collections.defaultdict(list)  # by groups
    near, fifos = [], []
    for name in sorted((name for name, cell in module["cells"].items() if cell["type"] == "DP16KD"), key=numbers):
        group = re.search(r"\.u_memory\.gen_group\[(\d+)\]", name)
        (large[int(group[1])] if group else fifos if ".u_fifo." in name else near).append(name)
    # A lane's sums side by side, those of one block together
    near.sort(key=lambda name: (re.sub(r"\d+", "", name.split(".gen_pair")[0]), numbers(name)))
    path = [(column, LOWER) for column in range(FIRST, len(COLUMNS))]
    path += [(column, UPPER) for column in reversed(range(len(COLUMNS)))] + [(column, LOWER) for column in range(FIRST)]

    def site(name, column, row):
        module["cells"][name]["attributes"]["BEL"] = f"X{COLUMNS[column]}/Y{row}/EBR{column % 4}"

    begun = max(len(near), len(fifos))
    rest = [(column, row) for column, rows in path[begun:] for row in rows]
    far = [name for group in sorted(large, reverse=True) for name in large[group]]
    if begun > len(COLUMNS) - FIRST or len(far) > len(rest):
        raise NetlistError(f"{len(near) + len(fifos) + len(far)} block RAMs have no room in 4 rows of {len(COLUMNS)}")
    for names, row in ((near, LOWER[0]), (fifos, LOWER[1])):
        for name, (column, _) in zip(names, path):
            site(name, column, row)
    for name, place in zip(far, rest):
        site(name, *place)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("netlist", type=pathlib.Path, help="JSON of Yosys, flat")
    parser.add_argument("to", type=pathlib.Path)
    parser.add_argument("--sites", action="store_true", help="for an LFE5U-85F")
    arguments = parser.parse_args()
    try:
        netlist = json.loads(arguments.netlist.read_text())
        module = top_of(netlist)
        gone = absorb(module)
        if arguments.sites:
            sites(module)
        arguments.to.write_text(json.dumps(netlist))
    except (OSError, KeyError, ValueError, NetlistError) as error:
        print(f"ecp5_memories.py: {arguments.netlist}: {error}", file=sys.stderr)
        return 1
    print(f"{gone} flip-flops are in block RAMs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
