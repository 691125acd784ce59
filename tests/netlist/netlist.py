#!/usr/bin/env python3
"""netlist.py mapped|ecp5|mutants --top MODULE --prefix NAME --out FOLDER [--mutants N] [--parameters NAME=VALUE...]

Makes a netlist of a module of rtl/ by Yosys, and of that netlist a Verilated model, class NAME, in FOLDER:

    mapped   mapped to the cells of the iCE40 as scripts/fpga.py maps the board: LUTs, carry chains, flip-flops, block
             RAM. The cells are those of Yosys's own simulation library.
    ecp5     the same for the ECP5, with every memory in block RAM and treated by constraints/ecp5/ecp5_memories.py. The
             block RAM is that of dp16kd.vh.
    mutants  flat, of Yosys's words (adders, multiplexers, registers), with N mutations. An input `mutant` of 16 bits
             turns on the mutation of its number (0: none), and NAME.mutants lists them, one a line, from number 1 on.
             sp_counter is mutated in its own netlist only. In the board only the logic outside of blocks is mutated:
             glue and the blocks' ports; in a board with the decoder or with verdicts, only what that adds, where
             registers and gate of the verdict have no netlist of their own and are not blocks.

It writes NAME.v, NAME.cpp (all that Verilator makes), NAME.h, NAME_ports.h (for tests/rtl/blocks/recorder.h).
Standard library only.
"""

import argparse
import pathlib
import re
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
import fpga  # noqa: E402
from lib import rtl_tree, tools  # noqa: E402

SELECT_BITS = 16
BOARD = "sp_board"
# The cells that these parameters add to the board
ADDED = {"*gen_codes*": "Codes=1'b1", "*gen_verdict*": "Verdict=1'b1"}
# Its users start it at zero, so no run reaches its upper chains. In its own netlist it begins just before each carry.
COUNTER = "sp_counter"


def cells_of(netlist, family):
    """Returns the models of the netlist's primitives from Yosys's library.

    Verilator accepts neither iCE40 ports with default values nor the primitives that need them; no such port is left
    open here."""
    path = (
        pathlib.Path(shutil.which("yosys") or "/usr/bin/yosys").resolve().parents[1]
        / f"share/yosys/{family}/cells_sim.v"
    )
    library = path.read_text()
    macros = "`define NO_ICE40_DEFAULT_ASSIGNMENTS\n" + library[:library.index("module ")] if family == "ice40" else ""
    models = {match[1]: match[0] for match in re.finditer(r"^module (\w+)\b.*?^endmodule", library, re.M | re.S)}
    used, new = [], [netlist]
    while new:
        names = set(re.findall(r"^\s*([A-Z]\w+) (?:#\(|\S+ +\()", "\n".join(new), re.M)) - set(used)
        missing = names - set(models)
        if missing:
            raise tools.ToolError(f"{path}: {', '.join(sorted(missing))} is not there")
        used += sorted(names)
        new = [models[name] for name in sorted(names)]
    if "DP16KD" in used:
        models["DP16KD"] = models["DP16KD"].replace("endmodule", (HERE / "dp16kd.vh").read_text() + "endmodule")
    return "\n".join([macros, *(models[name] for name in used), ""])


def yosys(commands, folder):
    tools.run(["yosys", "-q", "-p", commands], folder)


def write_mapped(top, read, path):
    # single wires instead of vectors; otherwise a vector that feeds one of its own bits looks like a loop
    yosys(f"{read}hierarchy -check -top {top}; rename -top {top}; {fpga.mapping('ice40', top)}; splitnets; "
          f"write_verilog -noattr {path.name}", path.parent)
    netlist = path.read_text()
    path.write_text(cells_of(netlist, "ice40") + netlist)


def write_ecp5(top, read, path):
    mapped, absorbed = (path.with_suffix(suffix).name for suffix in (".mapped.json", ".json"))
    yosys(f"{read}hierarchy -check -top {top}; rename -top {top}; {fpga.mapping('ecp5', top)} -nolutram; "
          f"write_json {mapped}", path.parent)
    print(f"{top}:", tools.run([*fpga.ECP5_MEMORIES[:2], mapped, absorbed], path.parent).strip())
    yosys(f"read_json {absorbed}; splitnets; write_verilog -noattr {path.name}", path.parent)
    netlist = path.read_text()
    path.write_text(cells_of(netlist, "ecp5") + netlist)


def write_mutants(top, read, path, mutants, cells="t:*"):
    listing = path.with_suffix(".mutants")
    flat = path.with_suffix(".il").name
    cells = "t:*" if top == COUNTER else f"{top}/{cells} a:src=*{COUNTER}.sv* %d"
    # modules of the board that contain blocks are flattened, and the blocks are their cells
    glue = f"{BOARD} %d *_path %d *sp_verdict_unit* %d *sp_verdict_registers* %d *sp_verdict_gate* %d"
    blocks = f"setattr -mod -set keep_hierarchy 1 *sp_* {glue}; " if top == BOARD else ""
    lines, listed, asked = [], [], 0
    while not lines or len(lines) < mutants and len(listed) == asked:
        asked = mutants + len(listed) - len(lines)
        choose = f"mutate -list {asked} -seed 1 -o {listing.name} {cells}; " if mutants else ""
        yosys(f"{read}hierarchy -check -top {top}; rename -top {top}; proc; {blocks}flatten; opt -full; "
              f"memory -nomap; opt_dff; opt_clean; check -assert; {choose}write_rtlil {flat}", path.parent)
        if not mutants:
            break
        listed = listing.read_text().splitlines()
        # Yosys stops if the two ports of a memory have different clocks.
        lines = [line for line in listed if not re.search(r" -port (RD|WR)_CLK ", line)][:mutants]
        listing.write_text("".join(line + "\n" for line in lines))
    script = [f"read_rtlil {flat}"]
    for number, line in enumerate(lines, 1):
        script.append(line.replace("mutate ", f"mutate -ctrl mutant {SELECT_BITS} {number} ", 1))
    script += ["setattr -mod -unset keep_hierarchy *", "flatten", "splitnets", "opt_clean",
               f"write_verilog -noattr {path.name}"]
    commands = path.with_suffix(".ys")
    commands.write_text("\n".join(script) + "\n")
    tools.run(["yosys", "-q", "-s", commands.name], path.parent)


def verilate(verilator, top, prefix, path):
    folder = path.parent / f"{prefix}.dir"
    shutil.rmtree(folder, ignore_errors=True)  # files of an earlier netlist, which may have had more of them
    tools.run([verilator, "--cc", "-O3", "--x-assign", "fast", "--x-initial", "unique", "--top", top, "--prefix", prefix,
               "--Mdir", folder.name, "-Wno-lint", "-Wno-style", "-Wno-UNOPTFLAT", "-Werror-PINMISSING", path.name],
              path.parent)
    sources = sorted(folder.glob("*.cpp"))
    path.with_suffix(".cpp").write_text("".join(f'#include "{source}"\n' for source in sources))
    path.with_suffix(".h").write_text(f'#include "{folder}/{prefix}.h"\n')
    ports = tools.run([sys.executable, ROOT / "tests/rtl/blocks/list_ports.py", prefix, folder / f"{prefix}.h"])
    (path.parent / f"{prefix}_ports.h").write_text(ports)


def main():
    parser = argparse.ArgumentParser(description="A module of rtl/ as a netlist, Verilated.")
    parser.add_argument("kind", choices=("mapped", "ecp5", "mutants"))
    parser.add_argument("--top", required=True)
    parser.add_argument("--prefix", required=True)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--verilator", default="verilator")
    parser.add_argument("--mutants", type=int, default=0)
    parser.add_argument("--parameters", nargs="*", default=[])
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    path = args.out.resolve() / f"{args.prefix}.v"
    # The tools run in the folder, and have no path of the machine to read: Yosys's commands and its lists of mutants
    # take no blank in one.
    rtl = path.parent / "rtl"
    rtl.unlink(missing_ok=True)
    rtl.symlink_to(ROOT / "rtl")
    files = [source.relative_to(ROOT) for source in rtl_tree.sources()]
    read = rtl_tree.read_command(args.top, args.parameters, files=files)
    if args.kind == "mapped":
        write_mapped(args.top, read, path)
    elif args.kind == "ecp5":
        write_ecp5(args.top, read, path)
    else:
        added = [cells for cells, parameter in ADDED.items() if args.top == BOARD and parameter in args.parameters]
        write_mutants(args.top, read, path, args.mutants, *added[:1])
    verilate(args.verilator, args.top, args.prefix, path)
    return 0


if __name__ == "__main__":
    tools.exit_of(main)
