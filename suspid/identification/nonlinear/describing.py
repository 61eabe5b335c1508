"""Describing functions: the equivalent of a force for each of several simultaneous tones."""

from __future__ import annotations

import numpy as np

from suspid.identification.nonlinear.forces import EVEN, ForceKind, size_of
from suspid.units import RealArray

# Phases of a tone over which a mean is taken: of the square of a speed with its sign, it is then good to 1e-4.
PHASES = 24


def describing(kind: ForceKind, own: RealArray, other: RealArray) -> RealArray:
    """Return the part of a force in step with a tone, over the amplitude of the tone.

    The force follows the sum of the tone, of amplitude ``own``, and of another, of amplitude ``other``, that keeps no
    phase with it; several others count as one of their power.

    Examples
    --------
    The cubic spring of a tone alone and under a large other one; friction, which a large other tone makes a damper:

    >>> describing(ForceKind.CUBIC, np.array([1.0, 1e-3]), np.array([0.0, 1.0])).round(3)
    array([0.75, 1.5 ])
    >>> describing(ForceKind.FRICTION, np.array([1.0, 1e-3]), np.array([0.0, 1.0])).round(3)
    array([1.273, 0.637])
    """
    own, other = np.maximum(own, 1e-300), np.asarray(other, float)
    if kind in EVEN:
        return np.zeros_like(own)
    if kind is ForceKind.CUBIC:
        return np.asarray(0.75 * (own**2 + 2 * other**2))
    if kind is ForceKind.FRICTION:
        return np.asarray(4 / np.pi / own * _mean_width(other / own))
    turns = 2 * np.pi * (np.arange(PHASES) + 0.5) / PHASES
    first, second = np.meshgrid(np.cos(turns), np.cos(turns))
    both = own[..., None, None] * first + other[..., None, None] * second
    return np.asarray(2 * np.mean(size_of(kind, both, both) * first, axis=(-2, -1)) / own)


def _mean_width(ratio: RealArray) -> RealArray:
    """Return the mean of ``sqrt(1 - x^2)``, 0 where x is beyond 1, over the phases of ``x = ratio cos(phase)``."""
    from scipy.special import ellipe, ellipk

    small, large = np.minimum(ratio, 1.0), np.maximum(ratio, 1.0 + 1e-12)
    beyond = large * ellipe(large**-2) - (large - 1 / large) * ellipk(large**-2)
    return np.asarray(2 / np.pi * np.where(ratio <= 1.0, ellipe(small**2), beyond))
