"""Modes that would still swing where a record stands still: a fit made them of friction that stops the motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.identification import UNIFORM_STD, Identification, resolution
from suspid.samples import held
from suspid.signals import as_signal

if TYPE_CHECKING:
    import control

# A mode swings on if more than this share of its first swing is left at the end of the stretch. Friction stops a mass
# at its last turn: what is left of a mode of its motion is less.
SWINGS_ON = 0.5
# Its swing is seen if it is this many times the range of what follows for half of its period. What lies within noise
# or the steps of a converter is not.
SEEN, PERIODS_BEHIND = 4.0, 0.5


def swings_on(found: Identification, whole: control.TimeResponseData) -> NDArray[np.bool_]:
    """Return which modes would still swing where the record stands still behind the stretch, (mode,).

    None of a fit with friction or other forces, which stops by itself.

    Examples
    --------
    >>> from suspid import identify
    >>> from suspid.records import as_response, cut
    >>> t = np.arange(0, 6, 0.01)
    >>> moved = np.exp(-3 * t) * np.cos(6 * t) + 0.1 * np.exp(-0.1 * t) * np.cos(30 * t)
    >>> record = as_response(t, np.where(t < 2, moved, 0.0)[None], ["mass"])
    >>> swings_on(identify(cut(record, stop=1.99)), record)
    array([False,  True])
    """
    part, after, poles = as_signal(held(found, "response")), as_signal(whole), found.modes.poles
    on = np.zeros(len(poles), bool)
    if found.forces or not len(poles) or not set(part.channels) <= set(after.channels):
        return on
    time = part.step * np.arange(part.values.shape[1])
    left = np.exp(poles.real * time[-1])
    periods = 2 * np.pi / np.abs(poles.imag * part.step).clip(1e-300)
    rows = [after.channels.index(name) for name in part.channels]
    behind = after.values[rows][:, after.timepts > part.timepts[-1] + 0.5 * part.step]
    may = np.flatnonzero((left > SWINGS_ON) & (behind.shape[1] >= PERIODS_BEHIND * periods))
    # The fit to all poles is sought only where it is needed: it takes a table of samples by poles.
    if not may.size:
        return on
    others = [c.pole for c in found.considered if c.removed and c.pole.real < 0]
    courses = np.exp(np.outer(time, [*poles, *others]))
    basis = np.concatenate([courses.real, courses.imag, np.ones((len(time), 1))], axis=1)
    weights, *_ = np.linalg.lstsq(basis, part.values.T, rcond=None)
    step = resolution(part.values) / UNIFORM_STD
    for mode in may:
        swing = 2 * left[mode] * np.hypot(weights[mode], weights[courses.shape[1] + mode])
        still = behind[:, : int(min(periods[mode], behind.shape[1]))]
        on[mode] = bool(np.any(swing > np.maximum(SEEN * np.ptp(still, axis=1), step)))
    return on
