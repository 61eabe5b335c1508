"""Clocks: from the stamps of a file, rounded, repeated, swapped or irregular, to one uniform grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import RecordError
from suspid.findings import Finding
from suspid.signals import JITTER, uniform_step
from suspid.units import Hertz, RealArray, Second

Indices: TypeAlias = NDArray[np.intp]

# How far two clocks may differ and still be meant to be one; over a long record, half a sample at most.
DRIFT = 1e-4
# How far a stated rate and that of irregular stamps may lie apart: the grid is the stated one.
APART = 0.02
# Stamps further than this many steps apart have rows missing between them.
HOLE = 1.5
# A stamp that lies further off its place in the grid than this, in steps, is not there by rounding or by jitter.
OFF = 0.5
# Rows that may be dropped, put in order or stamped anew, as a share of all, and how far out of order they may be.
FEW, FAR = 0.01, 8
# No stamp is later than this, no step shorter [s].
LATEST, SHORTEST = 1e15, 1e-12
# Rows that may share a stamp for being rounded.
COARSE = 20
# Samples that follow irregular stamps at least this far, and by so many standard deviations, were taken at them.
FOLLOWED, SIGNIFICANT = 0.3, 4.0
# Steps between samples above which nothing is interpolated, and how much of the time such holes may take.
WIDE, HOLLOW = 2.5, 0.2
# How many times the rows that are there a grid may hold.
MOST_ROWS = 20


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Clock:
    """Where the rows of a file stand in time.

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
        What was met.
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


def read_clock(stamps: RealArray, values: RealArray, *, rate: Hertz | None = None) -> Clock:
    """Return the uniform clock that stamps stand for.

    Tried in this order; the first that explains every stamp is taken, and said in the findings:
    stamps that are uniform already, which stay as they are; the grid of a rate that is known; a
    regular clock with rounded stamps; the same with a few rows doubled, swapped, wrongly stamped or
    missing; a regular clock with stamps that jitter, or irregular sampling with stamps that are
    right. The last two differ in which the samples follow more smoothly, the grid or the stamps.

    Parameters
    ----------
    stamps : ndarray (row,)
        Times [s] as the file has them.
    values : ndarray (channel, row)
        The samples; NaN where missing.
    rate : float, optional
        The rate that the file or the user states [Hz].

    Raises
    ------
    RecordError
        If there are fewer than two usable stamps, the clock restarts, the stamps are at odds with
        the rate, or they are too irregular for any grid.

    Examples
    --------
    >>> stamps = np.round(np.arange(2000) / 333, 3)
    >>> clock = read_clock(stamps, np.zeros((1, 2000)))
    >>> f"{1 / clock.step:.2f} Hz", clock.findings[0].kind
    ('333.00 Hz', 'rounded stamps')
    """
    rows, findings = _stamped(stamps)
    whole = _plain(stamps[rows], rate)
    if whole is not None:
        timepts, further = whole
        return Clock(
            timepts=timepts, rows=rows, stamps=timepts, places=np.arange(rows.size), findings=(*findings, *further)
        )
    times, rows, further = _ordered(stamps, values, rows)
    findings += further
    if further and rows.size > 1:
        whole = _plain(times, rate)
        if whole is not None:
            timepts, more = whole
            findings = (*findings, *more)
            return Clock(timepts=timepts, rows=rows, stamps=timepts, places=np.arange(rows.size), findings=findings)
    return _gridded(times, values[:, rows], rows, rate, findings)


def _stamped(stamps: RealArray) -> tuple[Indices, tuple[Finding, ...]]:
    """Return the rows whose stamp is a number."""
    rows = np.flatnonzero(np.abs(stamps) < LATEST)
    lost = stamps.size - rows.size
    if rows.size < 2 or lost > max(1, 0.1 * stamps.size):
        raise RecordError(
            f"{lost} of {stamps.size} time stamps are no times; mend the column of time, or give fs alone"
        )
    if not lost:
        return rows, ()
    text = f"{lost} rows without a time stamp were dropped"
    return rows, (found("no stamp", stamps[rows][[0, -1]], lost, text),)


def _plain(stamps: RealArray, rate: Hertz | None) -> tuple[RealArray, tuple[Finding, ...]] | None:
    """Return the grid of stamps in which every row is one sample and none is missing, or None."""
    index = np.arange(stamps.size)
    uniform = _is_uniform(stamps)
    if rate is None:
        if uniform:
            return stamps, ()
        line = rounded_line(index, stamps)
        if line is None:
            return None
        start, step, std = line
        grid = np.asarray(start + step * index)
        return grid, (found("rounded stamps", grid, stamps.size, _rounded_text(stamps, step, std)),)
    grid = np.asarray(stamps[0] + index / rate)
    off = np.abs(stamps - grid)
    if np.max(off) <= 8 * np.spacing(np.max(np.abs(grid))):
        return stamps, ()
    allowed = JITTER / rate + (0.0 if uniform else resolution(stamps))
    allowed = allowed + np.minimum(OFF / rate, DRIFT * np.abs(grid - grid[0]))
    if np.all(off <= allowed):
        text = (
            f"the stamps lie up to {np.max(off):.2g} s ({np.max(off) * rate:.2g} steps) off the grid of {rate:.9g} Hz; "
            f"they were put on it and no sample was changed"
        )
        return grid, (found("rounded stamps", grid, stamps.size, text),) if np.max(off) > JITTER / rate else ()
    if uniform:
        _check_rate(rate, (stamps.size - 1) / float(stamps[-1] - stamps[0]), 0.0, stamps, off - allowed)
    return None


def _check_rate(rate: Hertz, mean: Hertz, allowed: float, stamps: RealArray, off: RealArray) -> None:
    """Refuse a rate that is further than the share allowed from that of the stamps."""
    if abs(mean - rate) <= allowed * rate:
        return
    worst = int(np.argmax(off))
    raise RecordError(
        f"fs = {rate:.9g} Hz and the column of time disagree: the stamps run at {mean:.9g} Hz on average, and "
        f"stamp {worst + 1}, {stamps[worst]:.9g} s, lies {abs(stamps[worst] - stamps[0] - worst / rate) * rate:.3g} "
        f"samples off"
    )


def _ordered(stamps: RealArray, values: RealArray, rows: Indices) -> tuple[RealArray, Indices, tuple[Finding, ...]]:
    """Return stamps that increase, and the rows they belong to."""
    findings: list[Finding] = []
    times = stamps[rows]
    same = np.flatnonzero(np.diff(times) == 0) + 1
    if same.size:
        now, before = values[:, rows[same]], values[:, rows[same - 1]]
        same = same[np.all((now == before) | (np.isnan(now) & np.isnan(before)), axis=0)]
    if same.size:
        text = f"{same.size} rows stand twice, stamp and samples alike; one of each was dropped"
        findings.append(found("repeated rows", times[same], same.size, text))
        rows, times = np.delete(rows, same), np.delete(times, same)
    if times.size < 3:
        raise RecordError(f"only {times.size} rows with different time stamps are left; a record needs more")
    if np.all(np.diff(times) > 0):
        return times, rows, tuple(findings)
    order = np.argsort(times, kind="stable")
    moved = np.flatnonzero(order != np.arange(order.size))
    near = moved.size <= max(4, FEW * rows.size) and np.all(np.abs(order - np.arange(order.size)) <= FAR)
    if moved.size and near and np.all(np.diff(times[order]) > 0.5 * np.median(np.diff(times))):
        text = f"{moved.size} rows stand in the wrong order of time; they were sorted by their stamps"
        findings.append(found("swapped rows", times[order][moved], moved.size, text))
        return times[order], rows[order], tuple(findings)
    mended = _wrongly_stamped(times)
    if mended is not None:
        wrong = np.flatnonzero(mended != times)
        text = (
            f"{wrong.size} stamps are out of line with all others, the first {times[wrong[0]]:g} s; their rows "
            f"were taken to follow the rows before them"
        )
        findings.append(found("wrong stamps", mended[wrong], wrong.size, text))
        return mended, rows, tuple(findings)
    raise RecordError(_disordered(times))


def _wrongly_stamped(times: RealArray) -> RealArray | None:
    """Return the stamps with the few that are out of line replaced, or None if that does not explain them."""
    index = np.arange(times.size)
    start, step, _ = _line(index, times)
    if step <= 0:
        return None
    # The tolerance is below half a step: a row that is missing or too many shows in all that follow.
    line = start + step * index
    wrong = np.abs(times - line) > 0.3 * step + 0.5 * resolution(times)
    if np.sum(wrong) > max(2, FEW * times.size):
        return None
    mended = np.where(wrong, line, times)
    return mended if np.all(np.diff(mended) > 0) else None


def _disordered(times: RealArray) -> str:
    back = np.flatnonzero(np.diff(times) < 0)
    if not back.size:
        same = np.flatnonzero(np.diff(times) == 0)
        return (
            f"{same.size} stamps stand twice with different samples, the first is t = {times[same[0]]:g} s, and they "
            f"are not merely rounded: which sample is right cannot be told; remove one of each, or give fs alone if "
            f"the rows are regular"
        )
    edges = np.concatenate([[0], back + 1, [times.size]])
    longest = int(np.argmax(np.diff(edges)))
    first, last = edges[longest], edges[longest + 1] - 1
    k = back[0]
    return (
        f"time runs backwards at {back.size} of {times.size} rows, the first after row {k + 1} (from {times[k]:g} s to "
        f"{times[k + 1]:g} s): the clock restarted, or the file is several recordings; the longest that runs forwards "
        f"is rows {first + 1} to {last + 1}, {times[first]:g} to {times[last]:g} s; keep one of them in the file"
    )


def _gridded(
    times: RealArray, values: RealArray, rows: Indices, rate: Hertz | None, findings: tuple[Finding, ...]
) -> Clock:
    """Return the clock of increasing stamps, of which some may be missing or that may be irregular."""
    usual = float(np.median(np.diff(times)))
    if not 0 < times[-1] - times[0] <= MOST_ROWS * times.size * usual or usual < SHORTEST:
        raise RecordError(_hollow(np.diff(times), WIDE * usual))
    places, start, step = _regular(times)
    span = float(times[-1] - times[0])
    if rate is not None:
        off = np.abs(times - times[0] - places / rate)
        _check_rate(rate, 1 / step, APART, times, off)
        places = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(np.diff(times) * rate)))]).astype(np.intp)
        step = 1 / rate
        start = float(np.median(times - step * places))
    off = times - (start + step * places)
    rounding, worst = resolution(times), float(np.max(np.abs(off)))
    kind, text = "", ""
    if worst > JITTER * step:
        line = rounded_line(places, times) if rate is None else None
        if line is not None:
            start, step, std = line
            kind, text = "rounded stamps", _rounded_text(times, step, std)
        elif rate is not None and worst <= 0.5 * rounding + DRIFT * span and worst <= OFF * step:
            kind, text = "rounded stamps", f"the stamps are rounded; they were put on the grid of {rate:.9g} Hz"
        elif worst <= OFF * step:
            kind, text = _jitter(values, places, step, off)
        else:
            kind = "irregular stamps"
            text = (
                f"they stray by up to {worst / step:.2g} steps from the nearest uniform grid; they were taken as right"
            )
    if kind == "irregular stamps":
        return _irregular(times, rows, rate, findings, text)
    if places[-1] >= MOST_ROWS * times.size:
        raise RecordError(_hollow(np.diff(times), WIDE * usual))
    timepts = np.asarray(start + step * np.arange(places[-1] + 1))
    findings += (found(kind, times, times.size, text),) if kind else ()
    lost = int(timepts.size - places.size)
    if lost:
        holes = np.flatnonzero(np.diff(places) > 1)
        text = f"{lost} of {timepts.size} rows are missing, in {holes.size} places"
        findings += (found("missing rows", times[np.append(holes, holes[-1] + 1)], lost, text),)
    return Clock(timepts=timepts, rows=rows, stamps=timepts[places], places=places, findings=findings)


def _regular(times: RealArray) -> tuple[Indices, Second, Second]:
    """Return the place of each stamp on the regular grid nearest to all, and its start and step."""
    steps = np.diff(times)
    rounding = 0.0 if _exact(steps) else resolution(times)
    step = float(np.median(steps))
    for _ in range(8):
        better = float(np.mean(steps[steps <= HOLE * step + 0.5 * rounding]))
        if abs(better - step) <= 1e-12 * step:
            break
        step = better
    if step < SHORTEST:
        raise RecordError(_hollow(steps, HOLE * step))
    jumps = np.where(steps <= HOLE * step + 0.5 * rounding, 1, np.maximum(2, np.round(steps / step))).astype(np.intp)
    places = np.concatenate([[0], np.cumsum(jumps)])
    for _ in range(4):
        start, step, _ = _line(places, times)
        # A hole is counted anew with the better step: a long one holds many.
        again = np.concatenate([[0], np.cumsum(np.where(jumps > 1, np.maximum(1, np.round(steps / step)), 1))])
        if np.array_equal(again, places):
            break
        places = again.astype(np.intp)
    # Jitter makes long steps too; rows are missing only if that puts the stamps nearer to a grid.
    plain = np.arange(times.size)
    begin, even, _ = _line(plain, times)
    if even > 0 and np.sum((times - begin - even * plain) ** 2) <= np.sum((times - start - step * places) ** 2):
        return plain, begin, even
    return places, start, step


def _line(index: Indices, times: RealArray) -> tuple[Second, Second, Second]:
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


def rounded_line(index: Indices, stamps: RealArray) -> tuple[Second, Second, Second] | None:
    """Return start, step and std of the step of all grids that round to the stamps, or None if there is none.

    A grid rounds to the stamps if none lies further off than half their resolution. Its step then lies in an
    interval; the middle is returned, and the std of a uniform distribution over it. (The errors of rounding are
    no noise: they beat against the grid, and the spread about a line through them says too little.)
    """
    quantum = resolution(stamps)
    if _exact(np.diff(stamps)):
        return None
    step = _line(index, stamps)[1]
    if not 1e-6 * step < quantum < COARSE * step:
        return None
    span = float(index[-1] - index[0])

    def width(step: Second) -> Second:
        off = stamps - step * index
        return float(np.max(off) - np.min(off)) - 1.01 * quantum - 8 * float(np.spacing(np.max(np.abs(stamps))))

    low, high = step - 2 * quantum / span, step + 2 * quantum / span
    while high - low > 1e-3 * quantum / span:
        left, right = low + 0.382 * (high - low), low + 0.618 * (high - low)
        low, high = (low, right) if width(left) < width(right) else (left, high)
    best = (low + high) / 2
    if width(best) > 0:
        return None
    ends = []
    for side in (-1, 1):
        inside, outside = best, best + side * 2 * quantum / span
        for _ in range(14):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if width(middle) <= 0 else (inside, middle)
        ends.append(inside)
    step = (ends[0] + ends[1]) / 2
    off = stamps - step * index
    start = float(np.max(off) + np.min(off)) / 2
    if np.max(np.abs(off - off[0])) <= 0.505 * quantum:
        start = float(off[0])
    return start, step, (ends[1] - ends[0]) / np.sqrt(12)


def _exact(steps: RealArray) -> bool:
    """Return whether all steps are whole multiples of one, nearly always one of it: nothing but rows is missing."""
    usual = float(np.median(steps))
    if usual <= 0 or np.mean(steps == 0) > FEW:
        return False
    ratio = steps / usual
    return bool(np.all(np.abs(ratio - np.round(ratio)) < JITTER) and np.mean(steps <= HOLE * usual) > 0.9)


def _rounded_text(stamps: RealArray, step: Second, std: Second) -> str:
    return (
        f"the stamps are rounded to {resolution(stamps):.2g} s; the grid that rounds to all of them runs at "
        f"{1 / step:.8g} ± {max(std, 1e-15) / step**2:.1g} Hz; they were put on it and no sample was changed"
    )


def _jitter(values: RealArray, places: Indices, step: Second, off: RealArray) -> tuple[str, str]:
    """Return whether stamps that stray by less than half a step are wrong or the samples irregular, and why."""
    share, std = share_followed(values, off / step, places)
    sigma = float(np.sqrt(np.mean(off**2)))
    stray = f"they stray by {sigma:.2g} s rms and {np.max(np.abs(off)):.2g} s at most from a grid of {1 / step:.7g} Hz"
    if share > max(SIGNIFICANT * std, FOLLOWED):
        return "irregular stamps", f"{stray}, and the samples follow them (by {share:.2f} ± {std:.2g} of the way)"
    pace = np.diff(values, axis=1)
    speed = np.sqrt(_mean(pace**2, np.isfinite(pace), axis=1)) / step * sigma
    there = np.isfinite(values)
    about = values - _mean(values, there, axis=1)[:, None]
    motion = np.sqrt(_mean(about**2, there, axis=1))
    error = float(np.max(speed / np.where(motion > 0, motion, np.inf)))
    return "jittering stamps", (
        f"{stray}; the samples do not follow them ({share:.2f} ± {std:.2g} of the way), or are too rough to tell: "
        f"a regular clock with late stamps was assumed and no sample was changed (were the stamps right, it would err "
        f"by {100 * error:.2g} % of the motion, rms, noise included)"
    )


def _mean(values: RealArray, known: NDArray[np.bool_], *, axis: int) -> RealArray:
    """Return the mean of what is known; 0 where nothing is."""
    return np.asarray(np.where(known, values, 0.0).sum(axis=axis) / np.maximum(known.sum(axis=axis), 1))


def share_followed(values: RealArray, off: RealArray, places: Indices) -> tuple[float, float]:
    """Return how far the samples follow the stamps off the grid, 0 not at all and 1 all the way, and its std.

    The cubic through two neighbours on each side misses a sample of a smooth motion by its slope times
    how far its time lies off those of its neighbours: the regression on that is the share. In noise it tends
    to zero.

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
    whole = whole[:: max(1, whole.size // 200_000)]
    before, last, now, after, second = (values[:, whole + k] for k in range(5))
    missed = now - (4 * (last + after) - before - second) / 6
    slope = (8 * (after - last) - (second - before)) / 12
    lead = off[whole + 2] - (4 * (off[whole + 1] + off[whole + 3]) - off[whole] - off[whole + 4]) / 6
    known = np.isfinite(missed)
    size = np.sqrt(_mean(missed**2, known, axis=1))[:, None]
    usable = known & (size > 0)
    missed = np.where(usable, missed, 0.0) / np.where(size > 0, size, 1.0)
    expected = np.where(usable, slope * lead, 0.0) / np.where(size > 0, size, 1.0)
    power = float(np.sum(expected**2))
    if not power > 0:
        return 0.0, np.inf
    share = float(np.sum(missed * expected)) / power
    # Neighbouring misses share samples, which counts twice at most.
    return share, float(np.sqrt(2 * np.sum((expected * (missed - share * expected)) ** 2))) / power


def _irregular(times: RealArray, rows: Indices, rate: Hertz | None, findings: tuple[Finding, ...], text: str) -> Clock:
    steps = np.diff(times)
    usual = float(np.median(steps))
    step = float(np.mean(steps[steps <= WIDE * usual])) if rate is None else 1 / rate
    if np.sum(steps[steps > WIDE * step]) > HOLLOW * (times[-1] - times[0]):
        raise RecordError(_hollow(steps, WIDE * step))
    count = int(np.floor((times[-1] - times[0]) / step * (1 + 1e-12))) + 1
    said = found(
        "irregular stamps",
        times,
        times.size,
        f"{text}; the samples were interpolated (cubic spline) onto a grid of {1 / step:.7g} Hz",
    )
    timepts = np.asarray(times[0] + step * np.arange(count))
    return Clock(timepts=timepts, rows=rows, stamps=times, places=None, findings=(*findings, said))


def _hollow(steps: RealArray, wide: Second) -> str:
    share = 100 * float(np.sum(steps[steps > wide])) / max(float(np.sum(steps)), SHORTEST)
    longest = int(np.argmax(steps))
    return (
        f"the time stamps are too irregular for a uniform record: half of the steps are below "
        f"{np.median(steps):.3g} s, but {share:.2g} % of the time lies in steps above {wide:.3g} s, the longest "
        f"{steps[longest]:.3g} s after row {longest + 1}; record at a constant rate, or take a stretch without such "
        f"holes (start, stop)"
    )


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


def _is_uniform(stamps: RealArray) -> bool:
    try:
        uniform_step(stamps)
    except RecordError:
        return False
    return True


def found(kind: str, where: RealArray, samples: int, text: str, *, repaired: bool = True) -> Finding:
    """Return a finding of time."""
    return Finding(
        kind=kind,
        channel="",
        start=float(np.min(where)),
        stop=float(np.max(where)),
        samples=samples,
        text=text,
        repaired=repaired,
    )
