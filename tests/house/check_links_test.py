#!/usr/bin/env python3
"""Planted faults: links, pictures and anchors that lead nowhere, in a small tree."""

import unittest

import check_links
import documents
import planted

GOOD = {
    "README.md": "# Title\n\n[docs](docs/index.md), [folder](host/), [site](https://example.com), [here](#title)\n"
                 "![the marks](docs/images/marks.png) and [a picture ![x](docs/images/marks.png)](docs/index.md)\n"
                 "`[no](link.md)`\n\n```text\n[no](link.md)\n```\n\n    [no](link.md)\n",
    "docs/index.md": "# Index of `all`\n\n[up](../README.md#title) [twice](#same-1) [code](#index-of-all)\n\n"
                     "## Same\n\n## Same\n\n[shown]: ../README.md\n",
    "docs/images/marks.png": "png",
    "host/a.h": "\n",
    "mkdocs.yml": "nav:\n  - Home: index.md\n",
}


class CheckLinks(unittest.TestCase):
    def problems_of(self, **changes):
        with planted.tree({**GOOD, **changes}) as root:
            return check_links.problems(root)

    def expect(self, wanted, **changes):
        found = self.problems_of(**changes)
        self.assertTrue(any(wanted in line for line in found), f"{wanted!r} is not in {found}")

    def test_a_good_tree(self):
        # Markdown viewers number equal headings with -1, mkdocs with _1, so such an anchor leads nowhere on one of
        # them.
        self.assertEqual(self.problems_of(), ["docs/index.md:3: no heading for #same-1"])

    def test_files_and_folders_that_are_gone(self):
        self.expect("a.md:1: no file or folder docs/gone.md", **{"a.md": "[x](docs/gone.md)\n"})
        self.expect("docs/b.md:2: no file or folder docs/index.md", **{"docs/b.md": "\n[x](docs/index.md)\n"})
        self.expect("a.md:1: no file or folder gone/", **{"a.md": "[x](gone/)\n"})
        self.expect("a.md:1: no file or folder ../x.md", **{"a.md": "[x](../x.md)\n"})
        self.expect("a.md:1: no file or folder gone.md", **{"a.md": "[x]: gone.md\n"})

    def test_anchors_that_are_gone(self):
        self.expect("a.md:1: no heading for docs/index.md#inde", **{"a.md": "[x](docs/index.md#inde)\n"})
        self.expect("a.md:1: no heading for #below", **{"a.md": "[x](#below)\n\n```text\n# Below\n```\n"})
        self.expect("a.md:1: host/a.h#L1: only Markdown", **{"a.md": "[x](host/a.h#L1)\n"})

    def test_pictures(self):
        self.expect("a.md:1: no file or folder gone.png", **{"a.md": "![x](gone.png)\n"})
        self.expect("has no words beside it", **{"a.md": "![](docs/images/marks.png)\n"})

    def test_navigation(self):
        self.expect("mkdocs.yml: docs/more.md is not in the navigation", **{"docs/more.md": "# More\n"})
        self.expect("mkdocs.yml: host/README.md is not in the navigation", **{"host/README.md": "# Host\n"})
        self.expect("mkdocs.yml: no page host/a.h.md", **{"mkdocs.yml": "nav:\n  - index.md\n  - A: host/a.h.md\n"})
        self.expect("mkdocs.yml: no page gone.md", **{"mkdocs.yml": "nav:\n  - index.md\n  - Gone: gone.md\n"})
        self.expect("mkdocs.yml: index.md is there twice", **{"mkdocs.yml": "nav:\n  - index.md\n  - A: index.md\n"})

    def test_slugs(self):
        for heading, github, mkdocs in [("A `b` [c](d.md)", "a-b-c", "a-b-c"),
                                        ("B7, B8: what", "b7-b8-what", "b7-b8-what"),
                                        ("Error & range", "error--range", "error-range"),
                                        ("snake_case", "snake_case", "snake_case")]:
            self.assertEqual(documents.github_slug(heading), github)
            self.assertEqual(documents.mkdocs_slug(heading), mkdocs)


if __name__ == "__main__":
    unittest.main()
