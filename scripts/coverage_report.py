#!/usr/bin/env python3
"""coverage_report.py --exceptions FILE FOLDER: line and toggle coverage of rtl/ from the counts that Verilated models wrote.

Points are merged over all programs, models, parameters and instances: a point is a place in a source file (toggle: a bit of
a signal), covered where any instance reached it (toggle: in both directions). An exception is a line `file | pattern | reason`;
both file and pattern are regular expressions, the pattern for a whole signal name with its bit (toggle) or a whole source
line (line).
"""
import argparse
import collections
import pathlib
import re
import sys

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
                source = pathlib.Path(text["f"])
                if not source.is_relative_to(root / "rtl"):
                    continue
                kind = text["page"].split("/")[0].removeprefix("v_")
                if kind == "branch":
                    kind = "line"
                if kind in NEEDED:
                    name = text["o"] if kind == "toggle" else text["n"]
                    counts[(source.relative_to(root).as_posix(), int(text["l"]), kind, name)] += int(match[2])
    return files, counts


def read_exceptions(path):
    exceptions = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        parts = [part.strip() for part in line.split(" | ", 2)]
        if len(parts) != 3 or not all(parts):
            sys.exit(f"coverage_report.py: {path}:{number}: not `file | pattern | reason`")
        exceptions.append((re.compile(parts[0]), re.compile(parts[1]), line))
    return exceptions


def percent(covered, total):
    return "-" if total == 0 else f"{100 * covered / total:.1f} %"


def main():
    parser = argparse.ArgumentParser(description="Line and toggle coverage of rtl/.")
    parser.add_argument("--exceptions", required=True, type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path, help="where the counts are")
    args = parser.parse_args()

    root = pathlib.Path(__file__).resolve().parent.parent
    files, counts = read_counts(args.folder, root)
    if not counts:
        sys.exit(f"coverage_report.py: {args.folder}: no counts of rtl/")
    exceptions = read_exceptions(args.exceptions)
    used = set()
    tally = collections.defaultdict(lambda: {"line": [0, 0], "toggle": [0, 0]})
    missing = []
    excused = 0
    for (source, line, kind, name), count in sorted(counts.items()):
        tally[source][kind][1] += 1
        if count >= NEEDED[kind]:
            tally[source][kind][0] += 1
            continue
        text = (root / source).read_text(encoding="utf-8").splitlines()[line - 1].strip()
        target = name if kind == "toggle" else text
        reasons = [e for e in exceptions if e[0].fullmatch(source) and e[1].fullmatch(target)]
        if reasons:
            used.update(e[2] for e in reasons)
            excused += 1
        else:
            missing.append(f"{source}:{line}: {kind}: {target}")

    print(f"{len(files)} files of counts")
    print(f"{'file':40} {'lines':>14} {'toggles':>16}")
    total = {"line": [0, 0], "toggle": [0, 0]}
    for source, kinds in sorted(tally.items()):
        cells = []
        for kind in ("line", "toggle"):
            covered, points = kinds[kind]
            total[kind][0] += covered
            total[kind][1] += points
            cells.append(f"{covered}/{points}")
        print(f"{source:40} {cells[0]:>14} {cells[1]:>16}")
    for line in missing:
        print(f"not covered: {line}")
    for _, _, line in exceptions:
        if line not in used:
            print(f"exception not needed: {line}")
    print(f"line {percent(*total['line'])}, toggle {percent(*total['toggle'])}, {excused} points under "
          f"{len(exceptions)} exceptions, {len(missing)} uncovered")
    results.write("coverage", "Lines and toggles of rtl/ that the tests of its blocks and of the board reach",
                  "scripts/coverage.sh",
                  {"files": {source: {kind: {"covered": points[0], "points": points[1]} for kind, points in kinds.items()}
                             for source, kinds in sorted(tally.items())},
                   "all": {kind: {"covered": points[0], "points": points[1], "share": points[0] / max(1, points[1])}
                           for kind, points in total.items()},
                   "excused": excused, "exceptions": len(exceptions), "uncovered": len(missing)})
    sys.exit(1 if missing else 0)


main()
