"""Channels that follow no other one, or show the same motion as another one: faults of sensors, or of their wiring."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from suspid.greybox.measured_causes import Source
from suspid.levels import EXACT
from suspid.units import ComplexArray, RealArray
from suspid.words import Remark
from suspid.words.greybox import EstimateCheck

# Values that a coherence averages: by chance it is then some 3 % for each other channel.
AVERAGED = 32
# Share of a channel's power that the others tell, on average over frequency and beyond chance, below which it measures
# nothing of the car. Those of wheels and bodies on roads of class B share nine tenths.
DEAD_SHARE = 0.1
# Coherence in phase, on average over frequency, from which on two channels show one motion. Between a wheel and a body
# it is about zero, since the body lags by a half turn above its resonance.
SAME_MOTION = 0.8


def sensor_fault(sources: Sequence[Source]) -> Remark | None:
    """Return which channel follows no other one, or which two show the same motion; None where none does."""
    for source in sources:
        found = fault_of(source.spectra.values, source.layout.orders.tolist(), source.trial.channels)
        if found is not None:
            return found
    return None


def fault_of(values: ComplexArray, orders: Sequence[int], channels: Sequence[str]) -> Remark | None:
    """Return the fault that the spectra of a record show, (line, stretch, channel); ``orders`` are its derivatives.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> front, rear, dead = rng.standard_normal((3, 200, 8)) + 1j * rng.standard_normal((3, 200, 8))
    >>> made = np.stack([front, front + 0.1 * rear, rear + 0.5 * front, dead], axis=2)
    >>> fault_of(made, (2, 1, 2, 2), ("front", "body", "rear", "seat")).numbers["names"]
    ('seat',)
    >>> fault_of(made, (2, 2, 2, 2), ("front", "body", "rear", "seat")).numbers["names"]
    ('front', 'body')
    """
    matrices = _coherences(values)
    for i, j in combinations(range(len(channels)), 2):
        alike = float(np.mean(matrices[:, i, j].real))
        if orders[i] == orders[j] and abs(alike) > SAME_MOTION:
            return Remark(EstimateCheck.COPIED, {"names": (channels[i], channels[j]), "share": abs(alike)})
    shares = _shared(matrices)
    dead = [name for name, share in zip(channels, shares.tolist(), strict=True) if share < DEAD_SHARE]
    if not dead:
        return None
    # What is left of two channels that have nothing in common does not tell which of them is dead.
    code = EstimateCheck.DEAD if len(dead) == 1 else EstimateCheck.APART
    return Remark(code, {"names": tuple(dead), "share": float(np.min(shares))})


def _coherences(values: ComplexArray) -> ComplexArray:
    """Return the complex coherence between all channels in groups of lines, (group, channel, channel)."""
    lines, stretches, _ = values.shape
    made = []
    for part in np.array_split(values, min(max(1, lines * stretches // AVERAGED), lines)):
        flat = part.reshape(-1, values.shape[2])
        power = flat.conj().T @ flat
        size = np.sqrt(np.diag(power).real)
        size[size == 0] = 1.0
        made.append(power / np.outer(size, size))
    return np.asarray(made, complex)


def _shared(matrices: ComplexArray) -> RealArray:
    """Return the share of each channel's power that the others tell, on average and beyond chance, (channel,)."""
    # Of a matrix of coherences, one over the diagonal of the inverse is the share that is a channel's own.
    count = matrices.shape[1]
    regular = matrices + EXACT * np.eye(count)
    own = 1 / np.diagonal(np.linalg.inv(regular), axis1=1, axis2=2).real
    chance = (count - 1) / AVERAGED
    return np.asarray((1 - np.mean(own, axis=0) - chance) / (1 - chance))
