"""Poles of a record, refitted to a part of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.identification.exponentials import blocks_of
from suspid.identification.fitting import Problem
from suspid.identification.noise import noise_of
from suspid.identification.poles import Poles
from suspid.identification.refinement import thinned
from suspid.signals import as_signal
from suspid.units import RealArray

if TYPE_CHECKING:
    import control

    from suspid.identification.identification import Identification


def residual_of_part(found: Identification, part: control.TimeResponseData) -> RealArray | None:
    """Return the residual of a part of a record, (channel, sample), with the poles of the whole fitted anew to it.

    It is None where a pole is not significant in the part, and of fits that are no sum of damped exponentials.
    """
    if found.method != "likelihood" or found.forces or not len(found.modes):
        return None
    signal = as_signal(part)
    poles = poles_of(found, signal.step)
    blocks = blocks_of(values := signal.values - signal.values.mean(axis=1, keepdims=True))
    problem = Problem(values=values, blocks=blocks, noise=noise_of(signal.values).rounded(blocks.energy, blocks.count))
    fit = problem.fitted(poles, rough=True)
    if fit is None:
        return None
    _, _, lost = thinned(problem, fit)
    return None if lost else fit.residual


def poles_of(found: Identification, step: float) -> Poles:
    """Return all poles of a fit, modes and others, and one offset."""
    every = np.array([*found.modes.poles, *(c.pole for c in found.considered if c.removed)]) * step
    pair = every.imag > 0
    return Poles(pairs=np.asarray(every[pair], complex), reals=every[~pair].real, nuisances=np.zeros(1))
