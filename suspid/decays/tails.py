"""The free end of a record that is driven before: its motion is followed backwards from the end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from suspid.decays.predictions import at_rest_from, frequencies
from suspid.decays.refusals import fits, refused
from suspid.decays.sketches import LOOK_BLOCKS, clearly_driven
from suspid.decays.trials import BLOCKS_A_CYCLE, Trial, block_size, tried
from suspid.levels import FEWEST_SAMPLES
from suspid.signals import Signal
from suspid.units import RealArray

# Ends of the record that are tried grow by this factor, from the smallest to the largest share of it. A smaller factor
# finds shorter free ends and costs time.
LONGER, SHORTEST_END, LONGEST_END = 1.25, 0.05, 0.95
# Halvings between the longest end that is free and the next one, which is not.
TAIL_HALVINGS = 5
# An end is free where this many in a row are: a short one is explained by chance.
IN_A_ROW = 2
# Pairs of poles that are sought: a free end has few. More follow forced motion, and take most of the time.
END_PAIRS = 6
# Blocks of a single channel that each of them needs, three cycles of the highest one: more poles follow short forced
# motions by chance.
BLOCKS_A_POLE = 3 * BLOCKS_A_CYCLE


def free_end(signal: Signal, finest: RealArray) -> tuple[int, int] | None:
    """Return the samples between which the end of a record is a free decay, the last excluded; None where it is not.

    Longer and longer ends are fitted, as long as damped exponentials explain them down to noise with no more poles.

    Parameters
    ----------
    signal : Signal
        The recording.
    finest : ndarray (channel,)
        Standard deviation of the rounding and quantisation error of each channel.

    Examples
    --------
    A mass is shaken for 4 s and then let alone:

    >>> from scipy.signal import lfilter
    >>> rng = np.random.default_rng(1)
    >>> force = np.where(np.arange(1200) < 400, rng.standard_normal(1200), 0.0)
    >>> motion = lfilter([1.0], [1.0, -1.97, 0.985], force) + 0.01 * rng.standard_normal(1200)
    >>> first, last = free_end(Signal(start=0.0, step=0.01, values=motion[None], channels=("seat",)), np.zeros(1))
    >>> 395 <= first <= 450, last
    (True, 1200)
    """
    last = at_rest_from(signal.values, finest)
    count = int(np.log(LONGEST_END / SHORTEST_END) / np.log(LONGER))
    places = [last - round(SHORTEST_END * LONGER**n * last) for n in range(count + 1)]
    begin = free_since(signal, finest, places, last)
    return None if begin is None else (begin, last)


def free_since(
    signal: Signal, finest: RealArray, places: Sequence[int], last: int, *, reach: int = 0, patience: int | None = None
) -> int | None:
    """Return the first sample from which a record is a free decay until the last one, which is excluded.

    Of starts that are ever earlier, those are free from which damped exponentials explain the motion down to noise,
    with no more poles than from the next later one, and from all others at most ``reach`` samples later: poles that
    follow the end of a force are gone then. None where no two of them are in a row. Earlier starts than those are not
    tried after as many as ``patience`` that are not free, and none where not one of a few is.
    """

    @cache
    def at(first: int) -> Trial | None:
        values = signal.values[:, first:last]
        if values.shape[1] < FEWEST_SAMPLES:  # A clipped sensor may seem to rest all the time.
            return None
        top, _ = frequencies(values, finest, signal.step)
        size = min(block_size(signal.step, top), max(1, values.shape[1] // (2 * FEWEST_SAMPLES)))
        if values.shape[1] < FEWEST_SAMPLES * size or clearly_driven(values, size=size):
            return None
        trial = tried(values, step=signal.step, size=size, least=finest**2 / size, most=LOOK_BLOCKS, sought=END_PAIRS)
        if trial is None or _blocks_of_one(trial) < BLOCKS_A_POLE * trial.poles:
            return None
        return trial if refused(trial) is None and fits(trial) else None

    if patience is not None and all(at(place) is None for place in places[:: max(1, patience // 2)]):
        return None
    frees = list[bool]()
    for place in places:
        frees.append(at(place) is not None)
        enough = len(_longest_run(frees)) >= IN_A_ROW
        if patience is not None and enough and not any(frees[-patience:]):
            break
    free = _longest_run(frees)
    # A pole that only the longest end needs follows the force before it.
    while len(free) > 1:
        later = [k for k in free[:-1] if places[k] <= places[free[-1]] + reach] or [free[-2]]
        if _poles(at(places[free[-1]])) <= min(_poles(at(places[k])) for k in later):
            break
        free = free[:-1]
    if len(free) < IN_A_ROW:
        return None
    before = free[-1] + 1
    return _earliest(at, places[before] if before < len(places) else 0, places[free[-1]])


def _blocks_of_one(trial: Trial) -> float:
    """Return of how many blocks a single channel has as many samples for each unknown of a pole.

    A pole has its frequency and decay once, and two amplitudes in each channel.
    """
    channels, blocks = trial.residual.shape
    return float(2 * channels / (channels + 1) * blocks)


def _longest_run(free: Sequence[bool]) -> range:
    """Return the numbers of the longest run of ends that are free, the last one where several are as long."""
    edges = np.flatnonzero(np.diff(np.r_[False, free, False]))
    runs = [range(int(first), int(after)) for first, after in zip(edges[::2], edges[1::2], strict=True)]
    return max(reversed(runs), key=len, default=range(0))


def _poles(trial: Trial | None) -> int:
    return 0 if trial is None else trial.poles


def _earliest(at: Callable[[int], Trial | None], low: int, high: int) -> int:
    """Return the earliest start between one from which the motion is not free and one from which it is, by halving."""
    for _ in range(TAIL_HALVINGS):
        middle = (low + high) // 2
        if at(middle) is not None and _poles(at(middle)) <= _poles(at(high)):
            high = middle
        else:
            low = middle
    return high
