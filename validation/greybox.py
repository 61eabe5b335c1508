"""Springs and dampers straight from records, beside the bound and beside other methods.

Records come from the independent motion of `validation.motion`; the library starts 30 % off.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from suspid import Suspension, SuspidError, estimate
from suspid.units import RealArray
from suspid.values import text_table
from validation.greybox_bounds import value_of
from validation.greybox_peers import equation_error, era_and_reconstruct, welch_h1
from validation.greybox_rows import Row, rows

SEEDS = int(os.environ.get("SUSPID_SEEDS", "100"))
# Draws of a case that takes long: records of many minutes, cars of many masses.
FEWER = 0.3
LONG = ("1200 s", "300 s", "full car")
LEVEL = 0.95


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Tally:
    """What became of the draws of a case; parameters are those of the case."""

    draws: int
    failed: int
    error: RealArray  # (draw, parameter): relative
    bound: RealArray  # (parameter,): relative
    coverage: RealArray  # (parameter,)
    explained: float
    seconds: float  # processor time of one estimate, median

    @property
    def rmse(self) -> RealArray:
        """Relative root mean square error, (parameter,)."""
        return np.asarray(np.sqrt(np.mean(self.error**2, axis=0)))


def tally(row: Row, *, seeds: int = SEEDS) -> Tally:
    """Return errors and coverage of a case over many draws."""
    truth = np.array([value_of(row.car, name) for name in row.names])
    errors, holds, spent, explained, failed = [], [], [], 0, 0
    for seed in range(seeds):
        record = row.record(np.random.default_rng(seed))
        start = time.process_time()
        try:
            found = estimate(record, row.nominal, given=row.given, fixed=row.fixed, **row.options)
        except SuspidError:
            failed += 1
            continue
        spent.append(time.process_time() - start)
        ends, values = found.interval(LEVEL), dict(zip(found.parameters, found.values, strict=True))
        errors.append([values[name] / true - 1 for name, true in zip(row.names, truth, strict=True)])
        holds.append([ends[name][0] <= true <= ends[name][1] for name, true in zip(row.names, truth, strict=True)])
        explained += found.explains
    nothing = np.full((1, len(truth)), np.nan)
    return Tally(
        draws=seeds,
        failed=failed,
        error=np.array(errors) if errors else nothing,
        bound=np.full(len(truth), np.nan) if row.bound is None else row.bound() / truth,
        coverage=np.mean(holds, axis=0) if holds else nothing[0],
        explained=explained / max(len(errors), 1),
        seconds=float(np.median(spent)) if spent else np.nan,
    )


def table(cases: list[Row], *, seeds: int = SEEDS) -> str:
    """Return the table of some cases."""
    names = ("record", "draws", "failed", "bias [%]", "RMSE [%]", "RMSE / bound", "95 % that hold", "explained")
    columns: dict[str, list[str]] = {name: [] for name in (*names, "time [ms]")}
    for row in cases:
        found = tally(row, seeds=max(2, round(FEWER * seeds)) if any(word in row.name for word in LONG) else seeds)
        ratio = found.rmse / found.bound
        cells = (
            row.name,
            str(found.draws),
            str(found.failed),
            _span(100 * np.mean(found.error, axis=0), "{:+.2f}"),
            _span(100 * found.rmse, "{:.3g}"),
            _span(ratio, "{:.2f}"),
            f"{np.mean(found.coverage):.1%}",
            f"{found.explained:.0%}",
            f"{1e3 * found.seconds:.0f}",
        )
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(cell)
    return text_table(columns)


def _span(values: RealArray, form: str) -> str:
    """Return two values, or the least and the largest of several."""
    shown = values if len(values) <= 2 else [np.min(values), np.max(values)]
    return (", " if len(values) <= 2 else " to ").join(form.format(value) for value in shown)


def peers_table(*, seeds: int = SEEDS) -> str:
    """Return the table of all methods on the same drives and decays."""
    sections = rows()
    drive = next(r for r in sections["Everyday driving, wheels given"] if r.name == "class B, 60 s")
    decays = [
        r for r in sections["Free decays"] if r.name.startswith(("quarter car, 20", "half car, modes 10% apart, 40"))
    ]
    columns: dict[str, list[str]] = {name: [] for name in ("record", "method", "failed", "RMSE [%]", "RMSE / bound")}

    def add(row: Row, method: str, one: Callable[[object], RealArray]) -> None:
        truth, errors = np.array([value_of(row.car, name) for name in row.names]), []
        for seed in range(seeds):
            try:
                errors.append(one(row.record(np.random.default_rng(seed))) / truth - 1)
            except (SuspidError, np.linalg.LinAlgError, ValueError):
                continue
        rmse = np.sqrt(np.mean(np.square(errors), axis=0)) if errors else np.full(len(truth), np.nan)
        bound = np.full(len(truth), np.nan) if row.bound is None else row.bound() / truth
        cells = (
            row.name,
            method,
            f"{seeds - len(errors)}/{seeds}",
            _span(100 * rmse, "{:.3g}"),
            _span(rmse / bound, "{:.2f}"),
        )
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(cell)

    def ours(row: Row) -> Callable[[object], RealArray]:
        def one(record: object) -> RealArray:
            found = estimate(record, row.nominal, given=row.given, fixed=row.fixed, **row.options)
            return parameters_of(found.suspension, row)

        return one

    add(drive, "suspid, estimate", ours(drive))
    add(drive, "Welch H1, k and c fitted", lambda record: welch_h1(record, drive.nominal))
    add(drive, "equation error, least squares", lambda record: equation_error(record, drive.nominal))
    for row in decays:
        add(row, "suspid, estimate", ours(row))
        add(
            row,
            "python-control ERA (order given) + reconstruct",
            lambda record, row=row: parameters_of(era_and_reconstruct(record, row.nominal, row.fixed), row),  # type: ignore[misc]
        )
    return text_table(columns)


def parameters_of(car: Suspension, row: Row) -> RealArray:
    """Return the parameters of the case."""
    return np.array([value_of(car, name) for name in row.names])


def report() -> str:
    """Return the tables of all cases."""
    parts = [
        "# Springs and dampers straight from records",
        "Records come from an independent integrator (`validation/motion.py`), which shares no equation with the "
        "library. The nominal car is 30 % off in every spring and damper that is judged, up and down in turn. Bias, "
        "RMSE and RMSE over the Cramér-Rao bound are given for k and c where one strut is judged, else as the range "
        "over all parameters. The bound knows the start as little as the estimator does; where wheels are given, "
        "starts are left out, and gain and delay of the wheels' sensors and a mount are unknown to both (but for one "
        "row): without a mount, delay and mount are nearly one thing, and the bound does not know that a mount is not "
        "negative. Coverage is the mean over all parameters. 'explained' is the share of the draws in which "
        "the residual is accepted as noise. Time is processor time on this machine.",
    ]
    for name, cases in rows().items():
        parts.append(f"## {name}\n\n```\n{table(cases)}\n```")
    parts.append(f"## Beside other methods\n\nOn the same records.\n\n```\n{peers_table()}\n```")
    return "\n\n".join(parts) + "\n"
