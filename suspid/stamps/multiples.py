"""Multiples: stamps that are whole multiples of one step, so that only missing rows need explaining."""

from __future__ import annotations

import numpy as np

from suspid.signals import JITTER
from suspid.stamps.grids import Grid
from suspid.stamps.lines import FEWEST_POINTS
from suspid.stamps.rounding import line, resolution
from suspid.units import RealArray


def multiples_of(stamps: RealArray) -> Grid | None:
    """Return the clock of which all stamps are exact samples, with rows missing, or None if there is none.

    A slower clock whose stamps are rounded to that step explains the same stamps: the samples tell which is true.

    Examples
    --------
    >>> rows = np.delete(np.arange(400), np.arange(3, 400, 20))
    >>> grid = multiples_of(rows / 200)
    >>> f"{1 / grid.step:.2f} Hz", bool(np.all(grid.places == rows))
    ('200.00 Hz', True)
    """
    steps = np.diff(stamps)
    if stamps.size < FEWEST_POINTS or not np.min(steps) > 0:
        return None
    rounding = resolution(stamps)
    ticks = steps / float(np.median(steps))
    slack = JITTER + 2 * float(np.spacing(np.max(np.abs(stamps)))) / float(np.median(steps))
    if np.any(ticks < 0.5) or np.any(np.abs(ticks - np.round(ticks)) > slack * np.maximum(1, ticks)):
        return None
    # Where fewer steps are one step long, most of the clock would be missing.
    if np.mean(np.round(ticks) == 1) < 0.7 or np.max(ticks) > 1e9:
        return None
    places = np.concatenate([[0], np.cumsum(np.round(ticks))]).astype(np.intp)
    start, step, std = line(places, stamps)
    if np.any(np.abs(stamps - start - step * places) > slack * step):
        return None
    return Grid(start=start, step=step, step_std=std, places=places, resolution=rounding, jitter=0.0)
