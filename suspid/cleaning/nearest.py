"""Nearest clock: for increasing stamps that jitter, or belong to irregular sampling."""

from __future__ import annotations

import numpy as np

from suspid.cleaning.clock import DRIFT, OFF, Clock, check_rate, on_grid, stated
from suspid.cleaning.findings import found
from suspid.cleaning.following import FOLLOWED, SIGNIFICANT, late_or_irregular, share_followed
from suspid.errors import RecordError
from suspid.signals import JITTER
from suspid.stamps import FEW, HOLE, MOST_PER_ROW, SHORTEST, Indices, line, nearest_grid
from suspid.stamps import resolution as resolution_of
from suspid.units import Hertz, RealArray, Second
from suspid.wording import Argument
from suspid.words import Defect, Number, percent

# Steps between samples above which nothing is interpolated, and share of the time that such holes may take. Wider
# holes would be filled with what the record does not say.
WIDE_HOLE, HOLLOW = 2.5, 0.2
# Fewest packets that show a rate, and the longest wait for one over the time of the record. Rows that were lost in a
# longer one do not show.
FEW_PACKETS, LONGEST_WAIT = 20, 0.1
# A logger's clock may wander against that of the stamps by this share of its rate, from one part of the record to the
# next: frequencies are off by no more. Slower parts follow rounding, longer ones miss what wanders.
STRAYING, STRAY_PARTS = 2e-3, 20


def nearest_clock(times: RealArray, values: RealArray, rows: Indices, rate: Hertz | None) -> Clock:
    """Return the clock of increasing stamps that jitter or are irregular, of which some may be missing."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    hollow = not 0 < times[-1] - times[0] <= MOST_PER_ROW * times.size * usual or usual < SHORTEST
    near = None if hollow else nearest_grid(times)
    if near is None:
        raise RecordError(_hollow(steps, (WIDE_HOLE if hollow else HOLE) * usual))
    places, start, step = near
    if rate is not None:
        # Relative difference between a stated rate and that of irregular stamps up to which the stated one is taken.
        check_rate(rate, 1 / step, 0.02, times, np.abs(times - times[0] - places / rate))
        places = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(steps * rate)))]).astype(np.intp)
        step = 1 / rate
        start = float(np.median(times - step * places))
    off = times - (start + step * places)
    worst = float(np.max(np.abs(off)))
    within = 0.5 * resolution_of(times) + DRIFT * float(times[-1] - times[0])
    kind: Defect | None = None
    numbers: dict[str, Number] = {}
    if worst > JITTER * step:
        if rate is not None and worst <= min(within, OFF * step):
            kind, numbers = Defect.ROUNDED_STAMPS, stated(worst, rate)
        elif (worst <= step and np.mean(np.abs(off) > OFF * step) <= FEW) or (rate is None and _wanders(off, step)):
            kind, numbers = late_or_irregular(values, places, step, off)
        else:
            kind, numbers = Defect.IRREGULAR_STAMPS, {"largest": worst / step}
    if kind is Defect.IRREGULAR_STAMPS:
        return _irregular(times, rows, rate, numbers)
    return on_grid(start, step, places, rows, times, kind, numbers)


def _wanders(off: RealArray, step: Second) -> bool:
    """Return whether stamps stray from a grid slowly, and from that way by no more than rounding and jitter do."""
    from scipy.ndimage import uniform_filter1d

    size = max(off.size // STRAY_PARTS, 2)
    slow = np.asarray(uniform_filter1d(off, size, mode="nearest"))
    rest = np.abs(off - slow)
    changes = np.abs(slow[size:] - slow[:-size]) / size
    return bool(
        np.max(changes, initial=0.0) < STRAYING * step and np.max(rest) <= step and np.mean(rest > OFF * step) <= FEW
    )


def dispersed(times: RealArray, values: RealArray, rows: Indices, places: Indices) -> Clock | None:
    """Return the clock of rows in order whose stamps jitter so far that some repeat or run backwards, or None."""
    start, step, _ = line(places, times)
    off = times - start - step * places
    slack = 0.5 * resolution_of(times)
    if step < SHORTEST or np.max(np.abs(off)) > slack + step or np.mean(np.abs(off) > slack + OFF * step) > FEW:
        return None
    _, numbers = late_or_irregular(values, places, step, off)
    return on_grid(start, step, places, rows, times, Defect.JITTERING_STAMPS, numbers)


def packed(times: RealArray, values: RealArray, rows: Indices, places: Indices) -> Clock | None:
    """Return the clock of regular rows that came in packets, each with the time of its arrival as stamp, or None.

    The times of arrival lie on a line over the number of the last row of each packet; single ones come late, by the
    time that the longest of them was waited for.
    """
    steps = np.diff(times)
    ends = np.flatnonzero(steps > 0)
    if ends.size < FEW_PACKETS or 2 * ends.size > times.size or np.any(steps < 0):
        return None
    start, step, _ = line(places[ends], times[ends])
    off = times[ends] - start - step * places[ends]
    waited = float(np.max(steps))
    if step < SHORTEST or np.max(np.abs(off)) > waited or waited > LONGEST_WAIT * (times[-1] - times[0]):
        return None
    share, std = share_followed(values, (times - start) / step - places, places)
    if share > max(SIGNIFICANT * std, FOLLOWED):
        return None
    numbers: dict[str, Number] = {
        "packets": int(ends.size) + 1,
        "rows": float(np.median(np.diff(ends))),
        "rate": 1 / step,
        "rate_std": float(np.std(off)) / (step * np.sqrt(ends.size) * step * float(np.std(places[ends]))),
    }
    return on_grid(start, step, places, rows, times, Defect.PACKETS, numbers)


def _irregular(times: RealArray, rows: Indices, rate: Hertz | None, numbers: dict[str, Number]) -> Clock:
    """Return a uniform grid between irregular stamps."""
    steps = np.diff(times)
    step = mean_step(steps) if rate is None else 1 / rate
    if np.sum(steps[steps > WIDE_HOLE * step]) > HOLLOW * (times[-1] - times[0]):
        raise RecordError(_hollow(steps, WIDE_HOLE * step))
    count = int(np.floor((times[-1] - times[0]) / step * (1 + 1e-12))) + 1
    said = found(Defect.IRREGULAR_STAMPS, times, times.size, {**numbers, "rate": 1 / step})
    timepts = np.asarray(times[0] + step * np.arange(count))
    return Clock(timepts=timepts, rows=rows, stamps=times, places=None, findings=(said,))


def mean_step(steps: RealArray) -> Second:
    """Return the mean of all steps but holes: those that are wide against the mean of the others.

    A logger that often waits for its other work has many steps well above the usual one, where no row is missing.
    """
    step = float(np.mean(steps))
    while (shorter := float(np.mean(steps[steps <= WIDE_HOLE * step]))) < step:
        step = shorter
    return step


def _hollow(steps: RealArray, wide: Second) -> str:
    share = float(np.sum(steps[steps > wide])) / max(float(np.sum(steps)), SHORTEST)
    longest = int(np.argmax(steps))
    return (
        f"the time stamps are too irregular for a uniform record: half of the steps are below "
        f"{np.median(steps):.3g} s, but {percent(share)} of the time is in steps above {wide:.3g} s, the longest "
        f"{steps[longest]:.3g} s after row {longest + 1}; record at a constant rate, or take a stretch without such "
        f"holes ({Argument('start')}, {Argument('stop')})"
    )
