#!/usr/bin/env python3
"""Maps the FPGA of an Acorn (constraints/acorn) with Yosys, and prints what it takes.

    resources.py [--codes] [--keep]

The vendor's block for PCI Express, with its transceivers, is a black box, and is not counted. Place and route need the
vendor's tool. --codes maps the Gray decoder in place of runs, grey moments and raw images. --keep records the figures
in the folder results. Where PyPI is not reached, the script prints one line and exits with status 77. Standard library
only.
"""

import argparse
import sys

import litepcie_core

ROOT = litepcie_core.ROOT
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402
from lib import rtl_tree, tools, yosys  # noqa: E402

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


def netlist(parameters):
    """Returns the text of the netlist."""
    made = litepcie_core.core()
    files = rtl_tree.sources_of_all(TOPS)
    files += [litepcie_core.HERE / f"{module}.sv" for module in ("acorn_dma", "acorn_system", "acorn")]
    read = rtl_tree.read_command("acorn", [f"{key}={value}" for key, value in parameters.items()], files=files)
    path = made.with_name("netlist.json")
    script = (f'read_verilog "{made}" "{made.with_name("pcie_s7.v")}"; {read}hierarchy -top acorn; '
              "setattr -mod -set keep_hierarchy 1 litepcie_core *acorn_system; "
              f'synth_xilinx -family xc7 -flatten -top acorn; check -assert; write_json "{path}"')
    tools.run(["yosys", "-q", "-p", script], log=made.with_name("yosys.log"))
    return path.read_text(encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--codes", action="store_const", const="codes", default="grey", dest="configuration")
    parser.add_argument("--keep", action="store_true")
    words = parser.parse_args()
    title, parameters = CONFIGURATIONS[words.configuration]
    blocks, whole = yosys.count(netlist(parameters))
    columns = {key: head for key, head in yosys.COLUMNS.items() if whole[key]}
    print(title)
    print(f"{'':42}" + "".join(f"{head:>12}" for head in columns.values()))
    rows = {**{text: blocks[name] for name, text in ROWS.items()}, "all": whole}
    for text, counts in [*rows.items(), *PARTS.items()]:
        print(f"{text:42}" + "".join(f"{counts.get(key, 0):>12,g}" for key in columns))
    if words.keep:
        figures = {"litepcie": blocks["u_litepcie"], "system": blocks["u_system"], "whole": whole}
        results.write(f"acorn_{words.configuration}", f"The FPGA of an Acorn, mapped by Yosys: {title}",
                      " ".join(["constraints/acorn/resources.py", *sys.argv[1:]]),
                      {name: {key: counts[key] for key in yosys.COLUMNS} for name, counts in figures.items()},
                      ROOT / "results")
    return 0


if __name__ == "__main__":
    tools.exit_of(main)
