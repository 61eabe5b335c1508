"""Events: stretches of a recording whose power rises above the background."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from suspid.decays.envelopes import FOLD, Envelopes
from suspid.units import Decibel, Hertz, Second

# Rise of the level that makes a new event before the last one has ended. A smaller rise makes events of beating modes;
# a larger one misses a second event in the decay of the first.
RISE: Decibel = 8.0
# An event is over this far below the threshold, and half its length is kept after that. Less cuts off the end of weak
# modes; more adds noise alone.
OVER: Decibel = 8.0
AFTERWARDS = 0.5
# Bands count as ringing up to this far below the threshold. Less leaves out weak modes, more lets noise count.
RINGING: Decibel = 3.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Burst:
    """An event: a stretch whose power rises above the background."""

    onset: Second  # its beginning [s]
    peak: Second  # its peak [s]
    stop: Second  # its end or the beginning of the next one [s]
    level: Decibel  # power over background at the peak, in the strongest band and channel [dB]
    top: Hertz  # centre frequency of the highest band that rings after the onset [Hz]
    width: Second  # uncertainty of the onset: one period of the highest band that passes the threshold [s]
    cut: bool  # whether the next event begins before this one is over
    again: tuple[Second, ...] = ()  # times at which one of its bands rises again while others still decay [s]


def find_bursts(found: Envelopes) -> tuple[Burst, ...]:
    """Return the events in order of time."""
    from scipy.signal import find_peaks

    level, time = found.level, found.timepts
    peaks = find_peaks(np.r_[-np.inf, level, -np.inf], height=found.threshold, prominence=RISE)[0] - 1
    over = np.flatnonzero(level < found.threshold - OVER)
    starts = [_onset(found, int(a), int(b)) for a, b in zip(np.r_[0, peaks][:-1], peaks, strict=True)]
    out = []
    for index, ((onset, band), peak) in enumerate(zip(starts, peaks, strict=True)):
        after = over[np.searchsorted(over, peak) :]
        end = int(after[0]) if after.size else len(level) - 1
        last = min(int(end + AFTERWARDS * (end - onset)), len(level) - 1)
        following = starts[index + 1][0] if index + 1 < len(starts) else len(level)
        stop = max(min(last, following - 1), onset)
        rises = _rises(found, onset, stop)
        if following <= last:
            # Of the next event, slow bands show more than the one that tells its onset best.
            early = [onset + rise for rise, top in rises if onset + top == stop]
            stop = max(min([stop, *early]), onset)
            rises = [(rise, top) for rise, top in rises if onset + top <= stop]
        out.append(
            Burst(
                onset=float(time[onset]),
                peak=float(time[peak]),
                stop=float(time[stop]),
                level=float(level[peak]),
                top=_ringing(found, onset, band),
                width=float(1 / found.centres[band]),
                cut=bool(following <= end),
                again=tuple(float(time[onset + rise]) for rise, _ in rises),
            )
        )
    return tuple(out)


def died_down(found: Envelopes, burst: Burst) -> tuple[Burst, ...]:
    """Return the event from when its highest bands have died, each time at least twice as late as the last."""
    begin, end = np.searchsorted(found.timepts, [burst.onset, burst.stop])
    out, last = list[Burst](), int(begin)
    for band, centre in enumerate(found.centres[:-1]):
        ringing = np.flatnonzero(found.levels[: band + 1, begin:end].max(axis=0) > found.threshold - RINGING)
        after = begin + (int(ringing[-1]) + 1 if ringing.size else 0)
        if centre > burst.top or after - begin <= 2 * (last - begin) or 2 * (after - begin) > end - begin:
            continue
        onset, top, last = float(found.timepts[after]), float(found.centres[band + 1]), after
        out.append(replace(burst, onset=onset, peak=onset, top=top, width=1 / top, again=()))
    return tuple(out)


def _rises(found: Envelopes, begin: int, stop: int) -> list[tuple[int, int]]:
    """Return from where to where a band rises again within an event; of rises close together, that of the highest."""
    from scipy.signal import find_peaks

    out = list[tuple[int, int]]()
    for centre, levels in zip(found.centres, found.levels[:, begin : stop + 1], strict=True):
        apart = 2 / (centre * found.step)
        if len(levels) < 2 * apart:
            break
        tops = find_peaks(np.r_[-np.inf, levels, -np.inf], height=found.threshold, prominence=RISE)[0] - 1
        for before, top in pairwise(tops):
            least = before + int(np.argmin(levels[before : top + 1]))
            low = np.flatnonzero(levels[least:top] < 0.5 * (levels[least] + levels[top]))
            onset = least + (int(low[-1]) if low.size else 0)
            if onset > apart and all(abs(onset - other) > apart for other, _ in out):
                out.append((int(onset), int(top)))
    return sorted(out)


def _onset(found: Envelopes, since: int, peak: int) -> tuple[int, int]:
    """Return the point at which an event begins, and the highest band that shows it: that band is the most precise."""
    since += int(np.argmin(found.level[since : peak + 1]))
    for band, centre in enumerate(found.centres):
        period = int(np.ceil(1 / (centre * found.step)))
        levels = found.levels[band, since : peak + period + 1]
        top = int(np.argmax(levels))
        if levels[top] < found.threshold:
            continue
        least = int(np.argmin(levels[: top + 1]))
        low = max(found.threshold - OVER, 0.5 * (levels[least] + levels[top]))
        below = np.flatnonzero(levels[least:top] < low)
        begin = since + least + (int(below[-1]) + 1 if below.size else 0)
        return begin if begin > FOLD * period else 0, band
    return peak, len(found.centres) - 1


def _ringing(found: Envelopes, onset: int, highest: int) -> Hertz:
    """Return the centre of the highest band that rings from 1.5 to 4 of its periods after the onset [Hz]."""
    for centre, levels in zip(found.centres[highest:], found.levels[highest:], strict=True):
        early, late = (int(periods / (centre * found.step)) for periods in (1.5, 4.0))
        after = levels[onset + early : onset + late + 1]
        if after.size and np.median(after) > found.threshold - RINGING:
            return float(centre)
    return float(found.centres[-1])
