"""Tests whether a whole record is a free decay, and whether a stretch of it is a better one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.analysis.free_swings import doubts_of_swings
from suspid.decays import (
    DRIVEN,
    FEWEST_EARLY,
    FIT,
    TRIAL_PARTS,
    Decay,
    in_common,
    is_grave,
    not_far_weaker,
    unexplained,
)
from suspid.identification import (
    FORCED,
    Identification,
    cycles_seen,
    lag_one,
    removed_as,
    residual_of_part,
)
from suspid.levels import likely
from suspid.model import ModalSet
from suspid.samples import held
from suspid.signals import Signal, as_signal
from suspid.words import Check, DecayDoubt, Level, ModeCheck, Number, Reason, RecordCheck, Remark

if TYPE_CHECKING:
    import control

# The residual of a free decay is noise: none of these is said of it.
STRUCTURE = frozenset(
    {
        ModeCheck.RESIDUAL_LOUD,
        ModeCheck.RESIDUAL_COLOURED,
        ModeCheck.FOLLOWED,
        ModeCheck.HALVES_DISAGREE,
        ModeCheck.GROWING,
        ModeCheck.LATE_MOTION,
        ModeCheck.HELD_UP,
    }
)
# A fit that begins later than another, or ends earlier, is compared with it where it has this share of its samples.
PART_SHARED = 0.5
# Doubts of what is elsewhere in the record.
OF_ELSEWHERE = frozenset({DecayDoubt.BACKGROUND, DecayDoubt.SMALL_PART})
# A fit to a stretch so short is a guess where it leaves this multiple of the power of noise near a mode: what it leaves
# has the size of what tells the damping. So is one with forces that leaves more than noise.
LITTLE_SEEN, FAR_FROM_NOISE = frozenset({DecayDoubt.FEW_CYCLES, DecayDoubt.TOO_SHORT}), 10.0
# Where each mode that was identified makes more cycles than this, until it ends or has died away, it is no guess.
CYCLES_ENOUGH, DIED_AWAY = 4.0, 3.0
# Where the slowest mode is damped by more than this, the second half of its first cycle has less than a tenth of the
# size of the first: any pulse looks like that, and where the decay is doubted, that is no mode. Bodies have less.
NO_CYCLE = 0.6
# What a quick fit leaves of a motion beside a steady tone, as a share of it, is that tone up to this.
OF_A_TONE = 0.1
# Those that are about the quick fit alone.
ANSWERED = frozenset({DecayDoubt.FEW_SAMPLES})
# Decibels by which the start of a decay is above its end where fast modes may have died between: 3 in amplitude.
FAR_ABOVE = 10.0
# Other decays without a mode of the one that is used: from the first number on they call for care, from the second on
# they say that it is one by chance. A single one may be a knock at another part; larger numbers believe driven motion.
SOME_UNLIKE, MANY_UNLIKE = 2, 3


def swings(modes: Decay | ModalSet) -> bool:
    """Return whether the slowest mode makes cycles that can be seen, or there is none."""
    return not modes.wn.size or float(modes.zeta[np.argmin(modes.wn)]) < NO_CYCLE


def settled(found: Identification) -> bool:
    """Return whether a record is a free decay from its first sample on: modes are found, and the residual is noise."""
    forced = removed_as(found.considered, *FORCED)
    return len(found.modes) > 0 and not forced and not any(c.remark.code in STRUCTURE for c in found.verdict.checks)


def linear(found: Identification) -> bool:
    """Return whether modes without forces are beyond doubt: what rests in the end has died away in its noise."""
    return not found.forces and settled(found) and found.verdict.level is Level.SOUND


def settled_by_forces(found: Identification) -> bool:
    """Return whether forces that are not linear explain a record down to its noise."""
    return bool(found.forces) and settled(found)


def damping_known(found: Identification) -> bool:
    """Return whether no damping ratio has an interval that reaches zero."""
    return not any(check.remark.code is ModeCheck.DAMPING_UNKNOWN for check in found.verdict.checks)


def with_few_cycles(found: Identification) -> NDArray[np.bool_]:
    """Return which modes make few cycles and have not decayed by the end: any motion may look like it, (mode,)."""
    numbers = {c.remark.numbers["mode"] for c in found.verdict.checks if c.remark.code is ModeCheck.FEW_CYCLES}
    return np.array([k + 1 in numbers for k in range(len(found.modes))], bool)


def explains(whole: Identification, part: Identification) -> bool:
    """Return whether the fit to a whole record explains a stretch of it as well as the fit to the stretch alone.

    The likelihood ratio over the samples of the stretch, of which correlation leaves fewer independent ones, is
    compared with its distribution: a chi-square with one degree of freedom for each unknown of the stretch. A fit with
    more poles follows what is before or after the stretch, and does not count.
    """
    if not len(part.modes) or not len(whole.modes):
        return not len(part.modes)
    poles, most = _poles(whole), _poles(part)
    if poles > most:
        return False
    return _by_chance(whole, as_signal(held(part, "residual")), most)


def holds(whole: Identification, part: control.TimeResponseData) -> bool:
    """Return whether all poles of a fit are needed for a part of its record too, where they lie elsewhere by chance.

    Then a fit to the part alone need not be sought, which takes ten times as long.
    """
    left = residual_of_part(whole, part)
    signal = as_signal(part)
    return left is not None and _by_chance(whole, replace(signal, values=left), _poles(whole))


def _by_chance(whole: Identification, left: Signal, most: int) -> bool:
    """Return whether the residual of a fit to a part is smaller than that of the whole by no more than chance.

    The samples of both are compared: a part may begin in the hold before, of which the whole has nothing.
    """
    all_left = as_signal(held(whole, "residual"))
    rows = [all_left.channels.index(name) for name in left.channels]
    late = round((all_left.start - left.start) / left.step)
    ours = left.values[:, max(0, late) : max(0, late + all_left.values.shape[1])]
    count = ours.shape[1]
    theirs = all_left.values[rows, max(0, -late) : max(0, -late) + count]
    if count < PART_SHARED * left.values.shape[1]:
        return False
    squares = np.maximum([np.sum(each**2, axis=1) for each in (theirs, ours)], 1e-300)
    together = lag_one(ours) ** 2
    free = count * (1 - together) / (1 + together)
    ratio = float(np.sum(free * np.log(squares[0] / squares[1])))
    unknowns = 2 * most + (2 * most + 1) * len(rows)
    return likely(ratio, unknowns)


def doubts_of(used: Sequence[Decay], found: Identification, decays: Sequence[Decay]) -> tuple[Check, ...]:
    """Return the doubts about the decay that is used as checks, if it is a single one.

    What an identification down to the noise refutes calls for care. A quick fit takes means of several samples. That
    these are few says nothing of an identification, which takes all. What it leaves is explained where a fit with
    forces leaves hardly anything. Of a whole record, only real poles beside steady tones are doubted, and swings that
    no free motion makes.
    """
    late = tuple(doubts_of_swings(found))
    if len(used) != 1:
        return late if used else (*_beside_tones(found), *late)
    decay = used[0]
    # A background that excites the mode bends a decay as forces do, and of many stretches some look so by chance.
    bent = bool(found.forces) and any(doubt.code in OF_ELSEWHERE for doubt in decay.doubts)
    noise_alone = settled(found)
    refuted, answered = (FIT, ANSWERED) if noise_alone and not bent else (frozenset(), frozenset())
    answered |= FIT if not bent and explained_by_forces(found) else frozenset()
    # A quick fit leaves the hum of the mains as it is.
    hums = noise_alone and bool(removed_as(found.considered, Reason.TONE))
    answered |= LITTLE_SEEN if _cycles(found) > CYCLES_ENOUGH else frozenset()
    loud = np.max(found.loudness, initial=0.0) > FAR_FROM_NOISE or (bool(found.forces) and not noise_alone)
    guessed = LITTLE_SEEN if loud else frozenset()
    own = (
        Check(
            Remark(RecordCheck.DECAY, {"doubt": str(doubt)}),
            Level.DOUBTFUL if (is_grave(doubt) and doubt.code not in refuted) or doubt.code in guessed else Level.CARE,
        )
        for doubt in decay.doubts
        if doubt.code not in answered and not (hums and _little(doubt))
    )
    return (
        *own,
        *late,
        *_never_swings(decay, found),
        *_not_repeated(decay, found, decays),
        *_died_before(decay, found, decays),
    )


def _little(doubt: Remark) -> bool:
    """Return whether a quick fit leaves no more than a steady tone may be."""
    share = doubt.numbers.get("share")
    return doubt.code in FIT and isinstance(share, float) and share < OF_A_TONE


def _cycles(found: Identification) -> float:
    """Return the least number of cycles of a mode before the record ends, or before it has died away; 0 without one."""
    turning = found.modes.poles.imag > 0
    cycles = cycles_seen(found.modes, as_signal(held(found, "response")).duration, nepers=DIED_AWAY)[turning]
    return float(np.min(cycles)) if cycles.size else 0.0


def _never_swings(decay: Decay, found: Identification) -> tuple[Check, ...]:
    """Return the doubt that real poles alone were found in a stretch that was not seen to be let go."""
    if not len(found.modes) or np.any(found.modes.poles.imag) or decay.kind is not None:
        return ()
    return (Check(Remark(RecordCheck.NEVER_SWINGS), Level.DOUBTFUL),)


def _beside_tones(found: Identification) -> tuple[Check, ...]:
    """Return the doubt that real poles alone were found beside tones: what is driven has a mean that wanders."""
    tones = bool(removed_as(found.considered, Reason.TONE))
    if not len(found.modes) or np.any(found.modes.poles.imag) or not tones:
        return ()
    return (Check(Remark(RecordCheck.NEVER_SWINGS), Level.DOUBTFUL),)


def _not_repeated(decay: Decay, found: Identification, decays: Sequence[Decay]) -> tuple[Check, ...]:
    """Return the doubt that most other decays of a recording have no mode of the one that was identified.

    A structure shows its modes after each release. Of several stretches of driven motion, the one that is used is the
    one that looks most like a decay, by chance.
    """
    apart = (other for other in decays if other.stop <= decay.start or other.start >= decay.stop)
    others = [other for other in not_far_weaker(decay, [*apart]) if other.wn.size]
    unlike = sum(not in_common(other.wn, found.modes.wn) for other in others)
    if not len(found.modes) or unlike < SOME_UNLIKE or 2 * unlike <= len(others):
        return ()
    level = Level.DOUBTFUL if unlike >= MANY_UNLIKE else Level.CARE
    return (Check(Remark(RecordCheck.NOT_REPEATED, {"unlike": unlike, "others": len(others)}), level),)


def _died_before(decay: Decay, found: Identification, decays: Sequence[Decay]) -> tuple[Check, ...]:
    """Return the doubt that a far larger decay, of which the one that is used is the end, has a mode beside its modes.

    A fast mode dies first, and the end of a decay looks cleaner than its start. Where no fit follows the start, nothing
    tells which modes it has.
    """
    wn = found.modes.wn
    before = [one for one in decays if one.start < decay.start < one.stop and one.level > decay.level + FAR_ABOVE]
    missing = [[each for each in one.wn.tolist() if not in_common(np.array([each]), wn)] for one in before]
    told = [
        (other.start, some)
        for other, some in zip(before, missing, strict=True)
        if some or any(doubt.code in FIT for doubt in other.doubts)
    ]
    if not told or not len(wn):
        return ()
    start, some = max(told, key=lambda one: len(one[1]))
    hertz = ", ".join(f"{each / (2 * np.pi):.4g}" for each in some)
    numbers: dict[str, Number] = {"start": start, "number": len(some), "hertz": hertz}
    return (Check(Remark(RecordCheck.DIED_BEFORE, numbers), Level.CARE),)


def level_of(found: Identification, used: Sequence[Decay], decays: Sequence[Decay]) -> Level:
    """Return the level of the verdict on an identification and on the decay that it is of."""
    if not len(found.modes):
        return Level.NONE
    return min([found.verdict.level, *(doubt.level for doubt in doubts_of(used, found, decays))])


def explained_by_forces(found: Identification) -> bool:
    """Return whether a fit with forces that are not linear leaves too little, first and later, to be driven motion."""
    if not found.forces:
        return False
    motion, left = as_signal(held(found, "fitted")).values, as_signal(held(found, "residual")).values
    motion = motion - motion.mean(axis=1, keepdims=True)
    first = max(FEWEST_EARLY, motion.shape[1] // TRIAL_PARTS)
    return all(np.max(unexplained(motion[:, :end], left[:, :end])) <= DRIVEN for end in (3 * first, motion.shape[1]))


def _poles(found: Identification) -> int:
    """Return the number of poles of a fit, modes and others."""
    return len(found.modes) + sum(c.removed for c in found.considered)
