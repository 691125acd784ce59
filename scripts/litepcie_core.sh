#!/usr/bin/env bash
# litepcie_core.sh: makes LitePCIe's core for the Acorn by litepcie_gen of PyPI, as constraints/acorn/litepcie.yml says,
# and prints the path of its Verilog file. Beside it lie pcie_s7.v, the ports of the FPGA's block for PCI Express;
# pcie_s7.tcl, which makes that block with the vendor's tool; and driver/, LitePCIe's kernel driver for this core. What
# is current already is not made again. Where PyPI is not reached the script prints one line and exits with status 77.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=(litepcie==2024.12 litex==2024.12)
home=build/acorn
settings=constraints/acorn/litepcie.yml
core=$home/litepcie_core.v
makers=(scripts/litepcie_core.sh scripts/litepcie_core.py host/driver/litepcie_interface.h)
mark="${packages[*]} $(cat "$settings" "${makers[@]}" | sha256sum | cut -c1-16)"

if [[ ! -e $core || $(cat "$core.made" 2>/dev/null) != "$mark" ]]; then
  mkdir -p "$home"
  programs=$(python3 -B scripts/pypi.py "$home/venv" "${packages[@]}")
  made=$home/litepcie
  rm -rf "$made" "$core.made"
  mkdir "$made"
  cp "$settings" "$made"
  (cd "$made" && "../venv/bin/litepcie_gen" litepcie.yml) &>"$home/litepcie.log" ||
    { echo "litepcie_core.sh: litepcie_gen has failed ($home/litepcie.log)" >&2; exit 1; }
  python3 -B scripts/litepcie_core.py "$made" "$programs/.." "$home"
  echo "$mark" >"$core.made"
fi
echo "$core"
