#!/usr/bin/env python3
"""results.py: handles figures as data, and the tables of the documents that are generated from them: results/*.json
and results/*.toml, those of the laboratory in lab/results/.

    results.py update [ROOT]     rewrites the tables and figures in all Markdown files
    results.py check [ROOT]      exit status 1 where one differs from what results/ says, or is typed a second time
    results.py record NAME --about TEXT --command TEXT KEY=VALUE...     writes a result, for shell scripts

Programs write a result where the environment variable SELFPROJ_RESULTS names a folder: C++ by host/files/results_file.h,
Python by write() below. Both give the same envelope: about, command, date, commit, machine, results.

The TOML files define the tables. In a document a table stands between two comments, and so does a figure within
a sentence, which is named by a reference as in a cell:

    <!-- table NAME -->               <!-- =bench_gray/decode/cache_per_s:,.0f -->38,834<!-- end -->
    ...
    <!-- end -->

A cell is a text with references in braces. NAME/KEY/KEY:FORMAT is a value of NAME.json in Python's format; M
before the format shows millions, % a percentage. Of a table that a program wrote (header, rows) the keys are the names
of a row and of a column. NAME/KEY >= NUMBER is a goal: it shows the sign and the number, and the column `met` follows
from it, unless the row says `met` itself; of "4.1 / 102.2" and "53.5 ± 0.1" the first number counts. In a table with
`each`, /KEY is a value of the row's own object and @ is its name; `for` has a list of words for each row, which stand
for $1, $2, ... in the columns. Standard library only.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
VARIABLE = "SELFPROJ_RESULTS"
FOLDERS = ("results", "lab/results")
ENVELOPE = ["about", "command", "date", "commit", "machine", "results"]
SIGNS = {">=": "≥ ", "<=": "≤ ", "==": ""}
HEADS = {"what": "what", "published": "thesis", "goal": "goal", "result": "measured", "met": "met", "command": "by"}
BLOCK = re.compile(r"^<!-- table (\S+) -->\n(?:(?!<!--).*\n)*?<!-- end -->$", re.M)
FIGURE = re.compile(r"<!-- =(\S.*?) -->(.*?)<!-- end -->")
REFERENCE = re.compile(r"\{([^{}]+)\}")
# A number with a comma or a point. A number of at least four digits, apart from zeros at its ends, is searched for
# elsewhere.
LONG = re.compile(r"(?<![\w.,/-])(?:\d{1,3}(?:,\d{3})+(?:\.\d+)?|\d+\.\d+)(?![\w/]|[.,]\d)")


class ResultsError(Exception):
    """Says what is wrong with a result, a table or a document."""


# ---- writing ----


def git(root, *words):
    said = subprocess.run(["git", "-C", root, *words], capture_output=True, text=True, check=False)
    return said.stdout.strip()


def commit(root):
    head = git(root, "rev-parse", "--short=10", "HEAD")
    differs = git(root, "status", "--porcelain", "-uno", "--", ":/", *(f":(top,exclude){folder}" for folder in FOLDERS),
                  ":(top,exclude)*.md")
    return head + ("+" if differs else "") if head else "unknown"


def machine():
    cpu = re.search(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.M)
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30
    return {"cpu": cpu[1] if cpu else "unknown", "cores": os.cpu_count(), "memory_gib": round(memory, 1),
            "load": round(os.getloadavg()[0], 1)}


def depth_of(value):
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return 0 if inner is None else 1 + max(map(depth_of, inner), default=0)


def has_table(value):
    if isinstance(value, dict):
        return "rows" in value or any(map(has_table, value.values()))
    return isinstance(value, list) and any(map(has_table, value))


def text_of(value, indent=0, is_record=False, is_table=False):
    """Returns a value as JSON with one record a line: an element of a list, a row of a table, and anything that is
    nested at most two levels deep is one line. host/files/results_file.cpp writes the same."""
    is_short = is_record or (indent > 0 and depth_of(value) <= 2)
    if depth_of(value) == 0 or (is_short and not is_table and not has_table(value)):
        return json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    is_object = isinstance(value, dict)
    lines = [" " * (indent + 1) + (json.dumps(key, ensure_ascii=False) + ": " if is_object else "") +
             text_of(inner, indent + 1, not is_object, key == "rows")
             for key, inner in (value.items() if is_object else enumerate(value))]
    start, end = "{}" if is_object else "[]"
    return start + "\n" + ",\n".join(lines) + "\n" + " " * indent + end


def write(name, about, command, results, folder=None):
    """Writes NAME.json into `folder`, or else into the folder that SELFPROJ_RESULTS names. Without either it does
    nothing."""
    folder = folder or os.environ.get(VARIABLE)
    if not folder:
        return
    today = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    envelope = {"about": about, "command": command, "date": today, "commit": commit(ROOT), "machine": machine(),
                "results": results}
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(text_of(envelope) + "\n", encoding="utf-8")


def recorded(name):
    """Returns the results of NAME.json in the folder that SELFPROJ_RESULTS names; {} without such a file or folder."""
    file = pathlib.Path(os.environ[VARIABLE]) / f"{name}.json" if os.environ.get(VARIABLE) else None
    return json.loads(file.read_text(encoding="utf-8"))["results"] if file and file.is_file() else {}


def number_or_text(text):
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


def record(args):
    results = {}
    for word in args.values:
        key, equals, value = word.partition("=")
        if not equals:
            raise ResultsError(f"{word}: not KEY=VALUE")
        *path, last = key.split("/")
        inner = results
        for part in path:
            inner = inner.setdefault(part, {})
        inner[last] = number_or_text(value)
    write(args.name, args.about, args.command, results)


# ---- tables ----


class Results:
    """Gives the values of the results of a tree by reference."""

    def __init__(self, root):
        self.files = {}
        self.folders = {}
        for path in sorted(path for folder in FOLDERS for path in (root / folder).glob("*.json")):
            shown = path.relative_to(root).as_posix()
            text = path.read_text(encoding="utf-8")
            try:
                file = json.loads(text)
            except ValueError as error:
                raise ResultsError(f"{shown}: {error}") from None
            if text.count("\n") != text_of(file).count("\n") + 1:
                raise ResultsError(f"{shown}: has not one record a line, as write() would give it")
            missing = [key for key in ENVELOPE if key not in file]
            if missing:
                raise ResultsError(f"{shown}: without {', '.join(missing)}")
            if path.stem in self.files:
                raise ResultsError(f"{shown}: the name is there twice")
            self.files[path.stem] = file
            self.folders[path.stem] = path.relative_to(root).parent.as_posix()

    def value(self, path, row=None):
        """Returns the value of NAME/KEY/..., or of /KEY/... in the object `row`."""
        name, *keys = path.split("/")
        if name == "" and row is not None:
            found = row
        elif name in self.files:
            found = self.files[name]["results"]
        else:
            raise ResultsError(f"{path}: there is no result {name}")
        for key in keys:
            try:
                if isinstance(found, dict) and "header" in found and "rows" in found:
                    found = next(dict(zip(found["header"], row)) for row in found["rows"] if row[0] == key)
                else:
                    found = found[int(key)] if isinstance(found, list) else found[key]
            except (KeyError, IndexError, ValueError, TypeError, StopIteration):
                raise ResultsError(f"{path}: there is no {key}") from None
        return found


def formatted(value, spec):
    if isinstance(value, str):
        return value
    if value is None:
        return "–"
    if spec.startswith("M"):
        value, spec = value / 1e6, spec[1:]
    try:
        text = format(value, spec)
    except (ValueError, TypeError):
        raise ResultsError(f"{value}: not to be shown as :{spec}") from None
    return text.replace("%", " %").replace("-", "−") if isinstance(value, (int, float)) else text


def is_distinct(figure):
    return len(figure.replace(",", "").replace(".", "").strip("0")) >= 4


class Cells:
    """Fills references in texts."""

    def __init__(self, results):
        self.results = results
        self.shown = {}  # figure -> the reference that it came from

    def fill(self, text, row=None, name=""):
        return REFERENCE.sub(lambda match: self.one(match[1], row, name), str(text))

    def one(self, reference, row=None, name=""):
        if reference == "@":
            return name
        if goal := re.fullmatch(r"(.+?) (>=|<=|==) (.*)", reference):
            self.results.value(goal[1])
            return SIGNS[goal[2]] + goal[3]
        path, spec = re.fullmatch(r"(.+?)(?::([^/]*))?", reference).groups(default="")  # a key may have a colon, too
        text = formatted(self.results.value(path, row), spec)
        for figure in LONG.findall(text):
            if is_distinct(figure):
                self.shown[figure] = reference
        return text

    def met(self, text):
        """Returns yes, **no**, or – if the text has no goal."""
        answers = []
        for reference in REFERENCE.findall(text):
            if goal := re.fullmatch(r"(.+?) (>=|<=|==) (.*)", reference):
                value = float(re.split(" [/±] ", str(self.results.value(goal[1])))[0])
                limit = float(goal[3].replace(",", "").replace("%", "").strip()) / (100 if "%" in goal[3] else 1)
                answers.append({">=": value >= limit, "<=": value <= limit, "==": value == limit}[goal[2]])
        return "–" if not answers else "yes" if all(answers) else "**no**"

    def commands(self, text):
        names = dict.fromkeys(reference.split("/")[0] for reference in REFERENCE.findall(text))
        return ", ".join(f"`{self.results.files[name]['command']}`" for name in names)


def with_words(text, words):
    """Returns the text with $1, $2, ... replaced by the words."""
    return re.sub(r"\$(\d)", lambda match: words[int(match[1]) - 1], text)


class Tables:
    """The tables that the TOML files in each folder define."""

    def __init__(self, root):
        self.results = Results(root)
        self.cells = Cells(self.results)
        self.definitions = {}
        for folder in FOLDERS:
            for file in sorted((root / folder).glob("*.toml")):
                try:
                    self.definitions |= tomllib.loads(file.read_text(encoding="utf-8"))
                except tomllib.TOMLDecodeError as error:
                    raise ResultsError(f"{folder}/{file.name}: {error}") from None
        self.rows = {row["id"]: row for table in self.definitions.values() for row in table.get("rows", [])
                     if isinstance(row, dict) and "id" in row}

    def table(self, name):
        if name in ("sources", "lab-sources"):
            head, rows = self.sources(FOLDERS[name == "lab-sources"])
        elif name not in self.definitions:
            raise ResultsError(f"no TOML file of results has a table {name}")
        else:
            head, rows = self.defined(self.definitions[name])
        lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in [head, *rows]]
        lines.insert(1, "|" + "|".join("---" for _ in head) + "|")
        return "\n".join(lines) + "\n"

    def defined(self, definition):
        if "print" in definition:  # a table that a program has made
            table = self.results.value(definition["print"])
            for text in (cell for row in table["rows"] for cell in row):
                self.cells.shown.update({figure: definition["print"] for figure in LONG.findall(text)
                                         if is_distinct(figure)})
            return table["header"], table["rows"]
        if "each" in definition:
            items = self.results.value(definition["each"])
            items = items.items() if isinstance(items, dict) else enumerate(items)
            columns = definition["columns"]
            return list(columns), [[self.cells.fill(cell, value, str(key)) for cell in columns.values()]
                                   for key, value in items]
        if "for" in definition:
            columns = definition["columns"]
            return list(columns), [[self.cells.fill(with_words(cell, words)) for cell in columns.values()]
                                   for words in definition["for"]]
        rows = [self.rows[row] if isinstance(row, str) else row for row in definition["rows"]]
        if isinstance(definition["columns"], dict):
            return list(definition["columns"].values()), [self.plain(row, definition["columns"]) for row in rows]
        return [HEADS[key] for key in definition["columns"]], [self.plain(row, definition["columns"]) for row in rows]

    def plain(self, row, columns):
        row = {"brief_" + key: row.get(key, "–") for key in ("goal", "result")} | {"brief": row.get("what", "–"), **row}
        cells = {key: self.cells.fill(row.get(key, "–")) for key in columns if key not in ("met", "command")}
        if "met" in columns:
            cells["met"] = row["met"] if "met" in row else self.cells.met(row.get("goal", ""))
        if "command" in columns:
            cells["command"] = (self.cells.fill(row["command"]) if "command" in row else
                                self.cells.commands(row["result"]))
        return [cells[key] for key in columns]

    def sources(self, folder):
        rows = []
        for name, file in self.results.files.items():
            if self.results.folders[name] != folder:
                continue
            machine_of = file["machine"]
            where = (f"{machine_of['cpu']}, {machine_of['cores']} cores, {machine_of['memory_gib']:.0f} GiB, load "
                     f"{machine_of['load']}" if machine_of else file["recorded"])
            rows.append([f"[{name}]({'../' if folder == FOLDERS[0] else ''}results/{name}.json)", file["about"], f"`{file['command']}`",
                         f"{file['date']}, {file['commit']}", where])
        return ["file", "what", "command", "date, commit", "machine"], rows


# ---- documents ----


def documents(root):
    names = git(root, "ls-files", "-co", "--exclude-standard", "*.md").split("\n")
    return [root / name for name in sorted(names) if name and (root / name).is_file()]


def without_code(text):
    """Returns the text with fences and `quotes` blanked out, so that examples do not count as markers."""
    blank = lambda match: re.sub(r"[^\n]", " ", match[0])
    return re.sub(r"^    .*$", blank, re.sub(r"^```.*?^```$|`[^`\n]*`", blank, text, flags=re.M | re.S), flags=re.M)


def filled(text, tables):
    """Returns the document with its tables and figures brought up to date."""
    code_free = without_code(text)
    if early := re.search(r"^[ ]*<!-- =", code_free, re.M):  # Markdown takes the line as HTML
        raise ResultsError(f"{line_of(text, early.start())}: a line begins with a figure; put a word before it")
    if broken := re.search(r"<!--\s*\n\s*=|<!-- =[^>]*\n", code_free):
        raise ResultsError(f"{line_of(text, broken.start())}: a figure's name goes over the end of the line")
    for opening in re.finditer(r"<!-- (?:table \S+|=\S.*?) -->", code_free):
        if not (BLOCK.match(text, opening.start()) or FIGURE.match(text, opening.start())):
            raise ResultsError(f"{line_of(text, opening.start())}: {opening[0]} without its <!-- end -->")

    def block(match):
        if code_free[match.start()] == " ":
            return match[0]
        return f"<!-- table {match[1]} -->\n{tables.table(match[1])}<!-- end -->"

    def figure(match):
        if code_free[match.start()] == " ":
            return match[0]
        return f"<!-- ={match[1]} -->{tables.cells.one(match[1])}<!-- end -->"

    parts, at = [], 0
    for match in sorted([*BLOCK.finditer(text), *FIGURE.finditer(text)], key=lambda found: found.start()):
        parts += [text[at:match.start()], (block if match.re is BLOCK else figure)(match)]
        at = match.end()
    return "".join(parts) + text[at:]


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def typed_again(text, shown):
    """Yields figures of generated tables that are typed elsewhere: (line, figure, reference)."""
    blank = lambda match: re.sub(r"[^\n]", " ", match[0])
    rest = re.sub(r"<!-- BEGIN GENERATED.*?<!-- END GENERATED[^>]*-->", blank, text, flags=re.S)
    rest = FIGURE.sub(blank, BLOCK.sub(blank, rest))
    found = [match for match in LONG.finditer(rest) if match[0] in shown]
    return [(line_of(text, match.start()), match[0], shown[match[0]]) for match in found]


def faults(root):
    """Returns the faults of the documents of a tree, one line for each."""
    found = []
    tables = Tables(root)
    for name in tables.definitions:
        tables.table(name)
    texts = {path: path.read_text(encoding="utf-8") for path in documents(root)}
    for path, text in texts.items():
        name = path.relative_to(root).as_posix()
        try:
            wanted = filled(text, tables)
        except ResultsError as error:
            found.append(f"{name}: {error}")
            continue
        for number, (is_, should) in enumerate(zip(text.split("\n"), wanted.split("\n")), 1):
            if is_ != should:
                found.append(f"{name}:{number}: not what results/ says; run scripts/results.py update")
                break
        else:
            if text != wanted:
                found.append(f"{name}: not what results/ says; run scripts/results.py update")
    for path, text in texts.items():
        name = path.relative_to(root).as_posix()
        for number, figure, reference in typed_again(text, tables.cells.shown):
            found.append(f"{name}:{number}: {figure} is typed; it is a figure of results/ ({reference})")
    return found


def update(root):
    tables = Tables(root)
    for path in documents(root):
        text = path.read_text(encoding="utf-8")
        try:
            wanted = filled(text, tables)
        except ResultsError as error:
            raise ResultsError(f"{path.relative_to(root).as_posix()}: {error}") from None
        if wanted != text:
            path.write_text(wanted, encoding="utf-8")
            print(path.relative_to(root).as_posix())


def main():
    parser = argparse.ArgumentParser(description="Figures as data, and the tables of the documents.")
    commands = parser.add_subparsers(dest="job", required=True)
    for job in ("update", "check"):
        commands.add_parser(job).add_argument("root", nargs="?", type=pathlib.Path, default=ROOT)
    recording = commands.add_parser("record")
    recording.add_argument("name")
    recording.add_argument("--about", required=True)
    recording.add_argument("--command", required=True)
    recording.add_argument("values", nargs="+", metavar="KEY=VALUE")
    args = parser.parse_args()
    if args.job == "record":
        record(args)
    elif args.job == "update":
        update(args.root.resolve())
    else:
        found = faults(args.root.resolve())
        print("\n".join(found) if found else "every table and figure is as results/ says")
        return 1 if found else 0
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except ResultsError as error:
        print(f"results.py: {error}", file=sys.stderr)
        sys.exit(2)
