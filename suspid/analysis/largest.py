"""The largest motion of a record, where the search for decays ends without a result: what an eye would cut out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.between_knocks import between_knocks, smoothest
from suspid.analysis.choice import damping_known, level_of, settled_by_forces, swings
from suspid.analysis.far_larger import hardly_any, larger_elsewhere, shows_the_same, time_of
from suspid.analysis.settings import Settings
from suspid.analysis.shown_modes import shared_modes
from suspid.analysis.shrinking import longest_shrinking, shrinking
from suspid.analysis.support import questioned
from suspid.analysis.tries import tried
from suspid.analysis.used import Used, instead_of
from suspid.identification import Identification
from suspid.levels import FEWEST_SAMPLES
from suspid.records import cut, of_channels
from suspid.signals import Signal, as_signal
from suspid.units import Second
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
# Half of a beat shrinks as swings do, but its damping grows: that from the first and from the last start on is alike to
# this factor.
DAMPED_ALIKE = 1.5
# Shares of the motion after which it may be free: what lets it go acts for a while.
STARTS_TRIED = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4)
# Other starts that must show the same modes, for a result that is not doubtful and for one that is.
AGREE, AGREE_DOUBTFUL = 1, 2
# A motion of more samples than the first number takes seconds for each start: fewer are tried then. One of more than
# the second is a drive more often than a decay.
LONG, FEWER_STARTS, LONGEST_TRIED = 50_000, (0.0, 0.1, 0.4), 250_000
# Swings that shrink for this many times as long as a stretch whose modes are doubtful may be doubtful themselves.
FAR_LONGER = 4.0
# Where modes are found that only their stretch makes doubtful, another motion is tried that is larger than this times
# that of the stretch.
AS_LARGE = 0.5
# A mode that is damped by less makes three cycles before it has fallen to a fifth: others may be what is still held.
LASTING_ZETA = 0.08
# A fit explains this share of the energy of a channel where its modes are the largest motion.
MOST_OF_IT = 0.8


def of_largest(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the largest motion of a record where modes are the same from several starts; None if they are not.

    ``found`` is what the search for decays led to: nothing else is sought where that has modes, unless the record moves
    far more elsewhere, with other modes, or it is doubtful and the decay has next to nothing of the motion, or swings
    shrink for most of the record. Of each motion, the first start is used whose modes another shows too; a motion
    beyond doubt comes before one that is doubtful.
    """
    if not questioned(found, settings):
        return None
    beside = bool(len(found.modes))
    elsewhere = _larger_elsewhere(record, stretch, found) if beside else None
    clear = beside and level_of(found, stretch.used, stretch.decays) > Level.DOUBTFUL
    if clear and elsewhere is None:
        return None
    largest = not beside or elsewhere is not None or hardly_any(record, stretch)
    record = of_channels(record, as_signal(stretch.record).channels)
    doubtful: Used | None = None
    for motion in _motions(record, largest=largest, beside=beside):
        # What is clear gives way to the motion that is far larger, and to no other.
        if clear and elsewhere is not None and not motion.first <= elsewhere <= motion.last:
            continue
        # Modes that are doubtful of themselves, as those of the hand that catches a swing, may be larger.
        if beside and found.verdict.level > Level.DOUBTFUL and not _as_large(motion, stretch):
            continue
        used = _agreed(motion, settings, beside=beside and not _far_longer(motion, stretch))
        if used is None:
            continue
        out = tuple(name for name in as_signal(record).channels if name not in as_signal(used.record).channels)
        notes = (Remark(Note.FEWER_CHANNELS, {"names": out}),) if out else ()
        used = instead_of(stretch, replace(used, decays=stretch.decays, notes=(*notes, *used.notes)))
        if used.identification is not None and used.identification.verdict.level > Level.DOUBTFUL:
            more = len(used.identification.modes) > len(found.modes)
            same = clear and not more and shared_modes([used.identification, found])[0] == 1.0
            return None if same else used
        doubtful = doubtful or used
    return None if clear else doubtful


def _larger_elsewhere(record: control.TimeResponseData, stretch: Used, found: Identification) -> Second | None:
    """Return when a record moves far more elsewhere, where no decay shows the same modes; None where it does not."""
    times = map(time_of, larger_elsewhere(record, stretch))
    return next((time for time in times if not shows_the_same(stretch.decays, time, found.modes)), None)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Motion:
    """A part of a record that may be free from some time on."""

    record: control.TimeResponseData
    first: Second
    last: Second
    shrinks: bool  # whether its swings shrink; else it stands out


def _motions(record: control.TimeResponseData, *, largest: bool, beside: bool) -> Iterator[_Motion]:
    """Yield what moves most in a record, or swings that shrink from the ``largest`` on; then those that do so for long.

    Where one channel has most of the energy, the first are sought in it alone, too; those that shrink for long are of a
    single channel, and may be beside a larger knock. Last, unless there are modes ``beside`` it, what lies between
    knocks, in all channels and in the one that moves most beside its roughness.
    """
    signal = as_signal(record)
    most = _moves_most(signal)
    largest_of = [record, *([of_channels(record, [most])] if most is not None else [])] if largest else []
    motions = [motion for each in largest_of if (motion := _most_of(each)) is not None]
    yield from motions
    span = (motions[0].first, motions[0].last) if motions else None
    run = longest_shrinking(signal)
    # Of one channel, the same swings were tried, or more.
    known = run is not None and span is not None and len(signal.channels) == 1 and span[0] <= run[1] < run[2] <= span[1]
    if run is not None and not known:
        channel, first, last = run
        yield _Motion(record=of_channels(record, [channel]), first=first, last=last, shrinks=True)
    between = None if beside else between_knocks(signal)
    if between is not None:
        for names in [signal.channels, [smoothest(signal, between)]][: len(signal.channels)]:
            yield _Motion(record=of_channels(record, names), first=between[0], last=between[1], shrinks=True)


def _most_of(record: control.TimeResponseData) -> _Motion | None:
    """Return what moves most in a record, or swings that shrink from the largest on; None if there is neither."""
    signal = as_signal(record)
    stands_out = _largest(signal)
    span = stands_out or shrinking(signal)
    return None if span is None else _Motion(record=record, first=span[0], last=span[1], shrinks=stands_out is None)


def _moves_most(signal: Signal) -> str | None:
    """Return the channel that has most of the energy of several, each about its mean; None where none has."""
    energy = np.var(signal.values, axis=1)
    most = int(np.argmax(energy))
    return signal.channels[most] if len(energy) > 1 and energy[most] > MOST_OF_IT * energy.sum() else None


def _agreed(motion: _Motion, settings: Settings, *, beside: bool) -> Used | None:
    """Return the first part of a motion whose modes another start shows too; None if there is none.

    Rather one that has no heavily damped modes, or only such as half of the starts show. Where there are doubtful modes
    ``beside`` it, only one that is not doubtful.
    """
    length = motion.last - motion.first
    count = length / as_signal(motion.record).step
    if not FEWEST_SAMPLES / (1 - STARTS_TRIED[-1]) <= count <= LONGEST_TRIED:
        return None
    shares = STARTS_TRIED if count <= LONG else FEWER_STARTS
    parts = [cut(motion.record, start=motion.first + share * length, stop=motion.last) for share in shares]

    @cache
    def at(number: int) -> Identification | None:
        return tried(parts[number], settings)

    if motion.shrinks and not _as_damped_later([at(0), at(len(parts) - 1)]):
        return None
    tries = [at(number) for number in range(len(parts))]
    levels = ((Level.CARE, AGREE),) if beside else ((Level.CARE, AGREE), (Level.DOUBTFUL, AGREE_DOUBTFUL))
    for level, others in levels:
        shown = [
            (part, one, number)
            for part, one in zip(parts, tries, strict=True)
            if one is not None and _plain(one, level) and (number := _agreeing(one, tries, level)) >= others
        ]
        # Heavily damped modes that fewer than half of the starts show are what lets the motion go.
        free = [each for each in shown if _lasts(each[1]) or each[2] >= len(tries) // 2]
        for part, one, _ in (free or shown)[:1]:
            said = {"start": as_signal(part).start, "stop": motion.last}
            notes = (Remark(Note.LARGEST_USED, said),)
            return Used(record=part, decays=(), used=(), notes=notes, identification=one)
    return None


def _as_large(motion: _Motion, stretch: Used) -> bool:
    """Return whether a motion is as large as that of the stretch that is used, in a channel: a hum beside it is not."""
    part, other = as_signal(stretch.record), as_signal(cut(motion.record, start=motion.first, stop=motion.last))
    sizes = dict(zip(part.channels, np.ptp(part.values, axis=1), strict=True))
    moves = zip(other.channels, np.ptp(other.values, axis=1), strict=True)
    return any(size > AS_LARGE * sizes.get(name, np.inf) for name, size in moves)


def _far_longer(motion: _Motion, stretch: Used) -> bool:
    """Return whether swings shrink for far longer than the stretch lasts that is used."""
    part = as_signal(stretch.record)
    return motion.shrinks and FAR_LONGER * part.duration < motion.last - motion.first


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


def _plain(found: Identification, level: Level) -> bool:
    """Return whether modes that swing are as sure as a level, and what an eye would see."""
    if not _follows(found, level) or not swings(found.modes):
        return False
    if level is Level.DOUBTFUL:
        # One swing; others beside it may be what forces leave.
        return found.verdict.level is level and len(found.modes) == 1
    # Friction leaves the damping of the last swings open, also where it explains all.
    return damping_known(found) or settled_by_forces(found)


def _lasts(found: Identification) -> bool:
    """Return whether every mode swings for some cycles before it has faded."""
    return bool(np.all(found.modes.zeta < LASTING_ZETA))


def _follows(found: Identification, level: Level) -> bool:
    """Return whether modes explain most of the motion, and are at least as sure as a level."""
    return bool(len(found.modes)) and float(np.max(found.explained)) > MOST_OF_IT and found.verdict.level >= level


def _as_damped_later(tries: Sequence[Identification | None]) -> bool:
    """Return whether the mode that is damped least is damped alike from the first start on and from the last one.

    Late in the motion another mode may be seen beside it.
    """
    first, last = tries[0], tries[-1]
    if first is None or last is None or not (len(first.modes) and len(last.modes)):
        return False
    least = int(np.argmin(first.modes.zeta))
    nearest = int(np.argmin(np.abs(last.modes.wn - first.modes.wn[least])))
    zeta, later = float(first.modes.zeta[least]), float(last.modes.zeta[nearest])
    return zeta > 0 and later > 0 and max(zeta, later) < DAMPED_ALIKE * min(zeta, later)


def _agreeing(one: Identification, tries: Sequence[Identification | None], level: Level) -> int:
    """Return how many other identifications show all modes of one, and are at least as sure as a level."""
    others = [other for other in tries if other is not None and other is not one and _follows(other, level)]
    return sum(shared_modes([one, other])[0] == 1.0 for other in others)
