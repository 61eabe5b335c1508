"""How a quantity is spread over a fleet, and which records stand out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.units import RealArray

# With fewer values the scatter is not known well enough for a record to stand out: 8 know it to a fourth.
FEWEST_RECORDS = 8
# Of each distribution: the ends of 95 % and of the middle half.
QUANTILES = (0.025, 0.25, 0.75, 0.975)


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


def distribution(quantity: str, unit: str, values: RealArray, stds: RealArray) -> Distribution:
    """Return how values are spread, beside their own standard deviations."""
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


def outliers_of(quantity: str, who: Sequence[str], values: RealArray, stds: RealArray) -> list[Outlier]:
    """Return the values further off than chance explains."""
    from scipy import stats

    if len(values) < FEWEST_RECORDS:
        return []
    own = np.nan_to_num(stds, nan=0.0) ** 2
    median = float(np.median(values))
    # What the vehicles differ by is what is left of the scatter without what the records state.
    shared = max(float(stats.median_abs_deviation(values, scale="normal")) ** 2 - float(np.median(own)), 0.0)
    std = np.sqrt(shared + own)
    z = np.where(std > 0, (values - median) / np.where(std > 0, std, 1.0), 0.0)
    # A fleet without outliers has 0.05 of a quantity on average. More: more false alarms.
    limit = float(stats.norm.isf(0.05 / 2 / len(values)))
    return [
        Outlier(record=who[int(k)], quantity=quantity, value=float(values[k]), median=median, z=float(z[k]))
        for k in np.flatnonzero(np.abs(z) > limit)
    ]
