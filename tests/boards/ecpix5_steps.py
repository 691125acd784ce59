"""Runs steps on a simulated ECPIX-5 for the tests in this folder: constraints/ecpix5/simulate.sh runs them in bash.

On a busy machine the simulation may have to wait in the middle of a packet, for longer than a host waits for the rest
of it. The steps then report a loss, so they have three tries. SELFPROJ_PROGRAMS and SELFPROJ_BUILD name the programs,
as for simulate.sh. Standard library only.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TRIES = 3
UNREACHED = 77  # simulate.sh cannot run


def status_of(steps, folder):
    """Runs the steps in the folder, with compare_packets in PATH. Returns the exit status."""
    path = f"{os.environ['SELFPROJ_BUILD']}/constraints:{os.environ['PATH']}"
    return subprocess.run([ROOT / "constraints/ecpix5/simulate.sh", "--", "bash", "-euxo", "pipefail", "-c", steps],
                          cwd=folder, env={**os.environ, "PATH": path}, check=False).returncode


def run(steps, wrong_in):
    """Runs the steps in empty folders until a try is good, and ends the program with the status of the last try.

    `wrong_in` looks at a folder in which they ran, and returns what is wrong there, or an empty text."""
    for left in reversed(range(TRIES)):
        with tempfile.TemporaryDirectory(prefix="ecpix5-steps.") as folder:
            status = status_of(steps, folder)
            wrong = "a step has failed" if status else wrong_in(pathlib.Path(folder))
        if not wrong or status == UNREACHED:
            sys.exit(status)
        print(f"{pathlib.Path(sys.argv[0]).name}: {wrong}; tries left: {left}", file=sys.stderr)
    sys.exit(1)
