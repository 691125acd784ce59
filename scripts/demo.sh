#!/usr/bin/env bash
# demo.sh: builds the simulation and shows the main job. A conveyor moves at 1000 mm/s under the simulated camera, the
# board's RTL works on the images, and marks carved 1 mm deep show in the difference from the reference part. It
# installs missing packages first, writes to build/demo/, and ends with the paths of the pictures.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case ${1:-} in
  "") ;;
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/demo.sh; exit 0 ;;
  *) echo "demo.sh: $1: unknown; usage: scripts/demo.sh" >&2; exit 2 ;;
esac

scripts/build.sh release selfproj-sim
out=build/demo
rm -rf "$out"
mkdir -p "$out"

cat <<'TEXT'

Stairs of 30, 39 and 21 mm, with a circle, a cross and a triangle carved 1 mm deep, pass under the camera at 1000 mm/s:
1400 frames at 10,000 a second. The projected line is bent so that a good part shows it straight. The board (RTL,
Verilated, with real line timing) sums the moments; the driver takes its packets; every packet is compared with the
model.
TEXT
build/bin/selfproj-sim cosim --scene stairs-marked --out "$out/stairs-marked" --packets "$out/stairs-marked.packets"

captures=../shared/data/laser-chrisspen/images
if [[ -d $captures ]]; then
  printf '\nReal captures of a laser line, red channel minus that without the laser, through the same board:\n'
  build/bin/selfproj-sim cosim --frames "$captures/sample*/sample*-b-0.jpg" \
    --background "$captures/sample*/sample*-a-0.jpg" --channel red --threshold 30 --out "$out/captures"
fi

cat <<TEXT

Look at
  $out/stairs-marked/difference.png   the marks, in mm against the good part
  $out/stairs-marked/report.html      everything: heights, profiles, counters
  $out/stairs-marked/frame_700.png    one camera image with the line that was found, and its moments
  $out/stairs-marked/cloud.ply        the points, for any viewer of point clouds
TEXT
if [[ -d $captures ]]; then
  echo "  $out/captures/report.html            real images with the line that was found"
fi
