#!/usr/bin/env python3
"""laser_lines.py CAPTURES: compares `selfproj lines` with the owner's lines in the captures of a laser line.

CAPTURES is the folder images/ of laser-chrisspen (lab/accuracy.md). The first sample is left out, because its two
images were exposed differently. In the others, the row of the line is found from all lit pixels and from the strongest
run. Both are compared with the owner's picture of the line, in the columns where both sides have a line. Prints how
many columns lie within 2 rows. Needs build/bin/selfproj.

If SELFPROJ_RESULTS names a folder, the script writes laser_lines.json there. Standard library only.
"""

import csv
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402

FIRST, LAST = 2, 10
NEAR = 2  # rows
HALF = 8  # a column is ambiguous if its second run has so many sixteenths of the strongest one, as by default
LINE = ["--channel", "red", "--threshold", "15"]


def moments(images, options, folder):
    """Returns {(frame, column): row of the table} of `selfproj lines`."""
    command = [ROOT / "build/bin/selfproj", "lines", *options, "--out", folder, *images]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"laser_lines.py: {done.stderr.strip()}")
    with open(folder / "moments.csv", encoding="utf-8") as table:
        return {(int(row["frame"]), int(row["column"])): row for row in csv.DictReader(table)}


def centroid(row):
    return int(row["m1"]) / int(row["m0"]) if int(row["m0"]) else None


def compare(found, owner):
    """Returns how many of the columns with a line on both sides agree. Ambiguous columns are counted separately."""
    counts = {"columns": 0, "near": 0, "ambiguous": 0}
    for place, row in found.items():
        ours, right = centroid(row), centroid(owner[place])
        if ours is None or right is None:
            continue
        if int(row.get("second", 0)) >= HALF:
            counts["ambiguous"] += 1
            continue
        counts["columns"] += 1
        counts["near"] += abs(ours - right) <= NEAR
    return counts | {"share": counts["near"] / counts["columns"]}


def main():
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__, file=sys.stderr if len(sys.argv) != 2 else sys.stdout)
        return 2 if len(sys.argv) != 2 else 0
    captures = pathlib.Path(sys.argv[1])
    names = [f"sample{number}" for number in range(FIRST, LAST + 1)]
    on, off, drawn = ([captures / name / pattern.format(name) for name in names]
                      for pattern in ("{}-b-0.jpg", "{}-a-0.jpg", "_{}-line-3.jpg"))
    for path in [*on, *off, *drawn]:
        if not path.is_file():
            print(f"laser_lines.py: {path}: no such file", file=sys.stderr)
            return 2
    background = [word for path in off for word in ("--background", path)]
    with tempfile.TemporaryDirectory(prefix="laser_lines.") as temporary:
        folder = pathlib.Path(temporary)
        owner = moments(drawn, ["--select", "all", "--threshold", "128"], folder / "owner")
        found = {"all": moments(on, [*LINE, *background, "--select", "all"], folder / "all"),
                 "strongest": moments(on, [*LINE, *background, "--gap", "1"], folder / "strongest")}
    figures = {name: compare(rows, owner) for name, rows in found.items()}
    several = sum(int(row["runs"]) > 1 for row in found["strongest"].values())
    for name, counts in figures.items():
        print(f"{name}: {counts['near']} of {counts['columns']} columns within {NEAR} rows of the owner's line, "
              f"{counts['share']:.1%}; {counts['ambiguous']} ambiguous")
    results.write("laser_lines",
                  "selfproj lines on captures of a laser line, beside the rows that the owner of the captures marked",
                  "lab/scripts/laser_lines.py laser-chrisspen/images", figures | {"columns_with_several_runs": several})
    return 0


if __name__ == "__main__":
    sys.exit(main())
