"""Parquet files: columns of numbers by name, read and written without loss."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.foreign import sheltered
from suspid.io.names import PER_SECOND, is_time, split_unit
from suspid.io.tables import Table, TimeBase
from suspid.units import RealArray
from suspid.values import frozen_real
from suspid.words import LeftOut, Remark

# A few bytes may encode any number of equal samples; more than this are refused.
MOST_ROWS = 1 << 28
COLUMNS_AT_ONCE = 128  # columns that are read at once


def read_parquet(path: Path) -> Table:
    """Return the table of a Parquet file: its columns of numbers, and of dates and durations as seconds.

    Dates and times of day count from the first one. Where no column is named like a time, the only
    one that holds dates, times or durations is the time base of the others. Units are read from the metadata of the
    fields, under ``unit``.
    """
    content = read_bytes(path, error=RecordError)
    if not (len(content) >= 12 and content[:4] == b"PAR1" == content[-4:]):
        cut = content[:4] == b"PAR1"
        raise RecordError("is cut off: it does not end as a Parquet file" if cut else "is not a Parquet file")
    return sheltered(lambda: _table(content, path.suffix), extra="parquet", suffix=path.suffix)


def write_parquet(
    path: Path,
    timepts: RealArray,
    values: RealArray,
    channels: Sequence[str],
    *,
    units: Sequence[str] | None = None,
    title: str = "",
) -> None:
    """Write a column ``time [s]``, then the channels (channel, sample), in double precision, without loss.

    Units and title are written to the metadata of the fields and of the table.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "bump.parquet")
    ...     write_parquet(path, np.arange(3) / 10, np.array([[1.0, 0.5, 0.1]]), ["seat"], units=["m"], title="bump")
    ...     table = read_parquet(path)
    >>> table.sizes, table.columns(["seat"]), table.units, table.title
    ({'time [s]': 3, 'seat': 3}, [array([1. , 0.5, 0.1])], {'time [s]': 's', 'seat': 'm'}, 'bump')
    """
    content = sheltered(
        lambda: _written(timepts, values, channels, units or [""] * len(channels), title),
        doing="writing",
        extra="parquet",
        suffix=".parquet",
    )
    path.write_bytes(content)


def _written(timepts: RealArray, values: RealArray, channels: Sequence[str], units: Sequence[str], title: str) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [
        pa.field(name, pa.float64(), nullable=False, metadata={"unit": unit} if unit else None)
        for name, unit in zip(["time [s]", *channels], ["s", *units], strict=True)
    ]
    schema = pa.schema(fields, metadata={"title": title, "writer": "suspid"})
    stream = io.BytesIO()
    pq.write_table(pa.table([timepts, *values], schema=schema), stream, use_dictionary=False, write_page_checksum=True)
    return stream.getvalue()


def _table(content: bytes, suffix: str) -> Table:
    import pyarrow as pa
    import pyarrow.parquet as pq

    file = pq.ParquetFile(io.BytesIO(content), page_checksum_verification=True)
    schema, samples = file.schema_arrow, file.metadata.num_rows
    if not 0 <= samples <= MOST_ROWS:
        raise RecordError(f"states {samples} samples a column; at most {MOST_ROWS} are read")
    twice, often = next(iter(Counter(schema.names).most_common(1)), ("", 0))
    if often > 1:
        raise RecordError(f"contains {often} columns {twice!r}; names must differ")
    types = {field.name: field.type for field in schema}
    unusable = {name: why for name, kind in types.items() if (why := _why_not(kind, pa.types))}
    usable = [name for name in types if name not in unusable]
    if not usable or not samples:
        listed = ", ".join(f"{printable(name)!r} {why}" for name, why in unusable.items())
        raise RecordError(f"contains no sample: {listed or f'{len(types)} columns, {samples} samples'}")

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        return sheltered(lambda: _columns(file, wanted, types, samples), extra="parquet", suffix=suffix)

    temporal = [name for name in usable if pa.types.is_temporal(types[name])]
    clocks: dict[str, TimeBase] = {}
    if len(temporal) == 1 and len(usable) > 1 and not any(is_time(name) for name in usable):
        clock = TimeBase(name=temporal[0], stamps=lambda: columns(temporal)[0])
        clocks = {name: clock for name in usable if name not in temporal}
    units = {name: unit for name in usable if name not in temporal and (unit := _unit(schema.field(name).metadata))}
    title = (schema.metadata or {}).get(b"title", b"").decode("utf-8", "replace")
    sizes = dict.fromkeys(usable, samples)
    return Table(sizes=sizes, columns=columns, unusable=unusable, units=units, clocks=clocks, title=printable(title))


def _why_not(kind: Any, types: Any) -> Remark | None:
    """Return why a column of a type is not numbers, None if it is."""
    if types.is_dictionary(kind) or types.is_string(kind) or types.is_large_string(kind):
        return Remark(LeftOut.TEXT)
    if types.is_nested(kind):
        return Remark(LeftOut.NESTED, {"type": printable(str(kind)[:60])})
    numeric = types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind) or types.is_decimal(kind)
    if numeric or (types.is_temporal(kind) and not types.is_interval(kind)):
        return None
    return Remark(LeftOut.TYPE, {"type": printable(str(kind)[:60])})


def _unit(metadata: dict[bytes, bytes] | None) -> str:
    found = next((value for key, value in (metadata or {}).items() if key.lower() in (b"unit", b"units")), b"")
    return printable(found.decode("utf-8", "replace").strip())


def _columns(file: Any, wanted: Sequence[str], types: Mapping[str, Any], samples: int) -> list[RealArray]:
    """Return the numbers of columns, read a group at a time: one by one takes long, all at once takes memory."""
    values: list[RealArray] = []
    for k in range(0, len(wanted), COLUMNS_AT_ONCE):
        names = list(wanted[k : k + COLUMNS_AT_ONCE])
        # For a name with a point, pyarrow may return members of a structure as well.
        cells = file.read(columns=names, use_threads=False)
        for name in names:
            column = cells.column(name)
            if len(column) != samples:
                raise RecordError(f"is damaged: column {name!r} contains {len(column)} samples, not {samples}")
            values.append(_numbers(name, types[name], column))
    return values


def _numbers(name: str, kind: Any, cells: Any) -> RealArray:
    """Return cells as numbers, those of time in seconds, or in the unit that the name states."""
    import pyarrow as pa

    if not pa.types.is_temporal(kind):
        return frozen_real(cells.cast(pa.float64(), safe=False).to_numpy())
    per_second = 1 / 86400 if pa.types.is_date32(kind) else PER_SECOND[getattr(kind, "unit", "ms")]
    short = pa.types.is_date32(kind) or pa.types.is_time32(kind)
    whole = cells.cast(pa.int32() if short else pa.int64()).cast(pa.int64())
    missing = np.asarray(cells.is_null().to_numpy())
    counts = whole.fill_null(0).to_numpy()
    if not pa.types.is_duration(kind) and not missing.all():
        # Seconds since 1970 in double precision would be rounded to a quarter of a microsecond.
        counts = counts - counts[np.argmin(missing)]
    promised = PER_SECOND[split_unit(name)[1] or "s"] if is_time(name) else 1.0
    return frozen_real(np.where(missing, np.nan, counts / (per_second / promised)))
