"""Parts of a record from one time to another that modes and forces explain down to noise."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from suspid.analysis.choice import settled, swings
from suspid.analysis.settings import Settings
from suspid.analysis.tries import tried
from suspid.analysis.used import Used, instead_of
from suspid.decays import STARTS_AFTER_REST
from suspid.identification import Identification
from suspid.levels import FEWEST_SAMPLES
from suspid.records import cut
from suspid.signals import as_signal
from suspid.units import Second
from suspid.words import Note, Remark

if TYPE_CHECKING:
    import control


def shortened(
    record: control.TimeResponseData, start: Second, stop: Second | None, settings: Settings
) -> Iterator[tuple[control.TimeResponseData, Identification | None]]:
    """Yield a part with ever fewer samples, and what is identified in it, where enough of it is left.

    Its first samples may be of a rest still, and so may its last ones, where it does not end with the record.
    """
    signal = as_signal(record)
    last, ends = (float(signal.timepts[-1]), 1) if stop is None else (stop, 2)
    if round((last - start) / signal.step) + 1 < FEWEST_SAMPLES + ends * STARTS_AFTER_REST[-1]:
        return
    for samples in STARTS_AFTER_REST:
        less = samples * signal.step
        part = cut(record, start=start + less, stop=None if stop is None else stop - less)
        yield part, tried(part, settings)


def explains_swings(found: Identification) -> bool:
    """Return whether modes that swing, and forces, leave only noise of what was identified."""
    return settled(found) and swings(found.modes)


def used_instead(stretch: Used, part: control.TimeResponseData, found: Identification, why: Note) -> Used:
    """Return a part with what was identified in it, in place of the stretch that is used."""
    notes = (part_used(part, why),)
    used = Used(record=part, decays=stretch.decays, used=(), notes=notes, identification=found)
    return instead_of(stretch, used)


def part_used(part: control.TimeResponseData, why: Note) -> Remark:
    """Return the note that a part of a record is used, and why."""
    time = as_signal(part).timepts
    return Remark(why, {"start": float(time[0]), "stop": float(time[-1])})
