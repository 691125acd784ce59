"""rtl/ as the scripts in Python take it: the command with which Yosys reads it, and copies of it with a fault planted.

Standard library only.
"""

import pathlib
import shutil

ROOT = pathlib.Path(__file__).resolve().parents[1]
PACKAGE = pathlib.Path("common") / "sp_spec_pkg.sv"


class PlantError(Exception):
    """A fault has no place in rtl/."""


def sources(rtl=ROOT / "rtl"):
    """Every file of rtl, the package first."""
    others = sorted(path for path in rtl.rglob("sp_*.sv") if not path.name.endswith("_pkg.sv"))
    return [rtl / PACKAGE, *others]


def read_command(top, parameters=(), rtl=ROOT / "rtl", more=(), formal=False):
    """Commands of Yosys that read rtl, and the files `more`, and set parameters ("NAME=VALUE") of the module `top`."""
    files = " ".join(map(str, [*sources(rtl), *more]))
    sets = "".join(f" -set {text.replace('=', ' ', 1)}" for text in parameters)
    return f"read_verilog {'-formal ' if formal else ''}-sv {files}; " + (f"chparam{sets} {top}; " if sets else "")


def plant(folder, file, old, new):
    """A copy of rtl/ in folder, in whose file (below rtl/) the one occurrence of old is new; its path."""
    copy = pathlib.Path(folder) / "rtl"
    shutil.copytree(ROOT / "rtl", copy)
    text = (copy / file).read_text()
    if text.count(old) != 1:
        raise PlantError(f"rtl/{file} holds '{old}' {text.count(old)} times, not once")
    (copy / file).write_text(text.replace(old, new))
    return copy
