"""Vehicle and date of each record: from a table, or from the record's name."""

from __future__ import annotations

import csv
import datetime
import math
import os
import re
from collections.abc import Iterable
from pathlib import Path

from suspid.errors import InputError
from suspid.files import printable, read_text
from suspid.values import nearest_names

VEHICLE_COLUMNS = ("record", "vehicle", "date")


def read_vehicles(path: str | os.PathLike[str]) -> dict[str, tuple[str, float]]:
    r"""Return vehicle and time of each record from a CSV with the columns ``record``, ``vehicle`` and ``date``.

    A date such as ``2024-05-31`` or ``2024-05-31T12:00`` is converted to years; a plain number (a mileage) is kept.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "vehicles.csv")
    ...     _ = path.write_text("record,vehicle,date\nrun1.csv,VAN 7,2024-01-01\nrun2.csv,VAN 7,2024-07-01\n")
    ...     found = read_vehicles(path)
    >>> found["run2.csv"][0], found["run2.csv"][1] - found["run1.csv"][1]
    ('VAN 7', 0.498)
    """
    name = printable(str(path))
    rows = csv.DictReader(read_text(Path(path)).split("\n"))
    known = [column.strip() for column in rows.fieldnames or ()]
    for column in VEHICLE_COLUMNS:
        if column not in known:
            raise InputError(f"{name}: there is no column {column!r}; it needs {', '.join(VEHICLE_COLUMNS)}")
    rows.fieldnames = known
    found: dict[str, tuple[str, float]] = {}
    kinds: set[str] = set()
    for number, row in enumerate(rows, start=2):
        record, vehicle, date = ((row.get(column) or "").strip() for column in VEHICLE_COLUMNS)
        if record in found:
            raise InputError(f"{name}: line {number}: record {printable(record)!r} stands there twice")
        try:
            kind, when = _time(date)
        except ValueError:
            raise InputError(
                f"{name}: line {number}: {printable(date)!r} is neither a date as 2024-05-31 nor a number"
            ) from None
        kinds.add(kind)
        found[record] = printable(vehicle), when
    if len(kinds) > 1:
        raise InputError(f"{name}: some dates are calendar dates, others numbers; write all of them in one way")
    return found


def vehicles_from_names(names: Iterable[str], pattern: str) -> dict[str, tuple[str, float]]:
    r"""Return vehicle and time of each record whose name matches a pattern with these two groups.

    Examples
    --------
    >>> pattern = r"(?P<vehicle>\w+)/(?P<date>\d{4}-\d{2}-\d{2})"
    >>> vehicles_from_names(["north/V7/2024-01-01.csv", "V8/other.csv"], pattern)
    {'north/V7/2024-01-01.csv': ('V7', 2024.0)}
    """
    try:
        groups = re.compile(pattern)
    except re.error as error:
        raise InputError(f"{pattern=} is no regular expression: {error}") from None
    for group in VEHICLE_COLUMNS[1:]:
        if group not in groups.groupindex:
            raise InputError(f"{pattern=} has no group (?P<{group}>…).{nearest_names(group, groups.groupindex)}")
    found: dict[str, tuple[str, float]] = {}
    for name in names:
        match = groups.search(name)
        if match and match["date"] is not None and match["vehicle"] is not None:
            try:
                found[name] = match["vehicle"], _time(match["date"])[1]
            except ValueError:
                continue
    return found


def _time(text: str) -> tuple[str, float]:
    try:
        number = float(text)
    except ValueError:
        when = datetime.datetime.fromisoformat(text).replace(tzinfo=datetime.UTC)
        first = datetime.datetime(2000, 1, 1, tzinfo=datetime.UTC)
        return "date", 2000 + (when - first).total_seconds() / (365.25 * 86400)
    if not math.isfinite(number):
        raise ValueError(text)
    return "number", number
