"""Steps at a simulated ECPIX-5, for the tests beside this file: scripts/target_sim.sh runs them by bash.

On a busy machine the simulation may have to wait in the middle of a packet, for longer than a host waits for the rest
of it. The steps say so as a loss; they have three tries. SELFPROJ_PROGRAMS and SELFPROJ_JUDGE name the programs, as in
target_sim.sh. Standard library only.
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
    """Runs the steps in the folder, with the judges in the path. Returns the exit status."""
    path = f"{pathlib.Path(os.environ['SELFPROJ_JUDGE']).parent}:{os.environ['PATH']}"
    return subprocess.run([ROOT / "scripts/target_sim.sh", "--", "bash", "-euxo", "pipefail", "-c", steps], cwd=folder,
                          env={**os.environ, "PATH": path}, check=False).returncode


def run(steps, wrong_in):
    """Runs the steps in empty folders until a try is good, and ends the program with the status of the last one.

    `wrong_in` says what is wrong in a folder that they have left, or nothing."""
    for left in reversed(range(TRIES)):
        with tempfile.TemporaryDirectory(prefix="target-steps.") as folder:
            status = status_of(steps, folder)
            wrong = "a step has failed" if status else wrong_in(pathlib.Path(folder))
        if not wrong or status == UNREACHED:
            sys.exit(status)
        print(f"{pathlib.Path(sys.argv[0]).name}: {wrong}; tries left: {left}", file=sys.stderr)
    sys.exit(1)
