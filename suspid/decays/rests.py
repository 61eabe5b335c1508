"""A decay between two rests: a mass that was held and let go, and that friction stops."""

from __future__ import annotations

import numpy as np

from suspid.decays.decay import Decay
from suspid.errors import SuspidError
from suspid.identification import Identification, identify
from suspid.samples import as_samples, held
from suspid.signals import Signal, as_signal
from suspid.units import Decibel
from suspid.words import DecayDoubt, Remark


def decay_between(part: Signal, first: int, last: int, *, level: Decibel) -> Decay | None:
    """Return the decay between two samples (the last excluded) if `identify` explains it by nonlinear forces.

    Few cycles that friction stops follow no damped exponentials, so that quick fits refuse them.
    """
    try:
        found = identify(as_samples(part.timepts_of(first, last), part.values[:, first:last], part.channels))
    except SuspidError:
        return None
    if not found.forces:
        return None
    return as_decay(found, part, (first, last), level=level)


def as_decay(
    found: Identification, part: Signal, samples: tuple[int, int], *, level: Decibel, doubts: tuple[Remark, ...] = ()
) -> Decay:
    """Return the decay between two samples (the last excluded) as it was identified; forces in it are a doubt."""
    first, last = samples
    motion, left = as_signal(held(found, "fitted")).values, as_signal(held(found, "residual")).values
    energy = np.sum((motion - motion.mean(axis=1, keepdims=True)) ** 2, axis=1)
    cycles = float(np.max(found.modes.wn)) * part.step * (last - first) / (2 * np.pi)
    strength = float(np.sum(energy / np.maximum(found.noise_std**2, 1e-300))) * cycles**2
    share = float(np.sqrt(np.max(np.sum(left**2, axis=1) / np.maximum(energy, 1e-300))))
    return Decay(
        start=part.start + part.step * first,
        stop=part.start + part.step * (last - 1),
        rank=0,
        kind=None,
        level=level,
        cycles=cycles,
        strength=float(10 * np.log10(strength)),
        wn=found.modes.wn,
        zeta=found.modes.zeta,
        doubts=(*((Remark(DecayDoubt.NONLINEAR, {"share": share}),) if found.forces else ()), *doubts),
    )
