"""The free end of a record, where the search for decays led to what is driven before."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from suspid.analysis.choice import damping_known, level_of
from suspid.analysis.explained_parts import explains_swings
from suspid.analysis.settings import Settings
from suspid.analysis.support import questioned
from suspid.analysis.tries import tried
from suspid.analysis.used import Used, instead_of, used_of
from suspid.decays import decay_at_end
from suspid.identification import Identification
from suspid.records import of_channels
from suspid.signals import as_signal
from suspid.words import Level

if TYPE_CHECKING:
    import control


def at_free_end(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the end of a record that decays freely, if it has modes that are not doubtful; else None.

    A stretch may begin where a shaker does, and not where it is switched off. ``found`` is what the search for decays
    led to: nothing else is sought where that has modes.
    """
    if len(found.modes) or not questioned(found, settings):
        return None
    record = of_channels(record, as_signal(stretch.record).channels)
    decay = decay_at_end(as_signal(record))
    if decay is None:
        return None
    used = instead_of(stretch, used_of(record, (decay, *stretch.decays), decay))
    moved = tried(used.record, settings)
    if moved is None or not explains_swings(moved) or not damping_known(moved):
        return None
    free = level_of(moved, used.used, used.decays) > Level.DOUBTFUL
    return replace(used, identification=moved) if free else None
