#!/usr/bin/env python3
"""Checks every #include of the sources against layers.json.

    check_layers.py [ROOT]

Fails, with one line for each, on includes that the table does not allow, on folders that the table does not know, on
public headers that include private ones, and on cycles of folders or of files (a source and its header count as one file).
"""

import fnmatch
import json
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


ROOMS = ("model", "hls", "host", "capi", "python", "sim", "constraints", "lab")


def in_room(name):
    """A public header as if it stood in its room: selfproj/driver/device.h is host/driver/device.h."""
    name = name.removeprefix("include/")
    if not name.startswith("selfproj/"):
        return name
    name = name.removeprefix("selfproj/")
    return name if name.startswith("model/") else "host/" + name


def includes_of(root):
    """Returns (file, included file) of every include between our own files, as paths in their rooms."""
    pairs = []
    for top in ("include", *ROOMS):
        for path in sorted((root / top).rglob("*")):
            name = path.relative_to(root).as_posix()
            if path.suffix not in (".h", ".cpp", ".in") or name.startswith("lab/tests/"):
                continue
            for included in INCLUDE.findall(path.read_text(encoding="utf-8")):
                if included.split("/")[0] in (*ROOMS, "selfproj", "tests"):
                    pairs.append((in_room(name), in_room(included)))
    return pairs


def private_includes(root):
    """Returns a line for every public header that includes a private one."""
    return [f"{path.relative_to(root)}: is public, but includes {included}"
            for path in sorted((root / "include").rglob("*.h"))
            for included in INCLUDE.findall(path.read_text(encoding="utf-8")) if not included.startswith("selfproj/")]


def folder_of(name, folders):
    """Returns the innermost folder of the table that holds the file, or None."""
    found = [folder for folder in folders if name.startswith(folder + "/")]
    return max(found, key=len, default=None)


def unit_of(name):
    """A source and its header are one unit."""
    return name.rsplit(".", 1)[0]


def cycles(edges):
    """Returns a cycle through each group of nodes that reach each other, as lists of nodes."""
    graph = {}
    for start, end in edges:
        if start != end:
            graph.setdefault(start, set()).add(end)
    found, done = [], set()
    for start in sorted(graph):
        stack, before = [start], {start: None}
        while stack and start not in done:
            node = stack.pop()
            for after in sorted(graph.get(node, ())):
                if after == start:
                    way = [start]
                    while node != start:
                        way.append(node)
                        node = before[node]
                    found.append([start] + way[:0:-1] + [start])
                    done.update(way)
                    stack = []
                    break
                if after not in before:
                    before[after] = node
                    stack.append(after)
    return found


def problems(root, table):
    """Yields one line for each fault."""
    folders = table["folders"]
    lines = []
    pairs = includes_of(root)
    folder_edges = set()
    for name, included in pairs:
        start, end = folder_of(name, folders), folder_of(included, folders)
        if start is None:
            lines.append(f"{name}: its folder is not in the table")
            continue
        if end != start and end not in folders[start]:
            lines.append(f"{name}: {start} may not include {included}")
        if end is not None:
            folder_edges.add((start, end))
        for rule in table["apart"]:
            if (fnmatch.fnmatch(name, rule["from"])
                    and not any(fnmatch.fnmatch(name, other) for other in rule["except"])
                    and any(fnmatch.fnmatch(included, other) for other in rule["to"])):
                lines.append(f"{name}: must not include {included}: {rule['reason']}")
    for way in cycles(folder_edges):
        lines.append("cycle of folders: " + " -> ".join(way))
    for way in cycles({(unit_of(a), unit_of(b)) for a, b in pairs}):
        lines.append("cycle of files: " + " -> ".join(way))
    for folder in cycles({(a, b) for a, below in folders.items() for b in below}):
        lines.append("cycle in the table: " + " -> ".join(folder))
    return lines


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
    table = json.loads((pathlib.Path(__file__).parent / "layers.json").read_text(encoding="utf-8"))
    lines = private_includes(root) + problems(root, table)
    print("\n".join(lines) if lines else f"{len(includes_of(root))} includes, all allowed by the table")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
