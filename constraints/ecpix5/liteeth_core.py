#!/usr/bin/env python3
"""Makes LiteEth's core for the ECPIX-5 by liteeth_gen of PyPI, as liteeth.yml says, and prints the path of its Verilog
file. What is current already is not made again. Where PyPI is not reached it prints one line and exits with status 77.
Standard library only.
"""

import fcntl
import hashlib
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi, tools  # noqa: E402

HOME = ROOT / "build" / "ecpix5"
LITEETH = pypi.Environment(HOME / "venv", ["liteeth==2024.12"])
SETTINGS = HERE / "liteeth.yml"
CORE = HOME / "selfproj_liteeth.v"
# The generator declares the one pin of two directions as an input.
WRONG, RIGHT = "input  wire          rgmii_mdio", "inout  wire          rgmii_mdio"


def core():
    """Returns the path of the core."""
    HOME.mkdir(parents=True, exist_ok=True)
    made = CORE.with_suffix(".v.made")
    mark = LITEETH.packages[0] + "".join(hashlib.sha256(path.read_bytes()).hexdigest()
                                         for path in (SETTINGS, pathlib.Path(__file__)))
    with open(HOME / "liteeth.lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two tests may need the core at once
        if not CORE.exists() or not made.exists() or made.read_text(encoding="utf-8") != mark:
            tools.run([LITEETH.need() / "liteeth_gen", SETTINGS, "--name", CORE.stem, "--output-dir", HOME / "liteeth"],
                      log=HOME / "liteeth.log")
            text = (HOME / "liteeth" / "gateware" / CORE.name).read_text(encoding="utf-8")
            if text.count(WRONG) != 1:
                raise tools.ToolError("the core has no port rgmii_mdio as expected")
            CORE.write_text(text.replace(WRONG, RIGHT), encoding="utf-8")
            made.write_text(mark, encoding="utf-8")
    return CORE


def main():
    print(core().relative_to(ROOT))
    return 0


if __name__ == "__main__":
    tools.exit_of(main)
