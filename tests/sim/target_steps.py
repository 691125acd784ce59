"""Runs steps on a simulated ECPIX-5 for the tests in this folder: scripts/target_sim.sh runs them in bash.

On a busy machine the simulation may have to wait in the middle of a packet, for longer than a host waits for the rest
of it. The steps then report a loss, so they have three tries. SELFPROJ_PROGRAMS and SELFPROJ_JUDGE name the programs,
as for target_sim.sh. Standard library only.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TRIES = 3
UNREACHED = 77  # target_sim.sh cannot run


def status_of(steps, folder):
    """Runs the steps in the folder, with the folder of SELFPROJ_JUDGE in PATH. Returns the exit status."""
    path = f"{pathlib.Path(os.environ['SELFPROJ_JUDGE']).parent}:{os.environ['PATH']}"
    return subprocess.run([ROOT / "scripts/target_sim.sh", "--", "bash", "-euxo", "pipefail", "-c", steps], cwd=folder,
                          env={**os.environ, "PATH": path}, check=False).returncode


def run(steps, wrong_in):
    """Runs the steps in empty folders until a try is good, and ends the program with the status of the last try.

    `wrong_in` looks at a folder in which they ran, and returns what is wrong there, or an empty text."""
    for left in reversed(range(TRIES)):
        with tempfile.TemporaryDirectory(prefix="target-steps.") as folder:
            status = status_of(steps, folder)
            wrong = "a step has failed" if status else wrong_in(pathlib.Path(folder))
        if not wrong or status == UNREACHED:
            sys.exit(status)
        print(f"{pathlib.Path(sys.argv[0]).name}: {wrong}; tries left: {left}", file=sys.stderr)
    sys.exit(1)
