"""Clipping: runs of samples at the largest or smallest value of a channel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.findings import Finding, found
from suspid.cleaning.gaps import runs
from suspid.levels import UNLIKELY
from suspid.stamps import Indices
from suspid.units import RealArray
from suspid.words import Defect, Number

# Samples in a row at the largest value, left by a jump, from which on they are clipped. With two, the crest of any
# sampled sinusoid would be clipped.
CLIPPED = 3
# Samples on each side in which equal neighbours are counted: how often noise of a few steps repeats a value by chance.
BESIDE = 20
# A channel is in coarse steps from this share of repeats on, and of values on one side of a crest that are met on the
# other: a sensor that is read too often repeats each, but meets none again. A crest within one step has fallen by this
# many at twice its length at most: four, and one for where the steps begin.
MET_AGAIN, FALLEN_STEPS = 0.2, 5.0
# A crest that is cut off by this many steps at most has lost nothing: noise of one step is as large.
CUT_STEPS = 2.0
# The first step from rest over the growth of the next is at most one half where the force is steady, and this where it
# changes as in an eighth of a cycle. With more, most crests that are cut off seem to leave from rest.
FROM_REST = 0.8


def clipped_run(samples: RealArray, *, largest: bool) -> tuple[int, int] | None:
    """Return the first sample of the longest clipped run at the largest or smallest value and its length, or None.

    A slow crest in coarse steps stays at its value too, but comes and goes by single steps; a mass that was held and
    let go leaves from rest. Noise of a few steps of the converter repeats a value by chance: all runs together must be
    longer than that explains.

    Examples
    --------
    >>> clipped_run(np.clip(np.sin(np.arange(40) / 3), -1.0, 0.7), largest=True)
    (3, 5)
    """
    limit = float(np.max(samples) if largest else np.min(samples))
    first, after = runs(samples == limit)
    if not np.any(after - first >= CLIPPED):
        return None
    steps = np.abs(np.diff(samples))
    counts = after - first
    step = float(np.min(steps[steps > 0], initial=np.inf))
    left = ~_from_rest(samples, first, after, 3 * step)
    left &= ~_slow_crests(samples, steps, first, after) & ~_smooth_crests(samples, first, after, step)
    cut_off = left & (counts >= CLIPPED) & (counts <= 0.5 * samples.size)
    if not cut_off.any():
        return None
    longest = int(np.argmax(np.where(cut_off, counts, 0)))
    others = _steps_beside(samples, steps, int(first[longest]), int(after[longest]))
    again = (np.sum(others == 0) + 1) / (others.size + 2)
    from scipy.special import betainc

    # How likely that many repeats are in that many runs, where each sample repeats the one before by chance. A crest
    # that is cut off may leave its limit slowly, too; a mass that is held there stays longer.
    like = counts <= 2 * counts[longest]
    chance = betainc(np.sum(counts[like] - 1), np.sum(like), again)
    return (int(first[longest]), int(counts[longest])) if chance < UNLIKELY else None


def is_clipped(samples: RealArray) -> bool:
    """Return whether a channel is clipped at its largest or smallest value.

    Examples
    --------
    >>> wave = np.sin(np.arange(40) / 3)
    >>> is_clipped(wave), is_clipped(np.clip(wave, -0.7, 1.0))
    (False, True)
    """
    return any(clipped_run(samples, largest=largest) is not None for largest in (True, False))


def _slow_crests(samples: RealArray, steps: RealArray, first: Indices, after: Indices) -> NDArray[np.bool_]:
    """Return which runs at a limit are crests within one step of a converter, (run,).

    A crest that stays within a step for a time has fallen by four at that time from its middle. Nothing is told of
    channels that are not in coarse steps.
    """
    counts = after - first
    longest = int(np.argmax(counts))
    begin, end = int(first[longest]), int(after[longest])
    others = _steps_beside(samples, steps, begin, end)
    before, past = np.unique(samples[max(0, begin - BESIDE) : begin]), samples[end : end + BESIDE]
    # At another limit a channel stays again and again, too.
    again = np.isin(before[(before > np.min(samples)) & (before < np.max(samples))], past)
    if not np.count_nonzero(others) or np.mean(others == 0) < MET_AGAIN or not again.size or np.mean(again) < MET_AGAIN:
        return np.zeros(len(first), bool)
    half, last = (counts + 1) // 2, samples.size - 1
    fallen = [
        np.abs(samples[at] - samples[first]) for at in (np.maximum(first - half, 0), np.minimum(after - 1 + half, last))
    ]
    return np.asarray(np.maximum(*fallen) <= FALLEN_STEPS * float(np.median(others[others > 0])))


def _smooth_crests(samples: RealArray, first: Indices, after: Indices, step: float) -> NDArray[np.bool_]:
    """Return which runs at a limit are the crest of the parabola through two samples on each side, (run,).

    What is cut off there has no more than the ``step`` of a converter.
    """
    inside = (first >= 2) & (after + 2 <= samples.size)
    before, past = np.where(inside, first - 1, 0), np.where(inside, after, 0)
    inner, outer = samples[before] + samples[past], samples[before - 1] + samples[np.where(inside, after + 1, 0)]
    half = (after - first + 1) / 2
    bend = (outer - inner) / (2 * (2 * half + 1))
    slope = (samples[past] - samples[before]) / (2 * half)
    with np.errstate(divide="ignore", invalid="ignore"):
        crest = inner / 2 - bend * half**2 - slope**2 / (4 * bend)
        return np.asarray(inside & (np.abs(crest - samples[first]) <= CUT_STEPS * step))


def _steps_beside(samples: RealArray, steps: RealArray, first: int, after: int) -> RealArray:
    """Return the steps beside a run at a limit that do not leave the limit, of the differences of all samples."""
    near = slice(max(0, first - BESIDE), after + BESIDE)
    return np.asarray(steps[near][samples[near][: steps[near].size] != samples[first]])


def _from_rest(samples: RealArray, first: Indices, after: Indices, step: float) -> NDArray[np.bool_]:
    """Return which runs at a limit, and the samples next to them, are those of a mass that was held and let go, (run,).

    A crest that is cut off is left with any share of its next step; a mass that a spring moves from rest with a third
    of it, half of the growth of the step, at most. The ``step`` is what a converter adds to that.
    """
    last = samples.size - 1
    ends = after > last  # such a run is looked at from its other side
    beside = np.where(ends, first - 1, np.minimum(after, last)).clip(0)
    further = np.where(ends, first - 2, after + 1)
    left = np.abs(samples[beside] - samples[first])
    grown = FROM_REST * np.abs(np.abs(samples[further.clip(0, last)] - samples[beside]) - left)
    return np.asarray(left <= step + 1e-3 * np.ptp(samples) + np.where((further >= 0) & (further <= last), grown, 0.0))


def clipping(name: str, times: RealArray, samples: RealArray) -> list[Finding]:
    """Return a finding for each limit at which a channel is clipped."""
    findings = []
    if np.ptp(samples) > 0:
        for largest in (True, False):
            run = clipped_run(samples, largest=largest)
            if run is not None and run[0] > 0 and run[0] + run[1] < samples.size:
                at = np.flatnonzero(samples == samples[run[0]])
                numbers: dict[str, Number] = {
                    "largest": largest,
                    "value": float(samples[run[0]]),
                    "longest": run[1],
                    "longest_start": float(times[run[0]]),
                    "last": float(times[at[-1]]),
                    "throughout": bool(times[-1] - times[at[-1]] < times[at[-1]] - times[at[0]]),
                }
                findings.append(found(Defect.CLIPPED, times[at], at.size, numbers, channel=name, repaired=False))
    return findings
