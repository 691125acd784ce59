#!/usr/bin/env python3
"""Replays rendered images to a simulated FPGA, and compares what comes back with the models.

    replay_test.py [OPTION...]

The options are faults for constraints/ecpix5/simulate.sh. Status 77 where that script cannot run. SELFPROJ_PROGRAMS and
SELFPROJ_BUILD name the programs, as there.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
IMAGES = "12"


def main():
    with tempfile.TemporaryDirectory(prefix="replay.") as folder:
        program = pathlib.Path(os.environ["SELFPROJ_PROGRAMS"]) / "selfproj-sim"
        subprocess.run([program, "scene", "render", "stairs", "--first", "700", "--count", IMAGES, "--out", "images"],
                       cwd=folder, check=True)
        names = [path.name for path in (pathlib.Path(folder) / "images").iterdir() if path.suffix != ".png"]
        for name in names:
            (pathlib.Path(folder) / "images" / name).unlink()
        sys.exit(subprocess.run([ROOT / "constraints/ecpix5/simulate.sh", "--replay", "images", *sys.argv[1:]], cwd=folder,
                                check=False).returncode)


main()
