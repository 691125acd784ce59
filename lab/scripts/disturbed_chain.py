#!/usr/bin/env python3
"""Walks the user's chain in a world that is not ideal, by the commands alone: what is false, and what is lost.

    disturbed_chain.py [--seeds N-M] [--disturb A,B ...] [--ambiguous-from SHARE] [--small|--known] [--programs DIR]
                       [--out DIR]

Each seed draws a rig that nobody knows, as hidden_rigs.py does, and calibrates it by a chessboard on plates in an ideal
world. Then, once in that world and once with each disturbance, it does what a user does: heights by sweeps over plates
(`selfproj calibrate heights`), a scan of the good part and its residual (`selfproj pattern`), the part with marks
(`selfproj-sim cosim --select strongest`), and its points (`selfproj inspect`). The rig says that the strongest run of
each column counts, unless another one has --ambiguous-from of its light: 0.75 was chosen on seed 31. The points are
compared with the truth of the simulation.

False is a point away from height steps that is more than 0.3 mm off. Lost are places that have a point in the ideal
world and none here. A place without a line is one where in the ideal world's images no pixel is lit within 3 columns,
and as far along the belt. --small takes one frame in twenty. --known does so with the rig of the drawings, which nothing
needs to calibrate. The exit status is 1 where a bound is not held. With --out, all files are kept in DIR, a new folder.
With SELFPROJ_RESULTS set, disturbed_chain.json is written. Standard library only.
"""

import argparse
import math
import pathlib
import shutil
import sys
import tempfile

import float_tiff
import hidden_rig_figures as figures
import hidden_rigs
import results  # hidden_rigs has set its path

IDEAL = "ideal"
WORLDS = ("second-line=0.3", "defect-pixels=1e-3", "second-line=0.3,defect-pixels=1e-3")
FALSE_MM = 0.3
COUNTS = ("points", "false_points", "squares", "ideal_points", "lost_points", "unlit_places", "unlit_points")
BOUNDS = {"false": 1e-4, "lost": 0.01, "without_line": 1e-4}
RIG = "light-section"
KNOWN = hidden_rigs.Effort(0, (), (), 8, 20)


def with_strongest_run(text, ambiguous_from):
    """A rig of which the strongest run of each column counts, unless another one has so great a share of its light."""
    return text.replace("\nmeasure:\n", f"\nmeasure:\n  runs: {{gap_rows: 0, ambiguous_from: {ambiguous_from}}}\n", 1)


class DisturbedChain(hidden_rigs.Chain):
    """The chain, whose camera sees a world that is not ideal."""

    def __init__(self, folder, programs, seed, world, known, ambiguous_from):
        super().__init__(folder, programs, seed)
        self.ambiguous_from = ambiguous_from
        self.noise, self.known = 1000 * seed + 500, known
        self.disturb = () if world == IDEAL else ("--disturb", world)

    def take(self, *arguments):
        if self.known:
            self.noise += 1
            self.run("selfproj-sim", *arguments, "--seed", self.noise, *self.disturb)
        else:
            super().take(*arguments, *self.disturb)


def measured(chain, calibrated, effort):
    """From the calibrated rig to points: heights, scan, residual, part. Returns heights and truth."""
    chain.folder.mkdir(parents=True, exist_ok=True)
    (chain.folder / "calibrated.yaml").write_text(with_strongest_run(calibrated, chain.ambiguous_from),
                                                   encoding="utf-8")
    every = effort.every_line
    chain.host("pattern", "--rig", RIG, "--sweep", "--every", every, "--out", "lines")
    believed = "calibrated.yaml"
    if effort.heights:
        plates = [chain.plate(RIG, height) for height in effort.heights]
        chain.host("calibrate", "heights", "--rig", believed, "--heights", ",".join(map(str, effort.heights)),
                   "--every", every, "--out", "heights", *plates)
        believed = "heights/rig.yaml"
    chain.take("capture", "--rig", RIG, "--out", "scan", "--patterns", "lines", "--scene", "stairs", "--stopped")
    chain.host("pattern", "--rig", believed, "--scan", "scan", "--every", every, "--out", "good")
    drawn = hidden_rigs.drawn(RIG, effort.every_frame)
    (chain.folder / "drawn.yaml").write_text(drawn, encoding="utf-8")
    count = min(16, round(60 / effort.spacing_mm))
    chain.render("stairs", "good", "seen", "--first", round(70 / effort.spacing_mm - count / 2), "--count", count)
    chain.host("pattern", "--rig", believed, "--reference", "good", "--residual", "seen", "--out", "part")
    chain.render("stairs-marked", "part", "frames", "--truth", "truth.tiff")
    chain.run("selfproj-sim", "cosim", "--frames", "frames/*.png", "--engine", "model", "--rig", "drawn.yaml",
              "--select", "strongest", "--packets", "part.packets")
    chain.host("inspect", "--device", "file:part.packets", "--rig", believed, "--reference", "part", "--out", "result")
    return float_tiff.read(chain.folder / "result/height.tiff"), float_tiff.read(chain.folder / "truth.tiff")


def lit_columns(moments, columns):
    """A row of flags for each frame of moments.csv: the columns that have a lit pixel."""
    with moments.open(encoding="ascii") as table:
        next(table)
        flags = bytearray(line.split(",", 5)[4] != "0" for line in table)
    return [flags[i:i + columns] for i in range(0, len(flags), columns)]


def counts_of(height, truth, spacing, ideal, lit):
    """Points away from steps, false ones, the sum of their squares; places with a point in the ideal world, lost ones;
    places without a lit column of the ideal world near them, points there."""
    reach = math.ceil(figures.STEP_COLUMNS * figures.COLUMN_MM / spacing)
    edges = figures.near_steps(truth, figures.STEP_COLUMNS, reach, apart=reach)
    lit = figures.spread(lit, figures.STEP_COLUMNS)
    lit = zip(*figures.spread([bytearray(column) for column in zip(*lit)], reach))
    found = dict.fromkeys(COUNTS, 0)
    for heights, true, edge, near, wanted in zip(height, truth, edges, lit, ideal):
        for h, t, left_out, light, w in zip(heights, true, edge, near, wanted):
            seen = not math.isnan(h)
            if not math.isnan(w):
                found["ideal_points"] += 1
                found["lost_points"] += not seen
            if not light:
                found["unlit_places"] += 1
                found["unlit_points"] += seen
            if seen and not left_out and not math.isnan(t):
                found["points"] += 1
                found["false_points"] += abs(h - t) > FALSE_MM
                found["squares"] += (h - t) ** 2
    return found


def figures_of(counts):
    """The counts of a world as shares."""
    def share(some, of):
        return counts[some] / max(1, counts[of])

    return {"points": counts["points"], "false": share("false_points", "points"),
            "rms_mm": math.sqrt(share("squares", "points")), "lost": share("lost_points", "ideal_points"),
            "unlit_places": counts["unlit_places"], "without_line": share("unlit_points", "unlit_places")}


def run_seed(seed, root, options, effort, sums, refused):
    """Adds the counts of a seed, world by world."""
    programs = options.programs.resolve()
    calibrated = hidden_rigs.drawn(RIG)
    if not options.known:
        board = hidden_rigs.Chain(root / "board", programs, seed)
        boards = ",".join(map(str, effort.boards))
        board.calibrate(RIG, ("--heights", boards, "--moves", hidden_rigs.MOVES, "--bend", 0.01),
                        ("--plates", boards, "--moves", hidden_rigs.MOVES))
        calibrated = (board.folder / "calibration/rig.yaml").read_text(encoding="utf-8")
    ideal = lit = None
    for world in (IDEAL, *options.disturb):
        chain = DisturbedChain(root / world, programs, seed, world, options.known, options.ambiguous_from)
        one = sums.setdefault(world, dict.fromkeys(COUNTS, 0))
        try:
            height, truth = measured(chain, calibrated, effort)
        except hidden_rigs.Refused as error:
            refused[f"{seed}, {world}"] = str(error)
            print(f"{seed}, {world}: {error}", flush=True)
            continue
        if world == IDEAL:
            ideal, lit = height, lit_columns(chain.folder / "result/moments.csv", len(height[0]))
        counts = counts_of(height, truth, effort.spacing_mm, ideal, lit)
        for key, value in counts.items():
            one[key] += value
        print(f"seed {seed}, {world}: {counts}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=hidden_rigs.seeds_of, default=hidden_rigs.seeds_of("33-34"), metavar="N-M")
    parser.add_argument("--disturb", nargs="+", default=WORLDS, metavar="A,B")
    parser.add_argument("--ambiguous-from", type=float, default=0.75, metavar="SHARE")
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument("--small", action="store_true")
    amount.add_argument("--known", action="store_true")
    parser.add_argument("--programs", type=pathlib.Path, default=hidden_rigs.ROOT / "build/bin")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    if options.out and options.out.exists():
        parser.error(f"--out {options.out}: exists already")
    effort = KNOWN if options.known else hidden_rigs.SMALL if options.small else hidden_rigs.FULL
    sums, refused = {}, {}
    for seed in options.seeds:
        root = options.out or pathlib.Path(tempfile.mkdtemp())
        run_seed(seed, (root / f"{seed:02}").resolve(), options, effort, sums, refused)
        if not options.out:
            shutil.rmtree(root)
    found = {world: figures_of(counts) for world, counts in sums.items()}
    missed = [f"{world}: {key}" for world, one in found.items() for key, bound in BOUNDS.items()
              if not one[key] <= bound] + list(refused)
    for world, one in found.items():
        print(f"{world}: {one['points']} points, false {one['false']:.1e}, lost {one['lost']:.4f}, RMS "
              f"{one['rms_mm']:.4f} mm, points in {one['unlit_places']} places without a line "
              f"{one['without_line']:.1e}")
    for line in missed:
        print(f"not held: {line}")
    results.write("disturbed_chain", "The chain of commands in a world that is not ideal, against the truth",
                  "lab/scripts/disturbed_chain.py" + (" --small" if options.small else " --known" if options.known else ""),
                  {"seeds": list(options.seeds), "worlds": found, "missed": missed, "refused": refused})
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
