#!/usr/bin/env python3
"""Runs the steps of docs/network-board.md that need a board, beside a simulated one.

    bring_up_test.py

The steps are the blocks `sh` under a comment `run by target.bring_up`, one after another in an empty folder. Status 77
where scripts/target_sim.sh cannot run.
"""

import re
import sys

import target_steps

STEPS = re.compile(r"^<!-- [^>]*run by target\.bring_up -->\n```sh\n(.*?)^```$", re.M | re.S)


def wrong_in(folder):
    images = sorted(path.name for path in (folder / "images").glob("image_*.png"))
    return "" if len(images) == 3 else f"3 raw images were to come, not {images}"


def main():
    steps = STEPS.findall((target_steps.ROOT / "docs" / "network-board.md").read_text(encoding="utf-8"))
    if len(steps) < 4:
        sys.exit("bring_up_test.py: docs/network-board.md: its steps are not found")
    target_steps.run("".join(steps), wrong_in)


main()
