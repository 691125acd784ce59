#!/usr/bin/env python3
"""detection_plot.py [check]: draws the share of the planted defects that were found, over their size, a curve for each
depth, from what `selfproj-lab experiment parts` has recorded. With `check`, exit status 1 where the picture is not that
of the results. Standard library only."""

import json
import math
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PICTURE = ROOT / "lab/images/parts-detection.svg"
LEFT, TOP, WIDTH, HEIGHT = 50, 15, 420, 230
COLOURS = ["#440154", "#443983", "#31688e", "#21918c", "#35b779", "#90d743", "#d0b000"]


def curves(cells):
    """For each range of depths the points (middle of the sizes, share, number planted)."""
    found = {}
    for cell in cells:
        if cell["planted"]:
            size = math.sqrt(cell["size_mm"][0] * cell["size_mm"][1])
            found.setdefault(tuple(cell["depth_mm"]), []).append((size, cell["share"]))
    return sorted(found.items())


def drawn(results):
    def x(size):
        return LEFT + WIDTH * math.log(size / 0.5) / math.log(20)

    def y(share):
        return TOP + HEIGHT * (1 - share)

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 620 {TOP + HEIGHT + 45}" font-family="sans-serif" '
           'font-size="12">', '<rect width="100%" height="100%" fill="white"/>']
    for share in (0, 0.25, 0.5, 0.75, 1):
        svg.append(f'<path d="M{LEFT} {y(share):.1f}h{WIDTH}" stroke="#ddd"/>'
                   f'<text x="{LEFT - 6}" y="{y(share) + 4:.1f}" text-anchor="end">{share * 100:.0f} %</text>')
    for size in (0.5, 1, 2, 5, 10):
        svg.append(f'<path d="M{x(size):.1f} {TOP}v{HEIGHT}" stroke="#ddd"/>'
                   f'<text x="{x(size):.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{size:g}</text>')
    svg.append(f'<text x="{LEFT + WIDTH / 2}" y="{TOP + HEIGHT + 36}" text-anchor="middle">size, mm</text>')
    for i, ((low, high), points) in enumerate(curves(results["curves"])):
        path = "".join(f"{'L' if k else 'M'}{x(size):.1f} {y(share):.1f}" for k, (size, share) in enumerate(points))
        colour = COLOURS[i % len(COLOURS)]
        svg.append(f'<path d="{path}"\n  fill="none" stroke="{colour}" stroke-width="2"/>')
        svg += [f'<circle cx="{x(size):.1f}" cy="{y(share):.1f}" r="2.5" fill="{colour}"/>' for size, share in points]
        svg.append(f'<text x="{LEFT + WIDTH + 12}" y="{TOP + 12 + 18 * i}" fill="{colour}">{low:g}–{high:g} mm deep'
                   '</text>')
    return "\n".join(svg + ["</svg>"]) + "\n"


def main():
    text = drawn(json.loads((ROOT / "lab/results/parts_detection.json").read_text(encoding="utf-8"))["results"])
    if sys.argv[1:] == ["check"]:
        if PICTURE.read_text(encoding="utf-8") != text:
            sys.exit(f"{PICTURE.relative_to(ROOT)} is not that of lab/results/parts_detection.json; run "
                     "lab/scripts/detection_plot.py")
    elif sys.argv[1:]:
        sys.exit("detection_plot.py: usage: lab/scripts/detection_plot.py [check]")
    else:
        PICTURE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
