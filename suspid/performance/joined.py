"""Figures that are asked of a tuning: those of a ride, several of one unit joined to one, or those of a bench."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.performance.figure_plan import Plan
from suspid.performance.larger_better import BENCH_FIGURES, bench_rows, bench_values, kind_of
from suspid.performance.road_response import Grid
from suspid.units import RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Joined:
    """A plan for single figures, and which of them make each figure that is asked for."""

    names: tuple[str, ...]  # of those asked for
    plan: Plan
    parts: NDArray[np.bool_]  # (asked of a ride, single)
    bench: tuple[int, ...]  # of those asked of a bench, the places in `least_figures`
    units: tuple[str, ...]  # of those asked for

    @property
    def signs(self) -> RealArray:
        """1 of figures that are to be small, -1 of those that are to be large, (asked,)."""
        return np.array([-1.0 if kind_of(name) else 1.0 for name in self.names])

    def values(
        self, car: Suspension, parameters: Sequence[str], grid_for: Callable[[Suspension], Grid]
    ) -> tuple[RealArray, RealArray]:
        """Return what is asked for and its derivatives, (asked,) and (asked, parameter)."""
        values, slopes = np.zeros(len(self.names)), np.zeros((len(self.names), len(parameters)))
        of_bench = self.signs < 0
        if not np.all(of_bench):
            values[~of_bench], slopes[~of_bench] = self._ridden(car, parameters, grid_for(car))
        if np.any(of_bench):
            values[of_bench], slopes[of_bench] = bench_values(car, parameters, self.bench)
        return values, slopes

    def _ridden(self, car: Suspension, parameters: Sequence[str], grid: Grid) -> tuple[RealArray, RealArray]:
        """Return roots of sums of squares of the figures of a ride, and their derivatives."""
        values, slopes = self.plan.values(car, parameters=parameters, grid=grid)
        # Probabilities of rare events have squares of zero: by the largest part.
        largest = np.maximum(np.max(self.parts * values, axis=1), np.finfo(float).tiny)
        shares = self.parts * values / largest[:, None]
        size = np.sqrt(np.sum(shares**2, axis=1))
        return largest * size, shares / np.maximum(size, np.finfo(float).tiny)[:, None] @ slopes


def joined(plan: Plan, names: Sequence[str]) -> Joined:
    """Return figures, joined by + in their names, as part of a plan.

    Raises
    ------
    InputError
        If the car has no such figure, or those that are joined have different units.
    """
    bench = bench_rows(plan.car, [name for name in names if kind_of(name)])
    split = [[part.strip() for part in name.split("+")] for name in names if not kind_of(name)]
    single = list(dict.fromkeys(part for parts in split for part in parts))
    own = plan.only(single)
    units = {name: BENCH_FIGURES[kind_of(name)][0] for name in names if kind_of(name)}
    for name, parts in zip([name for name in names if not kind_of(name)], split, strict=True):
        kinds = list(dict.fromkeys(own.formulas[part][0] for part in parts))
        if len(kinds) > 1:
            raise InputError(f"figure {name!r} joins {' and '.join(kinds)}; join figures of one unit")
        units[name] = kinds[0]
    return Joined(
        names=tuple(names),
        plan=own,
        parts=np.array([[one in parts for one in single] for parts in split], bool),
        bench=tuple(bench),
        units=tuple(units[name] for name in names),
    )
