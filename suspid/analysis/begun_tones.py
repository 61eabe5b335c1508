"""Tones that begin with a decay: what turns does not begin to turn with a release, and a slow mode does."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.identification import Considered, Identification
from suspid.levels import SURE
from suspid.records import of_channels
from suspid.samples import held
from suspid.signals import Signal, as_signal
from suspid.units import ComplexArray, Second
from suspid.words import Reason, Remark

if TYPE_CHECKING:
    import control

# A tone is another motion than before a decay if it differs by this share of its size and this many standard
# deviations. It is compared over its last cycles before: in fewer than the first number, what leads to a release is of
# all frequencies; over more than the second, what turns wanders.
ANOTHER_MOTION, LEAST_BEFORE, MOST_BEFORE = 0.5, 3.0, 10.0
# It goes on where it is the same motion up to any of these cycles before the decay, which may begin some samples late.
ENDS_BEFORE = (0.0, 1.0, 3.0)
# Samples that tell a size: more cost memory only. Nepers beyond which what grows would have left any range.
SAMPLES_ENOUGH, MOST_GROWN = 100_000, 50.0


def with_begun_tones(found: Identification, whole: control.TimeResponseData) -> Identification:
    """Return an identification of a part of a record that says which of its tones begin with that part.

    Examples
    --------
    >>> from suspid import as_record, identify
    >>> from suspid.records import cut
    >>> t = np.arange(-2000, 1000) / 500
    >>> fast, slow = np.exp((-4 + 90j) * t).imag, np.exp((-0.02 + 20j) * t).imag
    >>> noise = 0.03 * np.random.default_rng(1).standard_normal(t.size)
    >>> hums, swings = (as_record(np.where(t < 0, before, fast + slow) + noise, timepts=t) for before in (slow, 0 * t))
    >>> for record in (hums, swings):
    ...     told = with_begun_tones(identify(cut(record, start=0.0)), record)
    ...     print([one.reason for one in told.considered if one.removed])
    ['steady tone: no decay is seen within the record']
    ['a slow mode or a tone: it begins with the decay, and is not seen to fade within it']
    """
    tones = [k for k, one in enumerate(found.considered) if _is_steady(one)]
    if not tones or not len(found.modes):
        return found
    part = as_signal(held(found, "response"))
    signal = as_signal(of_channels(whole, part.channels))
    considered = list(found.considered)
    removed = [one.pole for one in found.considered if one.removed]
    inside = _sizes(np.array([*removed, *found.modes.poles]), part, part.start)
    for k in tones:
        pole = considered[k].pole
        size = inside[removed.index(pole)]
        channel = int(np.argmax(np.abs(size) / np.maximum(found.noise_std, 1e-300)))
        before = [_before(signal, part.start, 2 * np.pi / abs(pole.imag), cycles) for cycles in ENDS_BEFORE]
        told = [each for each in before if each is not None]
        apart = [
            abs(size[channel] - _sizes(np.array([1j * pole.imag, *found.modes.poles]), each, part.start)[0, channel])
            - SURE * found.noise_std[channel] * np.sqrt(2 / each.values.shape[1])
            for each in told
        ]
        if apart and min(apart) > ANOTHER_MOTION * abs(size[channel]):
            considered[k] = replace(considered[k], remark=Remark(Reason.TONE, {"begun": True}))
    return replace(found, considered=tuple(considered))


def _before(signal: Signal, start: Second, cycle: Second, cycles: float) -> Signal | None:
    """Return the last cycles of a record up to some before a decay starts; None where there are too few."""
    time, end = signal.timepts, start - cycles * cycle
    reach = (time < end - 0.5 * signal.step) & (time >= end - MOST_BEFORE * cycle)
    if np.sum(reach) * signal.step < LEAST_BEFORE * cycle:
        return None
    return replace(signal, values=signal.values[:, reach], start=float(time[reach][0]))


def _is_steady(one: Considered) -> bool:
    return one.removed and one.remark.code is Reason.TONE and not one.remark.numbers


def _sizes(poles: ComplexArray, signal: Signal, at: Second) -> ComplexArray:
    """Return the amplitude and phase, at a time, of the motion of each pole in each channel, (pole, channel)."""
    every = 1 + signal.values.shape[1] // SAMPLES_ENOUGH
    time, values = signal.timepts[::every] - at, signal.values[:, ::every]
    first = time[0] if time[0] < 0 else 0.0
    # Of decays before that time, what counts is their size where the samples begin.
    grown = np.minimum(poles.real * (time - first)[:, None], MOST_GROWN)
    courses = np.exp(grown + 1j * poles.imag * time[:, None])
    columns = np.concatenate([courses.real, -courses.imag, np.vander(np.linspace(-1, 1, len(time)), 3)], axis=1)
    parts = np.linalg.lstsq(columns, values.T, rcond=1e-12)[0]
    return np.asarray(parts[: len(poles)] + 1j * parts[len(poles) : 2 * len(poles)])
