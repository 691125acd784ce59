#!/usr/bin/env python3
"""Elaborates modules with slang, plain and with FORMAL, and prints what it says. lint_rtl.sh calls this.

    slang_lint.py ['MODULE NAME=VALUE...' | FILE]...   modules of rtl/, and files outside of it with their tops

slang refuses a name that is used before its declaration, which Verilator, Yosys and Icarus before 13 take. It needs
pyslang of PyPI.
"""

import pathlib
import sys

import rtl_tree
from pyslang import driver  # pylint: disable=import-error


OPEN = ["-Wno-unconnected-input-port", "-Wno-unconnected-output-port"]  # ports for the proofs of other modules


def accepts(top, parameters, files, *options):
    """Whether slang elaborates the module without an error or a warning."""
    run = driver.Driver()
    run.addStandardArgs()
    # A shift by more bits than the operand has, in the Gray-to-binary of short pointers, gives 0 as it should.
    words = ["slang", "--top", top, "-Wno-shift-count-overflow", "-Werror", *options, *(f'"{file}"' for file in files),
             *(f'"-G{parameter}"' for parameter in parameters)]
    return run.parseCommandLine(" ".join(words)) and run.processOptions() and run.parseAllSources() and \
        run.runFullCompilation(True)


def main():
    status = 0
    formal = sorted((rtl_tree.ROOT / "tests" / "formal").glob("*.sv"))
    cells = sorted((rtl_tree.ROOT / "constraints" / "common").glob("*.sv"))
    for job in sys.argv[1:]:
        if job.endswith(".sv"):  # a target may use cells and cores that are not in the project
            path = pathlib.Path(job)
            files = dict.fromkeys([*rtl_tree.sources(), *sorted(path.resolve().parent.glob("*.sv")), *cells])
            passed = accepts(path.stem, [], files, "--ignore-unknown-modules")
        else:
            top, *parameters = job.split()
            files = rtl_tree.sources_of(top)
            passed = accepts(top, parameters, files) and \
                accepts(top, parameters, rtl_tree.sources_of(top, more=formal), "-DFORMAL", *OPEN)
        if not passed:
            print(f"slang_lint.py: {job}: slang does not accept it", file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
