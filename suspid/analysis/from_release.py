"""The motion from where a mass was let go to the end of its record, where the search for decays found no mode."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import damping_known
from suspid.analysis.explained_parts import explains_swings, shortened, used_instead
from suspid.analysis.settings import Settings
from suspid.analysis.support import questioned
from suspid.analysis.used import Used
from suspid.decays import finest, released_at, rest_of
from suspid.identification import Identification
from suspid.records import of_channels
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Level, Note

if TYPE_CHECKING:
    import control

# Samples that are held before a release, at least: fewer are alike by chance.
LEAST_HELD = 12


def from_release(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the motion from a release to the end of a record if modes and forces explain it down to its noise.

    An event is looked for above a background; a record of a few large cycles has none after them, and may be cut off
    within them. What is doubtful is none, as many poles follow any motion after a rest. ``found`` is what the search
    for decays led to: nothing else is sought where that has modes.
    """
    if len(found.modes) or not questioned(found, settings):
        return None
    record = of_channels(record, as_signal(stretch.record).channels)
    signal = as_signal(record)
    # A coarse step is not told from few samples of fast motion: then those that are equal are held.
    held = released_at(signal.values, finest(signal.values)) or _equal(signal.values) - 1
    first = held + 1 if held >= LEAST_HELD else rest_of(signal.values)
    if not first:
        return None
    for part, moved in shortened(record, signal.start + signal.step * first, None, settings):
        if moved is None or moved.verdict.level <= Level.DOUBTFUL:
            continue
        if explains_swings(moved) and damping_known(moved):
            return used_instead(stretch, part, moved, Note.FROM_RELEASE)
    return None


def _equal(values: RealArray) -> int:
    """Return how many samples at the start are equal in every channel."""
    return int(np.argmin(np.append(np.all(values == values[:, :1], axis=0), False)))
