"""Reads lists of exceptions with lines of the form `pattern | pattern | reason`.

An indented line continues the one before. Empty lines and lines that begin with # are left out. Standard library only.
"""

import re


def read(path):
    """[(regular expression, regular expression, reason), ...]; ValueError names the line that is not of this form."""
    rules = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        if line[0] == " " and rules:
            rules[-1][1] += " " + line.strip()
        else:
            rules.append([number, line])
    return [rule(path, number, text) for number, text in rules]


def rule(path, number, text):
    fields = [field.strip() for field in text.split(" | ", 2)]
    if len(fields) != 3 or not all(fields):
        raise ValueError(f"{path}:{number}: not `pattern | pattern | reason`")
    try:
        return re.compile(fields[0]), re.compile(fields[1]), fields[2]
    except re.error as error:
        raise ValueError(f"{path}:{number}: {error}") from error
