"""Clock: the rows of a file on a uniform grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.errors import RecordError
from suspid.stamps import MOST_PER_ROW, Indices
from suspid.units import Hertz, RealArray, Second
from suspid.wording import Argument
from suspid.words import Defect, Number

# Relative difference of two clocks that are meant to be one: that of cheap crystals. Larger values accept a wrong
# stated rate, smaller ones refuse a right one.
DRIFT = 1e-4
# A stamp further from its place in the grid than this, in steps, belongs to another place.
OFF = 0.5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Clock:
    """The rows of a file on a uniform clock.

    Parameters
    ----------
    timepts : ndarray (sample,)
        The uniform grid [s].
    rows : ndarray (row,)
        Rows of the file that are used, in order of time.
    stamps : ndarray (row,)
        Time of each of these rows [s].
    places : ndarray (row,) or None
        Sample of the grid that each of these rows is; None where the grid lies between the rows.
    findings : tuple of Finding
        Defects of the stamps.
    """

    timepts: RealArray
    rows: Indices
    stamps: RealArray
    places: Indices | None
    findings: tuple[Finding, ...]

    @property
    def step(self) -> Second:
        """Step of the grid [s]."""
        return float(self.timepts[-1] - self.timepts[0]) / (self.timepts.size - 1)


def on_grid(
    start: Second,
    step: Second,
    places: Indices,
    rows: Indices,
    times: RealArray,
    kind: Defect | None,
    numbers: dict[str, Number],
) -> Clock:
    """Return the clock of rows of which it is known which samples they are; refuse one that is nearly empty."""
    if places[-1] >= MOST_PER_ROW * places.size:
        raise RecordError(_empty(step, places, times))
    timepts = np.asarray(start + step * np.arange(places[-1] + 1))
    findings: tuple[Finding, ...] = (found(kind, times, times.size, numbers),) if kind else ()
    lost = int(timepts.size - places.size)
    if lost:
        holes = np.flatnonzero(np.diff(places) > 1)
        counts: dict[str, Number] = {"rows": timepts.size, "places": holes.size}
        findings += (found(Defect.MISSING_ROWS, times[np.append(holes, holes[-1] + 1)], lost, counts),)
    return Clock(timepts=timepts, rows=rows, stamps=timepts[places], places=places, findings=findings)


def _empty(step: Second, places: Indices, times: RealArray) -> str:
    row = int(np.argmax(np.diff(places)))
    return (
        f"the time stamps of {times.size} rows span {places[-1] + 1} samples of {step:.3g} s, most of them in a gap of "
        f"{times[row + 1] - times[row]:.6g} s after row {row + 1}, {times[row]:.9g} s; correct the stamps next to "
        f"it, or use the part before or after it ({Argument('start')}, {Argument('stop')})"
    )


def stated(off: Second, rate: Hertz) -> dict[str, Number]:
    """Return what is said of stamps that lie up to ``off`` [s] from the grid of a stated rate."""
    return {"off": off, "off_samples": off * rate, "rate": rate}


def check_rate(rate: Hertz, mean: Hertz, allowed: float, stamps: RealArray, off: RealArray) -> None:
    """Refuse a rate that is further than the share allowed from that of the stamps."""
    if abs(mean - rate) <= allowed * rate:
        return
    worst = int(np.argmax(off))
    lies = abs(stamps[worst] - stamps[0] - worst / rate) * rate
    raise RecordError(
        Argument("fs", f"{rate:.9g}"),
        f" Hz and the column of time disagree: the stamps run at {mean:.9g} Hz on average, and stamp {worst + 1}, "
        f"{stamps[worst]:.9g} s, lies {lies:.3g} samples off",
    )
