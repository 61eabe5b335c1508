"""Dialects of text files: how cells are parted and decimals written.

The dialect of a file is the one under which most of its lines are rows of numbers. What two dialects read as
different numbers is refused, never guessed.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from suspid.errors import RecordError
from suspid.files import printable
from suspid.io.text.cells import Kind, kind_of

# Digits with what may part them, in a cell that is no number.
NUMERIC = re.compile(r"[+-]?[\d.,][\d.,;\t '+\-eE]*")
# How a line looks, whatever its numbers are.
ONES, MANY_ONES = str.maketrans("023456789", "111111111"), re.compile("1{6,}")
COMMENTS = ("#", "%", "//")
DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks"}


@dataclass(frozen=True, kw_only=True, slots=True)
class Dialect:
    """How a line is parted into cells.

    Parameters
    ----------
    delimiter : str
        What stands between two cells; a blank stands for any run of blanks and tabs.
    comma : bool
        Whether decimals stand behind a comma.
    """

    delimiter: str
    comma: bool

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line without their quotes and outer blanks."""
        # A quote that is never closed quotes nothing.
        if '"' in line and line.count('"') % 2 == 0:
            try:
                blanks = self.delimiter == " "
                parts = next(
                    csv.reader([line.strip() if blanks else line], delimiter=self.delimiter, skipinitialspace=blanks),
                    [""],
                )
            except csv.Error as refusal:
                raise RecordError(f"is not delimited text: {refusal}") from None
        else:
            parts = line.split() if self.delimiter == " " else line.split(self.delimiter)
        return [part.strip() for part in parts]

    def is_comment(self, line: str) -> bool:
        """Whether a line is a comment; ``#N/A`` in its first cell makes none."""
        return line.lstrip().startswith(COMMENTS) and kind_of(self.cells(line)[0], comma=self.comma) != "missing"

    def kinds(self, line: str) -> list[Kind]:
        """Return what the cells of a line hold."""
        return [kind_of(cell, comma=self.comma) for cell in self.cells(line)]


COMMAS = Dialect(delimiter=",", comma=False)


def shortened(line: str, most: int = 60) -> str:
    """Return a line in quotes, cut where it is long."""
    text = printable(line.strip())
    return repr(text if len(text) <= most else text[: most - 1] + "…")


def parted_by(dialect: Dialect) -> str:
    """Return the delimiter in words for the end of a message."""
    return f" (separated by {DELIMITERS[dialect.delimiter]})"


def shapes(lines: Sequence[str]) -> Counter[str]:
    """Return how many of the lines look alike, by one that stands for them.

    Every digit is written as 1, and more than five in a row as five: no cell changes its kind by that, and the
    thousand rows of a record are some dozen shapes.

    Examples
    --------
    >>> shapes(["0.002,-3", "0.004,-5", "0.123456789,12"])
    Counter({'1.111,-1': 2, '1.11111,11': 1})
    """
    return Counter(MANY_ONES.sub("11111", "\n".join(lines).translate(ONES)).split("\n"))


def find_dialect(head: Sequence[str], sample: Sequence[str], counted: Mapping[str, int]) -> tuple[Dialect, int]:
    """Return the dialect in which most of the lines of a sample are rows of numbers, and the width of these.

    The shapes of the lines are those that `shapes` counted.
    """
    scored = []
    for delimiter in DELIMITERS:
        for comma in (False, True):
            dialect = Dialect(delimiter=delimiter, comma=comma)
            parted = {shape: dialect.cells(shape) for shape in counted}
            kinds = {shape: [kind_of(cell, comma=comma) for cell in cells] for shape, cells in parted.items()}
            widths = Counter[int]()
            for shape, found in kinds.items():
                if "number" in found:
                    widths[len(found)] += counted[shape]
            if widths:
                width = widths.most_common(1)[0][0]
                score = sum(n * _score(parted[shape], kinds[shape], width) for shape, n in counted.items())
                scored.append((score, width, dialect))
    if not scored:
        raise RecordError("holds no row of numbers; a record needs at least 2 samples, one a line")
    best = max(score for score, _, _ in scored)
    ties = [(width, dialect) for score, width, dialect in scored if score > best - 1e-9]
    # Where a decimal comma changes nothing, the point is as good.
    width, dialect = max(ties, key=lambda tie: (tie[0], not tie[1].comma))
    # A line cut short is a row of decimal commas too: rows of commas need not be all.
    two = next(((w, d) for score, w, d in scored if d == COMMAS and score > 1 - 1e-9 and 2 * score >= best), None)
    if two is not None and not [s for s in counted if "text" in (found := COMMAS.kinds(s)) and "number" in found]:
        width, dialect = _one_number_or_two(head, sample, two, ties)
    return dialect, width


def _score(cells: Sequence[str], kinds: Sequence[Kind], width: int) -> float:
    """Return 1 for a row of that width, less the share of its cells that are words, and 0 for what is no row."""
    if "number" not in kinds or len(kinds) != width:
        return 0.0
    texts = [cell for cell, kind in zip(cells, kinds, strict=True) if kind == "text"]
    # A stronger delimiter between digits says that this one is none.
    if any(NUMERIC.fullmatch(text) and re.search(r"[;\t]", text) for text in texts):
        return 0.0
    return 1 - len(texts) / width


def _one_number_or_two(
    head: Sequence[str], sample: Sequence[str], two: tuple[int, Dialect], ties: Sequence[tuple[int, Dialect]]
) -> tuple[int, Dialect]:
    """Return the dialect of rows such as ``1,234``: the header tells, or a digit 0 behind the comma."""
    one = max((tie for tie in ties if tie[1].comma and tie[1].delimiter != ","), key=lambda tie: tie[0], default=None)
    if one is None:
        return max(ties, key=lambda tie: (tie[0], not tie[1].comma))
    rows = [line for line in sample if "number" in two[1].kinds(line) and "," in line]
    if not rows:
        return max(ties, key=lambda tie: (tie[0], not tie[1].comma))
    above = [
        line for line in itertools.takewhile(lambda line: "number" not in two[1].kinds(line), head) if line.strip()
    ]
    if above:
        commas = Counter(line.count(",") for line in rows).most_common(1)[0][0]
        if above[-1].count(",") == commas:
            return two
        if "," not in above[-1]:
            return one
    # No program prints an integer with a zero before it.
    elif any(re.search(r",0\d", line) for line in rows):
        return one
    raise RecordError(
        f"{shortened(rows[0])} may be one number or two: the comma may stand before decimals or between cells; put a "
        f"header line with the names above, or write decimals with a point"
    )
