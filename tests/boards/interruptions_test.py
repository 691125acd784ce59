#!/usr/bin/env python3
"""A host that is killed and comes back, and a cable that is pulled and put back, at a simulated ECPIX-5.

    interruptions_test.py

The board sends 2,000 frames a simulated second. The first host is killed. A second one takes over while the board runs,
and its cable is pulled for two seconds. The second host must count every frame that it did not get as lost, even those
from before it began. Every frame that it got must equal the models'. The exit status is 77 if constraints/ecpix5/simulate.sh
cannot run.
"""

import json
import re

import ecpix5_steps

PERIOD = 62500  # pixel clocks from one frame to the next
STEPS = f"""
board=(--device udp:192.168.1.50)
selfproj board set "${{board[@]}}" measure.threshold=100 measure.mode=grey-over >/dev/null
selfproj board trigger "${{board[@]}}" --period {PERIOD} >/dev/null
selfproj record "${{board[@]}}" --out first.packets --count 100000 >first.txt 2>&1 & record=$!
sleep 1
selfproj board start "${{board[@]}}"
sleep 4
kill -KILL $record
wait $record 2>/dev/null || true
sleep 0.5
selfproj board status "${{board[@]}}" >before.txt
selfproj record "${{board[@]}}" --out second.packets --seconds 60 >second.txt 2>&1 & record=$!
sleep 3
ip link set tap0 down
sleep 2
ip link set tap0 up
sleep 3
selfproj board stop "${{board[@]}}"
sleep 0.5
kill -INT $record
wait $record
selfproj board status "${{board[@]}}" >after.txt
compare_packets second.packets 512x96 triggered={PERIOD} >compared.json
"""


def field(text, name):
    return int(re.search(rf"^0x\w+ {name} .*count=(\d+)", text, re.M)[1])


def number(text, words):
    return int(re.search(rf"{words} ([\d,]+)", text)[1].replace(",", ""))


def wrong_in(folder):
    before, after, reported = ((folder / f"{name}.txt").read_text(encoding="utf-8")
                               for name in ("before", "after", "second"))
    compared = json.loads((folder / "compared.json").read_text(encoding="utf-8"))
    sent = field(after, "frames") - field(after, "lost_moments")
    got, lost = compared["packets"], number(reported, "lost in the network")
    gaps = number(reported, "missing frames")  # between the first packet that the second host got and its last one
    print(f"{field(before, 'frames')} frames before the second host, {sent} in all: {got} recorded, "
          f"{compared['equal']} of them the models', {lost} counted as lost, {gaps} of them while it recorded")
    if got + lost != sent or compared["equal"] != got:
        return "a frame is neither recorded nor counted as lost, or differs from the models'"
    return "" if gaps > 0 and got > 10 and lost > gaps else "nothing was interrupted"


ecpix5_steps.run(STEPS, wrong_in)
