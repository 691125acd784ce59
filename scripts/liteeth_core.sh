#!/usr/bin/env bash
# liteeth_core.sh: makes LiteEth's core for the ECPIX-5 by liteeth_gen of PyPI, as constraints/ecpix5/liteeth.yml says,
# and prints the path of its Verilog file. What is current already is not made again. Where PyPI is not reached it
# prints one line and exits with status 77.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

package=liteeth==2024.12
home=build/ecpix5
settings=constraints/ecpix5/liteeth.yml
core=$home/selfproj_liteeth.v
mark="$package $(sha256sum <"$settings" | cut -c1-16) $(sha256sum <scripts/liteeth_core.sh | cut -c1-16)"

mkdir -p "$home"
exec {lock}>"$home/liteeth.lock" # two tests may need the core at once
flock "$lock"
if [[ ! -e $core || $(cat "$core.made" 2>/dev/null) != "$mark" ]]; then
  programs=$(python3 -B scripts/pypi.py "$home/venv" "$package")
  "$programs/liteeth_gen" "$settings" --name selfproj_liteeth --output-dir "$home/liteeth" &>"$home/liteeth.log" ||
    { echo "liteeth_core.sh: liteeth_gen has failed ($home/liteeth.log)" >&2; exit 1; }
  # The generator declares the one pin of two directions as an input.
  sed 's/\binput  wire          rgmii_mdio\b/inout  wire          rgmii_mdio/' \
    "$home/liteeth/gateware/selfproj_liteeth.v" >"$core.new"
  grep -q '\binout  wire          rgmii_mdio\b' "$core.new" ||
    { echo "liteeth_core.sh: the core has no port rgmii_mdio as expected" >&2; exit 1; }
  mv "$core.new" "$core"
  echo "$mark" >"$core.made"
fi
echo "$core"
