"""Dialects of text files: how cells are parted and decimals written.

The dialect of a file is the one under which most of its lines are rows of numbers. What two dialects read as
different numbers is refused, never guessed.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from suspid.errors import RecordError
from suspid.files import printable
from suspid.formats.cells import Kind, kind_of

# Digits with what may part them, in a cell that is no number.
NUMERIC = re.compile(r"[+-]?[\d.,][\d.,;\t '+\-eE]*")
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


def find_dialect(head: Sequence[str], sample: Sequence[str]) -> tuple[Dialect, int]:
    """Return the dialect in which most of the lines are rows of numbers, and the width of these."""
    scored = []
    for delimiter in DELIMITERS:
        for comma in (False, True):
            dialect = Dialect(delimiter=delimiter, comma=comma)
            rows = [kinds for kinds in map(dialect.kinds, sample) if "number" in kinds]
            if rows:
                width = Counter(map(len, rows)).most_common(1)[0][0]
                scored.append((_score(dialect, sample, width), width, dialect))
    if not scored:
        raise RecordError("holds no row of numbers; a record needs at least 2 samples, one a line")
    best = max(score for score, _, _ in scored)
    ties = [(width, dialect) for score, width, dialect in scored if score > best - 1e-9]
    # Where a decimal comma changes nothing, the point is as good.
    width, dialect = max(ties, key=lambda tie: (tie[0], not tie[1].comma))
    # A line cut short is a row of decimal commas too: rows of commas need not be all.
    two = next(((w, d) for score, w, d in scored if d == COMMAS and score > 1 - 1e-9 and 2 * score >= best), None)
    if two is not None and not [row for row in sample if "text" in (kinds := COMMAS.kinds(row)) and "number" in kinds]:
        width, dialect = _one_number_or_two(head, sample, two, ties)
    return dialect, width


def _score(dialect: Dialect, sample: Sequence[str], width: int) -> float:
    """Return how many of the lines are rows of that width, each by the share of its cells that are no words."""
    score = 0.0
    for line in sample:
        cells = dialect.cells(line)
        kinds = [kind_of(cell, comma=dialect.comma) for cell in cells]
        if "number" in kinds and len(kinds) == width:
            texts = [cell for cell, kind in zip(cells, kinds, strict=True) if kind == "text"]
            # A stronger delimiter between digits says that this one is none.
            if not any(NUMERIC.fullmatch(text) and re.search(r"[;\t]", text) for text in texts):
                score += 1 - len(texts) / width
    return score


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
