#!/usr/bin/env python3
"""Tests scripts/results.py: its output, and planted faults in a small tree."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import results  # noqa: E402

SCRIPT = pathlib.Path(results.__file__)
SPEED = {"about": "Speed", "command": "bench_speed", "date": "2026-01-02", "commit": "0123456789",
         "machine": {"cpu": "A", "cores": 2, "memory_gib": 8.0, "load": 0.5},
         "results": {"per_s": 38834.2, "share": 0.541, "steps": [{"name": "a|b", "ms": 0.25}],
                     "by": {"x": {"n": 12345}}, "printed": {"header": ["", "mm"], "rows": [["height, RMS", "0.015"]]}}}
TABLES = """
[speed]
columns = ["what", "goal", "result", "met", "command"]
rows = [
  {id = "decode", what = "decode", goal = "{speed/per_s >= 30,000} a second", result = "{speed/per_s:,.0f}"},
  {id = "share", what = "share", goal = "{speed/share >= 60 %}", result = "{speed/share:.0%}"},
]
[status]
columns = ["what", "met"]
rows = ["share"]
[steps]
each = "speed/steps"
columns = {step = "{/name}", ms = "{/ms:.2f}"}
[by]
each = "speed/by"
columns = {"" = "`{@}`", n = "{/n:,}"}
"""
GOOD = ("# Speed\n<!-- table speed -->\n<!-- end -->\n"
        "It is <!-- =speed/share:.1% -->?<!-- end -->, see `<!-- table x -->`.\n"
        "<!-- table status -->\n<!-- end -->\n<!-- table steps -->\n<!-- end -->\n<!-- table by -->\n<!-- end -->\n")
FILLED = """# Speed
<!-- table speed -->
| what | goal | measured | met | by |
|---|---|---|---|---|
| decode | ≥ 30,000 a second | 38,834 | yes | `bench_speed` |
| share | ≥ 60 % | 54 % | **no** | `bench_speed` |
<!-- end -->
It is <!-- =speed/share:.1% -->54.1 %<!-- end -->, see `<!-- table x -->`.
<!-- table status -->
| what | met |
|---|---|
| share | **no** |
<!-- end -->
<!-- table steps -->
| step | ms |
|---|---|
| a\\|b | 0.25 |
<!-- end -->
<!-- table by -->
|  | n |
|---|---|
| `x` | 12,345 |
<!-- end -->
"""


class Tree:
    """A git repository with one document and results, in a temporary folder."""

    def __init__(self, document=GOOD, tables=TABLES, speed=SPEED):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        subprocess.run(["git", "init", "-q", self.root], check=True)
        (self.root / "results").mkdir()
        text = json.dumps(speed) if isinstance(speed, dict) else speed
        (self.root / "results/speed.json").write_text(text, encoding="utf-8")
        (self.root / "results/tables.toml").write_text(tables, encoding="utf-8")
        self.document = self.root / "README.md"
        self.document.write_text(document, encoding="utf-8")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.folder.cleanup()


class Documents(unittest.TestCase):
    def test_update_fills_and_check_agrees(self):
        with Tree() as tree:
            self.assertEqual(len(results.faults(tree.root)), 1)
            results.update(tree.root)
            self.assertEqual(tree.document.read_text(encoding="utf-8"), FILLED)
            self.assertEqual(results.faults(tree.root), [])

    def test_drift_is_found(self):
        for old, new in (("38,834 |", "38,835 |"), ("54.1 %", "54.2 %"), ("| share | **no** |\n<!--", "<!--"),
                         ("| 0.25", "| 0.26")):
            with Tree(FILLED.replace(old, new)) as tree:
                self.assertIn("not what results/ says", "".join(results.faults(tree.root)), new)
        with Tree(FILLED, speed={**SPEED, "results": {**SPEED["results"], "per_s": 29999}}) as tree:
            self.assertEqual(results.faults(tree.root),
                             ["README.md:5: not what results/ says; run scripts/results.py update"])

    def test_a_figure_typed_again_is_found(self):
        for text in ("38,834 a second", "(38,834)", "| 38,834 |", "or 12,345."):
            with Tree(FILLED + text + "\n") as tree:
                self.assertIn("is typed; it is a figure of results/", "".join(results.faults(tree.root)), text)
        for text in ("138,834", "38,834.5", "v38,834", "1,38,834", "54.1 %"):
            with Tree(FILLED + text + "\n") as tree:
                self.assertEqual(results.faults(tree.root), [], text)

    def test_documents_that_still_have_typed_figures(self):
        listed = 'still_typed = ["README.md"]\n' + TABLES
        with Tree(FILLED + "38,834\n", tables=listed) as tree:
            self.assertEqual(results.faults(tree.root), [])
        self.expect("README.md has no figure of results/ any more", document=FILLED, tables=listed)
        self.expect("still_typed: there is no docs/a.md", document=FILLED,
                    tables=listed.replace("README.md", "docs/a.md"))

    def expect(self, message, **tree_of):
        with Tree(**tree_of) as tree:
            try:
                found = "".join(results.faults(tree.root))
            except results.ResultsError as error:
                found = str(error)
            self.assertIn(message, found)

    def test_markers(self):
        self.expect("no table none", document="<!-- table none -->\n<!-- end -->\n")
        self.expect("README.md: 2: <!-- table speed --> without its <!-- end -->",
                    document="\n<!-- table speed -->\n| a |\n")
        self.expect("without its", document="a <!-- =speed/share:.0% -->54 %\n")
        self.expect("there is no results/quick.json", document="<!-- =quick/share -->1<!-- end -->\n")
        self.expect("speed/none: there is no none", document="<!-- =speed/none -->1<!-- end -->\n")

    def test_results_and_tables(self):
        self.expect("without commit", speed={key: value for key, value in SPEED.items() if key != "commit"})
        self.expect("results/speed.json: ", speed="{")
        self.expect("results/tables.toml: ", tables="[speed\n")
        self.expect("speed/gone: there is no gone", tables=TABLES.replace("{speed/share:.0%}", "{speed/gone}"))
        self.expect("not to be shown as :s", tables=TABLES.replace("{speed/share:.0%}", "{speed/share:s}"))

    def test_goals(self):
        with Tree() as tree:
            cells = results.Tables(tree.root).cells
            for text, met in (("{speed/share >= 54.1 %}", "yes"), ("{speed/share >= 54.2 %}", "**no**"),
                              ("{speed/share <= 1}", "yes"), ("{speed/printed/height, RMS/mm <= 0.015}", "yes"),
                              ("{speed/printed/height, RMS/mm <= 0.014}", "**no**"),
                              ("{speed/per_s == 38834.2}", "yes"), ("{speed/per_s == 0}", "**no**"), ("none", "–"),
                              ("{speed/share <= 1}, {speed/per_s <= 38,000}", "**no**")):
                self.assertEqual(cells.met(text), met, text)
            self.assertEqual(cells.fill("{speed/per_s:M.3f} {speed/per_s == 0}"), "0.039 0")


class Writing(unittest.TestCase):
    def test_envelope(self):
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, {results.VARIABLE: folder}):
            results.write("one", "What", "how", {"n": 1})
            file = json.loads((pathlib.Path(folder) / "one.json").read_text(encoding="utf-8"))
            self.assertEqual(list(file), results.ENVELOPE)
            self.assertEqual((file["about"], file["command"], file["results"]), ("What", "how", {"n": 1}))
            self.assertRegex(file["date"], r"^\d{4}-\d\d-\d\d$")
            self.assertEqual(list(file["machine"]), ["cpu", "cores", "memory_gib", "load"])

    def test_nothing_without_the_variable(self):
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, {results.VARIABLE: ""}):
            os.chdir(folder)
            results.write("one", "What", "how", {})
            self.assertEqual(os.listdir(folder), [])
            os.chdir("/")

    def test_record(self):
        with tempfile.TemporaryDirectory() as folder:
            def record(*values):
                return subprocess.run([sys.executable, "-B", SCRIPT, "record", "two", "--about", "A", "--command", "c",
                                       *values], env={**os.environ, results.VARIABLE: folder}, capture_output=True,
                                      text=True, check=False)

            self.assertEqual(record("a=1", "b/c=2.5", "b/d=x y").returncode, 0)
            file = json.loads((pathlib.Path(folder) / "two.json").read_text(encoding="utf-8"))
            self.assertEqual(file["results"], {"a": 1, "b": {"c": 2.5, "d": "x y"}})
            said = record("a")
            self.assertEqual(said.returncode, 2)
            self.assertEqual(said.stderr, "results.py: a: not KEY=VALUE\n")


if __name__ == "__main__":
    unittest.main()
