"""Rows of numbers that blanks separate among others that tabs separate, as an editor leaves them."""

from __future__ import annotations

import re

# A number in a cell, with either decimal sign, and rows of such cells. Without limits of their length, lines of digits
# would take the square of it.
SOME_DIGITS = rb"\d{1,40}"
NUMERAL = rb"[+-]?(?:%b(?:[.,]\d{0,40})?|[.,]%b)(?:[eE][+-]?\d{1,3})?" % (SOME_DIGITS, SOME_DIGITS)
TAB_ROW = re.compile(rb"(?m)^ {0,40}%b {0,40}(?:\t {0,40}%b {0,40})+$" % (NUMERAL, NUMERAL))
# A line beside rows is one if its first number goes on as theirs do, to this share of their step: counts, settings and
# remarks stand there as well.
NEAR_STEP = 0.5


def with_tabs(text: bytes, *, within: int) -> bytes:
    r"""Return a text with tabs in the rows of numbers that have blanks in their place.

    The first row of tabs is looked for in the first ``within`` bytes. A row of blanks has as many cells.

    Examples
    --------
    >>> with_tabs(b"t seat\n0 5\n1\t6\n2\t7\n3  8\n4\t9\n", within=100)
    b't seat\n0\t5\n1\t6\n2\t7\n3\t8\n4\t9\n'

    Numbers between the rows that do not go on as they do are a remark:

    >>> with_tabs(b"1\t6\n2\t7\n40 2\n3\t8\n", within=100)
    b'1\t6\n2\t7\n40 2\n3\t8\n'
    """
    # A look for tabs takes no time beside one for rows.
    first = TAB_ROW.search(text, 0, within) if b"\t" in text[:within] else None
    if first is None:
        return text
    marks = first[0].count(b"\t")
    row = re.compile(rb"(?m)^ {0,40}%b(?: {1,40}%b){%d} {0,40}$" % (NUMERAL, NUMERAL, marks))
    above = text.rfind(b"\n", 0, max(first.start() - 1, 0)) + 1
    if row.fullmatch(text, above, max(first.start() - 1, 0)) and _goes_on(text[above:within].split(b"\n", 3)[:3]):
        text = text[:above] + _tabbed(text[above : first.start() - 1]) + text[first.start() - 1 :]
    else:
        above = first.start()
    start, stop = above, text.find(b"\n", text.rfind(b"\t")) + 1
    below = row.match(text, stop)
    if below is not None and _goes_on([*text[max(0, stop - within) : stop].split(b"\n")[-3:-1], below[0]]):
        text = text[:stop] + _tabbed(below[0]) + text[below.end() :]
    if text.count(b"\t", start, stop) == marks * text.count(b"\n", start, stop):
        return text
    rows = text[start:stop]

    def within_rows(found: re.Match[bytes]) -> bytes:
        before = rows[max(0, found.start() - within) : max(0, found.start() - 1)].split(b"\n")[-1]
        after = rows[found.end() + 1 : found.end() + within].split(b"\n", 1)[0]
        # A remark in numbers is none of them.
        return _tabbed(found[0]) if not (before and after) or _goes_on([before, found[0], after]) else found[0]

    return text[:start] + row.sub(within_rows, rows) + text[stop:]


def _tabbed(row: bytes) -> bytes:
    return b"\t".join(row.split())


def _goes_on(rows: list[bytes]) -> bool:
    r"""Return whether the first numbers of three rows rise or fall evenly.

    Examples
    --------
    >>> _goes_on([b"0 5", b"1\t6", b"2\t7"]), _goes_on([b"500 2", b"1\t6", b"2\t7"])
    (True, False)
    """
    cells = [line.split()[:1] for line in rows]
    numbers = [float(cell[0].replace(b",", b".")) for cell in cells if cell and re.fullmatch(NUMERAL, cell[0])]
    if len(numbers) < 3:
        return False
    one, two = numbers[1] - numbers[0], numbers[2] - numbers[1]
    return abs(one - two) < NEAR_STEP * max(abs(one), abs(two))
