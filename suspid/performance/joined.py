"""Figures that are asked of a tuning: those of a ride, or several of one unit joined to one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.performance.figure_plan import Plan
from suspid.performance.road_response import Grid
from suspid.units import RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Joined:
    """A plan for single figures, and which of them make each figure that is asked for."""

    plan: Plan
    parts: NDArray[np.bool_]  # (asked, single)
    units: tuple[str, ...]  # of those asked for

    def values(self, car: Suspension, parameters: Sequence[str], grid: Grid) -> tuple[RealArray, RealArray]:
        """Return what is asked for and its derivatives: roots of sums of squares, (asked,) and (asked, parameter)."""
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
    split = [[part.strip() for part in name.split("+")] for name in names]
    single = list(dict.fromkeys(part for parts in split for part in parts))
    own = plan.only(single)
    units = []
    for name, parts in zip(names, split, strict=True):
        kinds = list(dict.fromkeys(own.formulas[part][0] for part in parts))
        if len(kinds) > 1:
            raise InputError(f"figure {name!r} joins {' and '.join(kinds)}; join figures of one unit")
        units.append(kinds[0])
    rows = np.array([[one in parts for one in single] for parts in split], bool)
    return Joined(plan=own, parts=rows, units=tuple(units))
