"""Runs: several tests inside one file, distinguished by the names and clocks of their channels."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from suspid.io.names import NUMBERED_LAST, NUMBERED_TEST, bare_name, plain
from suspid.recordings import RawChannel

# Between the parts of a name, such as those of a structure, of a group, or of a run of Logger Pro. Between digits they
# are part of a date, a time of day or a number.
SEPARATORS = re.compile(r"(?:(?<!\d)[.:/|]|[.:/|](?!\d))\s*")
# Names that number tests; channels of such groups may share a clock.
NUMBERED = re.compile(rf"{NUMBERED_TEST}|.*\[\d+\]", re.I)
# Clocks of one pace that end this far apart, in the length of the longest and in its steps, are those of several tests;
# sensors of one test end together. Clocks whose mean steps differ by more than this share are not of one pace.
ENDS_APART, STEPS_APART, PACES_APART = 0.02, 10, 0.2
# So far the ends of tests are apart whose names have no numbers: of two loggers, one may be stopped later.
NAMED_APART = 0.1


def runs_of(clocks: Mapping[str, int]) -> dict[str, str]:
    """Return the test of each channel, by its name and the number of its clock; empty if there is but one test.

    Groups of channels are tests of their own if they hold channels of the same names, and either no group shares its
    clock with another or their names number tests. A channel outside all groups belongs to the test of its clock.

    Examples
    --------
    >>> runs_of({"Fe.Out.Acc": 1, "Fe.Out.Pos": 1, "Al.Out.Acc": 2, "Al.Out.Pos": 2})
    {'Fe.Out.Acc': 'Fe', 'Fe.Out.Pos': 'Fe', 'Al.Out.Acc': 'Al', 'Al.Out.Pos': 'Al'}
    >>> runs_of({"front.acc": 1, "rear.acc": 1}), runs_of({"Run 1: z (m)": 1, "Run 2: z (m)": 1})["Run 2: z (m)"]
    ({}, 'Run 2')
    >>> runs_of({"Angle (rad) Run #1": 1, "Angle (rad) Run #2": 1})
    {'Angle (rad) Run #1': 'Run #1', 'Angle (rad) Run #2': 'Run #2'}
    >>> list(runs_of({"9/7/2012 6:58:23 PM - all/Dev1": 1, "9/7/2012 6:58:23 PM - means/Dev1": 2}).values())
    ['9/7/2012 6:58:23 PM - all', '9/7/2012 6:58:23 PM - means']
    """
    parts = _without_common({name: _parts(name) for name in clocks})
    groups: dict[str, dict[str, str]] = {}
    for name, (first, *rest) in parts.items():
        if rest:
            groups.setdefault(first, {})[name] = ".".join(rest)
    if len(groups) < 2 or not set.intersection(*(set(rests.values()) for rests in groups.values())):
        return {}
    used = {group: {clocks[name] for name in names} for group, names in groups.items()}
    shared = sum(map(len, used.values())) > len(set().union(*used.values()))
    if shared and not all(NUMBERED.fullmatch(plain(group)) for group in groups):
        return {}
    by_clock = {clock: group for group, some in used.items() for clock in some} if not shared else {}
    of = {name: group for group, names in groups.items() for name in names}
    return {name: of.get(name) or by_clock.get(clocks[name], "") for name in clocks}


def runs_by_clock(channels: Sequence[RawChannel]) -> dict[str, str]:
    """Return the test of each channel by its number, where each has a clock of its own; empty if there is but one test.

    Channels of different tests have the same names but for the number, and their clocks run at one pace, from the same
    start, and end at different times. So are single channels of one unit, by their names, if the ends are far apart.

    Examples
    --------
    >>> def channel(name, rows, unit=""):
    ...     return RawChannel(name=name, unit=unit, timepts=np.arange(rows) / 20, values=np.ones(rows), rate=None)
    >>> runs_by_clock([channel("S1", 900), channel("S2", 500)])
    {'S1': '1', 'S2': '2'}
    >>> runs_by_clock([channel("S1", 900), channel("S2", 899)]), runs_by_clock([channel("seat", 900)])
    ({}, {})
    >>> runs_by_clock([channel("free", 900, "m"), channel("damped", 500, "m")])
    {'free': 'free', 'damped': 'damped'}
    >>> runs_by_clock([channel("free", 900, "m"), channel("damped", 500, "V")])
    {}
    """
    found = {channel.name: _last_number(bare_name(channel.name)) for channel in channels}
    of: dict[str, str] = {}
    stems: dict[str, set[str]] = {}
    clocks: dict[str, set[int]] = {}
    named = any(match is None for match in found.values())
    if named and (len({channel.unit for channel in channels}) > 1 or not channels[0].unit):
        return {}
    for channel in channels:
        match = found[channel.name]
        stem, test = ("", bare_name(channel.name)) if named or match is None else match
        of[channel.name] = test
        stems.setdefault(test, set()).add(stem)
        clocks.setdefault(test, set()).add(id(channel.timepts))
    own = all(len(some) == 1 for some in clocks.values()) and len(set().union(*clocks.values())) == len(clocks)
    if len(clocks) < 2 or not own or len(set(map(frozenset, stems.values()))) > 1:
        return {}
    stamps = {id(channel.timepts): channel.timepts for channel in channels}.values()
    if any(each.size < 2 or not np.all(np.isfinite(each[[0, -1]])) for each in stamps):
        return {}
    starts, ends = (np.array([each[k] for each in stamps]) for k in (0, -1))
    steps = (ends - starts) / np.array([each.size - 1 for each in stamps])
    least = NAMED_APART if named else ENDS_APART
    apart = max(least * float(np.max(ends - starts)), STEPS_APART * float(np.max(steps)))
    together = np.ptp(starts) < apart and np.ptp(steps) < PACES_APART * np.max(steps)
    return of if together and np.ptp(ends) > apart else {}


def _last_number(name: str) -> tuple[str, str] | None:
    """Return what stands before the number that ends a name, and the number; None without one.

    Examples
    --------
    >>> _last_number("seat_12"), _last_number("7"), _last_number("seat 1 b")
    (('seat', '12'), ('', '7'), None)
    """
    # From the end on: an expression tries every place of a long name.
    start = len(name)
    while start and name[start - 1].isdecimal():
        start -= 1
    stop = start
    while stop and not name[stop - 1].isalnum():
        stop -= 1
    return (name[:stop], name[start:]) if start < len(name) else None


def of_test(channel: RawChannel, test: str) -> RawChannel:
    """Return a channel as one of a test, whose name it has before its own.

    Examples
    --------
    >>> of_test(RawChannel(name="z", unit="m", timepts=np.arange(2.0), values=np.ones(2), rate=None), "Run 1").name
    'Run 1: z'
    """
    return replace(channel, name=f"{test}: {channel.name}", test=test)


def _parts(name: str) -> Sequence[str]:
    """Return the parts of a name, that which numbers a test first."""
    last = NUMBERED_LAST.fullmatch(plain(name))
    return [last[2], bare_name(last[1])] if last else SEPARATORS.split(bare_name(name))


def _without_common(parts: Mapping[str, Sequence[str]]) -> dict[str, Sequence[str]]:
    """Return the parts of names without the first ones that all have."""
    most = min(map(len, parts.values()), default=0) - 1
    common = next((k for k in range(most) if len({one[k] for one in parts.values()}) > 1), max(most, 0))
    return {name: one[common:] for name, one in parts.items()}
