#!/usr/bin/env python3
"""Makes the pages of the circuits' modules from their sources: the comment at the head of the file, drawings as text
blocks; parameters and ports as tables, from the declarations and the comments beside them.

    modules.py      makes every page, and says which it cannot make

The pages are made when the site is built (hooks.py). Parameters below "derived, do not set", and ports for the proofs,
are left out. Standard library only.
"""

import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
PORT = re.compile(r"(input|output)\s+(?:wire\s+)?logic\s*(?:\[([^\]]+):(\w+)\])?\s*(\w+)$")
PARAMETER = re.compile(r"parameter\s+(?:\w+\s+)?(?:\[[^\]]+\]\s*)?(\w+)\s*=\s*(.+)$", re.DOTALL)


class SourceError(Exception):
    """A module or file is missing, or has a form that this script does not know."""


def source_of(module):
    for path in sorted(ROOT.glob(f"rtl/*/{module}.sv")):
        return path.read_text(encoding="utf-8")
    raise SourceError(f"no module {module} under rtl/")


SETTINGS = ("grey_over",)  # values, written as words


def marked(text):
    """Returns the text with names marked as code."""
    names = r"(?<![\w`/])([a-z][a-z0-9]*(?:_[a-z0-9*]+)+|[A-Z][a-z]+[A-Z]\w*|[a-z]+(?:/[\w.-]+)+)(?![\w`])"
    return re.sub(names, lambda name: name.group() if name.group() in SETTINGS else f"`{name.group()}`", text)


def head(module):
    """Returns the comment at the head of a module's file as Markdown."""
    lines = []
    for line in source_of(module).splitlines():
        if not line.startswith("//"):
            break
        lines.append(line[3:])
    out, at = [], 0
    while at < len(lines):
        line = lines[at]
        if line.startswith("  ") and not (out and out[-1].startswith("* ")):
            block = []
            while at < len(lines) and (lines[at].startswith("  ") or not lines[at] and block and at + 1 < len(lines)
                                       and lines[at + 1].startswith("  ")):
                block.append(lines[at])
                at += 1
            out += ["```text", *textwrap.dedent("\n".join(block)).splitlines(), "```"]
            continue
        at += 1
        if not line:
            out.append("")
            continue
        text = line
        while at < len(lines) and lines[at] and not lines[at].startswith("* ") and (
                line.startswith("* ") or not lines[at].startswith("  ")):
            text += " " + lines[at].strip()
            at += 1
        out += textwrap.wrap(marked(text), 120, subsequent_indent="  " if line.startswith("* ") else "",
                             break_on_hyphens=False, break_long_words=False)
    return out


def declarations(module, opening, closing):
    return declarations_in(source_of(module), module, opening, closing)


def declarations_in(text, module, opening, closing):
    """(heading or None, declaration, comment) of the module's list between two lines of its source."""
    text = re.sub(r"`ifdef FORMAL\n.*?`endif\n", "", text, flags=re.DOTALL)
    found = re.search(rf"^module {module} .*?{opening}\n(.*?)^{closing}", text, re.DOTALL | re.MULTILINE)
    if not found:
        raise SourceError(f"{module}: no list from {opening} to {closing}")
    heading, pending, comment, was_note = None, "", "", False
    lines = found.group(1).splitlines()
    for number, line in enumerate(lines):
        code, _, note = line.partition("//")
        code, note = code.strip(), note.strip()
        if not code:
            if not note:
                heading = None
            elif not pending:
                heading = f"{heading} {note}" if heading and was_note else note
            was_note = True
            continue
        was_note = False
        pending, comment = f"{pending} {code}".strip(), f"{comment} {note}".strip()
        if code.endswith(",") or number == len(lines) - 1:
            yield heading, pending.rstrip(","), comment
            pending, comment = "", ""


def value_of(text):
    """Returns a default in which names of the package are replaced by their values."""
    package = (ROOT / "rtl/common/sp_spec_pkg.sv").read_text(encoding="utf-8")
    text = re.sub(r"sp_spec_pkg::(\w+)",
                  lambda name: re.search(rf"\b{name.group(1)} = ([^;]+);", package).group(1), text)
    return re.sub(r"\b1'b([01])\b", r"\1", text)


def has_parameters(module):
    return re.search(rf"^module {module} #", source_of(module), re.MULTILINE) is not None


def parameters(module):
    out = ["| parameter | default | meaning |", "|---|---|---|"]
    for heading, text, comment in declarations(module, r"#\(", r"\) \("):
        if heading == "derived, do not set":
            break
        found = PARAMETER.match(text)
        if not found:
            raise SourceError(f"{module}: cannot read '{text}'")
        default = value_of(found.group(2))
        meaning = comment or (heading or "").rstrip(":")
        out.append(f"| `{found.group(1)}` | `{default}` | {marked(meaning)} |")
    return out


def bits_of(msb, lsb):
    """Returns the number of bits of [msb:lsb], as a number or an expression."""
    if msb is None:
        return "1"
    if lsb != "0":
        return f"`{msb[:-2]} - {lsb}`" if msb.endswith("-1") else f"`{msb} - {lsb} + 1`"
    if msb.isdigit():
        return str(int(msb) + 1)
    return f"`{msb[:-2]}`" if msb.endswith("-1") else f"`{msb} + 1`"


def ports(module):
    out, last = ["| port | | bits | meaning |", "|---|---|---:|---|"], None
    opening = r"\) \(" if has_parameters(module) else r"\("
    for heading, text, comment in declarations(module, opening, r"\);"):
        found = PORT.match(re.sub(r"\s+", " ", text))
        if not found:
            raise SourceError(f"{module}: cannot read '{text}'")
        if heading and heading != last:
            out.append(f"| *{marked(heading.rstrip('.'))}* | | | |")
        last = heading
        direction = {"input": "in", "output": "out"}[found.group(1)]
        bits = bits_of(found.group(2) and found.group(2).replace("sp_spec_pkg::", ""), found.group(3))
        out.append(f"| `{found.group(4)}` | {direction} | {bits} | {marked(comment)} |")
    return out


def page(module):
    parts = [f"# {module}", "", *head(module), ""]
    if has_parameters(module):
        parts += ["## Parameters", "", *parameters(module), ""]
    return "\n".join([*parts, "## Ports", "", *ports(module)]) + "\n"


def pages():
    """Returns {name of a file: its text} for all modules."""
    names = sorted(path.stem for path in ROOT.glob("rtl/*/sp_*.sv") if path.stem != "sp_spec_pkg")
    return {f"{name}.md": page(name) for name in names}


def main():
    try:
        print(f"{len(pages())} pages of modules")
    except SourceError as error:
        print(f"modules.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
