"""Shared by the tests of the documents: headings, links, blocks of code and command lines of Markdown files."""

import dataclasses
import pathlib
import re
import shlex
import subprocess
import unicodedata

COMMENT = re.compile(r"^<!-- (not run|run shortened|output)(?:: (.+?))? -->$")
FENCE = re.compile(r"^( *)(```+|~~~+)\s*(\S*)\s*$")
HEADING = re.compile(r"^(#{1,6})\s+(.*?)\s*#*$")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(<?([^()\s<>]+(?:\([^()\s]*\))?)>?(?:\s+\"[^\"]*\")?\)")
REFERENCE = re.compile(r"^ {0,3}\[([^\]]+)\]:\s+<?(\S+?)>?\s*$")
SPAN = re.compile(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)")
PROGRAMS = ("selfproj", "selfproj-sim", "build/bin/selfproj", "build/bin/selfproj-sim")


@dataclasses.dataclass
class Block:
    """A fenced block of code, or one that is indented by four spaces."""
    line: int        # of its first line of code, from 1
    language: str    # "" where none is named
    text: str
    marks: list      # (kind, text) of the comments right before it: ("not run", "needs hardware")
    fenced: bool = True


@dataclasses.dataclass
class Document:
    name: str
    lines: list
    prose: list      # as many lines; empty where a line is code
    blocks: list
    headings: list   # (line from 1, level, text)
    unclosed: int    # line of a fence that nothing closes, else 0

    def links(self):
        """(line from 1, whether it is a picture, text, target)"""
        for number, line in enumerate(self.prose, 1):
            bare = SPAN.sub(lambda span: "x" * len(span.group()), line)
            for match in LINK.finditer(bare):
                yield number, match.group(1) == "!", match.group(2), match.group(3)
            match = REFERENCE.match(bare)
            if match:
                yield number, False, match.group(1), match.group(2)

    def spans(self):
        """(line from 1, text) of code within a line."""
        for number, line in enumerate(self.prose, 1):
            for match in SPAN.finditer(line):
                yield number, match.group(2).strip().replace("\\|", "|")

    def anchors(self):
        """Returns the anchors of headings on which Markdown viewers and mkdocs agree, and anchors that are written
        out."""
        ours, theirs, seen = set(), set(), {}
        for _, _, text in self.headings:
            slug = github_slug(text)
            count = seen[slug] = seen.get(slug, -1) + 1
            ours.add(f"{slug}-{count}" if count else slug)
            theirs.add(f"{mkdocs_slug(text)}_{count}" if count else mkdocs_slug(text))
        written = set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", "\n".join(self.prose)))
        return (ours & theirs) | written


def plain(heading):
    """Returns the text of a heading without the marks of code, links and emphasis."""
    heading = LINK.sub(lambda match: match.group(2), heading)
    return re.sub(r"[`*]", "", heading)


def github_slug(heading):
    text = plain(heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def mkdocs_slug(heading):
    text = unicodedata.normalize("NFKD", plain(heading)).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", text).strip().lower())


def parse(name, text):
    document = Document(name, text.split("\n"), [], [], [], 0)
    fence = None     # (its indentation, its mark, its block)
    marks = []
    in_comment = False
    for number, line in enumerate(document.lines, 1):
        match = FENCE.match(line)
        if fence:
            document.prose.append("")
            if match and match.group(2).startswith(fence[1]) and not match.group(3):
                fence = None
            else:
                block = fence[2]
                block.text += (line[fence[0]:] if not line[:fence[0]].strip() else line) + "\n"
            continue
        mark = COMMENT.match(line.strip())
        if match and not in_comment:
            block = Block(number + 1, match.group(3), "", marks)
            document.blocks.append(block)
            document.prose.append("")
            fence, document.unclosed, marks = (len(match.group(1)), match.group(2), block), number, []
        elif mark:
            marks = marks + [mark.groups(default="")]
            document.prose.append("")
        elif re.match(r"^( {4}|\t)\s*\S", line) and not in_comment and is_indented_code(document):
            previous = document.blocks[-1] if document.blocks else None
            if not previous or previous.fenced or document.prose[previous.line - 1:] != [""] * (number - previous.line):
                document.blocks.append(Block(number, "", "", marks, fenced=False))
            document.blocks[-1].text += line[4:] + "\n"
            document.prose.append("")
        else:
            document.prose.append(line)
            in_comment = (in_comment or line.lstrip().startswith("<!--")) and "-->" not in line
            heading = HEADING.match(line)
            if heading:
                document.headings.append((number, len(heading.group(1)), heading.group(2)))
            if line.strip():
                marks = []
    document.unclosed = document.unclosed if fence else 0
    return document


def is_indented_code(document):
    """Returns whether a next line that is indented by four spaces is code: it follows a blank line or code, and not a
    list."""
    if document.prose and document.prose[-1].strip():
        return False
    for line in reversed(document.prose):
        if line.strip():
            return not re.match(r"^\s*([-*+]|\d+[.)])\s", line) and not line.startswith("  ")
    return True


def tracked(root):
    out = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=root, capture_output=True, text=True,
                         check=True)
    return sorted({name for name in out.stdout.splitlines() if (root / name).is_file()})


def all_documents(root):
    return [parse(name, (root / name).read_text(encoding="utf-8")) for name in tracked(root) if name.endswith(".md")]


def script_lines(text):
    """Yields (offset of the line in the text, line). Lines continued by a backslash are joined."""
    joined, start = "", None
    for offset, line in enumerate(text.split("\n")):
        start = offset if start is None else start
        joined += line
        if joined.endswith("\\"):
            joined = joined[:-1] + " "
            continue
        if joined.strip():
            yield start, joined
        joined, start = "", None


def words_of(line):
    """Returns the words of a shell line, with operators such as && and > as separate words, and without comments."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    lexer.commenters = "#"
    try:
        return list(lexer)
    except ValueError:
        return line.split()


def simple_commands(line):
    """Returns the commands of a line as lists of words, without redirections and leading assignments."""
    commands, command, skip = [], [], False
    for word in words_of(line):
        if skip:
            skip = False
        elif set(word) <= set("();<>|&") and word:
            if set(word) & set("<>"):
                skip = True
                if command and command[-1].isdigit():
                    command.pop()
            else:
                commands.append(command)
                command = []
        elif command or not re.match(r"^[A-Za-z_]\w*=", word):
            command.append(word)
    commands.append(command)
    keywords = {"do", "then", "else", "!", "time", "nice", "sudo", "exec"}
    out = []
    for words in commands:
        while words and words[0] in keywords:
            words = words[1:]
        if words:
            out.append(words)
    return out


def is_ours(words):
    """Returns whether the command belongs to this project or to its build."""
    first = words[0].removeprefix("./")
    return (first in PROGRAMS or first in ("ctest", "cmake", "vitis_hls")
            or re.match(r"^(scripts|hls|model|tests|constraints)/[\w/-]+\.(sh|py)$", first) is not None
            or re.match(r"^build/\w+/tests/[\w./-]+$", first) is not None
            or (first.startswith("python3") and len(words) > 1 and "/" in words[1]))


def options_of(words):
    return [word.split("=")[0] for word in words if re.match(r"^--[a-z]", word)]


def read_root(argv, here):
    return pathlib.Path(argv[1] if len(argv) > 1 else pathlib.Path(here).parents[2]).resolve()
