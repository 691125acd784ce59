#!/usr/bin/env python3
"""Measures with laser rigs that nobody knows: from images alone to true millimetres.

    hidden_lasers.py [--seeds N-M] [--leans A,B,...] [--parts N] [--jobs N] [--small] [--programs DIR]
                     [--out DIR] [--add]

Each seed and lean draws a camera, its lens, a laser's plane, a belt and an encoder. The simulation takes the images that
a user takes: a chessboard held by hand in room light and with the laser's line, the chessboard carried by the belt, the
line on the empty belt and on a plate of 20 mm. The program `selfproj` sees these images and a drawing that fits no seed:

    selfproj calibrate camera     lens and light plane
    selfproj calibrate belt       plane, zero, way of the belt, encoder
    selfproj inspect              a block with a step of 20 mm, and a smooth ridge that passes under the line
    selfproj pattern --residual   the reference: one image of a good part
    selfproj tolerance learn      from five good parts
    selfproj verdict table        limits for a verdict by moments, as a board gives it
    selfproj inspect --tolerance --verdict  good parts, and bad ones with a dent or a bump of 0.4 to 1 mm: their verdicts

Half of the parts that are judged are bad.

Heights are compared with the truth of the simulation, places along and across with those that the true rig measures of
the same packets. Bounds: the step within 0.02 mm, heights 0.03 mm RMS, places within 0.1 mm over 100 mm, no verdict
wrong.

--small takes smaller images and fewer boards. With --out, all files are kept in DIR, a new folder. With SELFPROJ_RESULTS
set, hidden_lasers.json is written after each rig; with --add it keeps the rigs that an earlier run has measured. The
exit status is 1 where a bound is not held. Standard library only.
"""

import argparse
import concurrent.futures
import csv
import json
import math
import pathlib
import random
import sys
import tempfile

import drawn_rigs
import float_tiff
import hidden_rigs
import results  # hidden_rigs has set its path

BOUNDS = {"step_mm": 0.02, "rms_mm": 0.03, "along_mm": 0.1, "across_mm": 0.1, "wrong_verdicts": 0,
          "false_by_moments": 0}
DISTANCE_MM = 330
STEP_MM = 20
BOARD = ("--chessboard", "9x6", "--square", 7)       # held by hand
BELT_BOARD = ("--chessboard", "9x6", "--square", 6)  # carried by the belt
RATE_HZ, SPEED = 1500, 15000                         # 10 mm from frame to frame


class Effort:
    """How large the images are, and how many."""

    def __init__(self, scale, poses, moves, parts):
        self.rows, self.columns, self.focal_px = round(480 * scale), round(640 * scale), 1600 * scale
        self.poses, self.moves, self.parts = poses, moves, parts


FULL = Effort(1, 18, (0, 5, 10, 15, 20, 25), 4)
SMALL = Effort(0.625, 9, (0, 8, 16, 24), 2)

# Parts of the simulated line (`selfproj-sim production`): heights of a part's two treads, and their width.
TREADS_MM, TREAD_WIDTH_MM = "12,20", 22
PITCH_MM = 100  # more than a part takes
FRAME_MM = 0.25  # the belt moves so far from image to image

PROJECTOR = {"x_mm": 100, "z_mm": 0, "tilt_deg": 0, "focal_length_mm": 20, "lines": 64, "columns": 64,
             "line_pitch_um": 10, "column_pitch_um": 10, "center_xp_mm": 0, "center_yp_mm": 0}


def turned(vector, axis, degrees):
    """The vector turned about the x, y or z axis."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    out = list(vector)
    out[a], out[b] = c * vector[a] - s * vector[b], s * vector[a] + c * vector[b]
    return out


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def true_rig(seed, lean, effort):
    """The text of a rig file with the truth of a seed."""
    draw = random.Random(f"{seed} {lean}").uniform
    turns = [lean + draw(-10, 10), draw(-10, 10), draw(-10, 10)]

    def in_camera(vector):
        for axis, angle in enumerate(turns):
            vector = turned(vector, axis, angle)
        return vector

    way, normal = unit(in_camera([0, 1, 0])), unit(in_camera([0, 0, 1]))
    # The laser's plane holds the line, nearly along the image's rows, and a way down from the source.
    angle = draw(20, 60)
    planes = []
    twist, skew = draw(-5, 5), draw(-5, 5)
    for side in (1, -1):
        down = [0, side * math.sin(math.radians(angle)), math.cos(math.radians(angle))]
        line = unit([math.cos(math.radians(twist)), math.sin(math.radians(twist)), math.sin(math.radians(skew))])
        planes.append((abs(dot(unit(down), normal)), unit(cross(line, down))))
    light = max(planes)[1]  # from the side that is steeper on the belt
    distance = DISTANCE_MM * draw(0.95, 1.05)
    aim = [0, 0, distance]
    focal = effort.focal_px * draw(0.98, 1.02)
    lens = {"fx_px": focal, "fy_px": focal * draw(0.999, 1.001), "cx_px": effort.columns / 2 - 0.5 + draw(-10, 10),
            "cy_px": effort.rows / 2 - 0.5 + draw(-10, 10), "k1": draw(-0.1, 0.1), "k2": 0.0, "p1": draw(-5e-4, 5e-4),
            "p2": draw(-5e-4, 5e-4), "k3": 0.0}
    return drawn_rigs.rig(f"hidden-laser-{seed}-{lean}", (effort.rows, effort.columns), focal, plane=dot(aim, normal),
                          rate=RATE_HZ, speed=SPEED, encoder=0.01 * draw(0.8, 1.2), lens=lens, runs=drawn_rigs.RUNS,
                          light=(light, dot(aim, light)), belt=(way, normal))


def drawing(effort):
    return drawn_rigs.rig("drawing", (effort.rows, effort.columns), effort.focal_px, plane=300.0, projector=PROJECTOR,
                          rate=RATE_HZ, speed=1000, encoder=0.01)


def value_of(text, key):
    return float(text.split(f"{key}: ", 1)[1].split("\n", 1)[0])


class LaserChain(hidden_rigs.Chain):
    def take(self, *arguments):
        self.noise += 1
        self.run("selfproj-sim", *arguments, "--rig", "truth.yaml", "--seed", self.noise)

    def inspect(self, rig, packets, out):
        self.host("inspect", "--rig", rig, "--device", f"file:{packets}", "--out", out, "--check")

    def packets(self, frames, out):
        self.run("selfproj-sim", "cosim", "--frames", frames, "--engine", "model", "--rig", "truth.yaml", "--packets", out)


def images(chain, folder):
    return sorted(str(file.relative_to(chain.folder)) for file in (chain.folder / folder).glob("*.png"))


def places(file):
    """Frame and column of each point, and its x and y."""
    with file.open(encoding="utf-8") as table:
        return {(int(row["frame"]), int(row["column"])): (float(row["x"]), float(row["y"]))
                for row in csv.DictReader(table)}


def level(heights, around):
    near = sorted(h for h in heights if abs(h - around) < STEP_MM / 4)
    return near[len(near) // 2] if near else math.nan


def heights_off(found, truth):
    """Differences away from steps, across and along the belt. Of the first and the last frame nobody knows: there the part
    begins and ends, and the line falls partly beside it."""
    off = []
    for before, heights, true, after in zip(truth, found[1:], truth[1:], truth[2:]):
        for c, (h, t) in enumerate(zip(heights, true)):
            beside = true[max(0, c - 4):c + 5]
            steps = [*zip(beside, beside[1:]), (before[c], t), (t, after[c])]
            if not math.isnan(h - t) and all(abs(a - b) < 1 for a, b in steps):
                off.append(h - t)
    return off


def judged(chain, seed, parts, encoder):
    """Parts by the documented commands, from the line that is now known. Returns how many there were, how many verdicts
    were wrong, and what the moments found of the defects that the heights found, and in good parts."""
    chain.take("capture", "--steps", TREADS_MM, "--tread", TREAD_WIDTH_MM, "--out", "golden")
    chain.run("selfproj-sim", "production", "--rig", "truth.yaml", "--good", 5, "--parts", parts, "--bad-every", 2,
              "--seed", seed, "--out", "parts")
    line = ("--rig", "line/rig.yaml", "--reference", "good_part")
    chain.host("pattern", "--rig", "line/rig.yaml", "--residual", "golden", "--out", "good_part")
    chain.host("tolerance", "learn", *line, "--device", "file:parts/good.packets", "--out", "tolerance.yaml")
    # The line on the belt is in view all the time, so that light does not tell where parts begin. `inspect` places them.
    chain.host("verdict", "table", *line, "--tolerance", "tolerance.yaml", "--defect", "2x2", "--section", 1.5,
               "--mm-per-frame", FRAME_MM, "--start", 0, "--pitch", round(PITCH_MM / encoder), "--out", "verdict.yaml")
    chain.host("inspect", *line, "--device", "file:parts/run.packets", "--tolerance", "tolerance.yaml", "--verdict",
               "verdict.yaml", "--verdict-placed", "--parts", "judged", "--check")
    with (chain.folder / "parts/run.csv").open(encoding="utf-8") as table:
        true = [row["verdict"] for row in csv.DictReader(table)]
    parts = [json.loads(text) for text in
             (chain.folder / "judged/parts.jsonl").read_text(encoding="utf-8").splitlines()]
    found = [part["verdict"] for part in parts]
    by_moments = [part.get("moments", {}).get("defect", False) for part in parts]
    bad = [moments for moments, verdict, truth in zip(by_moments, found, true) if verdict == truth == "bad"]
    return {"parts": len(true), "wrong_verdicts": sum(a != b for a, b in zip(true, found)) + abs(len(true) - len(found)),
            "defects": len(bad), "defects_by_moments": sum(bad),
            "false_by_moments": sum(moments for moments, truth in zip(by_moments, true) if truth == "good")}


def measured(seed, lean, folder, options):
    chain = LaserChain(folder.resolve(), options.programs.resolve(), 100 * seed + lean)
    effort = SMALL if options.small else FULL
    truth = true_rig(seed, lean, effort)
    (chain.folder / "truth.yaml").write_text(truth, encoding="utf-8")
    (chain.folder / "drawing.yaml").write_text(drawing(effort), encoding="utf-8")
    encoder = value_of(truth, "encoder_mm_per_count")
    try:
        chain.take("capture", *BOARD, "--poses", effort.poses, "--tilt", 30, "--target-seed", seed,
                   "--bend", 0.05, "--out", "held")
        chain.host("calibrate", "camera", *BOARD, "--rig", "drawing.yaml", "--out", "camera", *images(chain, "held/boards"),
                   "--laser", *images(chain, "held/lines"))
        chain.take("capture", *BELT_BOARD, "--heights", 0, "--moves", ",".join(map(str, effort.moves)), "--target-seed", seed,
                   "--bend", 0.01, "--out", "carried")
        for height in (0, STEP_MM):
            chain.take("capture", "--plate", height, "--target-seed", 100 * seed + height, "--out", f"plate_{height:02}")
        counts = ",".join(str(round(move / encoder)) for move in effort.moves)
        chain.host("calibrate", "belt", "--rig", "camera/rig.yaml", *BELT_BOARD, "--counts", counts, "--out", "line",
                   "--laser", "plate_00/image_00.png", f"plate_{STEP_MM}/image_00.png", "--heights", f"0,{STEP_MM}",
                   *images(chain, "carried/boards"))
        chain.take("capture", "--steps", f"0,{STEP_MM}", "--tread", 40, "--out", "step")
        chain.packets("step/*.png", "step.packets")
        chain.inspect("line/rig.yaml", "step.packets", "step_result")
        chain.take("scene", "render", "mountain", "--truth", "truth.tiff", "--out", "frames")
        (chain.folder / "frames/pattern.tiff").unlink()
        chain.packets("frames/*.png", "part.packets")
        chain.inspect("line/rig.yaml", "part.packets", "result")
        chain.inspect("truth.yaml", "part.packets", "by_truth")
        verdicts = judged(chain, seed, options.parts or effort.parts, encoder)
    except hidden_rigs.Refused as error:
        return {"refused": str(error), "seconds": round(chain.seconds, 1)}
    step = [h for row in float_tiff.read(chain.folder / "step_result/height.tiff") for h in row if not math.isnan(h)]
    off = heights_off(float_tiff.read(chain.folder / "result/height.tiff"), float_tiff.read(chain.folder / "truth.tiff"))
    ours, theirs = places(chain.folder / "result/profile.csv"), places(chain.folder / "by_truth/profile.csv")
    both = sorted(set(ours) & set(theirs))
    scale = value_of((chain.folder / "line/rig.yaml").read_text(encoding="utf-8"), "encoder_mm_per_count") / encoder
    spacing = SPEED / RATE_HZ

    def spread(axis):
        """How far two places a hundred mm apart may be off each other."""
        along = [(spacing * frame if axis == 0 else 0) for frame, _ in both]
        true = [a - theirs[key][0] if axis == 0 else theirs[key][1] for a, key in zip(along, both)]
        ours_at = [scale * a - ours[key][0] if axis == 0 else ours[key][1] for a, key in zip(along, both)]
        wrong = [o - t for o, t in zip(ours_at, true)]
        reach = max(true) - min(true)
        return (max(wrong) - min(wrong)) * 100 / max(100, reach)

    return {"step_mm": abs(level(step, STEP_MM) - level(step, 0) - STEP_MM),
            "rms_mm": math.sqrt(sum(o * o for o in off) / len(off)), "max_mm": max(map(abs, off)),
            "along_mm": spread(0), "across_mm": spread(1), "points": len(off), **verdicts,
            "seconds": round(chain.seconds, 1)}


def name_of(seed, lean):
    return f"lean_{lean:02}_seed_{seed:02}"


def kept_or_not(seed, lean, options):
    """What is measured of a rig; its files are kept if a folder is given."""
    if options.out:
        return measured(seed, lean, options.out / name_of(seed, lean), options)
    with tempfile.TemporaryDirectory(prefix="selfproj_hidden_laser_") as scratch:
        return measured(seed, lean, pathlib.Path(scratch) / name_of(seed, lean), options)


def line_of(name, found):
    if "refused" in found:
        return f"{name}: {found['refused']}"
    return (f"{name}: step {found['step_mm']:.4f}, heights {found['rms_mm']:.4f} RMS, {found['max_mm']:.3f} at most; over "
            f"100 mm along {found['along_mm']:.3f}, across {found['across_mm']:.3f} mm; {found['points']} points; "
            f"{found['wrong_verdicts']} of {found['parts']} verdicts wrong; by moments {found['defects_by_moments']} of "
            f"{found['defects']} defects, {found['false_by_moments']} false; {found['seconds']} s")


def record(found, options):
    """Written after each rig, so that a run that is ended early keeps what it has."""
    seen = [one for one in found.values() if "refused" not in one]
    results.write("hidden_lasers", "Simulated laser rigs calibrated from images alone, compared with their true values",
                  "lab/scripts/hidden_lasers.py" + (" --small" if options.small else ""),
                  {"rigs": dict(sorted(found.items())), "within": sum(not one["missed"] for one in found.values()),
                   "of": len(found), "parts": sum(one["parts"] for one in seen),
                   "wrong_verdicts": sum(one["wrong_verdicts"] for one in seen),
                   "false_by_moments": sum(one["false_by_moments"] for one in seen),
                   "worst": hidden_rigs.worst({k: v for k, v in found.items() if "refused" not in v})})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=hidden_rigs.seeds_of, default=hidden_rigs.seeds_of("1-20"), metavar="N-M")
    parser.add_argument("--leans", type=lambda text: [int(lean) for lean in text.split(",")], default=[0, 30, 45])
    parser.add_argument("--parts", type=int, help="to judge; half of them are bad")
    parser.add_argument("--jobs", type=int, default=1, help="rigs at a time")
    parser.add_argument("--small", action="store_true")
    parser.add_argument("--programs", type=pathlib.Path, default=hidden_rigs.ROOT / "build/bin")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--add", action="store_true")
    options = parser.parse_args()
    if options.out and options.out.exists():
        parser.error(f"--out {options.out}: exists already")
    found = results.recorded("hidden_lasers").get("rigs", {}) if options.add else {}
    rigs = [(seed, lean) for lean in options.leans for seed in options.seeds]
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        for (seed, lean), one in zip(rigs, pool.map(kept_or_not, *zip(*rigs), [options] * len(rigs))):
            one["missed"] = ["refused"] if "refused" in one else [k for k, b in BOUNDS.items() if not one[k] <= b]
            found[name_of(seed, lean)] = one
            print(line_of(name_of(seed, lean), one), *one["missed"], flush=True)
            record(found, options)
    good = sum(not one["missed"] for one in found.values())
    print(f"{good} of {len(found)} within all bounds")
    return 0 if good == len(found) else 1


if __name__ == "__main__":
    sys.exit(main())
