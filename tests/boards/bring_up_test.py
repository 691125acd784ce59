#!/usr/bin/env python3
"""Runs the steps of docs/network-board.md that need a board, on a simulated one.

    bring_up_test.py

The steps are the blocks `sh` under a comment `run by ecpix5.bring_up`. They run one after another in an empty folder.
The exit status is 77 if constraints/ecpix5/simulate.sh cannot run.
"""

import re
import sys

import ecpix5_steps

STEPS = re.compile(r"^<!-- [^>]*run by ecpix5\.bring_up -->\n```sh\n(.*?)^```$", re.M | re.S)


def wrong_in(folder):
    images = sorted(path.name for path in (folder / "images").glob("image_*.png"))
    return "" if len(images) == 3 else f"3 raw images were expected, not {images}"


def main():
    steps = STEPS.findall((ecpix5_steps.ROOT / "docs" / "network-board.md").read_text(encoding="utf-8"))
    if len(steps) < 5:
        sys.exit("bring_up_test.py: docs/network-board.md: steps are missing")
    ecpix5_steps.run("".join(steps), wrong_in)


main()
