"""What an identification of a longer decay shows beside that of its part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.analysis.choice import explained_by_forces, explains, settled, settled_by_forces, with_few_cycles
from suspid.analysis.forced_start import SAME_POLE
from suspid.analysis.swelling import beats
from suspid.decays import Decay
from suspid.identification import Identification, removed_as
from suspid.levels import NORMAL_95
from suspid.samples import held
from suspid.signals import as_signal
from suspid.words import Level, Reason

# A mode is well known if the standard deviations of its frequency and of its damping ratio are below these shares. A
# mode of a longer decay that is not is no gain.
KNOWN_WN, KNOWN_ZETA = 0.01, 0.25


def shows_more(longer: Identification, found: Identification | None) -> bool:
    """Return whether an identification of a longer decay leaves only noise, and tells more than the other.

    Where the other is doubtful, or has a trace of something else, forces may explain the longer one instead, or close
    modes that beat: where they are out of step, a decay seems to end. It has all modes of the other unless that is
    doubtful, makes few cycles, or explains its part as well; and more modes that are well known or as good a verdict.
    """
    if longer.verdict.level is Level.DOUBTFUL:
        return found is not None and found.verdict.level is Level.DOUBTFUL and _with_fewer(longer, found)
    if found is not None and tells_tones(longer, found):
        return True
    traced = found is not None and any(c.remark.code is Reason.TRACE for c in found.considered)
    if found is None or not len(found.modes) or found.verdict.level is Level.DOUBTFUL or traced:
        closer = found is not None and not traced and len(longer.modes) and np.all(longer.explained > found.explained)
        return settled(longer) or explained_by_forces(longer) or beats(longer) > 0 or bool(closer)
    if not settled(longer):
        return False
    modes, few = found.modes, with_few_cycles(found)
    apart = np.min(np.abs(modes.poles[:, None] - longer.modes.poles), axis=1)
    unknown = np.zeros(len(modes)) if modes.wn_std is None else NORMAL_95 * modes.wn_std
    same = apart < np.maximum(SAME_POLE * modes.wn, unknown)
    if few[:1].any() and not with_few_cycles(longer).any() and np.all(same | few):
        return True
    # Few cycles before a dead stop look like other modes.
    if few.all() and _with_fewer(longer, found):
        return True
    kept = bool(np.all(same)) or explains(longer, found)
    more = known_modes(longer) - known_modes(found)
    return kept and (more > 0 or (more == 0 and longer.verdict.level >= found.verdict.level))


def tells_tones(longer: Identification, found: Identification) -> bool:
    """Return whether a longer decay shows that a tone of a part fades: it has a mode there, and those of the part."""
    tones = [c.pole for c in removed_as(found.considered, Reason.TONE)]
    modes = longer.modes
    if not tones or not 0 < len(found.modes) < len(modes) or modes.wn_std is None:
        return False
    there = np.abs(np.array([*found.modes.poles, *tones])[:, None].imag - modes.poles.imag)
    finest = np.pi / as_signal(held(found, "response")).duration
    same = np.all(np.min(there[: len(found.modes)], axis=1) < finest) and np.all(np.min(there, axis=0) < finest)
    return bool(same and np.all(modes.wn_std < KNOWN_WN * modes.wn))


def _with_fewer(longer: Identification, found: Identification) -> bool:
    """Return whether forces explain a longer decay down to its noise, and its part as well as more poles do."""
    return settled_by_forces(longer) and explains(longer, found)


def shows_all(longer: Identification, used: Decay) -> bool:
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


def known_modes(found: Identification) -> int:
    """Return the number of modes that are well known; damping that changes with the amplitude is known at each."""
    modes = found.modes
    if modes.wn_std is None or modes.zeta_std is None:
        return len(modes)
    sure = modes.zeta_std < KNOWN_ZETA * np.abs(modes.zeta)
    if len(found.amplitude_dependence) == len(modes):
        sure |= [bool(np.all(each.zeta_std < KNOWN_ZETA * np.abs(each.zeta))) for each in found.amplitude_dependence]
    return int(np.sum(sure & (modes.wn_std < KNOWN_WN * modes.wn)))
