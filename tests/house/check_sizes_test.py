#!/usr/bin/env python3
"""Planted faults: files and functions that are one line too long, in a small tree."""

import unittest

import check_sizes
import planted


def body(lines, indent=2):
    return "".join(" " * indent + f"work({i});\n" for i in range(lines))


def problems_of(**files):
    with planted.tree(files) as root:
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

    def test_the_front_page(self):
        self.expect([], "README.md", "ab\n" * 2048)
        self.expect(["6145 bytes, 6144 at most"], "README.md", "ab\n" * 2048 + "\n")
        self.expect([], "host/README.md", "ab\n" * 3000)

    def test_lines(self):
        self.expect([], "a.cpp", "/" * 118 + " a\n")
        self.expect(["121 characters, 120 at most"], "a.cpp", "/" * 119 + " a\n")
        self.expect(["101 characters, 100 at most"], "rtl/a.sv", "/" * 99 + " a\n")
        self.expect([], "a.cpp", "ä" * 118 + " a\n")

    def test_lines_that_cannot_be_wrapped(self):
        self.expect([], "a.md", "| a | " + "b" * 120 + " |\n")
        self.expect([], "a.md", "  [a](" + "b" * 120 + ")\n")
        self.expect(["125 characters, 120 at most"], "a.md", "a [a](" + "b" * 118 + ")\n")
        self.expect([], "a.md", "<!-- BEGIN GENERATED x -->\n" + "a " * 70 + "\n<!-- END GENERATED x -->\n")
        self.expect(["140 characters, 120 at most"], "a.md",
                    "<!-- BEGIN GENERATED x -->\n<!-- END GENERATED x -->\n" + "a " * 70 + "\n")
        self.expect([], "a.json", '{"a": "' + "b " * 70 + '"}\n')


if __name__ == "__main__":
    unittest.main()
