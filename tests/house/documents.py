"""Shared by the tests of the documents: headings, links, blocks of code and command lines of Markdown files.

The Markdown is read by markdown-it-py (Debian: python3-markdown-it).
"""

import dataclasses
import pathlib
import re
import shlex
import subprocess
import sys
import unicodedata

try:
    from markdown_it import MarkdownIt
except ImportError:  # a Python that is not Debian's own
    sys.path.append("/usr/lib/python3/dist-packages")
    from markdown_it import MarkdownIt

COMMENT = re.compile(r"^<!-- (not run|run shortened|output)(?:: (.+?))? -->$")
PROGRAMS = tuple(place + name for name in ("selfproj", "selfproj-sim", "selfproj-lab") for place in ("", "build/bin/"))


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
    blocks: list = dataclasses.field(default_factory=list)
    links: list = dataclasses.field(default_factory=list)     # (line of the paragraph, is a picture, text, target)
    spans: list = dataclasses.field(default_factory=list)     # (line of the paragraph, text) of code within a line
    headings: list = dataclasses.field(default_factory=list)  # texts
    written_anchors: list = dataclasses.field(default_factory=list)
    unclosed: int = 0  # line of a fence that nothing closes, else 0

    def anchors(self):
        """Returns the anchors of headings on which Markdown viewers and mkdocs agree, and anchors that are written
        out."""
        ours, theirs, seen = set(), set(), {}
        for text in self.headings:
            slug = github_slug(text)
            count = seen[slug] = seen.get(slug, -1) + 1
            ours.add(f"{slug}-{count}" if count else slug)
            theirs.add(f"{mkdocs_slug(text)}_{count}" if count else mkdocs_slug(text))
        return (ours & theirs) | set(self.written_anchors)


def github_slug(heading):
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def mkdocs_slug(heading):
    text = unicodedata.normalize("NFKD", heading).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", text).strip().lower())


def text_of(tokens):
    return "".join(token.content if token.type in ("text", "code_inline") else text_of(token.children or [])
                   for token in tokens)


def add_inline(document, token, line):
    """Adds the links, pictures, code and anchors of a paragraph, heading or cell of a table."""
    link = None
    for i, child in enumerate(token.children):
        if child.type == "link_open":
            link = (i, child.attrGet("href"))
        elif child.type == "link_close":
            document.links.append((line, False, text_of(token.children[link[0]:i]), link[1]))
        elif child.type == "image":
            document.links.append((line, True, child.content, child.attrGet("src")))
        elif child.type == "code_inline":
            document.spans.append((line, child.content.strip()))
        elif child.type == "html_inline":
            document.written_anchors += re.findall(r"<a (?:id|name)=\"([^\"]+)\"", child.content)


def parse(name, text):
    document = Document(name)
    marks, after_heading, line = [], False, 0
    for token in MarkdownIt("commonmark").enable("table").parse(text):
        line = token.map[0] + 1 if token.map else line
        if token.type in ("fence", "code_block"):
            fenced = token.type == "fence"
            document.blocks.append(Block(line + fenced, token.info.strip(), token.content, marks, fenced))
            # A fence that is closed has a line more below its text than above it.
            if fenced and token.map[1] - token.map[0] != token.content.count("\n") + 2:
                document.unclosed = line
        elif token.type == "html_block":
            document.written_anchors += re.findall(r"<a (?:id|name)=\"([^\"]+)\"", token.content)
            found = [COMMENT.match(one.strip()) for one in token.content.splitlines()]
            marks = marks + [match.groups(default="") for match in found if match]
            continue
        elif token.type == "inline":
            add_inline(document, token, line)
            if after_heading:
                document.headings.append(text_of(token.children))
        after_heading = token.type == "heading_open"
        marks = []
    return document


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
    return (first in PROGRAMS or first in ("ctest", "cmake")
            or re.match(r"^(scripts|hls|model|tests|constraints|lab)/[\w/-]+\.(sh|py)$", first) is not None
            or re.match(r"^build/\w+/tests/[\w./-]+$", first) is not None
            or (first.startswith("python3") and len(words) > 1 and "/" in words[1]))


def options_of(words):
    return [word.split("=")[0] for word in words if re.match(r"^--[a-z]", word)]


def read_root(argv, here):
    return pathlib.Path(argv[1] if len(argv) > 1 else pathlib.Path(here).parents[2]).resolve()
