"""Swings that do not die as free ones do: of a machine that runs down, of what is driven less and less, of a beat."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from suspid.analysis.swings import least_turn, turns_above_noise
from suspid.identification import Identification
from suspid.samples import held
from suspid.signals import as_signal, block_means
from suspid.units import RealArray
from suspid.words import Check, Level, RecordCheck, Remark

# Swings that are needed, from the largest on, and the largest share of it that the last may have: where less is seen to
# fall, drifts decide.
FEWEST_SWINGS, MUCH_LEFT = 9, 0.5
# Samples that are left in a cycle, in means: more only cost time, a second for a million.
CYCLE_LEFT = 60.0
# How much more the swings may fall in the middle or in the last third of them than in the first: friction lets them
# fall alike, and by a third more where it grows as a mass slows down. How much larger than before they may be.
FALLS_LATER, GROWS_AGAIN = 1.6, 1.5
# Swings that are needed to see how their time changes. A machine runs down where it grows by more than the second
# number in all, and in the last third of them by more than this share of what it grows by in the first. Springs that
# stiffen make the time of a swing grow most at first, in proportion to the square of its size.
MANY_TIMES, MUCH_SLOWER, AS_MUCH_LATER = 20, 0.15, 0.5
# Swings that are still this many times as large as the smallest that is counted, and followed by none for as many of
# their times, do not die: what drives them is switched off, or a hand stops them.
ABOVE_SMALLEST, NONE_FOR = 2.0, 4.0


def doubts_of_swings(found: Identification) -> Iterator[Check]:
    """Yield the doubts that the swings of a single mode, in its clearest channel, are not those of free motion.

    Free motion falls most at first, or by the same amount each time where Coulomb friction alone acts.

    Examples
    --------
    >>> from suspid import identify
    >>> from suspid.records import as_response
    >>> t = np.arange(0, 10, 0.01)
    >>> free, beat = np.exp(-0.2 * t) * np.sin(9 * t), np.cos(0.15 * t) * np.sin(9 * t)
    >>> each = [identify(as_response(t, y[None], ["seat"])) for y in (free, beat)]
    >>> [[str(check.remark.code) for check in doubts_of_swings(found)] for found in each]
    [[], ['falls late']]
    """
    if len(found.modes) != 1 or not found.modes.poles[0].imag:
        return
    signal = as_signal(held(found, "response"))
    clearest = signal.values[[int(np.argmax(found.explained))]]
    spared = max(1, int(2 * np.pi / (CYCLE_LEFT * float(found.modes.wn[0]) * signal.step)))
    samples = block_means(clearest, spared)[0]
    sizes, times = _swings(samples)
    if _falls_late(sizes) or _is_stopped(samples, sizes, times):
        yield Check(Remark(RecordCheck.FALLS_LATE), Level.DOUBTFUL)
    elif _runs_down(sizes, times):
        yield Check(Remark(RecordCheck.RUNS_DOWN), Level.DOUBTFUL)


def _swings(samples: RealArray) -> tuple[RealArray, RealArray]:
    """Return the sizes of swings, from the largest on, and their times [sample], (swing,).

    Without the last, which a hand may have caught, or the end of a record cut.
    """
    turns = turns_above_noise(samples, float(np.ptp(samples)))
    sizes, times = np.abs(np.diff(samples[turns])), np.diff(turns).astype(float)
    first = int(np.argmax(sizes)) if sizes.size else 0
    return sizes[first:-1], times[first:-1]


def _at_thirds(each: RealArray) -> RealArray:
    """Return means of a few swings at the first, after one and two thirds of them, and at the last, (4,)."""
    third = len(each) // 3
    near = max(2, third // 4)
    starts = (0, third - near // 2, 2 * third - near // 2, len(each) - near)
    return np.array([each[start : start + near].mean() for start in starts])


def _falls_late(sizes: RealArray) -> bool:
    """Return whether swings fall more later on than at first, or grow again."""
    if len(sizes) < FEWEST_SWINGS:
        return False
    borders = _at_thirds(sizes)
    if np.any(borders[1:] > GROWS_AGAIN * borders[:-1]):
        return True
    if borders[-1] > MUCH_LEFT * borders[0]:
        return False
    first, *later = (-np.diff(borders)).tolist()
    return bool(max(later) > FALLS_LATER * first)


def _is_stopped(samples: RealArray, sizes: RealArray, times: RealArray) -> bool:
    """Return whether many swings that hardly fall are followed by none in their samples."""
    if len(sizes) < FEWEST_SWINGS:
        return False
    first, *_, last = _at_thirds(sizes).tolist()
    if last <= MUCH_LEFT * first:
        return False
    size = float(np.ptp(samples))
    after = len(samples) - turns_above_noise(samples, size)[-1]
    return bool(last > ABOVE_SMALLEST * least_turn(samples, size) and after > NONE_FOR * np.median(times))


def _runs_down(sizes: RealArray, times: RealArray) -> bool:
    """Return whether swings that shrink take longer and longer, later on as well as at first."""
    if len(sizes) < MANY_TIMES or sizes[-1] > MUCH_LEFT * sizes[0]:
        return False
    first, middle, last = np.diff(np.log(_at_thirds(times))).tolist()
    grows = min(first, middle, last) > 0 and first + middle + last > MUCH_SLOWER
    return bool(grows and last > AS_MUCH_LATER * first)
