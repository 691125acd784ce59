#!/usr/bin/env python3
"""Tells tidy.sh which sources clang-tidy must check, and groups them.

    tidy_groups.py BUILD FOLDER SOURCE...

For a source alone, most of clang-tidy's time goes into the headers of libraries. So up to 60 sources, also from
different folders, are checked together: a file in FOLDER includes them all. FOLDER/compile_commands.json says how that
file and each source are compiled. Two sources are not checked together if together they would not compile, or if one
would then mean something else than it does alone. This is so if

* both define the same name,
* one calls a function that the unnamed namespace of the other would hide, or
* one names a macro of the command line that is not defined for the other, or has another value there.

A source is left out if it passed before in the same state. Its state is a hash of all that the result depends on: the
source, the headers it includes directly or through others, the compile options, the settings of clang-tidy, the
versions of clang-tidy and of the libraries' packages. FOLDER/good/HASH exists for each state that passed.

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

MOST = 60  # sources of a group, so that there are enough groups for the cores
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*["<](.*)[">]', re.MULTILINE)
# Options that do not change what clang-tidy finds.
WITHOUT_EFFECT = re.compile("-fPIC|-fvisibility.*|-pthread|-O.|-Winvalid-pch|-fpch-preprocess")
# Definitions of a source that may clash with those of another one: types, constants, the main function, operator new.
OWN = re.compile(
    r"^(?:class|struct|enum(?: class)?) (\w+)[^;{]*\{"
    r"|^(?:inline )?(?:constexpr|const|static) [^(=;{]*?\b(\w+)(?:\[\w*\])*(?: =|\{|;)"
    r"|^int (?:sc_)?(main)\("
    r"|^.*\b(operator (?:new|delete))\(",
    re.MULTILINE,
)
NAMESPACE = re.compile(r"^namespace (selfproj[\w:]*)", re.MULTILINE)
# The contents of unnamed namespaces, and the functions and type aliases in them.
UNNAMED = re.compile(r"^namespace \{\n(.*?)^\}", re.MULTILINE | re.DOTALL)
FUNCTION = re.compile(r"^(?!using )(?=\S)[\w:<>,&*\[\] ]*?[\w>][&*]* [&*]*(\w+)\(|^using (\w+) =", re.MULTILINE)
# Calls by a name without a scope. A function in an unnamed namespace would hide another one of the same name.
CALL = re.compile(r"(?<![\w.>:])([A-Za-z_]\w*)(?=[(<])")
# Headers that must not come after others: those of Verilator and SystemC, and those that define many macros. A source
# that includes one is grouped only with such sources of its folder.
APART = re.compile(r'^#include ("V|<verilated|<systemc|<arv|<httplib|"hls/|"sim/platform/)', re.MULTILINE)
ROOT = pathlib.Path.cwd()


def options_of(words):
    """Returns the compiler and its options from a compile command, without files, optimization and g++'s precompiled
    header."""
    options = []
    words = iter(words)
    for word in words:
        if word in ("-o", "-c", "-include"):
            next(words)
        elif word == "-isystem":
            options.append(word + next(words))
        elif not WITHOUT_EFFECT.fullmatch(word):
            options.append(word)
    return options


def folders_of(build, options):
    """Returns the folders of this project in which the compiler looks for headers. For headers elsewhere, the versions
    of their packages count."""
    folders = (build / found[1] for word in options if (found := re.match("(?:-I|-isystem)(.+)", word)))
    return tuple(folder for folder in folders if ROOT == folder or ROOT in folder.parents)


def macros_of(options):
    """Returns {name of a macro on the command line: its value}."""
    return dict((*word[2:].split("=", 1), "1")[:2] for word in options if word.startswith("-D"))


@functools.cache
def words_in(path):
    return frozenset(re.findall(rb"[A-Za-z_]\w*", text_of(path)))


@functools.cache
def text_of(path):
    return path.read_bytes()


@functools.cache
def found(folder, name):
    path = folder / name
    return path.resolve() if path.is_file() else None


@functools.cache
def included(path, folders):
    """Returns the headers of this project that a file includes itself. Conditions around the includes are ignored."""
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


def state_of(files, options, common):
    digest = common.copy()
    digest.update(" ".join(options).encode())
    for file in sorted(files):
        digest.update(str(file.relative_to(ROOT)).encode() + text_of(file))
    return digest.hexdigest()


@functools.cache
def names_in(path):
    """Returns the names that a file defines: types, constants, and what is in unnamed namespaces."""
    text = text_of(path).decode()
    unnamed = "\n".join(UNNAMED.findall(text))
    return {name for match in OWN.findall(text) + FUNCTION.findall(unnamed) for name in match if name}


class Group:
    """Sources that are checked together, and the options for all of them."""

    def __init__(self, *of):
        self.of = of  # must be equal for all: options apart from macros and folders, namespace, folder if APART matches
        self.sources, self.names, self.of_headers = [], set(), set()
        self.macros, self.named, self.folders = {}, set(), []

    def takes(self, names, foreign, macros, named):
        """Returns whether a source can be added. `foreign` are the names in its headers and the names that it calls.
        `named` are the macros of command lines that occur in it or in its headers."""
        return (len(self.sources) < MOST and not (names | foreign) & self.names and not names & self.of_headers and
                all(macros.get(name) == self.macros.get(name)
                    for name in (self.named & macros.keys()) | (named & self.macros.keys()) |
                    (macros.keys() & self.macros.keys())))

    def add(self, source, folders, names, of_headers, macros, named):
        self.sources.append(source)
        self.names |= names
        self.of_headers |= of_headers
        self.macros |= macros
        self.named |= named
        self.folders += (folder for folder in folders if folder not in self.folders)

    def options(self):
        return " ".join([self.of[0], *(f"-D{name}={value}" for name, value in self.macros.items()), *self.folders])


def add_to_groups(groups, source, options, files, known_macros):
    """Adds a source to the first group that can take it, or to a new group."""
    text = text_of(source).decode()
    folders = [word for word in options if word.startswith(("-I", "-isystem"))]
    rest = " ".join(word for word in options if word not in folders and not word.startswith("-D"))
    namespace = NAMESPACE.search(text)  # the same name may mean different things in different namespaces
    of = (rest, namespace and namespace[1], APART.search(text) and source.parent)
    names = names_in(source)
    of_headers = set().union(*(names_in(file) for file in files if file != source))
    macros = macros_of(options)
    named = {name for name in known_macros if any(name.encode() in text_of(file) for file in files)}
    group = next((group for group in groups if group.of == of and
                  group.takes(names, of_headers | set(CALL.findall(text)), macros, named)), None)
    if group is None:
        groups.append(group := Group(*of))
    group.add(source, folders, names, of_headers, macros, named)


def unknown_groups(compiled, build, folder, names):
    """Returns the groups of sources that have not passed in their present state, and the state of every source."""
    common = common_digest()
    states = {}
    groups = []
    known_macros = {name for options in compiled.values() for name in macros_of(options)}
    for name in names:
        source = pathlib.Path(name).resolve()
        if source not in compiled:
            raise ValueError(f"{name}: the build does not compile it")
        options = compiled[source]
        files = all_included(source, folders_of(build, options))
        states[source] = state_of(files, options, common)
        if not (folder / "good" / states[source]).exists():
            add_to_groups(groups, source, options, files, known_macros)
    return groups, states


def write_jobs(build, folder, groups, states, compiled):
    """Writes the files of groups and the compile commands. Returns [(file to check, its sources)]."""
    database = []
    jobs = []

    def add(file, options):
        database.append({"directory": str(build), "file": str(file), "command": f"{options} -c {file}"})

    for group in groups:
        file = group.sources[0]
        if len(group.sources) > 1:
            # Clang's analyzer looks into the functions of included sources only if the file has such a name.
            name = hashlib.sha256("".join(states[source] for source in group.sources).encode()).hexdigest()
            file = folder / f"UnifiedSource_{name}.cpp"
            line = '#include "{}"  // NOLINT(bugprone-suspicious-include)\n'
            file.write_text("".join(line.format(source) for source in group.sources))
            add(file, group.options())
        for source in group.sources:
            add(source, " ".join(compiled[source]))
        jobs.append((file, group.sources))
    (folder / "compile_commands.json").write_text(json.dumps(database, indent=1))
    return jobs


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(sys.argv[2]).resolve()
    compiled = compiled_sources(build)
    try:
        groups, states = unknown_groups(compiled, build, folder, sys.argv[3:])
    except ValueError as error:
        print(f"tidy.sh: {error}", file=sys.stderr)
        return 1
    jobs = write_jobs(build, folder, groups, states, compiled)
    for file, sources in sorted(jobs, key=lambda job: -len(job[1])):  # the longest first
        print(file, *(f"{states[source]}:{source}" for source in sources))
    print("end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
