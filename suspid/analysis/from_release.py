"""The motion from where a mass was let go to the end of its record, where the search for decays found no mode."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import damping_known, settled, tried
from suspid.analysis.settings import Settings
from suspid.analysis.stretch import swings
from suspid.analysis.support import questioned
from suspid.analysis.used import Used, instead_of
from suspid.decays import STARTS_AFTER_REST, finest, released_at, rest_of
from suspid.identification import FEWEST_SAMPLES, Identification
from suspid.records import cut, of_channels
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Level, Note, Remark

if TYPE_CHECKING:
    import control


# Samples that are held before a release, at least: fewer are alike by chance.
LEAST_HELD = 12


def from_release(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the motion from a release to the end of a record if modes and forces explain it down to its noise.

    An event is looked for above a background; a record of a few large cycles has none after them, and may be cut off
    within them. ``found`` is what the search for decays led to: nothing else is sought where that has modes.
    """
    if len(found.modes) or not questioned(found, settings):
        return None
    record = of_channels(record, as_signal(stretch.record).channels)
    signal = as_signal(record)
    # A coarse step is not told from few samples of fast motion: then those that are equal are held.
    held = released_at(signal.values, finest(signal.values)) or _equal(signal.values) - 1
    first = held + 1 if held >= LEAST_HELD else rest_of(signal.values)
    if not first or signal.values.shape[1] - first < FEWEST_SAMPLES + STARTS_AFTER_REST[-1]:
        return None
    # The first samples may be of the hold still.
    for samples in STARTS_AFTER_REST:
        start = signal.start + signal.step * (first + samples)
        part = cut(record, start=start)
        moved = tried(part, settings)
        if moved is None or moved.verdict.level <= Level.DOUBTFUL:
            continue
        if settled(moved) and swings(moved.modes) and damping_known(moved):
            notes = (Remark(Note.FROM_RELEASE, {"start": start}),)
            used = Used(record=part, decays=stretch.decays, used=(), notes=notes, identification=moved)
            return instead_of(stretch, used)
    return None


def _equal(values: RealArray) -> int:
    """Return how many samples at the start are equal in every channel."""
    return int(np.argmin(np.append(np.all(values == values[:, :1], axis=0), False)))
