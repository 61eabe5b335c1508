"""Rounding: the resolution of time stamps, and straight lines through them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import RecordError
from suspid.signals import JITTER, uniform_step
from suspid.units import RealArray, Second

Indices: TypeAlias = NDArray[np.intp]

# Steps longer than this many usual ones have rows missing in them: half way between one step and two.
HOLE = 1.5
# Share of the rows up to which doubled or wrong stamps count as single faults of a regular clock.
FEW = 0.01


def resolution(stamps: RealArray) -> Second:
    """Return the decimal or binary step to which the stamps are rounded [s].

    Examples
    --------
    >>> resolution(np.array([0.0, 0.003, 0.005])), resolution(np.array([0.0, 0.25, 0.45]))
    (0.001, 0.05)
    """
    largest = float(np.max(np.abs(stamps)))
    slack = max(1e-12, 4 * float(np.spacing(largest)))
    some = stamps[:: max(1, stamps.size // 4096)]
    decimal = 0.0
    for quantum in (m * 10.0**-k for k in range(10) for m in (1, 0.5, 0.2)):
        for part in (some, stamps):
            if not np.all(np.abs(part - np.round(part / quantum) * quantum) <= slack):
                break
        else:
            decimal = quantum
            break
    with np.errstate(over="ignore"):
        single = bool(np.all(stamps == stamps.astype(np.float32)))
    return max(decimal, float(np.spacing(np.float32(largest))) if single else 0.0, 2 * float(np.spacing(largest)))


def is_uniform(stamps: RealArray) -> bool:
    """Return whether stamps are a uniform grid already."""
    try:
        uniform_step(stamps)
    except RecordError:
        return False
    return True


def exact(steps: RealArray) -> bool:
    """Return whether all steps are whole multiples of one, nearly always one of it: nothing but rows is missing."""
    usual = float(np.median(steps))
    if usual <= 0 or np.mean(steps == 0) > FEW:
        return False
    ratio = steps / usual
    return bool(np.all(np.abs(ratio - np.round(ratio)) < JITTER) and np.mean(steps <= HOLE * usual) > 0.9)


def line(index: RealArray | Indices, times: RealArray) -> tuple[Second, Second, Second]:
    """Return start, step and the std of the step of the line through the stamps, outliers left out."""
    kept = np.ones(times.size, bool)
    start = step = std = 0.0
    for _ in range(4):
        centre = np.mean(index[kept])
        power = float(np.sum((index[kept] - centre) ** 2))
        step = float(np.sum((index[kept] - centre) * times[kept]) / power)
        start = float(np.mean(times[kept]) - step * centre)
        off = np.abs(times - (start + step * index))
        std = float(np.sqrt(np.mean(off[kept] ** 2) / power))
        inside = off <= 8 * np.median(off) + 1e-12 * abs(step)
        if np.array_equal(inside, kept) or np.sum(inside) < 0.9 * times.size:
            break
        kept = inside
    return start, step, std
