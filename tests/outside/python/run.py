#!/usr/bin/env python3
"""Installs the Python package into an environment of its own, and runs its tests and the examples of the documents.

    run.py BUILD PROGRAMS
    run.py --notebooks BUILD      only the notebooks, from a wheel of the build in an environment with NumPy alone

nanobind, scikit-build-core, plyfile and NumPy come from PyPI, into build/wheel-tools, build/python-tests and build/python-user of
the project. Where PyPI is not reached it says that it was skipped, and its exit status is 77. SELFPROJ_SEED draws other
cases.
"""

import pathlib
import subprocess
import sys
import tempfile

import environment

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import consumer  # noqa: E402


def run_examples(variables, programs):
    """Runs every block `python` of the front page and the page for users that uses the package, where what it reads is.
    Returns what is wrong."""
    blocks = [block for block in consumer.blocks("python") if "selfproj" in block and "harvesters" not in block]
    if len(blocks) < 4:
        return f"only {len(blocks)} examples"
    with tempfile.TemporaryDirectory() as folder:
        for words in (["scene", "render", "stairs", "--first", "700", "--count", "1", "--out", "frames"],
                      ["board", "--line", "512x96", "--record", "line.slfp"],
                      ["scene", "render", "desk", "--bits", "4", "--count", "8", "--out", "captures"]):
            subprocess.run([programs / "selfproj-sim", *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        for block in blocks:
            done = subprocess.run([environment.PACKAGE.python, "-c", block], cwd=folder, env=variables,
                                  capture_output=True, text=True, check=False)
            if done.returncode or not done.stdout:
                return f"{block}\n{done.stdout}{done.stderr}"
            print(done.stdout.splitlines()[-1])
        missing = [name for name in ("height.tiff", "cloud.ply") if not (pathlib.Path(folder) / name).exists()]
    return f"not written: {missing}" if missing else ""


def run_notebooks():
    """Returns whether all of them run."""
    print("notebooks, by plain Python and not by Jupyter:", flush=True)
    return subprocess.run([environment.USER.python, pathlib.Path(__file__).with_name("notebooks.py"), "production",
                           "research", "fpga"], check=False).returncode == 0


def main():
    if sys.argv[1] == "--notebooks":
        wrong = environment.install(pathlib.Path(sys.argv[2]).resolve(), environment.USER)
        if wrong:
            print(wrong)
        return 77 if wrong.startswith("skipped:") else 1 if wrong or not run_notebooks() else 0
    build, programs = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    variables = environment.variables(build, programs)
    wrong = environment.install(build, environment.PACKAGE, environment.USER)
    if wrong:
        print(wrong)
        return 77 if wrong.startswith("skipped:") else 1
    tests = pathlib.Path(__file__).with_name("test_package.py")
    if subprocess.run([environment.PACKAGE.python, tests], env=variables, check=False).returncode:
        return 1
    if not run_notebooks():
        return 1
    wrong = run_examples(variables, programs)
    print(wrong)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
