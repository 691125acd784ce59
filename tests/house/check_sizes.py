#!/usr/bin/env python3
"""No source file is longer than 450 lines, and no function than 80.

    check_sizes.py [ROOT]

Functions of C++ are found by the format of clang-format: one begins with a line that ends in `{` and ends with a `}` in
the same column. Functions called add_..._command are left out: they are tables of options.
"""

import ast
import pathlib
import re
import subprocess
import sys

MOST_LINES = 450
MOST_LINES_OF_FUNCTION = 80
SOURCES = {".h", ".cpp", ".sv", ".py", ".sh", ".cmake", ".tcl"}

# What opens a block and is no function.
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


def problems(root):
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=root, capture_output=True, text=True,
                            check=True).stdout.splitlines()
    lines = []
    for name in sorted(set(listed)):
        path = root / name
        if path.suffix not in SOURCES or "/generated/" in name or not path.is_file():
            continue
        text = path.read_text(encoding="utf-8")
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
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
    lines = problems(root)
    print("\n".join(lines) if lines else "no file and no function is too long")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
