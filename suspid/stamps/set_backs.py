"""Clocks that were set back by a few samples during a record, as loggers do that keep the time of a network."""

from __future__ import annotations

import numpy as np

from suspid.stamps.rounding import HOLE, Indices, resolution
from suspid.units import RealArray

# Of the steps of a clock, this share lies this near to the usual one, relative to it: loggers that wait between two
# samples stray by a tenth.
MOST_STEPS, JITTERY = 0.9, 0.25
# A clock is set back by this many samples at most: by more it may be another recording.
MOST_BACK = 8.0
# Fewest steps before and after, which show its pace: twice as many as it is set back by, so that none is a restart.
STEPS_OF_A_PACE = 16
# Rows for each time that a clock is set back, beyond the first: one that falls more often is none that runs on.
ROWS_PER_SET_BACK = 200
# Difference between the paces before and after, relative to these: over so few rows, jitter changes a mean by as much.
SAME_PACE = 0.03


def continued(stamps: RealArray) -> tuple[RealArray, Indices]:
    """Return the stamps of a clock as if it had not been set back, and the rows after which it was.

    Others are returned as they are: those that do not run evenly and at one pace before and after, that fall by more
    than a few samples, or too often. Stamps that also jump ahead by as much as they fall jitter.

    Examples
    --------
    >>> stamps = 0.02 * np.arange(100.0)
    >>> stamps[60:] -= 0.05
    >>> onward, after = continued(stamps)
    >>> bool(np.allclose(onward, 0.02 * np.arange(100.0))), after.tolist()
    (True, [59])
    """
    unchanged = stamps, np.zeros(0, np.intp)
    with np.errstate(over="ignore", invalid="ignore"):
        steps = np.diff(stamps)
    back = np.flatnonzero(steps < 0)
    if not 0 < back.size <= max(1, stamps.size // ROWS_PER_SET_BACK) or not np.all(np.isfinite(steps)):
        return unchanged
    runs = [steps[first:stop] for first, stop in zip([0, *(back + 1)], [*back, steps.size], strict=True)]
    forward = np.delete(steps, back)
    if min(run.size for run in runs) < STEPS_OF_A_PACE or not np.all(forward > 0) or not are_even(forward):
        return unchanged
    usual = float(np.median(forward))
    # Rows that are missing make single steps longer.
    single = [run[run < HOLE * usual] for run in runs]
    if not all(run.size for run in single):
        return unchanged
    paces = np.array([float(np.mean(run)) for run in single])
    pace = 0.5 * (paces[:-1] + paces[1:])
    moved = pace - steps[back]
    if np.ptp(paces) > SAME_PACE * usual or np.max(moved) > MOST_BACK * usual:
        return unchanged
    if np.max(forward) - usual >= np.min(moved):
        return unchanged
    quantum = resolution(stamps)
    shifts = np.zeros(stamps.size)
    shifts[back + 1] = np.round(moved / quantum) * quantum
    return np.asarray(stamps + np.cumsum(shifts)), back


def are_even(steps: RealArray) -> bool:
    """Return whether nine of ten steps are near to the usual one, which is positive.

    Examples
    --------
    >>> are_even(np.array([1.0, 1.1, 0.9, 1.0])), are_even(np.array([1.0, 2.0, 0.5, 1.0]))
    (True, False)
    """
    usual = float(np.median(steps))
    return usual > 0 and float(np.quantile(np.abs(steps - usual), MOST_STEPS)) <= JITTERY * usual
