#!/usr/bin/env python3
"""Places and routes the front end for Camera Link on an LFE5UM5G-85F, with the deserializer's cells and PLLs, alone or
with the board.

    place.py [NAME...] [--seeds N] [--keep]    (takes minutes)

nextpnr has one edge clock with a divider for each side of the chip that takes LVDS. So each link has a side of its own
(ecp5_camera_link), or all links share a bank and its edge clock (ecp5_camera_link_bank), as those of Full and 80 bit
must. These are also placed as they stand behind receiver chips, without cells and PLLs.

It prints what each configuration takes and the clocks that the seeds 1 to N (default: 10) reach. --keep records them in
results/, in place of what was recorded of these configurations. Yosys comes from Debian, nextpnr-ecp5 from PyPI; where
PyPI is not reached, the exit status is 77. Standard library only.
"""

import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "common"))
import front_ends  # noqa: E402
from lib import tools  # noqa: E402  front_ends has set its path

HOME = front_ends.ROOT / "build" / "camera_link"
ANY_PINS = 'BLOCK RESETPATHS;\nBLOCK ASYNCPATHS;\nFREQUENCY PORT "clk_i" 151.2 MHZ;\n'
# A top with what it needs beside rtl/, its pins and package, and the ports of the camera's clocks
LINKS = "ecp5_camera_link_pins", ("ecp5_channel_link", "ecp5_camera_link")
SIDES = (*LINKS, "ecp5_camera_link.lpf", "CABGA554", ("x_pll_clk_i", "y_pll_clk_i", "z_pll_clk_i"))
ONE_BANK = "ecp5_camera_link_bank_pins", ("ecp5_camera_link_bank",)
BANK = (*ONE_BANK, "ecp5_camera_link_bank.lpf", "CABGA554", ("pll_clk_i",))
BOARD = (*ONE_BANK, "evaluation_board.lpf", "CABGA381", ("pll_clk_i",))
WITH_BOARD = ("ecp5_camera_link_board", ("ecp5_camera_link_bank",), "ecp5_camera_link_bank.lpf", "CABGA554",
              ("pll_clk_i",))
CHIPS = ("sp_camera_link", (), None, "CABGA554", ("x_clk_i", "y_clk_i", "z_clk_i"))
# What is placed, with its parameters and the camera's clock in MHz
CONFIGURATIONS = {
    "Base, 3 taps": (SIDES, {"Taps": "3"}, 85),
    "Base, 3 taps, two samples a bit": (SIDES, {"Taps": "3", "Samples": "2", "Divider": "14"}, 54),
    "Medium": (SIDES, {"Taps": "4"}, 85),
    "Medium, two samples a bit": (SIDES, {"Taps": "4", "Samples": "2", "Divider": "14"}, 54),
    "Base, 3 taps, on the evaluation board": (BOARD, {"Taps": "3"}, 85),
    "Medium, on the evaluation board": (BOARD, {"Taps": "4"}, 85),
    "Full, in one bank": (BANK, {"Taps": "8"}, 85),
    "80 bit, in one bank": (BANK, {"Taps": "10", "Columns": "512"}, 85),
    "Full, behind receiver chips": (CHIPS, {"Taps": "8"}, 85),
    "80 bit, behind receiver chips": (CHIPS, {"Taps": "10", "Columns": "512"}, 85),
    "Full, with the board (512 columns, 127 rows, binary)": (WITH_BOARD, {"Taps": "8"}, 85),
}


def main():
    words = front_ends.options("The front end for Camera Link on an ECP5.", CONFIGURATIONS)
    measured = {}
    for name, ((top, cells, pins, package, clocks), parameters, megahertz) in words.configurations.items():
        around = [front_ends.PLL, front_ends.START, *(HERE / f"{source}.sv" for source in (*cells, top))] if cells else []
        board = top == WITH_BOARD[0]
        text = front_ends.netlist(top, ["sp_camera_link", "sp_channel_link_lock", "sp_channel_link_align"], around,
                                  parameters, HOME, board)
        constraints = (HERE / pins).read_text(encoding="utf-8") if pins else ANY_PINS
        constraints += "".join(f'FREQUENCY PORT "{clock}" {megahertz} MHZ;\n' for clock in clocks)
        constraints += front_ends.BUS_CLOCK if board else ""
        measured[name] = {"camera_mhz": megahertz,
                          **front_ends.measure(f"{name}, camera at {megahertz} MHz", text, constraints, words.seeds,
                                               r"sclk|[xyz]_clk_i", HOME, package=package)}
    return front_ends.finish(words, "fpga_camera_link",
                             "The front end for Camera Link on an LFE5UM5G-85F, placed and routed: what it takes, "
                             "and the clocks that seeds reach, in MHz", "constraints/camera_link/place.py --keep", measured)


if __name__ == "__main__":
    tools.exit_of(main)
