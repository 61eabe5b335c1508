"""The largest motion of a record, where the search for decays ends without a result: what an eye would cut out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import damping_known, tried
from suspid.analysis.far_larger import hardly_any, larger_elsewhere
from suspid.analysis.longer import shared_modes
from suspid.analysis.settings import Settings
from suspid.analysis.stretch import swings
from suspid.analysis.support import questioned
from suspid.analysis.swings import AT_REST, EVEN_SWINGS, turns_of
from suspid.analysis.used import Used, instead_of
from suspid.identification import FEWEST_SAMPLES, Identification
from suspid.records import cut, of_channels
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.words import Level, Note, Remark

if TYPE_CHECKING:
    import control

# Parts of a record in which its motion is compared, of at least this many samples.
PARTS_COMPARED, FEWEST_EACH = 40, 8
# It moves this many times as much as the calmest tenth of them: noise that wanders does not.
STANDS_OUT = 10.0
# A motion lasts until a part moves less than this multiple of what the calmest tenth does, or than this share of the
# largest.
CALM_AGAIN, FADED = 1.5, 0.01
# Swings that shrink one after the other, from the largest of the record on. Fewer are common in a resonance that noise
# drives; that swells again to more than this share of the largest.
SHRINKING_SWINGS, SWELLS_AGAIN = 8, 0.5
# Half of a beat shrinks too, hardly at first and most before its node: the first third of free swings falls at this
# share of the rate of all at least, and the damping from the first and from the last start on is alike to this factor.
FALLS_AT_ONCE, DAMPED_ALIKE = 1 / 3, 1.5
# Shares of the motion after which it may be free: what lets it go acts for a while.
STARTS_TRIED = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4)
# Other starts that must show the same modes, for a result that is not doubtful and for one that is.
AGREE, AGREE_DOUBTFUL = 1, 2
# A motion of more samples than the first number takes seconds for each start: fewer are tried then. One of more than
# the second is a drive more often than a decay.
LONG, FEWER_STARTS, LONGEST_TRIED = 50_000, (0.0, 0.1, 0.4), 250_000
# A fit explains this share of the energy of a channel where its modes are the largest motion.
MOST_OF_IT = 0.8


def of_largest(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the largest motion of a record where modes are the same from several starts; None if they are not.

    ``found`` is what the search for decays led to: nothing else is sought where that has modes, unless it is doubtful
    and the record moves far more elsewhere or the decay has next to nothing of its motion. The first start is used
    whose modes another shows too.
    """
    if not questioned(found, settings):
        return None
    if len(found.modes) and found.verdict.level is not Level.DOUBTFUL:
        return None
    if len(found.modes) and not (hardly_any(record, stretch) or larger_elsewhere(record, stretch)):
        return None
    record = of_channels(record, as_signal(stretch.record).channels)
    signal = as_signal(record)
    stands_out = _largest(signal)
    span = stands_out or _shrinking(signal)
    if span is None:
        return None
    first, last = span
    count = (last - first) / signal.step
    if not FEWEST_SAMPLES / (1 - STARTS_TRIED[-1]) <= count <= LONGEST_TRIED:
        return None
    shares = STARTS_TRIED if count <= LONG else FEWER_STARTS
    parts = [cut(record, start=first + share * (last - first), stop=last) for share in shares]
    tries = [tried(part, settings) for part in parts]
    if stands_out is None and not _as_damped_later(tries):
        return None
    levels = ((Level.CARE, AGREE),) if len(found.modes) else ((Level.CARE, AGREE), (Level.DOUBTFUL, AGREE_DOUBTFUL))
    for level, others in levels:
        for part, one in zip(parts, tries, strict=True):
            if one is not None and _plain(one, level) and _agreeing(one, tries, level) >= others:
                said = {"start": as_signal(part).start, "stop": last}
                used = Used(record=part, decays=stretch.decays, used=(), notes=(Remark(Note.LARGEST_USED, said),))
                return replace(instead_of(stretch, used), identification=one)
    return None


def _largest(signal: Signal) -> tuple[Second, Second] | None:
    """Return from when to when a record moves most; None if it is too short to tell, or none stands out."""
    each = signal.values.shape[1] // PARTS_COMPARED
    if each < FEWEST_EACH:
        return None
    parts = signal.values[:, : PARTS_COMPARED * each].reshape(len(signal.values), PARTS_COMPARED, each)
    moves = np.max(np.ptp(parts, axis=2) / np.maximum(np.ptp(signal.values, axis=1), 1e-300)[:, None], axis=0)
    most, calmest = int(np.argmax(moves)), float(np.quantile(moves, 0.1))
    if moves[most] < STANDS_OUT * calmest:
        return None
    calm = np.flatnonzero(moves[most:] < max(CALM_AGAIN * calmest, FADED * moves[most]))
    end = (most + int(calm[0])) * each if calm.size else signal.values.shape[1] - 1
    return signal.start + signal.step * most * each, signal.start + signal.step * end


def _shrinking(signal: Signal) -> tuple[Second, Second] | None:
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
    falls = -np.diff(np.log(sizes[first:last]))
    if np.mean(falls[: len(falls) // 3]) < FALLS_AT_ONCE * np.mean(falls):
        return None
    return last - first, int(turns[first]), len(samples) - 1 if last == len(sizes) else int(turns[last])


def _plain(found: Identification, level: Level) -> bool:
    """Return whether modes that swing are as sure as a level, and what an eye would see."""
    if not _follows(found, level) or not swings(found.modes):
        return False
    if level is Level.DOUBTFUL:
        # One swing; others beside it may be what forces leave.
        return found.verdict.level is level and len(found.modes) == 1
    return damping_known(found)


def _follows(found: Identification, level: Level) -> bool:
    """Return whether modes explain most of the motion, and are at least as sure as a level."""
    return bool(len(found.modes)) and float(np.max(found.explained)) > MOST_OF_IT and found.verdict.level >= level


def _as_damped_later(tries: Sequence[Identification | None]) -> bool:
    """Return whether the mode that is damped least is damped alike from the first start on and from the last one."""
    first, last = tries[0], tries[-1]
    if first is None or last is None or not (len(first.modes) and len(last.modes)):
        return False
    zeta, later = float(np.min(first.modes.zeta)), float(np.min(last.modes.zeta))
    return zeta > 0 and later > 0 and max(zeta, later) < DAMPED_ALIKE * min(zeta, later)


def _agreeing(one: Identification, tries: Sequence[Identification | None], level: Level) -> int:
    """Return how many other identifications show all modes of one, and are at least as sure as a level."""
    others = [other for other in tries if other is not None and other is not one and _follows(other, level)]
    return sum(shared_modes([one, other])[0] == 1.0 for other in others)
