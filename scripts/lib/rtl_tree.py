"""The sources of rtl/: what a module needs, the command with which Yosys reads it, and copies, plain or with a planted
fault.

    rtl_tree.py MODULE     prints the files that the module needs, below the root, the package first

Standard library only.
"""

import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = pathlib.Path("common") / "sp_spec_pkg.sv"


class PlantError(Exception):
    """A fault cannot be planted in rtl/."""


def sources(rtl=ROOT / "rtl"):
    """Returns every file of rtl, the package first."""
    others = sorted(path for path in rtl.rglob("sp_*.sv") if not path.name.endswith("_pkg.sv"))
    return [rtl / PACKAGE, *others]


def needed(top, texts):
    """Returns those of the files {path: text} that a module needs: the package, its own file, and the files of all
    modules that it names, directly or not. Yosys takes a second to read all of rtl."""
    paths = {path.stem: path for path in texts}
    named = [top]
    for name in named:
        text = re.sub(r"//[^\n]*", "", texts[paths[name]])
        named += {found for found in re.findall(r"\bsp_\w+", text) if found in paths}.difference(named)
    return [paths[PACKAGE.stem], *sorted(paths[name] for name in named if name != PACKAGE.stem)]


def sources_of(top, rtl=ROOT / "rtl", more=()):
    """Returns the files of rtl, and of the files `more`, that the module `top` needs."""
    return needed(top, {path: path.read_text(encoding="utf-8") for path in [*sources(rtl), *more]})


def sources_of_all(tops):
    """Returns the files of rtl that any of the modules needs, each once."""
    return list(dict.fromkeys(path for top in tops for path in sources_of(top)))


def without_comments(path):
    """Returns the text of a script or of constraints without its lines of comment, which change nothing."""
    lines = pathlib.Path(path).read_text().splitlines()
    return "\n".join(line for line in lines if line.strip() and not line.lstrip().startswith("#"))


def read_command(top, parameters=(), formal=False, files=()):
    """Returns Yosys's commands that read the files, or else all of rtl, and set parameters ("NAME=VALUE") of the module
    `top`. What is proved is what is synthesized."""
    files = " ".join(f'"{file}"' for file in files or sources())
    sets = "".join(f" -set {text.replace('=', ' ', 1)}" for text in parameters)
    return f"read_verilog {'-formal -DSYNTHESIS ' if formal else ''}-sv {files}; " + (f"chparam{sets} {top}; " if sets else "")


def plain(text):
    """Returns only the circuit of a source: without comments, proofs and simulation checks, one statement a line,
    single blanks."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)
    text = re.sub(r"`ifdef FORMAL\b(.*?)(?:`else\b(.*?))?`endif\b", lambda match: match[2] or "", text, flags=re.S)
    text = re.sub(r"`ifndef SYNTHESIS\b.*?`endif\b", "", text, flags=re.S)
    text = re.sub(r"^[ \t]*`default_nettype \w+[ \t]*$", "", text, flags=re.M)
    if "`" in text or not all(re.fullmatch(r"\w*", string) for string in text.split('"')[1::2]):
        raise ValueError(f"a directive or a string that plain() does not know: {text.splitlines()[0]}")
    text = re.sub(r" ?([][(){},;]) ?", r"\1", re.sub(r"\s+", " ", text).strip())
    return "`default_nettype none\n" + text.replace(";", ";\n").strip() + "\n`default_nettype wire\n"


def plain_texts(more=(), root=ROOT):
    """Returns the plain text of every source, and of the files `more`, by name below the root, in reading order."""
    return {path.relative_to(root): plain(path.read_text()) for path in [*sources(root / "rtl"), *more]}


def write(texts, folder):
    """Writes the texts, by name, into the folder."""
    for name, text in texts.items():
        to = pathlib.Path(folder) / name
        to.parent.mkdir(parents=True, exist_ok=True)
        to.write_text(text)


def plant(folder, file, old, new):
    """Copies rtl/ into folder, replaces the one occurrence of old in the file by new, and returns the path.

    In the file, lines may break at any blank of old.
    """
    copy = pathlib.Path(folder) / "rtl"
    shutil.copytree(ROOT / "rtl", copy)
    text = (copy / file).read_text()
    pattern = re.compile(r"\s+".join(re.escape(word) for word in old.split()))
    count = len(pattern.findall(text))
    if count != 1:
        raise PlantError(f"rtl/{file} holds '{old}' {count} times, not once")
    (copy / file).write_text(pattern.sub(lambda _: new, text))
    return copy


if __name__ == "__main__":
    print(*(path.relative_to(ROOT) for path in sources_of(sys.argv[1])), sep="\n")
