#!/usr/bin/env bash
# Installs what building and testing need and this machine lacks, from the packages of Debian 12.
# Where everything is there it says so in one line and asks for no rights.
set -euo pipefail

packages=(
  g++ cmake ninja-build git python3          # build, generator
  verilator yosys iverilog                   # simulation, synthesis, lint
  z3                                         # proofs
  libsystemc-dev                             # co-simulation
  libopencv-core-dev libopencv-imgcodecs-dev libopencv-imgproc-dev  # image files, colour conversion
  libopencv-calib3d-dev                      # calibration
  libcli11-dev libfmt-dev libyaml-cpp-dev    # command line, text, rigs
  nlohmann-json3-dev                         # summaries
  libgtest-dev libbenchmark-dev              # tests, benchmarks
  clang-format-14 clang-tidy-14              # checks of the sources
  clang-14 libclang-rt-14-dev                # fuzzing
)

fail() {
  printf 'setup.sh: %s\n' "$1" >&2
  exit 2
}

if ! { command -v dpkg-query && command -v apt-get; } >/dev/null; then
  fail "this machine has no apt (Debian 12 is expected); install by hand: ${packages[*]}"
fi

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
