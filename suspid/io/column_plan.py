"""The plan of a table: which columns are channels, and the source of their time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from suspid.errors import RecordError
from suspid.io.names import (
    is_time,
    is_time_in_unknown_unit,
)
from suspid.io.tables import Table, TimeBase
from suspid.io.time_columns import NO_SPECTRA, increasing, over_frequency, time_column, time_names
from suspid.io.time_units import unknown_unit
from suspid.levels import SEVEN_DIGITS
from suspid.units import Hertz
from suspid.values import listed
from suspid.wording import Argument
from suspid.words import LeftOut, Number, Remark

# In place of the name of a column of time: no column is.
NO_TIME = "none"


@dataclass(frozen=True, kw_only=True, slots=True)
class ColumnPlan:
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


def plan_of(table: Table, channels: Sequence[str] | None, time: str | None, fs: Hertz | None) -> ColumnPlan:
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
        if over_frequency(table, time):
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
    plan = ColumnPlan(channels=tuple(chosen), time=time, clocks=clocks, rate=rate, left_out=left_out)
    _check_followers(table, plan.followers, time, rate)
    if channels:
        return replace(plan, left_out={})
    others = [name for name in table.sizes if name not in often and name != time]
    why = {name: left_out.get(name) or _why_left_out(table, name, plan) for name in others}
    return replace(plan, left_out={**why, **{name: left_out[name] for name in (time,) if name in left_out}})


def _check_followers(table: Table, names: Sequence[str], time: str | None, rate: Hertz | None) -> None:
    """Refuse channels without a time base where no time or rate is known, or time has another length."""
    unclear = [name for name in table.sizes if is_time_in_unknown_unit(name)]
    if names and time is None and rate is None and unclear:
        raise RecordError(unknown_unit(unclear[0]))
    taken = [name for name in names if is_time(name)]
    if taken and time is None and rate is None:
        raise RecordError(
            f"{taken[0]!r} is the time of the other columns, and no channel: leave it out of ({Argument('channels')})"
        )
    if names and time is None and rate is None:
        stamps = {n: why for n, why in table.unusable.items() if is_time(n) or why.code is LeftOut.ODD_STAMPS}
        odd = "".join(f"; {name!r} {why}" for name, why in stamps.items())
        named = f"name one ({Argument('time')}), or " if len(table.sizes) > 1 else ""
        raise RecordError(
            f"no column is named like a time: {listed(list(table.sizes))}; {named}give the sampling rate "
            f"({Argument('fs')}){odd or increasing(table)}"
        )
    for name in names:
        reference = names[0] if time is None else time
        if table.sizes[name] != table.sizes[reference]:
            raise RecordError(
                f"channel {name!r} has {table.sizes[name]} samples, {reference!r} has {table.sizes[reference]}"
            )


def _why_left_out(table: Table, name: str, plan: ColumnPlan) -> Remark:
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
            why = _turned(table, table.sizes[time]) + why
            raise RecordError(f"no channel is as long as time, {time!r}: {table.sizes[time]} samples{why}")
    elif clocks and rate is None:
        others = []
    else:
        others = _of_one_length(table, others)
    chosen = {*clocks, *others}
    return [name for name in table.sizes if name in chosen]


def _turned(table: Table, size: int) -> str:
    """Return a hint at matrices with as many columns as time has stamps: their shorter axis is time."""
    columns = Counter(name.rpartition("[")[0] for name in table.sizes if name.endswith("]"))
    longs = {name: table.sizes.get(f"{name}[1]", 0) for name, often in columns.items() if often == size}
    return "".join(
        f"; {name!r} is {size} x {long}, with time along the shorter axis: save a vector for each channel"
        for name, long in longs.items()
    )


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
