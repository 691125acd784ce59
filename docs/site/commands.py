#!/usr/bin/env python3
"""Makes the pages of the commands from the help of the programs.

    commands.py [--check] [PROGRAMS]

PROGRAMS is the folder of selfproj and selfproj-sim, build/bin unless given. The pages are made when the site is built
(hooks.py), and have everything that --help of a command says. Only their index, docs/commands/index.md, is committed:
this writes it. With --check nothing is written, and the exit status is 1 if the index is out of date.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
INDEX = ROOT / "docs/commands/index.md"
PROGRAMS = ("selfproj", "selfproj-sim")
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


def list_of(names, cells, commands):
    rows = ["| command | purpose |", "|---|---|"]
    rows += [f"| {cell} | {commands[name]['purpose']} |" for name, cell in zip(names, cells)]
    return "\n".join(rows) + "\n"


def page(name, commands):
    command = commands[name]
    parts = [f"# {name}\n", command["purpose"] + "\n", f"```text\nUsage: {command['usage']}\n```\n"]
    if command["details"]:
        parts.append(paragraphs(command["details"], commands, name))
    if command["commands"]:
        names = command["commands"]
        parts += ["## Commands\n", list_of(names, [f"[`{name}`]({page_of(name)})" for name in names], commands)]
    parts += ["## Examples\n", examples(command, commands)]
    groups = [group for group in command["groups"] if group["name"] != "Help"]
    if command["arguments"] or groups:
        parts.append("## Options\n")
    if command["arguments"]:
        parts.append(table("argument", command["arguments"], commands, name))
    for group in groups:
        parts += [f"**{group['name']}**\n", table("option", group["options"], commands, name)]
    return "\n".join(parts)


def anchor_of(name):
    return name.replace(" ", "-")


def index(commands):
    """Returns the index. Each command has an anchor, which the site replaces by a link to the command's page."""
    parts = ["# Commands\n",
             "<!-- Written by docs/site/commands.py from what the programs say of themselves. -->\n",
             wrapped("Every command explains itself with `--help`: its options, their units and ranges, and examples. "
                     "The [site](../contributing.md#the-site) has a page of each command, which says the same.") + "\n"]
    for program in PROGRAMS:
        names = [name for name in commands if name.startswith(program + " ")]
        cells = [f'<a id="{anchor_of(name)}"></a>`{name}`' for name in names]
        parts += [f"## {program}\n", commands[program]["purpose"] + "\n", list_of(names, cells, commands)]
    parts += ["## What holds for all commands\n",
              paragraphs(commands[PROGRAMS[1]]["details"], {}, "")]
    return "\n".join(parts)


def pages(programs):
    """Returns {name of a file: its text} for all commands."""
    commands = describe(programs)
    return {page_of(name): page(name, commands) for name in commands if " " in name}


def main():
    words = [word for word in sys.argv[1:] if word != "--check"]
    programs = pathlib.Path(words[0] if words else ROOT / "build/bin").resolve()
    text = index(describe(programs))
    if "--check" not in sys.argv:
        INDEX.write_text(text, encoding="utf-8")
    elif INDEX.read_text(encoding="utf-8") != text:
        print(f"{INDEX.relative_to(ROOT)}: is not what the programs say; run docs/site/commands.py")
        return 1
    print(f"{len(pages(programs))} pages of commands")
    return 0


if __name__ == "__main__":
    sys.exit(main())
