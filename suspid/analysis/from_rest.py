"""Decays that begin where a rest ends: modes that have died when the search for decays lets one begin."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import settled
from suspid.analysis.forced_start import SAME_POLE, without_start
from suspid.analysis.longer import with_identification
from suspid.analysis.settings import Settings
from suspid.analysis.tries import tried
from suspid.analysis.used import Used, used_of
from suspid.decays import STARTS_AFTER_REST, Decays, rest_of
from suspid.identification import Identification
from suspid.levels import SURE
from suspid.records import cut, of_channels
from suspid.signals import as_signal
from suspid.units import RealArray, Second
from suspid.words import Level

if TYPE_CHECKING:
    import control

# A decay begins within this part of a period of its slowest mode after a rest, or what was between is a push.
SOON = 0.5
# A rest is looked for within this number of periods before a decay.
LOOKED_BACK_TO, REST_SHARE = 10.0, 0.9
# A mode that dies soon after a release is one if its frequency and its damping ratio are known to these shares.
KNOWN_TO, DAMPING_TO = 0.1, 0.25
# What is damped by more than this makes no swing: a force that falls looks the same.
NO_SWING = 0.8
# The further mode that lasts longest is the same from as many nepers later on: of a force that falls for a while, a
# later start sees less, and what looks like a mode falls faster.
NEPERS_LATER = 1.0


def from_rest(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return the decay from where a rest before it ends, if that shows further modes which are none of a force.

    What is damped heavily dies within a part of the first cycle, and without it the rest of the decay is beyond doubt.
    Where a force that ends would look the same, the further modes are named among the poles that were considered.
    """
    if len(best.used) != 1 or not isinstance(best.decays, Decays):
        return best
    best = with_identification(best, settings)
    found = best.identification
    if found is None or found.forces or not len(found.modes) or found.verdict.level is Level.DOUBTFUL:
        return best
    decay, part = best.used[0], as_signal(best.record)
    period = 2 * np.pi / float(np.min(found.modes.wn))
    left = _left_rest(of_channels(record, part.channels), decay.start, period)
    if left is None:
        return best
    for samples in STARTS_AFTER_REST:
        start = left + samples * part.step
        if not start < decay.start - 0.5 * part.step:
            break
        used = used_of(record, best.decays, replace(decay, start=start))
        more = tried(used.record, settings)
        if more is not None and _shows_more(more, found):
            lasts = _lasts(more, found, used, settings)
            told = replace(best, identification=without_start(more, found, released=True))
            return replace(used, identification=more) if lasts else told
    return best


def _left_rest(record: control.TimeResponseData, start: Second, period: Second) -> Second | None:
    """Return when a rest ends that a decay begins soon after; None where there is no such rest."""
    signal = as_signal(record)
    about = (signal.timepts > start - LOOKED_BACK_TO * period) & (signal.timepts < start + period)
    first = rest_of(signal.values[:, about], most=REST_SHARE)
    left = float(signal.timepts[about][0]) + signal.step * first
    return left if first and start - SOON * period < left < start else None


def _shows_more(more: Identification, found: Identification) -> bool:
    """Return whether a fit has the modes of another and further ones, all well known, and leaves only noise."""
    modes = more.modes
    if not settled(more) or more.forces or len(modes) <= len(found.modes):
        return False
    if modes.wn_std is None or modes.zeta_std is None or more.verdict.level is Level.DOUBTFUL:
        return False
    known = np.all((modes.wn_std < KNOWN_TO * modes.wn) & (modes.zeta_std < DAMPING_TO * np.abs(modes.zeta)))
    return bool(known and np.all(_apart(found, more) < SURE))


def _lasts(more: Identification, found: Identification, used: Used, settings: Settings) -> bool:
    """Return whether the further mode that lasts longest is seen from a good deal later on, too, and is the same then.

    Faster ones may have gone.
    """
    poles = more.modes.poles
    further = np.min(np.abs(poles[:, None] - found.modes.poles), axis=1) >= SAME_POLE * np.abs(poles)
    if not further.any() or np.any(more.modes.zeta[further] > NO_SWING):
        return False
    last = int(np.argmin(np.where(further, -poles.real, np.inf)))
    start = as_signal(used.record).start - NEPERS_LATER / float(poles[last].real)
    again = tried(cut(used.record, start=start), settings)
    return again is not None and len(again.modes) > len(found.modes) and bool(_apart(more, again)[last] < SURE)


def _apart(one: Identification, other: Identification) -> RealArray:
    """Return by how many standard deviations each mode of a fit differs from the nearest of another, (mode,)."""
    ours, theirs = one.modes, other.modes
    if ours.wn_std is None or ours.zeta_std is None or theirs.wn_std is None or theirs.zeta_std is None:
        return np.full(len(ours), np.inf)
    nearest = np.argmin(np.abs(ours.poles[:, None] - theirs.poles), axis=1)
    # A real pole has a damping ratio of 1, known without error.
    by_wn, by_zeta = (
        np.abs(here - there[nearest]) / np.maximum(np.hypot(std, other[nearest]), 1e-300)
        for here, std, there, other in (
            (ours.wn, ours.wn_std, theirs.wn, theirs.wn_std),
            (ours.zeta, ours.zeta_std, theirs.zeta, theirs.zeta_std),
        )
    )
    return np.asarray(np.maximum(by_wn, by_zeta))
