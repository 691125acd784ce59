#!/usr/bin/env bash
# other_debian.sh [--record | --when]: runs both commands of the README, the demo and the quick tests, on the other
# release of Debian: in a chroot of Debian 13 on Debian 12, and of 12 on 13. Then it makes the Python wheel there and runs
# the notebooks from it, unless their packages cannot be had from PyPI, as one line then says. It needs root and debootstrap; where these
# or the packages cannot be had, it says so in one line and exits with status 77. A line says when a run last passed here,
# and at which commit.
#
# The chroot stays in SELFPROJ_CACHE (default ~/.cache/selfproj), about 6 GB, with its packages and what its compiler
# made (ccache). Sources that passed there are not tried again. --when only prints that line. --record writes the versions
# and times of the run to results/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

record=false
when=false
case ${1:-} in
  "") ;;
  --record) record=true ;;
  --when) when=true ;;
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) echo "other_debian.sh: $1: unknown; usage: scripts/other_debian.sh [--record | --when]" >&2; exit 2 ;;
esac

release=trixie
number=13
if grep -q '^VERSION_ID="13"' /etc/os-release; then
  release=bookworm
  number=12
fi
cache=${SELFPROJ_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/selfproj}
root=$cache/$release
passed=$cache/$release.passed

last() {
  if [[ -f $passed ]]; then
    echo "Debian $number: last passed on this machine $(sed -n 2p "$passed")"
  else
    echo "Debian $number: has not passed on this machine yet"
  fi
}
skip() {
  echo "skipped: Debian $number: $1"
  last
  exit 77
}
if $when; then last; exit 0; fi

((EUID == 0)) || skip "a chroot needs root"
command -v debootstrap >/dev/null || skip "there is no debootstrap (scripts/setup.sh tests)"
unshare --mount true 2>/dev/null || skip "no mount namespace is allowed"

state=$({ scripts/lib/files.sh | tr '\n' '\0' | xargs -0 sha256sum
  find ../shared/data -type f -printf '%p %s\n' 2>/dev/null | LC_ALL=C sort || true
} | sha256sum | cut -d ' ' -f 1)
if ! $record && [[ -f $passed && $(sed -n 1p "$passed") == "$state" ]]; then
  echo "unchanged: $(last)"
  exit 0
fi

mkdir -p "$cache"
if [[ ! -e $root/ready ]]; then
  rm -rf "$root"
  debootstrap --variant=minbase --include=ca-certificates "$release" "$root" >"$cache/debootstrap.log" 2>&1 ||
    skip "debootstrap failed ($cache/debootstrap.log)"
  touch "$root/ready"
fi
# The network as this machine knows it
cp /etc/resolv.conf "$root/etc/"
cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/" 2>/dev/null || true
for file in /etc/apt/apt.conf.d/*proxy*; do
  if [[ -e $file ]]; then cp "$file" "$root/etc/apt/apt.conf.d/"; fi
done

# The sources without what a build made of them elsewhere, and their history. A clone has it in a worktree as well, but
# has to be told where this branch leaves the one that it follows.
sources=$root/selfproj
rm -rf "$sources"
git clone --quiet --no-hardlinks --no-checkout "file://$PWD" "$sources"
scripts/lib/files.sh | tar --create --verbatim-files-from --files-from=- | tar --extract --directory "$sources"
git -C "$sources" reset --quiet
if base=$(git merge-base HEAD '@{upstream}' 2>/dev/null); then
  git -C "$sources" update-ref "refs/remotes/origin/$(git branch --show-current)" "$base"
fi
if [[ -d ../shared/data ]]; then
  mkdir -p "$root/shared/data"
fi

# in_chroot COMMAND: runs it in the sources there, with mounts that end with it
in_chroot() {
  # shellcheck disable=SC2016  # the inner shell expands them
  unshare --mount --propagation private bash -euc '
    root=$1
    mount -t proc proc "$root/proc"
    mount --rbind /dev "$root/dev"
    mount --rbind /sys "$root/sys"
    mount -t tmpfs tmpfs "$root/tmp"
    if [[ -d ../shared/data ]]; then mount --bind -o ro ../shared/data "$root/shared/data"; fi
    exec chroot "$root" env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
      LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive SELFPROJ_DEMO_SECONDS=3 \
      bash -euc "cd /selfproj; $2"
  ' in_chroot "$root" "$1" </dev/null
}

in_chroot "apt-get -qq update && scripts/setup.sh tests" >"$cache/$release.setup.log" 2>&1 ||
  skip "its packages cannot be installed ($cache/$release.setup.log)"
times=()
for command in scripts/demo.sh scripts/test.sh; do
  echo "Debian $number: $command"
  SECONDS=0
  in_chroot "git config --global --add safe.directory /selfproj; $command"
  name=$(basename "$command" .sh)
  times+=("$name/seconds=$SECONDS")
done
echo "Debian $number: the notebooks from a wheel"
SECONDS=0
in_chroot "python3 -B tests/outside/python/run.py --notebooks build/quick" || (($? == 77))
times+=("notebooks/seconds=$SECONDS")
printf '%s\n%s at %s\n' "$state" "$(date +%F)" "$(git rev-parse --short HEAD)$(git diff --quiet HEAD || echo ' and changes')" \
  >"$passed"
last
if $record; then
  versions=()
  while IFS= read -r line; do versions+=("versions/$line"); done < <(in_chroot \
    "dpkg-query --show --showformat='\${Package}=\${Version}\n' g++ cmake verilator yosys iverilog libsystemc-dev")
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record "debian_$number" \
    --command "scripts/other_debian.sh --record" \
    --about "Both commands of the README in a chroot of Debian $number, made on the other release" \
    "${times[@]}" "${versions[@]}"
fi
