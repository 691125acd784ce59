#!/usr/bin/env python3
"""Places and routes the front end for serial LVDS sensors alone on an LFE5UM5G-85F, with its pins and cells.

    place.py [--seeds N] [--keep]    (takes minutes)

It prints what each configuration takes and the clocks that the seeds 1 to N (default: 10) reach. --keep records them in
results/. Yosys comes from Debian, nextpnr-ecp5 from PyPI; where PyPI is not reached, the exit status is 77. Standard
library only.
"""

import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "common"))
import front_ends  # noqa: E402
from lib import tools  # noqa: E402  front_ends has set its path

HOME = front_ends.ROOT / "build" / "lvds_sensor"
TOP = "ecp5_lvds_sensor"
# What is placed: its parameters, and the bits of a lane in a second, in millions
CONFIGURATIONS = {
    "16 lanes of 10 bits, flags": ({"LogDepth": "10"}, 480),
    "16 lanes of 12 bits, flags": ({"Bits": "12", "LogDepth": "10"}, 480),
    "4 lanes of 10 bits, codes": ({"Lanes": "4", "Codes": "1'b1", "Checked": "1'b1"}, 720),
}


def main():
    words = front_ends.options("The front end for serial LVDS sensors alone on an ECP5.", 10)
    pins = (HERE / "ecp5_lvds_sensor.lpf").read_text(encoding="utf-8")
    measured = {}
    for name, (parameters, megabits) in CONFIGURATIONS.items():
        text = front_ends.netlist(TOP, ["sp_lvds_sensor", "sp_lvds_gear"], [HERE / f"{TOP}.sv"], parameters, HOME)
        constraints = pins + f'FREQUENCY PORT "eclk_i" {megabits / 2} MHZ;\n'
        measured[name] = {"megabits": megabits, **front_ends.measure(f"{name}, {megabits} Mbit/s", text, constraints,
                                                                     words.seeds, "sclk", HOME)}
    return front_ends.finish(words, "fpga_lvds_sensor",
                             "The front end for serial LVDS sensors alone on an LFE5UM5G-85F, placed and routed: what it "
                             "takes, and the clocks that seeds reach, in MHz", "constraints/lvds_sensor/place.py --keep",
                             measured)


if __name__ == "__main__":
    tools.exit_of(main)
