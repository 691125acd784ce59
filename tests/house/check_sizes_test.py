#!/usr/bin/env python3
"""Planted faults: files and functions that are one line too long, in a tree of its own."""

import pathlib
import subprocess
import tempfile
import unittest

import check_sizes


def body(lines, indent=2):
    return "".join(" " * indent + f"work({i});\n" for i in range(lines))


def problems_of(**files):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        subprocess.run(["git", "init", "-q", folder], check=True)
        for name, text in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        return check_sizes.problems(root)


class CheckSizes(unittest.TestCase):
    def expect(self, wanted, name, text):
        found = problems_of(**{name: text})
        self.assertEqual([line.split(": ", 1)[1] for line in found], wanted)

    def test_files(self):
        self.expect([], "rtl/a.sv", "x\n" * 450)
        self.expect(["451 lines, 450 at most"], "rtl/a.sv", "x\n" * 451)
        self.expect([], "model/generated/a.h", "x\n" * 451)

    def test_functions(self):
        self.expect([], "a.cpp", "void f() {\n" + body(78) + "}\n")
        self.expect(["f has 81 lines, 80 at most"], "a.cpp", "void f() {\n" + body(79) + "}\n")

    def test_a_head_of_several_lines_counts(self):
        self.expect(["Thing::f has 82 lines, 80 at most"], "a.cpp",
                    "int g;\nint Thing::f(int a,\n             int b) const {\n" + body(79) + "}\n")

    def test_methods_in_a_class(self):
        self.expect(["g has 81 lines, 80 at most"], "a.h",
                    "struct A final : B {\n  void g() const {\n" + body(79, 4) + "  }\n};\n")

    def test_a_lambda_within_does_not_end_it(self):
        self.expect(["f has 84 lines, 80 at most"], "a.cpp",
                    "void f() {\n  const auto g = [&] {\n    work();\n  };\n" + body(79) + "}\n")

    def test_long_classes_and_tables_are_no_functions(self):
        self.expect([], "a.h", "class A {\n" + body(100) + "};\nconstexpr int kTable[] = {\n" + body(100) + "};\n")
        self.expect([], "a.cpp", "void add_depth_command(CLI::App& app) {\n" + body(100) + "}\n")

    def test_python(self):
        self.expect(["f has 81 lines, 80 at most"], "a.py", "def f():\n" + "    pass\n" * 80)


if __name__ == "__main__":
    unittest.main()
