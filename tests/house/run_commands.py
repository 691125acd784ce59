#!/usr/bin/env python3
"""Runs the command lines of the documents. Of those that are not run it checks the names.

    run_commands.py BUILD PROGRAMS [DOCUMENT...]
    run_commands.py BUILD PROGRAMS --share K/N

BUILD is the folder of a build, for the names of its tests. PROGRAMS is the folder of selfproj and selfproj-sim. A share
is every Nth document from the Kth on, K from 1. Blocks `sh` of a document, or of the page that the site has of a
command, without a comment `not run` (check_commands.py) run one after another, each by bash -eu, in one folder. The
folder contains only rtl, tests, and build/bin, which is PROGRAMS; PROGRAMS is also on the PATH. For every command line,
run or not, it checks that the options of our programs stand in their --help, that ctest finds tests by its -R and -L,
and that the test of `run by` exists. The lines of a block `text` under the comment `output` must be among those that
the block run last has printed.

Of the pages of PICTURED it also looks at what their commands have made: no map may be without values, and no picture of
one colour.
"""

import functools
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import zlib

import documents

for folder in ("docs/site", "lab/scripts"):
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / folder))
import commands  # noqa: E402
import float_tiff  # noqa: E402

LONGEST = 600  # limit in seconds for one block; on an idle machine all blocks together take 300 s
PICTURED = ("docs/getting-started.md",)
LEAST_VALUES = 0.3  # share of a map's values that are there
LEAST_PICTURES = 10  # fewer would mean that the check looks at nothing


def is_plain(path):
    """Whether a PNG, not interlaced, has pixels of one value alone."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        size, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    rows = int.from_bytes(data[20:24], "big")
    pixel = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[data[25]] * data[24] // 8  # bytes, by kind and depth
    raw = zlib.decompress(packed)
    step = len(raw) // rows
    # Filters write differences. Of one value alone, all rows after the first differ by nothing, or repeat it.
    later = [raw[i * step + 1:(i + 1) * step] for i in range(1, rows)]
    return len(set(later)) <= 1 and all(row[pixel:] in (row[:-pixel], bytes(len(row) - pixel)) for row in later[:1])


def empty_pictures(folder):
    """Yields the maps without values and the plain pictures in a folder, and whether there were too few to judge."""
    maps = [path for path in sorted(folder.rglob("*.tiff")) if path.stem.split("_")[0] in
            ("height", "difference", "depth", "centroid") and "build" not in path.relative_to(folder).parts]
    for path in maps:
        rows = float_tiff.read(path)
        share = sum(value == value for row in rows for value in row) / sum(map(len, rows))
        if share < LEAST_VALUES:
            yield f"{path.relative_to(folder)}: {share:.1%} of its values are there"
    pictures = [path for path in sorted(folder.rglob("*.png")) if "build" not in path.relative_to(folder).parts]
    for path in pictures:
        if is_plain(path):
            yield f"{path.relative_to(folder)}: is of one colour"
    if len(maps) + len(pictures) < LEAST_PICTURES:
        yield f"only {len(maps)} maps and {len(pictures)} pictures"
    print(f"{len(maps)} maps and {len(pictures)} pictures looked at")


class Checker:
    def __init__(self, root, build, programs):
        self.root, self.build, self.programs = root, build, programs

    @functools.cached_property
    def tests(self):
        """{name of a test: its labels}"""
        out = subprocess.run(["ctest", "--test-dir", str(self.build), "--show-only=json-v1"], capture_output=True,
                             text=True, check=True).stdout
        found = {}
        for test in json.loads(out)["tests"]:
            labels = [p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"]
            found[test["name"]] = sum(labels, [])
        return found

    @functools.lru_cache(maxsize=None)
    def help_of(self, program, *commands):
        run = subprocess.run([str(self.programs / program), *commands, "--help"], capture_output=True, text=True)
        return run.stdout if run.returncode == 0 else None

    def help_for(self, words):
        """Returns (the commands that a line of one of our programs names, their help). The help is None if a command is
        unknown."""
        program = pathlib.PurePosixPath(words[0]).name
        names = []
        text = self.help_of(program)
        while text and "\nCommands:\n" in text and len(names) + 1 < len(words):
            known = re.findall(r"^  ([a-z][\w-]*)", text.split("\nCommands:\n")[1].split("\n\n")[0], re.MULTILINE)
            word = words[len(names) + 1]
            if word not in known:
                if names or word.startswith("-") or word.isupper():
                    break
                return [*names, word], None
            names.append(word)
            text = self.help_of(program, *names)
        return names, text

    def problems_of_command(self, words):
        if words[0] in documents.PROGRAMS:
            if not (self.programs / pathlib.PurePosixPath(words[0]).name).exists():
                return  # the laboratory is not built everywhere
            names, text = self.help_for(words)
            if text is None:
                yield f"{words[0]} has no command {' '.join(names)}"
                return
            known = set(re.findall(r"--[a-z][\w-]*", text)) | {"--help", "--version"}
            for option in documents.options_of(words):
                if option not in known:
                    yield f"{' '.join([words[0], *names])} has no option {option}"
        elif words[0] == "ctest":
            yield from self.problems_of_patterns(words)
        elif re.match(r"(\./)?build/\w+/tests/", words[0]):
            name = pathlib.PurePosixPath(words[0]).name
            if not any(re.search(rf"\b{re.escape(re.sub(r'_[a-z]+$', '', name))}", text) for text in self.cmake_lists):
                yield f"nothing builds {words[0]}"

    @functools.cached_property
    def cmake_lists(self):
        return [(self.root / name).read_text(encoding="utf-8") for name in documents.tracked(self.root)
                if name.endswith("CMakeLists.txt")]

    def problems_of_patterns(self, words):
        for option, value in zip(words, words[1:]):
            if value.isupper():
                continue
            if option in ("-R", "--tests-regex") and not any(re.search(value, name) for name in self.tests):
                yield f"no test has a name like {value}"
            # A label may be that of another preset, such as sanitizers.
            labels = [one for labels in self.tests.values() for one in labels]
            labels += [one for text in self.cmake_lists for one in re.findall(r"LABEL ([a-z]+)", text)]
            if option in ("-L", "--label-regex") and not any(re.search(value, one) for one in labels):
                yield f"no test has a label like {value}"

    def problems_of_lines(self, page):
        for block in page.blocks:
            for kind, text in block.marks:
                _, _, by = text.partition("; run by ")
                if kind == "not run" and by and by not in self.tests:
                    yield f"{page.name}:{block.line - 2}: no test {by}"
            if block.language == "sh":
                for offset, line in documents.script_lines(block.text):
                    for words in documents.simple_commands(line):
                        for problem in self.problems_of_command(words):
                            yield f"{page.name}:{block.line + offset}: {problem}"
        for line, span in page.spans:
            words = documents.words_of(span)
            if words and documents.is_ours(words):
                for problem in self.problems_of_command(words):
                    yield f"{page.name}:{line}: {problem}"

    def shortened(self, line, option):
        """Returns the line with the option added or replaced, if its program knows the option."""
        name, _, value = option.partition(" ")
        for words in documents.simple_commands(line):
            if words[0] in documents.PROGRAMS and name in (self.help_for(words)[1] or ""):
                own = re.compile(rf"{name}(=|\s+)[^\s-]\S*" if value else rf"{name}\b")
                if own.search(line):
                    return own.sub(option, line)
                command = re.escape(" ".join(words[:2]))
                return re.sub(rf"({command}\b)", rf"\1 {option}", line, count=1)
        return line

    def script(self, block):
        """Returns the part of a block that bash runs, or None. Lines of ctest and cmake are checked but not run."""
        if block.language != "sh" or any(kind == "not run" for kind, _ in block.marks):
            return None
        lines = []
        for _, line in documents.script_lines(block.text):
            for kind, text in block.marks:
                line = self.shortened(line, text)
            if not any(words[0] in ("ctest", "cmake") for words in documents.simple_commands(line)):
                lines.append(line)
        return "\n".join(lines) + "\n" if any(not line.lstrip().startswith("#") for line in lines) else None

    def run(self, page):
        """Runs the blocks of a document, and returns its problems."""
        scripts = [(block, self.script(block)) for block in page.blocks]
        scripts = [(block, text) for block, text in scripts if text or "output" in dict(block.marks)]
        if not scripts:
            return
        printed = ""
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "build").mkdir()
            (pathlib.Path(folder) / "build/bin").symlink_to(self.programs)
            for sources in ("rtl", "tests"):
                (pathlib.Path(folder) / sources).symlink_to(self.root / sources)
            environment = {**os.environ, "PATH": f"{self.programs}:{os.environ['PATH']}"}
            for block, text in scripts:
                if text is None:
                    for line in block.text.splitlines():
                        if line not in printed.splitlines():
                            yield f"{page.name}:{block.line}: not printed: {line}"
                    continue
                start = time.monotonic()
                try:
                    done = subprocess.run(["bash", "-eu", "-o", "pipefail", "-c", text], cwd=folder, env=environment,
                                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                          text=True, errors="replace", timeout=LONGEST)
                except subprocess.TimeoutExpired:
                    yield f"{page.name}:{block.line}: takes longer than {LONGEST} s"
                    return
                print(f"{page.name}:{block.line}: {time.monotonic() - start:.1f} s")
                printed = done.stdout
                if done.returncode != 0:
                    yield f"{page.name}:{block.line}: exit status {done.returncode} of\n{text}{done.stdout}"
                    return
            if page.name in PICTURED:
                for fault in empty_pictures(pathlib.Path(folder)):
                    yield f"{page.name}: {fault}"


def problems(root, build, programs, names=(), share=slice(None)):
    checker = Checker(root, build, programs)
    lines = []
    made = [documents.parse(f"docs/commands/{name}", text) for name, text in commands.pages(programs).items()]
    for page in [*documents.all_documents(root), *made][share]:
        if not names or page.name in names:
            lines += checker.problems_of_lines(page)
            if (programs / "selfproj-lab").exists() or not page.name.startswith("lab/"):
                lines += checker.run(page)
    return lines


def main():
    if len(sys.argv) < 3:
        print("usage: run_commands.py BUILD PROGRAMS [DOCUMENT...] | BUILD PROGRAMS --share K/N", file=sys.stderr)
        return 2
    root = pathlib.Path(__file__).resolve().parents[2]
    build, programs = (pathlib.Path(name).resolve() for name in sys.argv[1:3])
    names, share = sys.argv[3:], slice(None)
    if names[:1] == ["--share"]:
        first, step = (int(word) for word in names[1].split("/"))
        names, share = [], slice(first - 1, None, step)
    lines = problems(root, build, programs, names, share)
    print("\n".join(lines) if lines else "every command line of the documents does what it should")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
