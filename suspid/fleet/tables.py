"""The tables of a fleet's results: their columns, and the rows of a record.

Records of decays leave rows of modes, drives one row each, whose last columns are those of the struts of the car.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from suspid.errors import InputError
from suspid.files import printable
from suspid.model import Suspension, car_from_toml
from suspid.performance import dampers_between
from suspid.reconstruction import QUANTITIES
from suspid.words import Verdict

if TYPE_CHECKING:
    import pyarrow as pa

TableName = Literal["modes", "drives", "springs", "failures"]
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
        **dict.fromkeys(("doubts", "doubts_in_words", "findings", "notes"), "strings"),
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
# Of a drive, before those of its struts.
DRIVE_COLUMNS = {
    **WHICH,
    "vehicle": "string",
    "time": "double",
    "verdict": "string",
    **dict.fromkeys(("doubts", "doubts_in_words", "notes"), "strings"),
    "remarks": "string",
    "stretches": "int32",
    **dict.fromkeys(("used_s", "length_s", "speed_m_per_s"), "double"),
    "explains": "bool",
    "chi_square": "double",
    "freedom": "int32",
    **dict.fromkeys(("road_wheels", "road_classes"), "strings"),
    **dict.fromkeys(("road_exponents", "road_roughness_m3"), "numbers"),
    "body_channels": "strings",
    **dict.fromkeys(("body_hz", "body_low_hz", "body_high_hz"), "numbers"),
}
# Of each damper between masses, after its name and a dot.
DAMPER_COLUMNS = {
    "correlation": "double",
    "wear": "string",
    **dict.fromkeys(("lost", "lost_low", "lost_high"), "double"),
    **dict.fromkeys(("phase_rad", "phase_std_rad", "adhesion", "adhesion_std"), "double"),
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
    "doubts_in_words": "a sentence for each of the doubts",
    "findings": "codes of defects of the recording that were found",
    "notes": "codes of what was done on the way",
    "remarks": "doubts, findings and notes in words",
    "held": "whether the parameter was held at its nominal value",
    "explains": "whether the car explains the modes within their uncertainty",
    "residual": "largest relative distance of a mode of the car from the measured one [1]",
    "alternatives": "how many other cars explain the modes as well",
    "time": "date in years, or the number that was given, such as a mileage",
    "stretches": "how many stretches were used",
    "used_s": "length of the stretches that were used [s]",
    "speed_m_per_s": "mean speed over them",
    "road_classes": "class of ISO 8608 under each of the wheels",
    "body_hz": "frequency of the body, by channel; with the ends of its interval over models of the road",
    "stiffness": "[N/m]",
    "damping": "[N s/m]",
    "correlation": "of damping and the stiffness of the spring beside it [1]",
    "wear": "good, watch, worn or cannot tell, against nominal values",
    "lost": "share of nominal damping that is lost [1], with its ends at the rate of the rule",
    "phase_rad": "least phase of the wheel (EGEA)",
    "adhesion": "least contact force of the wheel over the static one (EUSAMA) [1]",
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Rows:
    """What some records gave: rows of each table, and how many records they are."""

    modes: tuple[Row, ...] = ()
    drives: tuple[Row, ...] = ()
    springs: tuple[Row, ...] = ()
    failures: tuple[Row, ...] = ()
    records: int = 1
    # How many of these have a row among the failures.
    failed: int = 0


def joined(rows: Sequence[Rows]) -> Rows:
    """Return the rows of several records as one, in order."""
    return Rows(
        modes=tuple(row for some in rows for row in some.modes),
        drives=tuple(row for some in rows for row in some.drives),
        springs=tuple(row for some in rows for row in some.springs),
        failures=tuple(row for some in rows for row in some.failures),
        records=sum(some.records for some in rows),
        failed=sum(some.failed for some in rows),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Layout:
    """The tables of a run: the columns of each, and the one that is written last and makes a chunk complete."""

    columns: Mapping[TableName, Mapping[str, str]]
    main: TableName

    @property
    def names(self) -> tuple[TableName, ...]:
        """The tables in the order in which they are written."""
        return ("failures", "springs", self.main)

    def columns_of(self, table: TableName) -> Mapping[str, str]:
        """Return the columns of a table, or refuse one that the run does not have."""
        if table not in self.columns:
            raise InputError(f"these results have no table of {table}: their records have rows of {self.main}")
        return self.columns[table]

    def schema(self, table: TableName) -> pa.Schema:
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
            [pa.field(name, types[kind], metadata=_meaning(name)) for name, kind in self.columns_of(table).items()]
        )


DECAYS = Layout(columns=TABLE_COLUMNS, main="modes")


def drives_layout(car: Suspension | None) -> Layout:
    """Return the tables of drives of a car, whose row of a drive has columns of every strut.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> [name for name in drives_layout(car).columns["drives"] if name.endswith(".damping")]
    ['chassis.damping']
    """
    columns = dict(DRIVE_COLUMNS)
    for strut in car.struts if car else ():
        for quantity in QUANTITIES:
            if getattr(strut, quantity) > 0:
                columns |= dict.fromkeys((f"{strut.name}.{quantity}", f"{strut.name}.{quantity}_std"), "double")
    for name in dampers_named(car):
        columns |= {f"{name}.{column}": kind for column, kind in DAMPER_COLUMNS.items()}
    shared: tuple[TableName, ...] = ("springs", "failures")
    return Layout(columns={"drives": columns, **{name: TABLE_COLUMNS[name] for name in shared}}, main="drives")


def dampers_named(car: Suspension | None) -> list[str]:
    """Return the dampers of a car whose wear is judged."""
    return [strut.name for strut in dampers_between(car) if strut.damping > 0] if car else []


def layout_of(manifest: Mapping[str, object]) -> Layout:
    """Return the tables of the run that a manifest describes."""
    car = manifest.get("car")
    return drives_layout(car_from_toml(car) if isinstance(car, str) else None) if "drives" in manifest else DECAYS


def doubts_of(verdict: Verdict) -> Row:
    """Return the columns of doubts: the code of each, and the first sentence that is said with it."""
    words: dict[str, str] = {}
    for doubt in verdict.doubts:
        words.setdefault(str(doubt.code), printable(str(doubt)))
    return {"doubts": list(words), "doubts_in_words": list(words.values())}


def _meaning(column: str) -> dict[str, str] | None:
    """Return what a column holds, by its name or by what stands behind the name of a strut."""
    name = column.rpartition(".")[2]
    return {"description": MEANINGS[name]} if name in MEANINGS else None
