#!/usr/bin/env bash
# files.sh [--changed] [PATTERN...]: the files of the project that match (all, without a PATTERN): what git tracks or would
# track, without what is deleted. With --changed those that differ from the branch that this one follows, or from the
# commit before where there is no difference; without history, all.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

base=
if [[ ${1:-} == --changed ]]; then
  shift
  base=$(git merge-base HEAD '@{upstream}' 2>/dev/null || git rev-parse -q --verify HEAD 2>/dev/null || true)
  if [[ -n $base ]] && git diff --quiet "$base" -- && [[ -z $(git ls-files --others --exclude-standard) ]]; then
    base=$(git rev-parse -q --verify 'HEAD~1' 2>/dev/null || true)
  fi
fi
{
  if [[ -n $base ]]; then git diff --name-only --diff-filter=d "$base" -- "$@"; else git ls-files -- "$@"; fi
  git ls-files --others --exclude-standard -- "$@"
} | LC_ALL=C sort -u | while IFS= read -r file; do
  if [[ -f $file ]]; then printf '%s\n' "$file"; fi
done
