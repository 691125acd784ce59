"""Places and routes a front end for cameras, alone or with the board, on an LFE5UM5G-85F, for the place.py of each."""

import argparse
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import nextpnr_ecp5  # noqa: E402
import results  # noqa: E402
from lib import rtl_tree, tools  # noqa: E402

PLL = pathlib.Path(__file__).with_name("ecp5_pll.sv")
START = PLL.with_name("ecp5_gearing_start.sv")
BOARD_FILES = [PLL.with_name("sp_board_bus_pins.sv"), PLL.with_name("sp_board_pins.sv")]
BUS_CLOCK = 'FREQUENCY PORT "bus_clk_i" 62.5 MHZ;\n'  # as in ecp5/ecp5.lpf
CELLS = {"lut4": "TRELLIS_COMB", "ff": "TRELLIS_FF", "ram": "DP16KD", "gearing": "IOLOGIC", "pll": "EHXPLLL"}


def options(description, configurations):
    """Returns the words of the command line, and the `configurations` that they name."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog="configurations:\n" + "\n".join(f'    "{name}"' for name in configurations))
    parser.add_argument("names", nargs="*", metavar="NAME", help="of configurations, all unless given")
    parser.add_argument("--seeds", type=int, default=10, metavar="N", help="the seeds 1 to N (default: 10)")
    parser.add_argument("--keep", action="store_true", help="record the figures in results/, in place of earlier ones")
    words = parser.parse_args()
    if words.seeds < 1:
        parser.error(f"argument --seeds: {words.seeds} is less than 1")
    for name in words.names:
        if name not in configurations:
            parser.error(f"argument NAME: no configuration is called '{name}'; --help lists them")
    words.configurations = {name: configurations[name] for name in words.names or configurations}
    return words


def netlist(top, modules, files, parameters, home, board=False):
    """Returns the text of the netlist of `top`, from the sources of `modules` in rtl/ and from `files`. `board`: the top
    has sp_board as well, of which the ABC of Yosys 0.23 ends with an assertion behind -abc9."""
    home.mkdir(parents=True, exist_ok=True)
    mapper = "-no-rw-check" if board else "-abc9"
    if board:
        modules, files = [*modules, "sp_board"], [*files, *BOARD_FILES]
    path = home / "netlist.json"
    read = rtl_tree.read_command(top, [f"{name}={value}" for name, value in parameters.items()],
                                 files=[*rtl_tree.sources_of_all(modules), *files])
    tools.run(["yosys", "-q", "-p", f'{read}synth_ecp5 {mapper} -top {top} -json "{path}"'], log=home / "yosys.log")
    return path.read_text(encoding="utf-8")


def clocks_of(report, camera_side):
    """Returns the clocks that a report has reached, and those wanted: that of the board, that of its bus where it has
    one, and the slower one of the nets that `camera_side` matches."""
    of_camera = re.compile(camera_side)
    groups = {"link": [], "board": [], "bus": []}
    for net, clock in report["fmax"].items():
        groups["bus" if "bus_clk_i" in net else "link" if of_camera.search(net) else "board"].append(clock)
    if len(groups["board"]) != 1 or not groups["link"]:
        raise tools.ToolError(f"nextpnr reports other clocks than expected: {', '.join(report['fmax'])}")
    return {name: min((clock["achieved"], clock["constraint"]) for clock in clocks)
            for name, clocks in groups.items() if clocks}


def measure(name, text, constraints, seeds, camera_side, home, **package):
    """Places a netlist with the seeds 1 to `seeds`. Returns and prints what it takes, and the slowest clocks."""
    reached = []
    for seed in range(1, 1 + seeds):
        report, _ = nextpnr_ecp5.place(text, constraints, seed, home / "nextpnr.log", "--lpf-allow-unconstrained",
                                       **package)
        reached.append(clocks_of(report, camera_side))
    used = {key: report["utilization"].get(cell, {}).get("used", 0) for key, cell in CELLS.items()}
    least = {clock: round(min(of[clock][0] for of in reached), 1) for clock in reached[0]}
    wanted = {clock: round(reached[0][clock][1], 1) for clock in reached[0]}
    print(f"{name}: {used['lut4']} LUT4, {used['ff']} flip-flops, {used['ram']} block RAMs, {used['gearing']} "
          f"deserializers, {used['pll']} PLLs")
    for clock, mhz in least.items():
        print(f"    {clock}: {mhz} MHz, the least of {seeds} seeds (wanted: {wanted[clock]})", flush=True)
    return {"used": used, "seeds": seeds, "least": least, "wanted": wanted,
            "met": sum(all(got >= want for got, want in of.values()) for of in reached)}


def finish(words, record, about, command, measured):
    """Records the figures if --keep says so. Returns the exit status: 1 if a seed has not met a clock."""
    if words.keep:
        file = ROOT / f"results/{record}.json"
        kept = json.loads(file.read_text(encoding="utf-8"))["results"] if words.names else {}
        results.write(record, about, command, kept | measured, ROOT / "results")
    return 0 if all(of["met"] == of["seeds"] for of in measured.values()) else 1
