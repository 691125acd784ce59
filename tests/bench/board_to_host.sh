#!/usr/bin/env bash
# board_to_host.sh [--seconds S] [--rate FPS] [--few-rows] [--rising] [--realtime]: runs two processes. One is a board
# that plays 512 x 96 pixels in mode grey-over in real time into a ring (by default 10,000 frames a second for 60 s);
# the other is the on-line inspection. --few-rows: 512 x 20 pixels of a region, by default 50,000 frames a second. The
# script fails unless every frame became a profile, with nothing lost, bad or missing. --rising then doubles the rate, 5
# s each, as long as that holds. At the end the board plays as fast as it can, which shows how many profiles a second
# the host makes. --realtime gives both processes real-time priority, for which the user needs permission, and lets the
# host sleep while it waits. Without it, on a busy machine the processes may wait for a processor for longer than the
# ring holds packets, 1.6 s.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

seconds=60
rate=
few=false
rising=false
realtime=()
wait=poll-then-block
while (($# > 0)); do
  case $1 in
    --seconds) seconds=${2:?"board_to_host.sh: --seconds needs a number"}; shift 2 ;;
    --rate) rate=${2:?"board_to_host.sh: --rate needs a number"}; shift 2 ;;
    --few-rows) few=true; shift ;;
    --rising) rising=true; shift ;;
    --realtime) realtime=(chrt -f 10) wait=block; shift ;;
    *)
      echo "board_to_host.sh: $1: unknown;" \
        "usage: tests/bench/board_to_host.sh [--seconds S] [--rate FPS] [--few-rows] [--rising] [--realtime]" >&2
      exit 2
      ;;
  esac
done
for program in selfproj selfproj-sim; do
  [[ -x build/bin/$program ]] ||
    { echo "board_to_host.sh: build/bin/$program is missing; run scripts/build.sh" >&2; exit 2; }
done

size=512x96
rig=light-section
if $few; then
  size=512x20
  rig=build/board-to-host-$$.yaml
  build/bin/selfproj rows --rows 20 --rate 50000 --out "$rig" >/dev/null
  rate=${rate:-50000}
fi
rate=${rate:-10000}
ring=board-to-host-$$
results=()  # KEY=VALUE, for scripts/results.py
trap 'build/bin/selfproj devices --remove "$ring" 2>/dev/null || true; rm -f "build/$ring.yaml"' EXIT

# run RATE SECONDS INSPECT_OPTION...
run() {
  local rate=$1 seconds=$2 status=0
  shift 2
  "${realtime[@]}" build/bin/selfproj-sim board --line "$size" --rate "$rate" --seconds "$seconds" \
    --ring "$ring" --wait-for-reader \
    --keep >"build/$ring.txt" &
  local board=$!
  # The ring exists until both processes have ended, so that the reader gets every packet from the first to the last.
  until build/bin/selfproj devices | grep -q "ring:$ring  *process"; do sleep 0.05; done
  "${realtime[@]}" build/bin/selfproj inspect --rig "$rig" --device "ring:$ring" --wait "$wait" \
    --json "build/$ring.json" "$@" || status=$?
  wait "$board"
  sed 's/^/    board: /' "build/$ring.txt"
  while read -r key value; do results+=("$rate/$key=$value"); done < <(python3 -c '
import json, sys
for key, value in json.load(open(sys.argv[1])).items():
    print(key, value)' "build/$ring.json")
  results+=("$rate/seconds=$seconds")
  rm -f "build/$ring.txt" "build/$ring.json"
  build/bin/selfproj devices --remove "$ring"
  return "$status"
}

echo "$rate frames/s for $seconds s:"
run "$rate" "$seconds" --check
if $rising; then
  while rate=$((2 * rate)); echo "$rate frames/s for 5 s:"; run "$rate" 5 --check; do :; done
  echo "as fast as the board can, for 5 s:"
  run 0 5
fi
command=tests/bench/board_to_host.sh
! $few || command+=" --few-rows"
! $rising || command+=" --rising"
((${#realtime[@]} == 0)) || command+=" --realtime"
python3 scripts/results.py record "board_to_host$($few && echo _few_rows)${realtime[0]:+_realtime}" \
  --about "Two processes, the board at so many frames a second (0: as fast as it can) into the host's ring" \
  --command "$command" "${results[@]}"
