#!/usr/bin/env python3
"""Builds the documents as a site, build/site/index.html.

    build_site.py [PROGRAMS]

PROGRAMS is the folder of selfproj and selfproj-sim, build/bin unless given; the pages of the commands are made from
their help. Material for MkDocs comes from PyPI into build/mkdocs. Where it cannot be had, this says so, and the exit
status is 77. Warnings, such as of a link that leads nowhere, are errors.
"""

import os
import pathlib
import subprocess
import sys

from lib import pypi

ROOT = pathlib.Path(__file__).resolve().parents[1]
PACKAGES = ["mkdocs==1.6.1", "mkdocs-material==9.8.2"]


def main():
    programs = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/bin").resolve()
    if not (programs / "selfproj").is_file():
        print(f"build_site.py: {programs}: there is no program selfproj; run scripts/build.sh", file=sys.stderr)
        return 2
    environment = pypi.Environment(ROOT / "build/mkdocs", PACKAGES)
    if not environment.get():
        print(environment.missing())
        return pypi.UNREACHED
    done = subprocess.run([environment.bin / "mkdocs", "build", "--strict", "--quiet"], cwd=ROOT, check=False,
                          env={**os.environ, "SELFPROJ_PROGRAMS": str(programs), "NO_MKDOCS_2_WARNING": "1",
                               "PYTHONDONTWRITEBYTECODE": "1"})
    if done.returncode == 0:
        print(f"{ROOT / 'build/site/index.html'}")
    return 1 if done.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
