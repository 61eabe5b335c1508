"""The tables of a fleet's results as CSV, in addition to the Parquet parts."""

from __future__ import annotations

import csv
import math
import os
from pathlib import Path

from suspid.files import replacing
from suspid.fleet.manifest import read_manifest, require_fleet
from suspid.fleet.parts import part_numbers, part_path
from suspid.fleet.tables import layout_of

# What text of a formula begins with in a spreadsheet; a quote before it makes it text again.
FORMULA = ("=", "+", "-", "@", "\t", "\r")
# Between the values of a cell that holds several.
SEPARATOR = ";"


def write_csv(folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write each table of results as one CSV file next to the Parquet parts, and return the files.

    The columns are those of the tables, numbers with all their digits. A cell with several values has a semicolon
    between them, text that a spreadsheet would take for a formula a quote before it; a value that there is not is an
    empty cell. Parts are read one by one, so memory does not grow.

    Raises
    ------
    InputError
        If the folder contains no results or a file cannot be written.

    Examples
    --------
    >>> import json
    >>> import tempfile
    >>> from suspid.fleet.manifest import FLEET_FORMAT
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "manifest.json").write_text(json.dumps({"format": FLEET_FORMAT}))
    ...     files = write_csv(folder)
    ...     head = files[-1].read_text(encoding="utf-8").split(",")
    >>> [file.name for file in files], head[:4]
    (['failures.csv', 'springs.csv', 'modes.csv'], ['record', 'sha256', 'suspid', 'mode'])
    """
    require_fleet()
    from pyarrow import parquet

    place = Path(folder)
    layout = layout_of(read_manifest(place))
    files = []
    for table in layout.names:
        columns = list(layout.columns_of(table))
        files.append(place / f"{table}.csv")
        with replacing(files[-1]) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
            rows = csv.writer(stream, lineterminator="\n")
            rows.writerow(columns)
            for number in part_numbers(place, table):
                part = parquet.ParquetFile(part_path(place, table, number)).read(columns=columns).to_pylist()
                rows.writerows([_cell(row[name]) for name in columns] for row in part)
    return tuple(files)


def _cell(value: object) -> str:
    """Return a value as the text of a cell.

    Examples
    --------
    >>> _cell(0.1), _cell(None), _cell(True), _cell(["a", "b"]), _cell("=1+1.csv")
    ('0.1', '', 'true', 'a;b', "'=1+1.csv")
    """
    if isinstance(value, list):
        return SEPARATOR.join(map(_cell, value))
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, str) and value[:1] in FORMULA:
        return f"'{value}"
    return str(value).lower() if isinstance(value, bool) else str(value)
