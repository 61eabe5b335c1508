"""Vehicle and date of each record: from a table, or from the record's name."""

from __future__ import annotations

import csv
import datetime
import math
import os
import re
from collections.abc import Iterable
from pathlib import Path, PurePosixPath

from suspid.errors import InputError
from suspid.files import printable, read_text
from suspid.values import nearest_names
from suspid.wording import Argument

VEHICLE_COLUMNS = ("record", "vehicle", "date")
# A date in a name, with or without a time of day: 2024-05-31, 20240531T1200, 2024_05_31 12-00-30.
DATE_IN_NAME = re.compile(
    r"(?<!\d)(?P<year>(?:19|20)\d\d)(?P<between>[-_.]?)(?P<month>0[1-9]|1[0-2])(?P=between)(?P<day>0[1-9]|[12]\d|3[01])"
    r"(?:[T_ -]*(?P<hour>[01]\d|2[0-3])[-_:.]?(?P<minute>[0-5]\d)(?:[-_:.]?(?P<second>[0-5]\d))?)?(?!\d)"
)


# A pattern that finds a vehicle's folder and the date with which the name of a file begins.
SUCH_A_PATTERN = "(?P<vehicle>[^/]+)/(?P<date>[0-9-]+)"


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
        raise InputError(Argument("pattern", repr(pattern)), f" is not a regular expression: {error}") from None
    for group in VEHICLE_COLUMNS[1:]:
        if group not in groups.groupindex:
            raise InputError(
                Argument("pattern", repr(pattern)),
                f" has no group (?P<{group}>…), as in {SUCH_A_PATTERN}.{nearest_names(group, groups.groupindex)}",
            )
    found: dict[str, tuple[str, float]] = {}
    for name in names:
        match = groups.search(name)
        if match and match["date"] is not None and match["vehicle"] is not None:
            try:
                found[name] = match["vehicle"], _time(match["date"])[1]
            except ValueError:
                continue
    return found


def check_vehicles(table: str | os.PathLike[str] | None, pattern: str | None) -> None:
    """Refuse a table or a pattern of vehicles that cannot be used, before the records are read."""
    if table is not None:
        read_vehicles(table)
    if pattern is not None:
        vehicles_from_names((), pattern)


def vehicle_in_name(name: str) -> tuple[str | None, float | None]:
    """Return the vehicle and the time of a record by its name: its folders, and the last date in it.

    Without folders the vehicle is what stands beside the date in the name of the file. None where there is nothing.

    Examples
    --------
    >>> vehicle_in_name("north/VAN 7/2024-01-01.mf4"), vehicle_in_name("V8_20240101.csv"), vehicle_in_name("run1.csv")
    (('north/VAN 7', 2024.0), ('V8', 2024.0), (None, None))
    """
    dates = list(DATE_IN_NAME.finditer(name))
    when = None
    for date in reversed(dates):
        clock = ":".join(date[part] or "00" for part in ("hour", "minute", "second"))
        try:
            when = _time(f"{date['year']}-{date['month']}-{date['day']}T{clock}")[1]
            break
        except ValueError:
            continue
    path = PurePosixPath(name)
    folders = [part for part in path.parent.parts if not DATE_IN_NAME.search(part)]
    if folders:
        return "/".join(folders), when
    beside = DATE_IN_NAME.sub("", path.stem).strip(" -_.") if when is not None else ""
    return beside or None, when


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
