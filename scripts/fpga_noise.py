#!/usr/bin/env python3
"""fpga_noise.py COMMIT: how far the LUTs of the board, and of one of its blocks, move without a change of the circuits.

Yosys and its mapper break ties by the order in which cells were made, so the order of the source files moves the
figures. This maps them with the sources in several orders, for rtl/ of that commit and for rtl/ as it is now, and
writes LUTs and medians into README.md of constraints/, between its markers, and into results/. What was mapped before
is found again in build/fpga. Standard library only.
"""

import argparse
import collections
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile

import fpga
import results
import rtl_tree

Mapped = collections.namedtuple("Mapped", "key title family top parameters")


def board(family, configuration):
    """Returns the board in one piece, in one of the configurations of the tables."""
    return Mapped(f"{family}_{fpga.key_of(configuration)}", f"board, {configuration.head}", family, "sp_board",
                  configuration.parameters)


# As in the board with the Gray decoder
CODES = {"MaxColumns": "512", "MaxRows": "127", "MaxBits": "8", "Median": "1'b1", "LogDepth": "9"}
MAPPED = [board("xc6s", fpga.CONFIGURATIONS[0]), board("xc6s", fpga.CONFIGURATIONS[1]),
          board("xc7", fpga.CONFIGURATIONS[1]), board("xc7", fpga.CONFIGURATIONS[3]),
          board("ecp5", fpga.CONFIGURATIONS[2]),
          *(Mapped(f"{family}_codes_path", "`sp_codes_path`", family, "sp_codes_path", CODES)
            for family in ("ecp5", "ice40"))]
ORDERS = 7  # the first is that of the tables, the others are drawn
ABOUT = "LUTs of two versions of the circuits, with the source files in several orders"


def at_commit(commit, folder):
    """Puts rtl/ of that commit into the folder, and returns the folder's path."""
    archive = subprocess.run(["git", "archive", commit, "rtl"], cwd=rtl_tree.ROOT, capture_output=True, check=False)
    if archive.returncode != 0:
        raise fpga.FpgaError(f"{commit}: no such commit")
    subprocess.run(["tar", "-x", "-C", folder], input=archive.stdout, check=True)
    return pathlib.Path(folder)


def in_order(texts, order):
    """Returns the sources in the order of that number; the package stays first."""
    package, *others = texts
    drawn = random.Random(order).sample(others, len(others)) if order else others
    return {name: texts[name] for name in [package, *drawn]}


def luts(mapped, root, order):
    sources = in_order(rtl_tree.plain_texts(root=root), order)
    netlist = fpga.synthesize(mapped.family, mapped.parameters, mapped.top, sources=sources)
    return fpga.count(netlist)[1]["lut"]


def measure(commit):
    """Returns the LUTs by order for each circuit, of the commit and of now."""
    circuits = {}
    with tempfile.TemporaryDirectory() as folder:
        roots = {"before": at_commit(commit, folder), "now": rtl_tree.ROOT}
        for mapped in MAPPED:
            circuits[mapped.key] = {}
            for name, root in roots.items():
                found = [luts(mapped, root, order) for order in range(ORDERS)]
                circuits[mapped.key][name] = {"lut": found, "median": statistics.median(found)}
                print(f"{mapped.family}, {mapped.title}, {name}: {found}", file=sys.stderr, flush=True)
    return {"commit": commit, "circuits": circuits}


def table(measured):
    commit = measured["commit"][:7]
    lines = [f"| LUT | usual order, `{commit}` | now | {ORDERS} orders, `{commit}` | now | median, `{commit}` | now |",
             "|---|---:|---:|---:|---:|---:|---:|"]
    for mapped in MAPPED:
        of = measured["circuits"][mapped.key].values()
        cells = [f"{each['lut'][0]:,}" for each in of]
        cells += [f"{min(each['lut']):,} to {max(each['lut']):,}" for each in of]
        cells += [f"{each['median']:,}" for each in of]
        lines.append(f"| {fpga.FAMILIES[mapped.family].name}, {mapped.title} | {' | '.join(cells)} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("commit", metavar="COMMIT")
    commit = parser.parse_args().commit
    try:
        measured = measure(commit)
        fpga.insert("noise", table(measured))
        results.write("fpga_noise", ABOUT, f"scripts/fpga_noise.py {commit}", measured, rtl_tree.ROOT / "results")
    except (OSError, ValueError, fpga.FpgaError) as error:
        print(f"fpga_noise.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
