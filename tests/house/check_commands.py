#!/usr/bin/env python3
"""Every command line of every Markdown file is run by a test, or says why not.

    check_commands.py [ROOT]

A command line stands in a fenced block `sh`, a script that run_commands.py runs as it stands, or under one of these:

    <!-- run shortened: --count 20 -->          with this option added, or in place of the line's own
    <!-- not run: REASON -->                    REASON is one of the list below
    <!-- not run: REASON; run by NAME -->       the test NAME of CTest runs it

Lines of ctest and cmake need no comment: run_commands.py looks up what they name. A block `text` under

    <!-- output -->

must be printed by the block that was run last. This test looks at the comments, at scripts and presets, at the language
that each block names, and for command lines in blocks that are not `sh`.
"""

import json
import re
import sys

import documents

REASONS = {
    "needs hardware",
    "needs captures",      # real images in ../shared/data, which are not part of the project
    "needs your files",    # images, packets or rigs that the reader brings
    "needs a tool",        # a vendor's tool, or one that is not in Debian
    "installs packages",
    "builds",
    "runs the tests",
    "takes minutes",
    "writes the sources",
}
LANGUAGES = {"sh", "text", "cpp", "systemverilog", "python", "yaml", "json", "csv", "cmake", "tcl", "markdown"}
NEED_NO_COMMENT = {"ctest", "cmake"}


def presets(root):
    path = root / "CMakePresets.json"
    if not path.exists():
        return set()
    return {preset["name"] for preset in json.loads(path.read_text(encoding="utf-8"))["configurePresets"]}


def problems_of_marks(block):
    kinds = [kind for kind, _ in block.marks]
    if len(kinds) > 1:
        yield "more than one comment on how it is run"
    for kind, text in block.marks:
        if kind == "not run":
            reason, _, by = text.partition("; run by ")
            if reason not in REASONS:
                yield f"'{reason}' is none of the reasons not to run it: {', '.join(sorted(REASONS))}"
            if by and not re.fullmatch(r"[\w./-]+", by):
                yield f"'{by}' is not the name of a test"
        elif kind == "run shortened" and not re.fullmatch(r"--[a-z-]+( [^\s-]\S*)?", text):
            yield f"'{text}' is not one option"
        elif kind == "output" and text:
            yield f"'{text}' after output"


def problems_of_command(root, words, known_presets):
    first = words[0].removeprefix("./")
    if re.match(r"(scripts|hls|model|tests|constraints|lab)/", first) and not (root / first).is_file():
        yield f"no file {first}"
    if first.startswith("scripts/") and (root / first).is_file():
        text = (root / first).read_text(encoding="utf-8")
        for option in documents.options_of(words):
            if option not in text:
                yield f"{first} has no option {option}"
    if first.startswith("python3") and len(words) > 1 and "/" in words[1] and not (root / words[1]).is_file():
        yield f"no file {words[1]}"
    if first in ("ctest", "cmake"):
        for option, value in zip(words, words[1:]):
            if option in ("--preset", "--build=--preset") and not value.isupper() and value not in known_presets:
                yield f"no preset {value}"


def problems_of_block(root, block, known_presets):
    if block.fenced and block.language not in LANGUAGES:
        yield block.line, f"the block names no language, or none of {', '.join(sorted(LANGUAGES))}"
    for problem in problems_of_marks(block):
        yield block.line, problem
    if block.language != "sh":
        if block.marks and (block.language, block.marks[0][0]) != ("text", "output"):
            yield block.line, "a comment on how to run what is no block `sh`"
        for offset, line in documents.script_lines(block.text):
            words = line.split()
            if block.language in ("", "text") and documents.is_ours(words) and " ─" not in line:
                yield block.line + offset, f"a command line outside a block `sh`: {line.strip()}"
        return
    if "output" in dict(block.marks):
        yield block.line, "what is printed is a block `text`"
    for offset, line in documents.script_lines(block.text):
        for words in documents.simple_commands(line):
            for problem in problems_of_command(root, words, known_presets):
                yield block.line + offset, problem
            is_script = re.match(r"(\./)?(scripts/|hls/|model/|tests/|constraints/|lab/|build/(?!bin/))", words[0])
            if is_script and not block.marks:
                yield block.line + offset, f"{words[0]} is not run by run_commands.py: the block needs a comment"


def problems(root):
    known_presets = presets(root)
    lines = []
    for page in documents.all_documents(root):
        if page.unclosed:
            lines.append(f"{page.name}:{page.unclosed}: nothing closes this block")
        for block in page.blocks:
            lines += [f"{page.name}:{line}: {text}" for line, text in problems_of_block(root, block, known_presets)]
        for line, span in page.spans:
            words = documents.words_of(span)
            if words and documents.is_ours(words):
                lines += [f"{page.name}:{line}: {text}" for text in problems_of_command(root, words, known_presets)]
    return lines


def main():
    lines = problems(documents.read_root(sys.argv, __file__))
    print("\n".join(lines) if lines else "every command line is run, or says why not")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
