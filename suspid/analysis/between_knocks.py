"""What lies between knocks: a sensor that is handled before it swings, and caught after it."""

from __future__ import annotations

import numpy as np

from suspid.signals import Signal, roughness
from suspid.units import Second

# Parts of a record whose roughness is compared, of at least the second number of samples.
ROUGH_PARTS, ROUGH_SAMPLES = 40, 8
# A part is a knock where second differences are this many times (rms) those of the median part. Beats and the first
# swings of a decay are less; a smaller number cuts these off.
KNOCK = 6.0
# What lies between knocks is this share of a record at least.
MOST_BETWEEN = 1 / 3


def between_knocks(signal: Signal) -> tuple[Second, Second] | None:
    """Return from when to when no channel is knocked; None where none is, or never for long.

    Examples
    --------
    >>> t = np.arange(1000) / 100
    >>> knock = np.where(t > 8, np.random.default_rng(1).standard_normal(1000), 0.0)
    >>> values = (np.sin(3 * t) * np.exp(-0.1 * t) + knock)[None]
    >>> between_knocks(Signal(start=0.0, step=0.01, values=values, channels=("phone",)))
    (0.0, 7.97)
    """
    bends = np.diff(signal.values, 2)
    parts = min(ROUGH_PARTS, bends.shape[1] // ROUGH_SAMPLES)
    if parts < ROUGH_SAMPLES:
        return None
    edges = np.linspace(0, bends.shape[1], parts + 1).astype(int)
    sums = np.add.reduceat(bends**2, edges[:-1], axis=1)
    rough = np.sqrt(sums / np.diff(edges))
    knocked = np.any(rough > KNOCK * np.median(rough, axis=1, keepdims=True), axis=0)
    ends = np.flatnonzero(np.diff(np.concatenate([[True], knocked, [True]]).astype(int)))
    lengths = np.diff(ends)[::2]
    if not knocked.any() or not lengths.size or np.max(lengths) < MOST_BETWEEN * parts:
        return None
    longest = 2 * int(np.argmax(lengths))
    first, last = edges[ends[longest]], edges[ends[longest + 1]]
    # Second differences reach one sample further on either side.
    first, last = (first + 2 if first else 0), (last - 1 if last < bends.shape[1] else last + 1)
    return signal.start + signal.step * int(first), signal.start + signal.step * int(last)


def smoothest(signal: Signal, between: tuple[Second, Second]) -> str:
    """Return the channel that moves most between two times, beside its roughness there."""
    part = signal.values[:, (signal.timepts >= between[0]) & (signal.timepts <= between[1])]
    rough = np.maximum([roughness(samples) for samples in part], 1e-12 * np.max(np.abs(part), axis=1))
    return signal.channels[int(np.argmax(np.ptp(part, axis=1) / np.maximum(rough, 1e-300)))]
