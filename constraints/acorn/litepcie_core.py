#!/usr/bin/env python3
"""Makes LitePCIe's core for the Acorn by litepcie_gen of PyPI, as litepcie.yml says, and prints the path of its Verilog
file.

Beside it, in build/acorn, lie pcie_s7.v, the ports of the FPGA's block for PCI Express; pcie_s7.tcl, which makes that
block with the vendor's tool; and driver/, LitePCIe's kernel driver for this core. What is current already is not made
again. The places of registers must be those in host/driver/litepcie_interface.h. Where PyPI is not reached the script
prints one line and exits with status 77. Standard library only.
"""

import hashlib
import pathlib
import re
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi, tools  # noqa: E402

HOME = ROOT / "build" / "acorn"
LITEPCIE = pypi.Environment(HOME / "venv", ["litepcie==2024.12", "litex==2024.12"])
SETTINGS = HERE / "litepcie.yml"
INTERFACE = ROOT / "host" / "driver" / "litepcie_interface.h"
CORE = HOME / "litepcie_core.v"
BLOCK = "pcie_s7"
# Where the simulation puts what the block does (pcie_s7.svh)
BODY = "`ifdef SELFPROJ_PCIE_S7_BODY\n`include `SELFPROJ_PCIE_S7_BODY\n`endif\n"


def only(found, what):
    if len(found) != 1:
        raise tools.ToolError(f"{what} is found {len(found)} times, not once")
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
                raise tools.ToolError(f"port {name} of {BLOCK}: '{expression}' is not understood")
            found.append((direction, int(constant[1]) if constant else width_of[expression], name))
    if not found:
        raise tools.ToolError(f"{BLOCK} has no ports")
    return found


def block(text):
    lines = [f"  {direction} wire {f'[{width - 1}:0] ' if width > 1 else ''}{name}"
             for direction, width, name in ports(text)]
    return ("// The ports of the block for PCI Express, as LitePCIe connects them; by constraints/acorn/litepcie_core.py.\n"
            f"(* blackbox *)\nmodule {BLOCK} (\n" + ",\n".join(lines) + f"\n);\n{BODY}endmodule\n")


def tcl(text):
    """Returns the commands that make the block with the vendor's tool."""
    make = only(re.findall(rf"^create_ip .*?^synth_ip [^\n]*$", text, re.M | re.S), "create_ip ... synth_ip")
    return make + "\n"


def with_memory(text, made):
    """Copies the one memory that the core reads from a file, and returns the core with its path."""
    name = only(re.findall(r'\$readmemh\("([^"]+)"', text), "a memory in a file")
    shutil.copy(only(list(made.rglob(name)), name), HOME)
    return text.replace(f'"{name}"', f'"{HOME / name}"')


def check_places(headers):
    """Compares the places of registers with the program's."""
    defined = dict(re.findall(r"^#define (\w+) \(?(?:CSR_BASE \+ )?(0x[0-9a-fA-F]+|\d+)L?\)?", headers, re.M))
    mine = dict(re.findall(r"uint32_t (k\w+) = (0x[0-9a-fA-F]+);", INTERFACE.read_text(encoding="utf-8")))
    for name, macro in (("kBoardRegisters", "MMAP_BASE"),
                        ("kLoopStatus", "CSR_PCIE_DMA0_WRITER_TABLE_LOOP_STATUS_ADDR")):
        if macro not in defined:
            raise tools.ToolError(f"{macro} is not in the headers")
        if int(defined[macro], 0) != int(mine[name], 0):
            raise tools.ToolError(f"{macro} is {defined[macro]}, but {name} of {INTERFACE.relative_to(ROOT)} is "
                            f"{mine[name]}")


def make():
    programs = LITEPCIE.need()
    made = HOME / "litepcie"
    shutil.rmtree(made, ignore_errors=True)
    made.mkdir()
    shutil.copy(SETTINGS, made)
    tools.run([programs / "litepcie_gen", SETTINGS.name], made, log=HOME / "litepcie.log")
    text = only(list(made.rglob(CORE.name)), CORE.name).read_text(encoding="utf-8")
    script = only(list(made.rglob("litepcie_core.tcl")), "litepcie_core.tcl").read_text(encoding="utf-8")
    headers = [made / name for name in ("csr.h", "soc.h", "mem.h")]
    check_places("".join(path.read_text(encoding="utf-8") for path in headers))
    (HOME / f"{BLOCK}.v").write_text(block(text), encoding="utf-8")
    (HOME / f"{BLOCK}.tcl").write_text(tcl(script), encoding="utf-8")
    CORE.write_text(with_memory(text, made), encoding="utf-8")
    software = only(list(LITEPCIE.home.glob("lib/python3*/site-packages/litepcie/software")), "LitePCIe's driver")
    shutil.rmtree(HOME / "driver", ignore_errors=True)
    shutil.copytree(software, HOME / "driver", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    for path in headers:
        shutil.copy(path, HOME / "driver" / "kernel")


def core():
    """Returns the path of the core."""
    HOME.mkdir(parents=True, exist_ok=True)
    done = HOME / "litepcie_core.v.made"
    mark = " ".join(LITEPCIE.packages) + "".join(hashlib.sha256(path.read_bytes()).hexdigest()
                                                 for path in (SETTINGS, INTERFACE, pathlib.Path(__file__)))
    if not CORE.exists() or not done.exists() or done.read_text(encoding="utf-8") != mark:
        done.unlink(missing_ok=True)
        make()
        done.write_text(mark, encoding="utf-8")
    return CORE


def main():
    print(core().relative_to(ROOT))
    return 0


if __name__ == "__main__":
    tools.exit_of(main)
