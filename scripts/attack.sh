#!/usr/bin/env bash
# attack.sh [--short] [--seed S] [--share X] [--only PART...] [--programs DIR] [--record]: attacks the programs of
# build/bin from outside: every case that an attack has found, damaged and cut files of every kind that they read,
# images of every format, depth and layout, captures in wrong orders, names in every encoding, malicious values for every
# option, full disks, two outputs on one file, outputs onto inputs, a failing standard output, signals at random moments,
# damaged and shortened rings, readers and boards that are killed and restarted, with an exact account of every packet,
# and slow, silent and greedy clients of a line's page and Modbus server. --only soak runs two whole lines for four
# hours, with all of this.
#
# A fault is a signal, a wrong result with status 0, a loss that nobody counts, an input that changed, a file left
# behind, an error of more than one line, a good client that waits. Each is printed with the options that repeat it, and
# the exit status is 1. The long run takes hours; --short, which is a test, takes a minute. --record keeps the figures
# of a run in the folder results.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec python3 tests/attack/attack.py "$@"
