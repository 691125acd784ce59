#!/usr/bin/env python3
"""Tests crossings.py: it must name each fault planted in a copy of rtl/.

Standard library only.
"""

import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import rtl_tree  # noqa: E402

BOARD = ["--top", "sp_board", "--parameters", "MaxColumns=64", "MaxRows=40", "Image=1'b0"]
MEDIUM = ["--top", "sp_camera_link", "--parameters", "Taps=4"]
# File below rtl/, text, its replacement, the expected message, and the options that choose the module.
FAULTS = [
    (
        "common/sp_packet_fifo.sv",
        "assign whole      = written_gray_seen !=",
        "assign whole      = written_gray_q !=",
        "neither a synchronizer nor in",
        BOARD,
    ),
    (
        "common/sp_async_fifo.sv",
        ".d_i  (rd_gray_q),",
        ".d_i  (rd_ptr_q ^ (rd_ptr_q >> 1)),",
        "logic before the synchronizer",
        BOARD,
    ),
    (
        "board/sp_axil_bridge.sv",
        "assign request_o    = toggle_there !=",
        "assign request_o    = toggle_q !=",
        "neither a synchronizer nor in",
        BOARD,
    ),
    (
        "camera/sp_beat_crossing.sv",
        "changes_q <= ask_q ? '0 : changes;",
        "changes_q <= ask_q ? '0 : {cut_q, overrun_q};",
        "neither a synchronizer nor in",
        MEDIUM,
    ),
    (
        "camera/sp_replay.sv",
        ".start_i  (start),",
        ".start_i  (play),",
        "neither a synchronizer nor in",
        ["--top", "sp_replay", "--parameters", "MaxColumns=40", "MaxRows=9"],
    ),
]


def main():
    for file, old, new, said, options in FAULTS:
        with tempfile.TemporaryDirectory(prefix="crossings.") as folder:
            copy = rtl_tree.plant(folder, file, old, new)
            result = subprocess.run(
                [sys.executable, ROOT / "tests" / "rtl" / "crossings.py", "--rtl", copy, *options],
                capture_output=True,
                text=True,
                check=False,
            )
            if result.returncode != 1 or said not in result.stderr:
                print(f"crossings_test.py: the fault in {file} was not found:\n{result.stderr}", file=sys.stderr)
                return 1
    print(f"{len(FAULTS)} faults found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
