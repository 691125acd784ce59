#!/usr/bin/env bash
# Builds the programs and shows the main job: a conveyor at 1000 mm/s under the simulated camera, the board's RTL in
# between, and carved marks, 1 mm deep, in the difference from the reference part. What it writes is in build/demo/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh
out=build/demo
rm -rf "$out"
mkdir -p "$out"

cat <<'TEXT'

Stairs of 30, 39 and 21 mm, with a circle, a cross and a triangle carved 1 mm deep, pass under the camera at 1000 mm/s:
1400 frames at 10,000 a second. The projected line is bent so that the good part shows it straight. The board (RTL,
Verilated, with real line timing) sums the moments; the driver takes its packets; every one is compared with the model.
TEXT
build/bin/selfproj-sim cosim --scene stairs-marked --out "$out/stairs-marked" --packets "$out/stairs-marked.packets"

captures=../shared/data/laser-chrisspen/images
if [[ -d $captures ]]; then
  printf '\nReal captures of a laser line (laser-chrisspen), red channel less that without the laser, through the same board:\n'
  build/bin/selfproj-sim cosim --frames "$captures/sample*/sample*-b-0.jpg" --background "$captures/sample*/sample*-a-0.jpg" \
    --channel red --threshold 30 --out "$out/captures"
else
  printf '\nSkipped: the real captures are not there (%s)\n' "$captures"
fi

cat <<TEXT

Look at
  $out/stairs-marked/difference.png   the marks, in mm against the good part
  $out/stairs-marked/report.html      all of it: heights, profiles, counters
  $out/stairs-marked/frame_700.png    one camera image with the line that was found, and its moments
  $out/stairs-marked/cloud.ply        the points, for any viewer of point clouds
TEXT
if [[ -d $captures ]]; then
  echo "  $out/captures/report.html            real images with the line that was found"
fi
