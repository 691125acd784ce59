#!/usr/bin/env python3
"""laser_cloud.py CAPTURES: measures the captures of a laser line by `selfproj inspect --images`, with the owner's rig.

CAPTURES is the folder laser-chrisspen (lab/accuracy.md). Its owner calibrated by six distances that he measured by hand,
and by the row of the line there: tan(radians a row · rows above the middle + offset) = height of the laser / distance.
These two numbers become a rig: a camera without distortion, and the plane of the laser. The samples whose line he found
well (3 to 7) are measured with it, and the distance of each tenth of the columns is compared with his.

Prints the ratio of our distance to his, and what his calibration allows: two standard errors of the straight line through
his six pairs of row and angle, at the row of each place. This criterion was chosen before it was run. It is run by the
red channel less the image without the laser, as the owner does it, and by the difference of colours. The exit status is 1
if by the red channel the median of what we are off is more than that. If SELFPROJ_RESULTS names a folder,
laser_cloud.json is written there. Needs build/bin/selfproj, or --programs DIR. Standard library only.
"""

import argparse
import csv
import math
import pathlib
import re
import statistics
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import drawn_rigs  # noqa: E402
import results  # noqa: E402

SAMPLES = range(3, 8)
COLUMNS, ROWS = 320, 240
CHANNELS = ("red", "red-difference")
GROUPS = 10       # of columns, for each of which the owner has a distance
NEAREST, FURTHEST = 300, 900  # mm: what the rig measures, half of the middle's distance to both sides
MEASURE = {"threshold": 15, "min_lit_px": 1, "max_lit_px": 24}
STANDARD_ERRORS = 2


def calibration(folder):
    """Returns (row of each column or -1, {column: distance in mm}, height of the laser in mm)."""
    text = (folder / "data/calibrate.yml").read_text(encoding="utf-8")
    rows = [int(number) for number in re.search(r"readings: \[([^]]*)\]", text)[1].split(",")]
    distances = {int(a): float(b) for a, b in re.findall(r"^ {4}(\d+): (\d+)$", text, re.MULTILINE)}
    return rows, distances, float(re.search(r"^h: ([\d.]+)$", text, re.MULTILINE)[1])


def owners_distance(row, radians_a_row, offset, height):
    return height / math.tan(abs(ROWS / 2 - row) * radians_a_row + offset)


def rig_text(radians_a_row, offset, height, rows):
    """The rig of a laser above the camera, for the first `rows` rows of the image."""
    length = math.hypot(1, math.tan(offset))
    focal = 1 / radians_a_row
    return drawn_rigs.rig("laser-chrisspen", (rows, COLUMNS), focal, plane=(NEAREST + FURTHEST) / 2, exposure=1000,
                          measure=MEASURE, runs=drawn_rigs.RUNS, max_z_per_line=FURTHEST**2 * radians_a_row / height,
                          lens={"fx_px": focal, "fy_px": focal, "cx_px": COLUMNS / 2, "cy_px": ROWS / 2},
                          light=((0, -1 / length, math.tan(offset) / length), height / length))


class AngleErrors:
    """Standard errors of the line of least squares, angle = a rows + b, through the owner's pairs."""

    def __init__(self, line_rows, distances, height):
        rows = [ROWS / 2 - line_rows[column] for column in distances]
        angles = [math.atan(height / distance) for distance in distances.values()]
        self.count, self.middle = len(rows), statistics.fmean(rows)
        self.squares = sum((row - self.middle) ** 2 for row in rows)
        line = statistics.linear_regression(rows, angles)
        left = [angle - line.slope * row - line.intercept for row, angle in zip(rows, angles)]
        self.spread = math.sqrt(sum(angle * angle for angle in left) / (self.count - 2))

    def at(self, row):
        return self.spread * math.sqrt(1 / self.count + (row - self.middle) ** 2 / self.squares)


def cloud_of(path):
    """Yields (x, y, z) of a binary PLY of `selfproj inspect`."""
    data = path.read_bytes()
    head, _, body = data.partition(b"end_header\n")
    count = int(re.search(rb"element vertex (\d+)", head)[1])
    size = sum({b"float": 4, b"uchar": 1}[kind] for kind in re.findall(rb"^property (\w+)", head, re.MULTILINE))
    for i in range(count):
        yield struct.unpack_from("<fff", body, size * i)


def measured(program, folder, sample, channel, rig, rows, out):
    images = folder / f"images/sample{sample}"
    command = [program, "inspect", "--rig", rig, "--images", images / f"sample{sample}-b-0.jpg", "--background",
               images / f"sample{sample}-a-0.jpg", "--channel", channel, "--roi", f"{COLUMNS}x{rows}+0+0",
               "--out", out]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"laser_cloud.py: {done.stderr.strip()}")
    return list(cloud_of(out / "cloud.ply"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("captures", type=pathlib.Path)
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/bin")
    args = parser.parse_args()
    line_rows, distances, height = calibration(args.captures)
    with open(args.captures / "data/samples.csv", encoding="utf-8") as table:
        samples = {int(row["cnt"]): row for row in csv.DictReader(table)}
    first = samples[SAMPLES[0]]
    radians_a_row, offset = float(first["rpc"]), float(first["ro"])

    errors = AngleErrors(line_rows, distances, height)
    own = {column: owners_distance(line_rows[column], radians_a_row, offset, height) / distance
           for column, distance in distances.items()}
    print("his numbers against the distances that he measured: " +
          ", ".join(f"{distances[column]:.0f} mm {100 * (ratio - 1):+.1f} %" for column, ratio in own.items()))

    # Rows that see the line nearer than FURTHEST.
    rows = int(ROWS / 2 - (math.atan(height / FURTHEST) - offset) / radians_a_row)

    def figures(channel, rig, folder):
        ratios, limits = [], []  # of our distance to his; how far it may be off there
        for sample in SAMPLES:
            points = measured(args.programs / "selfproj", args.captures, sample, channel, rig, rows, folder / str(sample))
            groups = [[] for _ in range(GROUPS)]
            for x, y, z in points:
                column = y / z / radians_a_row + COLUMNS / 2
                groups[min(GROUPS - 1, max(0, int(column * GROUPS / COLUMNS)))].append(z)
            for group, text in zip(groups, samples[sample]["distances_10"].split(",")):
                his = float(text)
                if NEAREST <= his <= FURTHEST and len(group) >= COLUMNS // GROUPS // 2:
                    ratios.append(statistics.median(group) / his)
                    angle = math.atan(height / his)
                    off = errors.at((angle - offset) / radians_a_row)
                    limits.append(STANDARD_ERRORS * off / (math.sin(angle) * math.cos(angle)))
                    print(f"{channel}, sample {sample}: {statistics.median(group):7.1f} mm, his {his:5.0f} mm")
        low, middle, high = statistics.quantiles(ratios, n=4)
        share = statistics.median((ratio - 1) / limit for ratio, limit in zip(ratios, limits))
        print(f"{channel}, {len(ratios)} places: our distance is {middle:.4f} of his (quartiles {low:.4f} and {high:.4f}). "
              f"His calibration allows {statistics.median(limits):.4f} (median); the median is off by {share:.2f} of what "
              "it allows")
        return {"places": len(ratios), "ratio": middle, "quartile_low": low, "quartile_high": high,
                "allowed": statistics.median(limits), "share_of_allowed": share}

    found = {}
    with tempfile.TemporaryDirectory(prefix="laser_cloud.") as temporary:
        rig = pathlib.Path(temporary) / "rig.yaml"
        rig.write_text(rig_text(radians_a_row, offset, height, rows), encoding="utf-8")
        for channel in CHANNELS:
            found[channel.replace("-", "_")] = figures(channel, rig, pathlib.Path(temporary) / channel)
    results.write("laser_cloud", "The cloud of captures of a laser line, with the owner's rig, against his distances",
                  "lab/scripts/laser_cloud.py laser-chrisspen",
                  found)
    return 0 if abs(found["red"]["share_of_allowed"]) <= 1 else 1


if __name__ == "__main__":
    sys.exit(main())
