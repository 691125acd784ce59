"""A hash of a circuit that does not depend on names, lines and order of the sources, only on what they describe.

Standard library only.
"""

import hashlib
import json
import pathlib
import tempfile

import rtl_tree

# What Yosys makes of the sources before it maps anything: one module of word-level cells, without what has no effect
ELABORATE = "proc; flatten; opt_expr; opt_clean; opt_merge; memory_collect; opt_clean -purge"
NAMES = {"MEMID"}  # parameters of cells that hold names


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


def structure(netlist):
    """Returns a hash of the top module of a flat netlist (Yosys's JSON, as text).

    A cell's label begins as its kind, its parameters and how its inputs are wired. Then every label takes in those of
    the cells that drive it, again and again, until no more cells become different from each other (the refinement of
    Weisfeiler and Leman). Circuits that are equal but for their names have equal labels. Different circuits have equal
    labels only by a collision, or if they have cells that their whole input cones do not tell apart.
    """
    body = next(body for body in json.loads(netlist)["modules"].values() if body["attributes"].get("top"))
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


def circuit(run, read, texts, top):
    """Returns the hash of the module `top`. `run(command, folder)` runs a program; `read` are Yosys's commands that
    read the sources `texts` (text by name) and set parameters."""
    with tempfile.TemporaryDirectory() as folder:
        rtl_tree.write(texts, folder)
        run(["yosys", "-q", "-p", f"{read}hierarchy -check -top {top}; {ELABORATE}; write_json circuit.json"], folder)
        return structure((pathlib.Path(folder) / "circuit.json").read_text())
