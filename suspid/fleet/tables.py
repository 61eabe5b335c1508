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


# What is in columns whose names do not say it; Parquet keeps it as the description of the column.
MEANINGS = {
    "sha256": "of the file, or of the samples of a record",
    "modes": "number of modes of the record",
    "kind": "pair, real or zero: one entry is a conjugate pair, one real pole, or one pole at zero",
    "collinearity": "1 if all channels move in phase or antiphase [1]",
    "loudness": "power of the residual near the mode over that of white noise [1]; above 1 the interval is widened",
    "halves_apart": "distance of the mode in the first and second half of the decay [standard deviations]",
    "explained_least": "least share of the energy of a channel that the modes explain [1]",
    "explained": "share of the energy that the modes explain, by channel [1]",
    "noise_std": "standard deviation of the noise, by channel",
    "decays": "how many decays were used",
    "doubts": "codes of what speaks against the result",
    "findings": "codes of defects of the recording that were found",
    "notes": "codes of what was done on the way",
    "remarks": "doubts, findings and notes in words",
    "held": "whether the parameter was held at its nominal value",
    "explains": "whether the car explains the modes within their uncertainty",
    "residual": "largest relative distance of a mode of the car from the measured one [1]",
    "alternatives": "how many other cars explain the modes as well",
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
    return pa.schema(
        [
            pa.field(name, types[kind], metadata={"description": MEANINGS[name]} if name in MEANINGS else None)
            for name, kind in TABLE_COLUMNS[table].items()
        ]
    )
