#!/usr/bin/env bash
# build.sh [PRESET [TARGET]]: installs what is missing, configures and builds all, or TARGET. PRESET: release (default),
# dev, sanitizers.
# The programs of preset release, built for speed, are then in build/bin/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if (($# > 2)) || [[ ${1:-} == -* || ${2:-} == -* ]]; then
  echo "usage: scripts/build.sh [release|dev|sanitizers [TARGET]]" >&2
  exit 2
fi
preset=${1:-release}

scripts/setup.sh
cmake --preset "$preset" --log-level=NOTICE
cmake --build --preset "$preset" --target "${2:-all}"
