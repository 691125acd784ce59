#!/usr/bin/env python3
"""FuseSoC takes the circuits: every file is in one core, the cores lint and simulate, and a design needs one line.

    fusesoc_test.py

FuseSoC comes from PyPI, into a virtual environment in build/fusesoc of the project. Where PyPI is not reached the test
is skipped after the check of the files, with exit status 77.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi  # noqa: E402

FUSESOC = pypi.Environment(ROOT / "build" / "fusesoc", ["fusesoc==2.4.7"])
EXAMPLE = ROOT / "tests" / "rtl" / "example"


def files_of_cores():
    """What is wrong with the lists of files."""
    for room in sorted(path for path in (ROOT / "rtl").iterdir() if path.is_dir()):
        listed = re.findall(r"^      - (sp_\w+\.sv)$", (room / f"{room.name}.core").read_text(encoding="utf-8"),
                            flags=re.MULTILINE)
        there = sorted(path.name for path in room.glob("sp_*.sv"))
        if sorted(listed) != there:
            yield f"{room.name}.core: {sorted(set(listed) ^ set(there)) or 'a file is listed twice'}"


def fusesoc(folder, target, core, design):
    """Runs a target in a folder, with the cores of the project and those of `design`. Returns status and output."""
    roots = [word for root in (ROOT / "rtl", design) for word in ("--cores-root", str(root))]
    done = subprocess.run([FUSESOC.bin / "fusesoc", *roots, "run", "--target", target, core], cwd=folder,
                          env={**os.environ, "PATH": f"{FUSESOC.bin}:{os.environ['PATH']}"}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


def wrong_runs(folder):
    for core in ("rtl:moments", "rtl:gray", "rtl:board", "rtl:link", "example:camera_to_dma"):
        status, out = fusesoc(folder, "lint", f"selfproj:{core}", EXAMPLE)
        if status:
            yield f"lint of {core}: {out}"
    status, out = fusesoc(folder, "sim", "selfproj:rtl:board", EXAMPLE)
    if status or "column 8: m0 1, m1 3" not in out or "trailer: status 0" not in out:
        yield f"sim of board: {out}"
    # The design with a fault.
    shutil.copytree(EXAMPLE, folder / "copy")
    design = folder / "copy" / "camera_to_dma.sv"
    text = design.read_text(encoding="utf-8")
    design.write_text(text.replace("endmodule", "logic [3:0] nobody;\nendmodule"), encoding="utf-8")
    status, out = fusesoc(folder, "lint", "selfproj:example:camera_to_dma", folder / "copy")
    if status == 0 or "nobody" not in out:
        yield f"lint did not find the planted fault: {out}"


def main():
    wrong = list(files_of_cores())
    if not wrong:
        if not FUSESOC.get():
            print(FUSESOC.missing())
            return 77
        with tempfile.TemporaryDirectory() as folder:
            wrong = list(wrong_runs(pathlib.Path(folder)))
    print("\n".join(wrong) or "four cores lint, a frame went through the board, and a design needs one line")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
