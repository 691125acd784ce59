#!/usr/bin/env python3
"""run.py [--faults] FOLDER: runs the tests of board_bench.py with cocotb and Icarus. What they make is in FOLDER.
run.py --golden BUILD FOLDER: runs those of golden_bench.py, which compare with the Python package selfproj; it takes
its libraries from BUILD. sp_column_moments and sp_board run in Icarus and in Verilator.

With --faults it plants faults in copies of rtl/, one after another, and the test that it names must find each.

cocotb, cocotbext-axi and NumPy come from PyPI, into a virtual environment in build/cocotb of the project. Where PyPI is
not reached it says that it was skipped, and its exit status is 0. SELFPROJ_SEED draws other cases.
"""
import itertools
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi, rtl_tree  # noqa: E402

COCOTB = pypi.Environment(ROOT / "build" / "cocotb", ["cocotb==1.9.2", "cocotbext-axi==0.1.24", "numpy==2.4.6"],
                          "--only-binary", "numpy,cocotb")
BUILD_ARGUMENTS = {"icarus": ["-g2012"], "verilator": ["-Wno-fatal", "-O1"]}
# Verilator's code runs only briefly here. Optimizing it would take longer than it saves.
MAKE_FLAGS = "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0"
PARAMETERS = {"MaxColumns": 64, "MaxRows": 15}
# File, old, new, and the test that finds it
FAULTS = [
    ("board/sp_packetizer.sv", "{check_q[30:0], 1'b0} ^", "{check_q[30:0], 1'b1} ^",
     "frames_under_random_back_pressure"),
    ("board/sp_packetizer.sv", "q.asked[Start2] && !take ||", "1'b0 ||", "what_a_full_fifo_drops_is_counted"),
    ("board/sp_axil_bridge.sv", "s_axil_rresp_o <= back_error_q ? SlaveError : Okay;", "s_axil_rresp_o <= Okay;",
     "registers_with_stalls_on_every_channel"),
    ("board/sp_encoder.sv", "{{8{lines_q.step && lines_q.down}}, lines_q.step}", "{8'd0, lines_q.step}",
     "the_encoder_counts_its_steps"),
    ("board/sp_frame_timeout.sv", "expired_o <= !beat1_i &&", "expired_o <= 1'b0 &&", "frames_with_faults"),
]


def simulate(rtl, folder, only, simulator):
    """Runs the tests, or only one, in the environment with cocotb. Returns how many there were, and how many failed."""
    from cocotb.runner import get_results, get_runner  # only there
    runner = get_runner(simulator)
    top = "sp_column_moments" if only == "golden_moments" else "sp_board"
    package = rtl / "common" / "sp_spec_pkg.sv"
    sources = [package, *sorted(path for path in rtl.rglob("sp_*.sv") if path != package)]
    runner.build(verilog_sources=sources, hdl_toplevel=top, parameters=PARAMETERS, build_dir=folder, always=True,
                 build_args=BUILD_ARGUMENTS[simulator], timescale=("1ps", "1ps"))
    results = runner.test(hdl_toplevel=top, test_module="golden_bench" if only.startswith("golden") else "board_bench",
                          build_dir=folder, test_dir=folder, testcase=only or None,
                          extra_env={"MAX_COLUMNS": str(PARAMETERS["MaxColumns"]),
                                     "MAX_ROWS": str(PARAMETERS["MaxRows"])})
    tests, failed = get_results(results)
    print(f"cocotb: {tests} tests, {failed} failed")
    return 0 if failed == 0 and tests >= (1 if only else 5) else 1


def run(rtl, folder, only="", simulator="icarus", packages=""):
    """Runs the tests with Python of the environment, and with the packages of another one. Returns the exit status and
    what they say."""
    path = os.pathsep.join(filter(None, [str(pathlib.Path(__file__).parent), str(packages)]))
    environment = os.environ | {"PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1", "PYTHONWARNINGS": "ignore",
                                "MAKEFLAGS": f"{os.environ.get('MAKEFLAGS', '')} {MAKE_FLAGS}"}
    folder.mkdir(parents=True, exist_ok=True)
    done = subprocess.run([COCOTB.python, __file__, "--simulate", rtl, folder, only, simulator], env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


def golden(build, folder):
    """Compares with the model from Python. Returns the exit status."""
    sys.path.insert(0, str(ROOT / "tests" / "outside" / "python"))
    import environment
    wrong = environment.install(build, environment.PACKAGE)
    if wrong:
        print(wrong)
        return 0 if wrong.startswith("skipped:") else 1
    packages = next((environment.PACKAGE.home / "lib").glob("python3*")) / "site-packages"
    worst = 0
    for test, simulator in itertools.product(("golden_moments", "golden_board"), ("icarus", "verilator")):
        status, said = run(ROOT / "rtl", folder / f"{test}_{simulator}", test, simulator, packages)
        print(said if status else f"{test} in {simulator}: {said.splitlines()[-1]}")
        worst = max(worst, status)
    return worst


def plant_all(folder):
    """Plants the faults. Returns whether each is found."""
    missed = 0
    for file, old, new, test in FAULTS:
        with tempfile.TemporaryDirectory(dir=folder) as copy:
            status, said = run(rtl_tree.plant(copy, file, old, new), pathlib.Path(copy) / "simulation", test)
        found = status == 1 and "cocotb: 1 tests, 1 failed" in said
        print(f"{file}: {new}: {'found by ' + test if found else 'NOT FOUND'}", flush=True)
        missed += not found
    return missed == 0


def main():
    if len(sys.argv) == 6 and sys.argv[1] == "--simulate":
        return simulate(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]), *sys.argv[4:])
    against_model = sys.argv[1:2] == ["--golden"]
    faults = sys.argv[1:2] == ["--faults"]
    if len(sys.argv) != (4 if against_model else 2 + faults):
        print("run.py: [--faults] FOLDER, or --golden BUILD FOLDER", file=sys.stderr)
        return 2
    folder = pathlib.Path(sys.argv[-1]).resolve()
    if not COCOTB.get():
        print(COCOTB.missing())
        return 0
    folder.mkdir(parents=True, exist_ok=True)
    if against_model:
        return golden(pathlib.Path(sys.argv[2]).resolve(), folder)
    if faults:
        return 0 if plant_all(folder) else 1
    status, said = run(ROOT / "rtl", folder)
    print(said, end="")
    return status


if __name__ == "__main__":
    sys.exit(main())
