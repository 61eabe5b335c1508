"""Text of numbers, and tables of them."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from textwrap import wrap

import numpy as np
from tabulate import tabulate

from suspid.files import printable
from suspid.units import RealArray

# Magnitudes between which numbers are printed without an exponent: up to three zeros stand before their digits.
SMALLEST_PLAIN, LARGEST_PLAIN = 1e-4, 1e7
# What stands in a table for a number that is not known.
NOTHING = "–"
# Columns of a terminal that nobody has widened, and spaces between the columns of a table that has to fit it.
TERMINAL, COLUMN_GAP = 80, 2
# Letters of a name in a table: a column of it and two of numbers fit a terminal.
LONGEST_NAME = 58
# Letters of a word from which on a heading of several lines is better cut in it.
LONG_WORD = 15


def text_table(columns: Mapping[str, Sequence[str]], *, widest: int | None = None, words: Collection[str] = ()) -> str:
    """Return named columns of text as a table, aligned to the right; those of ``words`` to the left.

    One that is wider than ``widest`` has headings of several lines, and then several parts, each with the first column.
    Control characters are escaped, and names longer than a table has room for lose their middle.

    Examples
    --------
    >>> print(text_table({"car": ["1"], "seat.stiffness": ["20000"], "seat.damping": ["900"]}, widest=24))
         seat.    seat.
    car  stiffness  damping
    ---  ---------  -------
      1      20000      900
    """
    columns = {named(name): [named(cell, name in words) for cell in cells] for name, cells in columns.items()}
    # tabulate 0.9 fails if a table without rows is given alignments.
    rows = any(columns.values())
    sides = ["left" if name in words else "right" for name in columns] if rows else None
    whole: str = tabulate(columns, headers="keys", disable_numparse=True, stralign="right", colalign=sides)
    whole = "\n".join(map(str.rstrip, whole.split("\n"))) if words else whole
    if widest is None or max(map(len, whole.split("\n"))) <= widest:
        return whole
    cells = list(columns.values())
    # Headings are cut no further than one part needs; where several are needed names stay whole.
    for cut in (0, 1, 2, 3, 2):
        heads = [_heading(name, cut) for name in columns]
        widths = [max(map(len, [*head, *column])) for head, column in zip(heads, cells, strict=True)]
        if sum(widths) + COLUMN_GAP * (len(widths) - 1) <= widest:
            break
    parts: list[list[int]] = []
    left = list(range(1, len(heads)))
    while left or not parts:
        use, room = [0], widest - widths[0]
        while left and (len(use) == 1 or room >= widths[left[0]] + COLUMN_GAP):
            room -= widths[left[0]] + COLUMN_GAP
            use.append(left.pop(0))
        parts.append(use)
    return "\n\n".join(_part([heads[i] for i in use], [cells[i] for i in use]) for use in parts)


def named(text: str, whole: bool = False) -> str:
    r"""Return a name as a cell of a table shows it: on one line, without control characters, and not too long.

    Examples
    --------
    >>> print(named("seat\x1b[2J"), named("x" * 100 + "_left"))
    seat\x1b[2J xxxxxxxxxxxxxxxxxxxxxxxxxxxx…xxxxxxxxxxxxxxxxxxxxxxx_left
    """
    shown = printable(text)
    if whole or len(shown) <= LONGEST_NAME:
        return shown
    # Names of channels of one kind often differ at the end.
    half = (LONGEST_NAME - 1) // 2
    return f"{shown[:half]}…{shown[-half:]}"


def sentence_table(
    columns: Mapping[str, Sequence[str]], heading: str, sentences: Sequence[Sequence[str]], width: int
) -> str:
    """Return a table whose last column has sentences, any number a row, cut into lines of at most ``width`` letters.

    Examples
    --------
    >>> print(sentence_table({"records": ["3"]}, "such as", [["seat.csv: contains no row of numbers"]], 20))
      records  such as
    ---------  ------------------
            3  seat.csv: contains
               no row of numbers
    """
    lines = [[line for one in row for line in wrap(one, width)] or [""] for row in sentences]
    long = {
        name: [cell for text, own in zip(column, lines, strict=True) for cell in (text, *[""] * (len(own) - 1))]
        for name, column in columns.items()
    }
    return text_table({**long, heading: [line for own in lines for line in own]}, words=[heading])


def _heading(name: str, cut: int) -> list[str]:
    """Return the lines of a heading.

    Cut once the terms of a sum, a remark and the unit stand apart, cut twice a name and its last word, at last the
    parts of long words.
    """
    if not cut:
        return [name.strip()]
    what, *remarks = name.replace(" [", ", [").split(", ")
    words = what.replace(" + ", " +\n").split("\n")
    if cut > 1 and len(words) == 1:
        # A point before a digit is that of a number.
        words = re.sub(r"\.(?=[^\W\d])", ".\n", what).split("\n")
    if cut > 2:
        words = [part for word in words for part in ([word] if len(word) < LONG_WORD else _halves(word))]
    return [*words, *remarks]


def _halves(word: str) -> list[str]:
    first, mark, last = word.rpartition("_")
    return [first + mark, last] if mark else [word]


def _part(heads: Sequence[Sequence[str]], cells: Sequence[Sequence[str]]) -> str:
    """Return a table whose headings have several lines, the last lines side by side."""
    height = max(map(len, heads))
    columns = [[*[""] * (height - len(head)), *head, *column] for head, column in zip(heads, cells, strict=True)]
    widths = [max(map(len, column)) for column in columns]
    rows = [[*column[:height], "-" * width, *column[height:]] for column, width in zip(columns, widths, strict=True)]
    gap = " " * COLUMN_GAP
    lines = zip(*rows, strict=True)
    return "\n".join(
        gap.join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def figures_of(value: float, digits: int = 4) -> str:
    """Return a number with its significant digits, without an exponent unless it is far from 1; "–" of what is unknown.

    Examples
    --------
    >>> figures_of(50000.0), figures_of(0.0123456), figures_of(8.2e-9), figures_of(float("nan"))
    ('50000', '0.01235', '8.2e-09', '–')
    """
    if np.isnan(value):
        return NOTHING
    if value == 0 or not np.isfinite(value) or not SMALLEST_PLAIN <= abs(value) < LARGEST_PLAIN:
        return f"{value:.{digits}g}"
    return np.format_float_positional(float(f"{value:.{digits}g}"), trim="-")


def rounded(values: RealArray, stds: RealArray | None, scale: float = 1.0) -> list[str]:
    """Return values with the digits that their uncertainty (times ``scale``) leaves, or six significant ones.

    Examples
    --------
    >>> rounded(np.array([0.61049, 8.2e-9, 5.0]), np.array([0.0123, 1.1e-8, np.nan]))
    ['0.610', '8e-09', '5']
    >>> rounded(np.array([1e6, 799999.7]), None)
    ['1000000', '800000']
    """
    if stds is None:
        return [figures_of(v, 6) for v in values.tolist()]
    return [_rounded(float(v), float(s) * scale) for v, s in zip(values, stds, strict=True)]


def _rounded(value: float, std: float) -> str:
    if not np.isfinite(std) or not np.isfinite(value):
        return figures_of(value, 6)
    places = 1 - int(np.floor(np.log10(std))) if std > 0 else 6
    largest = max(abs(value), std)
    if value and std > 0 and largest < SMALLEST_PLAIN:
        digits = max(0, places + int(np.floor(np.log10(abs(value)))))
        return f"{value:.{digits}e}"
    text = f"{value:.{min(max(places, 0), 12)}f}"
    return text if float(text) else text.removeprefix("-")


def spread(std: float) -> str:
    """Return a standard deviation with two digits; tens and more are written out, what is unknown is "–".

    Examples
    --------
    >>> spread(0.01234), spread(1.0), spread(512.0), spread(0.0), spread(float("nan"))
    ('0.012', '1.0', '510', '0', '–')
    """
    if np.isnan(std):
        return NOTHING
    return f"{std:.0f}" if std == 0 else f"{std:#.2g}" if std < 9.95 else f"{float(f'{std:.2g}'):.0f}"


def value_columns(values: RealArray, stds: RealArray) -> dict[str, list[str]]:
    """Return a column of values, and one of their standard deviations unless all are known exactly.

    Examples
    --------
    >>> value_columns(np.array([26.181, 4.724]), np.array([1.23, np.nan]))
    {'value': ['26.2', '4.724'], '±': ['1.2', '–']}
    >>> value_columns(np.array([26.181]), np.array([0.0]))
    {'value': ['26.18']}
    """
    if not np.any(np.isnan(stds) | (stds > 0)):
        return {"value": [figures_of(value) for value in values.tolist()]}
    return {
        "value": [
            rounded(np.array([value]), np.array([std]))[0] if std > 0 else figures_of(value)
            for value, std in zip(values.tolist(), stds.tolist(), strict=True)
        ],
        "±": [spread(std) for std in stds.tolist()],
    }


def bound_columns(ends: Sequence[tuple[float, float]]) -> dict[str, list[str]]:
    """Return columns of lower and upper ends, with the digits that tell them apart.

    Examples
    --------
    >>> bound_columns([(0.017991, 0.018003), (63.73, 64.09), (np.nan, np.nan)])
    {'lower': ['0.0179910', '63.73', '–'], 'upper': ['0.0180030', '64.09', '–']}
    """
    half = np.array([max((high - low) / 2, 0.0) for low, high in ends])
    rows = [
        (rounded(np.array([low]), np.array([one]))[0], rounded(np.array([high]), np.array([one]))[0])
        if one > 0 or np.isnan(one)
        else (figures_of(low), figures_of(high))
        for (low, high), one in zip(ends, half.tolist(), strict=True)
    ]
    return {"lower": [low for low, _ in rows], "upper": [high for _, high in rows]}
