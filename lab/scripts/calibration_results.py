#!/usr/bin/env python3
"""calibration_results.py FOLDER: writes the findings of calibration_chain.sh, beside the truth, to
lab/results/calibration_chain.json.

Nothing is written unless SELFPROJ_RESULTS names a folder. Standard library only.
"""

import json
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import results  # noqa: E402


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def lens(found, truth):
    """Returns parameters with their standard deviations and true values. A mirrored projector has a negative focal
    length."""
    names = {"fx": "column_focal_px", "fy": "row_focal_px", "cx": "column_centre_px", "cy": "row_centre_px"}
    lengths = {name: abs if name.startswith("f") else float for name in names}
    return {name: {"value": lengths[name](found[name]["value"]), "sd": found[name]["sd"],
                   "truth": lengths[name](truth[key])} for name, key in names.items()}


def calibration(report, truth):
    lenses = {name: lens(report[name], truth[name]) for name in ("camera", "projector")}
    baseline = math.hypot(*truth["projector"]["centre_mm"])
    found = report["pose"]["baseline_mm"]
    focal = [lenses[name][key] for name in lenses for key in ("fx", "fy")]
    centres = [lenses[name][key] for name in lenses for key in ("cx", "cy")]
    return {**lenses, "baseline_mm": {**found, "truth": baseline},
            "focal_off": max(abs(length["value"] / length["truth"] - 1) for length in focal),
            "centre_off_px": max(abs(centre["value"] - centre["truth"]) for centre in centres),
            "baseline_off_mm": abs(found["value"] - baseline), "rms_px": report["rms_px"]}


def plane(summary, z_mm):
    found = summary["plane"]
    return {"points": found["points"], "z_mm": found["z_on_axis_mm"], "off_mm": abs(found["z_on_axis_mm"] - z_mm),
            "tilt_deg": found["tilt_deg"], "rms_mm": found["residual_rms_mm"],
            "predicted_rms_mm": found["rounding_rms_mm"]}


def main(folder):
    found = {}
    for rig in ("scanner", "light-section"):
        truth = read(folder / rig / "captures/truth.json")
        found[rig] = {way: calibration(read(folder / rig / way / "report.json"), truth)
                      for way in ("homography", "direct")}
    found["plane"] = plane(read(folder / "scanner/depth/summary.json"), 550)
    results.write("calibration_chain",
                  "Both rigs calibrated from captures of a virtual chessboard, and a plane measured with the result",
                  "lab/scripts/calibration_chain.sh", found)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
