"""A virtual environment for the tests of the Python package: it holds the package and what it needs from PyPI."""

import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import pypi  # noqa: E402

PACKAGE = pypi.Environment(ROOT / "build" / "python-tests",
                           ["nanobind==3.1.0", "numpy==2.4.6", "scikit-build-core==1.1.2"], "--only-binary", ":all:")


def install(build):
    """Installs selfproj with the libraries of a build. Returns pip's output if it failed, otherwise an empty string."""
    done = PACKAGE.pip("--no-build-isolation", "--no-deps", "--no-index", "--config-settings",
                       f"cmake.define.SELFPROJ_BUILT={build}", ROOT)
    return done.stdout + done.stderr if done.returncode else ""


def variables(build, programs):
    """Returns the environment variables for the tests."""
    return {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "SELFPROJ_C_LIBRARY": str(build / "capi" / "libselfproj.so"),
            "SELFPROJ_PROGRAM": str(programs / "selfproj"), "SELFPROJ_SIMULATION": str(programs / "selfproj-sim")}
