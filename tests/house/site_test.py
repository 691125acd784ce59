#!/usr/bin/env python3
"""Builds the site of the documents and looks at every page in Chromium, as wide as on a desk and as on a telephone: no
table is cut off, no page is wider than the window, no picture is missing, the first page finds words of others, and
nothing is asked for elsewhere.

    site_test.py PROGRAMS [--pictures DIR]

PROGRAMS is the folder of selfproj and selfproj-sim. With --pictures, DIR gets a picture of some pages at both widths.
The exit status is 77 where PyPI is not reached or there is no Chromium. Standard library only.
"""

import functools
import http.server
import json
import pathlib
import subprocess
import sys
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import chromium  # noqa: E402

SITE = ROOT / "build/site"
INDEX = "/search/search_index.json"
WIDTHS = (1400, 420)
SHOWN = ("index.html", "getting-started.html", "results.html", "using-the-circuits.html", "lab/accuracy.html",
         "commands/index.html", "commands/selfproj-inspect.html", "modules/sp_board.html", "verification.html")
# The faults of a page. What does not fit into the window is cut off unless the first thing
# around it that fits scrolls.
FAULTS = r"""
const faults = [], right = document.documentElement.clientWidth;
for (const picture of document.images)
  if (!picture.complete || picture.naturalWidth === 0) faults.push("missing picture " + picture.src);
const fits = element => {
  const box = element.getBoundingClientRect();
  return box.left > -1 && box.right < right + 1;
};
for (const block of document.querySelectorAll("article table, article pre > code")) {
  let around = block;
  while (!fits(around)) around = around.parentElement;
  if (around !== block && !["auto", "scroll"].includes(getComputedStyle(around).overflowX))
    faults.push("cut off: " + block.textContent.trim().replace(/\s+/g, " ").slice(0, 60));
}
if (document.documentElement.scrollWidth > right + 1) faults.push("wider than the window");
return faults;
"""


class Server:
    """Serves the site while it lives. Where `words` is False, the search of a page finds nothing: each page would sort a
    megabyte of words, which was half of the test's time."""

    words = True

    class Handler(http.server.SimpleHTTPRequestHandler):
        def do_GET(self):
            if self.path != INDEX or Server.words:
                super().do_GET()
                return
            index = json.loads((SITE / INDEX[1:]).read_bytes())
            self.send_response(200)
            self.end_headers()
            self.wfile.write(json.dumps({**index, "docs": []}).encode())

        def log_message(self, *_):
            pass

    def __enter__(self):
        self.http = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(self.Handler, directory=SITE))
        threading.Thread(target=self.http.serve_forever, daemon=True).start()
        return f"http://127.0.0.1:{self.http.server_port}"

    def __exit__(self, *_):
        self.http.shutdown()
        self.http.server_close()


def search(page, address):
    """Searches from the first page. Raises AssertionError where nothing is found."""
    page.open(f"{address}/index.html")
    page.script("const input = document.querySelector('.md-search__input'); input.focus(); "
                "input.value = 'self-projection'; input.dispatchEvent(new Event('keyup'))")
    page.wait_for("return document.querySelector('.md-search-result__item a')", "the search finds nothing")


def look(page, address, pictures):
    """Yields the faults of all pages."""
    files = sorted(SITE.rglob("*.html"))
    for file in files:
        name = file.relative_to(SITE).as_posix()
        page.show_as("light", WIDTHS[0])
        page.open(f"{address}/{name}")
        page.wait_for("return document.readyState === 'complete' && "  # the theme lets wide tables scroll
                      "[...document.querySelectorAll('article table:not([class])')]"
                      ".every(table => table.closest('.md-typeset__scrollwrap'))", name)
        for width in WIDTHS:
            page.show_as("light", width)
            for fault in page.script(FAULTS):
                yield f"{name} at {width} px: {fault}"
            if pictures and name in SHOWN:
                page.picture(pictures / f"{name.replace('/', '-').removesuffix('.html')}-{width}.png")
    for asked in page.asked():
        if not asked.startswith((address, "data:", "blob:")):
            yield f"asks for {asked}"
    for error in page.errors():
        yield f"logs {error['message']}"
    print(f"{len(files)} pages at {' and '.join(map(str, WIDTHS))} px")


def main():
    pictures = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 and sys.argv[2] == "--pictures" else None
    if not chromium.THERE:
        print("skipped: chromedriver is not installed")
        return 77
    status = subprocess.run([sys.executable, "-B", ROOT / "scripts/build_site.py", sys.argv[1]], check=False).returncode
    if status:
        return status
    page = chromium.Chromium()
    try:
        with Server() as address:
            search(page, address)
            Server.words = False
            faults = list(look(page, address, pictures))
    finally:
        page.close()
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
