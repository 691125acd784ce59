#!/usr/bin/env python3
"""Makes IP-XACT (IEEE 1685-2014) of the registers, from rtl/selfproj.rdl.

    ipxact.py [FOLDER]          writes selfproj_board.xml and selfproj_network.xml into FOLDER (build/ipxact)
    ipxact.py --round-trip      reads them back: they must say what model/spec/selfproj.json says

PeakRDL makes it. It comes from PyPI, into build/peakrdl. Where PyPI is not reached, one line says so, and the exit
status is 77.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi  # noqa: E402

PEAKRDL = pypi.Environment(ROOT / "build" / "peakrdl", ["systemrdl-compiler==1.33.0", "peakrdl-ipxact==3.5.0"])
# The SystemRDL map, and the parts of the specification that it has with the names of their address blocks
MAPS = {"selfproj_board": {"selfproj_board.": "registers"},
        "selfproj_network": {"board.": "registers", "link.": "link"}}
EXPORT = """
import sys
from systemrdl import RDLCompiler
from peakrdl_ipxact import IPXACTExporter, Standard
for name in sys.argv[3:]:
    compiler = RDLCompiler()
    compiler.compile_file(sys.argv[1])
    IPXACTExporter(vendor="selfproj", library="rtl", standard=Standard.IEEE_1685_2014).export(
        compiler.elaborate(name), f"{sys.argv[2]}/{name}.xml", component_name=name)
"""
IMPORT = """
import json, sys
from systemrdl import RDLCompiler
from systemrdl.node import RegNode
from peakrdl_ipxact import IPXACTImporter
compiler = RDLCompiler()
IPXACTImporter(compiler).import_file(sys.argv[1])
top = compiler.elaborate().top
print(json.dumps({
    reg.get_path().split(".", 1)[1]: {
        "address": reg.absolute_address,
        "fields": {field.inst_name: [field.low, field.width, field.get_property("sw").name,
                                     field.get_property("reset"), field.get_property("desc")]
                   for field in reg.fields()}}
    for reg in top.descendants() if isinstance(reg, RegNode)}))
"""


def python(code, *words):
    """Runs a program with PeakRDL, and returns what it prints."""
    done = subprocess.run([PEAKRDL.need() / "python3", "-c", code, *map(str, words)], capture_output=True, text=True,
                          check=False)
    if done.returncode:
        sys.exit(f"ipxact.py: PeakRDL: {done.stderr.strip().splitlines()[-1]}")
    return done.stdout


def write(folder):
    folder.mkdir(parents=True, exist_ok=True)
    python(EXPORT, ROOT / "rtl" / "selfproj.rdl", folder, *MAPS)


def wanted(name):
    """Returns what a map has to say: the registers of the specification by path, as IMPORT prints them."""
    sys.path.insert(0, str(ROOT / "model" / "spec"))
    import generate  # noqa: PLC0415: only for this

    spec = generate.Spec(generate.SPEC)
    out = {}
    for prefix, part in MAPS[name].items():
        registers = spec.raw["registers"] if part == "registers" else spec.raw["link"]["registers"]
        for reg in registers:
            known = reg["access"] == "rw" or reg["reset"] != "0"
            out[prefix + reg["name"]] = {
                "address": reg["offset"],
                "fields": {field["name"]: [
                    field["lsb"], field["bits"], "r" if reg["access"] == "ro" else "rw",
                    reg["reset_value"] >> field["lsb"] & (1 << field["bits"]) - 1 if known else None,
                    field["description"]] for field in reg["fields"]}}
    return out


def differences(name, got):
    due = wanted(name)
    for path in sorted(set(due) | set(got)):
        if due.get(path) != got.get(path):
            yield f"{name}: {path}: {got.get(path)} instead of {due.get(path)}"


def round_trip():
    wrong = 0
    with tempfile.TemporaryDirectory(prefix="ipxact.") as folder:
        write(pathlib.Path(folder))
        for name in MAPS:
            got = json.loads(python(IMPORT, pathlib.Path(folder) / f"{name}.xml"))
            for difference in differences(name, got):
                print(f"ipxact.py: {difference}", file=sys.stderr)
                wrong += 1
            # A reader that finds nothing would agree with everything.
            changed = json.loads(json.dumps(got))
            next(iter(changed.values()))["address"] += 4
            if len(got) < 26 or not list(differences(name, changed)):
                print(f"ipxact.py: {name}: the comparison does not notice a changed address", file=sys.stderr)
                wrong += 1
            print(f"{name}: {len(got)} registers, {sum(len(reg['fields']) for reg in got.values())} fields as specified")
    return 1 if wrong else 0


def main():
    words = sys.argv[1:]
    if len(words) > 1 or words and words[0].startswith("-") and words[0] != "--round-trip":
        print(__doc__, file=sys.stderr if words != ["--help"] else sys.stdout)
        return 0 if words == ["--help"] else 2
    try:
        if words == ["--round-trip"]:
            return round_trip()
        folder = pathlib.Path(words[0] if words else ROOT / "build" / "ipxact")
        write(folder)
        print(f"ipxact.py: {', '.join(f'{folder / name}.xml' for name in MAPS)}")
    except pypi.NotReached as error:
        print(f"ipxact.py: skipped: {error}")
        return pypi.UNREACHED
    return 0


if __name__ == "__main__":
    sys.exit(main())
