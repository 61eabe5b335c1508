"""Test whether samples were taken at irregular stamps, or regularly and stamped late."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.findings import Finding, found
from suspid.stamps import Grid, Indices
from suspid.units import RealArray, Second
from suspid.words import Defect, Number

# Share of the way that samples must follow their stamps to count as taken then, and the number of standard deviations
# by which it must differ from none. Between 0 (late stamps) and 1 (irregular sampling) the first leans towards
# irregular sampling, whose repair costs little; the second keeps noise from deciding.
FOLLOWED, SIGNIFICANT = 0.3, 4.0


def late_or_irregular(
    values: RealArray, places: Indices, step: Second, off: RealArray
) -> tuple[Defect, dict[str, Number]]:
    """Return whether stamps that are off by less than half a step are late or the samples irregular, with numbers.

    Parameters
    ----------
    values : ndarray (channel, row)
        The samples.
    places : ndarray (row,)
        Places of the rows in the grid.
    step : float
        Step of the grid [s].
    off : ndarray (row,)
        Stamps less their times in the grid [s].
    """
    share, std = share_followed(values, off / step, places)
    sigma = float(np.sqrt(np.mean(off**2)))
    largest = float(np.max(np.abs(off)))
    numbers: dict[str, Number] = {"followed": share, "followed_std": std}
    if share > max(SIGNIFICANT * std, FOLLOWED):
        return Defect.IRREGULAR_STAMPS, {**numbers, "largest": largest / step}
    pace = np.diff(values, axis=1)
    speed = np.sqrt(_mean(pace**2, np.isfinite(pace))) / step * sigma
    there = np.isfinite(values)
    about = values - _mean(values, there)[:, None]
    motion = np.sqrt(_mean(about**2, there))
    error = float(np.max(speed / np.where(motion > 0, motion, np.inf)))
    return Defect.JITTERING_STAMPS, {**numbers, "largest": largest, "rms": sigma, "rate": 1 / step, "error": error}


def rows_are_missing(times: RealArray, values: RealArray, slow: Grid, exact: Grid) -> tuple[bool, tuple[Finding, ...]]:
    """Return whether rows are missing from an exact clock, or else a slower one was rounded; a doubt if none can tell.

    The samples were taken at the stamps if rows are missing, and off them if the stamps of a slower clock are rounded.

    Parameters
    ----------
    times : ndarray (row,)
        The stamps [s].
    values : ndarray (channel, row)
        The samples.
    slow, exact : Grid
        The clock that rounds to the stamps, and the one of which they are multiples.
    """
    share, std = share_of_places(values, slow.places, exact.places)
    if share > max(SIGNIFICANT * std, FOLLOWED):
        return True, ()
    if share + SIGNIFICANT * std < 1:
        return False, ()
    numbers: dict[str, Number] = {
        "followed": share,
        "followed_std": std,
        "rate": 1 / slow.step,
        "other_rate": 1 / exact.step,
        "missing": int(exact.places[-1]) + 1 - times.size,
    }
    # Loggers round to powers of ten: another step is more likely that of the samples.
    digits = float(np.log10(exact.step))
    # A step is a power of ten if their decimal logarithms differ by no more than this.
    missing = bool(abs(digits - round(digits)) > 1e-3)
    numbers["assumed"] = 1 / (exact if missing else slow).step
    return missing, (found(Defect.AMBIGUOUS_STAMPS, times, times.size, numbers, repaired=False),)


def share_of_places(values: RealArray, slow: Indices, exact: Indices) -> tuple[float, float]:
    """Return how far samples lie at the exact places, 1, instead of at the slow ones, 0, and the std of that.

    Each sample is predicted by the cubic through two neighbours on each side, with their places by either clock. The
    share is the regression of the miss by the slow clock on the difference of the two predictions. What noise alone
    adds to both sums is known from the weights, and is subtracted.

    Parameters
    ----------
    values : ndarray (channel, row)
        The samples.
    slow, exact : ndarray (row,)
        Places of the rows by either clock.
    """
    by_slow, by_exact = _cubic_weights(slow), _cubic_weights(exact)
    apart = by_exact - by_slow
    tells = np.any(np.abs(apart) > 1e-9, axis=1)
    over = under = spread = 0.0
    for row in values:
        around = np.stack([row[k : row.size - 4 + k] for k in (0, 1, 3, 4)], axis=1)
        missed = row[2:-2] - np.sum(by_slow * around, axis=1)
        known = np.isfinite(missed)
        quiet, used = known & ~tells, known & tells
        if not np.any(used):
            continue
        # With 20 samples away from the jumps of a clock the noise is taken from them alone.
        where = quiet if np.sum(quiet) >= 20 else known
        misses = [missed, row[2:-2] - np.sum(by_exact * around, axis=1)]
        noise = min(
            float(np.mean(miss[where] ** 2 / (1 + np.sum(by[where] ** 2, axis=1))))
            for miss, by in zip(misses, (by_slow, by_exact), strict=True)
        )
        noise = max(noise, 1e-20 * float(np.mean(row[2:-2][known] ** 2)), 1e-300)
        expected = np.sum(apart[used] * around[used], axis=1) / np.sqrt(noise)
        missed = missed[used] / np.sqrt(noise)
        over += float(np.sum(expected * missed) + np.sum(by_slow[used] * apart[used]))
        under += float(np.sum(expected**2) - np.sum(apart[used] ** 2))
        share = float(np.clip(np.sum(expected * missed) / max(np.sum(expected**2), 1e-300), 0, 1))
        spread += float(
            np.sum((expected * (missed - share * expected)) ** 2) + np.sum(apart[used] ** 2) ** 2 / known.size
        )
    if not (under > 0 and np.isfinite(over) and np.isfinite(spread)):
        return 0.0, np.inf
    # Neighbouring misses share samples; simulated records have 2.2 times the variance of independent ones.
    return over / under, float(np.sqrt(2.5 * spread)) / under


def _cubic_weights(places: Indices) -> RealArray:
    """Return the weights of two neighbours on each side in the cubic through them, for each row but two at the ends."""
    knots = np.stack([places[k : places.size - 4 + k] - places[2:-2] for k in (0, 1, 3, 4)], axis=1).astype(float)
    weights = np.ones(knots.shape)
    for one in range(4):
        for other in range(4):
            if other != one:
                weights[:, one] *= -knots[:, other] / (knots[:, one] - knots[:, other])
    return weights


def share_followed(values: RealArray, off: RealArray, places: Indices) -> tuple[float, float]:
    """Return how far the samples follow the stamps off the grid, 0 not at all and 1 all the way, and its std.

    The cubic through two neighbours on each side misses a sample of a smooth motion by its slope times the distance
    of its time from those of its neighbours; the regression on that distance is the share. In noise it tends to zero.

    Parameters
    ----------
    values : ndarray (channel, row)
        The samples.
    off : ndarray (row,)
        Stamps less their places in the grid [steps].
    places : ndarray (row,)
        Places in the grid; only where five follow each other is anything counted.
    """
    whole = np.flatnonzero(places[4:] - places[:-4] == 4)
    # More samples would not change the decision.
    whole = whole[:: max(1, whole.size // 200_000)]
    before, last, now, after, second = (values[:, whole + k] for k in range(5))
    missed = now - (4 * (last + after) - before - second) / 6
    slope = (8 * (after - last) - (second - before)) / 12
    lead = off[whole + 2] - (4 * (off[whole + 1] + off[whole + 3]) - off[whole] - off[whole + 4]) / 6
    known = np.isfinite(missed)
    size = np.sqrt(_mean(missed**2, known))[:, None]
    usable = known & (size > 0)
    missed = np.where(usable, missed, 0.0) / np.where(size > 0, size, 1.0)
    expected = np.where(usable, slope * lead, 0.0) / np.where(size > 0, size, 1.0)
    power = float(np.sum(expected**2))
    if not power > 0:
        return 0.0, np.inf
    share = float(np.sum(missed * expected)) / power
    # Neighbouring misses share samples, which counts twice at most.
    return share, float(np.sqrt(2 * np.sum((expected * (missed - share * expected)) ** 2))) / power


def _mean(values: RealArray, known: NDArray[np.bool_]) -> RealArray:
    """Return the mean of what is known; 0 where nothing is."""
    return np.asarray(np.where(known, values, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1))
