#!/usr/bin/env python3
"""rows_curve.py [check] [--programs DIR]: what fewer rows cost and bring: for several numbers of rows the frames a
second that the board takes, the heights that the region measures, and the error of A2, by the documented commands on
the built-in rig (docs/few-rows.md): good part scanned with the whole sensor, `selfproj rows`, residual with the short
exposure, marked part through `selfproj-sim cosim`, `selfproj inspect`, compared with the truth. With SELFPROJ_RESULTS
set, rows_curve.json is written and the picture drawn. With `check`, exit status 1 where the picture is not that of the
results. Standard library only."""

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import few_rows
import float_tiff
import results  # few_rows has set its path

ROOT = results.ROOT
PICTURE = ROOT / "lab/images/rows-curve.svg"
ROWS = (12, 16, 20, 24, 32, 48, 64, 96)
EVERY = 4  # lines of the sweep
FRAMES = 60
# A line of the table that `selfproj rows` prints
LINE = re.compile(r"^ *(\d+) +\d+ +(-[\d.]+) \.\. \+([\d.]+) +(\d+) +(\d+) +([\d.]+) µs +(\d+) +([\d.]+) mm$", re.M)
LEFT, TOP, WIDTH, HEIGHT, APART = 55, 25, 220, 190, 75
DARK, LIGHT = "#31688e", "#35b779"


def said_by_rows(text):
    """{rows: figures} of `selfproj rows`."""
    return {int(rows): {"range_mm": min(-float(low), float(high)), "rate_hz": int(board), "ethernet_hz": int(ethernet),
                        "exposure_us": float(exposure), "threshold": int(threshold), "noise_mm": float(noise)}
            for rows, low, high, board, ethernet, exposure, threshold, noise in LINE.findall(text)}


def measured(programs):
    with tempfile.TemporaryDirectory(prefix="selfproj_rows_") as folder:
        def run(*words):
            return subprocess.run([str(programs / words[0]), *map(str, words[1:])], cwd=folder, check=True,
                                  capture_output=True, text=True).stdout

        run("selfproj", "pattern", "--sweep", "--every", EVERY, "--out", "lines")
        run("selfproj-sim", "capture", "--rig", "light-section", "--patterns", "lines", "--scene", "stairs",
            "--stopped", "--out", "scan")
        run("selfproj", "pattern", "--scan", "scan", "--every", EVERY, "--out", "part")
        found = said_by_rows(run("selfproj", "rows", "--reference", "part"))
        for rows in ROWS:
            if rows not in found:
                found |= said_by_rows(run("selfproj", "rows", "--reference", "part", "--rows", rows))
            rate = found[rows]["rate_hz"] - 1  # it is rounded
            middle = round(few_rows.MIDDLE_MM * rate / 1000)
            run("selfproj", "rows", "--reference", "part", "--rows", rows, "--rate", rate, "--out", "few.yaml")
            run("selfproj-sim", "scene", "render", "stairs", "--pattern", "part/pattern.tiff", "--region-of",
                "few.yaml", "--first", middle, "--count", 32, "--out", f"seen{rows}")
            run("selfproj", "pattern", "--rig", "few.yaml", "--reference", "part", "--residual", f"seen{rows}", "--out",
                f"few{rows}")
            run("selfproj-sim", "scene", "render", "stairs-marked", "--pattern", f"few{rows}/pattern.tiff",
                "--region-of", "few.yaml", "--first", middle - FRAMES // 2, "--count", FRAMES, "--truth", "truth.tiff",
                "--out", f"frames{rows}")
            run("selfproj-sim", "cosim", "--frames", f"frames{rows}/*.png", "--engine", "model", "--rig", "few.yaml",
                "--packets", "packets")
            run("selfproj", "inspect", "--rig", "few.yaml", "--reference", f"few{rows}", "--device", "file:packets",
                "--out", f"result{rows}")
            at = pathlib.Path(folder)
            one = few_rows.compared(float_tiff.read(at / f"result{rows}/height.tiff"),
                                    float_tiff.read(at / "truth.tiff"))
            found[rows] |= {"rms_mm": one["rms_mm"], "columns": one["columns"]}
            print(f"{rows} rows, {rate} frames/s: ± {found[rows]['range_mm']:.2f} mm, noise "
                  f"{found[rows]['noise_mm']} mm, A2 {one['rms_mm']:.4f} mm RMS over {100 * one['columns']:.1f} % of "
                  "the columns", flush=True)
        return {str(rows): found[rows] for rows in ROWS}


def panel(number, title, curves, most, ticks, form):
    """A diagram over the rows, in whose curves (colour, name, values) no value is above `most`."""
    left = LEFT + number * (WIDTH + APART)

    def x(rows):
        return left + WIDTH * rows / 100

    def y(value):
        return TOP + HEIGHT * (1 - value / most)

    svg = [f'<text x="{left}" y="{TOP - 9}" font-weight="bold">{title}</text>']
    svg += [f'<path d="M{left} {y(tick):.1f}h{WIDTH}" stroke="#ddd"/><text x="{left - 5}" y="{y(tick) + 4:.1f}" '
            f'text-anchor="end">{tick:{form}}</text>' for tick in ticks]
    svg += [f'<path d="M{x(rows):.1f} {TOP}v{HEIGHT}" stroke="#ddd"/><text x="{x(rows):.1f}" y="{TOP + HEIGHT + 16}" '
            f'text-anchor="middle">{rows}</text>' for rows in (20, 40, 60, 80, 100)]
    svg.append(f'<text x="{left + WIDTH / 2}" y="{TOP + HEIGHT + 34}" text-anchor="middle">rows</text>')
    for k, (colour, name, values) in enumerate(curves):
        path = "".join(f"{'L' if i else 'M'}{x(rows):.1f} {y(value):.1f}" for i, (rows, value) in enumerate(values))
        svg.append(f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        svg += [f'<circle cx="{x(rows):.1f}" cy="{y(value):.1f}" r="2.5" fill="{colour}"/>' for rows, value in values]
        svg.append(f'<text x="{left + WIDTH - 4}" y="{TOP + 14 + 16 * k}" text-anchor="end" fill="{colour}">{name}'
                   '</text>')
    return svg


def drawn(found):
    def curve(key):
        return [(int(rows), figures[key]) for rows, figures in found.items()]

    across = 3 * WIDTH + 2 * APART + LEFT + 20
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across} {TOP + HEIGHT + 44}" '
           'font-family="sans-serif" font-size="12">', '<rect width="100%" height="100%" fill="white"/>']
    svg += panel(0, "frames a second that the board takes", [(DARK, "", curve("rate_hz"))], 105000,
                 (0, 25000, 50000, 75000, 100000), ",")
    svg += panel(1, "heights over and under the part, mm", [(DARK, "", curve("range_mm"))], 16, (0, 5, 10, 15), "g")
    svg += panel(2, "error of a height, mm", [(LIGHT, "noise, predicted", curve("noise_mm")),
                                              (DARK, "A2, RMS", curve("rms_mm"))], 0.06,
                 (0, 0.02, 0.04, 0.06), "g")
    return "\n".join(svg + ["</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="?", choices=["check"])
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/bin")
    options = parser.parse_args()
    if options.what:
        kept = json.loads((ROOT / "lab/results/rows_curve.json").read_text(encoding="utf-8"))["results"]["rows"]
        if PICTURE.read_text(encoding="utf-8") != drawn(kept):
            sys.exit(f"{PICTURE.relative_to(ROOT)} is not that of lab/results/rows_curve.json; run "
                     "lab/scripts/rows_curve.py")
        return
    found = measured(options.programs.resolve())
    if os.environ.get(results.VARIABLE):
        results.write("rows_curve", "What fewer rows cost and bring: rate, range and error by the number of rows",
                      "lab/scripts/rows_curve.py", {"rows": found})
        PICTURE.write_text(drawn(found), encoding="utf-8")


if __name__ == "__main__":
    main()
