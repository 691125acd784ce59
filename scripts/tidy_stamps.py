#!/usr/bin/env python3
"""For tidy.sh: what clang-tidy's verdict on each source depends on, as a hash.

    ninja -C BUILD -t deps | tidy_stamps.py BUILD SOURCE...

prints "HASH SOURCE" for each source, then "end". The hash covers the source, the headers it includes (but those of the
system), its compile command and the settings. A source that the build does not compile is an error. Standard library
only.
"""

import hashlib
import json
import pathlib
import sys


def included(build, lines):
    """The files each object was made from: {object: [file, ...]}, from the output of `ninja -t deps`."""
    files = {}
    for line in lines:
        if line.startswith("    "):
            files[current].append((build / line.strip()).resolve())
        elif ":" in line:
            current = line.split(":")[0]
            files[current] = []
    return files


def main():
    build = pathlib.Path(sys.argv[1])
    root = pathlib.Path.cwd()
    files_of = included(build, sys.stdin)
    commands = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        commands[(build / entry["file"]).resolve()] = entry["command"]
    settings = [path for path in root.glob("**/.clang-tidy") if "build" not in path.relative_to(root).parts]
    settings += [root / "scripts" / "tidy.sh", root / "scripts" / "tidy_stamps.py"]
    for source in sys.argv[2:]:
        path = pathlib.Path(source).resolve()
        command = commands.get(path)
        if command is None:
            print(f"tidy.sh: {source}: no part of the build", file=sys.stderr)
            return 1
        words = command.split()
        ours = [file for file in files_of.get(words[words.index("-o") + 1], []) if root in file.parents]
        digest = hashlib.sha256(command.encode())
        for file in sorted(set([path, *ours, *settings])):
            digest.update(file.read_bytes())
        print(digest.hexdigest(), source)
    print("end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
