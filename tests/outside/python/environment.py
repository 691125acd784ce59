"""Virtual environments for the tests of the Python package: one has what the tests need, and one, a user's, only the wheel
and NumPy."""

import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi  # noqa: E402

PACKAGE = pypi.Environment(ROOT / "build" / "python-tests",
                           ["mypy==2.4.1", "nanobind==3.1.0", "numpy==2.4.6", "plyfile==1.1.5",
                            "scikit-build-core==1.1.2"], "--only-binary", ":all:")
USER = pypi.Environment(ROOT / "build" / "python-user", ["numpy==2.4.6"], "--only-binary", ":all:")


def install(build, *environments):
    """Makes a wheel with the libraries of a build, and installs it into these environments, which it makes first. Returns
    what was printed if that failed, a line that begins with "skipped:" where PyPI is not reached, otherwise an empty
    string."""
    for environment in environments:
        if not environment.get():
            return environment.missing()
    made = subprocess.run([ROOT / "scripts" / "wheel.sh", build], capture_output=True, text=True, check=False)
    if made.returncode:
        return made.stdout + made.stderr
    for environment in environments:
        begin = time.monotonic()
        done = environment.pip("--no-deps", "--no-index", "--force-reinstall", made.stdout.split()[-1])
        if done.returncode:
            return done.stdout + done.stderr
    print(f"the wheel was installed in {time.monotonic() - begin:.1f} s")
    return ""


def variables(build, programs):
    """Returns the environment variables for the tests."""
    return {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "SELFPROJ_C_LIBRARY": str(build / "capi" / "libselfproj.so"),
            "SELFPROJ_PROGRAM": str(programs / "selfproj"), "SELFPROJ_SIMULATION": str(programs / "selfproj-sim")}
