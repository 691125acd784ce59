#!/usr/bin/env python3
"""Places and routes the front end for Camera Link alone on an LFE5UM5G-85F, with the deserializer's cells and PLLs.

    place.py [--seeds N] [--keep]    (takes minutes)

Full and 80 bit are placed as they stand behind receiver chips, without cells and PLLs: nextpnr has one edge clock with
a divider for each side of the chip that takes LVDS, so that it cannot place the third link's.

It prints what each configuration takes and the clocks that the seeds 1 to N (default: 10) reach. --keep records them in
results/. Yosys comes from Debian, nextpnr-ecp5 from PyPI; where PyPI is not reached, the exit status is 77. Standard
library only.
"""

import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "common"))
import front_ends  # noqa: E402
from lib import tools  # noqa: E402  front_ends has set its path

HOME = front_ends.ROOT / "build" / "camera_link"
TOP = "ecp5_camera_link_pins"
BEHIND_CHIPS = "sp_camera_link"
PAIRS = ("ecp5_camera_link.lpf", "CABGA554")
BOARD = ("evaluation_board.lpf", "CABGA381")
# What is placed: its pins and package, its parameters, and the camera's clock in MHz; with 8 or 10 taps BEHIND_CHIPS,
# else TOP
CONFIGURATIONS = {
    "Base, 3 taps": (PAIRS, {"Taps": "3"}, 85),
    "Base, 3 taps, two samples a bit": (PAIRS, {"Taps": "3", "Samples": "2", "Divider": "14"}, 54),
    "Base, 3 taps, on the evaluation board": (BOARD, {"Taps": "3"}, 85),
    "Medium": (PAIRS, {"Taps": "4"}, 85),
    "Medium, two samples a bit": (PAIRS, {"Taps": "4", "Samples": "2", "Divider": "14"}, 54),
    "Full, behind receiver chips": (PAIRS, {"Taps": "8"}, 85),
    "80 bit, behind receiver chips": (PAIRS, {"Taps": "10", "Columns": "512"}, 85),
}


def main():
    words = front_ends.options("The front end for Camera Link alone on an ECP5.")
    measured = {}
    for name, ((pins, package), parameters, megahertz) in CONFIGURATIONS.items():
        chips = int(parameters["Taps"]) > 4
        top = BEHIND_CHIPS if chips else TOP
        around = [] if chips else [front_ends.PLL, *(HERE / f"{source}.sv" for source in (
            "ecp5_channel_link", "ecp5_camera_link", TOP))]
        text = front_ends.netlist(top, ["sp_camera_link", "sp_channel_link_lock"], around, parameters, HOME)
        constraints = "".join(line for line in (HERE / pins).read_text(encoding="utf-8").splitlines(True)
                              if not chips or re.search(r"^BLOCK|PORT .clk_i. ", line))
        clock = "clk_i" if chips else "pll_clk_i"
        constraints += "".join(f'FREQUENCY PORT "{link}_{clock}" {megahertz} MHZ;\n' for link in "xyz")
        measured[name] = {"camera_mhz": megahertz,
                          **front_ends.measure(f"{name}, camera at {megahertz} MHz", text, constraints, words.seeds,
                                               r"sclk|[xyz]_clk_i", HOME, package=package)}
    return front_ends.finish(words, "fpga_camera_link",
                             "The front end for Camera Link alone on an LFE5UM5G-85F, placed and routed: what it takes, "
                             "and the clocks that seeds reach, in MHz", "constraints/camera_link/place.py --keep", measured)


if __name__ == "__main__":
    tools.exit_of(main)
