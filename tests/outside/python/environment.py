"""A virtual environment for the tests of the Python package: it holds the package and what it needs from PyPI."""

import os
import pathlib
import subprocess
import venv

ROOT = pathlib.Path(__file__).resolve().parents[3]
HOME = ROOT / "build" / "python-tests"
PYTHON = HOME / "bin" / "python3"
READY = HOME / "ready"  # written after a successful installation; lists the packages
PACKAGES = ["nanobind==3.1.0", "numpy==2.4.6", "scikit-build-core==1.1.2"]


def pip(*words):
    return subprocess.run([PYTHON, "-m", "pip", "--quiet", "--disable-pip-version-check", "install", *map(str, words)],
                          capture_output=True, text=True, check=False)


def get():
    """Creates the environment with PACKAGES, unless it exists with just these. Returns False if PyPI or venv fails."""
    if READY.exists() and READY.read_text(encoding="utf-8") == "\n".join(PACKAGES):
        return True
    try:
        venv.create(HOME, with_pip=True, clear=True)
    except subprocess.CalledProcessError:
        return False
    if pip("--only-binary", ":all:", "--retries", "1", *PACKAGES).returncode:
        return False
    READY.write_text("\n".join(PACKAGES), encoding="utf-8")
    return True


def install(build):
    """Installs selfproj with the libraries of a build. Returns pip's output if it failed, otherwise an empty string."""
    done = pip("--no-build-isolation", "--no-deps", "--no-index", "--config-settings",
               f"cmake.define.SELFPROJ_BUILT={build}", ROOT)
    return done.stdout + done.stderr if done.returncode else ""


def variables(build, programs):
    """Returns the environment variables for the tests."""
    return {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "SELFPROJ_C_LIBRARY": str(build / "capi" / "libselfproj.so"),
            "SELFPROJ_PROGRAM": str(programs / "selfproj"), "SELFPROJ_SIMULATION": str(programs / "selfproj-sim")}
