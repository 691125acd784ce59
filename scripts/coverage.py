#!/usr/bin/env python3
"""coverage.py [--no-build]: line and toggle coverage of rtl/ by the tests of its blocks and of the board.

Builds them with counting models in build/coverage, runs them (the first 20 cases of each random test), lists every
point that no test reached, and compares the list with tests/rtl/coverage_exceptions.txt.

Points are merged over all programs, models, parameters and instances. A point is a place in a source file (toggle: a
bit of a signal), and is covered where any instance reached it (toggle: in both directions). An exception is a line
`file | pattern | reason`, which indented lines continue. File and pattern are regular expressions; the pattern is for a
whole signal name with its bit (toggle) or for a whole source line (line). The exit status is 1 if a point is neither
covered nor excepted, or if an exception is not needed any more. Standard library only.
"""

import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys

import results
from lib import reason_list

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "coverage"
COUNTS = BUILD / "counts"
EXCEPTIONS = ROOT / "tests" / "rtl" / "coverage_exceptions.txt"
# Programs below tests/rtl and their tests, the longest first. Each runs in one process, so that the tests share a model
# and its resets are counted.
TESTS = {"board/board_test": "Board.*", "board/board_codes_test": "CodesBoard.*:RunsBoard.*", "blocks/rtl_blocks": "*"}
POINT = re.compile(rb"^C '(.*)' (\d+)$")
NEEDED = {"line": 1, "toggle": 2}  # a bit has to rise and to fall


def build():
    subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG", "-DSELFPROJ_COVERAGE=ON"], check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", BUILD, "--target", *(pathlib.Path(test).name for test in TESTS)], check=True)


def run_tests():
    shutil.rmtree(COUNTS, ignore_errors=True)
    COUNTS.mkdir(parents=True)
    environment = os.environ | {"SELFPROJ_CASES": "20", "SELFPROJ_COVERAGE_FILE": str(COUNTS / "coverage.dat")}

    def run(test):
        subprocess.run([f"./{test}", "--gtest_brief=1", f"--gtest_filter={TESTS[test]}"], check=True, env=environment,
                       cwd=BUILD / "tests" / "rtl")

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(run, TESTS))


def read_counts():
    """(file, line, kind, name) -> count"""
    counts = collections.Counter()
    files = sorted(COUNTS.iterdir())
    for path in files:
        with open(path, "rb") as file:
            for line in file:
                match = POINT.match(line.rstrip(b"\n"))
                if not match:
                    continue
                keys = dict(field.split(b"\2", 1) for field in match[1].split(b"\1")[1:])
                text = {key.decode(): value.decode() for key, value in keys.items()}
                source = ROOT / text["f"]
                if not source.is_relative_to(ROOT / "rtl"):
                    continue
                kind = text["page"].split("/")[0].removeprefix("v_")
                if kind == "branch":
                    kind = "line"
                if kind in NEEDED:
                    name = text["o"] if kind == "toggle" else text["n"]
                    counts[(source.relative_to(ROOT).as_posix(), int(text["l"]), kind, name)] += int(match[2])
    return files, counts


class Tally:
    """Counts the points of each source and kind, those that are covered, and the reasons for the others."""

    def __init__(self, counts, exceptions):
        self.sources = collections.defaultdict(lambda: {kind: [0, 0] for kind in NEEDED})
        self.total = {kind: [0, 0] for kind in NEEDED}
        self.missing = []
        self.excused = 0
        self.not_needed = set(exceptions)
        for (source, line, kind, name), count in sorted(counts.items()):
            covered = count >= NEEDED[kind]
            for points in (self.sources[source][kind], self.total[kind]):
                points[0] += covered
                points[1] += 1
            if covered:
                continue
            text = (ROOT / source).read_text(encoding="utf-8").splitlines()[line - 1].strip()
            target = name if kind == "toggle" else text
            fitting = [rule for rule in exceptions if rule[0].fullmatch(source) and rule[1].fullmatch(target)]
            self.not_needed.difference_update(fitting)
            if fitting:
                self.excused += 1
            else:
                self.missing.append(f"{source}:{line}: {kind}: {target}")

    def print(self):
        print(f"{'file':40} {'lines':>14} {'toggles':>16}")
        for source, kinds in sorted(self.sources.items()):
            lines, toggles = ("{}/{}".format(*kinds[kind]) for kind in NEEDED)
            print(f"{source:40} {lines:>14} {toggles:>16}")
        for point in self.missing:
            print(f"not covered: {point}")
        for file, pattern, reason in sorted(self.not_needed, key=str):
            print(f"exception not needed: {file.pattern} | {pattern.pattern} | {reason}")


def percent(covered, total):
    return "-" if total == 0 else f"{100 * covered / total:.1f} %"


def figures(kinds, share=False):
    """The points of each kind, for the results file."""
    return {
        kind: {"covered": covered, "points": points} | ({"share": covered / max(1, points)} if share else {})
        for kind, (covered, points) in kinds.items()
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--no-build", action="store_true")
    try:
        if not parser.parse_args().no_build:
            build()
        run_tests()
        exceptions = reason_list.read(EXCEPTIONS)
    except (OSError, ValueError, subprocess.CalledProcessError) as error:
        sys.exit(f"coverage.py: {error}")
    files, counts = read_counts()
    if not counts:
        sys.exit(f"coverage.py: {COUNTS}: no counts of rtl/")
    tally = Tally(counts, exceptions)
    print(f"{len(files)} files of counts")
    tally.print()
    print(f"line {percent(*tally.total['line'])}, toggle {percent(*tally.total['toggle'])}, "
          f"{tally.excused} points under {len(exceptions)} exceptions, {len(tally.missing)} uncovered, "
          f"{len(tally.not_needed)} exceptions not needed")
    results.write(
        "coverage",
        "Lines and toggles of rtl/ that the tests of its blocks and of the board reach",
        "scripts/coverage.py",
        {
            "files": {source: figures(kinds) for source, kinds in sorted(tally.sources.items())},
            "all": figures(tally.total, share=True),
            "excused": tally.excused,
            "exceptions": len(exceptions),
            "uncovered": len(tally.missing),
        },
    )
    sys.exit(1 if tally.missing or tally.not_needed else 0)


if __name__ == "__main__":
    main()
