"""Trends: change over time of a quantity that was measured several times, each time with its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from suspid.errors import InputError
from suspid.levels import LEVEL, likely
from suspid.units import Ratio, RealArray

Measured: TypeAlias = "tuple[RealArray, RealArray, RealArray]"


@dataclass(frozen=True, kw_only=True, slots=True)
class Trend:
    """The straight line through measurements over time, and whether its change is significant.

    Parameters
    ----------
    vehicle : str
        The vehicle.
    quantity : str
        What was measured.
    count : int
        How many times.
    span : float
        Time from first to last.
    start, end : float
        Values of the line at the first and the last time.
    change : (float, float)
        Ends of the 95 % interval of ``end - start``.
    p : float
        Probability of such a change, or a larger one, without a trend.
    p_adjusted : float
        The same, adjusted for the number of trends (Benjamini and Hochberg).
    scatter : float
        Standard deviation from test to test, beyond the stated ones.
    std : float
        Standard deviation of ``end - start``.
    freedom : int
        Degrees of freedom of Student's t that its interval has.
    """

    vehicle: str
    quantity: str
    count: int
    span: float
    start: float
    end: float
    change: tuple[float, float]
    p: Ratio
    p_adjusted: Ratio
    scatter: float
    std: float
    freedom: int

    @property
    def changes(self) -> bool:
        """Whether the change is significant: less than 5 % of the trends that are reported so are chance."""
        return self.p_adjusted < 1 - LEVEL

    @property
    def direction(self) -> str:
        """``"falls"``, ``"rises"``, or ``"holds"`` if the change is not significant."""
        return ("falls" if self.end < self.start else "rises") if self.changes else "holds"


def trends_of(quantity: str, tests: Mapping[str, Measured], *, pooled: bool = False) -> tuple[Trend, ...]:
    """Return the weighted line through each vehicle's measurements over time; vehicles with too few are left out.

    Each value is weighted by its own variance plus one that all tests share (temperature, load). The shared variance
    is estimated from the residuals of all vehicles, without those that scatter far more; a vehicle with larger
    residuals has the shared variance of its own residuals. The interval is that of Student's t, with the degrees of
    freedom of that estimate.

    With ``pooled`` a vehicle has the shared variance unless its own is improbably large; else whenever its own is
    larger. ``tests`` holds times, values and their standard deviations (NaN where there is none) by vehicle.

    Examples
    --------
    >>> time, noise = np.arange(6.0), np.array([3.0, -5, 4, 1, -2, 3])
    >>> worn, sound = trends_of(
    ...     "damper",
    ...     {
    ...         "VAN 7": (time, 1500.0 - 100.0 * time + noise, np.full(6, 5.0)),
    ...         "VAN 8": (time, 1500.0 + noise, np.full(6, 5.0)),
    ...     },
    ... )
    >>> worn.direction, round(worn.end - worn.start), sound.direction
    ('falls', -499, 'holds')
    """
    usable: dict[str, Measured] = {}
    for vehicle, (time, values, stds) in tests.items():
        if not len(time) == len(values) == len(stds):
            raise InputError(f"{vehicle}: {len(time)} times, {len(values)} values and {len(stds)} standard deviations")
        known = np.isfinite(time) & np.isfinite(values)
        # A line through three tests leaves one degree of freedom, whose interval (Student's t: 12.7 sd) shows no
        # change.
        if np.sum(known) >= 4 and np.ptp(time[known]) > 0:
            own = np.nan_to_num(np.asarray(stds[known], float), nan=0.0) ** 2
            usable[vehicle] = np.asarray(time[known], float), np.asarray(values[known], float), own
    if not usable:
        return ()
    alike, everyone = _alike(list(usable.values()))
    freedom = sum(len(time) - 2 for time, _, _ in alike)
    same = {id(one) for one in alike} if pooled else set[int]()
    return tuple(
        _trend(vehicle, quantity, one, everyone, freedom, same=id(one) in same) for vehicle, one in usable.items()
    )


def adjusted(trends: Sequence[Trend]) -> tuple[Trend, ...]:
    """Return the trends with their probabilities adjusted for their number, the most significant change first.

    Examples
    --------
    >>> tests = {"A": (np.arange(5.0), np.array([1.0, 1.1, 0.9, 0.8, 0.85]), np.zeros(5))}
    >>> (line,) = trends_of("c", tests)
    >>> [round(t.p_adjusted / t.p) for t in adjusted([line, line])]
    [1, 1]
    """
    from scipy import stats

    if not trends:
        return ()
    every = stats.false_discovery_control([trend.p for trend in trends])
    found = [replace(trend, p_adjusted=float(p)) for trend, p in zip(trends, every, strict=True)]
    return tuple(sorted(found, key=lambda trend: (trend.p, trend.vehicle, trend.quantity)))


def _trend(vehicle: str, quantity: str, one: Measured, everyone: float, freedom: int, *, same: bool) -> Trend:
    from scipy import stats

    t, v, own = one
    alone = 0.0 if same else _shared_variance([one])
    shared = max(alone, everyone)
    if alone > everyone:
        freedom = len(t) - 2
    line, covariance, _ = _line(t, v, own + shared)
    start, end = (np.array([[1.0, np.min(t)], [1.0, np.max(t)]]) @ line).tolist()
    std = float(np.ptp(t) * np.sqrt(covariance[1, 1]))
    reach = float(stats.t.ppf((1 + LEVEL) / 2, freedom)) * std
    # Without any scatter every change is significant.
    p = float(2 * stats.t.sf(abs(end - start) / std, freedom)) if std > 0 else float(end == start)
    return Trend(
        vehicle=vehicle,
        quantity=quantity,
        count=len(t),
        span=float(np.ptp(t)),
        start=start,
        end=end,
        change=(end - start - reach, end - start + reach),
        p=p,
        p_adjusted=p,
        scatter=float(np.sqrt(shared)),
        std=std,
        freedom=freedom,
    )


def _alike(groups: Sequence[Measured]) -> tuple[list[Measured], float]:
    """Return the vehicles with a common scatter, and its variance; those that scatter far more are left out.

    A vehicle whose residuals are improbable has a scatter of its own: one bad logger would widen the intervals of all.
    """
    kept = list(groups)
    while True:
        everyone = _shared_variance(kept)
        quiet = [one for one in kept if likely(_line(*one[:2], one[2] + everyone)[2], len(one[0]) - 2)]
        if len(quiet) in (0, len(kept)):
            return kept, everyone
        kept = quiet


def _shared_variance(groups: Sequence[Measured]) -> float:
    """Return the variance that, added to each value's own, makes chi-square equal to its degrees of freedom."""
    from scipy.optimize import brentq

    freedom = sum(len(t) - 2 for t, _, _ in groups)
    unweighted = sum(_line(t, v, np.ones(len(t)))[2] for t, v, _ in groups)
    if unweighted <= 1e-24 * sum(float(v @ v) for _, v, _ in groups):
        return 0.0
    least = 1e-12 * unweighted / freedom

    def excess(shared: float) -> float:
        return sum(_line(t, v, own + shared)[2] for t, v, own in groups) - freedom

    if excess(least) <= 0:
        return least
    high = unweighted / freedom
    while excess(high) > 0:
        high *= 2
    return float(brentq(excess, least, high, rtol=1e-6))


def _line(t: RealArray, v: RealArray, variance: RealArray) -> tuple[RealArray, RealArray, float]:
    """Return the weighted line (value at 0, slope), its covariance, and the weighted sum of squared residuals."""
    largest = float(np.max(variance))
    weight = 1 / np.maximum(variance, 1e-12 * largest) if largest > 0 else np.ones(len(t))
    middle = float(weight @ t / np.sum(weight))
    basis = np.column_stack([np.ones(len(t)), t - middle]) * np.sqrt(weight)[:, None]
    inverse = np.linalg.inv(basis.T @ basis)
    at_middle = inverse @ (basis.T @ (v * np.sqrt(weight)))
    left = v * np.sqrt(weight) - basis @ at_middle
    back = np.array([[1.0, -middle], [0.0, 1.0]])
    return back @ at_middle, back @ inverse @ back.T, float(left @ left)
