#!/usr/bin/env bash
# Builds the programs and shows what they do so far: column moments by the board's RTL and by the model, compared.
# What it writes is in build/demo/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh
out=build/demo
rm -rf "$out"
mkdir -p "$out"

# laser_line FRAME: a 512 x 96 image (PGM) of a laser line over a bump that wanders with the frame, with noise
laser_line() {
  awk -v frame="$1" 'BEGIN {
    srand(frame)
    columns = 512; rows = 96
    for (x = 1; x <= columns; ++x) {
      d = (x - 120 - 40 * frame) / 60
      centre[x] = 70.3 - 45 * exp(-d * d)
    }
    printf "P2\n%d %d\n255\n", columns, rows
    for (y = 1; y <= rows; ++y) {
      for (x = 1; x <= columns; ++x) {
        d = (y - centre[x]) / 1.6
        value = 12 + 230 * exp(-d * d / 2) + 8 * rand()
        printf "%d%s", (value > 255 ? 255 : value), (x < columns ? " " : "\n")
      }
    }
  }'
}

# compare NAME OPTION... -- IMAGE...: the moments by both engines
compare() {
  local name=$1
  shift
  local engine
  for engine in rtl model; do
    build/bin/selfproj-sim moments --engine "$engine" --out "$out/$name-$engine.csv" "$@"
  done
  if ! cmp -s "$out/$name-rtl.csv" "$out/$name-model.csv"; then
    echo "demo.sh: $name: RTL and model differ:" >&2
    diff "$out/$name-rtl.csv" "$out/$name-model.csv" | head -n 10 >&2
    exit 1
  fi
  compared_columns=$((compared_columns + $(wc -l <"$out/$name-model.csv") - 1))
  compared_runs=$((compared_runs + 1))
}

compared_columns=0
compared_runs=0
frames=()
for frame in 0 1 2 3 4 5 6 7; do
  laser_line "$frame" >"$out/line_$frame.pgm"
  frames+=("$out/line_$frame.pgm")
done
printf '\nA synthetic laser line, 96 rows of 512 columns\n'
for mode in binary grey grey-over; do
  compare "line-$mode" --mode "$mode" --threshold 100 "${frames[@]}"
done

captures=../shared/data/laser-chrisspen/images
if [[ -d $captures ]]; then
  printf '\nReal captures of a laser line (laser-chrisspen), red channel\n'
  for mode in binary grey grey-over; do
    compare "capture-$mode" --channel red --mode "$mode" --threshold 100 "$captures"/sample*/sample*-b-0.jpg
  done
else
  printf '\nSkipped: the real captures are not there (%s)\n' "$captures"
fi

printf '\nmatched %d columns in %d runs, 0 mismatches: RTL and model are equal; tables in %s/\n' \
  "$compared_columns" "$compared_runs" "$out"
