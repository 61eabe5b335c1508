"""Reasons why an event is no free decay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from suspid.decays.envelopes import Envelopes
from suspid.decays.trials import Trial
from suspid.units import Decibel, Second
from suspid.words import DecayRemark, Number, Reason

# A reason with its numbers, to which time and level of the event are added.
Refusal: TypeAlias = tuple[DecayRemark, Mapping[str, Number]]

# At least one mode rises to within this of the threshold in the band of its own frequency. A smaller distance refuses
# weak decays; a larger one accepts modes of the background that a click elsewhere made visible.
OWN_BAND: Decibel = 6.0
# A fit of more poles follows noise or driven motion. A car with seat has 3 pairs, and drifts and tones take some more.
MOST_DECAY_POLES = 10
# Decaying modes explain at least this share of the first third of the motion, and leave no more than that.
DECAYING_SHARE = 0.5
# Growing motion has at most this share of the energy: beyond that the motion is driven.
GROWN = 0.1
# Relative standard deviation of the best decay rate, at most. A higher limit accepts bumps of noise.
WORST_KNOWN = 0.14
# Share of the motion that may remain as a coloured residual without doubt.
DRIVEN = 0.03


def refused(trial: Trial) -> Refusal | None:
    """Return why a stretch is no free decay, or None if it is one."""
    if not len(trial.modes):
        others = sorted({str(reason) for reason in trial.selection.reasons if reason is not None})
        return DecayRemark.NO_MODE, {"others": tuple(others)}
    if trial.poles > MOST_DECAY_POLES:
        return DecayRemark.MANY_POLES, {"poles": trial.poles, "most": MOST_DECAY_POLES}
    spread = float(np.min(trial.rate_std))
    if spread > WORST_KNOWN:
        return DecayRemark.WEAK, {"share": spread}
    early = max(1, trial.motion.shape[1] // 3)
    motion = np.sum(trial.motion[:, :early] ** 2, axis=1)
    share = motion / (motion + np.sum(trial.residual[:, :early] ** 2, axis=1) + 1e-300)
    best = int(np.argmax(share))
    grown = np.sum(trial.growing**2, axis=1) / np.maximum(np.sum(trial.motion**2, axis=1), 1e-300)
    if grown[best] > GROWN:
        return DecayRemark.GROWING, {"share": float(grown[best])}
    left = float(trial.left[best])
    if left > DECAYING_SHARE:
        return DecayRemark.LEFT_OVER, {"share": left}
    if share[best] < DECAYING_SHARE:
        return DecayRemark.UNEXPLAINED, {"share": float(share[best])}
    return None


def decaying(trial: Trial | None) -> bool:
    """Return whether at least half of the poles of a fit are modes and none grows: more others fit a nonlinearity."""
    return trial is None or (2 * len(trial.modes) >= trial.poles and Reason.GROWING not in trial.selection.reasons)


def fits(trial: Trial) -> bool:
    """Return whether a trial fits its first part as well as the others and leaves no coloured residual."""
    return trial.excess <= 1 and float(np.max(trial.left)) <= DRIVEN


def drowned(trial: Trial, found: Envelopes, start: Second) -> Refusal | None:
    """Return a refusal if no mode of a stretch rises above the background of its own band, else None."""
    highest = -np.inf
    for theta in trial.selection.fit.poles.pairs[trial.modes]:
        frequency = abs(theta) / (2 * np.pi * trial.step)
        band = int(np.argmin(np.abs(np.log(found.centres / frequency))))
        first, last = np.searchsorted(found.timepts, [start, start + 1 / min(frequency, found.centres[band])])
        highest = max(highest, float(np.max(found.levels[band, max(0, first - 1) : last + 1])))
    return (DecayRemark.DROWNED, {"most": highest}) if highest < found.threshold - OWN_BAND else None
