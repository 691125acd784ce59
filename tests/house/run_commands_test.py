#!/usr/bin/env python3
"""Planted faults: command lines that fail or name things that do not exist, with dummy programs and a dummy list of
tests."""

import pathlib
import unittest

import documents
import planted
import run_commands

PROGRAM = r"""#!/bin/bash
case "$*" in
  --help) printf '\nCommands:\n  cosim  all of it\n  scene  scenes\n' ;;
  "cosim --help") printf 'Options:\n  --count N\n  --out DIR\n' ;;
  "scene --help") printf '\nCommands:\n  list  them\n' ;;
  "scene list --help") printf 'Options:\n  --all\n' ;;
  cosim*) echo "$@" >> made ;;
  *) exit 1 ;;
esac
"""


class RunCommands(unittest.TestCase):
    def problems_of(self, text, ending=""):
        """Returns the problems of a document, and the arguments of the program's calls."""
        with planted.tree({"bin/selfproj-sim": PROGRAM}) as root:
            program = root / "bin/selfproj-sim"
            program.chmod(0o755)
            checker = run_commands.Checker(root, root, root / "bin")
            checker.tests = {"House.names": ["unit"], "Ring.Wraps": ["host"]}
            page = documents.parse("a.md", text + f"\n```sh\ntouch made; cp made {root}/made\n```\n" + ending)
            found = [*checker.problems_of_lines(page), *checker.run(page)]
            made = pathlib.Path(root / "made")
            return found, made.read_text(encoding="utf-8") if made.exists() else ""

    def expect(self, wanted, text):
        found, _ = self.problems_of(text)
        self.assertTrue(any(wanted in line for line in found), f"{wanted!r} is not in {found}")

    def test_what_is_run(self):
        found, made = self.problems_of("```sh\nselfproj-sim cosim --out a  # words\n```\n\nmore\n\n"
                                       "```sh\nbuild/bin/selfproj-sim cosim \\\n --count 2 && ctest -L unit\n"
                                       "build/bin/selfproj-sim cosim --out b\n```\n\n"
                                       "<!-- not run: builds -->\n```sh\nselfproj-sim cosim --out c\n```\n\n"
                                       "```text\nselfproj-sim cosim --out d\n```\n")
        self.assertEqual((found, made), ([], "cosim --out a\ncosim --out b\n"))

    def test_shortened(self):
        found, made = self.problems_of("<!-- run shortened: --count 3 -->\n```sh\nselfproj-sim cosim --out a\n"
                                       "selfproj-sim cosim --count 588 --out b\necho x\n```\n")
        self.assertEqual((found, made), ([], "cosim --count 3 --out a\ncosim --count 3 --out b\n"))

    def test_a_line_that_fails(self):
        self.expect("a.md:3: exit status 1 of", "\n```sh\nselfproj-sim scene lost\n```\n")
        self.expect("exit status 1 of", "```sh\nfalse | true\n```\n")
        self.expect("exit status 127 of", "```sh\nno-such-program\n```\n")
        self.expect("exit status 1 of", "```sh\necho ${unset}\n```\n")

    def test_output(self):
        text = "```sh\necho one; echo two >&2\n```\n\n<!-- output -->\n```text\n{}\n```\n"
        self.assertEqual(self.problems_of(text.format("two\none"))[0], [])
        self.expect("a.md:7: not printed: on", text.format("on"))

    def test_commands_and_options(self):
        for ending in "", "<!-- not run: builds -->":
            self.expect("has no command lost", f"{ending}\n```sh\nselfproj-sim lost\n```\n")
            self.expect("selfproj-sim cosim has no option --slow",
                        f"{ending}\n```sh\nselfproj-sim cosim --slow 3\n```\n")
        self.expect("selfproj-sim scene list has no option --out", "as `selfproj-sim scene list --out=DIR` does\n")
        self.assertEqual(self.problems_of("`selfproj-sim cosim --help`, `selfproj-sim`, `selfproj-sim COMMAND`\n")[0],
                         [])

    def test_names_of_tests(self):
        self.expect("a.md:1: no test has a name like Rung", "`ctest --preset release -R Rung`\n")
        self.expect("no test has a label like hots", "```sh\nctest -L hots\n```\n")
        self.expect("no test Ring.Wrap", "<!-- not run: builds; run by Ring.Wrap -->\n```sh\nselfproj-sim cosim\n```\n")
        self.assertEqual(self.problems_of("| `ctest -R 'Ring\\|Lost'` | `ctest -L host` |\n")[0], [])


if __name__ == "__main__":
    unittest.main()
