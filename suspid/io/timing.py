"""Timing: which columns of a table are channels, and the time of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from functools import partial

import numpy as np

from suspid.errors import RecordError
from suspid.io.column_plan import ColumnPlan, plan_of
from suspid.io.epochs import counted_from_first
from suspid.io.limits import metered
from suspid.io.names import (
    PER_SECOND,
    counts_rows,
    is_step,
    unit_in_name,
)
from suspid.io.newest_first import in_order, oldest_first
from suspid.io.not_motions import (
    counters_of,
    magnitudes,
    parts_of_seconds,
    repeated_times,
    single_numbers,
    temperatures,
)
from suspid.io.own_rows import with_own_rows
from suspid.io.parts import recording_of_parts
from suspid.io.restarts import with_restarts, with_rolled_on
from suspid.io.runs import runs_by_clock, runs_of
from suspid.io.side_tables import of_side_tables
from suspid.io.tables import Table, TimeBase, all_at_once
from suspid.io.time_units import FEW_STAMPS, guessed_unit, in_seconds, time_unit, too_fine
from suspid.levels import SEVEN_DIGITS
from suspid.recordings import RawChannel, Recording
from suspid.stamps import resolution
from suspid.units import Hertz, RealArray
from suspid.values import check_rate
from suspid.wording import Argument
from suspid.words import LeftOut, Remark

# Stamps whose mean rate is further than this share from a stated one run at another.
OTHER_PACE = 0.02
# Digits that a stated step may have: the inverse of its inverse has those again, and noise of doubles behind them.
STATED_DIGITS = 12


def as_recording(
    table: Table,
    *,
    channels: Sequence[str] | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
    title: str = "",
    size: int | None = None,
) -> Recording:
    """Return the channels of a table, each with its stamps; see `suspid.read_recording`.

    ``size`` is that of its file [bytes], by which the memory that is taken is limited.

    Examples
    --------
    >>> import numpy as np
    >>> sizes = {"t [ms]": 3, "seat": 3}
    >>> table = Table(sizes=sizes, columns=lambda names: [np.arange(3.0) for _ in names])
    >>> as_recording(table)["seat"].timepts
    array([0.   , 0.001, 0.002])
    """
    check_rate(fs)
    _check_names(channels, time)
    read = partial(_recording, time=time, fs=fs, title=title, size=size)
    return recording_of_parts(table, channels, time, read) if table.parts else read(table, channels)


def _recording(
    table: Table, channels: Sequence[str] | None, *, time: str | None, fs: Hertz | None, title: str, size: int | None
) -> Recording:
    """Return the channels of a table without parts."""
    table = metered(table if channels else all_at_once(table), size)
    plan = plan_of(table, channels, time, fs)
    followers = plan.followers
    times = [plan.time] if plan.time is not None and followers else []
    # All at once: a text file is read only once.
    columns = dict(zip([*times, *plan.channels], table.columns([*times, *plan.channels]), strict=True))
    if times and counts_rows(times[0], columns[times[0]]):
        plan, times = _without_counter(plan, times[0]), []
    columns, turned = oldest_first(columns, times[0], followers) if times else (columns, {})
    left_out = {**table.unusable, **plan.left_out, **turned}
    columns, rolled = with_rolled_on(columns, times)
    left_out |= rolled
    counters = [] if channels else counters_of(plan, columns)
    norms = {} if channels else {**magnitudes(plan, columns), **of_side_tables(plan.followers, columns)}
    norms |= {} if channels else {**single_numbers(plan, columns), **temperatures(plan, table.units)}
    left_out |= {**dict.fromkeys(counters, Remark(LeftOut.ROW_COUNTER)), **norms}
    for name, other in table.rates.items():
        if fs is not None and not abs(fs - other) <= SEVEN_DIGITS * other:
            left_out[f"rate {name!r}"] = Remark(LeftOut.OTHER_RATE, {"rate": other, "fs": fs})
    stamps = np.empty(0)
    if times:
        stamps = in_seconds(table, times[0], columns[times[0]])
        if time_unit(table, times[0]):
            said = too_fine(time_unit(table, times[0]), columns[times[0]])
        else:
            unit, said = guessed_unit(times[0], columns[times[0]], fs)
            stamps = stamps / PER_SECOND[unit]
        left_out |= {} if said is None else {f"unit of {times[0]!r}": said}
        plan, outvoted = _outvoted(table, plan, stamps, fs)
        parts = {} if channels else parts_of_seconds(plan, columns, stamps) | repeated_times(plan, columns)
        norms, left_out = norms | parts, left_out | outvoted | parts
    elif followers:
        stamps = table.start + np.arange(table.sizes[followers[0]]) / (plan.rate or 1.0)
    stamps.flags.writeable = False
    by_clock: dict[int, RealArray] = {}
    raw = []
    for name in plan.channels:
        clock = plan.clocks.get(name)
        if clock is not None and id(clock) not in by_clock:
            by_clock[id(clock)] = _stamps(clock, table.sizes[name], fs)
        own = plan.rate if clock is None else clock.rate
        if fs is not None and own is not None and clock is not None and not abs(fs - own) <= SEVEN_DIGITS * own:
            left_out[f"rate of {clock.name!r}"] = Remark(LeftOut.OTHER_RATE, {"rate": own, "fs": fs})
        times_of = stamps if clock is None else by_clock[id(clock)]
        raw.append(
            RawChannel(
                name=name,
                unit=table.units.get(name, "") or unit_in_name(name),
                timepts=times_of,
                values=columns[name][: times_of.size],
                rate=own if fs is None else fs,
            )
        )
    raw, turned = in_order(raw, plan.clocks)
    left_out |= turned
    raw = raw if fs is not None else with_own_rows(raw)
    kept = tuple(channel for channel in raw if channel.name not in counters and channel.name not in norms)
    kept, counted = counted_from_first(kept, next(iter(times), None))
    left_out |= counted
    if table.apart:
        tests = runs_of({channel.name: id(channel.timepts) for channel in kept}) or runs_by_clock(kept)
        kept = tuple(replace(channel, test=tests.get(channel.name, "")) for channel in kept)
        kept, apart = (kept, {}) if tests else with_restarts(kept, [*times, *(c.name for c in plan.clocks.values())])
        left_out |= apart
    return Recording(title=table.title or title, channels=kept, left_out=tuple(left_out.items()))


def _check_names(channels: object, time: object) -> None:
    if channels is not None:
        known = isinstance(channels, list | tuple) or hasattr(channels, "__iter__")
        names = list(channels) if known else []  # type: ignore[call-overload]
        if not names or not all(isinstance(name, str) for name in names):
            raise RecordError(Argument("channels", f"{channels!r:.80}"), " must be names of channels, or left out")
    if time is not None and not isinstance(time, str):
        raise RecordError(Argument("time", f"{time!r:.40}"), " must be the name of the column of time")


def _without_counter(plan: ColumnPlan, time: str) -> ColumnPlan:
    """Return the plan without a column of time that counts the rows, or refuse it where no rate is known."""
    if plan.rate is None:
        raise RecordError(f"{time!r} counts the rows, not time; give the sampling rate ({Argument('fs')})")
    return replace(plan, time=None, left_out={**plan.left_out, time: Remark(LeftOut.ROW_COUNTER)})


def _outvoted(
    table: Table, plan: ColumnPlan, stamps: RealArray, fs: Hertz | None
) -> tuple[ColumnPlan, dict[str, Remark]]:
    """Return the plan without a rate of the file at which its stamps do not run: rows were picked or averaged since."""
    known = stamps[np.isfinite(stamps)]
    if fs is not None or plan.rate is None or known.size < FEW_STAMPS or known[-1] <= known[0]:
        return plan, {}
    mean = (known.size - 1) / float(known[-1] - known[0])
    # Rounded stamps have another usual step than mean step, and so have those with gaps: of them the rate is believed.
    steps = np.diff(known)
    usual = float(np.median(steps))
    steady = abs(usual * mean - 1) < OTHER_PACE
    whole = float(np.max(steps)) < 1.5 * usual and float(np.min(steps)) > 0.5 * usual
    # The first stamp and the last are rounded: a step of the file within that is more exact than theirs.
    agree = abs(1 / mean - 1 / plan.rate) * (known.size - 1) <= resolution(known)
    if whole and not agree and abs(mean / plan.rate - 1) < OTHER_PACE and _rounds(table, mean):
        return replace(plan, rate=None), {}
    if not steady or abs(mean / plan.rate - 1) < OTHER_PACE:
        return plan, {}
    said = {
        f"rate {name!r}": Remark(LeftOut.OUTVOTED, {"rate": own, "stamps": mean}) for name, own in table.rates.items()
    }
    return replace(plan, rate=None), said


def _rounds(table: Table, mean: Hertz) -> bool:
    """Return whether every rate of a file is stated as a step of few digits, to which that of the stamps rounds.

    LabVIEW writes six decimals: of a step of 1/2048 s that is 0.000488, whose clock is 1.2 s late after an hour.
    """
    for name, rate in table.rates.items():
        if not is_step(name):
            return False
        digits = f"{1 / rate:.{STATED_DIGITS}g}"
        exponent = Decimal(digits).as_tuple().exponent
        # Half a unit of the last digit, and what the stamps are rounded by.
        if not isinstance(exponent, int) or abs(1 / mean - float(digits)) > 0.51 * 10.0**exponent:
            return False
    return bool(table.rates)


def _stamps(clock: TimeBase, size: int, fs: Hertz | None) -> RealArray:
    """Return the stamps of a clock [s]."""
    if clock.stamps is not None:
        stamps = np.asarray(clock.stamps(), float)
        if stamps.size != size and not (clock.cut and stamps.size < size):
            raise RecordError(f"clock {clock.name!r} has {stamps.size} stamps for {size} samples")
        stamps.flags.writeable = False
        return stamps
    rate = clock.rate if fs is None else fs
    if rate is None:
        raise RecordError(f"the rate of {clock.name!r} is not known; give the sampling rate ({Argument('fs')})")
    stamps = np.asarray(clock.start + np.arange(size) / rate)
    stamps.flags.writeable = False
    return stamps
