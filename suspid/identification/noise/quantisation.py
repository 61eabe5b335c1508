"""The least noise of a record: rounding of its samples."""

from __future__ import annotations

import numpy as np

from suspid.levels import ROUNDING
from suspid.units import RealArray

# The samples in which a common step or number of digits shows. More cost time.
FIRST_SAMPLES = 4096
# Samples count as rounded if they have at most this many significant digits. A larger value mistakes exact
# double-precision samples for rounded ones.
MOST_DIGITS = 12
# Samples nearer to a rounded number than this share of themselves are it: arithmetic that keeps the digits, such as an
# offset removed and added again, leaves rounding errors of this size. At a larger one the twelfth digit is chance.
ARITHMETIC = 1e-13
# Standard deviation of a variable that is uniform over one step: quantisation.
UNIFORM_STD = 1 / np.sqrt(12)
# Residuals within this factor of the resolution are rounding, whose colour says nothing.
ABOVE_RESOLUTION = 4.0


def resolution(values: RealArray) -> RealArray:
    """Return the standard deviation that rounding and quantisation leave in each channel, (channel,).

    The largest of: rounding of the floating-point format, ``step / sqrt(12)`` where all samples are multiples of a
    step, and one unit of the last digit where all samples have few significant digits.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> float(resolution(0.125 * rng.integers(-400, 400, (1, 500)))[0] * np.sqrt(12))
    0.125
    """
    peak = np.max(np.abs(values), axis=1)
    rounding = np.where([_single(samples) for samples in values], 2.0**-24, 2.0**-52) * peak
    # A common step or number of digits shows in the first samples.
    coarse = [_coarseness(samples[:FIRST_SAMPLES], float(top)) for samples, top in zip(values, peak, strict=True)]
    # Real sensors resolve no less than 1e-11 of the peak; a smaller share makes the fit model rounding errors of
    # earlier processing.
    return np.asarray(np.maximum(np.maximum(4 * rounding, 1e-11 * peak), coarse))


def _single(samples: RealArray) -> bool:
    """Return whether all samples were stored in single precision."""
    # The first samples exclude most records.
    return all(_all_single(samples[part]) for part in (slice(FIRST_SAMPLES), slice(FIRST_SAMPLES, None)))


def _all_single(samples: RealArray) -> bool:
    with np.errstate(over="ignore", invalid="ignore"):  # What single precision cannot hold was not stored in it.
        return bool(np.all(np.abs(samples - samples.astype(np.float32)) <= ARITHMETIC * np.abs(samples)))


def _coarseness(samples: RealArray, peak: float) -> float:
    """Return the standard deviation due to few digits or a common step, 0 where there is neither."""
    std = 0.0
    digits = _significant_digits(samples)
    if digits is not None:
        # Rounding to significant digits is coarsest at the peak. It is not white where the signal hardly
        # moves, so one whole unit of the last digit counts, not its share as a uniform variable.
        std = 10.0 ** (np.floor(np.log10(peak * (1 + ROUNDING))) - digits + 1)
    gaps = np.diff(np.sort(samples))
    gaps = gaps[gaps > ROUNDING * peak]
    if gaps.size and gaps.min() > 1e-9 * peak:
        ratio = gaps / gaps.min()
        if np.max(np.abs(ratio - np.round(ratio))) < 1e-3:
            std = max(std, float(gaps.min()) * UNIFORM_STD)
    return std


def _significant_digits(samples: RealArray) -> int | None:
    """Return the number of significant digits of all samples, or None if it exceeds `MOST_DIGITS`."""
    some = np.abs(samples[samples != 0])
    # The first few samples exclude most records.
    if not some.size or not _rounded_to(some[:16], MOST_DIGITS) or not _rounded_to(some, MOST_DIGITS):
        return None
    return next(digits for digits in range(2, MOST_DIGITS + 1) if _rounded_to(some, digits))


def _rounded_to(some: RealArray, digits: int) -> bool:
    # Samples whose power of ten overflows are rounding.
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = some * 10.0 ** (digits - 1 - np.floor(np.log10(some)))
        return bool(np.all(np.abs(scaled - np.round(scaled)) < ARITHMETIC * 10.0**digits + 1e-9))
