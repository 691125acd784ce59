"""Handles what the open FPGA tools write: cells and order of a netlist, worst paths of a placement.

Standard library only.
"""

import collections
import json
import re

# Column of the table, and how many of it a primitive takes
PRIMITIVES = [
    (r"LUT[1-6]|SB_LUT4|INV", "lut", 1),
    (r"RAM(16|32|64)X1S.*", "lut", 1), (r"RAM(16|32|64)X1D.*", "lut", 2), (r"RAM32M|RAM64M", "lut", 4),
    (r"RAM128X1D", "lut", 4), (r"RAM256X1S", "lut", 4), (r"SRL.*", "lut", 1), (r"TRELLIS_DPR16X4", "lut", 6),
    (r"CCU2C", "lut", 2),
    (r"FD\w*|SB_DFF\w*|TRELLIS_FF|LD\w*", "ff", 1),
    (r"RAMB16\w*|RAMB18\w*|DP16KD|PDPW16KD|SB_RAM40_4K\w*", "ram", 1), (r"RAMB8\w*", "ram", 0.5),
    (r"RAMB36\w*", "ram", 2),
    (r"MULT18X18\w*|DSP48\w*|SB_MAC16", "mult", 1),
]
NOT_COUNTED = re.compile(r"MUXF\d|MUXCY|XORCY|MULT_AND|ORCY|CARRY4|SB_CARRY|PFUMX|L6MUX21|BUFG\w*|GND|VCC|"
                         r"\$scopeinfo|GSR|I?O?BUFT?|IBUFDS\w*|PLLE2_BASE|MMCME2_ADV|pcie_s7")
COLUMNS = {"lut": "LUT", "ff": "FF", "ram": "block RAM", "mult": "multiplier"}


class FpgaError(Exception):
    """A tool failed, or its answer is not understood."""


def count(netlist):
    """Returns the resources of the netlist by column: of each block of the top, and of the whole."""
    bodies = {name: body for name, body in json.loads(netlist)["modules"].items()
              if not any(int(body["attributes"].get(box, "0"), 2) for box in ("blackbox", "whitebox"))}

    def total(cells):
        counts = collections.Counter()
        for cell in cells.values():
            if cell["type"] in bodies:
                counts.update(total(bodies[cell["type"]]["cells"]))
                continue
            for pattern, column, number in PRIMITIVES:
                if re.fullmatch(pattern, cell["type"]):
                    counts[column] += number
                    break
            else:
                if not NOT_COUNTED.fullmatch(cell["type"]):
                    raise FpgaError(f"primitive {cell['type']} is in no column of the table")
        return counts

    top = next(body for body in bodies.values() if body["attributes"].get("top"))["cells"]
    blocks = {name: total({name: cell}) for name, cell in top.items() if cell["type"] in bodies}
    return blocks, total(top)


def canonical(netlist):
    """Returns the netlist in an order that follows from its names alone, without the places in the sources.

    Yosys orders cells and numbers wires as it makes them, so that a line more in a source, or a module that nobody
    uses, would draw all placements anew.
    """
    data = json.loads(netlist)
    body = next(body for body in data["modules"].values() if body["attributes"].get("top"))
    numbers = {}

    def number(bits):
        return [numbers.setdefault(bit, len(numbers) + 2) if isinstance(bit, int) else bit for bit in bits]

    for port in body["ports"].values():
        port["bits"] = number(port["bits"])
    for kind in ("cells", "netnames"):
        body[kind] = dict(sorted(body[kind].items()))
        for of in body[kind].values():
            of["attributes"].pop("src", None)
    for cell in body["cells"].values():
        cell["connections"] = {port: number(bits) for port, bits in sorted(cell["connections"].items())}
    for net in body["netnames"].values():
        net["bits"] = number(net["bits"])
    body["attributes"].pop("src", None)
    return json.dumps(data, indent=1)


def worst_path(log):
    """Returns the register in which the worst path of the pixel clock begins, and the blocks through which it runs, as
    instance names of the board's blocks. Registers of sp_board_pins, which are in none of them, are of the pins."""
    reports = re.findall(r"Critical path report for clock '(?:\$glbnet\$)?clk_i[^\n]*\n(.*?)Info: [\d.]+ ns logic", log,
                         re.S)
    if not reports:
        return "?"
    names = re.findall(r"(?:Source|Sink) (\S+)\.\w+(?:\[\d+\])?$", reports[-1], re.M)
    # The cell is named after the net, with what the mapper added behind.
    begin = re.sub(r"_(SB|TRELLIS|LUT4|PFUMX|L6MUX21|CCU2C|DP16KD|PDPW16KD|MULT18X18D)_\w*$", "", names[0])
    blocks = [f"`{begin.removeprefix('u_board.')}`" + ("" if begin.startswith("u_board.") else " of the pins")]
    for name in names[1:]:
        block = ".".join(part for part in name.removeprefix("u_board.").split(".")[:-1] if part.startswith("u_"))
        if block and blocks[-1] != f"`{block}`":
            blocks.append(f"`{block}`")
    return " → ".join(blocks)
