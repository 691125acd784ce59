#!/usr/bin/env python3
"""Few rows of hidden rigs: calibrated with the whole sensor, then run with 20 rows at 50,000 frames a second.

    few_rows.py [--seeds N-M] [--quick] [--rows N] [--rate HZ] [--frames N] [--programs DIR] [--out DIR] [--add]

As hidden_rigs.py, by the documented commands and images alone: board, plates, and a scan of the good part with the
whole sensor; `selfproj rows` chooses the rows; images of the good part under its pattern with the short exposure, as the
camera then sends them, give the residual (`selfproj pattern --residual`); the part passes, the RTL makes packets of the
frames (`selfproj-sim cosim --engine rtl`, every packet compared with the model's), and `selfproj inspect` measures.
Experiments A1 (mountain) and A2 (stairs): the RMS of the differences from the good part over the columns with a
reference, but those within half a millimetre of a step (STEP_COLUMNS). Then parts of both that lie higher, aside or
turned (DISPLACED) pass a board whose camera obeys the register `region` (`selfproj-sim board --sensor`, whose packets
are the model's), one after the other, and `selfproj inspect --follow` moves the region; a part's last frames are those
that count, because the first ones are seen where the part before has left the region. Columns beside the jumps of the
pattern, which stays where it is, are left out as those beside steps are. With SELFPROJ_RESULTS set, few_rows.json is
written; --add keeps the seeds that an earlier run has measured. The exit status is 1 where a bound is not reached.
Standard library only.
"""

import argparse
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import float_tiff
import hidden_rig_figures as figures
import hidden_rigs
import results  # hidden_rigs has set its path

RIG = "light-section"
SCENES = {"A1": "mountain", "A2": "stairs"}
DISPLACED = (("lift", 2), ("lift", -2), ("aside", 2), ("turn", -1), ("lift", -2), ("aside", -2), ("turn", 1),
             ("lift", 2))
DISPLACED_FRAMES = 60  # of each, at DISPLACED_RATE
DISPLACED_RATE = 100   # of the simulated board, whose host shares the machine with it
STEP_COLUMNS = 3
RMS_MM = 0.03
ALL = (*SCENES, *(f"{name} displaced" for name in SCENES))
COLUMNS_SHARE = 0.8  # of the part's, those beside steps counted as missing
MIDDLE_MM = 70  # where the belt has the middle of the part under the line


def calibrated(chain, effort):
    """The rig, calibrated with the whole sensor."""
    boards = ",".join(map(str, effort.boards))
    chain.calibrate(RIG, ("--heights", boards, "--moves", hidden_rigs.MOVES, "--bend", 0.01),
                    ("--plates", boards, "--moves", hidden_rigs.MOVES))
    chain.host("pattern", "--rig", RIG, "--sweep", "--every", effort.every_line, "--out", "lines")
    plates = [chain.plate(RIG, height) for height in effort.heights]
    chain.host("calibrate", "heights", "--rig", "calibration/rig.yaml", "--heights",
               ",".join(map(str, effort.heights)), "--every", effort.every_line, "--out", "heights", *plates)
    (chain.folder / "drawn.yaml").write_text(hidden_rigs.drawn(RIG), encoding="utf-8")
    return "heights/rig.yaml"


def compared(height, truth, jumps=()):
    """The figures of heights beside the truth. `jumps`: columns that are left out as those beside steps are."""
    reach = 5  # frames, 0.1 mm of the belt: the light slides down the walls of turned parts
    edges = figures.near_steps(truth, STEP_COLUMNS, reach, apart=reach)
    squares = points = seen = beside = 0
    greatest = 0.0
    for measured, true, edge in zip(height, truth, edges):
        for column, (h, t) in enumerate(zip(measured, true)):
            left_out = edge[column] or column in jumps
            seen += not math.isnan(t)
            if left_out or math.isnan(t):
                beside += not math.isnan(t)
            elif not math.isnan(h):
                points += 1
                squares += (h - t) ** 2
                greatest = max(greatest, abs(h - t))
    return {"rms_mm": math.sqrt(squares / max(points, 1)), "max_mm": greatest, "columns": points / max(seen, 1),
            "left_out": beside / max(seen, 1), "points": points}


def displaced(chain, name, scene, options):
    """Parts of an experiment that lie elsewhere, one after the other. Returns the figures of the worst."""
    few, part = f"{name}/few.yaml", f"{name}/part"
    middle = round(MIDDLE_MM * options.rate / 1000)
    folders = []
    for number, (way, value) in enumerate(DISPLACED):
        folder = f"{name}/moved_{number}"
        chain.render(scene, part, folder, "--first", middle, "--count", DISPLACED_FRAMES, f"--{way}", value,
                     "--truth", f"{folder}.tiff", "--region-of", few, "--uncropped")
        folders.append(folder)
    ring = f"few-rows-{os.getpid()}-{chain.seed}"
    address = f"127.0.{1 + chain.seed // 250}.{1 + chain.seed % 250}"  # of that board's registers
    images = [str(file) for folder in folders for file in sorted((chain.folder / folder).glob("*.png"))]
    programs = options.programs.resolve()
    board = subprocess.Popen([programs / "selfproj-sim", "board", "--images", *images, "--sensor", "--rate",
                              str(DISPLACED_RATE), "--ring", ring, "--control", address], stdout=subprocess.DEVNULL)
    try:
        info = [programs / "selfproj", "board", "info", "--device", f"udp:{address}"]
        while subprocess.run(info, capture_output=True, check=False).returncode:
            if board.poll() is not None:
                raise hidden_rigs.Refused("selfproj-sim board has ended")
            time.sleep(0.1)
        chain.host("inspect", "--device", f"ring:{ring}", "--control", f"udp:{address}", "--rig", few, "--reference",
                   part, "--follow", "--assume", "speed", "--count", len(images), "--out", f"{name}/followed")
    finally:
        board.terminate()
        board.wait()
    height = float_tiff.read(chain.folder / f"{name}/followed/height.tiff")
    # The pattern jumps where the part in its place has its steps. There light leaks from one column to the next.
    place = float_tiff.read(chain.folder / f"{name}/truth.tiff")
    jumps = {c for c, near in enumerate(figures.near_steps(place[:1], STEP_COLUMNS, 0, apart=0)[0]) if near}
    found = []
    for number, folder in enumerate(folders):
        half = DISPLACED_FRAMES // 2
        begin = number * DISPLACED_FRAMES + half
        truth = float_tiff.read(chain.folder / f"{folder}.tiff")[half:]
        found.append(compared(height[begin:begin + half], truth, jumps))
    return {"rms_mm": max(one["rms_mm"] for one in found), "max_mm": max(one["max_mm"] for one in found),
            "columns": min(one["columns"] for one in found), "left_out": max(one["left_out"] for one in found),
            "points": sum(one["points"] for one in found)}


def run(chain, name, scene, rig, effort, options):
    """The part of an experiment with few rows. Returns its figures."""
    def at(folder):
        return f"{name}/{folder}"

    (chain.folder / name).mkdir(exist_ok=True)
    chain.take("capture", "--rig", RIG, "--out", at("scan"), "--patterns", "lines", "--scene", scene, "--stopped")
    chain.host("pattern", "--rig", rig, "--scan", at("scan"), "--every", effort.every_line, "--out", at("good"))
    chain.host("rows", "--rig", rig, "--reference", at("good"), "--rows", options.rows, "--rate", options.rate, "--out",
               at("few.yaml"))
    step = 1000 / options.rate  # mm of the belt between frames
    middle = round(MIDDLE_MM / step)
    few = ("--region-of", at("few.yaml"))
    chain.render(scene, at("good"), at("seen"), "--first", middle, "--count", 64, *few)
    chain.host("pattern", "--rig", at("few.yaml"), "--reference", at("good"), "--residual", at("seen"), "--out",
               at("part"))
    chain.render(scene, at("part"), at("frames"), "--first", middle - options.frames // 2, "--count", options.frames,
                 "--truth", at("truth.tiff"), *few)
    chain.run("selfproj-sim", "cosim", "--frames", at("frames/*.png"), "--engine", "rtl", "--rig", at("few.yaml"),
              "--packets", at("packets"))
    chain.host("inspect", "--device", f"file:{at('packets')}", "--rig", at("few.yaml"), "--reference", at("part"),
               "--out", at("result"), "--check")
    region = (chain.folder / at("few.yaml")).read_text(encoding="utf-8").split("region:")[1].split("projector:")[0]
    values = dict(line.strip().split(": ") for line in region.strip().splitlines())
    return {**compared(float_tiff.read(chain.folder / at("result/height.tiff")),
                       float_tiff.read(chain.folder / at("truth.tiff"))),
            "rows": int(values["rows"]), "rate_hz": float(values["frame_rate_hz"]),
            "exposure_us": float(values["exposure_us"])}


def measured(seed, root, options):
    effort = hidden_rigs.QUICK if options.quick else hidden_rigs.FULL
    chain = hidden_rigs.Chain((root / f"seed_{seed}").resolve(), options.programs.resolve(), seed)
    try:
        rig = calibrated(chain, effort)
        found = {name: run(chain, name, scene, rig, effort, options) for name, scene in SCENES.items()}
        found |= {f"{name} displaced": displaced(chain, name, scene, options) for name, scene in SCENES.items()}
    except hidden_rigs.Refused as error:
        return {"refused": str(error)}
    return found


def missed(found):
    if "refused" in found:
        return ["refused"]
    return [f"{name} {key}" for name, one in found.items() for key, bad in
            (("RMS", not one["rms_mm"] <= RMS_MM), ("columns", not one["columns"] >= COLUMNS_SHARE)) if bad]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=hidden_rigs.seeds_of, default=hidden_rigs.seeds_of("1-20"), metavar="N-M")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--rows", type=int, default=20)
    parser.add_argument("--rate", type=int, default=50000)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--programs", type=pathlib.Path, default=hidden_rigs.ROOT / "build/bin")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--add", action="store_true")
    options = parser.parse_args()
    by_seed = {}
    with tempfile.TemporaryDirectory(prefix="selfproj_few_rows_") as scratch:
        root = options.out or pathlib.Path(scratch)
        for seed in options.seeds:
            found = by_seed[seed] = measured(seed, root, options)
            found["missed"] = missed({key: value for key, value in found.items() if key != "missed"})
            print(f"seed {seed}: " + (found.get("refused") or "; ".join(
                f"{name} RMS {found[name]['rms_mm']:.4f} mm over {100 * found[name]['columns']:.1f} % of the columns, "
                f"{100 * found[name]['left_out']:.1f} % left out beside steps" for name in ALL)),
              flush=True)
    if options.add and (before := results.recorded("few_rows").get("seeds")):
        by_seed = {seed: by_seed.get(seed) or before[str(seed)] for seed in sorted({*by_seed, *map(int, before)})}
    bad = sum(bool(found["missed"]) for found in by_seed.values())
    print(f"{len(by_seed) - bad} of {len(by_seed)} hidden rigs hold the bounds: {RMS_MM} mm RMS over "
          f"{100 * COLUMNS_SHARE:.0f} % of the columns, {options.rows} rows at {options.rate} frames a second")
    if os.environ.get(results.VARIABLE):
        columns = [(name, key, form) for name in ALL for key, form in (("rms_mm", ".4f"), ("columns", ".1%"))]
        header = ["seed", *(f"{name}, {'RMS' if key == 'rms_mm' else key}" for name, key, _ in columns),
                  "does not hold"]
        rows = [[f"{seed:02}",
                 *(f"{found[name][key]:{form}}" if name in found else "–" for name, key, form in columns),
                 ", ".join(found["missed"]) if "refused" not in found else found["refused"]]
                for seed, found in by_seed.items()]
        table = {"title": f"Hidden rigs with {options.rows} rows at {options.rate:,} frames a second", "header": header,
                 "rows": rows,
                 "note": f"mm; bounds {RMS_MM} mm RMS over {COLUMNS_SHARE:.0%} of the columns of the part"}
        results.write("few_rows", "Few rows of simulated rigs calibrated from images alone, compared with the truth",
                      "lab/scripts/few_rows.py" + (" --quick" if options.quick else ""),
                      {"seeds": {str(seed): found for seed, found in by_seed.items()}, "within": len(by_seed) - bad,
                       "of": len(by_seed), "table": table})
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
