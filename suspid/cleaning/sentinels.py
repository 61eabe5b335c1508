"""Sentinels: values far from all others that a logger writes for a missing sample, or an electric fault leaves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.findings import Finding, found
from suspid.units import RealArray
from suspid.values import LARGEST_SIZE
from suspid.words import Defect, Number

# Values that loggers write for a missing sample.
MARKS = (-9999.0, 9999.0, -999.0, 999.0, -99999.0, 99999.0, -999999.0, 999999.0)
# Ends of the ranges of converters of 16, 24 and 32 bits, of which a mark may be one.
FULL_SCALE = tuple(
    float(sign * 2**bits + shift) for bits in (15, 16, 23, 24, 31, 32) for sign in (-1, 1) for shift in (-1, 0, 1)
)
# Samples of one value far from all others that are no motion, if in as many samples after them the motion is not larger
# than before by this factor: a blow leaves motion behind.
LONGEST_RUN, NEAR_RUN, STIRRED = 3, 20, 2.0


def possible(values: RealArray) -> RealArray:
    """Return the samples with NaN for infinities and impossibly large numbers."""
    # The largest of samples with a NaN is NaN, so that these take the second way.
    if values.size and np.min(values) > -LARGEST_SIZE and np.max(values) < LARGEST_SIZE:
        return values
    return np.where(np.abs(values) < LARGEST_SIZE, values, np.nan)


def known(times: RealArray, values: RealArray) -> tuple[RealArray, RealArray]:
    """Return stamps and samples without those that are missing."""
    missing = np.isnan(values)
    return (times[~missing], values[~missing]) if np.any(missing) else (times, values)


def without_sentinels(name: str, times: RealArray, values: RealArray) -> tuple[RealArray, list[Finding]]:
    """Return the samples with NaN for values far from all others, and a finding for each such value."""
    findings: list[Finding] = []
    for _ in range(6):
        some = known(times, values)[1]
        if some.size < 8:
            break
        limit = _sentinel(some)
        if limit is None:
            break
        at = np.flatnonzero(values == limit)
        others = some[some != limit]
        numbers: dict[str, Number] = {"value": limit, "low": float(np.min(others)), "high": float(np.max(others))}
        findings.append(found(Defect.SENTINEL, times[at], at.size, numbers, channel=name))
        values = np.where(values == limit, np.nan, values)
    return values, findings


def _sentinel(some: RealArray) -> float | None:
    """Return the extreme value that cannot be motion, or None."""
    for limit in (float(np.max(some)), float(np.min(some))):
        others = some[some != limit]
        count = some.size - others.size
        low, high = (float(np.min(others)), float(np.max(others))) if others.size else (limit, limit)
        beyond = min(abs(limit - low), abs(limit - high))
        spread = high - low
        marked = limit in MARKS or limit in FULL_SCALE
        # Distance beyond the range of all other samples, as a share of that range, from which a value cannot be motion:
        # for any value, and for a mark. Smaller values strike out the first sample of a blow.
        if others.size < 8 or spread == 0 or beyond <= (0.25 if marked else 3.0) * spread:
            continue
        at = np.flatnonzero(some == limit)
        inside = at[(at > 0) & (at < some.size - 1)]
        # The first sample of a blow, and those before one, are far from what follows, but are motion.
        alone = inside.size > 0 and not (count == 1 and _rises(some, int(at[0]), high if limit > high else low))
        alone = alone and bool(np.all(np.diff(at) > 1) or limit == 0 or _without_effect(some, at))
        # A channel of two levels is a switch or a counter: a far value is one of its states.
        if (marked or alone) and count < 0.5 * some.size and _levels(others) >= 3:
            return limit
    return None


def _rises(some: RealArray, at: int, farthest: float) -> bool:
    """Return whether a lone value is the peak of a motion: the farthest of all others on its side is its neighbour."""
    return farthest in (some[max(at - 1, 0)], some[min(at + 1, some.size - 1)])


def _without_effect(some: RealArray, at: NDArray[np.intp]) -> bool:
    """Return whether samples of one value are short runs after which the motion is as before, unlike that of a blow."""
    for run in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1):
        before, after = some[max(0, run[0] - NEAR_RUN) : run[0]], some[run[-1] + 1 : run[-1] + 1 + NEAR_RUN]
        if run.size > LONGEST_RUN or min(before.size, after.size) < NEAR_RUN:
            return False
        if np.ptp(after) > STIRRED * np.ptp(before):
            return False
    return True


def _levels(samples: RealArray) -> int:
    return int(np.unique(samples[:4096]).size)
