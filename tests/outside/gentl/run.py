#!/usr/bin/env python3
"""Tries the GenTL producer with Harvester, and runs the example of docs/from-outside.md.

    run.py PRODUCER PROGRAMS [TEST...]

Harvester, GenICam's reference implementation and NumPy come from PyPI, into build/gentl-tests of the project. Where
PyPI is not reached it says that it was skipped, and its exit status is 77. By hand: SELFPROJ_OPENS is how often a
camera is opened and closed, SELFPROJ_LINES how many lines a ring brings, 10,000 a second.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests" / "outside"), str(ROOT / "scripts")]
import consumer  # noqa: E402
from lib import pypi  # noqa: E402

HARVESTER = pypi.Environment(ROOT / "build" / "gentl-tests",
                             ["genicam==1.6.0", "harvesters==1.4.3", "numpy==2.4.6"], "--only-binary", ":all:")


def run_example(variables, producer, programs):
    """Runs the example of the document on a recording."""
    block = next(block for block in consumer.blocks("python") if "harvesters" in block)
    with tempfile.TemporaryDirectory() as name:
        consumer.record(programs / "selfproj-sim", pathlib.Path(name) / "line.slfp")
        (pathlib.Path(name) / "libselfproj.cti").symlink_to(producer)
        out = consumer.run(HARVESTER.python, "-c", block, cwd=name,
                           env={**variables, "SELFPROJ_GENTL_DEVICES": "file:line.slfp"})
    consumer.require("(32768, 3)" in out, f"another shape: {out}")
    print(out.splitlines()[-1])


def main():
    producer, programs = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    if not HARVESTER.get():
        print(HARVESTER.missing())
        return 77
    variables = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "SELFPROJ_PRODUCER": str(producer),
                 "SELFPROJ_PROGRAM": str(programs / "selfproj"), "SELFPROJ_SIMULATION": str(programs / "selfproj-sim")}
    tests = pathlib.Path(__file__).with_name("harvest.py")
    if subprocess.run([HARVESTER.python, tests, *sys.argv[3:]], env=variables, check=False).returncode:
        return 1
    run_example(variables, producer, programs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
