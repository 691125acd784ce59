#!/usr/bin/env python3
"""Tests the help of every command: it is complete, in plain words, and has examples that the program accepts.

    help_test.py PROGRAMS

PROGRAMS is the folder of selfproj and selfproj-sim. The lines of the examples are read by the programs here
(--check-usage); the test Documents.commands runs them from the pages of the commands.
"""

import pathlib
import re
import shlex
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "docs/site"))
import commands  # noqa: E402

WIDTH = 100
RAW = re.compile(r"\b(ENUM|TEXT|UINT|INT|FLOAT|BOOLEAN|VECTOR|POSITIVE|NONNEGATIVE|REQUIRED|OPTIONS|SUBCOMMANDS?"
                 r"|TypeName)\b"
                 r"|\.{4}|value in|INT in|Needs:|Excludes:|\[Option Group|PATH\(|:\{|\{[a-z0-9-]+(,[a-z0-9-]+)+\}")
programs = pathlib.Path()


def run(words):
    done = subprocess.run([str(programs / words[0]), *words[1:]], capture_output=True, text=True, timeout=60,
                          stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout, done.stderr


def lines_of(script):
    return [line for line in re.sub(r"\\\n\s*", "", script).splitlines() if line.strip() and not line.startswith("#")]


class Help(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.commands = commands.describe(programs)

    def test_commands_are_all_there(self):
        for name in ("selfproj inspect", "selfproj pattern gray", "selfproj-sim cosim", "selfproj-sim scene render"):
            self.assertIn(name, self.commands)

    def test_help_is_in_plain_words(self):
        for name, command in self.commands.items():
            with self.subTest(name):
                status, text, errors = run([*name.split(), "--help"])
                self.assertEqual((status, errors), (0, ""))
                self.assertTrue(text.startswith(command["purpose"].split()[0]), text[:80])
                self.assertIn(f"Usage: {name}", text)
                self.assertIn("\nExamples:\n", text)
                self.assertIsNone(RAW.search(text), RAW.search(text))
                for line in text.splitlines():
                    self.assertLessEqual(len(line), WIDTH, line)

    def test_programs_start_without_the_image_codecs(self):
        for program in commands.PROGRAMS:
            needed = subprocess.run(["ldd", str(programs / program)], capture_output=True, text=True, check=True).stdout
            self.assertIn("libopencv_core", needed)
            self.assertNotRegex(needed, "libopencv_imgcodecs|libgdal")

    def test_every_option_is_explained(self):
        for name, command in self.commands.items():
            for option in command["arguments"] + [one for group in command["groups"] for one in group["options"]]:
                with self.subTest(f"{name} {option['name']}"):
                    self.assertRegex(option["text"], r"^[A-Z0-9a-z].*\.$")
                    if option["value"]:
                        self.assertRegex(option["value"], r"^[A-Za-z0-9.,|+]+$")

    def test_numbers_have_units_or_ranges(self):
        for name, command in self.commands.items():
            for option in (one for group in command["groups"] for one in group["options"]):
                if option["value"] in ("MM", "PX", "DEG", "HZ", "S", "FPS", "PERCENT", "T", "N", "M", "K", "E"):
                    self.assertNotEqual(option["limits"], "", f"{name} {option['name']}")

    def test_examples_are_valid_command_lines(self):
        for name, command in self.commands.items():
            lines = lines_of(command["examples"])
            self.assertTrue(any(line.startswith(name) for line in lines), f"{name} has no example of its own")
            for line in lines:
                words = shlex.split(line, comments=True)
                for mark in (">", "&"):
                    words = words[:words.index(mark)] if mark in words else words
                if words[0] in commands.PROGRAMS:
                    with self.subTest(line):
                        self.assertEqual(run([words[0], "--check-usage", *words[1:]]), (0, "", ""))

    def test_check_usage_refuses_what_the_program_refuses(self):
        status, _, errors = run(["selfproj", "--check-usage", "depth", "--bits", "99", "--out", "x"])
        self.assertEqual(status, 2)
        self.assertEqual(errors, "selfproj: --bits: is '99'; a whole number from 1 to 12 is expected\n")

    def test_bad_usage_is_said_in_plain_words(self):
        cases = {
            "": "a command is missing; see selfproj --help",
            "bogus": "bogus: unknown command; see selfproj --help",
            "rig a b": "b: unexpected argument; see selfproj rig --help",
            "depth --bogus": "--bogus: unknown option; see selfproj depth --help",
            "depth --bits": "--bits: a value is missing; see selfproj depth --help",
            "depth --rig scanner --out x": "--bits: is required; see selfproj depth --help",
            "depth --bits 1.5": "--bits: is '1.5'; a whole number from 1 to 12 is expected",
            "depth --bits 4 --count -1": "--count: is '-1'; a whole number of 1 or more is expected",
            "depth --bits 4 --max-residual 0": "--max-residual: is '0'; a number above 0, at most 1e6 is expected",
            "depth --bits 4 --max-z nan": "--max-z: is 'nan'; a number from -1e6 to 1e6 is expected",
            "calibrate --corners best": "--corners: is 'best'; homography or direct is expected",
            "inspect --device ring:x --check=3": "--check: takes no value; see selfproj inspect --help",
            "inspect --device ring:x --check=never": "--check: takes no value; see selfproj inspect --help",
            "pattern --line 3 --sweep": "--line: cannot be combined with --sweep",
            "pattern --frame 3": "--frame: goes only with --reference",
        }
        for line, expected in cases.items():
            with self.subTest(line):
                self.assertEqual(run(["selfproj", *line.split()]), (2, "", f"selfproj: {expected}\n"))

    def test_no_error_shows_the_librarys_text(self):
        for name, command in self.commands.items():
            for group in command["groups"]:
                for option in group["options"]:
                    words = [*name.split(), option["name"].split(",")[-1].split()[0]]
                    if option["value"]:
                        words.append("\u221e")
                    if group["name"] == "Help":
                        continue
                    with self.subTest(" ".join(words)):
                        status, _, errors = run([words[0], "--check-usage", *words[1:]])
                        self.assertIn(status, (0, 2))
                        self.assertLessEqual(errors.count("\n"), 1)
                        self.assertIsNone(RAW.search(errors), errors)
                        self.assertNotRegex(errors, r"not in|Could not convert|were not expected|excludes|requires")


if __name__ == "__main__":
    programs = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=1)
