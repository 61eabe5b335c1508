"""Distribution of a quantity over a fleet, and its outliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.units import RealArray

# With fewer values the scatter is not known well enough for a record to stand out: 8 know it to a fourth.
FEWEST_RECORDS = 8
# Of each distribution: the ends of 95 % and of the middle half.
QUANTILES = (0.025, 0.25, 0.75, 0.975)
# Bars of a histogram at most: a picture of 4 inches shows no more. Its edges are these quantiles, so that one value
# far off does not make all others one bar.
MOST_BARS, EDGES = 40, (0.005, 0.995)


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
    edges : tuple of float
        Edges of the bars of its histogram.
    bars : tuple of int
        How many records are in each; the first and the last have those beyond the edges too.
    """

    quantity: str
    unit: str
    count: int
    median: float
    quantiles: tuple[float, ...]
    scatter: float
    stated: float
    edges: tuple[float, ...] = ()
    bars: tuple[int, ...] = ()

    @property
    def known_quantiles(self) -> tuple[float | None, ...]:
        """Those of `QUANTILES` beyond which at least one record lies, None in place of the others."""
        beyond = [self.count * min(q, 1 - q) >= 1 for q in QUANTILES]
        return tuple(value if known else None for value, known in zip(self.quantiles, beyond, strict=True))

    @property
    def known_scatter(self) -> float | None:
        """The scatter, or None of fewer than four values: the median absolute deviation is then that of one of them."""
        return self.scatter if self.count >= 4 else None


def known_columns(some: Sequence[Distribution]) -> dict[str, list[float | None]]:
    """Return by heading the quantiles that are known of some distribution, None where one is not.

    Examples
    --------
    >>> few = distribution("f", "Hz", np.arange(16.0), np.ones(16))
    >>> known_columns([few])
    {'25 %': [3.75], '75 %': [11.25]}
    """
    columns = {f"{100 * q:g} %": [one.known_quantiles[k] for one in some] for k, q in enumerate(QUANTILES)}
    return {heading: column for heading, column in columns.items() if any(value is not None for value in column)}


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
    scatter = float(stats.median_abs_deviation(values, scale="normal"))
    edges, bars = _histogram(values)
    return Distribution(
        quantity=quantity,
        unit=unit,
        count=len(values),
        median=float(np.median(values)),
        quantiles=tuple(np.quantile(values, QUANTILES).tolist()),
        scatter=scatter,
        stated=float(np.sqrt(np.mean(stated**2))) if stated.size else float("nan"),
        edges=edges,
        bars=bars,
    )


def _histogram(values: RealArray) -> tuple[tuple[float, ...], tuple[int, ...]]:
    """Return edges and bars of a histogram: no more than fit, as wide as Freedman and Diaconis advise.

    Where that would be fewer than Sturges advises, the records are few or in two groups, and his number is taken.
    """
    low = float(np.quantile(values, EDGES[0], method="lower"))
    high = float(np.quantile(values, EDGES[1], method="higher"))
    # Values that are alike but for rounding have no width to divide.
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        return (low, high), (len(values),)
    lower, upper = np.quantile(values, (0.25, 0.75))
    advised = 2 * float(upper - lower) / len(values) ** (1 / 3)
    width = max(min(advised, (high - low) / (np.log2(len(values)) + 1)), (high - low) / min(MOST_BARS, len(values)))
    bars, edges = np.histogram(np.clip(values, low, high), bins=int(np.ceil((high - low) / width)), range=(low, high))
    return tuple(edges.tolist()), tuple(bars.tolist())


def outliers_of(quantity: str, who: Sequence[str], values: RealArray, stds: RealArray) -> list[Outlier]:
    """Return the values further off than chance explains."""
    from scipy import stats

    if len(values) < FEWEST_RECORDS:
        return []
    own = np.nan_to_num(stds, nan=0.0) ** 2
    median = float(np.median(values))
    # The vehicles differ by the scatter less what the records state of their own uncertainty.
    shared = max(float(stats.median_abs_deviation(values, scale="normal")) ** 2 - float(np.median(own)), 0.0)
    std = np.sqrt(shared + own)
    z = np.where(std > 0, (values - median) / np.where(std > 0, std, 1.0), 0.0)
    # A fleet without outliers has 0.05 of a quantity on average. More: more false alarms.
    limit = float(stats.norm.isf(0.05 / 2 / len(values)))
    return [
        Outlier(record=who[int(k)], quantity=quantity, value=float(values[k]), median=median, z=float(z[k]))
        for k in np.flatnonzero(np.abs(z) > limit)
    ]
