#!/usr/bin/env python3
"""Places and routes the front end for Camera Link alone on an LFE5UM5G-85F, with the deserializer's cells and PLLs.

    place.py [--seeds N] [--keep]    (takes minutes)

Full and 80 bit are placed as they stand behind receiver chips, without cells and PLLs: nextpnr has one edge clock with
a divider for each side of the chip that takes LVDS, so that it cannot place the third link's.

It prints what each configuration takes and the clocks that the seeds 1 to N (default: 3) reach. --keep records them in
results/. Yosys comes from Debian, nextpnr-ecp5 from PyPI; where PyPI is not reached, the exit status is 77. Standard
library only.
"""

import argparse
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "constraints" / "common")]
import nextpnr_ecp5  # noqa: E402
import results  # noqa: E402
from lib import rtl_tree, tools  # noqa: E402

HOME = ROOT / "build" / "camera_link"
TOP = "ecp5_camera_link_pins"
BEHIND_CHIPS = "sp_camera_link"
# What is placed: its parameters, and the camera's clock in MHz; with 8 or 10 taps BEHIND_CHIPS, else TOP
CONFIGURATIONS = {
    "Base, 3 taps": ({"Taps": "3"}, 85),
    "Base, 3 taps, two samples a bit": ({"Taps": "3", "Samples": "2", "Divider": "14"}, 54),
    "Medium": ({"Taps": "4"}, 85),
    "Medium, two samples a bit": ({"Taps": "4", "Samples": "2", "Divider": "14"}, 54),
    "Full, behind receiver chips": ({"Taps": "8"}, 85),
    "80 bit, behind receiver chips": ({"Taps": "10", "Columns": "512"}, 85),
}
CELLS = {"lut4": "TRELLIS_COMB", "ff": "TRELLIS_FF", "ram": "DP16KD", "gearing": "IOLOGIC", "pll": "EHXPLLL"}


def netlist(top, parameters):
    """Returns the text of the netlist."""
    files = rtl_tree.sources_of_all(["sp_camera_link", "sp_channel_link_lock"])
    if top == TOP:
        files += [HERE / f"{name}.sv" for name in ("ecp5_channel_link", "ecp5_camera_link", TOP)]
    path = HOME / "netlist.json"
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters.items()], files=files)
    tools.run(["yosys", "-q", "-p", f'{read}synth_ecp5 -abc9 -top {top} -json "{path}"'], log=HOME / "yosys.log")
    return path.read_text(encoding="utf-8")


def clocks_of(report):
    """Returns the clocks that a report has reached, and those wanted: that of the board, and the slower one of the
    links."""
    of_link = re.compile(r"sclk|[xyz]_clk_i")
    links = [clock for net, clock in report["fmax"].items() if of_link.search(net)]
    boards = [clock for net, clock in report["fmax"].items() if not of_link.search(net)]
    if len(boards) != 1 or not links:
        raise tools.ToolError(f"nextpnr reports other clocks than expected: {', '.join(report['fmax'])}")
    return {name: min((clock["achieved"], clock["constraint"]) for clock in clocks)
            for name, clocks in (("link", links), ("board", boards))}


def main():
    parser = argparse.ArgumentParser(description="The front end for Camera Link alone on an ECP5.")
    parser.add_argument("--seeds", type=int, default=3, metavar="N")
    parser.add_argument("--keep", action="store_true", help="record the figures in results/")
    words = parser.parse_args()
    HOME.mkdir(parents=True, exist_ok=True)
    pins = (HERE / "ecp5_camera_link.lpf").read_text(encoding="utf-8")
    measured = {}
    for name, (parameters, megahertz) in CONFIGURATIONS.items():
        chips = int(parameters["Taps"]) > 4
        text = netlist(BEHIND_CHIPS if chips else TOP, parameters)
        constraints = "".join(line for line in pins.splitlines(True)
                              if not chips or re.search(r"^BLOCK|PORT .clk_i. ", line))
        clock = "clk_i" if chips else "pll_clk_i"
        constraints += "".join(f'FREQUENCY PORT "{link}_{clock}" {megahertz} MHZ;\n' for link in "xyz")
        reached = []
        for seed in range(1, 1 + words.seeds):
            report, _ = nextpnr_ecp5.place(text, constraints, seed, HOME / "nextpnr.log",
                                           "--lpf-allow-unconstrained")
            reached.append(clocks_of(report))
        used = {key: report["utilization"].get(cell, {}).get("used", 0) for key, cell in CELLS.items()}
        least = {clock: round(min(of[clock][0] for of in reached), 1) for clock in ("link", "board")}
        wanted = {clock: round(reached[0][clock][1], 1) for clock in ("link", "board")}
        measured[name] = {"camera_mhz": megahertz, "used": used, "seeds": words.seeds, "least": least, "wanted": wanted,
                          "met": sum(all(got >= want for got, want in of.values()) for of in reached)}
        print(f"{name}, camera at {megahertz} MHz: {used['lut4']} LUT4, {used['ff']} flip-flops, "
              f"{used['gearing']} deserializers, {used['pll']} PLLs")
        for clock, mhz in least.items():
            print(f"    {clock}: {mhz} MHz, the least of {words.seeds} seeds (wanted: {wanted[clock]})", flush=True)
    if words.keep:
        results.write("fpga_camera_link", "The front end for Camera Link alone on an LFE5UM5G-85F, placed and routed: "
                      "what it takes, and the clocks that seeds reach, in MHz", "constraints/camera_link/place.py --keep",
                      measured, ROOT / "results")
    return 0 if all(of["met"] == of["seeds"] for of in measured.values()) else 1


if __name__ == "__main__":
    tools.exit_of(main)
