"""Inspection: impossible samples, dropouts, held samples, offsets and drifts of a channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.cleaning.clipping import clipping
from suspid.cleaning.findings import Finding, found
from suspid.cleaning.sentinels import known, possible, without_sentinels
from suspid.cleaning.spikes import without_spikes
from suspid.cleaning.stopped import stopped_at
from suspid.cleaning.wraps import unwrapped
from suspid.levels import UNLIKELY
from suspid.stamps import Indices
from suspid.units import Flags, RealArray
from suspid.values import LARGEST_SIZE, frozen_real
from suspid.words import Defect, Number

# Share of the steps that are the commonest one, and of those up to ten times as large that are multiples of it, from
# which on it is the step of the converter. Of steps of any size a tenth are multiples by chance.
COMMONEST, MULTIPLES = 0.1, 0.75
# Equal samples in a row, entered and left by a jump, from which on they are a dropout.
FROZEN = 4
# Shorter runs of its value that show that it is a level of the channel, to which this returns. With their mean length,
# runs of any length are as probable as the next sample.
RETURNS, LONGEST_MEAN = 8, 2.0
# Share of a straight line in the variance of a channel, number of blocks, and number of their medians that must
# follow each other in its direction, from which on it is a drift. A free decay explains less.
DRIFTING, BLOCKS, ONE_WAY = 0.6, 10, 8


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Inspected:
    """A channel with its impossible samples removed.

    Parameters
    ----------
    values : ndarray (sample,)
        NaN where there was no number or an impossible one.
    findings : tuple of Finding
        Defects of the channel.
    """

    values: RealArray
    findings: tuple[Finding, ...]


def inspect(name: str, times: RealArray, values: RealArray) -> Inspected:
    """Return a channel without impossible samples, and its defects.

    Infinities, sentinels and short dropouts become NaN. Clipping, held samples, offsets and drifts are only reported.

    Parameters
    ----------
    name : str
        The channel.
    times, values : ndarray (sample,)
        Increasing stamps [s] and samples.

    Examples
    --------
    >>> t = np.arange(100) / 100
    >>> values = np.sin(20 * t)
    >>> values[40] = -9999.0
    >>> print(inspect("seat", t, values).findings[0])
    sentinel, channel 'seat' at 0.4 s: 1 sample equal to -9999, far from all others (...); treated as missing
    """
    findings: list[Finding] = []
    whole = possible(values)
    huge = np.flatnonzero(np.abs(values) >= LARGEST_SIZE) if whole is not values else np.empty(0, np.intp)
    if huge.size:
        findings.append(found(Defect.SENTINEL, times[huge], huge.size, {"limit": LARGEST_SIZE}, channel=name))
    whole, wraps = unwrapped(name, times, whole)
    findings += wraps
    repaired, sentinels = without_sentinels(name, times, whole)
    findings += sentinels
    repaired, spikes = without_spikes(name, times, repaired)
    findings += spikes
    if np.sum(~np.isnan(repaired)) >= 8:
        findings += clipping(name, *known(times, repaired))
        repaired, dropouts = _without_dropouts(name, times, repaired)
        repaired, stopped = _until_it_stops(name, times, repaired)
        findings += dropouts + stopped
        findings += _level(name, *known(times, repaired))
    kept = repaired is values and not values.flags.writeable
    return Inspected(values=values if kept else frozen_real(repaired), findings=tuple(findings))


def _without_dropouts(name: str, times: RealArray, values: RealArray) -> tuple[RealArray, list[Finding]]:
    """Remove short runs of one value that are entered and left by a jump; report samples that are held throughout."""
    whole = not np.any(np.isnan(values))
    good = np.arange(values.size) if whole else np.flatnonzero(~np.isnan(values))
    samples = values if whole else values[good]
    change = np.flatnonzero(samples[1:] != samples[:-1]) + 1
    # A run is made of samples that equal the one before.
    if change.size < 8 or samples.size - 1 - change.size < FROZEN - 1:
        return values, []
    starts, stops = np.concatenate([[0], change]), np.concatenate([change, [samples.size]])
    lengths = stops - starts
    steps = np.abs(np.diff(samples))
    quantum = _converter_step(steps[steps > 0])
    usual = lengths[1:-1]
    if usual.size and np.median(usual) >= 2 and np.mean(usual == np.median(usual)) > 0.9:
        numbers: dict[str, Number] = {"repeats": float(np.median(usual))}
        return values, [found(Defect.HELD_SAMPLES, times[good], samples.size, numbers, channel=name, repaired=False)]
    inner = np.flatnonzero(lengths >= FROZEN)
    inner = inner[(inner > 0) & (inner < lengths.size - 1)]
    left, right = samples[starts[inner] - 1], samples[stops[inner] % samples.size]
    entered, released = np.abs(samples[starts[inner]] - left), np.abs(right - samples[starts[inner]])
    # A crest in coarse steps is left by a single step; a frozen value by the motion that went on meanwhile.
    far = 5 * quantum
    inner, entered, released = inner[released > far], entered[released > far], released[released > far]
    around = np.array([_pace(samples, int(starts[k]), int(stops[k])) for k in inner]).reshape(-1)
    zero = (
        (samples[starts[inner]] == 0)
        & (entered > np.maximum(far, 4 * around))
        & (released > np.maximum(far, 4 * around))
    )
    by_chance = samples.size * (0.27 * quantum / np.maximum(around, quantum)) ** (lengths[inner] - 1.0)
    held = (released > np.maximum(far, 2 * around)) & (around > far) & (by_chance < UNLIKELY)
    extreme = (samples[starts[inner]] == np.max(samples)) | (samples[starts[inner]] == np.min(samples))
    # A motion that begins from rest, as one sound after silence does, leaves zero by a step as small as its others.
    onset = np.array([_pace(samples, int(stops[k]), int(stops[k]), before=False) for k in inner]).reshape(-1)
    silent = (samples[starts[inner]] == 0) & (released <= 4 * onset)
    held &= ~np.array([_sets_off(samples[stops[k] - 1 : stops[k] + 3]) for k in inner], bool)
    held[held] = ~_last_by_chance(samples, starts, lengths, inner[held])
    bad = inner[(zero | (held & ~extreme)) & ~silent]
    if not bad.size:
        return values, []
    where = np.concatenate([good[starts[k] : stops[k]] for k in bad])
    longest = int(np.max(lengths[bad]))
    only_zero = bool(np.all(samples[starts[bad]] == 0))
    numbers = {"runs": bad.size, "longest": longest, "zero": only_zero}
    cleared = values.copy()
    cleared[where] = np.nan
    return cleared, [found(Defect.DROPOUT, times[where], where.size, numbers, channel=name)]


def _until_it_stops(name: str, times: RealArray, values: RealArray) -> tuple[RealArray, list[Finding]]:
    """Remove what a sensor that has stopped repeats to the end."""
    if values[-1] != values[-2]:
        return values, []
    good = np.flatnonzero(~np.isnan(values))
    first = stopped_at(values[good])
    if first == good.size:
        return values, []
    where = good[first:]
    cleared = values.copy()
    cleared[where] = np.nan
    numbers: dict[str, Number] = {"value": float(values[-1])}
    return cleared, [found(Defect.STOPPED, times[where], where.size, numbers, channel=name)]


def _last_by_chance(samples: RealArray, starts: Indices, lengths: Indices, runs: Indices) -> Flags:
    """Return which runs of one value last by chance, since the channel returns to it again and again.

    The base of pulses is such a level. Its short runs tell how probable it is that one goes on: of lengths up to 3 with
    the probabilities 1, q and q², the mean is m where ``(3 - m) q² + (2 - m) q = m - 1``. A value at which a sensor is
    stuck has long runs, and hardly any of two or three samples.
    """
    values = np.unique(samples[starts[runs]])
    if not values.size:
        return np.empty(0, bool)
    place = np.minimum(np.searchsorted(values, samples[starts]), values.size - 1)
    short = (values[place] == samples[starts]) & (lengths < FROZEN)
    often = np.bincount(place[short], minlength=values.size)[place[runs]]
    total = np.bincount(place[short], weights=lengths[short], minlength=values.size)[place[runs]]
    mean = np.clip(total / np.maximum(often, 1), 1, LONGEST_MEAN)
    goes_on = (mean - 2 + np.sqrt((2 - mean) ** 2 + 4 * (3 - mean) * (mean - 1))) / (2 * (3 - mean))
    likely = often * np.minimum(goes_on, 1.0) ** (lengths[runs] - 1.0) >= UNLIKELY
    return np.asarray((often >= RETURNS) & likely)


def _converter_step(steps: RealArray) -> float:
    """Return the step of the converter, of steps between samples, none of them 0.

    It is the smallest one, but for printed numbers whose last digit is finer than the converter, and for filters that
    add values between its steps: then most steps are multiples of the commonest.
    """
    least = float(np.min(steps))
    digits = 10.0 ** (np.floor(np.log10(steps)) - 2)
    sizes, counts = np.unique(np.round(steps / digits) * digits, return_counts=True)
    often = float(sizes[np.argmax(counts)])
    near = np.abs(steps - often) <= 0.01 * often
    if not least < 0.5 * often or np.mean(near) < COMMONEST:
        return least
    often = float(np.median(steps[near]))
    ticks = steps[(steps > 0.5 * often) & (steps < 10.5 * often)] / often
    return often if np.mean(np.abs(ticks - np.round(ticks)) < 0.05) > MULTIPLES else least


def _sets_off(samples: RealArray) -> bool:
    """Return whether samples from the last one of a hold on are of a motion that begins there: it gets ever faster.

    A value that froze is left by all that it missed, and the motion goes on as it did before.
    """
    steps = np.diff(samples)
    return len(steps) == 3 and bool(np.all(np.diff(np.sign(steps[0]) * steps) > 0))


def _pace(samples: RealArray, start: int, stop: int, *, before: bool = True) -> float:
    """Return the median step between samples beside a run, or behind it alone."""
    length = max(8, stop - start)
    first = max(0, start - length) if before else start
    beside = np.concatenate([np.diff(samples[first:start]), np.diff(samples[stop : stop + length])])
    return float(np.median(np.abs(beside))) if beside.size else 0.0


def _level(name: str, times: RealArray, samples: RealArray) -> list[Finding]:
    """Report an offset, and a drift, that is larger than the motion."""
    findings: list[Finding] = []
    spread = float(np.ptp(samples))
    if spread > 0 and samples.size >= 8 * BLOCKS:
        x = np.linspace(-0.5, 0.5, samples.size)
        about = (samples - np.mean(samples)) / spread
        slope = spread * float(np.sum(x * about) / np.sum(x**2))
        explained = (slope / spread) ** 2 * float(np.mean(x**2) / np.mean(about**2))
        if explained > DRIFTING and _goes_one_way(samples, slope):
            numbers: dict[str, Number] = {"drift": slope}
            findings.append(found(Defect.DRIFT, times[[0, -1]], samples.size, numbers, channel=name, repaired=False))
    if np.min(samples) * np.max(samples) > 0 and abs(middle := float(np.median(samples))) > spread > 0:
        numbers = {"level": middle, "range": spread}
        findings.append(found(Defect.OFFSET, times[[0, -1]], samples.size, numbers, channel=name, repaired=False))
    return findings


def _goes_one_way(samples: RealArray, slope: float) -> bool:
    blocks = np.array([np.median(block) for block in np.array_split(samples, BLOCKS)])
    return bool(np.sum(np.sign(np.diff(blocks)) == np.sign(slope)) >= ONE_WAY)
