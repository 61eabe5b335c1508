"""Timing: which columns of a table are channels, and the time of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.errors import RecordError
from suspid.io.limits import metered
from suspid.io.names import (
    PER_SECOND,
    counts_rows,
    is_abscissa,
    is_count,
    is_frequency,
    is_time,
    is_time_in_unknown_unit,
)
from suspid.io.runs import runs_of
from suspid.io.side_tables import of_side_tables
from suspid.io.tables import Table, TimeBase
from suspid.io.time_columns import NO_SPECTRA, increasing, time_column, time_names
from suspid.io.time_units import FEW_STAMPS, in_seconds, time_unit, unit_remark, unknown_unit
from suspid.levels import SEVEN_DIGITS
from suspid.recordings import RawChannel, Recording
from suspid.units import Hertz, RealArray
from suspid.values import check_rate, listed
from suspid.wording import Argument
from suspid.words import LeftOut, Number, Remark

# Stamps whose mean rate is further than this share from a stated one run at another.
OTHER_PACE = 0.02
# In place of the name of a column of time: no column is.
NO_TIME = "none"


@dataclass(frozen=True, kw_only=True, slots=True)
class _Plan:
    """The channels of a table, and the source of their time."""

    channels: tuple[str, ...]
    # The column of time of the channels without a clock.
    time: str | None
    clocks: Mapping[str, TimeBase]
    # Sampling rate of the channels without a clock [Hz], given or stated.
    rate: Hertz | None
    # Columns that are neither, and why.
    left_out: Mapping[str, Remark]

    @property
    def followers(self) -> list[str]:
        """Channels without a clock of their own."""
        return [name for name in self.channels if name not in self.clocks]


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
    table = metered(table, size)
    plan = _plan(table, channels, time, fs)
    followers = plan.followers
    times = [plan.time] if plan.time is not None and followers else []
    # All at once: a text file is read only once.
    columns = dict(zip([*times, *plan.channels], table.columns([*times, *plan.channels]), strict=True))
    if times and counts_rows(times[0], columns[times[0]]):
        plan, times = _without_counter(plan, times[0]), []
    left_out = {**table.unusable, **plan.left_out}
    counters = [] if channels else _counters(plan, columns)
    norms = {} if channels else {**_magnitudes(plan, columns), **of_side_tables(plan.followers, columns)}
    left_out |= {**dict.fromkeys(counters, Remark(LeftOut.ROW_COUNTER)), **norms}
    for name, other in table.rates.items():
        if fs is not None and not abs(fs - other) <= SEVEN_DIGITS * other:
            left_out[f"rate {name!r}"] = Remark(LeftOut.OTHER_RATE, {"rate": other, "fs": fs})
    stamps = np.empty(0)
    if times:
        stamps = in_seconds(table, times[0], columns[times[0]])
        if not time_unit(table, times[0]) and (said := unit_remark(columns[times[0]])):
            left_out[f"unit of {times[0]!r}"] = said
            stamps = stamps / PER_SECOND[str(said.numbers["unit"])] if said.code is LeftOut.FINER_UNIT else stamps
        plan, outvoted = _outvoted(table, plan, stamps, fs)
        left_out |= outvoted
    elif followers:
        stamps = np.arange(table.sizes[followers[0]]) / (plan.rate or 1.0)
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
                unit=table.units.get(name, ""),
                timepts=times_of,
                values=columns[name][: times_of.size],
                rate=own if fs is None else fs,
            )
        )
    kept = tuple(channel for channel in raw if channel.name not in counters and channel.name not in norms)
    if table.apart:
        tests = runs_of({channel.name: id(channel.timepts) for channel in kept})
        kept = tuple(replace(channel, test=tests.get(channel.name, "")) for channel in kept)
    return Recording(title=table.title or title, channels=kept, left_out=tuple(left_out.items()))


def _check_names(channels: object, time: object) -> None:
    if channels is not None:
        known = isinstance(channels, list | tuple) or hasattr(channels, "__iter__")
        names = list(channels) if known else []  # type: ignore[call-overload]
        if not names or not all(isinstance(name, str) for name in names):
            raise RecordError(Argument("channels", f"{channels!r:.80}"), " must be names of channels, or left out")
    if time is not None and not isinstance(time, str):
        raise RecordError(Argument("time", f"{time!r:.40}"), " must be the name of the column of time")


def _plan(table: Table, channels: Sequence[str] | None, time: str | None, fs: Hertz | None) -> _Plan:
    """Return the channels and the source of their time; refuse what does not fit together."""
    names = [table.full_name(name, what="channel") for name in channels or ()]
    clocks = {name: table.clocks[name] for name in table.sizes if name in table.clocks}
    left_out: dict[str, Remark] = {}
    by_clock: list[str] = []
    if time == NO_TIME and NO_TIME not in table.sizes:
        # Stamps are ignored; a clock that only states a rate holds where no other rate is given.
        clocks = {name: clock for name, clock in clocks.items() if clock.stamps is None and fs is None}
        left_out = {n: Remark(LeftOut.IGNORED_TIME) for n in time_names(table) if n not in [*clocks, *names]}
        time = None
    elif time in {clock.name for clock in clocks.values()} - set(table.sizes):
        clocks = {name: clock for name, clock in clocks.items() if clock.name == time}
        by_clock, time = list(clocks), None
    elif time is not None:
        clocks, time = {}, table.full_name(time, what="time column")
        if is_frequency(time):
            raise RecordError(f"{time!r} holds frequencies and no time: {NO_SPECTRA}")
    elif not (names and all(name in clocks for name in names)):
        time, own, left_out = time_column(table, names, clocks, fs)
        clocks |= own
    rate = _rate(table, fs)
    chosen = names or by_clock or _all_channels(table, time, {*clocks, *left_out}, clocks, rate)
    often = Counter(chosen)
    for name in chosen:
        if name == time or often[name] > 1:
            raise RecordError(f"column {name!r} is requested twice")
    plan = _Plan(channels=tuple(chosen), time=time, clocks=clocks, rate=rate, left_out=left_out)
    _check_followers(table, plan.followers, time, rate)
    if channels:
        return replace(plan, left_out={})
    others = [name for name in table.sizes if name not in often and name != time]
    why = {name: left_out.get(name) or _why_left_out(table, name, plan) for name in others}
    return replace(plan, left_out={**why, **{name: left_out[name] for name in (time,) if name in left_out}})


def _without_counter(plan: _Plan, time: str) -> _Plan:
    """Return the plan without a column of time that counts the rows, or refuse it where no rate is known."""
    if plan.rate is None:
        raise RecordError(f"{time!r} counts the rows, not time; give the sampling rate ({Argument('fs')})")
    return replace(plan, time=None, left_out={**plan.left_out, time: Remark(LeftOut.ROW_COUNTER)})


def _counters(plan: _Plan, columns: Mapping[str, RealArray]) -> list[str]:
    """Return the channels that count the rows by their names, and a first one without a name that does so."""
    counters = [name for name in plan.followers if counts_rows(name, columns[name])]
    first = next(iter(plan.followers), "")
    unnamed = is_abscissa(first) and not first.endswith("]") and first not in counters
    # In a matrix, the column before the time counts the rows.
    unnamed |= first.endswith("[1]") and plan.time == f"{first.removesuffix('[1]')}[2]"
    if unnamed and columns[first].size >= FEW_STAMPS and is_count(columns[first]):
        counters.append(first)
    return [] if len(counters) == len(plan.channels) else counters


def _magnitudes(plan: _Plan, columns: Mapping[str, RealArray]) -> dict[str, Remark]:
    """Return the channels that are the magnitude of the three before them, as telephones add it: not linear in them."""
    found: dict[str, Remark] = {}
    for k in range(3, len(plan.channels)):
        name, axes = plan.channels[k], plan.channels[k - 3 : k]
        values = columns[name]
        if any(columns[axis].size != values.size for axis in axes) or not np.any(values > 0):
            continue
        norm = np.sqrt(np.sum([columns[axis] ** 2 for axis in axes], axis=0))
        with np.errstate(invalid="ignore"):
            apart = float(np.nanmax(np.abs(norm - values), initial=0.0))
        # Largest error of a magnitude that was computed from axes with more digits than the file has, relative to its
        # largest: half a unit of the last of three digits.
        if apart <= 5e-3 * float(np.nanmax(values)):
            found[name] = Remark(LeftOut.MAGNITUDE, {"axes": axes})
    return found


def _check_followers(table: Table, names: Sequence[str], time: str | None, rate: Hertz | None) -> None:
    """Refuse channels without a time base where no time or rate is known, or time has another length."""
    unclear = [name for name in table.sizes if is_time_in_unknown_unit(name)]
    if names and time is None and rate is None and unclear:
        raise RecordError(unknown_unit(unclear[0]))
    if names and time is None and rate is None:
        odd = "".join(f"; {name!r} {why}" for name, why in table.unusable.items() if is_time(name))
        raise RecordError(
            f"no column is named like a time: {listed(list(table.sizes))}; name one ({Argument('time')}), or give the "
            f"sampling rate ({Argument('fs')}){odd or increasing(table)}"
        )
    for name in names:
        reference = names[0] if time is None else time
        if table.sizes[name] != table.sizes[reference]:
            raise RecordError(
                f"channel {name!r} has {table.sizes[name]} samples, {reference!r} has {table.sizes[reference]}"
            )


def _outvoted(table: Table, plan: _Plan, stamps: RealArray, fs: Hertz | None) -> tuple[_Plan, dict[str, Remark]]:
    """Return the plan without a rate of the file at which its stamps do not run: rows were picked or averaged since."""
    known = stamps[np.isfinite(stamps)]
    if fs is not None or plan.rate is None or known.size < FEW_STAMPS or known[-1] <= known[0]:
        return plan, {}
    mean = (known.size - 1) / float(known[-1] - known[0])
    # Rounded stamps have another usual step than mean step, and so have those with gaps: of them the rate is believed.
    steady = abs(float(np.median(np.diff(known))) * mean - 1) < OTHER_PACE
    if not steady or abs(mean / plan.rate - 1) < OTHER_PACE:
        return plan, {}
    said = {
        f"rate {name!r}": Remark(LeftOut.OUTVOTED, {"rate": own, "stamps": mean}) for name, own in table.rates.items()
    }
    return replace(plan, rate=None), said


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


def _why_left_out(table: Table, name: str, plan: _Plan) -> Remark:
    samples = table.sizes[name]
    if plan.time is not None and samples != table.sizes[plan.time]:
        sizes: dict[str, Number] = {"samples": samples, "time": plan.time, "stamps": table.sizes[plan.time]}
        return Remark(LeftOut.SIZE, sizes)
    if is_time(name):
        return Remark(LeftOut.LIKE_TIME)
    if plan.rate is not None and plan.followers:
        return Remark(LeftOut.LENGTH, {"samples": samples, "others": table.sizes[plan.followers[0]]})
    return Remark(LeftOut.NO_TIME)


def _all_channels(
    table: Table, time: str | None, apart: set[str], clocks: Mapping[str, TimeBase], rate: Hertz | None
) -> list[str]:
    others = [name for name in table.sizes if name != time and name not in apart]
    if time is not None:
        others = [name for name in others if table.sizes[name] == table.sizes[time]]
        if not others and not clocks:
            why = "".join(f"; {name!r} {reason}" for name, reason in list(table.unusable.items())[:4])
            raise RecordError(f"no channel is as long as time, {time!r}: {table.sizes[time]} samples{why}")
    elif clocks and rate is None:
        others = []
    else:
        others = _of_one_length(table, others)
    chosen = {*clocks, *others}
    return [name for name in table.sizes if name in chosen]


def _of_one_length(table: Table, names: list[str]) -> list[str]:
    """Return the columns of the length that most of them have; refuse where no length has a majority."""
    lengths = Counter(table.sizes[name] for name in names)
    length, often = max(lengths.items(), key=lambda item: item[1], default=(0, 0))
    if 2 * often <= len(names) and len(lengths) > 1:
        sizes = ", ".join(f"{name!r} {table.sizes[name]}" for name in names)
        raise RecordError(f"the vectors differ in length ({sizes}); say which are channels")
    return [name for name in names if table.sizes[name] == length]


def _rate(table: Table, fs: Hertz | None) -> Hertz | None:
    """Return the rate that was given, or else the one that the file states."""
    rates = dict(table.rates)
    if fs is not None or not rates:
        return fs
    given, rate = next(iter(rates.items()))
    for name, other in rates.items():
        if not abs(other - rate) <= SEVEN_DIGITS * rate:
            raise RecordError(f"{given!r} says {rate:g} Hz, {name!r} in the file {other:g} Hz; correct one of them")
    return rate
