"""A decay from later on, where its first part makes the result doubtful: a blow that bounces, modes that die soon."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import damping_known, level_of, swings, with_few_cycles
from suspid.analysis.settings import Settings
from suspid.analysis.shown_modes import shared_modes
from suspid.analysis.stretch import LATER_SHARES
from suspid.analysis.support import NEARLY_ALL, questioned, supported
from suspid.analysis.tries import tried
from suspid.analysis.used import Used, instead_of, used_of
from suspid.decays import FIT, Decay, Decays, by_chance, find_decays
from suspid.errors import SuspidError
from suspid.identification import Identification, swings_many_times
from suspid.records import of_channels
from suspid.samples import held
from suspid.signals import as_signal
from suspid.words import DecayDoubt, Level, Remark

if TYPE_CHECKING:
    import control

# Doubts of the first part of a decay, or of the fit to all of it: of a later part they are judged anew.
OF_ALL = FIT | {DecayDoubt.MODES_MISSING, DecayDoubt.NOT_IDENTIFIED, DecayDoubt.AT_START}


def from_later(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return a later part of the decay that is used, or of the next, that is beyond doubt; None if there is none.

    ``found`` is what was found in the decay that is used. Where that is not doubtful, or was chosen by the settings, no
    other part is sought; nor where modes are found and the decay does not deviate from them. Where its first part does
    not do so more than the others, what is left later on must be modes of it that ring on alone.
    """
    decays = stretch.decays
    if not questioned(found, settings) or len(stretch.used) != 1 or not isinstance(decays, Decays):
        return None
    doubts = {doubt.code for doubt in stretch.used[0].doubts}
    if level_of(found, stretch.used, decays) > Level.DOUBTFUL or (len(found.modes) and not doubts & FIT):
        return None
    alone = bool(len(found.modes)) and DecayDoubt.FORCED not in doubts
    record = of_channels(record, as_signal(stretch.record).channels)
    for decay in _parts(stretch.used[0], () if alone else decays):
        # A look at some hundred cycles does not see a mode fall that rings for thousands.
        part = _without_doubts_of_all(decay) if alone else _checked(record, decay)
        if part is None:
            continue
        used = instead_of(stretch, used_of(record, decays, part))
        again = tried(used.record, settings)
        if again is None or not len(again.modes) or not swings(again.modes) or not damping_known(again):
            continue
        if alone and not _ring_on(again, found):
            continue
        # Of several parts, a few cycles of friction are a mode by chance.
        if with_few_cycles(again)[:1].any():
            continue
        kept = supported(again, used, settings, whole=record)
        if level_of(kept, used.used, decays) > Level.DOUBTFUL:
            return replace(used, identification=kept)
    return None


def _ring_on(later: Identification, found: Identification) -> bool:
    """Return whether all modes of a later part are modes of the whole decay, swing many times, and explain nearly all.

    Beside a mode that has died by then, and that no linear fit follows, they were doubtful.
    """
    signal = as_signal(held(later, "response"))
    many = swings_many_times(later.modes, signal.step * (signal.values.shape[1] - 1))
    plain = bool(np.max(later.explained) > NEARLY_ALL) and bool(np.all(many))
    return plain and shared_modes([later, found])[0] == 1.0


def _parts(best: Decay, decays: Sequence[Decay]) -> Iterator[Decay]:
    """Yield later and later parts of a decay, and of the next one."""
    others = [decay for decay in decays if decay.start != best.start and not by_chance(decay)]
    for decay in (best, *others[:1]):
        for share in LATER_SHARES if decay is best else (0.0, *LATER_SHARES):
            start = decay.start + share * (decay.stop - decay.start)
            said = (Remark(DecayDoubt.LATER, {"first": decay.start, "start": start}),) if share else ()
            yield replace(decay, start=start, doubts=(*said, *decay.doubts))


def _without_doubts_of_all(decay: Decay) -> Decay:
    """Return a part of a decay without the doubts of the whole that are judged anew."""
    return replace(decay, doubts=tuple(doubt for doubt in decay.doubts if doubt.code not in OF_ALL))


def _checked(record: control.TimeResponseData, decay: Decay) -> Decay | None:
    """Return a part of a decay with its own doubts, and those that are not of its first part; None if it is none."""
    try:
        again = find_decays(record, given=[(decay.start, decay.stop)])
    except SuspidError:
        return None
    if not again:
        return None
    kept = _without_doubts_of_all(decay).doubts
    own = tuple(doubt for doubt in again[0].doubts if doubt.code not in {one.code for one in kept})
    return replace(again[0], rank=decay.rank, doubts=(*kept, *own))
