#!/usr/bin/env python3
"""thesis_times.py [--programs DIR] [--limit MINUTES] [--record] [NAME...]: runs the commands of docs/thesis.md one after
another, or those named, and prints how many minutes of one processor core each took.

NAME is the number of a figure (3.9), an experiment (A1), a co-simulation (cosim_fist), a benchmark (bench_gray), rig,
accuracy, or one of the scripts and tests of TREE, which run in the tree, with the programs of --programs. Figures are
made each by a process of its own, as its row says; experiments, co-simulations and benchmarks are those whose results
the page shows, by the very command that their files in results/ and lab/results/ name. With --limit a command that
needs more is stopped, and that it takes more is what is known. With --record the times go to
lab/results/thesis_times.json, each with date and commit; others that stand there stay. Standard library only.
"""

import argparse
import datetime
import json
import os
import pathlib
import resource
import shlex
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402

RECORD = ROOT / "lab/results/thesis_times.json"
EXPERIMENTS = ("A1", "A2", "B2", "B3", "B4", "B7", "B8")
COSIMS = ("cosim_stairs-marked", "cosim_fist", "cosim_keys")
BENCHES = ("bench_gray", "bench_match")
TREE = {"fpga": "scripts/fpga.py table xc3s", "frame_rate": "ctest --preset release -R Board.TakesFull",
        "moments_delay": "ctest --preset release -R ColumnMoments.Delay",
        "depth_stream": "tests/cli/depth_stream.py build/bin --seconds 60"}


def commands(programs):
    """Returns name: words, as the page has them."""
    listed = subprocess.run([programs / "selfproj-lab", "thesis", "--list"], capture_output=True, text=True, check=True)
    found = {number: ["selfproj-lab", "thesis", "--figure", number] for number in listed.stdout.split()}
    for name in EXPERIMENTS + COSIMS + BENCHES:
        file = ROOT / (f"lab/results/experiment_{name}.json" if name in EXPERIMENTS else f"results/{name}.json")
        words = shlex.split(json.loads(file.read_text(encoding="utf-8"))["command"])
        while "=" in words[0]:  # settings of the environment
            words.pop(0)
        found[name] = words if name in BENCHES else [pathlib.Path(words[0]).name, *words[1:]]
    found.update((name, line.split()) for name, line in TREE.items())
    return {"rig": ["selfproj", "rig", "light-section"], "accuracy": ["selfproj", "accuracy"], **found}


def run(words, programs, folder, limit, in_tree):
    """Runs a command, of which at most `limit` minutes of a core, in `folder` or in the tree. Returns its core and wall
    time in seconds, and its exit status."""
    before, begin, made = os.times(), time.monotonic(), folder / "made"
    if in_tree:
        folder, words = ROOT, [programs if word == "build/bin" else word for word in words]
    else:
        words = [programs / pathlib.Path(words[0]).name, *words[1:]]
    if "thesis" in words:
        words += ["--out", folder / "out"]
    most = resource.RLIM_INFINITY if limit is None else round(60 * limit)
    status = subprocess.run(words, cwd=folder, stdout=subprocess.DEVNULL, check=False,
                            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY)),
                            env={**os.environ, results.VARIABLE: str(made)}).returncode
    after = os.times()
    core = after.children_user + after.children_system - before.children_user - before.children_system
    return core, time.monotonic() - begin, status


def shortened(minutes):
    """Two digits that count, which is more than a busy machine gives."""
    return "< 0.01" if minutes < 0.005 else round(minutes) if minutes >= 10 else round(minutes, 1 if minutes >= 1 else 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/bin")
    parser.add_argument("--limit", type=float, metavar="MINUTES")
    parser.add_argument("--record", action="store_true")
    parser.add_argument("names", nargs="*")
    args = parser.parse_args()
    programs = args.programs.resolve()
    known = commands(programs)
    wrong = [name for name in args.names if name not in known]
    if wrong:
        sys.exit(f"thesis_times.py: {', '.join(wrong)}: unknown; there are {', '.join(known)}")
    for name in args.names or known:
        with tempfile.TemporaryDirectory() as folder:
            core, wall, status = run(known[name], programs, pathlib.Path(folder), args.limit, name in TREE)
        stopped = status == -signal.SIGXCPU
        print(f"{name}: {core / 60:.1f} minutes of a core, {wall / 60:.1f} minutes; {shlex.join(known[name])}"
              + ("; stopped" if stopped else f"; exit status {status}" if status else ""), flush=True)
        if status not in (0, 1) and not stopped:  # 1: a figure was not reached
            return 1
        if args.record:
            old = json.loads(RECORD.read_text(encoding="utf-8"))["results"] if RECORD.exists() else {}
            minutes = f"> {args.limit:g}" if stopped else shortened(core / 60)
            old[name] = {"command": shlex.join(known[name]), "core_minutes": minutes,
                         "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
                         "commit": results.commit(ROOT)}
            results.write("thesis_times", "Minutes of one processor core of the commands of docs/thesis.md",
                          shlex.join(["lab/scripts/thesis_times.py", *sys.argv[1:]]),
                          {one: old[one] for one in known if one in old}, RECORD.parent)
    return 0


if __name__ == "__main__":
    sys.exit(main())
