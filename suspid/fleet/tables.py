"""The tables of a fleet's results: their columns, and the rows of a record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import pyarrow as pa

TableName = Literal["modes", "springs", "failures"]
# The last one makes a chunk complete.
TABLES: tuple[TableName, ...] = ("failures", "springs", "modes")
Row = Mapping[str, object]

WHICH = dict.fromkeys(("record", "sha256", "suspid"), "string")
TABLE_COLUMNS: dict[TableName, dict[str, str]] = {
    "modes": {
        **WHICH,
        **dict.fromkeys(("mode", "modes"), "int32"),
        "kind": "string",
        **dict.fromkeys(
            ("f_hz", "wn_rad_per_s", "wn_std_rad_per_s", "wn_low_rad_per_s", "wn_high_rad_per_s"), "double"
        ),
        **dict.fromkeys(("zeta", "zeta_std", "zeta_low", "zeta_high"), "double"),
        **dict.fromkeys(("pole_real_rad_per_s", "pole_imag_rad_per_s", "collinearity"), "double"),
        **dict.fromkeys(("loudness", "halves_apart", "explained_least"), "double"),
        "decays": "int32",
        "start_s": "double",
        "samples": "int64",
        "rate_hz": "double",
        "channels": "strings",
        **dict.fromkeys(("explained", "noise_std", "shape_real", "shape_imag"), "numbers"),
        "verdict": "string",
        **dict.fromkeys(("doubts", "findings", "notes"), "strings"),
        "remarks": "string",
    },
    "springs": {
        **WHICH,
        **dict.fromkeys(("parameter", "unit"), "string"),
        **dict.fromkeys(("value", "std", "low", "high"), "double"),
        **dict.fromkeys(("held", "explains"), "bool"),
        "chi_square": "double",
        "freedom": "int32",
        "residual": "double",
        "alternatives": "int32",
        "status": "string",
    },
    "failures": {**WHICH, "step": "string", "code": "string", "checks": "strings", "reason": "string"},
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Rows:
    """What some records gave: rows of each table, and how many records they are."""

    modes: tuple[Row, ...] = ()
    springs: tuple[Row, ...] = ()
    failures: tuple[Row, ...] = ()
    records: int = 1
    # How many of these have a row among the failures.
    failed: int = 0


def joined(rows: Sequence[Rows]) -> Rows:
    """Return the rows of several records as one, in order."""
    return Rows(
        modes=tuple(row for some in rows for row in some.modes),
        springs=tuple(row for some in rows for row in some.springs),
        failures=tuple(row for some in rows for row in some.failures),
        records=sum(some.records for some in rows),
        failed=sum(some.failed for some in rows),
    )


def schema_of(table: TableName) -> pa.Schema:
    """Return the schema of a table."""
    import pyarrow as pa

    types = {
        "string": pa.string(),
        "int32": pa.int32(),
        "int64": pa.int64(),
        "double": pa.float64(),
        "bool": pa.bool_(),
        "strings": pa.list_(pa.string()),
        "numbers": pa.list_(pa.float64()),
    }
    return pa.schema([(name, types[kind]) for name, kind in TABLE_COLUMNS[table].items()])
