"""Find the first sample from which an event decays freely."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from suspid.decays.bursts import Burst
from suspid.decays.predictions import SMALL_FORCE, freed_at
from suspid.decays.refusals import decaying, refused
from suspid.decays.sketches import LOOK_BLOCKS, clearly_driven
from suspid.decays.trials import Trial, tried
from suspid.decays.verification import LATEST_START
from suspid.levels import FEWEST_SAMPLES
from suspid.signals import Signal
from suspid.units import RealArray

# Starts are tried at delays that grow by this factor, up to `LATEST_START`. Then the interval between the
# last start that fails and the first that holds is halved this often. A smaller factor and more halvings give a more
# precise start and cost time.
LATER, HALVINGS = 1.4, 2
# These starts are tried first, over `LOOK_BLOCKS`. The stretch is refused if each of them is.
LOOKS = 1, 6, 11
# A start holds if this many later starts need no fewer poles, because poles that fit the excitation disappear then.
LATER_STARTS = 2
# If no start holds, the search ends this many periods of the highest band after the start with the least residual, if
# that leaves less than this share of the motion.
MORE_PERIODS, FITTING = 4, 0.5
# A fit that cannot reach the noise is good to this share of the motion; more precise ones spend poles on friction.
ROUGH_FIT = 0.1
# A start that does not hold is as good as the best if its residual is at most this many times as large.
AS_GOOD = 1.5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Start:
    """The first sample from which an event decays freely."""

    begin: int  # its number
    trial: Trial | None  # the fit from there; None if there is none
    driven: bool = False  # whether the event is driven motion throughout
    linear: bool = True  # whether damped exponentials were found to fit; if not, the motion told the start


def find_start(
    signal: Signal,
    least: RealArray,
    burst: Burst,
    first: int,
    last: int,
    size: int,
    clipped: NDArray[np.bool_],
    finest: RealArray,
    *,
    latest: float = LATEST_START,
) -> Start:
    """Return the first sample from which an event decays freely.

    The event has the samples ``first`` to ``last`` (excluded), averaged in blocks of ``size``; ``least`` is the lower
    bound of the variance of the noise in a block, ``finest`` the standard deviation of the rounding error of a sample,
    (channel,). A start lies before the share ``latest`` of it. Clipped samples early in the event are left out. Where
    no damped exponentials fit, the start is that from which the motion is predicted by itself, and the fit is no better
    than that motion is linear.
    """

    @cache
    def at(place: int) -> Trial | None:
        return tried(signal.values[:, place:last], step=signal.step, size=size, least=least)

    @cache
    def driven(place: int) -> bool:
        long_enough = (last - place) // size >= FEWEST_SAMPLES
        return long_enough and clearly_driven(signal.values[:, place:last], size=size)

    def look(place: int) -> Trial | None:
        return tried(signal.values[:, place:last], step=signal.step, size=size, least=least, most=LOOK_BLOCKS)

    early = np.flatnonzero(clipped[first : first + (last - first) // 4])
    begin = first + (int(early[-1]) + 1 if early.size else 0)
    may, free = _free(signal, least, (begin, last), size, finest, latest)
    if free is not None and _nonlinear(free, look):
        return free
    begin = may
    places = _places(begin, last, pace=max(1.0, 0.25 * burst.width / signal.step))
    promising, seen = free is not None, None
    if not promising:
        promising, seen = _look([places[n] for n in LOOKS if n < len(places)], look, driven)
    if not promising and len(places) > 1:
        return Start(begin=begin, trial=seen, driven=seen is None)
    found, residuals = None, list[tuple[float, int]]()
    if promising:
        patience = MORE_PERIODS * burst.width / signal.step
        found, residuals = _search(
            places, at, driven, patience=patience, sure=free.begin if free is not None else begin
        )
    if found is not None and free is not None and found.trial is not None and refused(found.trial) is not None:
        return free
    if found is not None or free is not None:
        return found or free or Start(begin=begin, trial=None)
    if not residuals:
        all_driven = all(map(driven, places))
        return Start(begin=begin, trial=None if all_driven else at(begin), driven=all_driven)
    place = next(place for residual, place in residuals if residual <= AS_GOOD * min(residuals)[0])
    return Start(begin=place, trial=at(place))


def _free(
    signal: Signal, least: RealArray, samples: tuple[int, int], size: int, finest: RealArray, latest: float
) -> tuple[int, Start | None]:
    """Return from where the motion may be free, and the start from which it is; None if no mode decays from there."""
    first, last = samples
    may, sure = freed_at(signal.values[:, first:last], finest, step=signal.step)
    values = signal.values[:, first + sure : last]
    size = min(size, max(1, values.shape[1] // (2 * FEWEST_SAMPLES)))
    if sure > latest * (last - first) or values.shape[1] < FEWEST_SAMPLES * size or clearly_driven(values, size=size):
        return first, None
    rough = np.maximum(least, ROUGH_FIT**2 * np.var(values, axis=1))
    trial = tried(values, step=signal.step, size=size, least=rough)
    lost = trial is None or refused(trial) is not None
    return first + may, None if lost else Start(begin=first + sure, trial=trial, linear=False)


def _nonlinear(free: Start, look: Callable[[int], Trial | None]) -> bool:
    """Return whether the motion is more than a few modes that decay."""
    return free.trial is not None and free.trial.early > SMALL_FORCE and not decaying(look(free.begin))


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
    places: Sequence[int],
    at: Callable[[int], Trial | None],
    driven: Callable[[int], bool],
    *,
    patience: float,
    sure: int,
) -> tuple[Start | None, list[tuple[float, int]]]:
    """Return the first start that holds, or None, and the early residuals of those that do not, with their places.

    From the sample ``sure`` on the motion is known to be free: a start before it needs no more poles than that.
    """
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
            after = [at(later) for later in (*places[number + 1 : number + 1 + LATER_STARTS], max(place, sure))]
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
