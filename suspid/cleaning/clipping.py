"""Clipping: runs of samples at the largest or smallest value of a channel."""

from __future__ import annotations

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.levels import UNLIKELY
from suspid.units import RealArray
from suspid.words import Defect, Number

# Samples in a row at the largest value, left by a jump, from which on they are clipped. With two, the crest of any
# sampled sinusoid would be clipped.
CLIPPED = 3
# Samples on each side in which equal neighbours are counted: how often noise of a few steps repeats a value by chance.
BESIDE = 20


def clipped_run(samples: RealArray, *, largest: bool) -> tuple[int, int] | None:
    """Return the first sample of the longest run at the largest or smallest value and its length, if it is clipped.

    A slow crest in coarse steps stays at its value too, but comes and goes by single steps.
    """
    limit = np.max(samples) if largest else np.min(samples)
    at = np.flatnonzero(samples == limit)
    if at.size < CLIPPED:
        return None
    starts = np.flatnonzero(np.diff(at, prepend=-9) > 1)
    lengths = np.diff(np.append(starts, len(at)))
    longest = int(np.argmax(lengths))
    first, count = int(at[starts[longest]]), int(lengths[longest])
    after = first + count
    if count < CLIPPED or count > 0.5 * len(samples):
        return None
    steps = np.abs(np.diff(samples))
    least = 3 * np.min(steps[steps > 0]) + 1e-3 * np.ptp(samples)
    if _from_rest(samples[after - 1 : after + 2] if after < len(samples) else samples[first::-1][:3], least):
        return None
    # Noise of a few steps of the converter repeats a value by chance.
    near = slice(max(0, first - BESIDE), after + BESIDE)
    others = steps[near][samples[near][: steps[near].size] != limit]
    chance = (np.sum(others == 0) + 1) / (others.size + 2)
    return (first, count) if chance ** (count - 1) < UNLIKELY else None


def _from_rest(samples: RealArray, least: float) -> bool:
    """Return whether a limit, and the samples next to it, are those of a mass that was held and let go.

    A crest that is cut off over n samples is left with (n + 1) / 2 times the step by which the steps grow; from rest it
    is half of that step at most.
    """
    first, *second = np.abs(np.diff(samples))
    return bool(first <= least + (abs(second[0] - first) if second else 0.0))


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
