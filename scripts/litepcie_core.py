#!/usr/bin/env python3
"""Takes what litepcie_gen has written apart, for litepcie_core.sh.

    litepcie_core.py MADE ENVIRONMENT HOME

MADE is the folder in which litepcie_gen ran, ENVIRONMENT the virtual environment with LitePCIe, HOME the folder that
gets litepcie_core.v, pcie_s7.v, pcie_s7.tcl and driver/. Exit status 1 and one line if a place of a register is not the
one in host/driver/litepcie_interface.h. Standard library only.
"""

import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
INTERFACE = ROOT / "host" / "driver" / "litepcie_interface.h"
BLOCK = "pcie_s7"
# Where the simulation puts what the block does (sim/target/pcie_s7.svh)
BODY = "`ifdef SELFPROJ_PCIE_S7_BODY\n`include `SELFPROJ_PCIE_S7_BODY\n`endif\n"


class CoreError(Exception):
    """The generator wrote something else than expected."""


def only(found, what):
    if len(found) != 1:
        raise CoreError(f"{what} is found {len(found)} times, not once")
    return found[0]


def widths(text):
    """Returns the width of each wire and register of the core by its name."""
    found = {}
    declared = r"^\s*(?:input |output |inout |)\s*(?:wire|reg)\s+(?:\[(\d+):0\])?\s*(\w+)"
    for high, name in re.findall(declared, text, re.M):
        found[name] = int(high) + 1 if high else 1
    return found


def ports(text):
    """Returns the block's ports, (direction, width, name), by the core's instance of it."""
    body = only(re.findall(rf"^{BLOCK} {BLOCK}\s*\((.*?)^\);", text, re.M | re.S), f"an instance of {BLOCK}")
    width_of = widths(text)
    found = []
    for line in body.splitlines():
        if heading := re.fullmatch(r"\s*// (Inputs|Outputs)\.", line):
            direction = {"Inputs": "input", "Outputs": "output"}[heading[1]]
        elif port := re.fullmatch(r"\s*\.(\w+)\s*\((.*)\),?", line):
            name, expression = port.groups()
            constant = re.fullmatch(r"(\d+)'[bdh]\w+", expression)
            if not constant and expression not in width_of:
                raise CoreError(f"port {name} of {BLOCK}: '{expression}' is not understood")
            found.append((direction, int(constant[1]) if constant else width_of[expression], name))
    if not found:
        raise CoreError(f"{BLOCK} has no ports")
    return found


def block(text):
    lines = [f"  {direction} wire {f'[{width - 1}:0] ' if width > 1 else ''}{name}"
             for direction, width, name in ports(text)]
    return ("// The ports of the block for PCI Express, as LitePCIe connects them; by scripts/litepcie_core.py.\n"
            f"(* blackbox *)\nmodule {BLOCK} (\n" + ",\n".join(lines) + f"\n);\n{BODY}endmodule\n")


def tcl(text):
    """Returns the commands that make the block with the vendor's tool."""
    make = only(re.findall(rf"^create_ip .*?^synth_ip [^\n]*$", text, re.M | re.S), "create_ip ... synth_ip")
    return make + "\n"


def with_memory(text, made, home):
    """Copies the one memory that the core reads from a file, and returns the core with its path."""
    name = only(re.findall(r'\$readmemh\("([^"]+)"', text), "a memory in a file")
    shutil.copy(only(list(made.rglob(name)), name), home)
    return text.replace(f'"{name}"', f'"{(home / name).resolve()}"')


def check_places(headers):
    """Compares the places of registers with the program's."""
    defined = dict(re.findall(r"^#define (\w+) \(?(?:CSR_BASE \+ )?(0x[0-9a-fA-F]+|\d+)L?\)?", headers, re.M))
    mine = dict(re.findall(r"uint32_t (k\w+) = (0x[0-9a-fA-F]+);", INTERFACE.read_text(encoding="utf-8")))
    for name, macro in (("kBoardRegisters", "MMAP_BASE"),
                        ("kLoopStatus", "CSR_PCIE_DMA0_WRITER_TABLE_LOOP_STATUS_ADDR")):
        if macro not in defined:
            raise CoreError(f"{macro} is not in the headers")
        if int(defined[macro], 0) != int(mine[name], 0):
            raise CoreError(f"{macro} is {defined[macro]}, but {name} of {INTERFACE.relative_to(ROOT)} is "
                            f"{mine[name]}")


def main():
    made, environment, home = map(pathlib.Path, sys.argv[1:])
    try:
        text = only(list(made.rglob("litepcie_core.v")), "litepcie_core.v").read_text(encoding="utf-8")
        script = only(list(made.rglob("litepcie_core.tcl")), "litepcie_core.tcl").read_text(encoding="utf-8")
        headers = [made / name for name in ("csr.h", "soc.h", "mem.h")]
        check_places("".join(path.read_text(encoding="utf-8") for path in headers))
        (home / f"{BLOCK}.v").write_text(block(text), encoding="utf-8")
        (home / f"{BLOCK}.tcl").write_text(tcl(script), encoding="utf-8")
        (home / "litepcie_core.v").write_text(with_memory(text, made, home), encoding="utf-8")
        software = only(list(environment.glob("lib/python3*/site-packages/litepcie/software")), "LitePCIe's driver")
        shutil.rmtree(home / "driver", ignore_errors=True)
        shutil.copytree(software, home / "driver", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
        for path in headers:
            shutil.copy(path, home / "driver" / "kernel")
    except (CoreError, OSError) as error:
        sys.exit(f"litepcie_core.py: {error}")


main()
