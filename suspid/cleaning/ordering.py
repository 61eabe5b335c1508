"""Ordering: doubled, swapped and wrongly stamped rows in one order of time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.findings import Finding, found
from suspid.errors import RecordError
from suspid.stamps import FEW, MOST_PER_ROW, Indices, line, resolution
from suspid.units import Ratio, RealArray
from suspid.wording import Argument, moment
from suspid.words import Defect, Number

# Latest possible time stamp [s].
LATEST = 1e15
# A clock has stopped where its last stamp stands in more than this many times the rows of any other: with fewer, stamps
# that come in packets of rows, or are rounded, stop too.
STOPPED = 8
# A stamp out of order belongs between its neighbours if these are two usual steps apart, to this share of a step: more
# takes the border of two recordings for one.
NEAR_TWO = 0.5
# A row that was sent again follows at most this many rows after the first: more rows are another recording.
SENT_AGAIN = 8


def stamped(stamps: RealArray) -> tuple[Indices, tuple[Finding, ...]]:
    """Return the rows whose stamp is a number, without those at the ends whose stamps are far from all others.

    Those after the clock has stopped have none of their own.
    """
    rows = np.flatnonzero(np.abs(stamps) < LATEST)
    lost = stamps.size - rows.size
    if stamps.size < 2:
        raise RecordError(f"there is only {stamps.size} sample; a record needs two at least")
    if rows.size < 2 or lost > max(1, 0.1 * stamps.size):
        raise RecordError(
            f"{lost} of {stamps.size} time stamps are not numbers; correct the time column, or give {Argument('fs')} "
            f"alone"
        )
    findings: tuple[Finding, ...] = ()
    if lost:
        findings = (found(Defect.NO_STAMP, stamps[rows][[0, -1]], lost),)
    stopped = _stopped(stamps[rows])
    if stopped:
        findings = (*findings, found(Defect.STOPPED_CLOCK, stamps[rows][[-1]], stopped))
        rows = rows[:-stopped]
    far = _far_ends(stamps[rows])
    if not np.any(far):
        return rows, findings
    first = float(stamps[rows[far]][0])
    rows = rows[~far]
    numbers: dict[str, Number] = {"first": first, "left_out": True}
    return rows, (*findings, found(Defect.WRONG_STAMPS, stamps[rows][[0, -1]], int(np.sum(far)), numbers))


def _stopped(times: RealArray) -> int:
    """Return the number of rows at the end that repeat a stamp far more often than any other is repeated."""
    borders = np.flatnonzero(np.diff(times, prepend=np.nan, append=np.nan) != 0)
    runs = np.diff(borders)
    if runs.size < 3:
        return 0
    return int(runs[-1]) - 1 if runs[-1] > STOPPED * max(1, int(np.max(runs[:-1]))) else 0


def _far_ends(times: RealArray) -> NDArray[np.bool_]:
    """Return which of the first and last rows are too far from the others in time for any grid, if these are few."""
    none = np.zeros(times.size, bool)
    steps = np.abs(np.diff(times))
    # Of fewer rows none can be told to be far from all others.
    if times.size < 12 or not np.any(steps > 0):
        return none
    reach = MOST_PER_ROW * times.size * float(np.median(steps[steps > 0]))
    far = np.abs(times - np.median(times)) > reach
    ends = np.logical_and.accumulate(far) | np.logical_and.accumulate(far[::-1])[::-1]
    return ends if np.sum(ends) <= max(2, FEW * times.size) else none


def numbered(rows: Indices, lost: Indices) -> Indices:
    """Return the numbers of rows in order of time, where the lost rows of the file have had numbers of their own."""
    if not lost.size:
        return np.arange(rows.size)
    ordered_rows = np.sort(rows)
    return np.asarray(
        np.arange(rows.size) + np.searchsorted(lost, ordered_rows) - np.searchsorted(lost, ordered_rows[0])
    )


def unrepeated(
    stamps: RealArray, values: RealArray, rows: Indices, *, most: Ratio = 1.0, distinct: bool = False
) -> tuple[Indices, tuple[Finding, ...]]:
    """Return the rows without those that repeat stamp and samples of the one before, if these are few.

    More than the share ``most`` is left, and with ``distinct`` all of them where as many stamps repeat with other
    samples: in coarse stamps, a mass at rest repeats both.
    """
    times = stamps[rows]
    shared = np.flatnonzero(np.diff(times) == 0) + 1
    now, before = values[:, rows[shared]], values[:, rows[shared - 1]]
    same = shared[np.all((now == before) | (np.isnan(now) & np.isnan(before)), axis=0)]
    coarse = distinct and 2 * same.size <= shared.size
    if not same.size or same.size > max(2, most * rows.size) or coarse:
        return rows, ()
    return np.delete(rows, same), (found(Defect.REPEATED_ROWS, times[same], same.size),)


def ordered(
    stamps: RealArray, values: RealArray, rows: Indices, lost: Indices
) -> tuple[RealArray, Indices, tuple[Finding, ...]]:
    """Return increasing stamps, and their rows; the lost rows have no stamp."""
    rows, repeated = unrepeated(stamps, values, rows, distinct=True)
    findings = list(repeated)
    times = stamps[rows]
    if times.size < 3:
        raise RecordError(f"only {times.size} rows with different time stamps are left; at least 3 are needed")
    again = _sent_again(times, values[:, rows])
    if again.any():
        findings.append(found(Defect.REPEATED_ROWS, times[again], int(np.sum(again))))
        times, rows = times[~again], rows[~again]
    if np.all(np.diff(times) > 0):
        return times, rows, tuple(findings)
    order = np.argsort(times, kind="stable")
    moved = np.flatnonzero(order != np.arange(order.size))
    # A row further out of order is a restart of the clock.
    near = moved.size <= max(4, FEW * rows.size) and np.all(np.abs(order - np.arange(order.size)) <= 8)
    if moved.size and near and np.all(np.diff(times[order]) > 0.5 * np.median(np.diff(times))):
        findings.append(found(Defect.SWAPPED_ROWS, times[order][moved], moved.size))
        return times[order], rows[order], tuple(findings)
    repaired = _wrongly_stamped(times, numbered(rows, lost))
    repaired = _between_neighbours(times) if repaired is None else repaired
    if repaired is not None:
        wrong = np.flatnonzero(repaired != times)
        findings.append(found(Defect.WRONG_STAMPS, repaired[wrong], wrong.size, {"first": float(times[wrong[0]])}))
        return repaired, rows, tuple(findings)
    apart = _moved_apart(times)
    if apart is not None:
        tied = np.flatnonzero(apart != times)
        findings.append(found(Defect.TIED_STAMPS, times[tied], tied.size // 2, {"apart": 0.5 * resolution(times)}))
        return apart, rows, tuple(findings)
    raise RecordError(_disordered(times))


def _sent_again(times: RealArray, values: RealArray) -> NDArray[np.bool_]:
    """Return which rows repeat one of the few rows before, stamp and samples, (row,): a packet sent twice.

    Another stamp lies between the two: in coarse stamps, a mass at rest repeats both.
    """
    again, other = np.zeros(times.size, bool), np.diff(times, prepend=np.nan) != 0
    for back in range(2, SENT_AGAIN + 1):
        same = np.flatnonzero((times[back:] == times[:-back]) & other[back:]) + back
        before = values[:, same - back]
        equal = np.all((values[:, same] == before) | (np.isnan(values[:, same]) & np.isnan(before)), axis=0)
        again[same[equal]] = True
    return again


def _moved_apart(times: RealArray) -> RealArray | None:
    """Return stamps of which some equal the one before, moved apart within their resolution; None if that is no order.

    Two rows of an irregular clock have one stamp where they lie closer than its last digit.
    """
    tied = np.diff(times) == 0
    if not tied.any() or np.any(tied[1:] & tied[:-1]) or np.sum(tied) > FEW * times.size:
        return None
    apart, quarter = times.copy(), 0.25 * resolution(times)
    apart[:-1][tied] -= quarter
    apart[1:][tied] += quarter
    return apart if np.all(np.diff(apart) > 0) else None


def _wrongly_stamped(times: RealArray, index: Indices) -> RealArray | None:
    """Return the stamps with a few outliers replaced, or None if outliers do not explain them."""
    start, step, _ = line(index, times)
    if step <= 0:
        return None
    # The tolerance is below half a step: a row that is missing or too many shows in all that follow.
    there = start + step * index
    wrong = np.abs(times - there) > 0.3 * step + 0.5 * resolution(times)
    if np.sum(wrong) > max(2, FEW * times.size):
        return None
    repaired = np.where(wrong, there, times)
    return repaired if np.all(np.diff(repaired) > 0) else None


def _between_neighbours(times: RealArray) -> RealArray | None:
    """Return the stamps with single ones that are out of order set between their neighbours; None if that is no order.

    The neighbours are two usual steps apart. Unlike a line, this needs no clock that is even over the record.
    """
    back = np.flatnonzero(np.diff(times) <= 0)
    usual = float(np.median(np.diff(times)))
    if not back.size or back.size > FEW * times.size or back[0] < 1 or back[-1] > times.size - 3 or not usual > 0:
        return None
    # Of two rows out of order, the one whose neighbours are nearer to two steps apart has the wrong stamp.
    off = np.abs([times[back + 1 + side] - times[back - 1 + side] - 2 * usual for side in (0, 1)])
    if np.any(np.min(off, axis=0) > NEAR_TWO * usual):
        return None
    wrong = back + np.argmin(off, axis=0)
    repaired = times.copy()
    repaired[wrong] = 0.5 * (times[wrong - 1] + times[wrong + 1])
    return repaired if np.all(np.diff(repaired) > 0) else None


def _taken(first: float, last: float) -> str:
    return f"take it with {Argument('start', moment(first))} and {Argument('stop', moment(last))}"


def _disordered(times: RealArray) -> str:
    back = np.flatnonzero(np.diff(times) < 0)
    if not back.size:
        same = np.flatnonzero(np.diff(times) == 0)
        return (
            f"{same.size} time stamps repeat the one before, with other samples, the first at "
            f"t = {moment(times[same[0]])} s, and no uniform clock rounds to them; remove one row of each, or give "
            f"{Argument('fs')} if the rows are regular"
        )
    if back.size == times.size - 1:
        return (
            f"the rows are in reverse order, from {moment(times[0])} s down to {moment(times[-1])} s; sort the rows by "
            f"time"
        )
    edges = np.concatenate([[0], back + 1, [times.size]])
    longest = int(np.argmax(np.diff(edges)))
    first, last = edges[longest], edges[longest + 1] - 1
    k = back[0]
    apart = np.delete(times, np.s_[first : last + 1])
    alone = bool(np.all((apart < times[first]) | (apart > times[last])))
    return (
        f"time runs backwards at {back.size} of {times.size} rows, the first after row {k + 1} (from "
        f"{moment(times[k])} s to {moment(times[k + 1])} s): the clock restarted, or the file contains several "
        f"recordings; the longest run is rows {first + 1} to {last + 1}, {moment(times[first])} to "
        f"{moment(times[last])} s; " + (_taken(times[first], times[last]) if alone else "keep one of them in the file")
    )
