#!/usr/bin/env bash
# changed.sh PATTERN...: the files of the project that match and differ from the branch that this one follows, or from
# the commit before where there is no difference. Without history: all of them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
base=$(git merge-base HEAD '@{upstream}' 2>/dev/null || git rev-parse -q --verify HEAD 2>/dev/null || true)
if [[ -n $base ]] && git diff --quiet "$base" -- && [[ -z $(git ls-files --others --exclude-standard) ]]; then
  base=$(git rev-parse -q --verify 'HEAD~1' 2>/dev/null || true)
fi
if [[ -z $base ]]; then
  git ls-files -- "$@"
else
  { git diff --name-only --diff-filter=d "$base" -- "$@"; git ls-files --others --exclude-standard -- "$@"; } |
    LC_ALL=C sort -u
fi
