"""Makes netlists by Yosys, and reads them (Yosys's JSON): what they take of an FPGA, and hashes of their circuits.

Standard library only.
"""

import collections
import hashlib
import json
import re

from lib.tools import ToolError, in_folder, kept, version

# What Yosys makes of the sources before it maps anything: one module of word-level cells, without what has no effect
ELABORATE = "proc; flatten; opt_expr; opt_clean; opt_merge; memory_collect; opt_clean -purge"
NAMES = {"MEMID"}  # parameters of cells that hold names

# Column of the tables, and how many of it a primitive takes
PRIMITIVES = [
    (r"LUT[1-6]|SB_LUT4|INV", "lut", 1),
    (r"RAM(16|32|64)X1S.*", "lut", 1), (r"RAM(16|32|64)X1D.*", "lut", 2), (r"RAM32M|RAM64M", "lut", 4),
    (r"RAM128X1S", "lut", 2), (r"RAM128X1D", "lut", 4), (r"RAM256X1S", "lut", 4), (r"SRL.*", "lut", 1),
    (r"TRELLIS_DPR16X4", "lut", 6),
    (r"CCU2C", "lut", 2),
    (r"FD\w*|SB_DFF\w*|TRELLIS_FF|LD\w*", "ff", 1),
    (r"RAMB16\w*|RAMB18\w*|DP16KD|PDPW16KD|SB_RAM40_4K\w*", "ram", 1), (r"RAMB8\w*", "ram", 0.5),
    (r"RAMB36\w*", "ram", 2),
    (r"MULT18X18\w*|DSP48\w*|SB_MAC16", "mult", 1),
]
NOT_COUNTED = re.compile(r"MUXF\d|MUXCY|XORCY|MULT_AND|ORCY|CARRY4|SB_CARRY|PFUMX|L6MUX21|BUFG\w*|GND|VCC|"
                         r"\$scopeinfo|GSR|I?O?BUFT?|IBUFDS\w*|PLLE2_BASE|MMCME2_ADV|pcie_s7")
COLUMNS = {"lut": "LUT", "ff": "FF", "ram": "block RAM", "mult": "multiplier"}


def netlist(commands, texts, log=None):
    """Returns the netlist that Yosys's commands make of the sources `texts`. It is made once for the same inputs."""
    def make():
        return in_folder(texts, ["yosys", "-q", "-p", f"{commands}; write_json netlist.json"], ["netlist.json"],
                         log=log)[1]

    return kept([version("yosys"), commands, *texts.values()], make)


def top_of(data):
    """Returns the top module of a netlist that json has read."""
    return next(body for body in data["modules"].values() if body["attributes"].get("top"))


def wires(ports, driver):
    """Returns what ports (name, bits) are wired to: a text with drivers by number, and the drivers in that order."""
    drivers = {}
    text = []
    for name, bits in sorted(ports):
        text.append(f"{name}:")
        for bit in bits:
            source, place = driver.get(bit, (None, f"open {bit}" if isinstance(bit, str) else "open"))
            number = drivers.setdefault(source, len(drivers)) if source is not None else ""
            text.append(f"{number}.{place}")
    return " ".join(text), list(drivers)


def structure(text):
    """Returns a hash of the top module of a flat netlist that does not depend on names.

    A cell's label begins as its kind, its parameters and how its inputs are wired. Then every label takes in those of
    the cells that drive it, again and again, until no more cells become different from each other (the refinement of
    Weisfeiler and Leman). Circuits that are equal but for their names have equal labels. Different circuits have equal
    labels only by a collision, or if they have cells that their whole input cones do not tell apart.
    """
    body = top_of(json.loads(text))
    driver = {}
    for name, port in body["ports"].items():
        if port["direction"] == "input":
            driver.update({bit: (None, f"{name}[{i}]") for i, bit in enumerate(port["bits"])})
    cells = body["cells"]
    for name, cell in cells.items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] == "output":
                driver.update({bit: (name, f"{port}[{i}]") for i, bit in enumerate(bits)})

    inputs = {name: wires(((port, bits) for port, bits in cell["connections"].items()
                           if cell["port_directions"][port] == "input"), driver) for name, cell in cells.items()}
    fixed = {name: repr((cell["type"], sorted((key, value) for key, value in cell["parameters"].items()
                                              if key not in NAMES), inputs[name][0])) for name, cell in cells.items()}
    outputs, ends = wires(((name, port["bits"]) for name, port in body["ports"].items()
                           if port["direction"] == "output"), driver)

    labels = dict.fromkeys(cells, "")
    different = 0
    while True:
        labels = {name: hashlib.sha256("\n".join([fixed[name], *(labels[of] for of in inputs[name][1])]).encode())
                  .hexdigest() for name in cells}
        if len(set(labels.values())) == different:
            break
        different = len(set(labels.values()))
    ports = sorted((name, port["direction"], len(port["bits"])) for name, port in body["ports"].items())
    whole = [repr(ports), outputs, *(labels[end] for end in ends), *sorted(labels.values())]
    return hashlib.sha256("\n".join(whole).encode()).hexdigest()[:16]


def circuit_hash(read, texts, top):
    """Returns the hash of the circuit `top`, which does not depend on names, lines and order of the sources `texts`.
    `read` are Yosys's commands that read them and set parameters."""
    commands = f"{read}hierarchy -check -top {top}; {ELABORATE}; write_json circuit.json"
    return structure(in_folder(texts, ["yosys", "-q", "-p", commands], ["circuit.json"])[1])


def count(text):
    """Returns the resources of a netlist by column: of each block of the top, and of the whole."""
    data = json.loads(text)
    bodies = {name: body for name, body in data["modules"].items()
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
                    raise ToolError(f"primitive {cell['type']} is in no column of the table")
        return counts

    cells = top_of(data)["cells"]
    blocks = {name: total({name: cell}) for name, cell in cells.items() if cell["type"] in bodies}
    return blocks, total(cells)


def canonical(text):
    """Returns the netlist in an order that follows from its names alone, without the places in the sources.

    Yosys orders cells and numbers wires as it makes them, so that a line more in a source, or a module that nobody
    uses, would draw all placements anew.
    """
    data = json.loads(text)
    body = top_of(data)
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
