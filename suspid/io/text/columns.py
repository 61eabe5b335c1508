"""Columns of text files: which lines are rows, names or units of them."""

from __future__ import annotations

import itertools
import re
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from suspid.io.names import is_abscissa, is_time, plain
from suspid.io.text.cells import Kind, kind_of
from suspid.io.text.dialects import COMMENTS, DELIMITERS, Dialect

REMARKS = {"comment", "comments", "remark", "remarks", "note", "notes", "kommentar"}
# One unit or several joined, such as mm, m/s^2, (kN), µm/m or °/s; every one that is converted is among them.
ATOM = (
    r"(?:[hkKMGcdmµμunp]?(?:m|s|g|gn|V|A|Hz|Pa|J|W|N|Nm|rad|bar|Ohm|Ω|strain|eps|ε|[Gg]al)"
    r"|min|h|hr|sec|deg[CF]?|°[CF]?|C|K|G|%|1|-|rpm|U|l|in|inch|mil|ft|lbf|kgf|psi|mph|MPH|kph|KPH|kn|ips|dps|g0|u[eE]"
    r"|[mu]G|microstrain|Celsius|counts?)"
)
UNIT = re.compile(
    rf"{ATOM}(?:\^?-?[0-9²³]|\*\*-?\d|⁻[¹²])?(?:[/*·. ]{ATOM}(?:\^?-?[0-9²³]|\*\*-?\d|⁻[¹²])?)*|hh:mm:ss\S*|[Uu]nits?"
    r"|[Ss]econds?|[Vv]olts?|Sequence|(?i:(?:milli|centi)?met(?:er|re)s?|inches|feet|degrees?|radians?)"
)

# Letters of the longest unit that is taken for one beside others that are known.
LONGEST_UNIT = 8
# What stands before names in a header that says what it holds.
LABELLED = re.compile(r"^\s*\w+\s*:=\s*")


@dataclass(frozen=True, slots=True)
class Columns:
    """The columns of the rows of a file."""

    dialect: Dialect
    kinds: tuple[Kind, ...]
    row: str = ""

    @property
    def trailing(self) -> bool:
        """Whether a delimiter ends each row: nothing follows it, not a word for what is missing."""
        ends = len(self.kinds) > 1 and self.kinds[-1] == "missing"
        return ends and not (self.row and self.dialect.cells(self.row)[-1])

    def are_data(self, line: str) -> bool:
        """Whether a line is a row of these columns."""
        kinds = self.dialect.kinds(line)
        return (
            len(kinds) == len(self.kinds)
            and not self.are_numbered_by(line)
            and bool({"number", "stamp"} & set(kinds))
            and all(a in (b, "missing") or b in ("text", "missing") for a, b in zip(kinds, self.kinds, strict=True))
        )

    def are_numbered_by(self, line: str) -> bool:
        """Whether a line is the header that pandas writes over an index and columns without names: blank, 0, 1, 2."""
        cells = self.dialect.cells(line)
        return self.kinds[0] != "missing" and cells == ["", *map(str, range(len(self.kinds) - 1))] and len(cells) > 1

    def are_missing(self, line: str) -> bool:
        """Whether a line is a row of these columns without a number."""
        return bool(line.strip()) and self.dialect.kinds(line) == ["missing"] * len(self.kinds)

    def titles(self, line: str) -> list[str]:
        """Return the cells of a header line, one for each column where possible."""
        blanks, width = self.dialect.delimiter == " ", len(self.kinds)
        text = line.lstrip() if blanks else line
        mark = next((mark for mark in COMMENTS if text.startswith(mark)), "")
        text = line.replace(mark, " " * len(mark), 1) if blanks else text.removeprefix(mark)
        text = LABELLED.sub("", text) if text.count(":=") == 1 else text
        cells = self.dialect.cells(text)
        # A program that separates rows by tabs or blanks may leave commas between the names.
        if self.dialect.delimiter != "," and len(cells) > 1 and all(cell.endswith(",") for cell in cells[:-1]):
            cells = [cell.removesuffix(",") for cell in cells]
        if blanks and len(cells) != width:
            wide = [cell.strip().strip('"') for cell in re.split(r"\t|\s{2,}", text.strip())]
            cells = wide if len(wide) == width else _aligned(text, self.row) or cells
        if len(cells) == 1 < width:
            cells = _marked(cells[0], width, comment=bool(mark)) or cells
        # LabVIEW names a column of comments that the rows lack.
        if len(cells) == width + 1 and (not cells[-1] or cells[-1].lower() in REMARKS):
            return cells[:-1]
        return [*cells, ""] if len(cells) == width - 1 and self.trailing else cells

    def may_be_named_by(self, line: str) -> bool:
        """Whether a line may hold the names of the columns: a cell each, and numbers only beside a time or from pandas.

        Oscilloscopes number their channels beside an x. A cell that stands alone in front is the title of the rows.
        """
        cells = self.titles(line)
        numbers = [kind_of(cell, comma=self.dialect.comma) in ("number", "stamp") for cell in cells]
        if len(cells) != len(self.kinds) or not any(cells) or all(numbers):
            return False
        if len(cells) > 1 and not any(cells[1:]) and not _is_axis(cells[0]):
            return False
        return (
            self.are_numbered_by(line)
            or not any(numbers)
            or any(is_time(cell) for cell in cells)
            or (_is_axis(cells[0]) and _count_up(cells[1:]))
        )

    def units(self, line: str) -> list[str]:
        """Return the cells of a header line without brackets."""
        return [cell.strip("[]() ") for cell in self.titles(line)]

    def are_units(self, line: str) -> bool:
        """Whether a line holds nothing but units."""
        cells, filled = self.units(line), [cell for cell in self.titles(line) if cell]
        bracketed = len(filled) > 1 and all(re.fullmatch(r"\(.*\)|\[.*\]", cell) for cell in filled)
        return bracketed or (any(cells) and all(not cell or UNIT.fullmatch(plain(cell)) for cell in cells))

    def are_units_mostly(self, line: str) -> bool:
        """Whether a line below names holds units in most cells, and in the others a word as short as a unit.

        Names differ: where cells are the same, half of them are enough.
        """
        cells = [cell for cell in self.units(line) if cell]
        known = [bool(UNIT.fullmatch(plain(cell))) for cell in cells]
        short = all(len(cell) <= LONGEST_UNIT and " " not in cell for cell in cells)
        same = len(set(cells)) < len(cells) and not any(is_time(cell) for cell in cells)
        return 2 * sum(known) + same > len(known) and short


def _is_axis(name: str) -> bool:
    return is_time(name) or is_abscissa(name)


def _count_up(cells: Sequence[str]) -> bool:
    """Whether cells hold whole numbers that rise, as those of channels do."""
    return all(map(str.isdecimal, cells)) and all(int(a) < int(b) for a, b in itertools.pairwise(cells))


def _marked(line: str, width: int, *, comment: bool) -> list[str]:
    """Return names that another mark than that of the rows separates, if each column gets one; else none.

    Programs that write decimals with a comma separate the cells by tabs, and some leave commas between the names.
    Blanks stand between the words of titles and comments as well: names that they separate begin with that of an axis.
    """
    for mark in DELIMITERS:
        cells = Dialect(delimiter=mark, comma=False).cells(line)
        named = mark != " " or (not comment and _is_axis(next(iter(cells), "")))
        if len(cells) == width and named and all(kind_of(cell, comma=False) == "text" for cell in cells):
            return cells
    return []


def _aligned(line: str, row: str) -> list[str]:
    """Return names of several words above the cells of a row, if they end or begin where the cells do; else none."""
    words = list(re.finditer(r"\S+", line))
    for ends in (True, False):
        edges = [found.end() if ends else found.start() for found in re.finditer(r"\S+", row)]
        places = [found.end() if ends else found.start() for found in words]
        if set(edges) <= set(places) and (places[-1] <= edges[-1] if ends else places[0] >= edges[0]):
            # A word belongs to the cell that ends where it ends or later, or begins where it begins or earlier.
            of = [bisect_left(edges, x) if ends else bisect_right(edges, x) - 1 for x in places]
            return [" ".join(w[0] for w, k in zip(words, of, strict=True) if k == n) for n in range(len(edges))]
    return []
