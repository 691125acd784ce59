#!/usr/bin/env python3
"""For tidy.sh: what clang-tidy is to look at in one go, and what its verdict depends on, as a hash.

    ninja -C BUILD -t deps | tidy_groups.py BUILD FOLDER SOURCE...

Most of clang-tidy's time goes into the headers of libraries. So the sources of a folder that are compiled with the same
options are included by one file in FOLDER, and FOLDER/compile_commands.json tells how that is compiled, and each of
them. Prints "HASH FILE SOURCE..." for each such file (FILE is SOURCE where there is but one), then "end". The hash
covers the sources, the headers they include (but those of the system), the compile command and the settings. A source
that the build does not compile is an error. Standard library only.
"""

import hashlib
import json
import pathlib
import re
import sys

MOST = 20  # sources of a group, so that there are enough groups for the cores
INCLUDE = re.compile(r'^#include "(.*)"', re.MULTILINE)
ALONE = re.compile(r"^(int (sc_)?main|.*\boperator (new|delete))\(", re.MULTILINE)
VERILATED = re.compile(r'^#include ("V|<verilated)', re.MULTILINE)


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


def options_of(words):
    """The compiler and its options in a compile command, without files, optimization and g++'s precompiled header."""
    options = []
    words = iter(words)
    for word in words:
        if word in ("-o", "-c", "-include"):
            next(words)
        elif word not in ("-Winvalid-pch", "-fpch-preprocess", "-O1", "-Og", "-O2", "-O3"):
            options.append(word)
    return options


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(sys.argv[2]).resolve()
    root = pathlib.Path.cwd()
    files_of = included(build, sys.stdin)
    compiled = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = entry["command"].split()
        files = files_of.get(words[words.index("-o") + 1], [])
        ours = [file for file in files if root in file.parents]
        file = (build / entry["file"]).resolve()
        joined = INCLUDE.findall(file.read_text()) if file.name.startswith("unity_") else [file]  # by CMake
        for source in joined:
            compiled.setdefault(pathlib.Path(source), (" ".join(options_of(words)), ours))
    groups = {}
    for source in sys.argv[3:]:
        path = pathlib.Path(source).resolve()
        if path not in compiled:
            print(f"tidy.sh: {source}: no part of the build", file=sys.stderr)
            return 1
        text = path.read_text()
        # Verilator's headers do not bear SystemC's before them; and each program has but one main function and one
        # operator new.
        of_folder = groups.setdefault((path.parent, compiled[path][0], bool(VERILATED.search(text))), [])
        alone = bool(ALONE.search(text))
        part = next((part for part in of_folder if len(part[0]) < MOST and not (alone and part[1])), None)
        if part is None:
            of_folder.append(part := ([], []))
        part[0].append(path)
        if alone:
            part[1].append(path)
    settings = [path for path in root.glob("**/.clang-tidy") if "build" not in path.relative_to(root).parts]
    settings += [root / "scripts" / "tidy.sh", root / "scripts" / "tidy_groups.py"]
    database = []
    jobs = []
    for (_, options, _), parts in groups.items():
        for sources, _ in parts:
            digest = hashlib.sha256(options.encode())
            for file in sorted(set(sources).union(settings, *(compiled[source][1] for source in sources))):
                digest.update(file.read_bytes())
            hashed = digest.hexdigest()
            file = sources[0]
            if len(sources) > 1:
                # Clang's analyzer looks into the functions of included sources only where the file is called so.
                file = folder / f"UnifiedSource_{hashed}.cpp"
                file.write_text("".join(f'#include "{source}"  // NOLINT(bugprone-suspicious-include)\n' for source in sources))
                database.append({"directory": str(build), "file": str(file), "command": f"{options} -c {file}"})
            for source in sources:
                database.append({"directory": str(build), "file": str(source), "command": f"{options} -c {source}"})
            jobs.append((hashed, file, sources))
    (folder / "compile_commands.json").write_text(json.dumps(database, indent=1))
    for hashed, file, sources in sorted(jobs, key=lambda job: -len(job[2])):  # the longest first
        print(hashed, file, *sources)
    print("end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
