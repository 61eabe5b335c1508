"""Modes that are doubtful, and that nothing but the fit to one stretch supports: they are no finding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.analysis.choice import NO_CYCLE, doubts_of, level_of, settled, swings
from suspid.analysis.settings import Settings
from suspid.analysis.standstill import swings_on
from suspid.analysis.swelling import beats, beyond_wave, left_by_modes
from suspid.analysis.swings import shown_by_swings
from suspid.analysis.used import Used
from suspid.decays import SAME_MODE, SMALL, Decay, in_common, is_grave, share_of
from suspid.identification import Considered, Identification, swings_many_times
from suspid.records import late_start, of_channels
from suspid.samples import held
from suspid.signals import as_signal
from suspid.values import frozen_real
from suspid.words import DecayDoubt, Level, ModeCheck, Note, Reason, RecordCheck, Remark

if TYPE_CHECKING:
    import control

# A mode that swings many times, and explains this share of the energy of a channel by itself, is plain to see: a burst
# of a voice has other tones beside.
NEARLY_ALL = 0.95
# Several that swing many times, and together beat this often, are as plain.
PLAIN_BEATS = 2
# One that swings this often, and would many times before it has faded, must explain this share: slow noise that a pole
# follows for a few cycles leaves more.
FEW_SWINGS, ALL_BUT_NOISE = 3.0, 0.999


def supported(
    found: Identification,
    stretch: Used,
    settings: Settings,
    *,
    whole: control.TimeResponseData | None = None,
    wave: bool = False,
) -> Identification:
    """Return an identification without its modes if they are doubtful and nothing but the fit to one stretch has them.

    A stretch that was chosen as the most like a decay of several, or of all that could be cut from a record, is like
    one by chance more often than a stretch that was given. What is not beyond doubt by itself then needs support: the
    same modes in both halves of the stretch, or in another stretch, or a mode whose swings the ``whole`` record shows
    between two rests, or that is nearly all of the motion over many cycles. What a ``wave`` (see `of_a_wave`) explains
    down to the noise of the fit has none. A mode that would swing on where the ``whole`` record stands still is none.
    The fit stays as it is. What the settings choose, a stretch or the number of modes, is not questioned.
    """
    if not questioned(found, settings):
        return found
    on = np.zeros(len(found.modes), bool) if whole is None else swings_on(found, whole)
    if on.any() and not on.all():
        found = _without(found, on, Remark(Reason.STANDS_STILL))
    lost = wave and (not stretch.used or level_of(found, stretch.used, stretch.decays) is Level.DOUBTFUL)
    reason = Remark(Reason.SWELLS) if lost else _reason(found, stretch, whole)
    if reason is None:
        return found
    shown = np.zeros(len(found.modes), bool)
    if reason.code is Reason.UNSUPPORTED and not found.forces:
        names = as_signal(stretch.record).channels
        shown = shown_by_swings(of_channels(stretch.record if whole is None else whole, names), found.modes)
        shown |= _coherent(found)
    if shown.all():
        return found
    return _without(found, ~shown, reason)


def _without(found: Identification, lost: NDArray[np.bool_], reason: Remark) -> Identification:
    """Return an identification without some of its modes, which are rejected for a reason; the fit stays as it is."""
    slow = reason.code is Reason.NO_SWING
    none = tuple(
        Considered(
            pole=complex(pole), remark=Remark(Reason.UNSUPPORTED) if slow and zeta < NO_CYCLE else reason, removed=True
        )
        for pole, zeta in zip(found.modes.poles[lost], found.modes.zeta[lost], strict=True)
    )
    return replace(
        found,
        modes=found.modes[~lost],
        loudness=frozen_real(found.loudness[~lost]),
        considered=(*none, *found.considered),
        amplitude_dependence=(),
        forces=(),
    )


def of_a_wave(
    found: Identification, stretch: Used, settings: Settings, whole: control.TimeResponseData
) -> tuple[bool, bool]:
    """Return whether a stretch is of motion that swells and fades as one wave, and whether it is nothing else.

    Free motion that forces build up looks like a wave too, but is none down to the noise. A whole record that is free
    from its first sample on does not swell, and close modes that beat rise more than once.
    """
    if not questioned(found, settings) or _long_checked(found, stretch):
        return False, False
    beyond = beyond_wave(whole, found)
    wave = beyond < np.inf and not beats(found)
    return wave, wave and (not stretch.used or beyond <= 0)


def doubted_as_wave(stretch: Used) -> Used:
    """Return a stretch with the doubt that its motion swells and fades as one wave."""
    doubt = Remark(DecayDoubt.SWELLS)
    return replace(
        stretch,
        used=tuple(replace(decay, doubts=(*decay.doubts, doubt)) for decay in stretch.used),
        notes=(*stretch.notes, Remark(Note.DECAY_DOUBT, {"doubt": str(doubt)})),
    )


def questioned(found: Identification, settings: Settings) -> bool:
    """Return whether nothing of an identification was chosen by the settings."""
    chosen = settings.decay != "auto" or any(s is not None for s in (settings.start, settings.stop, settings.modes))
    return not chosen and found.method == "likelihood"


def _reason(found: Identification, stretch: Used, whole: control.TimeResponseData | None) -> Remark | None:
    """Return the reason why the modes of an identification are none, if there is one."""
    used, decays = stretch.used, stretch.decays
    if level_of(found, used, decays) is not Level.DOUBTFUL:
        return None
    doubts = [check for check in doubts_of(used, found, decays) if check.level is Level.DOUBTFUL]
    grave = any(check.remark.code is RecordCheck.DECAY for check in doubts)
    unlike = [check.remark.numbers for check in doubts if check.remark.code is RecordCheck.NOT_REPEATED]
    # That no other stretch has the modes of one beyond doubt is said, and left to the user. What needs friction or
    # other forces is not: halves of different size cannot check them.
    if unlike and (grave or found.forces or found.verdict.level is Level.DOUBTFUL):
        return Remark(Reason.BY_CHANCE, unlike[0])
    if not used and not swings(found.modes):
        return Remark(Reason.NO_SWING)
    small = _small(used, whole)
    weak = grave or small or _one_place(found) or (_short(used) if used else not _let_go(found, stretch))
    # What needs forces is not checked by halves: of many stretches of driven motion, they explain one by chance.
    alone = _alone(found) or (small and bool(found.forces))
    return Remark(Reason.UNSUPPORTED) if weak and alone and not _again(found, stretch) else None


def _long_checked(found: Identification, stretch: Used) -> bool:
    """Return whether both halves of a decay of several cycles show a mode: one that hands pump up swells, too."""
    agree = any(check.remark.code is ModeCheck.HALVES_AGREE for check in found.verdict.checks)
    return agree and not _short(stretch.used)


def _short(used: Sequence[Decay]) -> bool:
    """Return whether the stretch is shorter than two cycles of its slowest mode."""
    return any(doubt.code is DecayDoubt.TOO_SHORT for decay in used for doubt in decay.doubts)


def _small(used: Sequence[Decay], whole: control.TimeResponseData | None) -> bool:
    """Return whether nearly all of the motion of a record is elsewhere: of many stretches, one is a decay by chance."""
    return whole is not None and any(share_of(as_signal(whole), decay) < SMALL for decay in used)


def _let_go(found: Identification, stretch: Used) -> bool:
    """Return whether a whole record begins as a decay does, or is free motion that no search for decays was needed for.

    What moves most at a later time was set in motion within the record.
    """
    wanting = any(note.code is Note.WHOLE_RECORD and not note.numbers["clear"] for note in stretch.notes)
    return late_start(as_signal(stretch.record)) is None or (settled(found) and not wanting)


def _one_place(found: Identification) -> bool:
    """Return whether several modes move several channels alike: modes of a structure have shapes of their own."""
    several = len(found.modes) > 1 and len(found.noise_std) > 1
    return several and any(check.remark.code is ModeCheck.ONE_SHAPE for check in found.verdict.checks)


def _alone(found: Identification) -> bool:
    """Return whether no mode is seen in both halves of a stretch, and the fit is loose or a pulse has one like it."""
    checks = found.verdict.checks
    return any(c.level is Level.DOUBTFUL and c.remark.code is ModeCheck.NOT_CROSS_CHECKED for c in checks)


def _coherent(found: Identification) -> NDArray[np.bool_]:
    """Return which modes are nearly all of a channel's motion over many cycles, or all of it over a few, (mode,).

    Close modes that beat are so together. Two parts of a light decay do not tell its damping; that one swing goes on at
    one frequency they show.
    """
    signal = as_signal(held(found, "response"))
    duration = signal.step * (signal.values.shape[1] - 1)
    many = swings_many_times(found.modes, duration)
    few = found.modes.poles.imag * duration > 2 * np.pi * FEW_SWINGS
    coherent = many | (few & swings_many_times(found.modes, np.inf))
    for mode in np.flatnonzero(coherent):
        left = np.min(left_by_modes(signal, found.modes[mode : mode + 1]))
        coherent[mode] = left < 1 - (NEARLY_ALL if many[mode] else ALL_BUT_NOISE)
    return np.asarray(coherent | (many & (beats(found) >= PLAIN_BEATS)))


def _again(found: Identification, stretch: Used) -> bool:
    """Return whether half of the other stretches may be free motion and show a mode; of parts of the record, two do.

    A body that is let go again shows its modes each time; of many stretches of driven motion, one does by chance.
    """
    used = stretch.used
    apart = [d for d in stretch.decays if d.wn.size and all(d.stop <= one.start or d.start >= one.stop for one in used)]
    free = [d for d in apart if not any(is_grave(doubt) for doubt in d.doubts)]
    alike = sum(in_common(d.wn, found.modes.wn, within=SAME_MODE) for d in free)
    return alike >= (1 if used else 2) and 2 * alike >= len(apart)
