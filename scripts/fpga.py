#!/usr/bin/env python3
"""What the board takes of the FPGA families that the open tools know, and the clock it reaches where they place and route.

    fpga.py table [FAMILY...]      a Markdown table: families by configurations, mapped by Yosys
    fpga.py place [--seeds N]      iCE40 HX8K: N seeds each of the moments configurations, placed and routed by nextpnr
    fpga.py update                 both, into README.md of constraints/ between its markers
    fpga.py stale                  exit status 1 and one line where rtl/ has changed since

Standard library only; called by scripts/fpga.sh, which sees to the tools.
"""

import argparse
import collections
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
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

# Name, Yosys's command, an example of the family
FAMILIES = {
    "xc3s": ("Spartan-3", "synth_xilinx -family xc3s -noiopad -nowidelut -flatten -top {top}"),
    "xc6s": ("Spartan-6", "synth_xilinx -family xc6s -noiopad -flatten -top {top}"),
    "xc7": ("7 series", "synth_xilinx -family xc7 -noiopad -flatten -top {top}"),
    "ecp5": ("ECP5", "synth_ecp5 -no-rw-check -top {top}"),
    "ice40": ("iCE40 HX", "synth_ice40 -device hx -abc9 -dff -no-rw-check -top {top}"),
}

# More weight on timing than nextpnr's own 10 and 2: the worst of four seeds went from 139 to 152 MHz.
PLACER = ["--placer-heap-timingweight", "20", "--placer-heap-critexp", "3"]

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


class FpgaError(Exception):
    """A tool failed, or an answer of it is not understood."""


def state():
    """A hash of the circuits: rtl/ without comments, blanks and proofs, and what is mapped how."""
    digest = hashlib.sha256(repr((CONFIGURATIONS, FAMILIES)).encode())
    for path in [*rtl_tree.sources(), PINS]:
        text = re.sub(r"`ifdef FORMAL.*?(`else(.*?))?`endif", lambda match: match.group(2) or "", path.read_text(), flags=re.S)
        text = re.sub(r"//[^\n]*", "", text)
        digest.update("".join(text.split()).encode())
    return digest.hexdigest()[:16]


def run(command, folder):
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        said = [line for line in (result.stdout + result.stderr).splitlines() if "ERROR" in line] or ["no word why"]
        raise FpgaError(f"{command[0]}: {said[-1]}")
    return result.stdout + result.stderr


def synthesize(family, parameters, top, path, folder):
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters.items()], more=[PINS])
    command = FAMILIES[family][1].format(top=top)
    run(["yosys", "-q", "-p", f"{read}hierarchy -check -top {top}; {command}; write_json {path}"], folder)


def count(path):
    modules = json.loads(pathlib.Path(path).read_text())["modules"]
    top = next(body for body in modules.values() if body["attributes"].get("top"))
    counts = collections.Counter()
    for cell in top["cells"].values():
        for pattern, column, number in PRIMITIVES:
            if re.fullmatch(pattern, cell["type"]):
                counts[column] += number
                break
        else:
            if not NOT_COUNTED.fullmatch(cell["type"]):
                raise FpgaError(f"primitive {cell['type']} is in no column of the table")
    return counts


def table(families):
    def job(task):
        family, (title, parameters) = task
        with tempfile.TemporaryDirectory(prefix="fpga.") as folder:
            path = pathlib.Path(folder) / "netlist.json"
            synthesize(family, parameters, "sp_board", path, folder)
            return family, title, count(path)

    tasks = [(family, configuration) for configuration in CONFIGURATIONS for family in families]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(job, tasks))
    lines = []
    for title, _ in CONFIGURATIONS:
        lines += [f"**{title}**", "", "| family | " + " | ".join(COLUMNS) + " |", "|---|" + "---:|" * len(COLUMNS)]
        for family, of, counts in results:
            if of == title:
                cells = [f"{counts[column]:,.0f}" if counts[column] == int(counts[column]) else f"{counts[column]:,.1f}"
                         for column in COLUMNS]
                lines.append(f"| {FAMILIES[family][0]} (`{family}`) | " + " | ".join(cells) + " |")
        lines.append("")
    return lines


def worst_path(log):
    """Modules that the worst path of the pixel clock goes through, in order: instance names of the board's blocks."""
    match = re.search(r"Critical path report for clock 'clk_i[^\n]*\n(.*?)Info: [\d.]+ ns logic", log, re.S)
    if not match:
        return "?"
    blocks = []
    for name in re.findall(r"(?:Source|Sink) u_board\.(\S+)", match.group(1)):
        block = ".".join(part for part in name.split(".")[:-1] if part.startswith("u_"))
        if block and (not blocks or blocks[-1] != block):
            blocks.append(block)
    return " → ".join(f"`{block}`" for block in blocks) or "?"


def place(seeds):
    lines = ["| configuration | seeds | clock, minimum | median | worst path of the slowest |", "|---|---:|---:|---:|---|"]
    for title, parameters in CONFIGURATIONS[:2]:
        with tempfile.TemporaryDirectory(prefix="fpga.") as folder:
            folder = pathlib.Path(folder)
            synthesize("ice40", parameters, "sp_board_pins", folder / "netlist.json", folder)

            def job(seed, folder=folder):
                log = run(["nextpnr-ice40", "--hx8k", "--package", "ct256", "--json", "netlist.json", "--seed", str(seed),
                           "--pcf", str(ROOT / "constraints/ice40_hx8k.pcf"), "--pcf-allow-unconstrained",
                           "--pre-pack", str(ROOT / "constraints/ice40_hx8k_clocks.py"), "--timing-allow-fail", *PLACER], folder)
                found = re.findall(r"Max frequency for clock\s+'clk_i[^']*': ([\d.]+) MHz", log)
                if not found:
                    raise FpgaError("nextpnr-ice40: no frequency in its report")
                return float(found[-1]), worst_path(log)

            with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
                results = sorted(pool.map(job, range(1, seeds + 1)))
        clocks = [clock for clock, _ in results]
        lines.append(f"| {title} | {seeds} | {clocks[0]:.1f} MHz | {statistics.median(clocks):.1f} MHz | {results[0][1]} |")
    return lines


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
            resources, clocks = table(list(FAMILIES)), place(arguments.seeds)
            resource_table.insert("resources", "\n".join([mark, *resources]), README)
            resource_table.insert("clocks", "\n".join(clocks), README)
        elif f"<!-- circuits {state()} -->" not in README.read_text():
            raise FpgaError("constraints/README.md was measured of other circuits than rtl/ has now; scripts/fpga.sh update")
    except (OSError, KeyError, ValueError, FpgaError, resource_table.TableError) as error:
        print(f"fpga.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
