"""For mkdocs (mkdocs.yml): the READMEs of the folders become pages of the site, and links follow them there.

A link to a file that is not a page, such as a source, becomes plain text, because the site has no sources.
"""

import pathlib
import posixpath
import re

from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).resolve().parents[1]
LINK = re.compile(r"(?<!!)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s#:]+)(#[^()\s]*)?\)")


def on_files(files, config):
    for path in sorted(ROOT.glob("**/README.md")):
        name = path.relative_to(ROOT).as_posix()
        if "/" in name and not name.startswith("build/"):  # the first page of the site is docs/index.md
            files.append(File(name, str(ROOT), config.site_dir, False))
    return files


def on_page_markdown(markdown, page, config, files):
    source = page.file.src_uri
    is_document = pathlib.Path(page.file.abs_src_path).is_relative_to(config.docs_dir)
    place = posixpath.dirname(posixpath.join("docs", source) if is_document else source)  # in the tree of sources

    def follow(match):
        text, target, anchor = match.group(1), match.group(2), match.group(3) or ""
        full = posixpath.normpath(posixpath.join(place, target))
        uri = full.removeprefix("docs/")
        if (ROOT / full).is_dir():
            uri = posixpath.join(full, "README.md")
        if files.get_file_from_path(uri) is None:
            return text
        return f"[{text}]({posixpath.relpath(uri, posixpath.dirname(source) or '.')}{anchor})"

    return LINK.sub(follow, markdown)
