#!/usr/bin/env bash
# setup.sh [programs|tests]: installs missing packages of Debian 12 or 13. With `programs` these are the packages that the
# programs and the demo need, with `tests` (default) also those of the tests. If nothing is missing, it says so in one
# line and does not ask for root rights.
set -euo pipefail

for_programs=(
  g++ cmake ninja-build                      # build
  verilator zlib1g-dev                       # simulation of the circuits, compressed waveforms
  libsystemc-dev                             # co-simulation
  libopencv-core-dev libopencv-imgcodecs-dev libopencv-imgproc-dev  # image files, colour conversion
  libopencv-calib3d-dev libceres-dev libeigen3-dev  # calibration
  libnanoflann-dev                           # distances between point clouds
  libcli11-dev libfmt-dev libyaml-cpp-dev    # command line, text, rigs
  nlohmann-json3-dev                         # summaries
  libmodbus-dev                              # results for controllers
  libreaderwriterqueue-dev                   # the queue of the production
  libmicrohttpd-dev libjs-three              # the live page
  pkg-config libaravis-dev libusb-1.0-0-dev  # GigE and USB3 cameras
  libsdl2-dev                                # projectors
)
for_tests=(
  git python3 python3-pip                    # lists of sources, checks
  python3-dev python3-venv                   # the Python package, and what comes from PyPI
  python3-markdown-it                        # links and commands of the documents
  yosys iverilog z3                          # synthesis, lint, proofs
  ghdl-mcode                                 # benches in VHDL
  nextpnr-ice40                              # placement (scripts/fpga.py)
  libgtest-dev libbenchmark-dev              # tests, benchmarks
  libopencv-contrib-dev                      # OpenCV's Gray decoder, for comparisons
  shellcheck ccache                          # checks of the scripts, builds after a change
  xvfb                                       # a display for the tests of projectors
  # a server with two displays, for the same tests
  xserver-xorg-core xserver-xorg-video-dummy x11-xserver-utils x11-apps
  librsvg2-bin                               # the printed chessboard as an image
  chromium-driver                            # the live page in a browser
  pkg-config dpkg-dev                        # tests of the installation and of the Debian packages
  iproute2 util-linux                        # namespaces, in which tests have networks of their own
  tshark                                     # the dissector for Wireshark
  debootstrap                                # the other release of Debian
)
# Checks of the sources, fuzzing. Version 14 decides on the format; Debian 13 does not have it (scripts/test.sh).
for_tests_on_12=(clang-format-14 clang-tidy-14 clang-14 libclang-rt-14-dev)
for_tests_on_13=(clang-tidy-19 clang-19 libclang-rt-19-dev)

fail() {
  printf 'setup.sh: %s\n' "$1" >&2
  exit 2
}

(($# <= 1)) || fail "usage: scripts/setup.sh [programs|tests]"
case ${1:-tests} in
  programs) packages=("${for_programs[@]}") ;;
  tests) packages=("${for_programs[@]}" "${for_tests[@]}") ;;
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) fail "$1: unknown; usage: scripts/setup.sh [programs|tests]" ;;
esac

release=$(sed -n 's/^\(ID\|VERSION_ID\)=//p' /etc/os-release 2>/dev/null | tr -d '"' | LC_ALL=C sort -r | xargs) || true
if ! { command -v dpkg-query && command -v apt-get; } >/dev/null; then
  fail "this is ${release:-no Debian}, known are Debian 12 and 13; install by hand: ${packages[*]}"
fi
case $release in
  "debian 12") by_release=("${for_tests_on_12[@]}") ;;
  "debian 13") by_release=("${for_tests_on_13[@]}") ;;
  *)
    echo "setup.sh: this is ${release:-no Debian}, known are Debian 12 and 13: the packages of 13 are tried"
    by_release=("${for_tests_on_13[@]}")
    ;;
esac
if [[ ${1:-tests} == tests ]]; then packages+=("${by_release[@]}"); fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done

if ((${#missing[@]} == 0)); then
  echo "setup.sh: all ${#packages[@]} packages are there"
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || fail "run as root, or install sudo; missing: ${missing[*]}"
  as_root=(sudo)
fi

echo "setup.sh: installing ${missing[*]}"
"${as_root[@]}" apt-get -qq update || fail "apt-get update failed; missing: ${missing[*]}"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get -qq install --yes --no-install-recommends "${missing[@]}" ||
  fail "apt-get install failed; missing: ${missing[*]}"
