"""Intervals of modes that a background excites during their decay."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from suspid.analysis.used import Used
from suspid.decays import FEWEST_STRETCHES
from suspid.identification import Identification, with_changes
from suspid.levels import NORMAL_MEDIAN
from suspid.records import of_channels
from suspid.samples import held
from suspid.signals import Signal, as_signal, block_means
from suspid.units import RealArray
from suspid.words import DecayDoubt, Note, Remark

if TYPE_CHECKING:
    import control

# Stretches end where the slowest mode has fallen by the first number [neper], as longer ones hold other decays. Each
# sample is in as many of them as the second number says; a long recording gives the third number, further apart.
FALLS_BY, LAPS, MOST_LAPS = 5.0, 4, 400
# Standard deviations that are less than this many times as large are not worth a word.
LEAST_SAID = 1.1


def with_background(
    found: Identification, stretch: Used, whole: control.TimeResponseData
) -> tuple[Identification, Used]:
    """Return an identification whose intervals hold what a background does that excites modes during the decay.

    They assume white noise, or noise as loud as what the fit leaves near a mode. A fit follows part of the background
    with poles of its own and bends the mode. What is used comes with a note on how much wider they are.
    """
    doubted = any(doubt.code is DecayDoubt.BACKGROUND for decay in stretch.used for doubt in decay.doubts)
    before = found.modes
    if len(stretch.used) != 1 or not doubted or before.covariance is None or not len(before):
        return found, stretch
    spread = _spread(found, as_signal(of_channels(whole, before.channels)))
    modes = with_changes(before, (np.asarray(spread[:, 0], complex), np.asarray(1j * spread[:, 1], complex)))
    assert before.wn_std is not None
    assert modes.wn_std is not None
    times = modes.wn_std / before.wn_std
    wider = np.flatnonzero(times > LEAST_SAID)
    if not wider.size:
        return found, stretch
    said = Remark(Note.WIDENED, {"modes": tuple((wider + 1).tolist()), "times": tuple(times[wider].tolist())})
    return replace(found, modes=modes), replace(stretch, notes=(*stretch.notes, said))


def _spread(found: Identification, signal: Signal) -> RealArray:
    """Return what a background changes of the poles, as standard deviations of Re and Im of each, (mode, 2).

    A change of the samples changes the poles of a fit by its projection on the derivatives of the fit, beside all that
    amplitudes and levels follow. Each stretch of the recording does that; other decays among them are few.
    """
    from scipy.linalg import orth

    part, fitted = as_signal(held(found, "response")), as_signal(held(found, "fitted"))
    step, poles = part.step, found.modes.poles
    # What was found in means over samples is compared with the same means.
    values = block_means(signal.values, max(1, round(step / signal.step)))
    count = int(min(part.values.shape[1], np.max(FALLS_BY / np.maximum(-poles.real * step, 1e-12))))
    hop = max(1, count // LAPS, values.shape[1] // MOST_LAPS)
    if values.shape[1] < FEWEST_STRETCHES * count or count < 3 + 4 * len(poles):
        return np.zeros((len(poles), 2))
    stretches = sliding_window_view(values, count, axis=1)[:, ::hop]
    time = step * np.arange(count)
    courses = np.exp(poles[:, None] * time)
    levels = np.vander(np.linspace(-1, 1, count), 3)
    columns = np.concatenate([courses.real, -courses.imag, levels.T]).T
    linear = orth(columns)
    moves, changes = [], []
    for channel, samples in enumerate(fitted.values[:, :count]):
        parts = np.linalg.lstsq(columns, samples, rcond=None)[0]
        amplitudes = parts[: len(poles)] + 1j * parts[len(poles) : 2 * len(poles)]
        along = amplitudes[:, None] * courses * time
        slopes = np.stack([along.real, -along.imag], axis=1).reshape(2 * len(poles), count).T
        scale = max(float(found.noise_std[channel]), 1e-300)
        moves.append((slopes - linear @ (linear.T @ slopes)) / scale)
        changes.append(stretches[channel] / scale)
    every = np.concatenate(moves)
    answer = np.linalg.pinv(every)
    shifts = answer @ np.concatenate(changes, axis=1).T  # (part of a pole, stretch)
    return np.asarray(np.median(np.abs(shifts), axis=1).reshape(-1, 2) / NORMAL_MEDIAN)
