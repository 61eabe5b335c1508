"""Dialects of text files: the delimiter and the decimal sign.

The dialect of a file is the one in which most of its lines are rows of numbers. A text that two dialects read as
different numbers is refused. `csv.Sniffer` does neither: it fails on a banner and reads ``1,034`` as two numbers.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable
from suspid.io.names import plain
from suspid.io.text.cells import Kind, kind_of

# Digits with marks between them, in a cell that is not a number; narrow blanks and apostrophes mark thousands too.
NUMERIC = re.compile("[+-]?[\\d.,][\\d.,;\t '\u2019\xa0\u2009\u202f+\\-eE]*")
# Shapes of numbers and delimiters, and what may be a date among them.
NUMBER_ROW, DATED = re.compile(r"[1.,;+\-eE\t |]*"), re.compile(r"1[-.]1+[-.]1")
# The exponent that ends a number with a decimal point; behind a whole number, a comma may be its decimal sign.
TENS = re.compile(r"(?m)(?<=\.)(1*)[eE][+-]?1+(?=[,;\t |]|$)")
AS_ONES = bytes.maketrans(b"0123456789", b"1111111111")
# A number whose thousands are marked by blanks.
GROUPED = re.compile("[+-]?\\d{1,3}(?:[ \u2009\xa0\u202f]\\d{3})+(?:[.,]\\d+)?")
COMMENTS = ("#", "%", "//")
DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "blanks"}
# A number with its unit behind it.
UNITED = re.compile(r"\s*[+-]?\d+(?:[.]\d+)?(?:[eE][+-]?\d+)?\s*[^\W\d_][^\s\d]{0,8}[\d²³]?\s*")


@dataclass(frozen=True, kw_only=True, slots=True)
class Dialect:
    """How a line is split into cells."""

    # The character between two cells; a blank stands for any run of blanks and tabs.
    delimiter: str
    # Whether decimals follow a comma.
    comma: bool

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line without their quotes and outer blanks."""
        blanks = self.delimiter == " "
        # A quote that is not closed has no meaning.
        if '"' in line and line.count('"') % 2 == 0:
            text = line.strip() if blanks else line
            try:
                parts = next(csv.reader([text], delimiter=self.delimiter, skipinitialspace=blanks), [""])
            except csv.Error as refusal:
                raise RecordError(f"is not delimited text: {refusal}") from None
        else:
            parts = line.split() if blanks else line.split(self.delimiter)
        return [part.strip() for part in parts]

    def is_comment(self, line: str) -> bool:
        """Whether a line is a comment; ``#N/A`` in the first cell does not make one."""
        return line.lstrip().startswith(COMMENTS) and kind_of(self.cells(line)[0], comma=self.comma) != "missing"

    def kinds(self, line: str) -> list[Kind]:
        """Return what the cells of a line hold."""
        return [kind_of(cell, comma=self.comma) for cell in self.cells(line)]

    def __str__(self) -> str:
        return f"separated by {DELIMITERS[self.delimiter]}"


COMMAS = Dialect(delimiter=",", comma=False)
DIALECTS = [Dialect(delimiter=delimiter, comma=comma) for delimiter in DELIMITERS for comma in (False, True)]


@dataclass(frozen=True, slots=True)
class _Trial:
    """A dialect with the width of its rows, and how many lines of a sample are such rows."""

    score: float
    width: int
    dialect: Dialect

    @property
    def rank(self) -> tuple[int, bool]:
        """Order of trials with the same score: wider first, and a decimal point where a comma changes nothing."""
        return self.width, not self.dialect.comma


def shortened(line: str) -> str:
    """Return a line in quotes, cut where it is long."""
    text = printable(line.strip())
    return repr(text if len(text) <= 60 else text[:59] + "…")


def shapes(lines: Sequence[str]) -> Counter[str]:
    """Return how many of the lines look alike: every digit is written as 1, runs of digits as one or at most five.

    Exponents and signs are left out where they say nothing. The kinds of the cells stay the same, and the thousand rows
    of a record have some dozen shapes.

    Examples
    --------
    >>> shapes(["0.002,-3", "1.123456789e-04,-12", "12:30:05.123456,3"])
    Counter({'1.1,-1': 2, '11:11:11.11111,1': 1})
    """
    codes = np.frombuffer("\n".join(lines).encode().translate(AS_ONES), np.uint8)
    digit = codes == ord("1")
    # Whether five more digits stand before each.
    beyond = digit.copy()
    for _ in range(5):
        beyond[1:] = beyond[:-1] & digit[1:]
        beyond[:1] = False
    counted = Counter(codes[~beyond].tobytes().decode().split("\n"))
    # The length of a number, its exponent and its sign do not matter, except in dates.
    plain_rows = [shape for shape in counted if NUMBER_ROW.fullmatch(shape) and not DATED.search(shape)]
    short = TENS.sub(r"\1", "\n".join(["", *plain_rows]))
    # Runs have five digits at most. Replacements take a quarter of the time of expressions.
    for _ in range(3):
        short = short.replace("11", "1")
    # Between a comma and a whole number, a sign tells that the comma is no decimal sign.
    for mark, number in (("\n", "1"), (";", "1"), ("\t", "1"), (" ", "1"), ("|", "1"), (",", "1.1")):
        short = short.replace(f"{mark}-{number}", f"{mark}{number}")
    shape_of = {shape: shape for shape in counted} | dict(zip(plain_rows, short.split("\n")[1:], strict=True))
    alike = Counter[str]()
    for shape, often in counted.items():
        alike[shape_of[shape]] += often
    return alike


def find_dialect(head: Sequence[str], sample: Sequence[str], counted: Mapping[str, int]) -> tuple[Dialect, int]:
    """Return the dialect in which most lines of a sample are rows of numbers, and the number of cells of a row."""
    trials = _trials(counted)
    if not trials:
        # A line in the middle is no header.
        middle = sample[len(sample) // 2] if sample else ""
        seen = f": {shortened(middle)} is none" if sample else ""
        united = next((cell for cell in re.split(r"[,;\t]", middle.replace('"', "")) if UNITED.fullmatch(cell)), "")
        why = f"{shortened(united)} has its unit behind it: write numbers alone, and units above them"
        what = why if united else "a record needs at least 2 samples, one a line"
        raise RecordError(f"contains no row of numbers{seen}; {what}")
    # Blanks and tabs read what tabs alone read, and a few lines of a header besides.
    tabs = max((trial.score for trial in trials if trial.dialect.delimiter == "\t"), default=0.0)
    # Share of the lines that are read with blanks as well: if tabs read as many, tabs separate the cells.
    trials = [
        t
        for t in trials
        if t.dialect.delimiter != " " or (tabs < 0.8 * t.score and not (tabs and _has_marked_thousands(sample)))
    ]
    best = max(trial.score for trial in trials)
    ties = [trial for trial in trials if trial.score > best - 1e-9]
    chosen = max(ties, key=lambda trial: trial.rank)
    # A line that is cut short is a row of decimal commas too: not all lines need be rows of commas.
    two = next((t for t in trials if t.dialect == COMMAS and t.score > 1 - 1e-9 and 2 * t.score >= best), None)
    one = max((t for t in ties if t.dialect.comma and t.dialect.delimiter != ","), key=lambda t: t.width, default=None)
    if two and one and not any({"text", "number"} <= set(COMMAS.kinds(shape)) for shape in counted):
        rows = [line for line in sample if "," in line and "number" in COMMAS.kinds(line)]
        chosen = (two if _are_two(rows, head) else one) if rows else chosen
    return chosen.dialect, chosen.width


def _has_marked_thousands(lines: Sequence[str]) -> bool:
    r"""Return whether blanks stand between the thousands of cells that tabs separate, in most rows.

    Examples
    --------
    >>> _has_marked_thousands(["0,5\t12 002,5\t-3"] * 9), _has_marked_thousands(["0.5 12 002\t1"] * 9)
    (True, False)
    """
    rows = [[cell.strip() for cell in line.split("\t")] for line in lines if "\t" in line.strip()]
    marked = [
        any(GROUPED.fullmatch(cell) for cell in row) and all(GROUPED.fullmatch(cell) or " " not in cell for cell in row)
        for row in rows
    ]
    return 2 * sum(marked) > len(lines)


def _trials(counted: Mapping[str, int]) -> list[_Trial]:
    """Return the dialects in which some of the lines are rows of numbers."""
    text, kind = "".join(counted), cache(kind_of)
    found: list[_Trial] = []
    whole: dict[bool, _Trial | None] = {}
    for dialect in DIALECTS:
        # Delimiters that no line has leave the same cells: all of the line.
        absent = dialect.delimiter != " " and dialect.delimiter not in text
        trial = whole[dialect.comma] if absent and dialect.comma in whole else _tried(dialect, counted, kind)
        if absent:
            whole[dialect.comma] = trial
        if trial is not None:
            found.append(replace(trial, dialect=dialect))
    return found


def _tried(dialect: Dialect, counted: Mapping[str, int], kind: Callable[..., Kind]) -> _Trial | None:
    cells = {shape: dialect.cells(shape) for shape in counted}
    kinds = {shape: [kind(cell, comma=dialect.comma) for cell in row] for shape, row in cells.items()}
    widths = Counter[int]()
    for shape, found in kinds.items():
        if "number" in found:
            widths[len(found)] += counted[shape]
    if not widths:
        return None
    width = widths.most_common(1)[0][0]
    score = sum(n * _score(cells[shape], kinds[shape], width) for shape, n in counted.items())
    return _Trial(score, width, dialect) if score > 0 else None


def _score(cells: Sequence[str], kinds: Sequence[Kind], width: int) -> float:
    """Return 1 for a row of that width, less the share of its cells that are words, and 0 for other lines."""
    if "number" not in kinds or len(kinds) != width:
        return 0.0
    texts = [cell for cell, kind in zip(cells, kinds, strict=True) if kind == "text"]
    # A semicolon or tab between digits is the delimiter.
    if any(NUMERIC.fullmatch(plain(text)) and re.search(r"[;\t]", text) for text in texts):
        return 0.0
    return 1 - len(texts) / width


def _are_two(rows: Sequence[str], head: Sequence[str]) -> bool:
    """Whether rows such as ``1,234`` are two numbers: by the commas of the header, or a zero after the comma."""
    above = [
        line for line in itertools.takewhile(lambda line: "number" not in COMMAS.kinds(line), head) if line.strip()
    ]
    if above and above[-1].count(",") == Counter(line.count(",") for line in rows).most_common(1)[0][0]:
        return True
    # No program writes an integer with a leading zero.
    if ("," not in above[-1]) if above else any(re.search(r",0\d", line) for line in rows):
        return False
    raise RecordError(
        f"{shortened(rows[0])} may be one number or two: the comma may separate decimals or cells; put a header line "
        f"with the names above, or write decimals with a point"
    )
