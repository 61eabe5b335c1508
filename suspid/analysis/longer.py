"""Whether the decay that is used is the end of a longer one, which shows more of its modes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import explained_by_forces, settled, tried
from suspid.analysis.forced_start import SAME_POLE
from suspid.analysis.settings import Settings
from suspid.analysis.used import Used, used_of
from suspid.decays import Decay, Decays, releases_before
from suspid.identification import Identification
from suspid.levels import NORMAL_95
from suspid.records import cut
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.words import DecayDoubt, Level

if TYPE_CHECKING:
    import control

# Two decays are one where the later begins within this number of periods of its slowest mode after the earlier.
# Friction that holds a mass and lets it go parts them; a larger number tries to join a second release to the first.
SHORT_PAUSE = 1.0
# A release this number of periods of the slowest mode before a decay is tried as its start: a fast mode may have died
# since. A smaller number costs the time of a fit for nothing.
EARLIER = 0.3
# The motion goes on after a decay if the samples there spread by more than this many standard deviations of the
# residual. White noise hardly spreads by more than ten; a smaller number costs the time of a fit where none is needed.
MOVES = 15.0
# A mode is well known if the standard deviations of its frequency and of its damping ratio are below these shares. A
# mode of a longer decay that is not is no gain.
KNOWN_WN, KNOWN_ZETA = 0.01, 0.25
# A release is looked for before a decay within this multiple of its length: a fast mode has died after fewer.
BEFORE_DECAY = 3.0
# Doubts that end with the first of two decays that are joined.
OF_LENGTH = frozenset({DecayDoubt.CUT_OFF, DecayDoubt.FEW_CYCLES, DecayDoubt.TOO_SHORT, DecayDoubt.FEW_SAMPLES})


def longer(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return the longer decay of which the best one is a part, if that shows more of its modes."""
    decays = best.decays
    if len(best.used) != 1 or not isinstance(decays, Decays):
        return best
    signal = as_signal(record)
    before = _before(best.used[0], decays, signal)
    released = _released(record, best.used[0], min(decay.start for decay in (best.used[0], *before)))
    for decay in _longer_decays(best.used[0], decays, before=before, released=released, end=float(signal.timepts[-1])):
        earlier = decay.start < best.used[0].start
        if not earlier:
            best = with_identification(best, settings)
            if not _goes_on(best.identification, _after(signal, best)):
                continue
        more = with_identification(used_of(record, decays, decay), settings)
        found = more.identification
        if found is None:
            continue
        if earlier and best.identification is None and _shows_all(found, best.used[0]):
            return more
        best = with_identification(best, settings)
        if _shows_more(found, best.identification):
            return more
    return best


def with_identification(used: Used, settings: Settings) -> Used:
    """Return the part of a record that is used with what is identified in it."""
    return replace(used, identification=used.identification or tried(used.record, settings))


def _released(record: control.TimeResponseData, used: Decay, first: Second) -> tuple[Second, ...]:
    """Return when the motion that a decay continues, from a first time on, may have been let go.

    A look at all of a long recording would cost too much.
    """
    earliest = max(as_signal(record).start, first - BEFORE_DECAY * (used.stop - first))
    return releases_before(as_signal(cut(record, start=earliest, stop=used.stop)), first)


def _after(signal: Signal, best: Used) -> RealArray:
    """Return the samples of a record after the stretch that is used, (channel, sample), of its channels."""
    rows = [signal.channels.index(name) for name in as_signal(best.record).channels]
    return signal.values[rows][:, signal.timepts > best.used[0].stop + 0.5 * signal.step]


def _before(used: Decay, decays: Sequence[Decay], signal: Signal) -> list[Decay]:
    """Return the decays that begin before the one that is used: those that contain it or that it continues, joined."""
    earlier = [decay for decay in decays if decay.start < used.start]
    return [
        decay if decay.stop >= used.stop else _until(decay, used.stop)
        for decay in earlier
        if decay.stop >= used.stop or _continued(signal, decay, used)
    ]


def _longer_decays(
    used: Decay, decays: Sequence[Decay], *, before: Sequence[Decay], released: Sequence[Second], end: Second
) -> Iterator[Decay]:
    """Yield longer decays: the one that is used from where the motion before it was let go, then those before it.

    Then it joined to the next where it is cut off, and continued to the last sample of the record where no other was
    found: what fills it has no background to meet.
    """
    yield from (replace(used, start=start) for start in released if start < used.start - EARLIER * _period(used))
    yield from before
    if any(doubt.code is DecayDoubt.CUT_OFF for doubt in used.doubts):
        after = [
            d for d in decays if used.start < d.start <= used.stop + SHORT_PAUSE * _period(used) and d.stop > used.stop
        ]
        yield from (_until(used, decay.stop) for decay in after)
    if len(decays) == 1 and end > used.stop:
        yield _until(used, end)


def _goes_on(found: Identification | None, after: RealArray) -> bool:
    """Return whether the samples after a decay (channel, sample) move more than what the fit to it leaves."""
    if found is None or not after.shape[1]:
        return found is None
    return bool(np.any(np.ptp(after, axis=1) > MOVES * found.noise_std))


def _shows_more(longer: Identification, found: Identification | None) -> bool:
    """Return whether an identification of a longer decay leaves only noise, and tells more than the other.

    Where the other is doubtful, forces may explain the longer one instead. It has all modes of the other unless that is
    doubtful, and more modes that are well known or as good a verdict.
    """
    if longer.verdict.level is Level.DOUBTFUL:
        return False
    if found is None or not len(found.modes) or found.verdict.level is Level.DOUBTFUL:
        return settled(longer) or explained_by_forces(longer)
    if not settled(longer):
        return False
    modes = found.modes
    apart = np.min(np.abs(modes.poles[:, None] - longer.modes.poles), axis=1)
    unknown = np.zeros(len(modes)) if modes.wn_std is None else NORMAL_95 * modes.wn_std
    kept = bool(np.all(apart < np.maximum(SAME_POLE * modes.wn, unknown)))
    more = _known(longer) - _known(found)
    return kept and (more > 0 or (more == 0 and longer.verdict.level >= found.verdict.level))


def _shows_all(longer: Identification, used: Decay) -> bool:
    """Return whether an identification leaves only noise and has the modes of a part that a quick fit found."""
    wn, modes = longer.modes.wn, used.wn
    if not settled(longer) or longer.verdict.level is Level.DOUBTFUL or not len(modes):
        return False
    return bool(np.all(np.min(np.abs(modes[:, None] - wn), axis=1) < SAME_POLE * modes))


def shared_modes(found: Sequence[Identification | None]) -> list[float]:
    """Return which share of the modes of each identification one of the others has too."""
    poles = [np.zeros(0, complex) if one is None else one.modes.poles for one in found]
    shares = []
    for k, own in enumerate(poles):
        others = np.concatenate([np.zeros(0, complex), *(other for j, other in enumerate(poles) if j != k)])
        if not own.size or not others.size:
            shares.append(0.0)
            continue
        apart = np.min(np.abs(own[:, None] - others), axis=1)
        shares.append(float(np.mean(apart < SAME_POLE * np.abs(own))))
    return shares


def _until(decay: Decay, stop: Second) -> Decay:
    """Return a decay that ends later."""
    return replace(decay, stop=stop, doubts=tuple(doubt for doubt in decay.doubts if doubt.code not in OF_LENGTH))


def _known(found: Identification) -> int:
    """Return the number of modes that are well known."""
    modes = found.modes
    if modes.wn_std is None or modes.zeta_std is None:
        return len(modes)
    sure = (modes.wn_std < KNOWN_WN * modes.wn) & (modes.zeta_std < KNOWN_ZETA * np.abs(modes.zeta))
    return int(np.sum(sure))


def _continued(signal: Signal, before: Decay, after: Decay) -> bool:
    """Return whether one decay continues another: after a short pause, or without a rise of the motion between them."""
    if before.stop >= after.start - SHORT_PAUSE * _period(after):
        return True
    borders = np.searchsorted(signal.timepts, [before.start, before.stop, after.start, after.stop], side="right")
    parts = [signal.values[:, i:j] for i, j in itertools.pairwise(borders.tolist())]
    if min(part.shape[1] for part in parts) < 2:
        return False
    first, pause, last = (np.ptp(part, axis=1) for part in parts)
    return bool(np.all(first > pause) and np.all(pause > last))


def _period(decay: Decay) -> Second:
    return 2 * np.pi / float(np.min(decay.wn)) if len(decay.wn) else 0.0
