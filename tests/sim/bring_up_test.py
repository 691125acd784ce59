#!/usr/bin/env python3
"""Runs the steps of docs/network-board.md that need a board, beside a simulated one.

    bring_up_test.py

The steps are the blocks `sh` under a comment `run by target.bring_up`, one after another in an empty folder. On a busy
machine the simulation may have to wait in the middle of a packet, for longer than a host waits for the rest of it. The
steps say so as a loss; they have three tries. Status 77 where scripts/target_sim.sh cannot run. SELFPROJ_PROGRAMS and
SELFPROJ_JUDGE name the programs, as there.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TRIES = 3
STEPS = re.compile(r"^<!-- [^>]*run by target\.bring_up -->\n```sh\n(.*?)^```$", re.M | re.S)


def run(steps):
    """Runs the steps. Returns what was wrong, and the exit status."""
    with tempfile.TemporaryDirectory(prefix="bring-up.") as folder:
        path = f"{pathlib.Path(os.environ['SELFPROJ_JUDGE']).parent}:{os.environ['PATH']}"
        done = subprocess.run([ROOT / "scripts/target_sim.sh", "--", "bash", "-euxo", "pipefail", "-c", steps],
                              cwd=folder, env={**os.environ, "PATH": path}, check=False)
        if done.returncode:
            return "a step has failed", done.returncode
        images = sorted(path.name for path in (pathlib.Path(folder) / "images").glob("image_*.png"))
        return (f"3 raw images were to come, not {images}", 1) if len(images) != 3 else ("", 0)


def main():
    steps = STEPS.findall((ROOT / "docs" / "network-board.md").read_text(encoding="utf-8"))
    if len(steps) < 4:
        sys.exit("bring_up_test.py: docs/network-board.md: its steps are not found")
    for left in reversed(range(TRIES)):
        wrong, status = run("".join(steps))
        if not wrong or status == 77:
            sys.exit(status)
        print(f"bring_up_test.py: {wrong}; tries left: {left}", file=sys.stderr)
    sys.exit(1)


main()
