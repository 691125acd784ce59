"""What comes from PyPI: packages of fixed versions in a virtual environment of their own. Standard library only."""

import pathlib
import subprocess
import venv


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

    def missing(self):
        """Says that the packages cannot be had, for tests that are skipped."""
        return f"skipped: {', '.join(self.packages)} cannot be had from PyPI"
