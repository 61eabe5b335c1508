"""Sections: recordings one below the other in one text, each below the names of the columns."""

from __future__ import annotations

import re
from collections.abc import Sequence

from suspid.io.text.cells import kind_of
from suspid.io.text.layouts import Layout
from suspid.io.text.rows import is_row, names_again

FILLED_LINE = re.compile(rb"[^\n]+")
# Characters of a title, at most.
LONGEST_TITLE = 60


def sections_of(text: bytes, top: Sequence[str], layout: Layout) -> list[tuple[int, int]]:
    r"""Return where each section begins, and the names in it, of a text whose names of columns stand again.

    ``top`` has the first lines of the text. What stands between the rows of a section and the names of the next one is
    about that: no more than above the first one, and lines that are no rows. None where the names stand once.

    Examples
    --------
    >>> from suspid.io.text.layouts import find_layout
    >>> text = "Run 1\nt,z\n0,1\n1,2\n\nRun 2\nt,z\n0,3\n1,4\n"
    >>> lines = text.splitlines()
    >>> [text[k:] for k, _ in sections_of(text.encode(), lines, find_layout(lines, lines))][1]
    '\nRun 2\nt,z\n0,3\n1,4\n'
    """
    above = [k for k in range(layout.first) if names_again(top[k], layout)]
    if not above:
        return []
    first = sum(len(line.encode()) + 1 for line in top[: above[-1]])
    # Blank columns behind the others may be named above some sections only.
    names = _less_blank(top[above[-1]], layout)
    found, at = [(0, first)], first
    while (at := text.find(b"\n" + names.encode(), at)) >= 0:
        start, at = at + 1, text.find(b"\n", at + 1)
        if _less_blank(text[start:at].decode(), layout) == names:
            found.append((_first_above(text, start, above[-1] + 1, layout), start))
    return found if len(found) > 1 else []


def _less_blank(names: str, layout: Layout) -> str:
    """Return the names of columns without those behind the last one."""
    delimiter = layout.dialect.delimiter
    return names if delimiter == " " else delimiter.join(names.split(delimiter)[: len(layout.names)])


def has_rows(text: bytes, start: int, stop: int, layout: Layout) -> bool:
    """Return whether there is a row between two places of a text."""
    return any(_may_be_row(line[0].decode(), layout) for line in FILLED_LINE.finditer(text, start, stop))


def title_above(text: bytes, names: int, layout: Layout) -> str:
    r"""Return the title of a section, the line above its names at ``names`` where that is short and a single cell.

    Examples
    --------
    >>> from suspid.io.text.layouts import find_layout
    >>> lines = ["Run 1", "t,z", "0,1", "1,2"]
    >>> title_above("\n".join(lines).encode(), 6, find_layout(lines, lines))
    'Run 1'
    """
    above = text[max(0, names - 4 * LONGEST_TITLE) : names].rstrip()
    line = above[above.rfind(b"\n") + 1 :].decode(errors="replace")
    cells = [cell for cell in layout.dialect.cells(line) if cell] if len(line) < LONGEST_TITLE else []
    return cells[0].strip(" #%:;*=-") if len(cells) == 1 else ""


def _first_above(text: bytes, start: int, most: int, layout: Layout) -> int:
    """Return where the lines above one at ``start`` begin that are no rows, up to ``most`` that are not blank."""
    while most > 0 and start > 0:
        before = text.rfind(b"\n", 0, start - 1) + 1
        line = text[before : start - 1].decode()
        if _may_be_row(line, layout):
            break
        most -= bool(line.strip())
        start = before
    return start


def _may_be_row(line: str, layout: Layout) -> bool:
    """Return whether a line is a row that begins as all do: a setting with its number begins with its name."""
    if not line.strip() or not is_row(line, layout):
        return False
    begins, usual = kind_of(layout.dialect.cells(line)[0], comma=layout.dialect.comma), layout.kinds[layout.names[0]]
    return begins != "text" or usual == "text"
