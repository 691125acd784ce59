#!/usr/bin/env bash
# demo.sh [--record]: builds the simulation and shows the main job. A conveyor moves at 1000 mm/s under the simulated
# camera, the board's RTL works on the images, and marks carved 1 mm deep show in the difference from the reference
# part. The script installs missing packages first, writes to build/demo/, prints the paths of the pictures, builds the
# host program, and ends with a live run of good and bad parts that a browser can watch. SELFPROJ_DEMO_SECONDS is the length of the live run
# in seconds (default 20; with 0 there is none, and the host program is not built). SELFPROJ_DEMO_PORT is its port
# (default 8080).
#
# The script builds small variants of the two programs in build/bin/demo/. They have only the commands that are shown
# here. scripts/build.sh builds the whole programs. --record writes to results/ how long a run from scratch took.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

record=false
case ${1:-} in
  "") ;;
  --record)
    record=true
    [[ ${SELFPROJ_DEMO_SECONDS:-20} != 0 ]] ||
      { echo "demo.sh: --record: goes only with a live run; SELFPROJ_DEMO_SECONDS is 0" >&2; exit 2; }
    [[ ! -e build ]] || { echo "demo.sh: --record: goes only with a run from scratch; build/ is there" >&2; exit 2; }
    export CCACHE_RECACHE=1  # without what ccache keeps from earlier builds
    ;;
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/demo.sh; exit 0 ;;
  *) echo "demo.sh: $1: unknown; usage: scripts/demo.sh [--record]" >&2; exit 2 ;;
esac

# The CPU time of all that this script has run so far
cpu_seconds() { awk -v hz="$(getconf CLK_TCK)" '{sub(/.*\) /, ""); printf "%.1f", ($14 + $15) / hz}' "/proc/$$/stat"; }

scripts/build.sh release selfproj-sim_demo
programs=build/bin/demo
out=build/demo
rm -rf "$out"
mkdir -p "$out"

cat <<'TEXT'

Stairs of 30, 39 and 21 mm, with a circle, a cross and a triangle carved 1 mm deep, pass under the camera at 1000 mm/s:
1400 frames at 10,000 a second. The projected line is bent so that the camera sees it straight on a good part. The board
(RTL, Verilated, with real line timing) computes the moments; the driver takes its packets; every packet is compared
with the model.
TEXT
"$programs"/selfproj-sim cosim --scene stairs-marked --out "$out/stairs-marked" --packets "$out/stairs-marked.packets"

captures=../shared/data/laser-chrisspen/images
if [[ -d $captures ]]; then
  printf '\nReal captures of a laser line go through the same board; the image without the laser is subtracted. The first of
them is left out, whose two images have different exposures:\n'
  "$programs"/selfproj-sim cosim --frames "$captures"/sample[2-9]/sample*-b-0.jpg \
    --background "$captures"/sample[2-9]/sample*-a-0.jpg --channel red --threshold 30 --out "$out/captures"
fi

cat <<TEXT

Look at
  $out/stairs-marked/difference.png   the marks: the difference from the good part, in mm
  $out/stairs-marked/report.html      everything: heights, profiles, counters
  $out/stairs-marked/frame_700.png    one camera image with the line that was found, and its moments
  $out/stairs-marked/cloud.ply        the points, for any viewer of point clouds
TEXT
if [[ -d $captures ]]; then
  echo "  $out/captures/report.html            real images with the line that was found"
fi

times=("pictures/seconds=$SECONDS" "pictures/cpu_seconds=$(cpu_seconds)")

seconds=${SELFPROJ_DEMO_SECONDS:-20}
port=${SELFPROJ_DEMO_PORT:-8080}
[[ $seconds != 0 ]] || exit 0

printf '\nBuilding the host program for the live run:\n'
cmake --build --preset release --parallel "$(nproc)" --target selfproj_demo
times+=("programs/seconds=$SECONDS" "programs/cpu_seconds=$(cpu_seconds)")
if $record; then
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record demo_time --command "scripts/demo.sh --record" \
    --about "The demo from scratch, with all packages installed: up to the pictures, and to the live run" "${times[@]}"
fi

# A line with good and bad parts, and the tolerance of its good ones.
"$programs"/selfproj-sim production --bad-every 4 --parts 12 --out "$out/line"
"$programs"/selfproj tolerance learn --rig "$out/line/rig.yaml" --reference "$out/line/part" \
  --device "file:$out/line/good.packets" --out "$out/tolerance.yaml" >/dev/null

cat <<TEXT

The host program now classifies the parts of a running line. Another process sends it packets, as a board would: a part
every 1.3 s, of which every fourth has a dent or a bump. Open this page in a browser of this machine within the next
$seconds seconds:

  http://127.0.0.1:$port/

It shows the profile, each part with its verdict, good or bad, and the last part in 3-D with its defect. Of each bad part
there is a folder in $out/parts/.

For a longer run: SELFPROJ_DEMO_SECONDS=600 scripts/demo.sh
TEXT
ring=selfproj-demo-$$
"$programs"/selfproj-sim board --replay "$out/line/run.packets" --ring "$ring" --rate 100 --loop >/dev/null &
board=$!
trap 'kill "$board" 2>/dev/null || true' EXIT
"$programs"/selfproj inspect --device "ring:$ring" --wait-for-board --newest --rig "$out/line/rig.yaml" \
  --reference "$out/line/part" --tolerance "$out/tolerance.yaml" --parts "$out/parts" --seconds "$seconds" \
  --live "$port" ||
  echo "the live run failed; to use another port: SELFPROJ_DEMO_PORT=8081 scripts/demo.sh"
