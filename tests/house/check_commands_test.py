#!/usr/bin/env python3
"""Planted faults: command lines that nothing runs, and comments without a reason, in a small tree."""

import unittest

import check_commands
import documents
import planted

GOOD = {
    "README.md": "# Title\n\n```sh\nselfproj rig\nbuild/bin/selfproj-sim cosim --count 3 | tail -1\n"
                 "ctest --preset release\n```\n\n"
                 "<!-- run shortened: --count 20 -->\n```sh\nselfproj-sim cosim\n```\n\n"
                 "<!-- not run: takes minutes; run by House.names -->\n"
                 "```sh\nscripts/demo.sh --quick  # all of it\n```\n\n"
                 "Inline: `scripts/demo.sh --quick`, `scripts/`, `cmake --preset PRESET`.\n\n```text\nmatched\n```\n",
    "scripts/demo.sh": "case $1 in --quick) ;; esac\n",
    "CMakePresets.json": '{"configurePresets": [{"name": "release"}]}',
}


def block(text, comment="", language="sh"):
    return f"{comment}\n```{language}\n{text}\n```\n"


class CheckCommands(unittest.TestCase):
    def problems_of(self, **changes):
        with planted.tree({**GOOD, **changes}) as root:
            return check_commands.problems(root)

    def expect(self, wanted, text):
        found = self.problems_of(**{"a.md": text})
        self.assertEqual(len(found), 1, found)
        self.assertIn(wanted, found[0])

    def test_a_good_tree(self):
        self.assertEqual(self.problems_of(), [])

    def test_command_lines_outside_blocks_sh(self):
        self.expect("a.md:1: a command line outside", "    selfproj rig\n")
        self.expect("a.md:3: a command line outside", block("scripts/demo.sh", language="text"))

    def test_languages(self):
        self.expect("a.md:3: the block names no language", block("x = 1", language=""))
        self.expect("a.md:3: the block names no language", block("x = 1", language="bash"))
        self.expect("a.md:1: nothing closes this block", "```text\nx\n")

    def test_reasons(self):
        self.expect("'it is slow' is none of the reasons", block("selfproj rig", "<!-- not run: it is slow -->"))
        self.expect("'a b' is not the name", block("selfproj rig", "<!-- not run: takes minutes; run by a b -->"))
        self.expect("'count 3' is not one option", block("selfproj rig", "<!-- run shortened: count 3 -->"))
        self.expect("more than one comment",
                    block("selfproj rig", "<!-- not run: builds -->\n<!-- run shortened: --count 3 -->"))
        self.expect("what is no block `sh`", block("x", "<!-- not run: builds -->", "text"))
        self.expect("what is printed is a block `text`", block("selfproj rig", "<!-- output -->"))
        self.expect("'of x' after output", block("x", "<!-- output: of x -->", "text"))
        self.assertEqual(self.problems_of(**{"a.md": block("x", "<!-- output -->", "text")}), [])

    def test_a_comment_holds_for_the_next_block_alone(self):
        text = block("scripts/demo.sh", "<!-- not run: builds -->\n\nmore words\n")
        self.expect("the block needs a comment", text)

    def test_scripts(self):
        self.expect("scripts/demo.sh is not run by run_commands.py", block("cd x && scripts/demo.sh"))
        self.expect("no file scripts/gone.sh", block("scripts/gone.sh", "<!-- not run: builds -->"))
        self.expect("scripts/demo.sh has no option --slow", block("scripts/demo.sh --slow", "<!-- not run: builds -->"))
        self.expect("a.md:2: no file scripts/gone.sh", "\nas `scripts/gone.sh` does\n")

    def test_presets(self):
        self.expect("no preset fast", block("cmake --preset fast"))
        self.expect("no preset fast", block("ctest --preset fast -L unit"))

    def test_simple_commands(self):
        for line, commands in [
                ("A=1 a b | c > d 2>&1 && e # f", [["a", "b"], ["c"], ["e"]]),
                ("for x in 1 2; do a $x; done", [["for", "x", "in", "1", "2"], ["a", "$x"], ["done"]]),
                ("a 'b c' \"d\" &", [["a", "b c", "d"]]),
        ]:
            self.assertEqual(documents.simple_commands(line), commands)


if __name__ == "__main__":
    unittest.main()
