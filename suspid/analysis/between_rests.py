"""The motion between two rests within noise, where no mode was found: friction stops what was let go."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.explained_parts import explains_swings, shortened, used_instead
from suspid.analysis.settings import Settings
from suspid.analysis.support import questioned
from suspid.analysis.used import Used
from suspid.decays import rest_of
from suspid.identification import Identification
from suspid.records import of_channels
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Note

if TYPE_CHECKING:
    import control

# Rests that are looked for take at most these shares of a record, before the motion and after it.
REST_BEFORE, REST_AFTER = 0.9, 0.97
# The motion passes the level of its last rest at least this often, by this share of its size: a pulse of force does
# not.
PASSES, BY_SHARE = 2, 0.03


def between_rests(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the motion between two rests if modes and forces explain it down to its noise; None where they do not.

    Few cycles that friction stops are no damped exponentials, and the quick fits of the search for decays refuse them.
    """
    if len(found.modes) or not questioned(found, settings):
        return None
    record = of_channels(record, as_signal(stretch.record).channels)
    signal = as_signal(record)
    size = signal.values.shape[1]
    first = rest_of(signal.values, most=REST_BEFORE)
    last = size - rest_of(signal.values[:, ::-1], most=REST_AFTER)
    if not first or last == size or last <= first:
        return None
    if not _passes(signal.values[:, first:], last - first):
        return None
    start, stop = (signal.start + signal.step * sample for sample in (first, last - 1))
    for part, moved in shortened(record, start, stop, settings):
        if moved is not None and moved.forces and explains_swings(moved):
            return used_instead(stretch, part, moved, Note.BETWEEN_RESTS)
    return None


def _passes(values: RealArray, last: int) -> bool:
    """Return whether the largest motion passes the level of what follows it often enough for a swing."""
    about = values - np.median(values[:, last:], axis=1, keepdims=True)
    largest = np.max(np.abs(about), axis=1)
    moves = about[np.argmax(largest / np.maximum(np.std(values[:, last:], axis=1), 1e-300))]
    far = np.sign(moves[np.abs(moves) > BY_SHARE * np.max(np.abs(moves))])
    return int(np.count_nonzero(np.diff(far))) >= PASSES
