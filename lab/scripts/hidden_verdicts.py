#!/usr/bin/env python3
"""Measures the verdict by moments over rigs that nobody knows: what it finds of what the host finds, and false alarms.

    hidden_verdicts.py [--seeds N-M] [--parts N] [--good-parts N] [--jobs N] [--programs DIR] [--add]

For each seed S runs `selfproj-lab experiment parts --verdict --perturbed-rig-seed S --parts-seed 100+S`: a rig that
deviates from its drawings and is calibrated from images, tolerance and limits from good parts, and parts shifted by up
to 2 mm. Bounds, over all seeds together: of the defects 2 mm wide and 0.3 mm deep or larger that the host finds on the
inspected surface, moments find at least 99.9 %; no good part has a defect.

With SELFPROJ_RESULTS set, hidden_verdicts.json is written there; with --add it keeps the seeds that an earlier run has
measured. The exit status is 1 where a bound is not held. Standard library only.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import hidden_rigs
import results  # hidden_rigs has set its path

LEAST_SHARE = 0.999


def measured(seed, options):
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [options.programs / "selfproj-lab", "experiment", "parts", "--verdict", "--perturbed-rig-seed", str(seed),
             "--parts-seed", str(100 + seed), "--parts", str(options.parts), "--good-parts", str(options.good_parts)],
            env={**os.environ, results.VARIABLE: folder}, capture_output=True, text=True, check=False)
        file = pathlib.Path(folder) / "verdict_detection.json"
        if not file.exists():
            return {"refused": done.stderr.strip().splitlines()[-1:]}
        found = json.loads(file.read_text(encoding="utf-8"))["results"]
    moments = found["moments"]
    tallies = [found[kind] for kind in ("planted_parts", "good_parts")]
    return {"of_host": moments["of_host"]["planted"], "found": moments["of_host"]["found"],
            "good_parts": moments["good_parts"], "false_parts": moments["false_parts"],
            "judged_columns": moments["judged_columns"], "missed": moments["missed"],
            "host_false_parts": sum(tally["parts_with_a_false_defect"] for tally in tallies),
            "host_inconclusive": sum(tally["inconclusive"] for tally in tallies)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=hidden_rigs.seeds_of, default=hidden_rigs.seeds_of("1-20"), metavar="N-M")
    parser.add_argument("--parts", type=int, default=60, help="with planted defects")
    parser.add_argument("--good-parts", type=int, default=500)
    parser.add_argument("--jobs", type=int, default=1, help="seeds at a time")
    parser.add_argument("--programs", type=pathlib.Path, default=hidden_rigs.ROOT / "build/bin")
    parser.add_argument("--add", action="store_true")
    options = parser.parse_args()
    rigs = results.recorded("hidden_verdicts").get("rigs", {}) if options.add else {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for seed, one in zip(options.seeds, pool.map(lambda seed: measured(seed, options), options.seeds)):
            rigs[str(seed)] = one
            print(f"seed {seed}: {one}", flush=True)
    rigs = dict(sorted(rigs.items(), key=lambda item: int(item[0])))
    judged = [one for one in rigs.values() if "refused" not in one]
    total = {key: sum(one[key] for one in judged) for key in ("of_host", "found", "good_parts", "false_parts")}
    share = total["found"] / max(1, total["of_host"])
    print(f"{len(judged)} of {len(rigs)} rigs: {total['found']} of {total['of_host']} defects, {share:.2%}; "
          f"{total['false_parts']} of {total['good_parts']} good parts with a defect")
    results.write("hidden_verdicts", "Verdicts by moments on rigs calibrated from images alone: found of what the host "
                  "finds, and false alarms", f"lab/scripts/hidden_verdicts.py --parts {options.parts} --good-parts "
                  f"{options.good_parts}",
                  {"rigs": rigs, "of": len(rigs), "refused": len(rigs) - len(judged), **total,
                   "share": round(share, 5)})
    return 0 if len(judged) == len(rigs) and share >= LEAST_SHARE and total["false_parts"] == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
