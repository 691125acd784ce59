#!/usr/bin/env python3
"""Measures the verdict by moments over rigs that nobody knows: what it finds of what the host finds, and false alarms.

    hidden_verdicts.py [--seeds N-M] [--parts N] [--good-parts N] [--line-parts N] [--line-only] [--jobs N]
                       [--programs DIR] [--add]

For each seed S runs `selfproj-lab experiment parts --verdict --perturbed-rig-seed S --parts-seed 100+S`: a rig that
deviates from its drawings and is calibrated from images, tolerance and limits from good parts, and parts shifted by up
to 2 mm. Bounds, over all seeds together: of the defects 2 mm wide and 0.3 mm deep or larger that the host finds, wholly
on the inspected surface or partly in the strips around it, moments find at least 99.9 %; no good part has a defect.

Then --line-parts good parts and as many with a defect pass through the RTL, by the documented commands, from the images
of the hidden rig and the files that a user has: `inspect` places the parts, `verdict table` makes limits for parts that
lie there, `cosim --engine rtl --verdict` judges the images, and `inspect --verdict` compares. The circuit says of every
frame what the model says, and no good part has a defect; counted is, too, how many of the parts that are bad by heights
are bad by the circuit, of those whose defect lies wholly in a region of the tolerance, and of the others.

With SELFPROJ_RESULTS set, hidden_verdicts.json is written there after each rig; with --add it keeps the seeds that an
earlier run has measured. The exit status is 1 where a bound is not held. Standard library only.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

import hidden_rigs
import results  # hidden_rigs has set its path

LEAST_SHARE = 0.999
FRAME_MM, ENCODER_MM = 0.25, 0.01  # of the experiment's belt
SIZE_MM = 2                        # of the planted defects
CORNERS = re.compile(r"corners_mm: \[(.*?)\]", re.S)
KEYS = ("of_host", "found", "of_host_at_edges", "found_at_edges", "good_parts", "false_parts", "rtl_good_parts", "rtl_false_parts", "rtl_host_false_parts",
        "rtl_of_host", "rtl_found", "rtl_of_host_at_edges", "rtl_found_at_edges")


def placed(folder):
    """Where the host has found each part."""
    lines = (folder / "parts.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def is_inside(defect, regions):
    """Whether a defect 2 mm wide lies wholly in a region, whose corners are those of a rectangle."""
    def within(place, corners):
        return min(corners) + SIZE_MM / 2 <= place <= max(corners) - SIZE_MM / 2
    return any(within(defect["along_mm"], corners[0::2]) and within(defect["across_mm"], corners[1::2])
               for corners in regions)


def through_rtl(seed, parts, options, folder):
    """Files of a line, and what the circuit says of its parts."""
    chain = hidden_rigs.Chain(folder, options.programs.resolve(), seed)
    line = ("--rig", "rig.yaml", "--reference", "part", "--tolerance", "tolerance.yaml")
    chain.run("selfproj-sim", "cosim", "--frames", "good/*.png", "--engine", "model", "--rig", "rig.yaml", "--packets",
              "good.packets")
    chain.host("inspect", *line, "--device", "file:good.packets", "--parts", "good_placed")
    found = placed(folder / "good_placed")
    frames = len(list((folder / "good").glob("*.png"))) // parts
    first = [part["begin_mm"] + part["placement"]["along_mm"] - i * frames * FRAME_MM for i, part in enumerate(found)]
    chain.host("verdict", "table", *line, "--defect", "2x2", "--mm-per-frame", FRAME_MM, "--out", "verdict.yaml",
               "--shift", f"{statistics.mean(part['placement']['across_mm'] for part in found):.2f}",
               "--start", round(statistics.mean(first) / ENCODER_MM), "--pitch", round(frames * FRAME_MM / ENCODER_MM))
    judged = {}
    for kind in ("good", "bad"):
        chain.run("selfproj-sim", "cosim", "--frames", f"{kind}/*.png", "--engine", "rtl", "--rig", "rig.yaml",
                  "--verdict", "verdict.yaml", "--packets", f"{kind}_judged.packets")
        chain.host("inspect", *line, "--device", f"file:{kind}_judged.packets", "--verdict", "verdict.yaml", "--parts",
                   f"{kind}_parts", "--out", f"{kind}_result")
        counters = json.loads((folder / f"{kind}_result/summary.json").read_text(encoding="utf-8"))["counters"]
        if counters["board_frames"] != parts * frames or counters["board_disagrees"]:
            raise hidden_rigs.Refused(f"{kind}: the circuit judged {counters['board_frames']} frames, "
                                      f"{counters['board_disagree']} otherwise than the model")
        judged[kind] = placed(folder / f"{kind}_parts")
        if [part["moments"]["frames"] > 0 for part in judged[kind]] != [True] * parts:
            raise hidden_rigs.Refused(f"{kind}: not every part was judged")
    text = (folder / "tolerance.yaml").read_text(encoding="utf-8")
    regions = [[float(number) for number in corners.split(",")] for corners in CORNERS.findall(text)]
    bad = [part for part in judged["bad"] if part["verdict"] == "bad"]
    inside = [part for part in bad if any(is_inside(defect, regions) for defect in part["defects"])]
    return {"rtl_good_parts": parts, "rtl_false_parts": sum(part["moments"]["defect"] for part in judged["good"]),
            "rtl_host_false_parts": sum(part["verdict"] != "good" for part in judged["good"]),
            "rtl_of_host": len(inside), "rtl_found": sum(part["moments"]["defect"] for part in inside),
            "rtl_of_host_at_edges": len(bad) - len(inside),
            "rtl_found_at_edges": sum(part["moments"]["defect"] for part in bad if part not in inside)}


def measured(seed, options):
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        done = subprocess.run(
            [options.programs / "selfproj-lab", "experiment", "parts", "--verdict", "--perturbed-rig-seed", str(seed),
             "--parts-seed", str(100 + seed), "--parts", str(options.parts), "--good-parts", str(options.good_parts),
             "--line-parts", str(options.line_parts), "--out", folder / "line"],
            env={**os.environ, results.VARIABLE: scratch}, capture_output=True, text=True, check=False)
        file = folder / "verdict_detection.json"
        if not file.exists():
            return {"refused": done.stderr.strip().splitlines()[-1:]}
        found = json.loads(file.read_text(encoding="utf-8"))["results"]
        try:
            by_rtl = through_rtl(seed, options.line_parts, options, folder / "line") if options.line_parts else {}
        except hidden_rigs.Refused as error:
            return {"refused": str(error)}
    if options.line_only:
        return by_rtl
    moments = found["moments"]
    tallies = [found[kind] for kind in ("planted_parts", "good_parts")]
    return {"of_host": moments["of_host"]["planted"], "found": moments["of_host"]["found"],
            "of_host_at_edges": moments["of_host_at_edges"]["planted"],
            "found_at_edges": moments["of_host_at_edges"]["found"],
            "good_parts": moments["good_parts"], "false_parts": moments["false_parts"],
            **by_rtl, "judged_columns": moments["judged_columns"], "missed": moments["missed"],
            "host_false_parts": sum(tally["parts_with_a_false_defect"] for tally in tallies),
            "host_inconclusive": sum(tally["inconclusive"] for tally in tallies)}


def record(rigs, options):
    """Written after each rig, so that a run that is ended early keeps what it has."""
    judged = [one for one in rigs.values() if "refused" not in one]
    total = {key: sum(one.get(key, 0) for one in judged) for key in KEYS}
    total |= {"of": len(rigs), "refused": len(rigs) - len(judged),
              "share": round((total["found"] + total["found_at_edges"]) /
                             max(1, total["of_host"] + total["of_host_at_edges"]), 5)}
    results.write("hidden_verdicts", "Verdicts by moments on rigs calibrated from images alone: found of what the host "
                  "finds, and false alarms", f"lab/scripts/hidden_verdicts.py --parts {options.parts} --good-parts "
                  f"{options.good_parts} --line-parts {options.line_parts}{' --line-only' * options.line_only}",
                  {"rigs": dict(sorted(rigs.items(), key=lambda item: int(item[0]))), **total})
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=hidden_rigs.seeds_of, default=hidden_rigs.seeds_of("1-20"), metavar="N-M")
    parser.add_argument("--parts", type=int, default=60, help="with planted defects")
    parser.add_argument("--good-parts", type=int, default=500)
    parser.add_argument("--line-parts", type=int, default=5, help="through the RTL, of each kind; 0: none")
    parser.add_argument("--line-only", action="store_true", help="measure nothing else; with --add the rest is kept")
    parser.add_argument("--jobs", type=int, default=1, help="seeds at a time")
    parser.add_argument("--programs", type=pathlib.Path, default=hidden_rigs.ROOT / "build/bin")
    parser.add_argument("--add", action="store_true")
    options = parser.parse_args()
    if options.line_only:
        options.parts = options.good_parts = 1
    rigs = results.recorded("hidden_verdicts").get("rigs", {}) if options.add else {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for seed, one in zip(options.seeds, pool.map(lambda seed: measured(seed, options), options.seeds)):
            rigs[str(seed)] = rigs.get(str(seed), {}) | one if options.line_only else one
            print(f"seed {seed}: {one}", flush=True)
            total = record(rigs, options)
    print(f"{total['of'] - total['refused']} of {total['of']} rigs: {total['found']} of {total['of_host']} defects, "
          f"{total['found_at_edges']} of {total['of_host_at_edges']} at edges, {total['share']:.2%}; "
          f"{total['false_parts']} of {total['good_parts']} good parts with a defect; by the RTL "
          f"{total['rtl_found']} of {total['rtl_of_host']}, {total['rtl_found_at_edges']} of "
          f"{total['rtl_of_host_at_edges']} at edges, and {total['rtl_false_parts']} of {total['rtl_good_parts']}")
    false = total["false_parts"] + total["rtl_false_parts"]
    found = total["share"] >= LEAST_SHARE or options.line_only
    return 0 if total["refused"] == 0 and found and false == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
