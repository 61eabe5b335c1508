"""Where a motion turns, how far it is out there, and the swings between."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.units import ComplexArray, RealArray

# A swing that is this many times as large as the first is the first: what decays makes no larger one.
HELD_BEFORE = 1.2
# At its turns a motion rises or falls by less than this share of what it does between them: a tenth of half a period
# from them by more.
ALIGNED = 0.3


def first_swing(sizes: RealArray) -> int:
    """Return the first swing of sizes: what is held at first turns without a swing.

    Examples
    --------
    >>> swings = [9.0, 8.0, 7.0], [2.0, 9.0, 8.0], [1.0, 2.0, 9.0, 8.0], [9.0, 9.5, 9.2]
    >>> [first_swing(np.array(sizes)) for sizes in swings]
    [0, 1, 2, 0]
    """
    largest = int(np.argmax(sizes[:3]))
    return largest if sizes[largest] > HELD_BEFORE * sizes[0] else 0


def middles(times: RealArray) -> RealArray:
    """Return the middle of each swing between turns.

    Where friction stops the motion its last turn is not seen, and the state goes on for a while: the last swing lasts
    no longer than those of the cycle before it.

    Examples
    --------
    >>> middles(np.array([0.0, 10.0, 20.0, 30.0, 48.0])), middles(np.array([0.0, 6.0, 20.0, 26.0, 40.0]))
    (array([ 5., 15., 25., 35.]), array([ 3., 13., 23., 33.]))
    >>> middles(np.array([0.0, 6.0, 20.0]))
    array([ 3., 13.])
    """
    lasts = np.diff(times)
    if len(lasts) > 2:
        lasts[-1] = min(lasts[-1], np.max(lasts[-3:-1]))
    return np.asarray(times[:-1] + 0.5 * lasts)


def measured_turns(motion: RealArray, times: RealArray, reach: int) -> RealArray:
    """Return when a motion turns: at given times, or where it is seen to rise or fall at those.

    Forces follow noise in part, and what they drive may turn at other times than what they add to.

    Examples
    --------
    >>> motion = np.cos(np.pi * np.arange(45) / 10)
    >>> measured_turns(motion, np.array([10.5, 20.5, 30.5]), 2)
    array([10.5, 20.5, 30.5])
    >>> measured_turns(motion, np.array([14.0, 24.0, 34.0]), 2).round(6)
    array([10., 20., 30., 40.])
    >>> measured_turns(motion[9:], np.array([5.0, 15.0, 25.0]), 2).round(6)
    array([11., 21., 31.])
    """
    # What is turned before or after the record was not measured.
    times = times[(times > -0.5) & (times < len(motion) - 0.5)]
    if len(times) < 3:
        return times
    # Of a pole that hardly turns, a share of a cycle is longer than any record.
    reach = min(reach, len(motion))
    rises = _risen(motion, reach)
    at, between = (
        np.abs(rises[np.clip(np.round(each).astype(int), 0, len(motion) - 1)])
        for each in (times, 0.5 * (times[:-1] + times[1:]))
    )
    if np.median(at) < ALIGNED * np.median(between):
        return times
    turns = turns_through_zero(rises)
    # What the ends of the record cut off has no rise.
    return np.asarray(turns[(turns > reach) & (turns < len(motion) - 1 - reach)])


def _risen(motion: RealArray, reach: int) -> RealArray:
    """Return by how much a motion rises from a number of samples before to as many after each.

    Examples
    --------
    >>> _risen(np.array([0.0, 2.0, 5.0, 1.0]), 1)
    array([ 2.,  5., -1., -4.])
    """
    padded = np.pad(motion, reach, mode="edge")
    return np.asarray(padded[2 * reach :] - padded[: -2 * reach])


def extremes(motion: RealArray, times: RealArray) -> RealArray:
    """Return the crest or the trough of a motion about each of the times at which it turns, one after the other.

    It is that of the parabola through three samples.

    Examples
    --------
    >>> extremes(np.array([0.0, 2.0, 3.0, 2.0, -3.0, -4.0, -4.0]), np.array([1.9, 5.4])).round(3)
    array([ 3.   , -4.125])
    """
    starts = np.concatenate([[0], np.ceil(0.5 * (times[:-1] + times[1:])).astype(int)])
    starts = np.minimum(starts, len(motion) - 1)
    # Two turns between the same samples share them.
    ends = np.maximum(np.append(starts[1:], len(motion)), starts + 1)
    parts = list(zip(starts.tolist(), ends.tolist(), strict=True))
    crests, troughs = (
        _tops(out, np.array([a + int(np.argmax(out[a:b])) for a, b in parts])) for out in (motion, -motion)
    )
    even = np.arange(len(times)) % 2 == 0
    both = np.where(even, crests, -troughs), np.where(even, -troughs, crests)
    return np.asarray(max(both, key=lambda positions: float(np.sum(np.abs(np.diff(positions))))))


def _tops(motion: RealArray, at: NDArray[np.intp]) -> RealArray:
    """Return the tops of the parabolas through samples that are no smaller than their neighbours, and those."""
    at = np.clip(at, 1, len(motion) - 2)
    before, top, after = motion[at - 1], motion[at], motion[at + 1]
    bend = 2 * top - before - after
    between = (after - before) ** 2 / np.where(bend > 0, 8 * bend, np.inf)
    highest = np.maximum(np.maximum(before, after), top)
    return np.asarray(np.where((top >= before) & (top >= after), top + between, highest))


def prolonged(state: ComplexArray, theta: complex, push: ComplexArray, more: int) -> ComplexArray:
    """Return a state with some samples more at both ends, where the first and last of what pushes it go on.

    Examples
    --------
    >>> state = np.exp(0.1j * np.arange(3))
    >>> np.angle(prolonged(state, 0.1j, np.zeros(2), 1)).round(12).tolist()
    [-0.1, 0.0, 0.1, 0.2, 0.3]
    """
    steps = theta * np.arange(1, more + 1)
    before = np.exp(-steps) * state[0] + push[0] * np.expm1(-steps) / theta
    after = np.exp(steps) * state[-1] + push[1] * np.expm1(steps) / theta
    return np.concatenate([before[::-1], state, after])


def turns_through_zero(speed: RealArray) -> RealArray:
    """Return where a speed passes through 0, in samples.

    Examples
    --------
    >>> turns_through_zero(np.array([2.0, 1.0, -1.0, -2.0]))
    array([1.5])
    """
    passed = np.flatnonzero((speed[:-1] > 0) != (speed[1:] > 0))
    return np.asarray(passed + speed[passed] / (speed[passed] - speed[passed + 1]))


def turns_between(speed: RealArray, rise: RealArray, turn: float) -> RealArray:
    """Return where a speed passes through 0, in samples, from how fast it rises at each sample.

    Friction changes the rise at the very turn: from either side the speed goes on as a swing of the angular frequency
    ``turn`` per sample about a middle of its own, and straight lines put the turn too late.

    Examples
    --------
    >>> sine = np.sin(0.5 * (np.arange(5) - 2.2))
    >>> rises = 0.5 * np.cos(0.5 * (np.arange(5) - 2.2))
    >>> turns_between(np.where(sine < 0, 2 * sine, sine), np.where(sine < 0, 2 * rises, rises), 0.5).round(12)
    array([2.2])
    """
    passed = np.flatnonzero((speed[:-1] > 0) != (speed[1:] > 0))
    before, after = speed[passed], speed[passed + 1]
    share = before / (before - after)
    rises = rise[passed], rise[passed + 1]
    # The speed falls to 0 from either side, unless other motion bends it between the samples.
    falls = (before * rises[0] < 0) & (after * rises[1] > 0)
    ahead, behind = (
        np.arctan(turn * np.abs(one) / np.maximum(np.abs(by), np.finfo(float).tiny)) / turn
        for one, by in zip((before, after), rises, strict=True)
    )
    from_both = np.clip((1 - share) * ahead + share * (1 - behind), 0.0, 1.0)
    return np.asarray(passed + np.where(falls, from_both, share))
