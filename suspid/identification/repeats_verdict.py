"""The verdict on several decays jointly: whether they agree, and what the checks of each say."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.identification.mode_checks import check_of, check_precision, numbers_of
from suspid.identification.verdict import verdict_of
from suspid.levels import LEVEL
from suspid.units import Ratio
from suspid.words import Check, Code, Headline, Level, ModeCheck, Number, Remark, Verdict, count

if TYPE_CHECKING:
    from suspid.identification.repeats import Repeats

# How well one decay alone tells its modes.
OF_PRECISION = frozenset({ModeCheck.DAMPING_UNKNOWN, ModeCheck.KNOWN_ROUGHLY, ModeCheck.MOSTLY_OPEN, ModeCheck.KNOWN})
# Share of the decays from which on a doubt is one of all of them.
COMMON_SHARE = 0.5


def verdict_of_repeats(repeats: Repeats, level: Ratio = LEVEL) -> Verdict:
    """Return the verdict on several decays jointly: their agreement, beside the checks of the decays themselves.

    A doubt of most decays is one of all of them; that of a few is milder by a level, since the others do not have it.
    """
    decays = len(repeats.spans)
    own = tuple(_of_decays(repeats, level))
    if not len(repeats.modes):
        none = check_of(ModeCheck.NO_COMMON_MODE, Level.NONE, {"decays": decays})
        return Verdict(Remark(Headline.NO_MODE), (none, *own))
    agreement = tuple(_of_agreement(repeats))
    # What one decay tells roughly, several may tell well.
    own = tuple(check for check in own if decays == 1 or check.remark.code not in OF_PRECISION)
    if decays > 1:
        repeated = np.array([0.0 if len(one.held) > 1 else np.nan for one in repeats.consistency])
        agreement += tuple(check_precision(repeats.modes, repeats.loudness, repeated, level))
    return Verdict(Remark(Headline.MODES, {"modes": len(repeats.modes)}), (*agreement, *own))


def _of_agreement(repeats: Repeats) -> Iterator[Check]:
    decays, consistency = len(repeats.spans), repeats.consistency
    apart = np.array([one.widening > 1 for one in consistency])
    shared = np.array([len(one.held) > 1 for one in consistency])
    bent = bool(repeats.amplitude_dependence)
    met = np.array([each is not None for each in repeats.amplitude_dependence]) if bent else np.zeros(len(apart), bool)
    unmet = shared & ~met & (bent and any(found.forces for found in repeats.each))
    if not np.any(shared):
        yield check_of(ModeCheck.NONE_REPEATED, Level.CARE, {"decays": decays})
    elif np.any(apart):
        numbers: dict[str, Number] = {
            "decays": decays,
            "modes": numbers_of(apart),
            "compared_at": bool(met[apart].all()),
        }
        yield check_of(ModeCheck.REPEATS_DISAGREE, Level.CARE, numbers)
    elif not np.any(unmet):
        yield check_of(ModeCheck.REPEATS_AGREE, Level.SOUND, {"decays": decays})
    if bent and np.any(shared & met):
        yield check_of(ModeCheck.AT_COMMON_AMPLITUDES, Level.NOTE, {"modes": numbers_of(shared & met)})
    if np.any(unmet):
        yield check_of(ModeCheck.NO_COMMON_AMPLITUDE, Level.CARE, {"modes": numbers_of(unmet)})


def _of_decays(repeats: Repeats, level: Ratio) -> Iterator[Check]:
    """Yield what the checks of the single decays say, each kind once, with the decays that it holds for."""
    decays = len(repeats.each)
    if decays == 1:
        yield from verdict_of(repeats.each[0], level).checks
        return
    names = repeats.names or tuple(f"decay {number}" for number in range(1, decays + 1))
    by_code = dict[Code, dict[int, Check]]()
    for number, found in enumerate(repeats.each):
        for check in sorted(verdict_of(found, level).checks, key=lambda one: one.level):
            by_code.setdefault(check.remark.code, {}).setdefault(number, check)
    # The table of joint modes says how they depend on their amplitude.
    if any(each is not None for each in repeats.amplitude_dependence):
        by_code.pop(ModeCheck.AMPLITUDE, None)
    for checks in by_code.values():
        against = {number: check for number, check in checks.items() if check.level < Level.NOTE}
        saying = against or checks
        # That a check is passed is said where all decays pass it.
        if not against and len(saying) < decays:
            continue
        first = min(saying, key=lambda number: saying[number].level)
        milder = against and len(against) < COMMON_SHARE * decays
        others = f" and {count(len(saying) - 1, 'other')}" if len(saying) > 1 else ""
        there = "" if len(repeats.each[first].modes) == len(repeats.modes) else ", by the numbers of its own modes"
        remark = replace(saying[first].remark, of=f"{printable(names[first])}{others}{there}")
        yield Check(remark, Level(saying[first].level + 1) if milder else saying[first].level)
