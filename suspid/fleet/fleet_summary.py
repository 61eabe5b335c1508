"""What a fleet's results say: how each mode and parameter is distributed, which records stand out, what changes."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.fleet.families import OTHERS, families_by_density, families_of_car
from suspid.fleet.manifest import read_manifest
from suspid.fleet.parts import part_counts, part_numbers, read_table
from suspid.fleet.trends import Trend, adjusted, trends_of
from suspid.fleet.vehicles import read_vehicles, vehicles_from_names
from suspid.model import car_from_toml, eigenmodes
from suspid.units import RealArray
from suspid.values import text_table

if TYPE_CHECKING:
    from numpy.typing import NDArray

# With fewer values nothing can stand out.
FEWEST = 8
QUANTILES = (0.025, 0.25, 0.75, 0.975)
# So many values of a healthy fleet, of one quantity, are called outliers by chance.
FALSE_OUTLIERS = 0.05
MOST_SHOWN = 20
# What the summary reads of the failures, and how much of a reason it shows [characters].
FAILURE, WIDTH = ["record", "step", "error", "reason"], 100


@dataclass(frozen=True, kw_only=True, slots=True)
class Distribution:
    """How a quantity is spread over the fleet.

    Parameters
    ----------
    quantity, unit : str
        What it is.
    count : int
        In how many records.
    median : float
        Its median.
    quantiles : tuple of float
        Those of `QUANTILES`.
    scatter : float
        Robust standard deviation from record to record: 1.4826 times the median absolute deviation.
    stated : float
        Root mean square of the standard deviations that the records state; NaN if they state none. Where the scatter
        is much larger, the vehicles differ, or their tests do, by more than noise.
    """

    quantity: str
    unit: str
    count: int
    median: float
    quantiles: tuple[float, ...]
    scatter: float
    stated: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Outlier:
    """A value far from the fleet's median, its own uncertainty allowed for.

    Parameters
    ----------
    record, quantity : str
        Which.
    value, median : float
        What it is, and what it is for the fleet.
    z : float
        Distance from the median over the standard deviation of scatter and own uncertainty together.
    """

    record: str
    quantity: str
    value: float
    median: float
    z: float


@dataclass(frozen=True, kw_only=True, slots=True)
class FleetSummary:
    """What a fleet's results say.

    Parameters
    ----------
    folder : path
        Where they are.
    records, failed : int
        How many records there are, and how many of them have a row among the failures.
    failures : mapping of str to int
        How many failed by step and kind of error.
    such_as : mapping of str to str
        The first record of each kind of failure, and its reason.
    distributions : tuple of Distribution
        Of frequency and damping of each family of modes, and of each parameter.
    outliers : tuple of Outlier
        The furthest first.
    trends : tuple of Trend
        Of each quantity of each vehicle, the surest change first; none without vehicles.
    others : int
        How many modes belong to no family.
    unplaced : int or None
        How many records have no vehicle; None if none was asked for.
    complete : bool
        Whether the run has ended.
    """

    folder: Path
    records: int
    failed: int
    failures: Mapping[str, int]
    such_as: Mapping[str, str]
    distributions: tuple[Distribution, ...]
    outliers: tuple[Outlier, ...]
    trends: tuple[Trend, ...]
    others: int
    unplaced: int | None
    complete: bool

    def __str__(self) -> str:
        parts = [
            f"{printable(str(self.folder))}: {self.records} records, {self.failed} of them with a failure"
            + ("" if self.complete else "; the run has not ended")
        ]
        if self.failures:
            rows = sorted(self.failures.items(), key=lambda row: (-row[1], row[0]))
            columns = {
                "failed at": [kind for kind, _ in rows],
                "records": [str(count) for _, count in rows],
                "such as": [self.such_as[kind] for kind, _ in rows],
            }
            parts.append(text_table(columns) + "\nEvery one, with its reason, stands in the table of failures.")
        if self.distributions:
            parts.append(_distribution_table(self.distributions))
        if self.others:
            parts.append(f"{self.others} modes belong to no family: too few records have one there")
        if self.outliers:
            shown = self.outliers[:MOST_SHOWN]
            columns = {
                "outlier": [one.record for one in shown],
                "quantity": [one.quantity for one in shown],
                "value": [f"{one.value:.5g}" for one in shown],
                "median": [f"{one.median:.5g}" for one in shown],
                "off [sd]": [f"{one.z:+.1f}" for one in shown],
            }
            parts.append(text_table(columns) + _more(len(self.outliers)))
        else:
            parts.append("no record stands out")
        if self.unplaced is not None:
            parts.append(_trends_in_words(self.trends, self.unplaced))
        return "\n\n".join(parts)


def fleet_summary(
    folder: str | os.PathLike[str],
    *,
    table: str | os.PathLike[str] | None = None,
    pattern: str | None = None,
) -> FleetSummary:
    r"""Return what the results of `identify_many` say, complete or so far.

    Modes are put into families: the modes of the car that the run was given, or else the peaks of the density of log
    frequency over all records. The columns of one quantity are held in memory at a time.

    Parameters
    ----------
    folder : path
        The results.
    table : path, optional
        CSV with the columns ``record`` (as in the results), ``vehicle`` and ``date`` (a date, or a number such as a
        mileage): trends are then looked for.
    pattern : str, optional
        In its place a regular expression with the groups ``vehicle`` and ``date`` that the records' names match,
        such as ``r"(?P<vehicle>\w+)/(?P<date>\d{4}-\d{2}-\d{2})"``.

    Raises
    ------
    InputError
        If there are no results, or the table or the pattern cannot be used.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> from suspid.fleet import identify_many
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> decay = free_decay(car, np.arange(0, 4, 0.01), initial_state={"v_tire": 1.0})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = identify_many([(f"test {k}", decay) for k in range(3)], output=folder, workers=1)
    ...     summary = fleet_summary(folder)
    >>> [(d.quantity, d.count, round(d.median, 3)) for d in summary.distributions]
    [('mode 1 f', 3, 1.085), ('mode 1 zeta', 3, 0.231), ('mode 2 f', 3, 11.677), ('mode 2 zeta', 3, 0.26)]
    """
    place = Path(folder)
    manifest = read_manifest(place)
    counts = [c for c in (part_counts(place, number) for number in part_numbers(place, "modes")) if c is not None]
    failures: dict[str, int] = {}
    failed = read_table(place, "failures", columns=FAILURE).to_pydict()
    such_as: dict[str, str] = {}
    for record, step, error, reason in zip(*(failed[name] for name in FAILURE), strict=True):
        kind = f"{step}: {error}"
        failures[kind] = failures.get(kind, 0) + 1
        such_as.setdefault(kind, textwrap.shorten(f"{record}: {reason}", WIDTH, placeholder=" …"))
    names, record, columns = _modes(place)
    vehicles = read_vehicles(table) if table is not None else {}
    if pattern is not None:
        vehicles = vehicles_from_names(names, pattern)
    car = manifest.get("car")
    f, zeta = columns["f_hz"], columns["zeta"]
    if isinstance(car, str):
        label = families_of_car(f, zeta, record, eigenmodes(car_from_toml(car)))
    else:
        label = families_by_density(f, zeta, record)
    distributions: list[Distribution] = []
    outliers: list[Outlier] = []
    trends: list[Trend] = []
    for quantity, unit, who, values, stds in _quantities(place, names, record, columns, label):
        distributions.append(_distribution(quantity, unit, values, stds))
        outliers += _outliers(quantity, who, values, stds)
        trends += _trends(quantity, who, values, stds, vehicles)
    asked = table is not None or pattern is not None
    return FleetSummary(
        folder=place,
        records=sum(done for done, _ in counts),
        failed=sum(bad for _, bad in counts),
        failures=failures,
        such_as=such_as,
        distributions=tuple(distributions),
        outliers=tuple(sorted(outliers, key=lambda one: (-abs(one.z), one.record, one.quantity))),
        trends=adjusted(trends),
        others=int(np.sum(label == OTHERS)),
        unplaced=sum(1 for name in names if name not in vehicles) if asked else None,
        complete="complete" in manifest,
    )


def _modes(folder: Path) -> tuple[list[str], NDArray[np.int64], dict[str, RealArray]]:
    """Return the names of the records, the record of each row, and the columns of the modes."""
    wanted = ["f_hz", "wn_std_rad_per_s", "zeta", "zeta_std"]
    table = read_table(folder, "modes", columns=["record", *wanted])
    encoded = table["record"].combine_chunks().dictionary_encode()
    columns = {name: np.asarray(table[name].to_numpy(), float) for name in wanted}
    return encoded.dictionary.to_pylist(), np.asarray(encoded.indices, dtype=np.int64), columns


def _quantities(
    folder: Path,
    names: Sequence[str],
    record: NDArray[np.int64],
    modes: Mapping[str, RealArray],
    label: NDArray[np.int64],
) -> Iterator[tuple[str, str, list[str], RealArray, RealArray]]:
    """Yield name, unit, records, values and standard deviations of each quantity."""
    for family in range(int(np.max(label, initial=OTHERS)) + 1):
        rows = np.flatnonzero(label == family)
        who = [names[k] for k in record[rows]]
        for quantity, unit, value, std, scale in (
            ("f", "Hz", "f_hz", "wn_std_rad_per_s", 1 / (2 * np.pi)),
            ("zeta", "1", "zeta", "zeta_std", 1.0),
        ):
            if rows.size:
                yield f"mode {family + 1} {quantity}", unit, who, modes[value][rows], modes[std][rows] * scale
    if not part_numbers(folder, "springs"):
        return
    springs = read_table(folder, "springs", columns=["record", "parameter", "unit", "value", "std", "held"])
    parameter = springs["parameter"].to_numpy()
    free = ~springs["held"].to_numpy()
    for name in dict.fromkeys(parameter[free]):
        some = springs.take(np.flatnonzero(free & (parameter == name)))
        values, stds = (np.asarray(some[column].to_numpy(), float) for column in ("value", "std"))
        yield name, some["unit"][0].as_py(), some["record"].to_pylist(), values, stds


def _distribution(quantity: str, unit: str, values: RealArray, stds: RealArray) -> Distribution:
    from scipy import stats

    stated = stds[np.isfinite(stds)]
    return Distribution(
        quantity=quantity,
        unit=unit,
        count=len(values),
        median=float(np.median(values)),
        quantiles=tuple(np.quantile(values, QUANTILES).tolist()),
        scatter=float(stats.median_abs_deviation(values, scale="normal")),
        stated=float(np.sqrt(np.mean(stated**2))) if stated.size else float("nan"),
    )


def _outliers(quantity: str, who: Sequence[str], values: RealArray, stds: RealArray) -> list[Outlier]:
    """Return the values further off than one of so many would be by chance."""
    from scipy import stats

    if len(values) < FEWEST:
        return []
    own = np.nan_to_num(stds, nan=0.0) ** 2
    median = float(np.median(values))
    # What the vehicles differ by is what is left of the scatter without what the records state.
    shared = max(float(stats.median_abs_deviation(values, scale="normal")) ** 2 - float(np.median(own)), 0.0)
    std = np.sqrt(shared + own)
    z = np.where(std > 0, (values - median) / np.where(std > 0, std, 1.0), 0.0)
    limit = float(stats.norm.isf(FALSE_OUTLIERS / 2 / len(values)))
    return [
        Outlier(record=who[int(k)], quantity=quantity, value=float(values[k]), median=median, z=float(z[k]))
        for k in np.flatnonzero(np.abs(z) > limit)
    ]


def _trends(
    quantity: str,
    who: Sequence[str],
    values: RealArray,
    stds: RealArray,
    vehicles: Mapping[str, tuple[str, float]],
) -> tuple[Trend, ...]:
    tests: dict[str, list[int]] = {}
    for k, record in enumerate(who):
        if record in vehicles:
            tests.setdefault(vehicles[record][0], []).append(k)
    return trends_of(
        quantity,
        {
            vehicle: (np.array([vehicles[who[k]][1] for k in rows]), values[rows], stds[rows])
            for vehicle, rows in tests.items()
        },
    )


def _distribution_table(distributions: Sequence[Distribution]) -> str:
    return text_table(
        {
            "quantity": [f"{one.quantity} [{one.unit}]" for one in distributions],
            "records": [str(one.count) for one in distributions],
            "median": [f"{one.median:.5g}" for one in distributions],
            **{f"{100 * q:g} %": [f"{one.quantiles[k]:.5g}" for one in distributions] for k, q in enumerate(QUANTILES)},
            "scatter": [f"{one.scatter:.2g}" for one in distributions],
            "stated ±": [f"{one.stated:.2g}" for one in distributions],
        }
    )


def _trends_in_words(trends: Sequence[Trend], unplaced: int) -> str:
    changing = [one for one in trends if one.changes]
    vehicles = len({one.vehicle for one in trends})
    said = (
        f"{len(trends)} trends of {vehicles} vehicles (at least four tests each); of {len(changing)} the end no longer "
        f"holds the start (5 % of these by chance at most)"
    )
    if unplaced:
        said += f"; {unplaced} records have no vehicle and date"
    if not changing:
        return said
    shown = changing[:MOST_SHOWN]
    columns = {
        "vehicle": [one.vehicle for one in shown],
        "quantity": [f"{one.quantity} {one.direction}" for one in shown],
        "tests": [str(one.count) for one in shown],
        "over": [f"{one.span:.4g}" for one in shown],
        "start": [f"{one.start:.5g}" for one in shown],
        "end": [f"{one.end:.5g}" for one in shown],
        "95 % of the change": [f"{one.change[0]:+.3g} … {one.change[1]:+.3g}" for one in shown],
        "p": [f"{one.p_adjusted:.1g}" for one in shown],
    }
    return f"{said}\n\n{text_table(columns)}{_more(len(changing))}"


def _more(count: int) -> str:
    return f"\n… and {count - MOST_SHOWN} more" if count > MOST_SHOWN else ""
