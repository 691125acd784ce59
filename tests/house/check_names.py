#!/usr/bin/env python3
"""Checks that every file and every name that a comment or a document mentions exists.

    check_names.py [ROOT]

Looked at: Markdown, and the comments of C++, SystemVerilog, Python, shell, CMake, Tcl.
* A path (host/io/files.h, ../rtl/README.md, sim/board/) must be a tracked file or folder: from the root, from the file
  that names it, or, for a bare file name such as files.h, anywhere.
* A name (snake_case, camelCase, call(), Class::member, --option) must stand somewhere outside comments. Symbols of
  equations, which begin with a single letter (x_camera), and names with a placeholder in capitals (depth_KKKK) pass.
external.txt beside this file lists names of others (tools, standards); a name there that nobody mentions is an error,
too.
"""

import pathlib
import re
import sys

import documents

SOURCE = {".h", ".cpp", ".in", ".sv", ".v", ".vh", ".vlt", ".py", ".sh", ".cmake", ".tcl", ".txt", ".xdc", ".ucf",
          ".lpf", ".pcf"}
DATA = {".json", ".yaml", ".yml", ".clang-tidy", ".clang-format", ".gitignore", ""}
SLASH = {".h", ".cpp", ".in", ".sv", ".v", ".vh", ".vlt"}

PATH = re.compile(r"(?<![\w./$}{*~%>-])((?:\.\./)*[A-Za-z_][\w.-]*(?:/[\w.*{},-]+)+/?"
                  r"|(?:\.\./)+[A-Za-z_][\w.-]*\w"
                  r"|[A-Za-z_][\w-]*\.(?:h|cpp|sv|vh|vlt|py|sh|md|cmake|tcl))(?![\w/*])")
NAME = re.compile(r"(?<![\w/.$-])(--[a-z][a-z0-9-]+"
                  r"|[A-Za-z_][A-Za-z0-9_]*(?:(?:::|\.)[A-Za-z_][A-Za-z0-9_]*)*(?:\(\))?)(?![\w/*]|\.\.\.)")


def split(name, text):
    """Returns the code and the comments of a file: two texts with as many lines as the file."""
    suffix = pathlib.Path(name).suffix
    if suffix == ".md":
        return "", text
    if suffix in SLASH:
        pattern = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|(//[^\n]*|/\*.*?\*/)', re.DOTALL)
    elif suffix == ".py":
        pattern = re.compile(r'("""(?:.|\n)*?""")|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|(#[^\n]*)')
    elif suffix in (".sh", ".cmake", ".tcl", ".xdc", ".ucf", ".lpf", ".pcf") or name.endswith("CMakeLists.txt"):
        pattern = re.compile(r'("")|(?:(?<=\s)|^)(#(?![{!])[^\n]*)', re.MULTILINE)
    else:
        return text, ""
    code, comment, at = [], [], 0
    for match in pattern.finditer(text):
        found = next((group for group in match.groups() if group), None)
        if found is None:
            continue
        code.append(text[at:match.start()])
        comment.append(re.sub(r"[^\n]", " ", text[at:match.start()]))
        code.append(re.sub(r"[^\n]", " ", match.group()))
        comment.append(match.group())
        at = match.end()
    code.append(text[at:])
    comment.append(re.sub(r"[^\n]", " ", text[at:]))
    return "".join(code), "".join(comment)


def is_identifier(word):
    """Returns whether a word of prose can only be a name: snake_case, camelCase, Two::Parts, call()."""
    bare = word.removesuffix("()")
    if re.match(r"[A-Za-z]_", bare) or re.search(r"[A-Z]{4}", bare):
        return False
    return (word.endswith("()") or "::" in word or word.startswith("--") or re.search(r"[a-z0-9]_[a-zA-Z0-9]", bare)
            or re.search(r"[a-z][A-Z]", bare)) and not bare.isupper()


class Tree:
    def __init__(self, root):
        self.root = root
        self.files = documents.tracked(root)
        self.known_paths = set(self.files)
        for name in self.files:
            self.known_paths.update(parent.as_posix() for parent in pathlib.PurePath(name).parents)
        self.stems = {name.rsplit(".", 1)[0] for name in self.files}  # host/rig/lens, for lens.h and lens.cpp
        self.base_names = {pathlib.PurePath(name).name for name in self.files}
        self.comments = {}
        self.words = set()
        self.prefixes = set()  # of names that CMake and shells put together: hls_soak${suffix}
        for name in self.files:
            if name.startswith("tests/house/") or pathlib.Path(name).suffix not in SOURCE | DATA | {".md"}:
                continue
            try:
                text = (root / name).read_text(encoding="utf-8")
            except UnicodeDecodeError:
                continue
            code, comment = split(name, text)
            self.comments[name] = comment
            self.words.update(re.findall(r"[A-Za-z_]\w*", code))
            self.words.update(re.findall(r"--[a-z][a-z0-9-]+", code))
            self.prefixes.update(re.findall(r"([A-Za-z]\w{3,})\$\{", code))
            self.words.update(pathlib.PurePath(name).parts)
            self.words.add(pathlib.PurePath(name).stem)

    def name_is_there(self, word):
        return (word in self.words or f"sp_{word}" in self.words  # a block by its short name
                or any(word.startswith(prefix) for prefix in self.prefixes))

    def path_is_there(self, path, name):
        if "/" not in path:
            return path in self.base_names or re.search(r"[A-Z]{4}", path.replace("README", "")) is not None
        here = pathlib.PurePosixPath(name).parent
        for start in (pathlib.PurePosixPath("."), here):
            parts = []
            for part in (start / path).parts:
                if part == ".." and parts:
                    parts.pop()
                elif part != ".":
                    parts.append(part)
            full = "/".join(parts)
            if full in self.known_paths or full in self.stems or "*" in full or re.search(r"[A-Z]{4}(?!ME)", full):
                return True
        return False


def problems(root, external):
    tree = Tree(root)
    tops = {name.split("/")[0] for name in tree.files if "/" in name}
    lines, used = [], set()
    for name, comment in tree.comments.items():
        for number, line in enumerate(comment.splitlines(), 1):
            for path in PATH.findall(line):
                path = path.rstrip(".,")
                first = path.split("/")[0]
                if "/" in path and first not in tops and first != "..":
                    continue
                if not tree.path_is_there(path, name):
                    if path in external:
                        used.add(path)
                    else:
                        lines.append(f"{name}:{number}: no file or folder {path}")
            for word in NAME.findall(line):
                if not is_identifier(word):
                    continue
                parts = [word] if word.startswith("--") else re.findall(r"[A-Za-z_][A-Za-z0-9_]*", word)
                missing = [part for part in parts if not tree.name_is_there(part)]
                if word in external or (missing and all(part in external for part in missing)):
                    used.update([word, *missing])
                elif missing:
                    lines.append(f"{name}:{number}: no name {word}")
    lines += [f"external.txt: {word} is not used" for word in sorted(external - used)]
    return lines


def main():
    here = pathlib.Path(__file__).parent
    root = documents.read_root(sys.argv, __file__)
    external = {line.split("#")[0].strip() for line in (here / "external.txt").read_text(encoding="utf-8").splitlines()}
    lines = problems(root, external - {""})
    print("\n".join(lines) if lines else "every file and name that is spoken of is there")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
