#!/usr/bin/env python3
"""Maps the FPGA of an Acorn (constraints/acorn) with Yosys, and prints what it takes.

    acorn_netlist.py [--codes] [--keep]

The vendor's block for PCI Express, with its transceivers, is a black box, and is not counted. Place and route need the
vendor's tool. --codes maps the Gray decoder in place of runs, grey moments and raw images. --keep records the figures
in the folder results. Where PyPI is not reached, the script prints one line and exits with status 77. Standard library
only.
"""

import argparse
import pathlib
import subprocess
import sys

import fpga_reports
import pypi
import results
import rtl_tree

ROOT = rtl_tree.ROOT
BOARD = ROOT / "constraints" / "acorn"
TOPS = ["sp_board", "sp_sync", "sp_test_camera"]
# What is mapped by itself, as a row of the table
ROWS = {"u_litepcie": "LitePCIe, without the vendor's block", "u_system": "camera, board, way to the DMA"}
# What the parts have, block RAMs of 18 Kbit
PARTS = {"XC7A100T (CLE-101, LiteFury)": {"lut": 63_400, "ff": 126_800, "ram": 270},
         "XC7A200T (CLE-215, CLE-215+, NiteFury)": {"lut": 134_600, "ff": 269_200, "ram": 730}}
CONFIGURATIONS = {"grey": ("grey moments, strongest runs, raw images; 2048 columns, 1023 rows", {}),
                  "codes": ("binary moments and Gray decoder, 8 bits; 512 columns, 512 rows",
                            {"MaxColumns": "512", "MaxRows": "512", "Grey": "1'b0", "Runs": "1'b0", "Image": "1'b0",
                             "Codes": "1'b1"})}


class NetlistError(Exception):
    """A tool has failed."""


def core():
    """Returns the path of LitePCIe's core."""
    done = subprocess.run([ROOT / "scripts/litepcie_core.sh"], capture_output=True, text=True, check=False)
    if done.returncode == pypi.UNREACHED:
        print(f"acorn_netlist.py: {done.stderr.strip()}", file=sys.stderr)
        sys.exit(pypi.UNREACHED)
    if done.returncode:
        raise NetlistError(done.stderr.strip())
    return ROOT / done.stdout.strip()


def netlist(parameters, name):
    """Returns the text of the netlist."""
    made = core()
    files = rtl_tree.sources_of_all(TOPS)
    files += [BOARD / f"{module}.sv" for module in ("acorn_dma", "acorn_system", "acorn")]
    read = rtl_tree.read_command("acorn", [f"{key}={value}" for key, value in parameters.items()], files=files)
    path = made.parent / f"{name}.json"
    script = (f"read_verilog {made} {made.parent / 'pcie_s7.v'}; {read}hierarchy -top acorn; "
              "setattr -mod -set keep_hierarchy 1 litepcie_core *acorn_system; "
              f"synth_xilinx -family xc7 -flatten -top acorn; check -assert; write_json {path}")
    done = subprocess.run(["yosys", "-q", "-p", script], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    log = made.parent / "yosys.log"
    log.write_text(done.stdout, encoding="utf-8")
    if done.returncode:
        wrong = [line for line in done.stdout.splitlines() if "ERROR" in line] or ["no word"]
        raise NetlistError(f"yosys: {wrong[0]} ({log})")
    return path.read_text(encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--codes", action="store_const", const="codes", default="grey", dest="configuration")
    parser.add_argument("--keep", action="store_true")
    words = parser.parse_args()
    title, parameters = CONFIGURATIONS[words.configuration]
    try:
        blocks, whole = fpga_reports.count(netlist(parameters, f"acorn-{words.configuration}"))
    except (NetlistError, fpga_reports.FpgaError, OSError) as error:
        print(f"acorn_netlist.py: {error}", file=sys.stderr)
        return 1
    columns = {key: head for key, head in fpga_reports.COLUMNS.items() if whole[key]}
    print(title)
    print(f"{'':42}" + "".join(f"{head:>12}" for head in columns.values()))
    rows = {**{text: blocks[name] for name, text in ROWS.items()}, "all": whole}
    for text, counts in [*rows.items(), *PARTS.items()]:
        print(f"{text:42}" + "".join(f"{counts.get(key, 0):>12,g}" for key in columns))
    if words.keep:
        figures = {"litepcie": blocks["u_litepcie"], "system": blocks["u_system"], "whole": whole}
        results.write(f"acorn_{words.configuration}", f"The FPGA of an Acorn, mapped by Yosys: {title}",
                      " ".join(["scripts/acorn_netlist.py", *sys.argv[1:]]),
                      {name: {key: counts[key] for key in fpga_reports.COLUMNS} for name, counts in figures.items()},
                      ROOT / "results")
    return 0


if __name__ == "__main__":
    sys.exit(main())
