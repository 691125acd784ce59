#!/usr/bin/env python3
"""Makes a bitstream of the board for an ECPIX-5 with the LFE5UM5G-85F, from Debian and PyPI alone, and says how to load
it: Yosys, nextpnr-ecp5, ecppack.

    bitstream.py [--seed N | --seeds FIRST-LAST] [--address A.B.C.D] [--sensor | --codes | --few-rows] [--jumbo]
                 [--keep]

It prints what the circuit takes and the clocks that each seed of the placement reaches. --sensor makes the parallel
sensor the camera, in place of the test camera; --codes has the Gray decoder in place of grey moments and raw images.
--few-rows is for 50,000 frames of 20 rows a second: with the register region and compact columns, a test camera of 20
rows that makes no pause, and a pixel clock of 133.3 MHz.
--jumbo sends packets in datagrams of up to 8,972 bytes, for a network whose frames may have 9,000 bytes. --keep records
the figures in the folder results. Netlists and placements are kept in build/, so an unchanged circuit is not placed
again. Where PyPI is not reached it prints one line and exits with status 77. Standard library only.
"""

import argparse
import ipaddress
import pathlib
import re
import shutil
import subprocess
import sys

import liteeth_core

ROOT = liteeth_core.ROOT
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "constraints" / "common")]
import nextpnr_ecp5  # noqa: E402
import results  # noqa: E402
from lib import rtl_tree, tools, yosys  # noqa: E402

HOME = liteeth_core.HOME
BOARD = liteeth_core.HERE
JUMBO_BYTES = 8972  # of a datagram in an Ethernet frame of 9,000 bytes
TOPS = ["sp_board", "sp_link", "sp_parallel_sensor", "sp_replay", "sp_sync", "sp_test_camera", "sp_video_switch"]
# What a design takes, by nextpnr's names
COLUMNS = {"TRELLIS_COMB": ("lut4", "LUT4"), "TRELLIS_FF": ("ff", "flip-flops"), "DP16KD": ("ram", "block RAMs"),
           "TRELLIS_IO": ("pins", "pins"), "EHXPLLL": ("pll", "PLLs")}
CONFIGURATIONS = {"test camera": {}, "parallel sensor": {"Sensor": "1'b1"},
                  "Gray decoder": {"Grey": "1'b0", "Image": "1'b0", "Codes": "1'b1"},
                  "few rows": {"Region": "1'b1", "Compact": "1'b1", "CameraRows": "20", "FrameClocks": "2560",
                               "Fast": "1'b1"}}


def netlist(parameters):
    """Returns the text of the netlist. Yosys names cells by the lines of the sources, and the later steps depend on
    these names. So Yosys reads the sources without comments, one statement a line, as in fpga.py."""
    files = [*rtl_tree.sources_of_all(TOPS), BOARD / "ecpix5_system.sv", BOARD / "ecpix5.sv"]
    texts = {path.relative_to(ROOT): rtl_tree.plain(path.read_text(encoding="utf-8")) for path in files}
    read = rtl_tree.read_command("ecpix5", [f"{key}={value}" for key, value in parameters.items()], files=texts)
    texts["liteeth.v"] = liteeth_core.core().read_text(encoding="utf-8")
    return yosys.netlist(f"read_verilog liteeth.v; {read}synth_ecp5 -abc9 -top ecpix5", texts, HOME / "yosys.log")


def clocks_of(report):
    """Returns the clocks of a report: {name: (reached, wanted) in MHz}."""
    found = {}
    for net, clock in report["fmax"].items():
        name = {"clk": "pixel", "bus_clk": "bus", "eth_rx_clk_i": "rgmii",
                "sensor_clk_i": "sensor"}[re.fullmatch(r"(?:\$glbnet\$)?(\w+?)(?:\$TRELLIS_IO_IN)?", net)[1]]
        found[name] = (clock["achieved"], clock["constraint"])
    return found


def seeds_of(words):
    first, last = re.fullmatch(r"(\d+)-(\d+)", words.seeds).groups() if words.seeds else (words.seed, words.seed)
    return range(int(first), int(last) + 1)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--seeds", metavar="FIRST-LAST")
    parser.add_argument("--address", type=ipaddress.IPv4Address, default=ipaddress.IPv4Address("192.168.1.50"))
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--sensor", action="store_const", const="parallel sensor", dest="configuration",
                      default="test camera")
    kind.add_argument("--codes", action="store_const", const="Gray decoder", dest="configuration")
    kind.add_argument("--few-rows", action="store_const", const="few rows", dest="configuration")
    parser.add_argument("--jumbo", action="store_true")
    parser.add_argument("--keep", action="store_true")
    words = parser.parse_args()
    if words.seeds and not re.fullmatch(r"\d+-\d+", words.seeds):
        parser.error(f"argument --seeds: '{words.seeds}' is not FIRST-LAST")
    return words


def main():
    words = arguments()
    if not shutil.which("yosys"):
        subprocess.run([ROOT / "scripts" / "setup.sh"], stdout=sys.stderr, check=True)
    configuration = words.configuration
    name = "ecpix5" if configuration == "test camera" else f"ecpix5-{configuration.split()[0].lower()}"
    name += "-jumbo" if words.jumbo else ""
    _, ecppack = nextpnr_ecp5.programs()
    datagrams = {"DatagramBytes": str(JUMBO_BYTES)} if words.jumbo else {}
    text = netlist({"Address": f"32'h{int(words.address):08X}", **CONFIGURATIONS[configuration], **datagrams})
    pins = (BOARD / "ecpix5.lpf").read_text(encoding="utf-8")
    used, seeds, good = {}, {}, None
    for seed in seeds_of(words):
        report, config = nextpnr_ecp5.place(text, pins, seed, HOME / "nextpnr.log")
        if not used:
            used = {key: report["utilization"][cell]["used"] for cell, (key, _) in COLUMNS.items()}
            print(f"{configuration} on an LFE5UM5G-85F")
            for cell, (key, title) in COLUMNS.items():
                print(f"    {title:<12} {used[key]:>6} of {report['utilization'][cell]['available']}")
        clocks = clocks_of(report)
        print(f"seed {seed}: " + ", ".join(f"{clock} {reached:.1f} MHz (wanted: {wanted:g})"
                                           for clock, (reached, wanted) in sorted(clocks.items())), flush=True)
        seeds[seed] = {clock: round(reached, 1) for clock, (reached, _) in clocks.items()}
        seeds[seed]["met"] = all(reached >= wanted for reached, wanted in clocks.values())
        if seeds[seed]["met"] and good is None:
            good = seed
            (HOME / f"{name}.config").write_text(config, encoding="utf-8")
            tools.run([ecppack, "--compress", HOME / f"{name}.config", HOME / f"{name}.bit"], log=HOME / "ecppack.log")
    if words.keep:
        results.write(f"bitstream_{configuration.replace(' ', '_').lower()}{'_jumbo' * words.jumbo}",
                      f"The ECPIX-5 with {configuration}{', jumbo frames' * words.jumbo}: what it takes, and the "
                      "clocks that seeds reach, in MHz",
                      " ".join(["constraints/ecpix5/bitstream.py", *sys.argv[1:]]),
                      {"used": used, "seeds": {str(seed): figures for seed, figures in seeds.items()},
                       "placed": len(seeds), "met": sum(figures["met"] for figures in seeds.values()),
                       "least": {clock: min(figures[clock] for figures in seeds.values())
                                 for clock in clocks}}, ROOT / "results")
    if good is None:
        print("bitstream.py: no seed meets every clock; nothing was written", file=sys.stderr)
        return 1
    print(f"build/ecpix5/{name}.bit: seed {good}, address {words.address}")
    print(f"load it with: openFPGALoader -b ecpix5 build/ecpix5/{name}.bit (--write-flash keeps it)")
    return 0


if __name__ == "__main__":
    tools.exit_of(main)
