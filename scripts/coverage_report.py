#!/usr/bin/env python3
"""coverage_report.py --exceptions FILE FOLDER: line and toggle coverage of rtl/ from the counts of Verilated models.

Points are merged over all programs, models, parameters and instances. A point is a place in a source file (toggle: a
bit of a signal), and is covered where any instance reached it (toggle: in both directions). An exception is a line
`file | pattern | reason`, which indented lines continue. File and pattern are regular expressions; the pattern is for a
whole signal name with its bit (toggle) or for a whole source line (line). The exit status is 1 if a point is neither
covered nor excepted, or if an exception is not needed any more.
"""
import argparse
import collections
import pathlib
import re
import sys

import reason_list
import results

POINT = re.compile(rb"^C '(.*)' (\d+)$")
NEEDED = {"line": 1, "toggle": 2}  # a bit has to rise and to fall


def read_counts(folder, root):
    """(file, line, kind, name) -> count"""
    counts = collections.Counter()
    files = sorted(folder.iterdir())
    for path in files:
        with open(path, "rb") as file:
            for line in file:
                match = POINT.match(line.rstrip(b"\n"))
                if not match:
                    continue
                keys = dict(field.split(b"\2", 1) for field in match[1].split(b"\1")[1:])
                text = {key.decode(): value.decode() for key, value in keys.items()}
                source = root / text["f"]
                if not source.is_relative_to(root / "rtl"):
                    continue
                kind = text["page"].split("/")[0].removeprefix("v_")
                if kind == "branch":
                    kind = "line"
                if kind in NEEDED:
                    name = text["o"] if kind == "toggle" else text["n"]
                    counts[(source.relative_to(root).as_posix(), int(text["l"]), kind, name)] += int(match[2])
    return files, counts


class Tally:
    """Counts the points of each source and kind, those that are covered, and the reasons for the others."""

    def __init__(self, counts, exceptions, root):
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
            text = (root / source).read_text(encoding="utf-8").splitlines()[line - 1].strip()
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
    parser = argparse.ArgumentParser(description="Line and toggle coverage of rtl/.")
    parser.add_argument("--exceptions", required=True, type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path, help="where the counts are")
    args = parser.parse_args()

    root = pathlib.Path(__file__).resolve().parent.parent
    files, counts = read_counts(args.folder, root)
    if not counts:
        sys.exit(f"coverage_report.py: {args.folder}: no counts of rtl/")
    try:
        exceptions = reason_list.read(args.exceptions)
    except ValueError as error:
        sys.exit(f"coverage_report.py: {error}")
    tally = Tally(counts, exceptions, root)
    print(f"{len(files)} files of counts")
    tally.print()
    print(f"line {percent(*tally.total['line'])}, toggle {percent(*tally.total['toggle'])}, "
          f"{tally.excused} points under {len(exceptions)} exceptions, {len(tally.missing)} uncovered, "
          f"{len(tally.not_needed)} exceptions not needed")
    results.write(
        "coverage",
        "Lines and toggles of rtl/ that the tests of its blocks and of the board reach",
        "scripts/coverage.sh",
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
