#!/usr/bin/env bash
# network_to_host.sh [--seconds S] [--rate FPS] [--jumbo] [--keep]: runs two processes in a network of their own, which
# has only the loopback. One is a board that sends 512 x 96 pixels in mode grey-over in datagrams (by default 10,000
# frames a second for 60 s); the other is the on-line inspection of udp:. The script fails unless every frame became a
# profile, with nothing lost. It prints the share of one processor that the inspection took. --keep records the figures
# in the folder results. On a busy machine the inspection may wait for a processor for longer than the socket's buffer
# holds datagrams, 0.7 s.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

seconds=60
rate=10000
more=()
keep=false
while (($# > 0)); do
  case $1 in
    --seconds) seconds=${2:?"network_to_host.sh: --seconds needs a number"}; shift 2 ;;
    --rate) rate=${2:?"network_to_host.sh: --rate needs a number"}; shift 2 ;;
    --jumbo) more=(--jumbo); shift ;;
    --keep) keep=true; shift ;;
    *)
      echo "network_to_host.sh: $1: unknown;" \
        "usage: tests/bench/network_to_host.sh [--seconds S] [--rate FPS] [--jumbo] [--keep]" >&2
      exit 2
      ;;
  esac
done
for program in selfproj selfproj-sim; do
  [[ -x build/bin/$program ]] ||
    { echo "network_to_host.sh: build/bin/$program is missing; run scripts/build.sh" >&2; exit 2; }
done
folder=$(mktemp -d build/network-to-host-XXXXXX)
trap 'rm -rf "$folder"' EXIT

export seconds rate folder
# shellcheck disable=SC2016 # the inner shell expands it
unshare --map-root-user --net bash -euo pipefail -c '
  ip link set lo up
  frames=$((rate * seconds))
  (
    TIMEFORMAT="%R %U %S"
    { time build/bin/selfproj inspect --device udp:127.0.0.2 --control none --count "$frames" \
      --seconds "$((2 * seconds + 10))" --check --json "$folder/counts.json" \
      >"$folder/host.txt" 2>"$folder/error.txt"; } 2>"$folder/time.txt"
  ) &
  host=$!
  until grep -q ":04D3 " /proc/net/udp || ! kill -0 "$host"; do sleep 0.05; done # port 1235 is open
  build/bin/selfproj-sim board --line 512x96 --udp 127.0.0.1 --from 127.0.0.2 --rate "$rate" --seconds "$seconds" \
    "$@" | sed "s/^/    board: /"
  status=0
  wait "$host" || status=$?
  cat "$folder/host.txt" "$folder/error.txt"
  exit "$status"
' network_to_host "${more[@]}"

python3 - "$folder" "$seconds" <<'PYTHON' >"$folder/figures.txt"
import json, pathlib, sys
folder, seconds = pathlib.Path(sys.argv[1]), float(sys.argv[2])
_, user, system = map(float, (folder / "time.txt").read_text().split())
print(f"cpu_share={(user + system) / seconds:.3f}")
print(f"seconds={seconds:g}")
for key, value in json.loads((folder / "counts.json").read_text()).items():
    print(f"{key}={value}")
PYTHON
grep -E '^(cpu_share|profiles|lost_network|datagrams_overflow)=' "$folder/figures.txt" | sed 's/^/    /'
if $keep; then
  mapfile -t figures < <(sed "s|^|$rate/|" "$folder/figures.txt")
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record "network_to_host${more[0]:+_jumbo}" \
    --about "Two processes, a board that sends so many frames a second in datagrams over the loopback to the host" \
    --command "tests/bench/network_to_host.sh${more[0]:+ --jumbo} --keep" "${figures[@]}"
fi
