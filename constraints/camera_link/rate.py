#!/usr/bin/env python3
"""Says what blanking a Camera Link camera of 8 or 10 taps needs in front of the board, and how many frames a second
result.

A line has n = ceil(C / T) words of the camera's clock F, and G words without line valid follow it. The board takes one
beat of four pixels in a clock B, so C / 4 clocks a line. While words come faster than that, they wait in the FIFO of
sp_wide_beats:

    of one line             n - (B / F) n / (C / 4) n
    at the end of a frame   R n - (B / F) (R (n + G) - G) / (C / 4) n

Neither may be more than the 2^L words of the FIFO less four that are on their way, or the frame may be cut off, which
is counted. The exit status is then 1, and the smallest L with room is told. B is the clock that your board's design
has, which need not be the default. Nothing is left from line to line with G of (C / 4) F / B - n or more.

No more frames come in a second than F / (R (n + G)) by the camera's words, and B / (R C / 4) by the board's beats. A
camera that is faster than the board must pause between two frames, as long as is told, or the FIFO fills from frame to
frame. What the camera itself needs between two frames comes on top.
"""

import argparse
import math
import sys


ON_THEIR_WAY = 4  # words; CameraLinkFull.TheFifoHoldsWhatTheFormulaSays leaves out cases that are closer than that
APART = 32  # clocks of the board from one line's beginning to the next one's, with 80 bit (sp_camera_link)


def waiting(taps, ratio, columns, rows, gap):
    """Returns the most words that wait, of one line and at the end of a frame. ratio: the board's clock over the
    camera's."""
    words = -(-columns // taps)
    taken = ratio * words / (columns / 4)  # words that the board takes in a clock of the camera
    return max(words - taken * words, 0), max(rows * words - taken * (rows * (words + gap) - gap), 0)


# What the circuit can be built for
MOST = {"--camera-mhz": 1000, "--board-mhz": 1000, "--columns": 2048, "--rows": 1023, "--gap": 65535, "--log-words": 24}


def between(option, kind):
    """Returns what reads the value of an option, from 1 to the most that there is."""
    def read(text):
        value = kind(text)
        if not 1 <= value <= MOST[option]:
            raise argparse.ArgumentTypeError(f"{text} is not in 1 to {MOST[option]}")
        return value
    read.__name__ = kind.__name__
    return read


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--taps", type=int, default=8, choices=(8, 10), metavar="T", help="8 or 10")
    parser.add_argument("--bits", type=int, default=8, choices=(8, 10), help="of a pixel: 8; with 8 taps also 10")
    for option, kind, usual, letter, text in (
            ("--camera-mhz", float, 85, "F", "clock of its words"),
            ("--board-mhz", float, 151.2, "B", "its pixel clock"),
            ("--columns", int, 512, "C", "a multiple of 4"), ("--rows", int, 96, "R", None),
            ("--gap", int, 4, "G", "words between two lines"),
            ("--log-words", int, 9, "L", "as sp_camera_link has it")):
        parser.add_argument(option, type=between(option, kind), default=usual, metavar=letter, help=text)
    at = parser.parse_args()
    if at.columns % 4 != 0:
        parser.error("argument --columns: is not a multiple of 4")
    if at.taps == 10 and at.bits != 8:
        parser.error("argument --bits: ten taps have 8 bits")
    if at.camera_mhz >= at.board_mhz:
        parser.error("argument --board-mhz: the board's clock must be faster than the camera's")
    words = -(-at.columns // at.taps)
    ratio = at.board_mhz / at.camera_mhz
    if at.taps * at.bits == 80 and (words + at.gap) * ratio < APART:
        parser.error(f"argument --gap: with 80 bit, lines must begin {APART} clocks of the board apart or more; at "
                     f"least {math.ceil(APART / ratio) - words}")
    of_line, of_frame = waiting(at.taps, ratio, at.columns, at.rows, at.gap)
    room = (1 << at.log_words) - ON_THEIR_WAY
    wanted = max(math.ceil(math.log2(max(of_line, of_frame) + ON_THEIR_WAY)), 1)
    fits = wanted <= at.log_words
    remedy = f"LogWords={wanted} has room" if wanted <= MOST["--log-words"] else "a longer gap is needed"
    enough = max(math.ceil(at.columns / 4 / ratio - words), 1)
    by_words = at.camera_mhz * 1e6 / (at.rows * (words + at.gap))
    by_beats = at.board_mhz * 1e6 / (at.rows * at.columns / 4)
    pause = max(math.ceil(at.rows * at.columns / 4 / ratio) - at.rows * (words + at.gap), 0)
    print(f"a line: {words} words, and {at.gap} between two; from {enough} on nothing is left from line to line")
    print(f"words that wait: {math.ceil(of_line)} of one line, {math.ceil(of_frame)} at the end of a frame; room for "
          f"{room}{'' if fits else f': TOO FEW, frames are cut off; {remedy}'}")
    print(f"frames a second: {by_words:,.0f} by the camera's words, {by_beats:,.0f} by the board's beats")
    print(f"so at most {min(by_words, by_beats):,.0f}" +
          (f", with {pause} words or more, besides the gap, between two frames" if pause > 0 else ""))
    return 0 if fits else 1


if __name__ == "__main__":
    sys.exit(main())
