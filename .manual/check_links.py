"""Check the built manual: every link inside it leads to a page and an anchor that are there, options have two hyphens.

Links to other sites are tried by `.ci/manual links`.
"""

from __future__ import annotations

import re
import sys
from functools import cache
from html import unescape
from pathlib import Path
from urllib.parse import unquote

LINK = re.compile(r'<a\s[^>]*?href="([^"]*)"|<img\s[^>]*?src="([^"]*)"')
ANCHOR = re.compile(r'\s(?:id|name)="([^"]+)"')
# What a dash in place of two hyphens makes of an option.
DASHED = re.compile(r"(?<!\w)[–—][a-z][a-z-]+")
ELSEWHERE = re.compile(r"(?:https?|mailto|data):")


@cache
def anchors(page: Path) -> frozenset[str]:
    """Return the anchors of a page."""
    return frozenset(map(unescape, ANCHOR.findall(page.read_text(encoding="utf-8"))))


def broken(page: Path) -> list[str]:
    """Return the links of a page that lead nowhere."""
    found = []
    links = {unescape(one or other) for one, other in LINK.findall(page.read_text(encoding="utf-8"))}
    for link in sorted(links):
        if ELSEWHERE.match(link):
            continue
        place, _, anchor = map(unquote, link.partition("#"))
        target = page.parent / place if place else page
        there = target.exists()
        if not there or (anchor and target.suffix == ".html" and anchor not in anchors(target)):
            found.append(f"{page}: {link}")
    return found


if __name__ == "__main__":
    pages = sorted(Path(sys.argv[1]).rglob("*.html"))
    wrong = [link for page in pages for link in broken(page)]
    wrong += [f"{page}: {one}" for page in pages for one in DASHED.findall(page.read_text(encoding="utf-8"))]
    print(*wrong, sep="\n")
    print(f"{len(pages)} pages, {len(wrong)} broken links or options")
    sys.exit(bool(wrong) or not pages)
