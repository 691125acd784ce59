#!/usr/bin/env python3
"""Tests that scripts/tidy_groups.py leaves out sources that passed until something changes that their result depends
on."""

import json
import pathlib
import subprocess
import sys
import unittest

import planted

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = {f"scripts/{name}": (ROOT / "scripts" / name).read_text() for name in ("tidy.sh", "tidy_groups.py")}
FILES = {
    ".clang-tidy": "Checks: bugprone-*\n",
    "a/one.cpp": '#include "a/one.h"\n',
    "a/two.cpp": "constexpr int kTwo = 2;\nint two();\n",
    "a/other.cpp": "int other();\n",
    "a/twin.cpp": "constexpr int kTwo = 2;\n",
    "b/three.cpp": '#include <made.h>\n',
    "a/one.h": '#include "b/deep.h"\n',
    "b/deep.h": "int deep();\n",
    "build/release/made/made.h": "int made();\n",
}
OPTIONS = {"a/other.cpp": "-DOTHER"}


class TidyGroups(unittest.TestCase):
    def setUp(self):
        tree = planted.tree({**SCRIPTS, **FILES})
        self.root = tree.__enter__().resolve()
        self.addCleanup(tree.__exit__, None, None, None)
        (self.root / "build/tidy/good").mkdir(parents=True)
        self.compile_with(OPTIONS)
        self.assertEqual(self.asked(), [["a/one.cpp", "a/two.cpp"], ["a/other.cpp"], ["a/twin.cpp"], ["b/three.cpp"]])
        self.pass_all()
        self.assertEqual(self.asked(), [])

    def compile_with(self, options):
        commands = [
            {
                "directory": str(self.root / "build/release"),
                "file": str(self.root / name),
                "command": f"c++ -I{self.root} -Imade {options.get(name, '')} -O3 -o x.o -c {self.root / name}",
            }
            for name in FILES if name.endswith(".cpp")
        ]
        (self.root / "build/release/compile_commands.json").write_text(json.dumps(commands))

    def lines(self, *names):
        sources = names or [name for name in FILES if name.endswith(".cpp")]
        return subprocess.run(
            [sys.executable, "scripts/tidy_groups.py", "build/release", "build/tidy", *sources],
            cwd=self.root, capture_output=True, text=True, check=False,
        )

    def parts(self):
        lines = self.lines().stdout.splitlines()
        self.assertEqual(lines.pop(), "end")
        return [[part.split(":") for part in line.split()[1:]] for line in lines]

    def asked(self):
        """The groups of sources to check."""
        groups = ([pathlib.Path(source) for _, source in group] for group in self.parts())
        return sorted([str(source.relative_to(self.root)) for source in group] for group in groups)

    def pass_all(self):
        for group in self.parts():
            for state, _ in group:
                (self.root / "build/tidy/good" / state).touch()

    def change(self, name):
        with open(self.root / name, "a", encoding="utf-8") as file:
            file.write("// changed\n")

    def test_a_source(self):
        self.change("a/two.cpp")
        self.assertEqual(self.asked(), [["a/two.cpp"]])

    def test_a_header_of_a_header(self):
        self.change("b/deep.h")
        self.assertEqual(self.asked(), [["a/one.cpp"]])

    def test_a_generated_header(self):
        self.change("build/release/made/made.h")
        self.assertEqual(self.asked(), [["b/three.cpp"]])

    def test_the_settings(self):
        self.change(".clang-tidy")
        self.assertEqual(len(self.asked()), 4)

    def test_the_options(self):
        self.compile_with({"a/other.cpp": "-DTHIS"})
        self.assertEqual(self.asked(), [["a/other.cpp"]])

    def test_a_change_taken_back(self):
        before = (self.root / "a/two.cpp").read_text()
        self.change("a/two.cpp")
        (self.root / "a/two.cpp").write_text(before)
        self.assertEqual(self.asked(), [])

    def test_a_source_that_is_not_compiled(self):
        result = self.lines("a/one.h")
        self.assertEqual((result.returncode, result.stderr), (1, "tidy.sh: a/one.h: the build does not compile it\n"))


if __name__ == "__main__":
    unittest.main()
