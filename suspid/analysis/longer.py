"""Whether the decay that is used is the end of a longer one, which shows more of its modes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from suspid.analysis.choice import settled
from suspid.analysis.forced_start import SAME_POLE
from suspid.decays import Decay
from suspid.identification import Identification
from suspid.units import RealArray, Second
from suspid.words import DecayDoubt, Level

# Two decays are one where the later begins within this number of periods of its slowest mode after the earlier.
# Friction that holds a mass and lets it go parts them; a larger number tries to join a second release to the first.
SHORT_PAUSE = 1.0
# The motion goes on after a decay if the samples there spread by more than this many standard deviations of the
# residual. White noise hardly spreads by more than ten; a smaller number costs the time of a fit where none is needed.
MOVES = 15.0
# A mode is well known if the standard deviations of its frequency and of its damping ratio are below these shares. A
# mode of a longer decay that is not is no gain.
KNOWN_WN, KNOWN_ZETA = 0.01, 0.25
# Doubts that end with the first of two decays that are joined.
OF_LENGTH = frozenset({DecayDoubt.CUT_OFF, DecayDoubt.FEW_CYCLES, DecayDoubt.TOO_SHORT, DecayDoubt.FEW_SAMPLES})


def longer_decays(used: Decay, decays: Sequence[Decay], *, released: Second | None, end: Second) -> Iterator[Decay]:
    """Yield decays that begin before the one that is used and contain it, or end where it begins, joined to it.

    One that is cut off is joined to the next. Then that of a single event, from the release before it, and to the last
    sample of the record: what fills it has no background to meet.
    """
    for decay in decays:
        if decay.start >= used.start:
            continue
        if decay.stop >= used.stop:
            yield decay
        elif decay.stop >= used.start - SHORT_PAUSE * _period(used):
            yield _until(decay, max(decay.stop, used.stop))
    if any(doubt.code is DecayDoubt.CUT_OFF for doubt in used.doubts):
        after = [
            d for d in decays if used.start < d.start <= used.stop + SHORT_PAUSE * _period(used) and d.stop > used.stop
        ]
        yield from (_until(used, decay.stop) for decay in after)
    if len(decays) == 1 and released is not None and released < used.start - _period(used):
        yield replace(used, start=released)
    if len(decays) == 1 and end > used.stop:
        yield _until(used, end)


def goes_on(found: Identification | None, after: RealArray) -> bool:
    """Return whether the samples after a decay (channel, sample) move more than what the fit to it leaves."""
    if found is None or not after.shape[1]:
        return found is None
    return bool(np.any(np.ptp(after, axis=1) > MOVES * found.noise_std))


def shows_more(longer: Identification, found: Identification | None) -> bool:
    """Return whether an identification of a longer decay leaves only noise, and tells more than the other.

    It has all modes of the other unless that is doubtful, and more modes that are well known or as good a verdict.
    """
    if not settled(longer) or longer.verdict.level is Level.DOUBTFUL:
        return False
    if found is None or not len(found.modes) or found.verdict.level is Level.DOUBTFUL:
        return True
    apart = np.abs(found.modes.poles[:, None] - longer.modes.poles)
    kept = bool(np.all(np.min(apart, axis=1) < SAME_POLE * np.abs(found.modes.poles)))
    more = _known(longer) - _known(found)
    return kept and (more > 0 or (more == 0 and longer.verdict.level >= found.verdict.level))


def shared_modes(found: Sequence[Identification | None]) -> list[float]:
    """Return which share of the modes of each identification one of the others has too."""
    poles = [np.zeros(0, complex) if one is None else one.modes.poles for one in found]
    shares = []
    for k, own in enumerate(poles):
        others = np.concatenate([other for j, other in enumerate(poles) if j != k])
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


def _period(decay: Decay) -> Second:
    return 2 * np.pi / float(np.min(decay.wn)) if len(decay.wn) else 0.0
