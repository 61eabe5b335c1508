"""Kinds of excitation of a decay: an impulse, a step of the road, a release."""

from __future__ import annotations

import numpy as np

from suspid.decays.trials import Trial
from suspid.levels import CERTAIN, FEWEST_SAMPLES
from suspid.signals import Signal
from suspid.units import Second
from suspid.words import DecayKind

# The rest position is that over this time before the event, at most.
BEFORE: Second = 1.0
# The rest position moves if by more than this share of the motion, and all channels move together (a step of the road)
# if they differ by less than this share of their shift.
SHIFTED, TOGETHER = 0.15, 0.1
# The excitation is an impulse if the motion during it is this many times the motion after it.
SPIKE = 2.0
# A spike is this many standard deviations of the rest before, because it is the largest of many samples.
SURE_SPIKE = 10.0


def kind_of(signal: Signal, trial: Trial, first: int, begin: int) -> DecayKind | None:
    """Return what set a decay off, or None if neither the rest positions before and after nor a spike show it.

    The event begins at sample ``first``, the decay at sample ``begin``, from which the trial is fitted.
    """
    quiet = signal.values[:, max(0, first - int(BEFORE / signal.step)) : first]
    if quiet.shape[1] < FEWEST_SAMPLES:
        return None
    count = trial.residual.shape[1]
    after = signal.values[:, begin : begin + count * max(1, round(trial.step / signal.step))]
    swing = np.max(np.abs(trial.motion), axis=1)
    shift = np.mean(after, axis=1) - np.mean(trial.motion, axis=1) - np.mean(quiet, axis=1)
    spread = np.std(quiet, axis=1)
    moved = (np.abs(shift) > SHIFTED * swing) & (np.abs(shift) > CERTAIN * spread)
    if np.sum(moved) == 1:
        return DecayKind.STEP_OR_RELEASE
    if np.any(moved):
        together = np.ptp(shift[moved]) < TOGETHER * np.max(np.abs(shift[moved]))
        return DecayKind.STEP if together else DecayKind.RELEASE
    forced = signal.values[:, first:begin]
    if forced.shape[1]:
        spike = np.max(np.abs(forced - np.mean(quiet, axis=1, keepdims=True)), axis=1)
        if np.any((spike > SPIKE * swing) & (spike > SURE_SPIKE * spread)):
            return DecayKind.IMPULSE
    return None
