"""Clocks that begin anew, or go on after a long break: tests in the same columns; and counters that roll over.

A logger that is switched on again, or that waits for the next event, writes its rows below those before.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from suspid.io.runs import of_test
from suspid.recordings import RawChannel
from suspid.stamps import MOST_PER_ROW, Indices
from suspid.units import RealArray
from suspid.words import LeftOut, Remark

# Fewest rows of a recording, and the most recordings of a file.
FEWEST_ROWS_OF_A_TEST, MOST_TESTS = 16, 1000
# Steps of a clock, in mean ones, of which breaks between recordings have at least one: of so few rows each, they would
# take most of the time.
LONGEST_STEP = 0.5 * FEWEST_ROWS_OF_A_TEST
# A clock that begins anew does so at its first stamp, to this share of the longest recording.
AT_FIRST_STAMP = 0.1
# Breaks of this share of the longest one are between recordings as well.
ALIKE_BREAKS = 0.1
# Where counters roll over: those of 16 and 32 bits, in their own unit, or from us or ms to s.
ROLLS_OVER = (2.0**16, 2.0**32, 2.0**32 / 1e3, 2.0**32 / 1e6)
# A step across a roll over, in usual steps.
NEXT_STEP = 2.5


def with_restarts(
    channels: tuple[RawChannel, ...], times: Sequence[str]
) -> tuple[tuple[RawChannel, ...], dict[str, Remark]]:
    """Return the channels of one clock as tests, where it begins anew or has long breaks, and what is said of that.

    The first of the ``times`` is its name.

    Examples
    --------
    >>> t = np.arange(200) % 100 / 50
    >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=np.sin(9 * t), rate=None)
    >>> tests, said = with_restarts((seat,), ["t"])
    >>> [(each.name, each.test, each.values.size) for each in tests]
    [('Run 1: seat', 'Run 1', 100), ('Run 2: seat', 'Run 2', 100)]
    >>> print(said["'t'"])
    begins anew after row 100: what follows is a test of its own
    """
    stamps = {id(channel.timepts): channel.timepts for channel in channels}
    if len(stamps) != 1 or any(channel.values.size != channel.timepts.size for channel in channels):
        return channels, {}
    (clock,) = stamps.values()
    anew = _begins_anew(clock)
    edges = anew if anew.size else _breaks(clock)
    rows = np.diff([0, *edges, clock.size])
    if not edges.size or edges.size >= MOST_TESTS or np.min(rows) < FEWEST_ROWS_OF_A_TEST:
        return channels, {}
    tests = list[RawChannel]()
    for k, (first, stop) in enumerate(itertools.pairwise([0, *edges.tolist(), clock.size])):
        # Channels of one test share their stamps.
        own = clock[first:stop]
        tests += [of_test(replace(c, timepts=own, values=c.values[first:stop]), f"Run {k + 1}") for c in channels]
    why = LeftOut.ANEW if anew.size else LeftOut.BREAKS
    said = Remark(why, {"row": int(edges[0]), "more": int(edges.size) - 1})
    return tuple(tests), {repr(next(iter(times), "time")): said}


def _begins_anew(times: RealArray) -> Indices:
    """Return the rows at which a clock begins anew; none where it also falls elsewhere, or a stamp is wrong."""
    steps = np.diff(times)
    edges = np.flatnonzero(steps < 0) + 1
    if not edges.size or not np.all(np.isfinite(steps)):
        return np.zeros(0, np.intp)
    rows, usual = np.diff([0, *edges, times.size]), float(np.median(steps))
    starts, ends = times[[0, *edges]], times[[*(edges - 1), -1]]
    near = np.abs(starts - starts[0]) <= AT_FIRST_STAMP * usual * np.max(rows)
    whole = ends - starts <= MOST_PER_ROW * usual * rows
    return edges if np.all(near & whole) else np.zeros(0, np.intp)


def _breaks(times: RealArray) -> Indices:
    """Return the rows behind the long breaks of a clock that would leave a record nearly empty."""
    steps, none = np.diff(times), np.zeros(0, np.intp)
    if steps.size < FEWEST_ROWS_OF_A_TEST or not np.all(steps >= 0):
        return none
    if np.max(steps) < LONGEST_STEP * np.mean(steps):
        return none
    usual = float(np.median(steps))
    if not usual > 0 or times[-1] - times[0] < MOST_PER_ROW * times.size * usual:
        return none
    return np.flatnonzero(steps > max(MOST_PER_ROW * usual, ALIKE_BREAKS * float(np.max(steps)))) + 1


def with_rolled_on(
    columns: Mapping[str, RealArray], times: Sequence[str]
) -> tuple[dict[str, RealArray], dict[str, Remark]]:
    """Return the columns with those of times that roll over counted on (see `rolled_on`), and what is said of that.

    Examples
    --------
    >>> counts = np.arange(2.0**16 - 4000, 2.0**16 + 4000, 1000) % 2**16
    >>> print(with_rolled_on({"ms": counts}, ["ms"])[1]["'ms'"])
    rolls over at 65536: it is counted on from there
    """
    found = {name: rolled_on(columns[name]) for name in times}
    said = {repr(name): Remark(LeftOut.ROLLS_OVER, {"period": at}) for name, (_, at) in found.items() if at}
    return {**columns, **{name: numbers for name, (numbers, _) in found.items()}}, said


def rolled_on(numbers: RealArray) -> tuple[RealArray, float]:
    """Return the numbers of a counter that rolls over as if it counted on, and where it does; 0 for others.

    Examples
    --------
    >>> rolled_on(np.arange(2.0**16 - 4000, 2.0**16 + 4000, 1000) % 2**16)[0][-3:].tolist(), rolled_on(np.ones(9))[1]
    ([66536.0, 67536.0, 68536.0], 0.0)
    """
    steps = np.diff(numbers)
    back = np.flatnonzero(steps < 0)
    if not back.size or not np.all(np.isfinite(steps)) or np.min(numbers) < 0:
        return numbers, 0.0
    usual = float(np.median(steps))
    for period in ROLLS_OVER:
        within = np.max(numbers) <= period and 0 < usual < period / FEWEST_ROWS_OF_A_TEST
        if within and np.all((steps[back] + period >= 0) & (steps[back] + period <= NEXT_STEP * usual)):
            turns = np.zeros(numbers.size)
            turns[back + 1] = period
            return np.asarray(numbers + np.cumsum(turns)), period
    return numbers, 0.0
