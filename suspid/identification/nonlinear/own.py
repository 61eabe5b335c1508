"""Poles in a residual, and whether one is a separate mode or a part or multiple of another."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from suspid.identification.candidates import ranked, searched
from suspid.identification.exponentials import blocks_of
from suspid.identification.fitting import OTHER_FREQUENCY
from suspid.identification.harmonics import HIGHEST, WEAK
from suspid.identification.likelihood import bic_penalty
from suspid.identification.likelihood import evaluate as evaluate_decay
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.units import ComplexArray, RealArray

# A mode whose pole has a standard deviation above this share of its modulus, or changes by more with the stretch, is
# none.
UNKNOWN = 0.1
# Poles tried as the next one.
NEXT = 2
# A pole near another in frequency is part of it if their shapes agree: modal assurance criterion above this.
ALIKE_MAC = 0.9
# A pole is a harmonic of another mode if its frequency is that near to a multiple and its amplitude below `WEAK`.
MULTIPLE = 0.03
# From this multiple on, the share is that of the distance between two: else one is near every frequency. Beyond the
# highest one is, and what is weak there is distortion as likely.
THIRD = 3.0


def repeated(
    theta: complex,
    amplitude: ComplexArray,
    others: ComplexArray,
    amplitudes: ComplexArray,
    *,
    weak: float = WEAK,
    most: float = np.inf,
) -> bool:
    """Return whether a pole is part of another of the same shape, or a multiple of it below a share of its amplitude.

    So is one at the sum or difference of two that are larger. Multiples count up to ``most``. The amplitudes, over the
    noise, are (channel,) and (other, channel).
    """
    ratio = np.abs(theta) / np.abs(others)
    size, sizes = float(np.sum(np.abs(amplitude) ** 2)), np.sum(np.abs(amplitudes) ** 2, axis=1)
    alike = np.abs(amplitudes.conj() @ amplitude) ** 2 > ALIKE_MAC * sizes * size
    near = alike & (np.maximum(ratio, 1 / ratio) < OTHER_FREQUENCY)
    if _combined(abs(theta), np.abs(others[sizes > size])):
        return True
    multiple = at_multiple(ratio) & (np.round(ratio) <= most)
    return bool(np.any(near | multiple & (size < weak**2 * sizes)))


def at_multiple(ratio: RealArray) -> NDArray[np.bool_]:
    """Return which ratios of two frequencies are near to a whole number above one; high ones always are.

    Examples
    --------
    >>> at_multiple(np.array([1.0, 2.04, 2.1, 6.05, 6.15]))
    array([False,  True, False,  True, False])
    """
    whole = np.maximum(np.round(ratio), 1.0)
    near = MULTIPLE * np.where(whole <= HIGHEST, np.minimum(whole, THIRD), whole)
    return np.asarray((whole > 1) & (np.abs(ratio - whole) < near))


def _combined(frequency: float, others: RealArray) -> bool:
    """Return whether a frequency is the sum or difference of two others, as where two modes bend the same spring."""
    pairs = itertools.combinations(others.tolist(), 2)
    both = (each for one, other in pairs for each in (one + other, abs(one - other)))
    return any(abs(frequency - each) < MULTIPLE * each for each in both)


def next_poles(residual: RealArray, variance: RealArray, noise: WhiteNoise, *, worth: float = 0.0) -> list[complex]:
    """Return the exponents at which a residual is largest, of at least one cycle.

    Each gains at least ``worth`` times what a pole must gain for a lower BIC.
    """
    none = Poles(pairs=np.zeros(0, complex), reals=np.zeros(0), nuisances=np.zeros(1))
    count = residual.shape[1]
    alone = evaluate_decay(blocks_of(residual), none, noise)
    if alone is None:
        return []
    least = worth * bic_penalty(len(residual), residual.size)
    found = ranked(alone, variance, searched(alone, residual, variance))
    return [c.theta for c in found if not c.real and c.gain >= least and c.theta.imag * count > 2 * np.pi][:NEXT]
