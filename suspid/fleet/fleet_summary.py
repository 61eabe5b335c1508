"""Summary of a fleet: distributions of modes and parameters, outliers, trends."""

from __future__ import annotations

import itertools
import os
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.fleet.damper_trends import DamperTrends, trends_of_table
from suspid.fleet.distributions import Distribution, Outlier, distribution, outliers_of
from suspid.fleet.drive_summary import body_quantities, drive_dampers, placed_drives, untrusted_drives, wear_counts
from suspid.fleet.families import OTHERS, families_by_density, families_of_car
from suspid.fleet.manifest import read_manifest
from suspid.fleet.parts import check_parts, part_numbers, read_table
from suspid.fleet.summary import FailureCount, FleetSummary
from suspid.fleet.tables import layout_of
from suspid.fleet.trends import Trend, adjusted, trends_of
from suspid.fleet.vehicles import read_vehicles, vehicles_from_names
from suspid.model import Suspension, car_from_toml, eigenmodes
from suspid.performance import WearRule
from suspid.units import RealArray
from suspid.words import Failure, Step

if TYPE_CHECKING:
    import pyarrow as pa
    from numpy.typing import NDArray


# Letters of an example of a failure: its next step comes last.
LONGEST_EXAMPLE = 300


@explained
def fleet_summary(
    folder: str | os.PathLike[str],
    *,
    table: str | os.PathLike[str] | None = None,
    pattern: str | None = None,
    rule: WearRule | None = None,
) -> FleetSummary:
    r"""Return a summary of the results of `identify_many` or `estimate_many`, complete or not.

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
        such as ``r"(?P<vehicle>\w+)/(?P<date>\d{4}-\d{2}-\d{2})"``. Without both, drives have those of their rows.
    rule : WearRule, optional
        What is asked of the verdicts on dampers over their records.

    Raises
    ------
    InputError
        If there are no results or damaged ones, or the table or the pattern cannot be used.

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
    layout = layout_of(manifest)
    toml = manifest.get("car")
    car = car_from_toml(toml) if isinstance(toml, str) else None
    ended = manifest.get("complete")
    complete = check_parts(place, layout, ended["parts"] if isinstance(ended, dict) else None)
    drives, placed, others = layout.main == "drives", dict[str, tuple[str, float]](), 0
    if drives:
        names, placed = placed_drives(place)
        first, quantities = (
            read_table(place, "drives", columns=["verdict", "doubts", "doubts_in_words"]),
            body_quantities(place),
        )
    else:
        names, record, columns = _modes(place)
        label = _families(columns, record, car)
        others = int(np.sum(label == OTHERS))
        first, quantities = _first_rows(place), _mode_quantities(names, record, columns, label)
    vehicles = read_vehicles(table) if table is not None else placed
    if pattern is not None:
        vehicles = vehicles_from_names(names, pattern)
    distributions: list[Distribution] = []
    outliers: list[Outlier] = []
    trends: list[Trend] = []
    for quantity, unit, who, values, stds in itertools.chain(quantities, _spring_quantities(place)):
        distributions.append(distribution(quantity, unit, values, stds))
        outliers += outliers_of(quantity, who, values, stds)
        trends += _trends(quantity, who, values, stds, vehicles)
    dampers = None
    if car is not None and vehicles:
        dampers = drive_dampers(place, vehicles, car, rule) if drives else _dampers(place, vehicles, car, rule)
    asked = drives or table is not None or pattern is not None
    return FleetSummary(
        folder=place,
        records=sum(done for done, _ in complete),
        failed=sum(bad for _, bad in complete),
        failures=_failures(place),
        verdicts=_counts(first, "verdict"),
        doubts=_counts(first, "doubts"),
        distributions=tuple(distributions),
        outliers=tuple(sorted(outliers, key=lambda one: (-abs(one.z), one.record, one.quantity))),
        trends=adjusted(trends),
        dampers=dampers,
        others=others,
        unplaced=sum(1 for name in names if name not in vehicles) if asked else None,
        complete=ended is not None,
        wear=wear_counts(place, car) if drives and car is not None else {},
        untrusted=untrusted_drives(place) if drives else 0,
        car=car,
        said=_said(first),
    )


def _said(first: pa.Table) -> dict[str, str]:
    """Return for each doubt what is said of it in the first record that has it."""
    found: dict[str, str] = {}
    for doubts, words in zip(first["doubts"].to_pylist(), first["doubts_in_words"].to_pylist(), strict=True):
        found = dict(zip(doubts or (), words or (), strict=False)) | found
    return found


def _families(columns: Mapping[str, RealArray], record: NDArray[np.int64], car: Suspension | None) -> NDArray[np.int64]:
    """Return the family of each row of the modes: modes of the car, or else peaks of the density."""
    f, zeta = columns["f_hz"], columns["zeta"]
    if car is not None:
        return families_of_car(f, zeta, record, eigenmodes(car))
    return families_by_density(f, zeta, record)


def _failures(folder: Path) -> tuple[FailureCount, ...]:
    """Return the failures, counted by step and code."""
    names = ["record", "step", "code", "reason"]
    table = read_table(folder, "failures", columns=names).to_pydict()
    counts: Counter[tuple[str, str]] = Counter()
    examples: dict[tuple[str, str], str] = {}
    for record, step, code, reason in zip(*(table[name] for name in names), strict=True):
        counts[step, code] += 1
        examples.setdefault((step, code), textwrap.shorten(f"{record}: {reason}", LONGEST_EXAMPLE, placeholder=" …"))
    return tuple(
        FailureCount(step=Step(step), code=Failure(code), count=count, example=examples[step, code])
        for (step, code), count in sorted(counts.items(), key=lambda one: (-one[1], one[0]))
    )


def _first_rows(folder: Path) -> pa.Table:
    """Return verdict and doubts of each record: they are the same in the rows of all its modes."""
    table = read_table(folder, "modes", columns=["mode", "verdict", "doubts", "doubts_in_words"])
    return table.take(np.flatnonzero(table["mode"].to_numpy() == 1))


def _counts(table: pa.Table, column: str) -> dict[str, int]:
    """Return how many records have each value of a column, or each value in its lists, the most frequent first."""
    values = table[column].combine_chunks()
    found = values.flatten() if column == "doubts" else values
    counts = {one["values"]: one["counts"] for one in found.value_counts().to_pylist() if one["values"] is not None}
    return dict(sorted(counts.items(), key=lambda one: (-one[1], one[0])))


def _modes(folder: Path) -> tuple[list[str], NDArray[np.int64], dict[str, RealArray]]:
    """Return the names of the records, the record of each row, and the columns of the modes."""
    wanted = ["f_hz", "wn_std_rad_per_s", "zeta", "zeta_std"]
    table = read_table(folder, "modes", columns=["record", *wanted])
    encoded = table["record"].combine_chunks().dictionary_encode()
    columns = {name: np.asarray(table[name].to_numpy(), float) for name in wanted}
    return encoded.dictionary.to_pylist(), np.asarray(encoded.indices, dtype=np.int64), columns


def _mode_quantities(
    names: Sequence[str],
    record: NDArray[np.int64],
    modes: Mapping[str, RealArray],
    label: NDArray[np.int64],
) -> Iterator[tuple[str, str, list[str], RealArray, RealArray]]:
    """Yield name, unit, records, values and standard deviations of frequency and damping of each family."""
    for family in range(int(np.max(label, initial=OTHERS)) + 1):
        rows = np.flatnonzero(label == family)
        who = [names[k] for k in record[rows]]
        for quantity, unit, value, std, scale in (
            ("f", "Hz", "f_hz", "wn_std_rad_per_s", 1 / (2 * np.pi)),
            ("zeta", "1", "zeta", "zeta_std", 1.0),
        ):
            if rows.size:
                yield f"mode {family + 1} {quantity}", unit, who, modes[value][rows], modes[std][rows] * scale


def _spring_quantities(folder: Path) -> Iterator[tuple[str, str, list[str], RealArray, RealArray]]:
    """Yield the same of each parameter that was found."""
    if not part_numbers(folder, "springs"):
        return
    springs = read_table(folder, "springs", columns=["record", "parameter", "unit", "value", "std", "held"])
    parameter = springs["parameter"].to_numpy()
    free = ~springs["held"].to_numpy()
    for name in dict.fromkeys(parameter[free]):
        some = springs.take(np.flatnonzero(free & (parameter == name)))
        values, stds = (np.asarray(some[column].to_numpy(), float) for column in ("value", "std"))
        yield name, some["unit"][0].as_py(), some["record"].to_pylist(), values, stds


def _dampers(
    folder: Path, vehicles: Mapping[str, tuple[str, float]], car: Suspension, rule: WearRule | None
) -> DamperTrends | None:
    """Return the trends of dampers; None where springs and dampers were not looked for."""
    if not part_numbers(folder, "springs"):
        return None
    springs = read_table(folder, "springs", columns=["record", "parameter", "value", "std", "held"])
    free = springs.take(np.flatnonzero(~springs["held"].to_numpy())).to_pydict()
    rows = zip(*(free[name] for name in ("record", "parameter", "value", "std")), strict=True)
    known = ((who, what, value, np.nan if std is None else std) for who, what, value, std in rows if value is not None)
    return trends_of_table(known, vehicles, car, rule)


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
