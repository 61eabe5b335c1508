"""Verify a free decay with `identify`."""

from __future__ import annotations

import numpy as np

from suspid.decays.trials import Trial
from suspid.errors import SuspidError
from suspid.identification import FORCED, MOST_PAIRS, Identification, identify, identify_linear, removed_as
from suspid.samples import as_samples
from suspid.signals import Signal
from suspid.words import DecayDoubt, Reason, Remark

# No start lies beyond this share of the stretch: the rest is too short to recognise a decay.
LATEST_START = 0.4
# Delays of the starts that are verified, in quarters of a block.
QUARTERS = (0, 1, 2, 3, 4, 6, 9, 14, 20)
# Those at which friction and other forces are looked for too, a block apart. Each search takes most of the time of an
# identification, and a few samples less show no others.
WITH_FORCES = (0, 4)
# Modes with this share of the energy of the strongest must be found again. With a smaller share noise decides: what is
# weaker, down to `COUNTING_SHARE`, counts where cycles are counted, which needs no second fit.
STRONG = 0.05
# A mode is found again within this share of its frequency plus this many of its standard deviations. Wider limits
# accept another mode, narrower ones refuse weak modes.
NEAR, NEAR_SURE = 0.05, 3.5
# The residual near a mode is at most this many times that of white noise; beyond that the motion is driven or
# nonlinear.
MOST_RESIDUAL = 4.0
# What a pole is that is found, but is no mode: part of the motion of modes that are not linear.
NAMED_PARTS = frozenset({Reason.HARMONIC, Reason.COMBINATION})


def verified(
    signal: Signal, trial: Trial, begin: int, last: int, size: int, *, moved: bool
) -> tuple[int, Remark | None]:
    """Return a start from which `identify` finds the modes of a trial, and a doubt if there is none.

    A trial fits means over blocks of ``size`` samples, which hide a few forced samples; `identify` fits all samples.
    The signal holds the moving channels; the decay has the samples ``begin`` to ``last`` (excluded). If it may
    be ``moved``, later starts are tried too.
    """
    first_doubt: Remark | None = None
    usable: int | None = None
    for quarter in QUARTERS if moved else (0,):
        place = begin + round(quarter * max(1.0, size / 4))
        if place - begin > LATEST_START * (last - begin):
            break
        part = signal.values[:, place:last]
        try:
            response = as_samples(signal.timepts_of(place, last), part, signal.channels)
            found = identify(response) if quarter in WITH_FORCES else identify_linear(response)
        except SuspidError as error:
            doubt: Remark | None = Remark(DecayDoubt.NOT_IDENTIFIED, {"error": error.wording})
        else:
            if found.forces:
                return place, Remark(DecayDoubt.NONLINEAR, {"share": trial.early})
            doubt = _doubt(trial, found)
            if not len(found.modes) and len(found.considered) >= MOST_PAIRS:
                # No number of poles explains the stretch, nor the same stretch from a few samples later on.
                return begin, first_doubt or doubt
            # A pole that is gone after a few samples fits forced samples.
            if doubt is None and not removed_as(found.considered, *FORCED):
                return place, None
            usable = place if doubt is None and usable is None else usable
        first_doubt = first_doubt or doubt
    return (begin, first_doubt) if usable is None else (usable, None)


def _doubt(trial: Trial, found: Identification) -> Remark | None:
    """Return a doubt if an identification does not find the modes of a trial, or leaves a high residual near them."""
    strong = trial.strengths >= STRONG * np.max(trial.strengths)
    poles = trial.selection.fit.poles.pairs[trial.modes][strong] / trial.step
    spread = -poles.real * trial.rate_std[strong]
    reach = NEAR * np.abs(poles) + NEAR_SURE * spread
    missing, highest = list[float](), 1.0
    named = np.array([c.pole for c in found.considered if c.remark.code in NAMED_PARTS], complex)
    for pole, most in zip(poles, reach, strict=True):
        apart = np.abs(found.modes.poles - pole)
        if not apart.size or np.min(apart) > most:
            if not np.any(np.abs(named - pole) < most):
                missing.append(float(abs(pole)) / (2 * np.pi))
            continue
        highest = max(highest, float(found.loudness[np.argmin(apart)]))
    if missing:
        return Remark(DecayDoubt.MODES_MISSING, {"hertz": tuple(missing)})
    if highest > MOST_RESIDUAL:
        return Remark(DecayDoubt.HIGH_RESIDUAL, {"decibel": float(10 * np.log10(highest))})
    return None
