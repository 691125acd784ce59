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
    "a/other.cpp": "int other() { return OTHER; }\n",
    "a/asks.cpp": "#ifdef OTHER\n#endif\n",
    "a/local.cpp": "namespace {\nint three() { return 3; }\n}\n",
    "a/twin.cpp": "constexpr int kTwo = 2;\n",
    "b/three.cpp": '#include <made.h>\nint four() { return three() + 1; }\n',
    "a/one.h": '#include "b/deep.h"\n',
    "b/deep.h": "int deep();\n",
    "build/release/made/made.h": "int made();\n",
}
OPTIONS = {"a/other.cpp": "-DOTHER=1", "a/two.cpp": "-DOTHER=2 -fPIC", "b/three.cpp": "-Ib"}
# Apart because of: a macro of another value; a macro that is not there; a constant of the same name, and a function
# that would hide another.
SEPARATE = [["a/asks.cpp"], ["a/one.cpp", "a/two.cpp", "a/local.cpp"], ["a/other.cpp", "a/twin.cpp", "b/three.cpp"]]


class TidyGroups(unittest.TestCase):
    def setUp(self):
        tree = planted.tree({**SCRIPTS, **FILES})
        self.root = tree.__enter__().resolve()
        self.addCleanup(tree.__exit__, None, None, None)
        (self.root / "build/tidy/good").mkdir(parents=True)
        self.compile_with(OPTIONS)
        self.assertEqual(self.asked(), SEPARATE)
        self.pass_all()
        self.assertEqual(self.asked(), [])

    def compile_with(self, options, names=tuple(name for name in FILES if name.endswith(".cpp"))):
        commands = [
            {
                "directory": str(self.root / "build/release"),
                "file": str(self.root / name),
                "command": f"c++ -I{self.root} -Imade {options.get(name, '')} -O3 -o x.o -c {self.root / name}",
            }
            for name in names
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

    def options_of(self, number):
        """The options with which the group of that number is compiled."""
        first = self.lines().stdout.splitlines()[number].split()[0]
        commands = json.loads((self.root / "build/tidy/compile_commands.json").read_text())
        return next(entry["command"].split() for entry in commands if entry["file"] == first)

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
        self.assertEqual(self.asked(), SEPARATE)
        # A group has all that its sources need.
        self.assertTrue({"-DOTHER=1", "-Ib", "-Imade"} <= set(self.options_of(1)))
        self.assertFalse({"-fPIC", "-O3"} & set(self.options_of(0)))

    def test_the_options(self):
        self.compile_with({**OPTIONS, "a/other.cpp": "-DTHIS"})
        self.assertEqual(self.asked(), [["a/other.cpp"]])

    def test_a_change_taken_back(self):
        before = (self.root / "a/two.cpp").read_text()
        self.change("a/two.cpp")
        (self.root / "a/two.cpp").write_text(before)
        self.assertEqual(self.asked(), [])

    def test_a_source_that_is_not_compiled(self):
        result = self.lines("a/one.h")
        self.assertEqual((result.returncode, result.stderr), (1, "tidy.sh: a/one.h: the build does not compile it\n"))

    def test_sources_that_do_not_compile_together(self):
        files = {
            "host/first.cpp": "struct  Same {};\n",
            "host/second.cpp": "struct  Same {};\nint second() { return 1 - 1; }\n",
            "host/third.cpp": "int third() { int* none = 0; return none != nullptr; }\n",
            ".clang-tidy": "Checks: '-*,modernize-use-nullptr'\n",
        }
        (self.root / "host").mkdir()  # tidy.sh shows no findings in other folders than ours
        for name, text in files.items():
            (self.root / name).write_text(text)
        sources = sorted(name for name in files if name.endswith(".cpp"))
        self.compile_with(OPTIONS, sources)
        subprocess.run(["git", "init", "--quiet"], cwd=self.root, check=True)

        def tidy():
            return subprocess.run(["bash", "scripts/tidy.sh", *sources], cwd=self.root, capture_output=True, text=True,
                                  check=False)

        done = tidy()
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("second.cpp:1:9: error: redefinition of 'Same'", done.stdout)
        self.assertIn("third.cpp:1:27: error: use nullptr", done.stderr)
        # What passed alone is not asked again.
        (self.root / "host/third.cpp").write_text("int third() { return 0; }\n")
        done = tidy()
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("3 sources are clean, 2 of them checked now", done.stdout)


if __name__ == "__main__":
    unittest.main()
