#!/usr/bin/env python3
"""Measures with rigs that nobody knows: from images alone to true millimetres.

    hidden_rigs.py [--seeds N-M] [--kind light-section|scanner|both] [--quick|--small] [--given NAME] [--out DIR]
                   [--add]

Each seed draws a rig that deviates from its drawings (`selfproj-sim ... --perturbed-rig-seed`) and takes the images that a
user would take. The program `selfproj` sees these images and the drawings, nothing else. Light section: it calibrates
with a chessboard on plates, ties the heights to plates, scans the good part, makes its pattern, takes out the residual,
and measures experiment A2. Scanner: it calibrates and measures a plane. The figures are compared with the truth of the
simulation.

--quick takes one frame in five of A2, --small the least that still tests every step of the light section. --given
replaces a step by the truth, to show what that step costs: `calibration` (lenses, poses, the belt) or `belt` (the way
it moves). With --out, all files are kept in DIR, a new folder; with --resume, what is in it is not made again. With
SELFPROJ_RESULTS set, hidden_rigs.json is written; with --add it keeps the seeds of earlier runs that this one does not
measure, so that a long table can be made in parts. The exit status is 1 where a bound is not reached. Standard
library only.
"""

import argparse
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time


ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import hidden_rig_figures as figures  # noqa: E402
import results  # noqa: E402

BOUNDS = {"light-section": {"tread_mm": 0.03, "rms_mm": 0.03, "max_mm": 0.10, "place_mm": 0.2},
          "scanner": {"plane_mm": 0.1}}
BOARDS = {"light-section": ("37x3", 2.2), "scanner": ("14x11", 15)}  # corners, side of a square in mm
PROJECTORS = {"light-section": "512x512", "scanner": "1024x768"}
CHECKED_MM = 15  # height of the plate with which the user checks the rig
WRONG_TILT_DEG = 0.02
# The scanner's chessboard is etched in glass or metal, not printed: squares within 2e-5, flat within 0.01 mm.
GLASS_BOARD = ("--print-scale", 2e-5, "--bend", 0.01)
# Coefficients too small to stand out of the noise of the corners still bend a plane by a tenth of a millimetre.
ALL_DISTORTION = ("--camera-distortion", 4, "--projector-distortion", 4)
MOVES = "0,6"  # places of the belt, mm, at which it shows the chessboard on each plate


class Effort:
    """How much is captured."""

    def __init__(self, poses, heights, boards, every_line, every_frame):
        self.poses, self.heights, self.boards = poses, heights, boards
        self.every_line, self.every_frame = every_line, every_frame

    @property
    def spacing_mm(self):
        return 0.1 * self.every_frame


# Poses of the scanner's chessboard. Heights of the light section's plates in mm under the lines, which is all that the
# image's rows can see around the treads; and under the chessboard, which must be seen as a whole.
HEIGHTS = (0, 12, 24, 36, 48, 60)
FULL = Effort(20, HEIGHTS, (0, 12, 24, 36, 48), 4, 1)
QUICK = Effort(20, HEIGHTS, (0, 16, 32, 48), 8, 5)
SMALL = Effort(0, (0, 20, 40, 60), (0, 24, 48), 10, 20)


class Refused(Exception):
    """A program of the chain ended with another status than 0."""


class Chain:
    """The commands of one seed, in a folder of their own."""

    def __init__(self, folder, programs, seed):
        self.folder, self.programs, self.seed = folder, programs, seed
        folder.mkdir(parents=True, exist_ok=True)
        self.seconds = 0.0
        self.noise = 1000 * seed  # each capture has noise of its own
        self.notes = {}           # what a step said that the chain survived

    def run(self, program, *arguments):
        words = [str(self.programs / program), *(str(a) for a in arguments)]
        if "--out" in words and (self.folder / words[words.index("--out") + 1]).exists():
            return  # --resume
        begin = time.monotonic()
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=False)
        self.seconds += time.monotonic() - begin
        with (self.folder / "log.txt").open("a", encoding="utf-8") as log:
            log.write(" ".join(words) + "\n" + done.stdout + done.stderr)
        if done.returncode != 0:
            said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
            raise Refused(f"{arguments[0]}: {said[-1]}")

    def host(self, *arguments):
        self.run("selfproj", *arguments)

    def take(self, *arguments):
        """Images by the hidden rig."""
        self.noise += 1
        self.run("selfproj-sim", *arguments, "--perturbed-rig-seed", self.seed, "--seed", self.noise)

    def calibrate(self, rig, capture, calibrate=()):
        """Board and calibration; the folder `calibration`."""
        board, square = BOARDS[rig]
        size = ("--chessboard", board, "--square", square)
        self.host("pattern", "gray", "--rig", rig, "--out", "gray")
        self.take("capture", "--rig", rig, "--out", "board", "--patterns", "gray", *size, "--target-seed", self.seed,
                  *capture)
        self.host("calibrate", *size, "--projector", PROJECTORS[rig], "--rig", rig, "--out", "calibration", *calibrate,
                  *sorted((self.folder / "board").glob("pose_*")))

    def plate(self, rig, height):
        """A sweep of lines over a plate that is not quite flat and not quite at this height."""
        folder = f"plate_{height:02}"
        self.take("capture", "--rig", rig, "--out", folder, "--patterns", "lines", "--plate", height, "--target-seed",
                  100 * self.seed + height)
        return folder

    def render(self, scene, reference, out, *more):
        """Frames of a scene on the moving belt under the pattern of a reference."""
        self.take("scene", "render", scene, "--rig", "drawn.yaml", "--pattern", f"{reference}/pattern.tiff", "--out",
                  out, *more)

    def noticed(self, rig, every):
        """Whether the user's check finds fault with a rig."""
        try:
            self.host("calibrate", "heights", "--rig", rig, "--heights", CHECKED_MM, "--every", every, "--check",
                      f"plate_{CHECKED_MM}")
            return False
        except Refused as error:
            self.notes[f"check of {rig}"] = str(error)
            return True


def true_sections(truth, names):
    """Sections of a rig file from the truth, for what is given to the chain."""
    def lens(view):
        values = {"fx_px": view["column_focal_px"], "fy_px": view["row_focal_px"], "cx_px": view["column_centre_px"],
                  "cy_px": view["row_centre_px"], **view["distortion"]}
        return "".join(f"  {key}: {value!r}\n" for key, value in values.items())

    axes = {name: [truth[name][key] for key in ("along_columns", "along_rows", "axis")]
            for name in ("camera", "projector")}
    way = [a[0] for a in axes["camera"]]
    normal = [a[2] for a in axes["camera"]]
    text = "belt_pose:\n" + "".join(f"  {name}_{letter}: {value!r}\n" for name, vector in
                                    (("direction", way), ("normal", normal)) for letter, value in zip("xyz", vector))
    if "calibration" not in names:
        return text
    turn = [[sum(p * c for p, c in zip(row, column)) for column in axes["camera"]] for row in axes["projector"]]
    between = [c - p for c, p in zip(truth["camera"]["centre_mm"], truth["projector"]["centre_mm"])]
    shift = [sum(a * b for a, b in zip(row, between)) for row in axes["projector"]]
    angle = math.acos(max(-1, min(1, (turn[0][0] + turn[1][1] + turn[2][2] - 1) / 2)))
    scale = math.degrees(angle) / (2 * math.sin(angle))
    turns = [scale * (turn[2][1] - turn[1][2]), scale * (turn[0][2] - turn[2][0]), scale * (turn[1][0] - turn[0][1])]
    return (text + "camera_lens:\n" + lens(truth["camera"]) + "projector_lens:\n" + lens(truth["projector"])
            + "projector_pose:\n"
            + "".join(f"  rotation_{letter}_deg: {value!r}\n" for letter, value in zip("xyz", turns))
            + "".join(f"  translation_{letter}_mm: {value!r}\n" for letter, value in zip("xyz", shift)))


def drawn(rig, every=1):
    """The text of a drawn rig that takes only one in `every` frames."""
    text = (ROOT / f"host/rig/{rig}.yaml").read_text(encoding="utf-8")
    return re.sub(r"frame_rate_hz: (\d+)", lambda found: f"frame_rate_hz: {int(found[1]) // every}", text)


def with_wrong_tilt(text):
    """A rig whose projector is believed to be turned by WRONG_TILT_DEG more than it is."""
    key = "rotation_x_deg" if "rotation_x_deg" in text else "tilt_deg"
    return re.sub(key + r": *(\S+)", lambda found: f"{key}: {float(found[1]) + WRONG_TILT_DEG!r}", text, count=1)


def light_section(chain, effort, given):
    """The whole chain and its figures."""
    rig = "light-section"
    boards = ",".join(map(str, effort.boards))
    chain.calibrate(rig, ("--heights", boards, "--moves", MOVES, "--bend", 0.01),
                    ("--plates", boards, "--moves", MOVES))
    believed = "calibration/rig.yaml"
    if given:
        truth = json.loads((chain.folder / "board/truth.json").read_text(encoding="utf-8"))
        (chain.folder / "given.yaml").write_text(drawn(rig) + true_sections(truth, given), encoding="utf-8")
        believed = "given.yaml"
    every = effort.every_line
    chain.host("pattern", "--rig", rig, "--sweep", "--every", every, "--out", "lines")
    plates = [chain.plate(rig, height) for height in effort.heights]
    chain.host("calibrate", "heights", "--rig", believed, "--heights", ",".join(map(str, effort.heights)), "--every",
               every, "--out", "heights", *plates)
    believed = "heights/rig.yaml"
    chain.plate(rig, CHECKED_MM)
    wrong = with_wrong_tilt((chain.folder / believed).read_text(encoding="utf-8"))
    (chain.folder / "wrong.yaml").write_text(wrong, encoding="utf-8")
    noticed = {"right_rig_refused": chain.noticed(believed, every),
               "wrong_rig_noticed": chain.noticed("wrong.yaml", every)}

    chain.take("capture", "--rig", rig, "--out", "scan", "--patterns", "lines", "--scene", "stairs", "--stopped")
    chain.host("pattern", "--rig", believed, "--scan", "scan", "--every", every, "--out", "good")
    (chain.folder / "drawn.yaml").write_text(drawn(rig, effort.every_frame), encoding="utf-8")
    count = min(16, round(60 / effort.spacing_mm))
    chain.render("stairs", "good", "seen", "--first", round(70 / effort.spacing_mm - count / 2), "--count", count)
    chain.host("pattern", "--rig", believed, "--reference", "good", "--residual", "seen", "--out", "part")
    chain.render("stairs-marked", "part", "frames", "--truth", "truth.tiff")
    chain.run("selfproj-sim", "cosim", "--frames", "frames/*.png", "--engine", "model", "--rig", "drawn.yaml",
              "--packets", "part.packets")
    chain.host("inspect", "--device", "file:part.packets", "--rig", believed, "--reference", "part", "--out", "result")
    return {**figures.light_section_figures(chain.folder, effort.spacing_mm), **noticed}


def scanner(chain, effort, _given):
    """The whole chain and its figures."""
    chain.calibrate("scanner", ("--poses", effort.poses, *GLASS_BOARD), ALL_DISTORTION)
    chain.take("capture", "--rig", "scanner", "--out", "plane", "--patterns", "gray", "--scene", "plane")
    images = sorted((chain.folder / "plane").glob("image_*.png"))[:40]  # without white and black
    chain.host("depth", "--rig", "calibration/rig.yaml", "--bits", 10, "--row-bits", 10, "--strict", "--plane",
               "--out", "depth", *images)
    return figures.scanner_figures(chain.folder)


def held(kind, found, bounds):
    """What does not hold, as names of figures."""
    if "refused" in found:
        return ["refused"]
    missed = [key for key, bound in bounds.items() if not found[key] <= bound]
    if kind == "scanner" and not found["residual_mm"] <= found["rounding_mm"]:
        missed.append("residual_mm")
    if kind == "light-section":
        missed += [key for key, wrong in (("right_rig_refused", True), ("wrong_rig_noticed", False))
                   if found[key] == wrong]
    return missed


def line_of(kind, seed, found):
    if "refused" in found:
        return f"{kind} {seed:2}: {found['refused']}"
    if kind == "scanner":
        return (f"{kind} {seed:2}: plane off by {found['plane_mm']:.3f} mm at most, {found['middle_mm']:.3f} in the "
                f"middle; residual {found['residual_mm']:.3f}, rounding {found['rounding_mm']:.3f} mm")
    treads = " ".join(f"{tread:.3f}" for tread in found["treads_mm"])
    return (f"{kind} {seed:2}: treads {treads}, RMS {found['rms_mm']:.3f}, max {found['max_mm']:.3f}, marks "
            f"{found['place_mm']:.3f} (centroids {found['centroid_mm']:.3f}) mm; check "
            f"{'refuses' if found['right_rig_refused'] else 'passes'} the rig, "
            f"{'refuses' if found['wrong_rig_noticed'] else 'passes'} the wrong one")


def measured(kind, seed, folder, options, effort):
    chain = Chain(folder.resolve(), options.programs.resolve(), seed)
    try:
        found = (light_section if kind == "light-section" else scanner)(chain, effort, options.given)
    except Refused as error:
        found = {"refused": str(error)}
    return {**found, "notes": chain.notes, "seconds": round(chain.seconds, 1)}


def seeds_of(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def worst(by_seed):
    """The greatest of each figure, and the seed it comes from."""
    keys = {key for found in by_seed.values() for key, value in found.items() if isinstance(value, float)}
    return {key: dict(zip(("value", "seed"), max((found[key], seed) for seed, found in by_seed.items()
                                                 if key in found))) for key in sorted(keys)}


def mm(value):
    return f"{value:.3f}" if math.isfinite(value) else "none seen"


def row_of(kind, seed, found):
    """A row of the table: the seed, the figures, and those that do not hold."""
    if "refused" in found:
        return [seed, *["–"] * (8 if kind == "light-section" else 4), found["refused"]]
    names = {"place_mm": "marks", "max_mm": "largest", "rms_mm": "RMS", "tread_mm": "treads", "plane_mm": "plane",
             "residual_mm": "residual", "right_rig_refused": "check", "wrong_rig_noticed": "check of the wrong rig"}
    missed = ", ".join(names[key] for key in found["missed"])
    if kind == "scanner":
        return [seed, *(mm(found[key]) for key in ("plane_mm", "middle_mm", "residual_mm", "rounding_mm")), missed]
    return [seed, *map(mm, found["treads_mm"]),
            *(mm(found[key]) for key in ("rms_mm", "max_mm", "place_mm", "centroid_mm")),
            f"{found['points']:,}", missed]


def table_of(kind, by_seed):
    """The table of a kind for the documents."""
    bounds = {key: bound for each in BOUNDS.values() for key, bound in each.items()}
    head, note = {
        "light-section": (
            ["tread of 30 mm", "39 mm", "21 mm", "RMS", "largest", "marks", "centroids", "points"],
            f"Light section, mm. Bounds: treads within {bounds['tread_mm']}, heights {bounds['rms_mm']} RMS and "
            f"{bounds['max_mm']} at most away from steps, places of the marks' points within {bounds['place_mm']}. "
            "Centroids: of what is seen of each mark, from those of the drawing."),
        "scanner": (
            ["plane, largest", "plane, middle", "residual", "rounding predicts"],
            f"Scanner, mm. Bounds: the plane within {bounds['plane_mm']} everywhere, its residual no more than "
            "rounding to whole codes predicts.")}[kind]
    return {"title": f"Hidden rigs: {kind}", "header": ["seed", *head, "does not hold"],
            "rows": [row_of(kind, seed, found) for seed, found in by_seed.items()], "note": note}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, default=seeds_of("1-20"), metavar="N-M")
    parser.add_argument("--kind", choices=("light-section", "scanner", "both"), default="both")
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/bin")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--add", action="store_true")
    parser.add_argument("--given", choices=("calibration", "belt"), nargs="*", default=[])
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument("--quick", action="store_true")
    amount.add_argument("--small", action="store_true")
    options = parser.parse_args()
    effort = SMALL if options.small else QUICK if options.quick else FULL
    if options.out and options.out.exists() and not options.resume:
        parser.error(f"--out {options.out}: exists already")
    if options.small and options.kind != "light-section":
        parser.error("--small goes only with --kind light-section")
    found, failures = {}, 0
    for kind in ("light-section", "scanner") if options.kind == "both" else (options.kind,):
        bounds = BOUNDS[kind]
        before = results.recorded("hidden_rigs").get(kind, {}).get("seeds", {}) if options.add else {}
        by_seed = found.setdefault(kind, {})
        for seed in options.seeds:
            root = options.out or pathlib.Path(tempfile.mkdtemp())
            by_seed[f"{seed:02}"] = one = measured(kind, seed, root / kind / f"{seed:02}", options, effort)
            one["missed"] = held(kind, one, bounds)
            failures += bool(one["missed"])
            print(line_of(kind, seed, one), flush=True)
            if not options.out:
                shutil.rmtree(root)
        by_seed = dict(sorted({**before, **by_seed}.items()))
        good = sum(not one["missed"] for one in by_seed.values())
        print(f"{kind}: {good} of {len(by_seed)} within all bounds")
        found[kind] = {"seeds": by_seed, "within": good, "of": len(by_seed), "worst": worst(by_seed),
                       "table": table_of(kind, by_seed)}
    effort_words = " --quick" if options.quick else " --small" if options.small else ""
    if options.given:
        found = {f"given_{'_'.join(options.given)}": found}
    results.write("hidden_rigs", "Simulated rigs calibrated from images alone, compared with their true values",
                  "lab/scripts/hidden_rigs.py" + effort_words, {**results.recorded("hidden_rigs"), **found})
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
