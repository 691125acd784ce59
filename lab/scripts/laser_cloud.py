#!/usr/bin/env python3
"""laser_cloud.py CAPTURES: measures the captures of a laser line by `selfproj inspect --images`, with the owner's rig.

CAPTURES is the folder laser-chrisspen (lab/accuracy.md). Its owner calibrated by six distances that he measured by hand,
and by the row of the line there: tan(radians a row · rows above the middle + offset) = height of the laser / distance.
These two numbers become a rig: a camera without distortion, and the plane of the laser. The samples whose line he found
well (3 to 7) are measured with it, and the distance of each tenth of the columns is compared with his.

Prints the ratio of our distance to his, and what his calibration allows: how well his own numbers give the six distances
back, and half a row of the image, because he read whole rows. The exit status is 1 if the median of what we are off is
more than that. If SELFPROJ_RESULTS names a
folder, laser_cloud.json is written there. Needs build/bin/selfproj, or --programs DIR. Standard library only.
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
import results  # noqa: E402

SAMPLES = range(3, 8)
COLUMNS, ROWS = 320, 240
GROUPS = 10       # of columns, for each of which the owner has a distance
FURTHEST = 1500   # mm: beyond, one row of the image is worth more than a third of the distance
RIG = """name: laser-chrisspen
kind: light-section
plane_z_mm: 1000
camera:
  rows: {rows}
  columns: {columns}
  pixel_pitch_um: 10
  focal_length_mm: {focal_mm!r}
  frame_rate_hz: 1
  exposure_us: 1000
conveyor:
  speed_mm_per_s: 0
  encoder_mm_per_count: 1
measure:
  mode: grey-over
  threshold: 15
  min_lit_px: 1
  max_lit_px: 24
  line_width_px: 3
  code_threshold: 5
  max_z_per_line_mm: 5
  runs:
    gap_rows: 1
    ambiguous_from: 0.5
imaging:
  white: 200
  ambient: 8
  dark: 2
  camera_blur_px: 0.7
  projector_blur_px: 0.7
  electrons_per_grey: 80
  read_noise: 1
  seed: 1
camera_lens:
  fx_px: {focal!r}
  fy_px: {focal!r}
  cx_px: {cx!r}
  cy_px: {cy!r}
  k1: 0
  k2: 0
  p1: 0
  p2: 0
  k3: 0
light_plane:
  normal_x: 0
  normal_y: {normal_y!r}
  normal_z: {normal_z!r}
  distance_mm: {distance!r}
"""


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
    return RIG.format(rows=rows, columns=COLUMNS, focal=focal, focal_mm=focal / 100, cx=COLUMNS / 2, cy=ROWS / 2,
                      normal_y=-1 / length, normal_z=math.tan(offset) / length, distance=height / length)


def cloud_of(path):
    """Yields (x, y, z) of a binary PLY of `selfproj inspect`."""
    data = path.read_bytes()
    head, _, body = data.partition(b"end_header\n")
    count = int(re.search(rb"element vertex (\d+)", head)[1])
    for i in range(count):
        yield struct.unpack_from("<fff", body, 19 * i)


def measured(program, folder, sample, rig, rows, out):
    images = folder / f"images/sample{sample}"
    command = [program, "inspect", "--rig", rig, "--images", images / f"sample{sample}-b-0.jpg", "--background",
               images / f"sample{sample}-a-0.jpg", "--channel", "red-difference", "--roi", f"{COLUMNS}x{rows}+0+0",
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

    own = {column: owners_distance(line_rows[column], radians_a_row, offset, height) / distance
           for column, distance in distances.items()}
    near = [abs(ratio - 1) for column, ratio in own.items() if distances[column] <= FURTHEST]
    allowed = max(near)
    print("his numbers against the distances that he measured: " +
          ", ".join(f"{distances[column]:.0f} mm {100 * (ratio - 1):+.1f} %" for column, ratio in own.items()))

    # Rows that see the line nearer than FURTHEST.
    rows = int(ROWS / 2 - (math.atan(height / FURTHEST) - offset) / radians_a_row)
    ratios, shares = [], []  # the latter: of what is allowed there
    with tempfile.TemporaryDirectory(prefix="laser_cloud.") as temporary:
        rig = pathlib.Path(temporary) / "rig.yaml"
        rig.write_text(rig_text(radians_a_row, offset, height, rows), encoding="utf-8")
        for sample in SAMPLES:
            points = measured(args.programs / "selfproj", args.captures, sample, rig, rows,
                              pathlib.Path(temporary) / str(sample))
            groups = [[] for _ in range(GROUPS)]
            for x, y, z in points:
                column = y / z / radians_a_row + COLUMNS / 2
                groups[min(GROUPS - 1, max(0, int(column * GROUPS / COLUMNS)))].append(z)
            for group, text in zip(groups, samples[sample]["distances_10"].split(",")):
                his = float(text)
                if 0 < his <= FURTHEST and len(group) >= COLUMNS // GROUPS // 2:
                    ratios.append(statistics.median(group) / his)
                    half_a_row = 0.5 * radians_a_row * his / height
                    shares.append((ratios[-1] - 1) / (allowed + half_a_row))
                    print(f"sample {sample}: {statistics.median(group):7.1f} mm, his {his:5.0f} mm")
    middle = statistics.median(ratios)
    spread = statistics.quantiles(ratios, n=4)
    print(f"{len(ratios)} places: our distance is {middle:.4f} of his (quartiles {spread[0]:.4f} and {spread[2]:.4f}). His "
          f"numbers are off by up to {allowed:.3f}; with half a row, the median is off by {statistics.median(shares):.2f} of "
          f"what his calibration allows")
    results.write("laser_cloud", "The cloud of captures of a laser line, with the owner's rig, against his distances",
                  "lab/scripts/laser_cloud.py laser-chrisspen",
                  {"places": len(ratios), "ratio": middle, "quartile_low": spread[0], "quartile_high": spread[2],
                   "allowed": allowed, "share_of_allowed": statistics.median(shares)})
    return 0 if abs(statistics.median(shares)) <= 1 else 1


if __name__ == "__main__":
    sys.exit(main())
