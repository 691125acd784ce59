#!/usr/bin/env python3
"""Tests the programs that scripts/demo.sh builds: they accept its command lines, have no other commands, and refuse
the circuits that they do not have.

    demo_test.py PROGRAMS

PROGRAMS is the folder of the demo's selfproj and selfproj-sim.
"""

import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

DEMO = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "demo.sh"
programs = pathlib.Path()


def command_lines():
    """Returns the command lines of the demo that run its programs. Each is a list of words; the folder of the program
    is left out."""
    text = re.sub(r"\\\n\s*", "", DEMO.read_text(encoding="utf-8"))
    found = []
    for line in re.findall(r'^\s*"\$programs"/(.*)', text, re.MULTILINE):
        words = shlex.split(re.split(r" >| \|\|", line)[0])
        found.append([{"$seconds": "20", "$port": "8080"}.get(word, word) for word in words])
    return found


class Demo(unittest.TestCase):
    def test_command_lines_of_the_demo_are_accepted(self):
        lines = command_lines()
        self.assertEqual({tuple(words[:2]) for words in lines},
                         {("selfproj-sim", "cosim"), ("selfproj-sim", "board"), ("selfproj-sim", "production"),
                          ("selfproj", "tolerance"), ("selfproj", "inspect")})
        for words in lines:
            done = subprocess.run([programs / words[0], "--check-usage", *words[1:]], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), words)

    def test_examples_of_the_help_are_accepted(self):
        for program in ("selfproj", "selfproj-sim"):
            done = subprocess.run([programs / program, "--help"], capture_output=True, text=True, check=True)
            text = re.sub(r"\\\n\s*", "", done.stdout)
            examples = re.findall(rf"^  {program} .+$", text, re.MULTILINE)
            self.assertTrue(examples)
            for example in examples:
                words = shlex.split(example)
                done = subprocess.run([programs / program, "--check-usage", *words[1:]], capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stderr), (0, ""), example)

    def test_programs_have_only_the_commands_of_the_demo(self):
        for program in ("selfproj", "selfproj-sim"):
            done = subprocess.run([programs / program, "--help"], capture_output=True, text=True, check=True)
            listed = re.findall(r"^  ([a-z][\w-]*)  ", done.stdout.split("\nCommands:\n")[1], re.MULTILINE)
            used = {words[1] for words in command_lines() if words[0] == program}
            self.assertEqual(set(listed), used)

    def test_other_circuits_are_refused(self):
        for words in (["--engine", "hls"], ["--trace", "board.fst"], ["--scene", "fist"],
                      ["--select", "strongest"]):
            with tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([programs / "selfproj-sim", "cosim", "--count", "40", *words], cwd=folder,
                                      capture_output=True, text=True)
                self.assertEqual(list(pathlib.Path(folder).iterdir()), [], words)
            self.assertEqual(done.returncode, 2, words)
            self.assertRegex(done.stderr, r"^selfproj-sim: .*: not part of the demo's program; .*\n$")


if __name__ == "__main__":
    programs = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
