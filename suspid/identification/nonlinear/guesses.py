"""Starts of a fit with friction: its force is guessed, as a share of the inertia at the first peak.

A fit that starts without friction may end beside the best one where masses stop after a few cycles.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from suspid.identification.nonlinear.motion import Structures, motion_of
from suspid.identification.nonlinear.structure import StructureFit, gains_of
from suspid.units import ComplexArray, RealArray

# Friction of each mass over the force at its first peak. A start without friction reaches what is weaker; under what is
# stronger one cycle is left. Coarser steps are not within reach of the fit.
SHARES = (0.01, 0.02, 0.05, 0.1, 0.2)
# Damping that a linear fit has beside friction, as shares of its own: most of it may be friction, or none.
VISCOUS = (0.2, 1.0)
# Masses up to which each has a share of its own: the number of guesses grows as its power, 50 for two masses.
MOST_ALONE = 2
# Starts that are fitted: the fit may end beside the best one from the most likely.
TRIED = 3
# Loss per sample by which they may be above the start without friction: friction that stops masses soon explains at
# least as much at once, or nearly. Of masses that no friction stops, the guesses mostly lose more.
WORSE = 1.0


def with_friction(plain: StructureFit) -> list[StructureFit]:
    """Return the most likely starts near a structure on which no force acts yet, with friction of several sizes.

    There are none where friction of no size explains the record. The friction of a mass slows that mass alone, and
    moves none at once: that settles the gains of all modes.
    """
    of, channels = plain.structures, len(plain.residual)
    alone = channels <= MOST_ALONE
    sizes = np.array(list(product(SHARES, repeat=channels))) if alone else np.tile(SHARES, (channels, 1)).T
    damping = np.repeat(VISCOUS, len(sizes))
    theta = damping[:, None] * of.theta[0].real + 1j * of.theta[0].imag
    shapes = np.repeat(of.shapes, len(theta), axis=0)
    sizes = np.tile(sizes, (len(VISCOUS), 1))
    # The amplitudes of a linear fit are too small at first: friction takes as much from small swings as from large.
    for _ in range(2):
        slowed = sizes * np.sum(np.abs(shapes * theta[:, :, None] ** 2), axis=1)
        gains = np.zeros((len(theta), of.theta.shape[1], len(of.forces)), complex)
        gains[:, :, :channels] = gains_of(theta, shapes, slowed[:, :, None] * np.eye(channels))
        guesses = replace(of, theta=theta, shapes=shapes, gains=gains)
        shapes, losses = _refitted(plain, guesses, slowed)
    likely = [one for one in np.argsort(losses)[:TRIED] if losses[one] < plain.loss + WORSE * plain.residual.size]
    return [
        plain.with_structures(replace(of, theta=theta[[one]], shapes=shapes[[one]], gains=gains[[one]]))
        for one in likely
    ]


def _refitted(plain: StructureFit, guesses: Structures, slowed: RealArray) -> tuple[ComplexArray, RealArray]:
    """Return the displacements (structure, pole, channel) that fit a record best, and the loss of each structure."""
    record, count = plain.record, plain.residual.shape[1]
    motion, order = motion_of(guesses, count), plain.order
    fixed = np.exp(np.outer(np.arange(count), record.nuisances))
    shapes, losses = np.empty_like(guesses.shapes), np.empty(len(slowed))
    for one, states in enumerate(motion.states):
        values = record.values
        if order == 2:
            # Friction shows in the accelerations at once.
            values = values + slowed[one][:, None] * motion.acting[one, : len(values)]
        columns = np.column_stack([states.real.T, -states.imag.T, fixed])
        parts = np.linalg.lstsq(columns, values.T, rcond=None)[0]
        squares = np.sum((values.T - columns @ parts) ** 2, axis=0)
        losses[one] = record.noise.loss(np.asarray(squares), count)
        poles = len(states)
        shapes[one] = (parts[:poles] + 1j * parts[poles : 2 * poles]) * guesses.theta[one][:, None] ** -order
    return shapes, losses
