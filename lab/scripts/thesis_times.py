#!/usr/bin/env python3
"""thesis_times.py [--programs DIR] [--record] [NAME...]: runs the commands of docs/thesis.md one after another, or those
named, and prints how many minutes of one processor core each took.

NAME is the number of a figure (3.9), an experiment (A1), a co-simulation (cosim_fist), rig or accuracy. Figures are
made each by a process of its own, as its row says; experiments and co-simulations are those whose results the page
shows, by the very command that their files in results/ and lab/results/ name. With --record the times go to
lab/results/thesis_times.json, each with date and commit; others that stand there stay. Standard library only.
"""

import argparse
import datetime
import json
import os
import pathlib
import shlex
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


def commands(programs):
    """Returns name: words."""
    listed = subprocess.run([programs / "selfproj-lab", "thesis", "--list"], capture_output=True, text=True, check=True)
    found = {number: ["selfproj-lab", "thesis", "--figure", number] for number in listed.stdout.split()}
    for name in EXPERIMENTS + COSIMS:
        file = ROOT / ("results" if name in COSIMS else "lab/results")
        file /= f"{name if name in COSIMS else 'experiment_' + name}.json"
        words = shlex.split(json.loads(file.read_text(encoding="utf-8"))["command"])
        while "=" in words[0]:  # settings of the environment
            words.pop(0)
        found[name] = [pathlib.Path(words[0]).name, *words[1:]]
    return {"rig": ["selfproj", "rig", "light-section"], "accuracy": ["selfproj", "accuracy"], **found}


def run(words, programs, folder):
    """Runs a command. Returns its core and wall time in seconds, what it records, and its exit status."""
    before, begin = os.times(), time.monotonic()
    words = [programs / words[0], *words[1:]]
    if "thesis" in words:
        words += ["--out", folder / "out"]
    status = subprocess.run(words, cwd=folder, stdout=subprocess.DEVNULL, check=False,
                            env={**os.environ, results.VARIABLE: str(folder / "made")}).returncode
    after = os.times()
    core = after.children_user + after.children_system - before.children_user - before.children_system
    return core, time.monotonic() - begin, status


def shortened(minutes):
    """Two digits that count, which is more than a busy machine gives."""
    return "< 0.01" if minutes < 0.005 else round(minutes) if minutes >= 10 else round(minutes, 1 if minutes >= 1 else 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/bin")
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
            core, wall, status = run(known[name], programs, pathlib.Path(folder))
        print(f"{name}: {core / 60:.1f} minutes of a core, {wall / 60:.1f} minutes; {shlex.join(known[name])}"
              + (f"; exit status {status}" if status else ""), flush=True)
        if status > 1:  # 1: a figure was not reached
            return 1
        if args.record:
            old = json.loads(RECORD.read_text(encoding="utf-8"))["results"] if RECORD.exists() else {}
            old[name] = {"command": shlex.join(known[name]), "core_minutes": shortened(core / 60),
                         "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
                         "commit": results.commit(ROOT)}
            results.write("thesis_times", "Minutes of one processor core of the commands of docs/thesis.md",
                          shlex.join(["lab/scripts/thesis_times.py", *sys.argv[1:]]),
                          {one: old[one] for one in known if one in old}, RECORD.parent)
    return 0


if __name__ == "__main__":
    sys.exit(main())
