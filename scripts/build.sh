#!/usr/bin/env bash
# build.sh [PRESET]: installs what is missing, configures and builds. PRESET: release (default), dev, sanitizers.
# The programs of preset release, built for speed, are then in build/bin/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if (($# > 1)) || [[ ${1:-} == -* ]]; then
  echo "usage: scripts/build.sh [release|dev|sanitizers]" >&2
  exit 2
fi
preset=${1:-release}

scripts/setup.sh
cmake --preset "$preset" --log-level=NOTICE
cmake --build --preset "$preset"
