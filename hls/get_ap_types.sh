#!/usr/bin/env bash
# get_ap_types.sh: takes the open vendor headers (ap_int.h, hls_stream.h; Apache licence) out of PyPI's wheel of hls4ml
# and puts them into build/ap_types/, where the build looks for them. Those of an installed HLS tool work as well:
# cmake -D SELFPROJ_AP_TYPES=FOLDER.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

to=build/ap_types
wheel=hls4ml==1.3.0  # another version may hold others

if [[ -f $to/ap_int.h ]]; then
  echo "get_ap_types.sh: $to is there"
  exit 0
fi
command -v pip3 >/dev/null || { echo "get_ap_types.sh: pip3 is missing" >&2; exit 2; }
mkdir -p build
folder=$(mktemp -d build/ap_types.XXXXXX)
trap 'rm -rf "$folder"' EXIT
pip3 --quiet --disable-pip-version-check download --no-deps --only-binary :all: --dest "$folder" "$wheel" ||
  { echo "get_ap_types.sh: $wheel cannot be had" >&2; exit 1; }
python3 - "$folder" <<'PYTHON'
import pathlib, sys, zipfile
folder = pathlib.Path(sys.argv[1])
inside = "hls4ml/templates/vivado/ap_types/"
with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
    for name in wheel.namelist():
        if name.startswith(inside) and not name.endswith("/"):
            file = folder / "ap_types" / name[len(inside):]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(wheel.read(name))
PYTHON
[[ -f $folder/ap_types/ap_int.h && -f $folder/ap_types/hls_stream.h ]] ||
  { echo "get_ap_types.sh: the wheel does not hold what was expected" >&2; exit 1; }
mv "$folder/ap_types" "$to"
echo "get_ap_types.sh: $(find "$to" -name '*.h' | wc -l) headers → $to"
