#!/usr/bin/env python3
"""Checks that source files have at most 450 lines, functions 80 lines, and lines 120 characters (RTL: 100).

    check_sizes.py [ROOT]

Lines that cannot be wrapped may be longer: tables and generated parts of Markdown, JSON, and a line that holds a single
word, such as a link, which is too long by itself. The front page, README.md, has at most 6 kB.

Functions of C++ are found by the format of clang-format: one begins with a line that ends in `{` and ends with a `}` in
the same column. Functions called add_..._command are left out: they are tables of options.
"""

import ast
import pathlib
import re
import sys

import documents

MOST_LINES = 450
MOST_LINES_OF_FUNCTION = 80
MOST_BYTES_OF_FRONT_PAGE = 6 * 1024
MOST_CHARACTERS = {".sv": 100, ".v": 100, ".vh": 100}  # of a line; of all others 120
SOURCES = {".h", ".cpp", ".sv", ".py", ".sh", ".cmake", ".tcl"}

# Keywords that open a block that is not a function.
OTHER = re.compile(r"^\s*(namespace|class|struct|enum|union|extern|if|for|while|switch|do|else|try|catch|case|default|"
                   r"constexpr \S+ \w+ = |.*\b(class|struct|union) \w+( final)?( :.*)? \{$|.*= \{$|.*=\s*\[)")
FUNCTION = re.compile(r"\)[^()]*\{$|\) (const |noexcept |override )*\{$")
NAME = re.compile(r"([~\w:]+|operator\S+)\s*\(")


def functions_of_cpp(text):
    """(name, first line from 1, lines) of each function at the top or directly in a class."""
    lines = text.split("\n")
    found = []
    start = None
    for number, line in enumerate(lines):
        if start is None:
            if line.endswith("{") and not OTHER.match(line) and not line.lstrip().startswith("//"):
                first = number
                while first > 0 and lines[first - 1].strip() and not re.search(r"[;{}>:]$", lines[first - 1].rstrip()):
                    first -= 1
                head = " ".join(part.strip() for part in lines[first:number + 1])
                name = NAME.search(head)
                indent = len(lines[first]) - len(lines[first].lstrip())
                if name and indent <= 4 and FUNCTION.search(head) and not OTHER.match(lines[first]):
                    start = (name.group(1), first, indent)
        elif line.rstrip(";") == " " * start[2] + "}":
            found.append((start[0], start[1] + 1, number - start[1] + 1))
            start = None
    return found


def functions_of_python(text):
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]
    return [(node.name, node.lineno, node.end_lineno - node.lineno + 1) for node in nodes]


def long_lines(name, text):
    """Yields (number from 1, characters, limit) of each line that is too long and could be wrapped."""
    suffix = pathlib.PurePath(name).suffix
    most = MOST_CHARACTERS.get(suffix, 120)
    generated = False
    for number, line in enumerate(text.split("\n"), 1):
        generated = "BEGIN GENERATED" in line or (generated and "END GENERATED" not in line)
        can_wrap = len(line.split()) > 1 and not generated and not (suffix == ".md" and line.lstrip().startswith("|"))
        if len(line) > most and can_wrap:
            yield number, len(line), most


def problems(root):
    lines = []
    for name in documents.tracked(root):
        path = root / name
        if "/generated/" in name or path.suffix == ".json":
            continue
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:  # a picture
            continue
        lines += [f"{name}:{number}: {count} characters, {most} at most" for number, count, most in long_lines(name, text)]
        if name == "README.md" and len(text.encode()) > MOST_BYTES_OF_FRONT_PAGE:
            lines.append(f"{name}: {len(text.encode())} bytes, {MOST_BYTES_OF_FRONT_PAGE} at most")
        if path.suffix not in SOURCES:
            continue
        count = text.count("\n")
        if count > MOST_LINES:
            lines.append(f"{name}: {count} lines, {MOST_LINES} at most")
        functions = functions_of_cpp(text) if path.suffix in (".h", ".cpp") else []
        if path.suffix == ".py":
            functions = functions_of_python(text)
        for function, at, size in functions:
            if size > MOST_LINES_OF_FUNCTION and not re.fullmatch(r"add_\w+_command", function):
                lines.append(f"{name}:{at}: {function} has {size} lines, {MOST_LINES_OF_FUNCTION} at most")
    return lines


def main():
    lines = problems(documents.read_root(sys.argv, __file__))
    print("\n".join(lines) if lines else "no file, no function and no line is too long")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
