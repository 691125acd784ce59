#!/usr/bin/env python3
"""Writes the pages of the commands, docs/commands/, from the help of the programs.

    command_pages.py [--check] [PROGRAMS]

PROGRAMS is the folder of selfproj and selfproj-sim, build/bin unless given. A page has everything that --help of its
command says. Text below the line `<!-- notes -->` of a page is written by hand and kept. With --check nothing is
written, and the exit status is 1 if a page is out of date.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAMS = ("selfproj", "selfproj-sim")
HEAD = ("<!-- Written by scripts/command_pages.py from what the program says of itself. "
        "Edit the help in its sources. -->")
NOTES = "<!-- notes -->"
NOT_RUN = re.compile(r" \((needs hardware|needs your files|takes minutes)\)$")
WIDTH = 120


def describe(programs):
    """Returns {name of a command: its description} for all commands of both programs."""
    commands = {}
    for program in PROGRAMS:
        run = subprocess.run([str(programs / program), "--help-json"], capture_output=True, text=True, check=True)
        commands.update({command["name"]: command for command in json.loads(run.stdout)})
    return commands


def page_of(name):
    return name.replace(" ", "-") + ".md"


def linked(text, commands, name):
    """Returns the text with a link at each command that it mentions, except the command of this page."""
    def link(match):
        command = match.group(1)
        return f"[`{command}`]({page_of(command)})" if command in commands and command != name else match.group()
    return re.sub(r"`([a-z][a-z -]*[a-z])`", link, text)


def wrapped(text, indent=""):
    """Words in lines of at most WIDTH characters. Code spans and links are one word."""
    lines, line = [], ""
    for word in re.findall(r"(?:\[[^\]]*\]\([^)]*\)|`[^`]*`|\S)+", text):
        if line and len(line) + 1 + len(word) > WIDTH:
            lines.append(line)
            line = indent + word
        else:
            line = f"{line} {word}" if line else word
    return "\n".join([*lines, line])


def paragraphs(texts, commands, name):
    parts, item_before = [], False
    for text in texts:
        item = text.startswith("- ")
        parts.append(("" if item and item_before else "\n") +
                     wrapped(linked(text, commands, name), "  " if item else ""))
        item_before = item
    return "\n".join(parts).strip("\n") + "\n"


def example_groups(text):
    """Returns (purpose, lines, why it is not run or None) of each group of lines under a comment."""
    groups = []
    for line in text.splitlines():
        if line.startswith("# "):
            reason = NOT_RUN.search(line)
            groups.append((NOT_RUN.sub("", line[2:]), [], reason.group(1) if reason else None))
        elif line.strip():
            groups[-1][1].append(line)
    return groups


def examples(command, commands):
    parts = []
    for effect, lines, reason in example_groups(command["examples"]):
        mark = f"<!-- not run: {reason} -->\n" if reason else ""
        parts.append(f"{wrapped(effect.rstrip('.') + ':')}\n\n{mark}```sh\n" + "\n".join(lines) + "\n```\n")
    return "\n".join(parts)


def cell(text):
    return text.replace("|", r"\|")


def table(title, options, commands, name):
    rows = [f"| {title} | meaning | values |", "|---|---|---|"]
    for option in options:
        meaning = linked(option["text"], commands, name)
        rows.append(f"| `{cell(option['name'])}` | {cell(meaning)} | {cell(option['facts'].strip('[]'))} |")
    return "\n".join(rows) + "\n"


def list_of(names, commands):
    rows = ["| command | purpose |", "|---|---|"]
    rows += [f"| [`{name}`]({page_of(name)}) | {commands[name]['purpose']} |" for name in names]
    return "\n".join(rows) + "\n"


def page(name, commands):
    command = commands[name]
    parts = [f"# {name}\n", HEAD + "\n", command["purpose"] + "\n", f"```text\nUsage: {command['usage']}\n```\n"]
    if command["details"]:
        parts.append(paragraphs(command["details"], commands, name))
    if command["commands"]:
        parts += ["## Commands\n", list_of(command["commands"], commands)]
    parts += ["## Examples\n", examples(command, commands)]
    groups = [group for group in command["groups"] if group["name"] != "Help"]
    if command["arguments"] or groups:
        parts.append("## Options\n")
    if command["arguments"]:
        parts.append(table("argument", command["arguments"], commands, name))
    for group in groups:
        parts += [f"**{group['name']}**\n", table("option", group["options"], commands, name)]
    return "\n".join(parts)


def index(commands):
    parts = ["# Commands\n", HEAD + "\n",
             "Every command explains itself with `--help`. These pages say the same.\n"]
    for program in PROGRAMS:
        names = [name for name in commands if name.startswith(program + " ")]
        parts += [f"## {program}\n", commands[program]["purpose"] + "\n", list_of(names, commands)]
    parts += ["## What holds for all commands\n",
              paragraphs(commands[PROGRAMS[1]]["details"], commands, "")]
    return "\n".join(parts)


def pages(programs):
    """Returns {file: its text}. Notes of existing pages are kept."""
    commands = describe(programs)
    folder = ROOT / "docs/commands"
    texts = {folder / page_of(name): page(name, commands) for name in commands if " " in name}
    texts[folder / "index.md"] = index(commands)
    for file, text in texts.items():
        _, mark, notes = (file.read_text(encoding="utf-8") if file.exists() else "").partition(f"\n{NOTES}\n")
        texts[file] = text + mark + notes
    return texts


def main():
    words = sys.argv[1:]
    check = "--check" in words
    words = [word for word in words if word != "--check"]
    texts = pages(pathlib.Path(words[0] if words else ROOT / "build/bin").resolve())
    there = set((ROOT / "docs/commands").glob("*.md"))
    wrong = [f"{file.relative_to(ROOT)}: no command has this page" for file in sorted(there - set(texts))]
    for file, text in texts.items():
        if not check:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        elif file not in there or file.read_text(encoding="utf-8") != text:
            wrong.append(f"{file.relative_to(ROOT)}: is not what the program says; run scripts/command_pages.py")
    print("\n".join(wrong) if wrong else f"{len(texts)} pages of commands")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
