"""Spreadsheets as tables: the sheet with the most numbers is read as text is."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any, TypeGuard

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.foreign import sheltered
from suspid.io.limits import check_memory, most_bytes
from suspid.io.tables import Table
from suspid.io.text.cells import kind_of
from suspid.io.text.delimited import table_of_text
from suspid.words import LeftOut, Remark

# Rows of a sheet in a zipped spreadsheet, and the columns of their cells, as it names them.
SHEET_ROW, SHEET_COLUMN = re.compile(rb'<row[^<>]*? r="(\d{1,7})"'), re.compile(rb'<c[^<>]*? r="([A-Z]{1,3})\d')
# Memory that a cell takes, whether it is filled or not [bytes]: all between the first one and the last are made.
CELL_BYTES = 32
# Whole numbers below this have all their digits in text without decimals.
ALL_DIGITS = 1e15


def read_sheets(path: Path) -> Table:
    """Return the table of a spreadsheet, of its sheet with the most numbers; what formulas gave is read, not they."""
    content = read_bytes(path, error=RecordError)
    sheets = sheltered(lambda: _sheets(content), extra="sheets", suffix=path.suffix)
    numbers = {name: sum(_is_number(cell) for row in rows for cell in row) for name, rows in sheets.items()}
    used = max(numbers, key=lambda name: numbers[name], default="")
    if not numbers.get(used):
        raise RecordError("has no sheet with numbers")
    others = {name: rows for name, rows in sheets.items() if name != used and numbers[name]}
    table = table_of_text(text_of(sheets[used]))
    left_out = {f"sheet {printable(n)}": Remark(LeftOut.OTHER_SHEET, {"rows": len(r)}) for n, r in others.items()}
    return replace(table, unusable={**table.unusable, **left_out})


def _sheets(content: bytes) -> dict[str, list[list[Any]]]:
    """Return the rows of cells of each sheet that is shown, or of all where none is, with blank ones above them."""
    from python_calamine import CalamineWorkbook, SheetTypeEnum, SheetVisibleEnum

    if zipfile.is_zipfile(io.BytesIO(content)):
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            check_memory(sum(entry.file_size for entry in archive.infolist()), len(content))
            for entry in archive.infolist():
                if entry.filename.startswith("xl/worksheets/"):
                    _refuse_far_cells(archive.read(entry), len(content))
    with CalamineWorkbook.from_filelike(io.BytesIO(content)) as book:
        every = [sheet for sheet in book.sheets_metadata if sheet.typ == SheetTypeEnum.WorkSheet]
        shown = [sheet for sheet in every if sheet.visible == SheetVisibleEnum.Visible] or every
        out = dict[str, list[list[Any]]]()
        for one in shown:
            sheet = book.get_sheet_by_name(one.name)
            above = sheet.start[0] if sheet.start else 0
            out[one.name] = [[] for _ in range(above)] + sheet.to_python()
    return out


def _refuse_far_cells(sheet: bytes, size: int) -> None:
    """Refuse a sheet of a file of a size with so few cells so far apart that all between would take too much memory."""
    rows, columns = cells_between(sheet)
    wanted = CELL_BYTES * rows * columns
    if wanted > most_bytes(size):
        raise RecordError(
            f"has a sheet whose first and last cell lie {rows} rows and {columns} columns apart: all between would "
            f"take {wanted / 2**30:.3g} GiB of memory, of a file of {size} bytes; delete the cells far from the samples"
        )


def cells_between(sheet: bytes) -> tuple[int, int]:
    """Return how many rows and columns lie between the first cell of a sheet and the last.

    Examples
    --------
    >>> cells_between(b'<row r="2"><c r="B2"><v>1</v></c></row><row r="9"><c r="AA9"/></row>')
    (8, 26)
    """
    rows = [int(row) for row in SHEET_ROW.findall(sheet)]
    columns = [_number_of(name) for name in set(SHEET_COLUMN.findall(sheet))]
    return (max(rows) - min(rows) + 1, max(columns) - min(columns) + 1) if rows and columns else (0, 0)


def _number_of(column: bytes) -> int:
    """Return the number of a column, from 1, by its letters."""
    number = 0
    for letter in column:
        number = 26 * number + letter - ord("A") + 1
    return number


def text_of(rows: Sequence[Sequence[Any]]) -> bytes:
    r"""Return rows of cells as text, each in a line of its own, with tabs between cells.

    Examples
    --------
    >>> text_of([["time\n[s]", "seat"], [2.0, 1.5e-7], [timedelta(hours=1, milliseconds=2), ""]])
    b'time [s]\tseat\n2\t1.5e-07\n01:00:00.002000\t\n'
    """
    # A stamp at midnight is a date to a spreadsheet.
    stamped = {k for row in rows for k, value in enumerate(row) if isinstance(value, datetime)}
    whole = (
        [_cell(datetime.combine(value, time()) if k in stamped and _is_date(value) else value) for k, value in each]
        for each in map(enumerate, rows)
    )
    return "".join(f"{chr(9).join(cells)}\n" for cells in whole).encode("utf-8", "replace")


def _is_date(value: object) -> TypeGuard[date]:
    return isinstance(value, date) and not isinstance(value, datetime)


def _is_number(value: object) -> bool:
    """Return whether a cell holds a number, or a text that is one: some programs write all cells as text."""
    if isinstance(value, str):
        return any(kind_of(value, comma=comma) == "number" for comma in (False, True))
    return isinstance(value, int | float) and not isinstance(value, bool)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < ALL_DIGITS else repr(value)
    if isinstance(value, timedelta):
        minutes, seconds = divmod(value.total_seconds(), 60)
        return f"{minutes // 60:02.0f}:{minutes % 60:02.0f}:{seconds:09.6f}"
    if isinstance(value, datetime):
        return value.isoformat(sep=" ")
    if isinstance(value, date | time):
        return value.isoformat()
    return " ".join(str(value).split())
