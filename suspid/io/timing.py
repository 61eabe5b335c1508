"""Timing: which column of a table is time, which channels follow it, and which have clocks of their own."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence

import numpy as np

from suspid.errors import RecordError
from suspid.io.tables import PER_SECOND, Table, TimeBase, is_time, split_unit
from suspid.recordings import RawChannel, Recording
from suspid.units import Hertz, RealArray
from suspid.words import LeftOut, Number, Remark

# A rate stored in single precision, or as a rounded step, is still the same rate.
SAME_RATE = 1e-6
# Least size of a stamp since 1970, by its unit: those of our time lie near 1.7e12 ms, 1.7e15 us and 1.7e18 ns.
EPOCHS = (("ns", 1e17), ("us", 1e14), ("ms", 1e11))


def as_recording(
    table: Table,
    *,
    channels: Sequence[str] | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
    title: str = "",
) -> Recording:
    """Return the channels of a table, each with its stamps; see `suspid.read_recording`.

    Raises
    ------
    RecordError
        If a column is not there, nothing tells the time, or channels and time differ in length.

    Examples
    --------
    >>> import numpy as np
    >>> sizes = {"t [ms]": 3, "seat": 3}
    >>> table = Table(sizes=sizes, columns=lambda names: [np.arange(3.0) for _ in names], unusable={}, rates={})
    >>> as_recording(table)["seat"].timepts
    array([0.   , 0.001, 0.002])
    """
    if fs is not None and not (np.isfinite(fs) and fs > 0):
        raise RecordError(f"{fs=} Hz must be positive and finite")
    names = [table.full_name(name, what="channel") for name in channels or ()]
    clocks = {name: table.clocks[name] for name in table.sizes if name in table.clocks}
    by_name = time in {clock.name for clock in clocks.values()} - set(table.sizes)
    if by_name:
        clocks, time = {name: clock for name, clock in clocks.items() if clock.name == time}, None
    elif time is not None:
        clocks, time = {}, table.full_name(time, what="time column")
    passed_over: dict[str, Remark] = {}
    if time is None and not by_name and not (names and all(name in clocks for name in names)):
        time, passed_over = _time_column(table, names, clocks, fs)
    rate = _rate(table, fs)
    chosen = (
        names or (list(clocks) if by_name else []) or _all_channels(table, time, {*clocks, *passed_over}, clocks, rate)
    )
    for name in chosen:
        if name == time or chosen.count(name) > 1:
            raise RecordError(f"column {name!r} is asked for twice")
    followers = [name for name in chosen if name not in clocks]
    _check_followers(table, followers, time, rate)
    follow_time = [time] if time is not None and followers else []
    # All at once: a text file is read but once.
    columns = dict(zip([*follow_time, *chosen], table.columns([*follow_time, *chosen]), strict=True))
    if time is not None and followers:
        stamps = _in_seconds(table, time, columns[time])
    else:
        stamps = np.arange(table.sizes[followers[0]]) / (rate or 1.0) if followers else np.empty(0)
    stamps.flags.writeable = False
    by_clock: dict[int, RealArray] = {}
    for name in chosen:
        if name in clocks and id(clocks[name]) not in by_clock:
            by_clock[id(clocks[name])] = _stamps(clocks[name], table.sizes[name], fs)
    raw = []
    for name in chosen:
        clock = clocks.get(name)
        own = rate if clock is None else clock.rate
        raw.append(
            RawChannel(
                name=name,
                unit=table.units.get(name, ""),
                timepts=stamps if clock is None else by_clock[id(clock)],
                values=columns[name],
                rate=fs if own is None else own,
            )
        )
    left_out = dict(table.unusable)
    if time is not None and followers and not _unit(table, time) and _epoch_unit(columns[time]) != "s":
        left_out[f"unit of {time!r}"] = Remark(LeftOut.EPOCH, {"unit": _epoch_unit(columns[time])})
    for name in [] if channels else [name for name in table.sizes if name not in chosen and name != time]:
        left_out[name] = passed_over.get(name) or _why_left_out(table, name, time)
    return Recording(title=table.title or title, channels=tuple(raw), left_out=tuple(left_out.items()))


def _check_followers(table: Table, names: Sequence[str], time: str | None, rate: Hertz | None) -> None:
    """Refuse channels without a clock of their own where nothing tells their time, or it is not as long."""
    if names and time is None and rate is None:
        raise RecordError(
            f"no column is named like a time: {', '.join(map(repr, table.sizes))}; name one (time), or give the "
            f"sampling rate (fs){_increasing(table)}"
        )
    for name in names:
        reference = names[0] if time is None else time
        if table.sizes[name] != table.sizes[reference]:
            raise RecordError(
                f"channel {name!r} has {table.sizes[name]} samples, {reference!r} has {table.sizes[reference]}"
            )


def _stamps(clock: TimeBase, size: int, fs: Hertz | None) -> RealArray:
    """Return the stamps of a clock [s]."""
    if clock.stamps is not None:
        stamps = np.asarray(clock.stamps(), float)
        if stamps.size != size:
            raise RecordError(f"clock {clock.name!r} has {stamps.size} stamps for {size} samples")
        stamps.flags.writeable = False
        return stamps
    rate = clock.rate if clock.rate is not None else fs
    if rate is None:
        raise RecordError(f"nothing tells the rate of {clock.name!r}; give the sampling rate (fs)")
    if fs is not None and not abs(fs - rate) <= SAME_RATE * rate:
        raise RecordError(f"'fs' says {fs:g} Hz, {clock.name!r} in the file {rate:g} Hz; leave fs out")
    stamps = np.asarray(clock.start + np.arange(size) / rate)
    stamps.flags.writeable = False
    return stamps


def _why_left_out(table: Table, name: str, time: str | None) -> Remark:
    if time is not None and table.sizes[name] != table.sizes[time]:
        sizes: dict[str, Number] = {"samples": table.sizes[name], "time": time, "stamps": table.sizes[time]}
        return Remark(LeftOut.SIZE, sizes)
    return Remark(LeftOut.LIKE_TIME if is_time(name) else LeftOut.NO_TIME)


def _time_column(
    table: Table, channels: Sequence[str], clocks: Mapping[str, TimeBase], fs: Hertz | None
) -> tuple[str | None, dict[str, Remark]]:
    """Return the column of time, and which others tell the same."""
    candidates = [name for name in table.sizes if is_time(name) and name not in channels and name not in clocks]
    if len(candidates) > 1 and len({table.sizes[c] for c in channels}) == 1:
        # Vectors of another length are another record's time.
        candidates = [name for name in candidates if table.sizes[name] == table.sizes[channels[0]]]
    passed_over: dict[str, Remark] = {}
    # Telephones write the time of day and that since the start.
    while len(candidates) > 1 and _same_time(table, candidates[0], candidates[1]):
        starts = [abs(_in_seconds(table, name, table.columns([name])[0])[0]) for name in candidates[:2]]
        worse = candidates.pop(0 if starts[0] > starts[1] else 1)
        passed_over[worse] = Remark(LeftOut.SAME_TIME, {"other": candidates[0]})
    if len(candidates) > 1:
        also = "" if fs is None else ", even beside fs: it must agree"
        raise RecordError(f"{', '.join(map(repr, candidates))} all read like a time; name one (time){also}")
    return (candidates[0] if candidates else None), passed_over


def _same_time(table: Table, one: str, other: str) -> bool:
    """Whether two columns of time run alike but for their start."""
    if table.sizes[one] != table.sizes[other]:
        return False
    first, second = (_in_seconds(table, name, table.columns([name])[0]) for name in (one, other))
    with np.errstate(invalid="ignore"):
        apart = np.abs((first - first[:1]) - (second - second[:1]))
        step = np.median(np.abs(np.diff(second)))
    return bool(step > 0 and np.all(apart <= step / 2))


def _increasing(table: Table) -> str:
    """Return a hint at a column of numbers that increases from row to row."""
    for name in list(table.sizes)[:1]:
        with contextlib.suppress(RecordError):
            if table.sizes[name] > 2 and np.all(np.diff(table.columns([name])[0]) > 0):
                return f"; {name!r} increases as a time does"
    return ""


def _all_channels(
    table: Table, time: str | None, apart: set[str], clocks: Mapping[str, TimeBase], rate: Hertz | None
) -> list[str]:
    others = [name for name in table.sizes if name != time and name not in apart]
    if time is not None:
        others = [name for name in others if table.sizes[name] == table.sizes[time]]
        if not others and not clocks:
            why = "".join(f"; {name!r} {reason}" for name, reason in list(table.unusable.items())[:4])
            raise RecordError(f"there is no channel as long as time, {time!r}: {table.sizes[time]} samples{why}")
    elif clocks and rate is None:
        others = []
    elif len({table.sizes[name] for name in others}) > 1:
        sizes = ", ".join(f"{name!r} {table.sizes[name]}" for name in others)
        raise RecordError(f"the vectors differ in length ({sizes}); say which are channels")
    return [name for name in table.sizes if name in clocks or name in others]


def _rate(table: Table, fs: Hertz | None) -> Hertz | None:
    """Return the rate that was given and the file states, which must be one."""
    rates = dict(table.rates) if fs is None else {"fs": fs, **table.rates}
    if not rates:
        return None
    given, rate = next(iter(rates.items()))
    for name, other in rates.items():
        if not abs(other - rate) <= SAME_RATE * rate:
            raise RecordError(f"{given!r} says {rate:g} Hz, {name!r} in the file {other:g} Hz; correct one of them")
    return rate


def _unit(table: Table, time: str) -> str:
    return table.units.get(time, "").strip().lower() or split_unit(time)[1]


def _in_seconds(table: Table, time: str, stamps: RealArray) -> RealArray:
    """Return the numbers of a column of time in seconds."""
    unit = _unit(table, time) or _epoch_unit(stamps)
    if unit not in PER_SECOND:
        raise RecordError(f"the unit of time in {time!r} is not known; known: s, ms, us, ns, min; or give fs alone")
    return np.asarray(stamps / PER_SECOND[unit])


def _epoch_unit(stamps: RealArray) -> str:
    """Return the unit of stamps without one: s, unless they were then years above 4000."""
    size = float(np.nanmax(np.abs(stamps), initial=0.0))
    return next((name for name, least in EPOCHS if size > least), "s")
