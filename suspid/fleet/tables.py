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

WHICH = {"record": "string", "sha256": "string", "suspid": "string"}
COLUMNS: dict[TableName, dict[str, str]] = {
    "modes": {
        **WHICH,
        "mode": "int32",
        "modes": "int32",
        "kind": "string",
        "f_hz": "double",
        "wn_rad_per_s": "double",
        "wn_std_rad_per_s": "double",
        "wn_low_rad_per_s": "double",
        "wn_high_rad_per_s": "double",
        "zeta": "double",
        "zeta_std": "double",
        "zeta_low": "double",
        "zeta_high": "double",
        "pole_real_rad_per_s": "double",
        "pole_imag_rad_per_s": "double",
        "collinearity": "double",
        "loudness": "double",
        "halves_apart": "double",
        "explained_least": "double",
        "decays": "int32",
        "start_s": "double",
        "samples": "int64",
        "rate_hz": "double",
        "channels": "strings",
        "explained": "numbers",
        "noise_std": "numbers",
        "shape_real": "numbers",
        "shape_imag": "numbers",
        "verdict": "string",
        "doubts": "strings",
        "findings": "strings",
        "notes": "strings",
        "remarks": "string",
    },
    "springs": {
        **WHICH,
        "parameter": "string",
        "unit": "string",
        "value": "double",
        "std": "double",
        "low": "double",
        "high": "double",
        "held": "bool",
        "explains": "bool",
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
    """What some records gave: rows of each table, and how many records they are.

    Parameters
    ----------
    modes, springs, failures : tuple of mappings
        Rows, with the columns of `COLUMNS`.
    records : int
        How many records gave them.
    failed : int
        How many of these have a row among the failures.
    """

    modes: tuple[Row, ...] = ()
    springs: tuple[Row, ...] = ()
    failures: tuple[Row, ...] = ()
    records: int = 1
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
    return pa.schema([(name, types[kind]) for name, kind in COLUMNS[table].items()])
