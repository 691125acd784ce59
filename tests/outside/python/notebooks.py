"""Runs the notebooks of python/notebooks: their cells one after another, in one namespace, by plain Python.

    notebooks.py NAME...     runs them in a folder of their own, and says how long each took; exit status 1 where one took
                             more than a minute of processor time
"""

import contextlib
import io
import json
import pathlib
import sys
import tempfile
import time

MOST_SECONDS = 60
FOLDER = pathlib.Path(__file__).resolve().parents[3] / "python" / "notebooks"


def run(name, folder):
    """Runs a notebook in the folder; what its last lines show is made, too. Returns its names."""
    cells = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    names = {}
    with contextlib.chdir(folder) if hasattr(contextlib, "chdir") else _inside(folder):
        for number, cell in enumerate(cells):
            if cell["cell_type"] != "code":
                continue
            assert not cell["outputs"], f"{name}: cell {number} has outputs; clear them before it is committed"
            text = "".join(cell["source"])
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(text, f"{name}.ipynb, cell {number}", "exec"), names)  # pylint: disable=exec-used
            last = text.rsplit("\n", 1)[-1]
            if last.isidentifier() or last.endswith("]"):  # a notebook shows it
                shown = eval(last, names)  # pylint: disable=eval-used
                if hasattr(shown, "_repr_html_"):
                    assert "<" in shown._repr_html_(), last
    return names


@contextlib.contextmanager
def _inside(folder):
    import os  # Python 3.10 has no contextlib.chdir
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


if __name__ == "__main__":
    for word in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as made:
            begin, core = time.monotonic(), time.process_time()
            run(word, made)
            core = time.process_time() - core
            print(f"{word}: {time.monotonic() - begin:.1f} s, {core:.1f} s of a processor core, Python "
                  f"{sys.version_info.major}.{sys.version_info.minor}", flush=True)
            if core > MOST_SECONDS:
                sys.exit(f"{word}: takes more than {MOST_SECONDS} s")
