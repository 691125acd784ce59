#!/usr/bin/env bash
# tidy.sh [--all | SOURCE...]: runs clang-tidy by run-clang-tidy over the C++ sources named; without any, over those that
# differ from the branch that this one follows, or from the commit before if there is no difference. With --all these are
# the sources of capi, constraints, host, model and sim. The compile options are those of the build for the quick tests, with --all
# those of the release build, which must be there. As there, the sources of a library are then checked as one file, so
# that headers are read once. The exit status is 1 if there is a finding.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

all=false
case ${1:-} in
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
  --all) all=true; shift ;;
  -*) echo "tidy.sh: $1: unknown; usage: scripts/tidy.sh [--all | SOURCE...]" >&2; exit 2 ;;
esac

build=build/quick
if $all; then build=build/release; fi
folder=build/tidy
[[ -f $build/compile_commands.json ]] ||
  { echo "tidy.sh: $build is missing; run scripts/build.sh ${build#*/} all" >&2; exit 2; }
tidy=
for version in 14 19 ""; do
  tidy=${version:+-$version}
  command -v "run-clang-tidy$tidy" >/dev/null && break
done
command -v "run-clang-tidy$tidy" >/dev/null ||
  { echo "tidy.sh: there is no run-clang-tidy; scripts/setup.sh installs it" >&2; exit 2; }

sources=("$@")
if ((${#sources[@]} == 0)) && ! $all; then
  mapfile -t sources < <(scripts/lib/files.sh --changed '*.cpp')
  if ((${#sources[@]} == 0)); then
    echo "tidy.sh: no source has changed"
    exit 0
  fi
fi

# The compile commands of the build for each source and for each joined file, without what only g++ knows. Clang's
# analyzer looks into the functions of included sources only if the file's name begins with UnifiedSource. Prints the
# files to check as expressions.
mkdir -p "$folder"
rm -f "$folder"/UnifiedSource*
mapfile -t files < <(python3 - "$build" "$folder" "${sources[@]}" <<'PYTHON'
import json, pathlib, re, sys
root = pathlib.Path.cwd()
build, folder = (root / name for name in sys.argv[1:3])
wanted = {str(root / name) for name in sys.argv[3:]}
product = re.compile("(capi|constraints|host|model|sim)/")
entries, all_of_product = [], []
for entry in json.loads((build / "compile_commands.json").read_text()):
    command = re.sub(r" -(Winvalid-pch|fpch-preprocess|-param=ggc-\S+|include \S+cmake_pch\.hxx)", "", entry["command"])
    file, base = pathlib.Path(entry["file"]), root
    names = [str(file)]
    if file.name.startswith("unity_"):
        base = build
        joined = folder / f"UnifiedSource_{len(entries)}.cpp"
        joined.write_text(re.sub('(#include ".*")', r"\1  // NOLINT(bugprone-suspicious-include)", file.read_text()))
        names = [str(joined), *re.findall('#include "(.*)"', file.read_text())]
    entries += [{**entry, "command": command.replace(str(file), name), "file": name} for name in names]
    if file.is_relative_to(base) and product.match(str(file.relative_to(base))):
        all_of_product.append(names[0])
(folder / "compile_commands.json").write_text(json.dumps(entries))
for file in sorted(wanted & {entry["file"] for entry in entries}) if wanted else all_of_product:
    print(f"^{re.escape(file)}$")
PYTHON
)
if ((${#files[@]} == 0)); then
  echo "tidy.sh: the quick build compiles none of the changed sources"
  exit 0
fi
# The analyzer does not look into templates, nearly all of which are from libraries; to analyze them takes six times as
# long. A third of the default limit for the states of a function halves its time, and it still finds the same.
"run-clang-tidy$tidy" -clang-tidy-binary "clang-tidy$tidy" -p "$folder" -quiet -j "$(nproc)" \
  -header-filter="^$PWD/((constraints|hls|host|include/selfproj|model|sim|tests)/|capi/.*[.]cpp$)" \
  -extra-arg=-Wno-unknown-warning-option -extra-arg=-Xclang -extra-arg=-analyzer-config -extra-arg=-Xclang \
  -extra-arg=c++-template-inlining=false,max-nodes=75000 "${files[@]}" >"$folder/output" 2>&1 || {
  grep -vE '^\[|^$|warnings? generated|^clang-tidy' "$folder/output" >&2
  exit 1
}
echo "tidy.sh: ${#files[@]} files are clean"
