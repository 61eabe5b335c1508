"""Find the first sample from which an event decays freely."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from suspid.decays.bursts import Burst
from suspid.decays.refusals import refused
from suspid.decays.sketches import clearly_driven
from suspid.decays.trials import FEWEST_BLOCKS, Trial, tried
from suspid.signals import Signal
from suspid.units import RealArray

# Starts are tried at delays that grow by this factor, up to this share of the stretch. Then the interval between the
# last start that fails and the first that holds is halved this often. A smaller factor and more halvings give a more
# precise start and cost time.
LATER, LATEST_START, HALVINGS = 1.4, 0.4, 2
# These starts are tried first, over this many blocks. The stretch is refused if each of them is.
LOOKS, LOOK_BLOCKS = (1, 6, 11), 300
# A start holds if this many later starts need no fewer poles, because poles that fit the excitation disappear then.
NEXT = 2
# If no start holds, the search ends this many periods of the highest band after the start with the least residual, if
# that leaves less than this share of the motion.
MORE_PERIODS, FITTING = 4, 0.5
# A start that does not hold is as good as the best if its residual is at most this many times as large.
AS_GOOD = 1.5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Start:
    """The first sample from which an event decays freely."""

    begin: int  # its number
    trial: Trial | None  # the fit from there; None if there is none
    driven: bool = False  # whether the event is driven motion throughout


def find_start(
    signal: Signal, least: RealArray, burst: Burst, first: int, last: int, size: int, clipped: NDArray[np.bool_]
) -> Start:
    """Return the first sample from which an event decays freely.

    The event has the samples ``first`` to ``last`` (excluded), averaged in blocks of ``size``; ``least`` is the lower
    bound of the variance of the noise in a block, (channel,). Clipped samples early in the event are left out.
    """

    @cache
    def at(place: int) -> Trial | None:
        return tried(signal.values[:, place:last], step=signal.step, size=size, least=least)

    @cache
    def driven(place: int) -> bool:
        long_enough = (last - place) // size >= FEWEST_BLOCKS
        return long_enough and clearly_driven(signal.values[:, place:last], size=size)

    def look(place: int) -> Trial | None:
        return tried(signal.values[:, place:last], step=signal.step, size=size, least=least, most=LOOK_BLOCKS)

    early = np.flatnonzero(clipped[first : first + (last - first) // 4])
    begin = first + (int(early[-1]) + 1 if early.size else 0)
    places = _places(begin, last, pace=max(1.0, 0.25 * burst.width / signal.step))
    promising, seen = _look([places[n] for n in LOOKS if n < len(places)], look, driven)
    if not promising and len(places) > 1:
        return Start(begin=begin, trial=seen, driven=seen is None)
    found, residuals = _search(places, at, driven, patience=MORE_PERIODS * burst.width / signal.step)
    if found is not None:
        return found
    if not residuals:
        return (
            Start(begin=begin, trial=None, driven=True)
            if all(map(driven, places))
            else Start(begin=begin, trial=at(begin))
        )
    place = next(place for residual, place in residuals if residual <= AS_GOOD * min(residuals)[0])
    return Start(begin=place, trial=at(place))


def _places(begin: int, last: int, *, pace: float) -> list[int]:
    """Return the starts to try: delays that grow from ``pace`` samples on."""
    delays = [0.0, pace]
    while delays[-1] * LATER < LATEST_START * (last - begin):
        delays.append(delays[-1] * LATER)
    return list(dict.fromkeys(begin + round(delay) for delay in delays))


def _look(
    places: Sequence[int], look: Callable[[int], Trial | None], driven: Callable[[int], bool]
) -> tuple[bool, Trial | None]:
    """Return whether a start among a few may hold, and the first fit seen."""
    seen: Trial | None = None
    for place in places:
        if not driven(place):
            trial = look(place)
            if trial is None or refused(trial) is None:
                return True, trial
            seen = seen or trial
    return False, seen


def _search(
    places: Sequence[int], at: Callable[[int], Trial | None], driven: Callable[[int], bool], *, patience: float
) -> tuple[Start | None, list[tuple[float, int]]]:
    """Return the first start that holds, or None, and the early residuals of those that do not, with their places."""
    residuals: list[tuple[float, int]] = []
    for number, place in enumerate(places):
        if driven(place):
            continue
        trial = at(place)
        if trial is None:
            break
        if not len(trial.modes):
            continue
        if trial.excess <= 1:
            after = [at(later) for later in places[number + 1 : number + 1 + NEXT]]
            if all(later is None or later.poles >= trial.poles for later in after):
                return _earlier(at, places[number - 1] if number else place, place), residuals
        residuals.append((trial.early, place))
        least, best = min(residuals)
        if least < FITTING and place - best > patience:
            break
    return None, residuals


def _earlier(at: Callable[[int], Trial | None], low: int, high: int) -> Start:
    """Return the earliest start that holds, between one that does not and one that does, by halving."""
    found = at(high)
    for _ in range(HALVINGS):
        middle = (low + high) // 2
        trial = at(middle) if middle not in (low, high) else None
        if found is None or trial is None:
            break
        if trial.excess <= 1 and len(trial.modes) and trial.poles <= found.poles:
            high, found = middle, trial
        else:
            low = middle
    return Start(begin=high, trial=found)
