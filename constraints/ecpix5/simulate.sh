#!/usr/bin/env bash
# simulate.sh [--frames N] [--replay DIR | --codes | --rows N | --few-rows] [--drop P] [--double P] [--reorder P]
# [--damage P] [--images] [--jumbo] [--keep] [-- COMMAND...]: simulates the FPGA of the ECPIX-5, LiteEth included, from
# the test camera to the pins of RGMII. In a network namespace of its own a TAP interface takes the place of the cable.
# The kernel's own stack and the programs in build/bin reach the board at 192.168.1.50. By default the board sends N
# frames (40), and each recorded packet must equal that of the models. The network can drop, double and reorder P
# percent of the datagrams: the packets recorded and those counted as lost must together be those that were sent. With
# --replay the images of a folder, 512 x 96 pixels each, take the place of the test camera: selfproj board replay sends
# them to the board. The faults hit its datagrams, too, but every image must arrive. With --codes the board is built
# with the Gray-code decoder, and the test camera shows its patterns, one every millisecond; code images must be those
# of the models, too. With --rows the test camera has N rows, 5 to 127, and makes no pause between frames: only its
# pixel clock limits their rate. --few-rows does the same with 20 rows, the register region, compact columns, and the
# clocks of bitstream.py --few-rows; it prints how many packets a second the cable carries, and fails below 50,000.
# --damage hits the frames to the board. --images has raw images sent as well. --jumbo builds the board for datagrams of
# up to 8,972 bytes, and gives the network frames of 9,000 bytes. --keep records the figures in the folder results. With
# a COMMAND, that command runs instead, as long as it likes; rates.py is one. SELFPROJ_PROGRAMS names the folder of the
# programs, and SELFPROJ_BUILD the build with the models, if they are not build/bin and build/release. Where PyPI is not
# reached, or a TAP interface is not allowed, the script says so and exits with status 77.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
here=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

frames=40
replay=
codes=false
faults=()
images=false
mtu=1500
rows=
few=false
keep=false
command=()
while (($# > 0)); do
  case $1 in
    --frames) frames=${2:?"simulate.sh: --frames needs a number"}; shift 2 ;;
    --replay) replay=$(cd "$here" && realpath -e -- "${2:?"simulate.sh: --replay needs a folder"}"); shift 2 ;;
    --codes) codes=true; shift ;;
    --drop | --double | --reorder | --damage) faults+=("$1" "${2:?"simulate.sh: $1 needs a percentage"}"); shift 2 ;;
    --images) images=true; shift ;;
    --jumbo) mtu=9000; shift ;;
    --few-rows) few=true; shift ;;
    --rows) rows=${2:?"simulate.sh: --rows needs a number"}; shift 2 ;;
    --keep) keep=true; shift ;;
    --) command=("${@:2}"); break ;;
    *) echo "simulate.sh: $1: unknown; --help lists the options" >&2; exit 2 ;;
  esac
done

[[ -z $rows || $rows =~ ^[1-9][0-9]{0,2}$ && $rows -ge 5 && $rows -le 127 ]] ||
  { echo "simulate.sh: --rows: '$rows' is not a number from 5 to 127" >&2; exit 2; }
((${#replay} > 0)) && given="--replay " || given=
$codes && given+="--codes "
[[ -z $rows ]] || given+="--rows "
$few && given+="--few-rows "
[[ $given != *" "*" " ]] || { echo "simulate.sh: ${given}exclude each other" >&2; exit 2; }
programs=${SELFPROJ_PROGRAMS:-$PWD/build/bin}
built=${SELFPROJ_BUILD:-$PWD/build/release}
compare=$built/constraints/compare_packets
for program in "$programs/selfproj" "$compare"; do
  [[ -x $program ]] || { echo "simulate.sh: $program is missing; run scripts/build.sh release all" >&2; exit 2; }
done
unshare --map-root-user --net ip tuntap add dev tap0 mode tap 2>/dev/null ||
  { echo "simulate.sh: this system allows no TAP interface in a network namespace" >&2; exit 77; }

# --- The simulation, with a link that tells of silence after 2 ms instead of 50. What LiteEth's generator writes is
# not linted. ---
core=$(python3 -B constraints/ecpix5/liteeth_core.py)
folder=build/ecpix5/sim
build=()
((mtu == 1500)) || { folder+=-jumbo && build+=("-GDatagramBytes=$((mtu - 28))"); } # without headers of IP and UDP
frame_clocks=12500
[[ -z $rows ]] || { # a beat is four pixels
  frame_clocks=$((128 * rows))
  folder+=-rows-$rows && build+=("-GCameraRows=$rows" "-GFrameClocks=$frame_clocks")
}
clocks=
$few && { rows=20 && frame_clocks=2560
  folder+=-few-rows && build+=("-GCameraRows=$rows" "-GFrameClocks=$frame_clocks" "-GRegion=1'b1" "-GCompact=1'b1")
  clocks=--fast
}
$codes && folder+=-codes && build+=("-GGrey=1'b0" "-GImage=1'b0" "-GCodes=1'b1") # as bitstream.py does
search=()
for room in rtl/*/; do search+=(-y "${room%/}"); done
# It links Ethernet frames, the TAP interface, and Verilator's runtime.
constraints/common/verilated_sim.sh "$built" "$folder" Vecpix5_system constraints/ecpix5/ecpix5_sim.cpp \
  constraints/libselfproj_board_links.a sim/board/libselfproj_verilator_runtime.a -- -O3 \
  -Wall -Wno-fatal -Wno-COMBDLY -Wno-TIMESCALEMOD -Wno-UNOPTFLAT --x-assign fast --x-initial fast --assert \
  --top-module ecpix5_system -GIdleClocks=100000 "${build[@]}" "${search[@]}" \
  constraints/ecpix5/liteeth.vlt rtl/common/sp_spec_pkg.sv constraints/ecpix5/ecpix5_system.sv \
  constraints/common/ecp5_cells.sv "$core"

work=$(mktemp -d "$PWD/build/ecpix5-sim-XXXXXX")
trap 'rm -rf "$work"' EXIT
export here folder work programs compare frames images replay codes mtu rows few clocks
status=0
# The host's programs do not interrupt the simulation when a datagram wakes them up. A host takes 20 ms of silence for
# the end of a packet. Where the simulation had to wait for a processor in the middle of one, it counts that (held_up).
# shellcheck disable=SC2016 # the inner shell expands it
unshare --map-root-user --net chrt --batch 0 bash -euo pipefail -c '
  ip link set lo up
  faults=()
  while [[ ${1:-} == --* && $1 != -- ]]; do faults+=("$1" "$2"); shift 2; done
  shift
  touch "$work/sim.txt"
  chrt --other 0 "$folder/sim" tap0 $clocks --counts "$work/sim.json" --paused "$work/record.pid" "${faults[@]}" \
    >"$work/sim.txt" & sim=$!
  trap "kill -TERM $sim 2>/dev/null || true" EXIT
  until grep -q ready "$work/sim.txt" || ! kill -0 "$sim" 2>/dev/null; do sleep 0.05; done
  ip addr add 192.168.1.1/24 dev tap0
  ip link set tap0 mtu "$mtu" up
  PATH=$programs:$PATH
  board=(--device udp:192.168.1.50)
  end() { kill -TERM "$sim"; wait "$sim"; trap - EXIT; }
  if (($# > 0)); then
    status=0
    (cd "$here" && "$@") || status=$?
    end
    exit "$status"
  fi

  selfproj board info "${board[@]}"
  $images && image=1 || image=0
  ((mtu == 1500)) && jumbo= || jumbo=--jumbo
  settings=(measure.mode=grey-over "control.image=$image" ${rows:+"size.rows=$rows"})
  $few && settings+=(compact.on=1 region.row=39 region.column=1)
  $codes && settings=(decode.bits=8 decode.codes=1)
  selfproj board set "${board[@]}" measure.threshold=100 "${settings[@]}" >/dev/null
  [[ -z $replay ]] || selfproj board source replay "${board[@]}"
  $codes && selfproj board source patterns "${board[@]}"
  selfproj record "${board[@]}" --out "$work/packets" >"$work/record.txt" 2>&1 & record=$!
  echo "$record" >"$work/record.pid"
  until grep -q ":04D3 " /proc/net/udp || ! kill -0 "$record"; do sleep 0.05; done # port 1235 is open
  selfproj board start "${board[@]}"
  # On a busy machine an answer may come later than a host waits for it.
  count() {
    local tries=10 said
    until said=$(selfproj board status "${board[@]}"); do
      ((--tries > 0)) || exit 1
    done
    sed -n "s/^0x.. $1 .* count=//p" <<<"$said"
  }
  $codes && selfproj board trigger --period 125000 --patterns 16 "${board[@]}"
  [[ -z $replay ]] || selfproj board replay "${board[@]}" $jumbo "$replay" | tee "$work/replay.txt"
  [[ -z $replay ]] || frames=1 # all of them have left
  sent=0
  while ((sent < frames)); do
    sleep 0.2
    sent=$(count frames)
  done
  selfproj board stop "${board[@]}"
  sleep 1 # much more than the link takes to tell that nothing follows
  for name in frames lost_moments lost_image lost_codes; do echo "$name=$(count "$name")"; done >"$work/board.txt"
  rm "$work/record.pid"
  kill -INT "$record"
  wait "$record"
  end
' ecpix5 "${faults[@]}" -- "${command[@]}" || status=$?
((${#command[@]} == 0 && status == 0)) || exit "$status"

form=("512x${rows:-96}" "$frame_clocks")
if $codes; then form[1]=codes=8; fi
if [[ -n $replay ]]; then form=(replay "$replay"); fi
"$compare" "$work/packets" "${form[@]}" >"$work/compared.json" || status=$?
python3 -B - "$work" "$images" "$codes" "${rows:-96}" "$few" <<'PYTHON' || status=$?
import json, pathlib, re, sys
folder, (images, codes, few) = pathlib.Path(sys.argv[1]), (sys.argv[at] == "true" for at in (2, 3, 5))
rows = int(sys.argv[4])
said = (folder / "record.txt").read_text()
print("record: " + said.strip())
number = lambda what: int(re.search(rf"{what} ([\d,]+)", said)[1].replace(",", ""))
board = {name: int(value or 0) for name, value in
         (line.split("=") for line in (folder / "board.txt").read_text().split())}
lost_board = board["lost_moments"] + board["lost_image"] + board["lost_codes"]
code_images = max(0, board["frames"] - 14) // 2 if codes else 0  # after 8 pairs, and after each further pair
sim, compared = (json.loads((folder / f"{name}.json").read_text()) for name in ("sim", "compared"))
sent = board["frames"] * (1 + rows * images) + 96 * code_images - lost_board
figures = {"frames": board["frames"], "packets_sent": sent, "recorded": compared["packets"],
           "equal": compared["equal"], "lost_board": lost_board,
           "lost_network": number("lost in the network"), "bad": number("bad packets"), **sim}
if sim["packet_clocks"]:
    figures["packets_per_s"] = round((sim["packets_on_cable"] - 1) / sim["packet_clocks"] * 125e6)
images_replayed = "images" in compared
if images_replayed:
    replayed = (folder / "replay.txt").read_text()
    figures |= {"images": compared["images"], "left": int(re.search(r": ([\d,]+) frames left", replayed)[1]),
                "repeated": int(re.search(r"([\d,]+) of them again", replayed)[1])}
(folder / "figures.txt").write_text("".join(f"{key}={value}\n" for key, value in figures.items()))
print("".join(f"    {key} {value}\n" for key, value in figures.items()), end="")
good = (figures["recorded"] == figures["equal"] and figures["recorded"] + figures["lost_network"] == sent
        and figures["bad"] == 0 and sim["from_board_damaged"] == 0 and sim["refused_by_kernel"] == 0
        and figures["lost_network"] <= sim["dropped"] + sim["held_up"]
        and (not few or lost_board == 0 and figures["packets_per_s"] >= 50_000)
        and (not images_replayed or figures["images"] == figures["left"] == figures["frames"]))
print("every packet equals the models', and delivered + lost = sent" if good else "the counts do not fit")
sys.exit(0 if good else 1)
PYTHON
((status == 0)) || exit "$status"
if $keep; then
  mapfile -t figures <"$work/figures.txt"
  [[ -n $replay ]] && source="--replay ${replay##*/}" || source="--frames $frames"
  name=target_sim${replay:+_replay}
  ((mtu == 1500)) || { source+=" --jumbo" && name+=_jumbo; }
  if $few; then
    source+=" --few-rows" name+=_few_rows
  elif [[ -n $rows ]]; then
    source+=" --rows $rows" name+=_rows
  fi
  $codes && source+=" --codes" && name+=_codes
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record "$name${faults[0]:+_faults}" \
    --about "The FPGA of an ECPIX-5 in simulation, test camera to RGMII, and the host behind the kernel's stack" \
    --command "constraints/ecpix5/simulate.sh $source${faults[*]:+ ${faults[*]}} --keep" "${figures[@]}"
fi
