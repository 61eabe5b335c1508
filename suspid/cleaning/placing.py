"""Placing: samples onto the uniform grid of a clock, and from one grid onto another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.cleaning.clipping import clipped_run
from suspid.cleaning.clock import Clock
from suspid.cleaning.findings import Finding
from suspid.cleaning.nearest import WIDE_HOLE
from suspid.stamps import Indices
from suspid.units import Hertz, Ratio, RealArray, Second
from suspid.words import Number

# Share of the usual step below which a stamp nearly duplicates the one before: a spline through both would turn their
# noise into slope.
CLOSE = 0.3


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Placed:
    """Channels on one uniform grid.

    Parameters
    ----------
    timepts : ndarray (sample,)
        The grid [s].
    step : float
        Its step [s].
    names : tuple of str
        The channels.
    values : ndarray (channel, sample)
        Their samples; NaN where missing.
    findings : tuple of Finding
        Defects of the stamps and of the channels.
    """

    timepts: RealArray
    step: Second
    names: tuple[str, ...]
    values: RealArray
    findings: tuple[Finding, ...]


def place(clock: Clock, names: Sequence[str], values: RealArray, findings: Sequence[Finding] = ()) -> Placed:
    """Return rows (channel, row) on the grid of their clock.

    Where every row is a sample of the grid, the samples stay as they are and missing rows become NaN. Otherwise they
    are interpolated, and the finding states the error.

    Examples
    --------
    >>> from suspid.cleaning.clocks import read_clock
    >>> t = np.delete(np.arange(20) / 10, 7)
    >>> placed = place(read_clock(t, t[None]), ["seat"], t[None])
    >>> placed.values[0, 6:9]
    array([0.6, nan, 0.8])
    """
    said = list(clock.findings)
    if clock.places is None:
        spread = [interpolate(clock.timepts, clock.stamps, row, widest=WIDE_HOLE * clock.step) for row in values]
        errors = [halving_error(clock.stamps, row) for row in values]
        least = min(range(len(errors)), key=lambda k: (np.isnan(errors[k]), errors[k]))
        slow: dict[str, Number] = {"error": max(errors), "least": errors[least], "slowest": names[least]}
        steps = np.diff(clock.stamps)
        close = int(np.sum(steps < CLOSE * np.median(steps)))
        said[-1] = said[-1].with_numbers({"faithful_below": faithful_below(steps), **slow, "dropped": close})
        placed = np.array(spread)
    elif clock.places.size == clock.timepts.size:
        placed = values
    else:
        placed = np.full((len(values), clock.timepts.size), np.nan)
        placed[:, clock.places] = values
    return Placed(
        timepts=clock.timepts, step=clock.step, names=tuple(names), values=placed, findings=(*said, *findings)
    )


def resample(part: Placed, onto: Placed) -> tuple[Placed, Ratio]:
    """Return channels on the grid of others, and the largest rms error as a share of a channel's motion."""
    rows = [interpolate(onto.timepts, part.timepts, row, widest=WIDE_HOLE * part.step) for row in part.values]
    error = max(halving_error(part.timepts, row) for row in part.values)
    inside = (onto.timepts >= part.timepts[0]) & (onto.timepts <= part.timepts[-1])
    grid = onto.timepts[inside] if np.any(inside) else part.timepts
    return replace(part, timepts=grid, step=onto.step, values=np.array(rows)), error


def interpolate(wanted: RealArray, times: RealArray, values: RealArray, *, widest: Second) -> RealArray:
    """Return the cubic spline through the samples at the times wanted; NaN in gaps wider than ``widest``.

    What is nearer to a sample than half a step, as it is between rows without a gap, is known beside a gap as well.

    Examples
    --------
    >>> t = np.array([0.0, 0.1, 0.25, 0.3, 0.4, 1.0])
    >>> interpolate(np.array([0.2, 0.7]), t, t**3, widest=0.2)
    array([0.008, nan])
    """
    from scipy.interpolate import CubicSpline

    known = np.isfinite(values)
    spread = np.full(wanted.size, np.nan)
    if np.sum(known) < 4:
        return spread
    t, y = _apart(times[known], values[known])
    if t.size < 4:
        return spread
    slack = 1e-9 * min(widest, float(t[-1] - t[0]))
    inside = (wanted >= t[0] - slack) & (wanted <= t[-1] + slack)
    spread[inside] = CubicSpline(t, y)(wanted[inside])
    behind = np.clip(np.searchsorted(t, wanted), 1, t.size - 1)
    spread = _within_limits(spread, behind, y)
    wide = t[behind] - t[behind - 1] > widest
    near = max(slack, 0.5 * widest / WIDE_HOLE) if np.any(wide) else slack
    wide &= (np.abs(t[behind] - wanted) > near) & (np.abs(wanted - t[behind - 1]) > near)
    spread[wide] = np.nan
    return spread


def _within_limits(spread: RealArray, behind: Indices, samples: RealArray) -> RealArray:
    """Return interpolated samples that stay at a limit at which those before and ``behind`` them are clipped.

    What the sensor did not measure is no part of a spline, which runs beyond the limit there.
    """
    for largest in (True, False):
        run = clipped_run(samples, largest=largest)
        if run is None:
            continue
        limit = samples[run[0]]
        between = (samples[behind] == limit) & (samples[behind - 1] == limit)
        within = np.minimum(spread, limit) if largest else np.maximum(spread, limit)
        spread = np.where(between & np.isfinite(spread), limit, within)
    return spread


def _apart(times: RealArray, values: RealArray) -> tuple[RealArray, RealArray]:
    """Leave out near-duplicate time stamps: the noise of their samples would become slope."""
    steps = np.diff(times)
    if not steps.size:
        return times, values
    keep = np.concatenate([[True], steps >= CLOSE * np.median(steps)])
    return times[keep], values[keep]


def faithful_below(steps: RealArray) -> Hertz:
    """Return the frequency below which the error of a cubic spline is below 1 % of a sinusoid's amplitude [Hz].

    The error is at most 5/384 h^4 times the largest fourth derivative (Hall and Meyer 1976). The step h is the 99 %
    quantile of the steps.

    Examples
    --------
    >>> round(faithful_below(np.full(9, 0.01)), 1)
    14.9
    """
    return float((0.01 * 384 / 5) ** 0.25 / (2 * np.pi * np.quantile(steps, 0.99)))


def halving_error(times: RealArray, values: RealArray) -> Ratio:
    """Return the rms error of the spline through every second sample at the others, as a share of the motion.

    The error of the spline through all samples is smaller. Noise is included.
    """
    known = np.isfinite(values)
    t, y = _apart(times[known], values[known])
    motion = float(np.std(y)) if y.size > 1 else 0.0
    if t.size < 9 or motion == 0:
        return float("nan")
    between = interpolate(t[1:-1:2], t[::2], y[::2], widest=np.inf)
    return float(np.sqrt(np.nanmean((between - y[1:-1:2]) ** 2))) / motion
