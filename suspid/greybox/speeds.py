"""Speed, braking and cornering of a car, block by block."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from suspid.errors import InputError
from suspid.greybox.channel_words import (
    LATERAL_WORDS,
    LONGITUDINAL_WORDS,
    OTHER_WORDS,
    PLAIN_WORDS,
    SPEED_WORDS,
    WITHIN_WORDS,
    YAW_WORDS,
    words_of,
)
from suspid.greybox.held_speed import released
from suspid.greybox.level_axes import about_vertical, horizontal
from suspid.greybox.stated_units import in_si, spelled, stated_unit
from suspid.recordings import RawChannel, Recording
from suspid.units import ROAD_SPEEDS, MetrePerSecond, MetrePerSecond2, RealArray
from suspid.values import listed
from suspid.wording import Argument, Wording

# No road car is faster; larger values are what buses send for a speed that is not known.
FASTEST_CAR: MetrePerSecond = 120.0
# No road car brakes or pulls away harder: what falls faster to a value below zero is what a bus sends instead of a
# speed.
HARDEST: MetrePerSecond2 = 15.0
# Channels of speed have steps of 1 mph or finer ones.
COARSEST_STEP: MetrePerSecond = 0.5
# Of the units of speed km/h has the largest numbers: of 1 m/s.
KMH = 3.6
# A value counts as known for this many steps of its channel, but for at least this time: longer ones are tunnels.
KNOWN_STEPS, KNOWN_FOR = 3.0, 2.0
NO_CHANNEL = "none"  # asks for no channel, as with time


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Way:
    """Channels of the motion along the way, in SI units; None where there is none."""

    speed: RawChannel | None
    longitudinal: RawChannel | None
    lateral: RawChannel | None
    yaw: RawChannel | None
    # A channel that is named like a speed and was not used, and why.
    unused: tuple[str, Wording] | None = None
    unread: RawChannel | None = None  # that channel, where only its unit is not known
    upright: bool = False  # whether the yaw rate was known by its axis, which gravity shows, and not by its name
    by_unit: bool = False  # whether the speed was known by its unit alone
    by_axis: tuple[str, ...] = ()  # accelerations along and across that were known by their axes, not by their names

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels, and of one that was meant as such."""
        every = (self.speed, self.longitudinal, self.lateral, self.yaw)
        named = tuple(channel.name for channel in every if channel is not None)
        return named if self.unused is None else (*named, self.unused[0])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Going:
    """Motion along the way by block; NaN where it is not known."""

    speed: RealArray  # [m/s]
    longitudinal: RealArray  # [m/s2]
    lateral: RealArray  # [m/s2]
    unread: RealArray  # what may be the speed, in the unit of the file


def way_of(
    recording: Recording,
    *,
    speed: str | None,
    speed_unit: str | None,
    longitudinal: str | None,
    lateral: str | None,
    without: Iterable[str],
) -> Way:
    """Return the channels of the motion along the way: those that are named, else those whose name and unit say so.

    Raises
    ------
    InputError
        If a named channel has no suitable unit or contains no speed, or the given unit is not one of speed.
    """
    if speed_unit is not None and spelled(speed_unit, "m/s") is None:
        raise InputError(Argument("speed_unit", speed_unit), " is not a unit of speed; known: km/h, m/s, mph, kn")
    free = [channel for channel in recording.channels if channel.name not in set(without)]

    def chosen(name: str | None, words: frozenset[str], si: str, unit: str | None = None) -> RawChannel | None:
        if name == NO_CHANNEL:
            return None
        if name is not None:
            return in_si(recording[name], si, unit)
        others = WITHIN_WORDS if si == "m/s" else OTHER_WORDS
        named = [c for c in free if words_of(c.name) & words and not words_of(c.name) & others]
        fit = [c for c in named if stated_unit(c, unit if si == "m/s" else None, si) is not None]
        best = min(fit, key=lambda c: len(words_of(c.name)), default=None)
        return None if best is None else in_si(best, si, unit if si == "m/s" else None)

    moving = chosen(speed, SPEED_WORDS, "m/s", speed_unit)
    by_unit = moving is None and speed is None and _unused(None, free, None) is None
    several = None
    if by_unit:
        moving, several = _by_unit(free)
    if speed_unit is not None and moving is None and speed != NO_CHANNEL:
        raise InputError(
            Argument("speed_unit", speed_unit),
            " needs a speed channel, and none was found; name it with ",
            Argument("speed"),
        )
    moving = None if moving is None else released(directed(moving))
    unused = several or _unused(moving, free, speed)
    yaw, upright = chosen(None, YAW_WORDS, "rad/s"), about_vertical(free)
    along, across = chosen(longitudinal, LONGITUDINAL_WORDS, "m/s2"), chosen(lateral, LATERAL_WORDS, "m/s2")
    along = along or _plain(free, longitudinal, across)
    first, second = horizontal(recording.channels, without)
    first = None if longitudinal is not None or along is not None else first
    second = None if lateral is not None or across is not None else second
    return Way(
        speed=None if unused else moving,
        unused=unused,
        unread=None if unused is None or moving is not None else recording[unused[0]],
        longitudinal=along or first,
        lateral=across or second,
        yaw=yaw or upright,
        upright=yaw is None and upright is not None,
        by_unit=by_unit and moving is not None and not unused,
        by_axis=tuple(one.name for one in (first, second) if one is not None),
    )


def _plain(free: Iterable[RawChannel], asked: str | None, across: RawChannel | None) -> RawChannel | None:
    """Return the only channel that is called an acceleration and no more, where that across the car has a name."""
    if asked is not None or across is None:
        return None
    called = [
        c for c in free if {"acceleration", "accel", "acc"} & words_of(c.name) and words_of(c.name) <= PLAIN_WORDS
    ]
    known = [c for c in called if stated_unit(c, None, "m/s2") is not None]
    return in_si(known[0], "m/s2", None) if len(known) == 1 else None


def _by_unit(channels: Iterable[RawChannel]) -> tuple[RawChannel | None, tuple[str, Wording] | None]:
    """Return the only channel in a unit in which nothing but the speed of a vehicle is stated; or why it is none.

    A speed that never changes is a setting.
    """
    stated = [c for c in channels if not words_of(c.name) & WITHIN_WORDS and stated_unit(c, None, "m/s") in ROAD_SPEEDS]
    changing = [c for c in stated if np.nanmin(c.values, initial=np.inf) < np.nanmax(c.values, initial=-np.inf)]
    if len(changing) > 1:
        first, *others = [c.name for c in changing]
        choice = Wording((f"{listed(others)} may be it as well; choose one, such as ", Argument("speed", repr(first))))
        return None, (first, choice)
    return (in_si(changing[0], "m/s", None) if changing else None), None


def _unused(moving: RawChannel | None, free: Iterable[RawChannel], asked: str | None) -> tuple[str, Wording] | None:
    """Return a channel that may be meant as the speed and cannot be used, and why; refuse one that was asked for."""
    if moving is None:
        words = SPEED_WORDS - {"velocity"}  # a velocity without a unit may be that of the body
        alike = [c.name for c in free if words_of(c.name) & words and not words_of(c.name) & WITHIN_WORDS]
        if not alike or asked is not None:
            return None
        unit = Argument("speed_unit", repr("km/h"))
        return alike[0], Wording(("no unit of speed is stated for it; state it, such as ", unit))
    if np.any((moving.values >= 0) & (moving.values <= FASTEST_CAR)):
        return None
    why = f"it contains no value between 0 and {FASTEST_CAR:g} m/s"
    if asked is not None:
        raise InputError(f"channel {moving.name!r} is not a speed: {why}")
    return moving.name, Wording((why,))


def going(way: Way, edges: RealArray) -> Going:
    """Return the motion along the way in the blocks between edges [s]."""
    nothing = np.full(len(edges) - 1, np.nan)
    v = nothing if way.speed is None else by_block(way.speed, edges, low=0.0, high=FASTEST_CAR)
    # The harder of the changes to the block before and to the one behind: a speed may come late by a block.
    change = np.abs(np.diff(v)) / np.diff(edges)[1:]
    along = np.fmax(np.append(np.nan, change), np.append(change, np.nan)) if len(v) > 1 else nothing
    if way.longitudinal is not None:
        along = np.fmax(along, np.abs(_about_usual(by_block(way.longitudinal, edges))))
    across = nothing
    if way.lateral is not None:
        across = np.abs(_about_usual(by_block(way.lateral, edges)))
    if way.yaw is not None:
        across = np.fmax(across, np.abs(v * _about_usual(by_block(way.yaw, edges))))
    unread = nothing if way.unread is None else by_block(way.unread, edges, low=0.0, high=FASTEST_CAR * KMH)
    return Going(speed=v, longitudinal=along, lateral=across, unread=unread)


def directed(channel: RawChannel) -> RawChannel:
    """Return a speed without its sign, which is that of the direction; values that no car can reach become unknown.

    Cars back, and some sensors count backwards. A value below zero is a speed where it is reached as cars reach speeds,
    in steps of the channel or by accelerations that are possible, and where it changes. One that a bus sends for a
    speed that is not known is jumped to, and stays.

    Examples
    --------
    >>> t = np.arange(8) / 10
    >>> values = np.array([0.5, 0.0, -0.4, -0.9, -0.3, 0.2, -9.0, -9.0])
    >>> directed(RawChannel(name="speed", unit="m/s", timepts=t, values=values, rate=None)).values.tolist()
    [0.5, 0.0, 0.4, 0.9, 0.3, 0.2, nan, nan]
    """
    t, v = channel.timepts, np.array(channel.values, float)
    good = np.flatnonzero(np.isfinite(t) & np.isfinite(v) & (np.abs(v) <= FASTEST_CAR))
    below = v[good] < 0
    if not np.any(below):
        return channel
    bounds = np.flatnonzero(np.diff(np.concatenate([[False], below, [False]])))
    for first, after in zip(bounds[::2], bounds[1::2], strict=True):
        inside = good[first:after]
        pairs = [(good[i], good[i + 1]) for i in (first - 1, after - 1) if 0 <= i < len(good) - 1]
        jumps = [(abs(v[b] - v[a]), abs(t[b] - t[a])) for a, b in pairs]
        by_step = bool(jumps) and all(jump <= COARSEST_STEP for jump, _ in jumps)
        by_car = all(jump <= HARDEST * time + COARSEST_STEP for jump, time in jumps) and len(np.unique(v[inside])) > 1
        v[inside] = -v[inside] if by_step or by_car else np.nan
    return replace(channel, values=v)


def by_block(channel: RawChannel, edges: RealArray, *, low: float = -np.inf, high: float = np.inf) -> RealArray:
    """Return the mean of a channel in each block; interpolated where it is slower, NaN where it is lost.

    Examples
    --------
    >>> t = np.array([0.0, 2.0, 4.0, 30.0])
    >>> speed = RawChannel(name="speed", unit="m/s", timepts=t, values=np.array([0.0, 2.0, 4.0, -1.0]), rate=None)
    >>> by_block(speed, np.arange(7.0), low=0.0)
    array([0.5, 1.5, 2.5, 3.5, 4. , 4. ])
    """
    good = np.isfinite(channel.timepts) & (channel.values >= low) & (channel.values <= high)
    order = np.argsort(channel.timepts[good], kind="stable")
    t, y = channel.timepts[good][order], channel.values[good][order]
    blocks = len(edges) - 1
    if not t.size:
        return np.full(blocks, np.nan)
    middle = 0.5 * (edges[:-1] + edges[1:])
    at = np.searchsorted(edges, t, side="right") - 1
    inside = (at >= 0) & (at < blocks)
    number = np.bincount(at[inside], minlength=blocks)
    mean = np.bincount(at[inside], weights=y[inside], minlength=blocks) / np.maximum(number, 1)
    between = np.interp(middle, t, y)
    step = float(np.median(np.diff(t))) if t.size > 1 else 0.0
    after = np.clip(np.searchsorted(t, middle), 0, t.size - 1)
    nearest = np.minimum(np.abs(t[after] - middle), np.abs(t[np.maximum(after - 1, 0)] - middle))
    between[nearest > max(KNOWN_FOR, KNOWN_STEPS * step)] = np.nan
    # A single sample in a block stands for its own time, not for the block.
    return np.where(number > 1, mean, between)


def _about_usual(values: RealArray) -> RealArray:
    """Return values less their median: a tilted sensor shows a part of gravity, and a drive is straight on average."""
    return np.asarray(values - np.nanmedian(values)) if np.any(np.isfinite(values)) else values
