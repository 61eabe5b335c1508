"""The files of a fleet's results: Parquet parts that are complete or absent.

A folder of results holds

- ``manifest.json``: settings and versions; written first;
- ``records.jsonl``: the records of a folder, a glob or a list, one ``[path, name, bytes,
  when it was changed]`` a line;
- ``modes/part-000000.parquet`` …: one row per record and mode; of drives ``drives``: one row per vehicle and drive;
- ``springs/part-….parquet``: one row per record and parameter of the car, where a car was given;
- ``failures/part-….parquet``: one row per record, step and reason, where something failed.

Part number k of each table comes from the k-th chunk of records. The part of ``modes`` or ``drives`` is written last,
with or without rows: it marks the chunk as complete. It holds the sha256 of its own file, taken with zeros in place of
the sha256, and those of the other tables' parts, so that a part that was damaged or deleted is seen. Nothing in these
files depends on the clock or on the worker.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from suspid.errors import InputError
from suspid.files import printable
from suspid.fleet.manifest import durable_write, read_manifest, require_fleet, writing
from suspid.fleet.records import file_hash
from suspid.fleet.tables import DECAYS, Layout, Row, Rows, TableName, layout_of

if TYPE_CHECKING:
    import pyarrow as pa

# Key of the metadata of a part that holds how many records its chunk had and how many failed.
COUNTS = b"suspid counts"
# What stands in a part for its sha256 while that is computed.
NO_HASH = "sha256:" + 64 * "0"


@dataclass(frozen=True, kw_only=True, slots=True)
class Part:
    """One chunk's tables as the bytes of Parquet files; one without rows has none, save the last that is written."""

    files: Mapping[TableName, bytes]
    records: int
    failed: int


def as_part(rows: Rows, layout: Layout = DECAYS) -> Part:
    """Return the rows as the bytes of Parquet files: the same rows, the same bytes."""
    counts = {"records": rows.records, "failed": rows.failed}
    tables: dict[TableName, tuple[Row, ...]] = {name: getattr(rows, name) for name in layout.names}
    others = {name: some for name, some in tables.items() if some and name != layout.main}
    files = {name: _parquet(layout, name, some, counts) for name, some in others.items()}
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    main = _parquet(layout, layout.main, tables[layout.main], {**counts, "parts": hashes, "this": NO_HASH})
    files[layout.main] = main.replace(NO_HASH.encode(), _own_hash(main))
    return Part(files=files, records=rows.records, failed=rows.failed)


def write_part(folder: Path, number: int, part: Part, layout: Layout = DECAYS) -> None:
    """Write a chunk's tables, each complete or absent; the last one marks the chunk as complete."""
    for table in layout.names:
        path = part_path(folder, table, number)
        if table in part.files:
            durable_write(path, part.files[table])
        else:
            # A killed run may have left a part here; this chunk has no such rows.
            with writing(path):
                path.unlink(missing_ok=True)


def part_path(folder: Path, table: TableName, number: int) -> Path:
    """Return the place of a part."""
    return folder / table / f"part-{number:06d}.parquet"


def part_counts(folder: Path, number: int, layout: Layout = DECAYS) -> tuple[int, int] | None:
    """Return how many records a chunk had and how many failed, or None if it is not complete and undamaged."""
    counts = _counts(folder, number, layout)
    return None if isinstance(counts, Path) else counts


def check_parts(folder: Path, layout: Layout, count: int | None = None) -> list[tuple[int, int]]:
    """Return how many records each chunk had and how many failed; refuse parts that are damaged, or missing of a count.

    Raises
    ------
    InputError
        The message names the first of them.
    """
    numbers = part_numbers(folder, layout.main)
    found = [_counts(folder, number, layout) for number in (numbers if count is None else range(count))]
    bad = [one for one in found if isinstance(one, Path)]
    if bad:
        more = f"; so are parts of {len(bad) - 1} more chunks" if len(bad) > 1 else ""
        raise InputError(
            f"{printable(str(bad[0]))}: is damaged or missing{more}; the command that began the run makes it again"
        )
    return [one for one in found if not isinstance(one, Path)]


def _counts(folder: Path, number: int, layout: Layout) -> tuple[int, int] | Path:
    """Return how many records a chunk had and how many failed, or the part of it that is missing or damaged."""
    import pyarrow as pa
    from pyarrow import parquet

    path = part_path(folder, layout.main, number)
    try:
        content = path.read_bytes()
        counts = json.loads((parquet.read_metadata(io.BytesIO(content)).metadata or {})[COUNTS])
        said, hashes = counts["this"].encode(), counts["parts"]
        if said != _own_hash(content.replace(said, NO_HASH.encode())):
            return path
        for table in layout.names:
            if table != layout.main:
                path = part_path(folder, table, number)
                # A part that the chunk does not have may be of a run that was killed: its rows are no rows of this one.
                if path.exists() != (table in hashes) or (table in hashes and file_hash(path) != hashes[table]):
                    return path
        return int(counts["records"]), int(counts["failed"])
    except (OSError, KeyError, ValueError, TypeError, AttributeError, pa.ArrowException):
        return path


def _own_hash(content: bytes) -> bytes:
    return b"sha256:" + hashlib.sha256(content).hexdigest().encode()


def part_numbers(folder: Path, table: TableName) -> list[int]:
    """Return the numbers of the parts of a table that are there, in order."""
    names = (path.name for path in (folder / table).glob("part-*.parquet"))
    return sorted(int(name[5:-8]) for name in names if name[5:-8].isdigit())


def part_names(folder: Path, number: int, layout: Layout = DECAYS) -> set[tuple[str, str | None]]:
    """Return (record, sha256) of every record that has a row in a complete chunk."""
    from pyarrow import parquet

    found: set[tuple[str, str | None]] = set()
    for table in (layout.main, *layout.names[:1]):
        path = part_path(folder, table, number)
        if path.exists():
            columns = parquet.ParquetFile(path).read(columns=["record", "sha256"]).to_pydict()
            found |= set(zip(columns["record"], columns["sha256"], strict=True))
    return found


def read_table(folder: str | os.PathLike[str], table: TableName, *, columns: Sequence[str] | None = None) -> pa.Table:
    """Return a table of the results: all its parts in order, or some columns of them.

    Raises
    ------
    InputError
        If the folder contains no results, or damaged ones.
    """
    require_fleet()
    import pyarrow as pa
    from pyarrow import parquet

    layout = layout_of(read_manifest(Path(folder)))
    known = layout.columns_of(table)
    paths = [part_path(Path(folder), table, number) for number in part_numbers(Path(folder), table)]
    wanted = list(columns or known)
    # Metadata differ from part to part; without them the tables join.
    parts = []
    for path in paths:
        try:
            parts.append(parquet.ParquetFile(path).read(columns=wanted).replace_schema_metadata())
        except (OSError, ValueError, pa.ArrowException) as refusal:
            raise InputError(f"{printable(str(path))}: is damaged: {printable(str(refusal)):.200}") from None
    return pa.concat_tables(parts) if parts else layout.schema(table).empty_table().select(wanted)


def _parquet(layout: Layout, table: TableName, rows: Sequence[Row], counts: Mapping[str, object]) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    schema = layout.schema(table)
    arrays = [pa.array([row[name] for row in rows], type=schema.field(name).type) for name in schema.names]
    content = pa.Table.from_arrays(arrays, schema=schema.with_metadata({COUNTS: json.dumps(counts).encode()}))
    stream = io.BytesIO()
    # Everything that decides the bytes is given here, not left to a default.
    parquet.write_table(content, stream, compression="zstd", compression_level=3, version="2.6", row_group_size=1 << 20)
    return stream.getvalue()
