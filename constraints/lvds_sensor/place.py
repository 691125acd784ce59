#!/usr/bin/env python3
"""Places and routes the front end for serial LVDS sensors on an LFE5UM5G-85F, with its pins and cells, alone or with
the board.

    place.py [NAME...] [--seeds N] [--keep]    (takes minutes)

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

HOME = front_ends.ROOT / "build" / "lvds_sensor"
BANK = ("ecp5_lvds_sensor", "ecp5_lvds_sensor.lpf", "CABGA554", "eclk_i")
BOARD = ("ecp5_lvds_sensor_pll", "evaluation_board.lpf", "CABGA381", "pll_clk_i")
WITH_BOARD = ("ecp5_lvds_sensor_board", *BANK[1:])
# What is placed: top, pins, package and port of the sensor's clock; parameters; the bits of a lane in a second, in
# millions
CONFIGURATIONS = {
    "16 lanes of 10 bits, flags": (BANK, {"LogDepth": "10"}, 480),
    "16 lanes of 12 bits, flags": (BANK, {"Bits": "12", "LogDepth": "10"}, 480),
    "4 lanes of 10 bits, codes": (BANK, {"Lanes": "4", "Codes": "1'b1", "Checked": "1'b1"}, 720),
    "the same on the evaluation board": (BOARD, {"Checked": "1'b1"}, 720),
    "16 lanes of 10 bits, with the board (512 columns, 127 rows, binary)": (WITH_BOARD, {}, 480),
}


def main():
    words = front_ends.options("The front end for serial LVDS sensors on an ECP5.", CONFIGURATIONS)
    measured = {}
    for name, ((top, pins, package, clock), parameters, megabits) in words.configurations.items():
        around = [HERE / f"{top}.sv", front_ends.START,
                  *([] if top == BANK[0] else [HERE / f"{BANK[0]}.sv", front_ends.PLL])]
        board = top == WITH_BOARD[0]
        text = front_ends.netlist(top, ["sp_lvds_sensor", "sp_lvds_gear"], around, parameters, HOME, board)
        constraints = (HERE / pins).read_text(encoding="utf-8") + f'FREQUENCY PORT "{clock}" {megabits / 2} MHZ;\n'
        constraints += front_ends.BUS_CLOCK if board else ""
        measured[name] = {"megabits": megabits, **front_ends.measure(f"{name}, {megabits} Mbit/s", text, constraints,
                                                                     words.seeds, "sclk", HOME, package=package)}
    return front_ends.finish(words, "fpga_lvds_sensor",
                             "The front end for serial LVDS sensors on an LFE5UM5G-85F, placed and routed: what it "
                             "takes, and the clocks that seeds reach, in MHz", "constraints/lvds_sensor/place.py --keep",
                             measured)


if __name__ == "__main__":
    tools.exit_of(main)
