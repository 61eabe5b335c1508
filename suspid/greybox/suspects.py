"""Channels with a wrong sign, or exchanged, that would explain a misfit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from suspid.greybox.measured_causes import WheelProblem, first_levels
from suspid.greybox.misfit import misfit_of
from suspid.greybox.settling import descended, released, settled
from suspid.units import RealArray
from suspid.words import Remark
from suspid.words.greybox import EstimateCheck


def suspect_of(problem: WheelProblem) -> Remark | None:
    """Return which channel has the wrong sign, or which two are exchanged, if the car then explains the records.

    The change that lets the car come nearest is tried in earnest.
    """
    changes = list(_changes(problem))
    if not changes:
        return None
    start = np.concatenate([problem.unknowns.nominal, problem.extras.start])

    def cost(changed: WheelProblem) -> float:
        levels = [first_levels(source) for source in changed.sources]
        return descended(changed, start, levels).cost

    remark, changed = min(changes, key=lambda change: cost(change[1]))
    first = [first_levels(source) for source in changed.sources]
    found, _ = released(changed, *settled(changed, start, first))
    misfit = misfit_of(found.every, [source.spectra.hertz for source in changed.sources])
    return remark if misfit.likely else None


def _changes(problem: WheelProblem) -> Iterator[tuple[Remark, WheelProblem]]:
    """Yield problems with one channel reversed, or two of one kind exchanged, in the records of one logger."""
    for number, source in enumerate(problem.sources):
        channels, orders = source.trial.channels, source.layout.orders
        every = np.arange(len(channels))
        # The sign of all channels together does not matter: that of the first output is that of the others.
        for i in every.tolist():
            if i != source.layout.outputs[0] or len(source.layout.outputs) > 1:
                sign = np.where(every == i, -1.0, 1.0)
                yield Remark(EstimateCheck.REVERSED, {"names": (channels[i],)}), _with(problem, number, every, sign)
        for i, j in combinations(every.tolist(), 2):
            if orders[i] == orders[j]:
                order = every.copy()
                order[i], order[j] = j, i
                names = (channels[i], channels[j])
                yield Remark(EstimateCheck.EXCHANGED, {"names": names}), _with(problem, number, order, 1.0)


def _with(
    problem: WheelProblem, number: int, order: np.ndarray[tuple[int], np.dtype[np.intp]], sign: RealArray | float
) -> WheelProblem:
    sources = list(problem.sources)
    spectra = sources[number].spectra
    changed = replace(spectra, values=np.ascontiguousarray(spectra.values[:, :, order] * sign))
    sources[number] = replace(sources[number], spectra=changed)
    return replace(problem, sources=tuple(sources))
