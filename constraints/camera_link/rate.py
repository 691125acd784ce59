#!/usr/bin/env python3
"""Says what blanking a Camera Link camera of 8 or 10 taps needs in front of the board, and how many frames a second
result.

    rate.py [--taps T] [--camera-mhz F] [--board-mhz B] [--columns C] [--rows R] [--gap G] [--log-words L]

A line has n = ceil(C / T) words of the camera's clock F, and G words without line valid follow it. The board takes one
beat of four pixels in a clock B, so C / 4 clocks a line. While words come faster than that, they wait in the FIFO of
sp_wide_beats:

    of one line             n - (B / F) n / (C / 4) n
    at the end of a frame   R n - (B / F) (R (n + G) - G) / (C / 4) n

Neither may be more than the 2^L words of the FIFO less four that are on their way, or the frame may be cut off, which
is counted. The exit status is then 1, and the smallest L with room is told. B is the clock that your board's design
has, which need not be the default.
Nothing is left from line to line with G of (C / 4) F / B - n or more. No more frames come in a second than
F / (R (n + G)) by the camera's words, and B / (R C / 4) by the board's beats, before what the camera needs between two
frames. Standard library only.
"""

import argparse
import math
import sys


ON_THEIR_WAY = 4  # words; CameraLinkFull.TheFifoHoldsWhatTheFormulaSays leaves out cases that are closer than that


def waiting(taps, ratio, columns, rows, gap):
    """Returns the most words that wait, of one line and at the end of a frame. ratio: the board's clock over the
    camera's."""
    words = -(-columns // taps)
    taken = ratio * words / (columns / 4)  # words that the board takes in a clock of the camera
    return max(words - taken * words, 0), max(rows * words - taken * (rows * (words + gap) - gap), 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taps", type=int, default=8, choices=(8, 10))
    parser.add_argument("--camera-mhz", type=float, default=85, metavar="F")
    parser.add_argument("--board-mhz", type=float, default=151.2, metavar="B")
    parser.add_argument("--columns", type=int, default=512, metavar="C")
    parser.add_argument("--rows", type=int, default=96, metavar="R")
    parser.add_argument("--gap", type=int, default=4, metavar="G", help="words between two lines")
    parser.add_argument("--log-words", type=int, default=9, metavar="L", help="as sp_camera_link has it")
    at = parser.parse_args()
    if at.columns < 4 or at.columns % 4 != 0 or at.rows < 1 or at.gap < 1 or min(at.camera_mhz, at.board_mhz) <= 0:
        parser.error("columns are a multiple of 4; rows, gaps and clocks are positive")
    if at.camera_mhz >= at.board_mhz:
        parser.error("the board's clock must be faster than the camera's")
    words = -(-at.columns // at.taps)
    ratio = at.board_mhz / at.camera_mhz
    of_line, of_frame = waiting(at.taps, ratio, at.columns, at.rows, at.gap)
    room = (1 << at.log_words) - ON_THEIR_WAY
    wanted = max(math.ceil(math.log2(max(of_line, of_frame) + ON_THEIR_WAY)), 1)
    fits = wanted <= at.log_words
    enough = max(math.ceil(at.columns / 4 / ratio - words), 1)
    print(f"a line: {words} words, and {at.gap} between two; from {enough} on nothing is left from line to line")
    print(f"words that wait: {math.ceil(of_line)} of one line, {math.ceil(of_frame)} at the end of a frame; room for "
          f"{room}{'' if fits else f': TOO FEW, frames are cut off; LogWords={wanted} has room'}")
    print(f"frames a second: {at.camera_mhz * 1e6 / (at.rows * (words + at.gap)):,.0f} by the camera's words, "
          f"{at.board_mhz * 1e6 / (at.rows * at.columns / 4):,.0f} by the board's beats")
    return 0 if fits else 1


if __name__ == "__main__":
    sys.exit(main())
