#!/usr/bin/env bash
# calibration_chain.sh [--out DIR]: the whole chain of calibration in simulation, both rigs at full size: patterns,
# captures of a virtual chessboard, calibration in both ways, depth of a known plane. It prints the results beside the
# truth. With --out it keeps its files in DIR, a new folder.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }

root=$(cd "$(dirname "$0")/../.." && pwd)
host=$root/build/bin/selfproj
sim=$root/build/bin/selfproj-sim
for program in "$host" "$sim"; do
  if [[ ! -x $program ]]; then
    echo "calibration_chain.sh: $program is not there; run scripts/build.sh" >&2
    exit 2
  fi
done

if (($# == 0)); then
  out=$(mktemp -d)
  trap 'rm -rf "$out"' EXIT
elif (($# == 2)) && [[ $1 == --out ]] && mkdir "$2"; then
  out=$2
else
  echo "usage: calibration_chain.sh [--out DIR]" >&2
  exit 2
fi

# chain RIG BOARD SQUARE PROJECTOR POSES TILT OPTION...
chain() {
  local rig=$1 board=$2 square=$3 projector=$4 poses=$5 tilt=$6
  shift 6
  local folder=$out/$rig
  mkdir "$folder"
  "$host" pattern gray --rig "$rig" --out "$folder/patterns"
  "$sim" capture --rig "$rig" --patterns "$folder/patterns" --chessboard "$board" --square "$square" \
    --poses "$poses" --tilt "$tilt" --out "$folder/captures"
  for way in homography direct; do
    echo "rig $rig, $way:"
    "$host" calibrate --chessboard "$board" --square "$square" --projector "$projector" --rig "$rig" \
      --corners "$way" "$@" --out "$folder/$way" "$folder"/captures/pose_*
  done
  echo "truth of rig $rig:"
  python3 - "$folder/captures/truth.json" <<'END'
import json, math, sys
truth = json.load(open(sys.argv[1]))
for name in ("camera", "projector"):
    t = truth[name]
    print(f"{name:10} fx {t['column_focal_px']:.2f}, fy {t['row_focal_px']:.2f}, "
          f"cx {t['column_centre_px']:.2f}, cy {t['row_centre_px']:.2f} px")
print(f"{'':10} baseline {math.hypot(*truth['projector']['centre_mm']):.3f} mm")
END
}

chain scanner 9x7 21 1024x768 8 30
# A chessboard in this narrow field shows hardly any perspective: 8 poses would leave two fits that are alike.
chain light-section 7x3 2.6 512x512 16 40 --camera-distortion 0 --projector-distortion 0 --window 24

echo "the plane of rig scanner at 550 mm:"
folder=$out/scanner
"$sim" capture --rig scanner --patterns "$folder/patterns" --scene plane --out "$folder/plane"
images=("$folder"/plane/image_*.png)
"$host" depth --calibration "$folder/homography/calibration.yaml" --bits 10 --row-bits 10 --strict \
  --max-z-per-line 5 --plane --out "$folder/depth" "${images[@]:0:40}"
python3 "$root/lab/scripts/calibration_results.py" "$out"
