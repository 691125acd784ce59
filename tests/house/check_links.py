#!/usr/bin/env python3
"""Checks that every relative link of every Markdown file leads to a file, folder, picture or heading.

    check_links.py [ROOT]

An anchor must be that of a heading, both in Markdown viewers and on the site that mkdocs builds. A picture has a text
that says what it shows. Every page of docs/ and lab/ is in the navigation of mkdocs.yml, and every page there exists.
"""

import pathlib
import re
import sys
import urllib.parse

import documents


def resolve(name, target):
    """Returns the path of a relative target from the root, or None if it leaves the tree."""
    parts = []
    for part in (pathlib.PurePosixPath(name).parent / target).parts:
        if part != "..":
            parts.append(part)
        elif not parts:
            return None
        else:
            parts.pop()
    return "/".join(parts)


def problems_of_links(files, pages):
    folders = {parent.as_posix() for name in files for parent in pathlib.PurePosixPath(name).parents} | {""}
    anchors = {page.name: page.anchors() for page in pages}
    for page in pages:
        for line, is_picture, text, target in page.links:
            where = f"{page.name}:{line}:"
            if re.match(r"^[a-z][a-z0-9+.-]*:", target):
                continue
            if is_picture and not text.strip():
                yield f"{where} the picture {target} has no words beside it"
            path, _, anchor = target.partition("#")
            full = resolve(page.name, urllib.parse.unquote(path)) if path else page.name
            if full is None or (full not in files and full not in folders):
                yield f"{where} no file or folder {target}"
            elif anchor and full not in anchors:
                yield f"{where} {target}: only Markdown files have anchors"
            elif anchor and urllib.parse.unquote(anchor) not in anchors[full]:
                yield f"{where} no heading for {target}"


def problems_of_navigation(root, pages):
    text = (root / "mkdocs.yml").read_text(encoding="utf-8")
    listed = re.findall(r"(?<=[\s:])([\w./-]+\.md)\s*$", text, re.MULTILINE)
    # The first page of the site is README.md; the site adds the READMEs of the folders and the pages that are made.
    there = {page.name.removeprefix("docs/") for page in pages
             if page.name.startswith(("docs/", "lab/")) and not page.name.endswith("/README.md")} | {"index.md"}
    for name in sorted(set(listed) - there):
        yield f"mkdocs.yml: no page {name}"
    for name in sorted(there - set(listed)):
        yield f"mkdocs.yml: {name} is not in the navigation"
    for name in sorted({name for name in listed if listed.count(name) > 1}):
        yield f"mkdocs.yml: {name} is there twice"


def problems(root):
    pages = documents.all_documents(root)
    files = set(documents.tracked(root))
    return [*problems_of_links(files, pages), *problems_of_navigation(root, pages)]


def main():
    lines = problems(documents.read_root(sys.argv, __file__))
    print("\n".join(lines) if lines else "every link leads somewhere")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
