"""Swings that shrink one after the other: a motion that an eye sees to be free where nothing is calm beside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.analysis.swings import AT_REST, EVEN_SWINGS, turns_above_noise, turns_of
from suspid.signals import Signal
from suspid.units import RealArray, Second

# Swings that shrink one after the other, from the largest of the record on. Fewer are common in a resonance that noise
# drives; that swells again to more than this share of the largest.
SHRINKING_SWINGS, SWELLS_AGAIN = 8, 0.5
# Half of a beat shrinks too, hardly at first and most before its node: the first third of free swings falls at this
# share of the rate of all at least.
FALLS_AT_ONCE = 1 / 3
# Where a knock is larger than any swing, more of them must shrink, over this part of the record, their means over two
# cycles at least and over this share of all swings: single ones are as large as the noise lets them be.
MANY_SHRINKING, PART_OF_RECORD, SWINGS_TOGETHER, SHARE_TOGETHER = 16, 0.5, 4, 1 / 16
# The range of a channel without the largest and the smallest samples: those of a knock. Turns by less than the share
# of it that follows may be those of a ripple on the swings.
WITHOUT_KNOCK, RIPPLE_TURNS = (0.02, 0.98), 0.2


def shrinking(signal: Signal) -> tuple[Second, Second] | None:
    """Return from when to when swings shrink from the largest one on, in the channel with most of them; None if few do.

    What fills a record has no calm part to stand out from, and one that bends looks like new events all the while.
    """
    runs = [run for samples in signal.values if (run := _shrinking_run(samples)) is not None]
    if not runs:
        return None
    _, first, last = max(runs, key=lambda run: run[0])
    return signal.start + signal.step * first, signal.start + signal.step * last


def _shrinking_run(samples: RealArray) -> tuple[int, int, int] | None:
    """Return how many swings shrink from the largest one on, and the first and last sample of them; None if few do."""
    turns = turns_of(samples, AT_REST * float(np.ptp(samples)))
    sizes, times = np.abs(np.diff(samples[turns])), np.diff(turns)
    if len(sizes) < SHRINKING_SWINGS:
        return None
    first = int(np.argmax(sizes))
    grows = np.flatnonzero(np.diff(sizes[first:]) >= 0)
    last = first + (int(grows[0]) if grows.size else len(sizes) - 1 - first) + 1
    uneven = np.flatnonzero(np.abs(times[first:last] / np.median(times[first:last]) - 1) > EVEN_SWINGS)
    # What was held, and what swings far, takes longer at first.
    first += int(uneven[-1]) + 1 if uneven.size else 0
    if last - first < SHRINKING_SWINGS or np.any(sizes[last:] > SWELLS_AGAIN * sizes[first]):
        return None
    if not _falls_at_once(sizes[first:last]):
        return None
    return last - first, int(turns[first]), len(samples) - 1 if last == len(sizes) else int(turns[last])


def longest_shrinking(signal: Signal) -> tuple[str, Second, Second] | None:
    """Return the channel whose swings shrink for longest, and from when to when; None if none do for long."""
    best: tuple[str, int, int] | None = None
    for name, samples in zip(signal.channels, signal.values, strict=True):
        run = _long_run(samples)
        if run is not None and (best is None or run[1] - run[0] > best[2] - best[1]):
            best = (name, *run)
    if best is None or best[2] - best[1] < PART_OF_RECORD * signal.values.shape[1]:
        return None
    return best[0], signal.start + signal.step * best[1], signal.start + signal.step * best[2]


def _long_run(samples: RealArray) -> tuple[int, int] | None:
    """Return the first and last sample of the longest run of swings of which some cycles are less than those before.

    None where that has few. Where a ripple on the swings has turns of its own, larger ones are looked at alone.
    """
    low, high = np.quantile(samples, WITHOUT_KNOCK)
    if not high > low:
        return None
    return _run_of(samples, turns_above_noise(samples, float(high - low))) or _run_of(
        samples, turns_of(samples, RIPPLE_TURNS * float(high - low))
    )


def _run_of(samples: RealArray, turns: NDArray[np.intp]) -> tuple[int, int] | None:
    """Return the first and last sample of the longest run of swings between these turns; None where it has few."""
    if len(turns) <= MANY_SHRINKING:
        return None
    times = np.sort(np.diff(turns))
    # Half of the time of all swings is that of longer ones: a knock has many short ones.
    usual = times[int(np.searchsorted(np.cumsum(times), times.sum() / 2))]
    swings = np.abs(np.diff(samples[turns]))
    count = max(SWINGS_TOGETHER, int(SHARE_TOGETHER * len(swings)))
    sizes, lasting = (np.convolve(each, np.full(count, 1 / count), "valid") for each in (swings, np.diff(turns)))
    even = np.abs(lasting / usual - 1) < EVEN_SWINGS
    falls = (sizes[count:] < sizes[:-count]) & even[count:] & even[:-count]
    first, last = _longest_true(falls)
    # Swings, the last of which are compared with those before.
    last += 2 * count - 1
    if last - first < max(MANY_SHRINKING, 3 * count):
        return None
    if not _falls_at_once(sizes[first : last - count + 1]):
        return None
    return int(turns[first]), int(turns[last])


def _falls_at_once(sizes: RealArray) -> bool:
    """Return whether swings fall in their first third as they do in all, and not as half of a beat."""
    falls = -np.diff(np.log(sizes))
    return bool(np.mean(falls[: len(falls) // 3]) >= FALLS_AT_ONCE * np.mean(falls))


def _longest_true(which: NDArray[np.bool_]) -> tuple[int, int]:
    """Return where the longest run of true values begins, and where it has ended.

    Examples
    --------
    >>> _longest_true(np.array([True, False, True, True, False]))
    (2, 4)
    """
    edges = np.flatnonzero(np.diff(which.astype(int), prepend=0, append=0))
    if not edges.size:
        return 0, 0
    longest = 2 * int(np.argmax(edges[1::2] - edges[::2]))
    return int(edges[longest]), int(edges[longest + 1])
