"""Angles and counts that wrap round: they are continued beyond their range."""

from __future__ import annotations

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.units import RealArray
from suspid.words import Defect

# One turn in the units of angles, and in counts of converters of 8 to 16 bits.
WHOLE_TURNS = (2 * np.pi, 360.0, *(2.0**bits for bits in range(8, 17)))
# Steps are at most this part of a turn, but for those that wrap round, which are as far from a whole turn as this many
# of the largest of them, at most. Larger steps leave open which way they go.
SMALL_STEPS, AS_FAR = 1 / 16, 2.0
# Whole numbers wrap round at least this often: what is lost sight of once, as by a camera, jumps as far.
FEWEST_OF_COUNTS = 3
# Share of a turn by which numbers that were rounded when they were written exceed it.
ABOVE_A_TURN = 1e-3


def unwrapped(name: str, times: RealArray, values: RealArray) -> tuple[RealArray, list[Finding]]:
    """Return an angle or a count that wraps round as one that goes on, and the finding that says so.

    Each large step is nearly a whole turn, from one end of a range of a turn to the other, and all others are small.

    Examples
    --------
    >>> t = np.arange(200) / 100
    >>> angle = 20 * np.exp(-t) * np.cos(10 * t)
    >>> values, findings = unwrapped("angle", t, angle % 360)
    >>> bool(np.allclose(values - values[0], angle - angle[0])), findings[0].kind.value
    (True, 'wrapped')
    """
    good = np.flatnonzero(~np.isnan(values))
    if good.size < 2:
        return values, []
    samples = values if good.size == values.size else values[good]
    low, high = float(np.min(samples)), float(np.max(samples))
    turns = [turn for turn in WHOLE_TURNS if 0.5 * turn < high - low <= turn * (1 + ABOVE_A_TURN)]
    if not turns:
        return values, []
    turn, steps, counts = turns[0], np.diff(samples), not np.any(samples % 1)
    far = np.abs(steps) > 0.5 * turn
    most = float(np.max(np.abs(steps[~far]), initial=0.0))
    whole = turn == WHOLE_TURNS[1] or counts == (turn != WHOLE_TURNS[0])
    often = FEWEST_OF_COUNTS if counts else 1
    if np.sum(far) < often or not whole or most >= SMALL_STEPS * turn:
        return values, []
    if np.max(turn - np.abs(steps[far])) > AS_FAR * most:
        return values, []
    goes_on = values.copy()
    goes_on[good[1:]] -= turn * np.cumsum(np.where(far, np.sign(steps), 0.0))
    at = good[1:][far]
    return goes_on, [found(Defect.WRAPPED, times[at], at.size, {"turn": turn}, channel=name)]
