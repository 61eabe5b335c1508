"""Numbers of clocks: whether those of a column run as the stamps of a clock do."""

from __future__ import annotations

import numpy as np

from suspid.io.time_units import FEW_STAMPS
from suspid.stamps import MOST_STEPS, are_even, continued, resolution
from suspid.units import RealArray

# No step of a clock that is read late now and then is longer than this, over the usual one, nor as much shorter.
MOST_LATE = 2.5
# Whole numbers are those of a clock that jitters if their usual step is this many at least, over this many rows: rows
# that were picked, and stations of a speed, are fewer apart, or fewer.
LEAST_TICKS, MANY_STAMPS = 4, 50
# Whole numbers in even steps are milliseconds beyond this: degrees end before it, and frequencies mostly.
MANY_TICKS = 1000
# Steps of a grid that is rounded differ by one unit of its last digit; those of a clock that jitters by this many.
TWO_DIGITS = 1.5
# Usual steps before which the first stamp of such a clock is.
FIRST_STEPS = 2.0
# Parts of a record in which a clock runs have the same mean step within this; most steps lie this near the usual one.
# Trackers that send when they can need the second, a counter of chance events has more.
ONE_PACE, UNSTEADY = 0.06, 0.6


def runs_as_clock(stamps: RealArray) -> bool:
    """Whether numbers rise as the stamps of a clock do: evenly, in even steps that are rounded, or with jitter.

    Whole numbers in even steps of one or more count the rows or are another axis; those of a clock in milliseconds, or
    finer, jitter. A logarithmic axis has no usual step. A clock may have been set back by a few samples.

    Examples
    --------
    >>> rows = np.arange(100.0)
    >>> [runs_as_clock(column) for column in (rows / 8, np.round(rows / 7, 1), rows, np.exp(rows), np.sin(rows))]
    [True, True, False, False, False]
    """
    # Columns of other lengths beside it leave it empty at the end.
    stamps = continued(stamps[: filled(stamps)])[0]
    if stamps.size < FEW_STAMPS or not np.all(np.isfinite(stamps)):
        return False
    with np.errstate(over="ignore"):
        steps = np.diff(stamps)
    usual = float(np.median(steps))
    rises = usual > 0 and bool(np.all(steps > 0))
    if not np.all(np.isfinite(steps)):
        return False
    if usual >= 1 and np.all(stamps == np.round(stamps)):
        return ticks(stamps)
    if rises and are_even(steps):
        return True
    # Stamps of whole milliseconds, some of them late by one.
    late = rises and float(np.max(steps)) <= MOST_LATE * usual and float(np.min(steps)) * MOST_LATE >= usual
    return late or _are_rounded(stamps, steps)


def ticks(stamps: RealArray) -> bool:
    """Whether numbers are those of a clock in whole milliseconds, or finer, that jitters.

    Examples
    --------
    >>> late = np.random.default_rng(1).integers(-2, 3, 100)
    >>> ticks(25.0 * np.arange(100) + late), ticks(25.0 * np.arange(100))
    (True, False)
    """
    stamps = continued(stamps[: filled(stamps)])[0]
    if stamps.size < MANY_STAMPS or not np.all(np.isfinite(stamps)) or not np.all(stamps == np.round(stamps)):
        return False
    steps = np.diff(stamps)
    jitters = float(np.median(steps)) >= LEAST_TICKS and bool(np.all(steps > 0) and np.ptp(steps) > 0)
    return jitters and are_even(steps)


def counts_in_steps(stamps: RealArray) -> bool:
    """Whether numbers are whole milliseconds from 0 in even steps, over a second and more, as a table is computed.

    Rows that were picked are fewer apart, and angles of a turn end below.

    Examples
    --------
    >>> [counts_in_steps(step * np.arange(200.0)) for step in (10, 1, 0.5)]
    [True, False, False]
    """
    if stamps.size < MANY_STAMPS or not np.all(np.isfinite(stamps)):
        return False
    step = float(stamps[1] - stamps[0])
    whole = step >= LEAST_TICKS and step == round(step) and bool(np.all(np.diff(stamps) == step))
    return whole and float(stamps[0]) in (0.0, step) and float(stamps[-1]) > MANY_TICKS


def jitters_at_one_pace(stamps: RealArray) -> bool:
    """Whether numbers are those of a clock with decimals that jitters: an axis that is driven goes in even steps.

    It begins with the record: what drifts has a level, as a temperature does.

    Examples
    --------
    >>> stamps = np.cumsum(np.random.default_rng(1).uniform(0.023, 0.027, 100))
    >>> [jitters_at_one_pace(numbers) for numbers in (stamps, 20 + stamps, np.arange(100) / 40)]
    [True, False, False]
    """
    if stamps.size < MANY_STAMPS or not np.all(np.isfinite(stamps)):
        return False
    stamps = continued(stamps)[0]
    steps = np.diff(stamps)
    begins = abs(float(stamps[0])) < FIRST_STEPS * float(np.median(np.abs(steps)))
    return begins and keeps_pace(stamps) and are_even(steps) and float(np.ptp(steps)) > TWO_DIGITS * resolution(stamps)


def filled(stamps: RealArray) -> int:
    """Return the number of rows up to the last stamp.

    Examples
    --------
    >>> filled(np.array([0.0, np.nan, 2.0, np.nan]))
    3
    """
    known = np.isfinite(stamps)
    return known.size - int(np.argmax(known[::-1])) if np.any(known) else 0


def never_falls(stamps: RealArray) -> bool:
    """Whether numbers rise and never fall, such as stamps of few digits, of which many repeat the one before.

    Examples
    --------
    >>> never_falls(np.round(np.arange(20) / 3)), never_falls(np.sin(np.arange(20.0)))
    (True, False)
    """
    steps = np.diff(stamps[: filled(stamps)])
    return bool(steps.size >= FEW_STAMPS and np.all(steps >= 0) and 2 * np.count_nonzero(steps) > FEW_STAMPS)


def keeps_pace(stamps: RealArray) -> bool:
    """Whether numbers rise at one pace but for jitter: in nine of ten parts of a record as in the middle one.

    A way, a counter of something and sorted numbers do not.

    Examples
    --------
    >>> keeps_pace(np.arange(100) / 8), keeps_pace((np.arange(100) / 8) ** 2)
    (True, False)
    """
    steps = np.diff(stamps)
    usual = float(np.median(steps))
    if not np.all(steps > 0) or np.all(stamps == np.round(stamps)):
        return False
    return at_one_pace(steps) and bool(np.quantile(np.abs(steps - usual), MOST_STEPS) <= UNSTEADY * usual)


def at_one_pace(steps: RealArray) -> bool:
    """Whether steps have the mean of the middle part of a record in nine of ten parts.

    Examples
    --------
    >>> at_one_pace(np.ones(100)), at_one_pace(np.arange(1.0, 101.0))
    (True, False)
    """
    paces = np.array([part.mean() for part in np.array_split(steps, 10)])
    return bool(np.sum(np.abs(paces / np.median(paces) - 1) < ONE_PACE) >= 9)


def _are_rounded(stamps: RealArray, steps: RealArray) -> bool:
    """Whether stamps are an even grid, rounded to a unit by which the steps differ."""
    unit = float(f"{np.ptp(steps):.1g}") if np.all(steps >= 0) else 0.0
    if not unit > 0:
        return False
    counts = stamps / unit
    # What rises by less is within one unit of a line whatever it is: a channel that steps once, and rests.
    if counts[-1] - counts[0] < 3:
        return False
    line = np.polynomial.Polynomial.fit(np.arange(stamps.size), counts, 1)(np.arange(stamps.size))
    # Stamps that are rounded to a unit are multiples of it but for this, in units.
    return bool(np.all(np.abs(counts - np.round(counts)) < 1e-3) and np.all(np.abs(counts - line) <= 1))
