#!/usr/bin/env python3
"""For tidy.sh: which sources clang-tidy must check, and how they are grouped.

    tidy_groups.py BUILD FOLDER SOURCE...

Most of clang-tidy's time goes into the headers of libraries. So the sources of a folder that are compiled with the same
options are checked together: a file in FOLDER includes them all, and FOLDER/compile_commands.json says how that file
and each source are compiled. A source is left out if it passed before in the same state. Its state is a hash of all
that the result depends on: the source, the headers it includes directly or through others, the compile options, the
settings of clang-tidy, the versions of clang-tidy and of the libraries' packages. FOLDER/good/HASH exists for each
state that passed.

Prints "FILE HASH:SOURCE..." for each file to check (FILE is the source itself if there is only one), then "end". It is
an error if the build does not compile a source. Standard library only.
"""

import functools
import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys

MOST = 20  # sources of a group, so that there are enough groups for the cores
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*["<](.*)[">]', re.MULTILINE)
# What a source defines for itself and another may define as well: types, constants, the main function, operator new.
OWN = re.compile(
    r"^(?:class|struct|enum(?: class)?) (\w+)[^;{]*\{"
    r"|^(?:constexpr|const|static) [^(=;{]*?\b(\w+)(?:\[\w*\])*(?: =|\{|;)"
    r"|^int (?:sc_)?(main)\("
    r"|^.*\b(operator (?:new|delete))\(",
    re.MULTILINE,
)
VERILATED = re.compile(r'^#include ("V|<verilated)', re.MULTILINE)
ROOT = pathlib.Path.cwd()


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


def folders_of(build, options):
    """The folders of this project in which the compiler looks for headers; others are known by their packages."""
    folders = []
    for at, word in enumerate(options):
        if word.startswith("-I"):
            folders.append(build / word[2:])
        elif word == "-isystem":
            folders.append(build / options[at + 1])
    return tuple(folder for folder in folders if ROOT == folder or ROOT in folder.parents)


@functools.cache
def text_of(path):
    return path.read_bytes()


@functools.cache
def found(folder, name):
    path = folder / name
    return path.resolve() if path.is_file() else None


@functools.cache
def included(path, folders):
    """Returns the headers of this project that a file includes itself, whatever the conditions around the includes."""
    headers = set()
    for name in INCLUDE.findall(text_of(path).decode(errors="replace")):
        header = next((at for folder in (path.parent, *folders) if (at := found(folder, name))), None)
        if header is not None and ROOT in header.parents:
            headers.add(header)
    return headers


def all_included(path, folders):
    """Returns the file and everything that it includes, directly or indirectly."""
    seen = {path}
    ahead = [path]
    while ahead:
        more = included(ahead.pop(), folders) - seen
        seen |= more
        ahead += more
    return seen


def said(*command):
    return subprocess.run(command, capture_output=True, check=False).stdout if shutil.which(command[0]) else b""


def common_digest():
    """Returns what every result depends on: settings, this script and its caller, versions."""
    digest = hashlib.sha256(said("clang-tidy-14", "--version"))
    packages = said("dpkg-query", "--show", "*-dev").splitlines()
    digest.update(b"\n".join(sorted(package for package in packages if package.split(b"\t")[-1])))
    settings = [path for path in ROOT.glob("**/.clang-tidy") if "build" not in path.relative_to(ROOT).parts]
    for path in sorted(settings) + [ROOT / "scripts" / "tidy.sh", ROOT / "scripts" / "tidy_groups.py"]:
        digest.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return digest


def compiled_sources(build):
    """The options of each source that the build compiles."""
    compiled = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        file = (build / entry["file"]).resolve()
        options = options_of(entry["command"].split())
        joined = INCLUDE.findall(file.read_text()) if file.name.startswith("unity_") else [file]  # by CMake
        for source in joined:
            compiled.setdefault(pathlib.Path(source), options)
    return compiled


def state_of(source, options, folders, common):
    digest = common.copy()
    digest.update(" ".join(options).encode())
    for file in sorted(all_included(source, folders)):
        digest.update(str(file.relative_to(ROOT)).encode() + text_of(file))
    return digest.hexdigest()


def add_to_groups(groups, source, options):
    """Puts a source into the first group of its folder and options that can take it."""
    text = text_of(source).decode()
    # Verilator's headers cannot come after SystemC's. A source does not compile after another with the same names.
    of_folder = groups.setdefault((source.parent, " ".join(options), bool(VERILATED.search(text))), [])
    names = {name for match in OWN.findall(text) for name in match if name}
    with_room = (group for group in of_folder if len(group["sources"]) < MOST and not names & group["names"])
    group = next(with_room, None)
    if group is None:
        of_folder.append(group := {"sources": [], "names": set()})
    group["sources"].append(source)
    group["names"] |= names


def unknown_groups(build, folder, names):
    """Returns the groups of sources whose state is not known to be good, and the state of every source."""
    compiled = compiled_sources(build)
    common = common_digest()
    states = {}
    groups = {}
    for name in names:
        source = pathlib.Path(name).resolve()
        if source not in compiled:
            raise ValueError(f"{name}: the build does not compile it")
        options = compiled[source]
        states[source] = state_of(source, options, folders_of(build, options), common)
        if not (folder / "good" / states[source]).exists():
            add_to_groups(groups, source, options)
    return groups, states


def write_jobs(build, folder, groups, states):
    """[(file to check, its sources)]; writes the files of groups and the compile commands."""
    database = []
    jobs = []

    def add(file, options):
        database.append({"directory": str(build), "file": str(file), "command": f"{options} -c {file}"})

    for (_, options, _), parts in groups.items():
        for sources in (part["sources"] for part in parts):
            file = sources[0]
            if len(sources) > 1:
                # Clang's analyzer looks into the functions of included sources only where the file has such a name.
                name = hashlib.sha256("".join(states[source] for source in sources).encode()).hexdigest()
                file = folder / f"UnifiedSource_{name}.cpp"
                line = '#include "{}"  // NOLINT(bugprone-suspicious-include)\n'
                file.write_text("".join(line.format(source) for source in sources))
                add(file, options)
            for source in sources:
                add(source, options)
            jobs.append((file, sources))
    (folder / "compile_commands.json").write_text(json.dumps(database, indent=1))
    return jobs


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(sys.argv[2]).resolve()
    try:
        groups, states = unknown_groups(build, folder, sys.argv[3:])
    except ValueError as error:
        print(f"tidy.sh: {error}", file=sys.stderr)
        return 1
    jobs = write_jobs(build, folder, groups, states)
    for file, sources in sorted(jobs, key=lambda job: -len(job[1])):  # the longest first
        print(file, *(f"{states[source]}:{source}" for source in sources))
    print("end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
