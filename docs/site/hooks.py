"""For mkdocs (mkdocs.yml): pages that are made from programs, sources and the specification, and documents outside docs/.

* Commands and modules get a page each (commands.py, modules.py). SELFPROJ_PROGRAMS names the folder of the programs;
  without it the commands have only their index.
* `<!-- site: file PATH -->` in a document becomes that file.
* README.md is the first page; the READMEs of the folders and the documents of the laboratory are pages, too.
* Links and pictures are followed from the place in the tree to the page. A link to a file that is not a page, such as a
  source, becomes plain text, because the site has no sources.
"""

import functools
import os
import pathlib
import posixpath
import re
import sys

from mkdocs.structure.files import File

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))
import commands  # noqa: E402
import modules  # noqa: E402

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s#:]+)(#[^()\s]*)?\)")
COMMENT = re.compile(r"<!-- site: file (\S+) -->")
ANCHOR = re.compile(r'<a id="(selfproj[a-z-]*)"></a>(`[^`]*`)')
LANGUAGES = {".sv": "systemverilog", ".sh": "sh"}


@functools.cache
def documents():
    """Returns {name on the site: path in the tree} of documents and pictures outside docs/."""
    paths = [*ROOT.glob("**/README.md"), *ROOT.glob("lab/*.md"), *ROOT.glob("lab/images/*")]
    names = {path.relative_to(ROOT).as_posix(): path for path in paths}
    names = {name: path for name, path in names.items() if not name.startswith((".", "build", "docs/"))}
    return {"index.md" if name == "README.md" else name: path for name, path in sorted(names.items())}


@functools.cache
def made_pages():
    """Returns {name on the site: text} of the pages that no file has."""
    pages = {f"modules/{name}": text for name, text in modules.pages().items()}
    if programs := os.environ.get("SELFPROJ_PROGRAMS"):
        pages |= {f"commands/{name}": text for name, text in commands.pages(pathlib.Path(programs)).items()}
    return pages


def on_config(config):
    """Adds the pages of commands, modules and folders to the navigation."""
    more = {"Commands": [name for name in made_pages() if name.startswith("commands/")],
            "FPGA": [{"Modules": [name for name in made_pages() if name.startswith("modules/")]}],
            "Contributing": [{"Folders": [name for name in documents() if name.endswith("README.md")]}]}
    for section in config.nav:
        for title, pages in section.items():
            pages += more.get(title, [])
    return config


def on_files(files, config):
    for name, path in documents().items():
        files.append(File.generated(config, name, abs_src_path=str(path)))
    for name, text in made_pages().items():
        files.append(File.generated(config, name, content=text))
    return files


def made(match):
    path = ROOT / match[1]
    return f"\n\n```{LANGUAGES.get(path.suffix, 'text')}\n{path.read_text(encoding='utf-8').rstrip()}\n```\n"


def on_page_markdown(markdown, page, config, files):
    source = page.file.src_uri
    outside = documents()
    if source in outside:
        place = posixpath.dirname(outside[source].relative_to(ROOT).as_posix())
    else:
        place = posixpath.dirname(posixpath.join("docs", source))

    def uri_of(target):
        """Returns the name on the site of a file or folder of the tree, or None."""
        full = posixpath.normpath(posixpath.join(place, target))
        if (ROOT / full).is_dir():
            full = posixpath.join(full, "README.md")
        module = posixpath.basename(full).removesuffix(".sv")
        names = [full.removeprefix("docs/"), "index.md" if full == "README.md" else full, f"modules/{module}.md"]
        return next((name for name in names if files.get_file_from_path(name)), None)

    def follow(match):
        mark, text, target, anchor = match.group(1), match.group(2), match.group(3), match.group(4) or ""
        uri = uri_of(target)
        if uri == "commands/index.md" and files.get_file_from_path(f"commands/{anchor[1:]}.md"):
            uri, anchor = f"commands/{anchor[1:]}.md", ""
        if uri is None:
            return text
        return f"{mark}[{text}]({posixpath.relpath(uri, posixpath.dirname(source) or '.')}{anchor})"

    markdown = COMMENT.sub(made, LINK.sub(follow, markdown))
    if source == "commands/index.md" and os.environ.get("SELFPROJ_PROGRAMS"):
        markdown = ANCHOR.sub(r"[\2](\1.md)", markdown)
    return markdown
