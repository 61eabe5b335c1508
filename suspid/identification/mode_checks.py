"""Checks of single modes: their halves, precision, cycles and amplitudes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.files import printable
from suspid.identification.combs import OVERTONES, repeated_in
from suspid.identification.fitting import BENT
from suspid.identification.noise import LOUD
from suspid.levels import NORMAL_95, SURE
from suspid.model import modal_assurance
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Ratio, RealArray, Second
from suspid.words import Check, Level, ModeCheck, Number, Reason, Remark

if TYPE_CHECKING:
    from suspid.identification.identification import Identification
    from suspid.model import ModalSet

# Half widths of the interval, as shares of the value, from which on zeta is unknown, zeta is rough, wn is rough.
UNKNOWN_ZETA, ROUGH_ZETA, ROUGH_WN = 1.0, 0.25, 0.05
# Where the residual near a mode has this many times the power of white noise, a mode whose zeta is unknown, or whose wn
# is open to this share, is no more than what some other motion leaves there. A smaller number doubts weak modes in
# noise with a little colour; a smaller share those of a body that is damped heavily.
LINE_OF_OTHER_MOTION, OPEN_WN = 2.0, 0.1
# More hardly known modes than this, of which wn is as open or zeta is to this share, and more than half of all: poles
# that no motion of a structure needs. Wheels beside a body, and a heavily damped car, have fewer. So are more than two
# thirds of all whose zeta is rough and that the halves do not check.
FEWEST_OPEN, OPEN_ZETA, MOST, NEARLY_EACH = 2, 0.5, 1 / 2, 2 / 3
# Phase collinearity below which the channels of a mode are out of phase.
OUT_OF_PHASE = 0.5
# A mode with fewer cycles in the record than this, that has not decayed by as many nepers, is known from few cycles.
# One more than `DOUBTED_CYCLES` of a decay: a mode seen over two cycles is used, with this remark.
CYCLES_SEEN = 3.0
# Modes form a row where each lies within this multiple of two half widths of the next. Each channel tells one
# shape, and two more are told by frequency: a longer row is what a fit makes of a band of noise. A smaller first number
# misses rows of which each second line is left out; a larger one takes the modes of a damped car for a row.
SIDE_BY_SIDE, TOLD_BY_FREQUENCY = 2.0, 2
# Two modes of one shape (MAC) within a line, of which one fades this many times as fast as the other, are what a mode
# looks like whose damping falls with its amplitude. A smaller number doubts pairs of close modes that are linear; those
# of one structure have like damping. Of a motion and its rate, the shape is the pole.
BROAD_BESIDE_NARROW, ONE_SHAPE = 3.0, 0.99
# And their frequencies are this near: no damping moves one further.
ONE_FREQUENCY = 1.1
# A mode at a multiple of another is damped as that is, to this factor; its frequency is known to this share. Another
# lies there by chance once in fifty.
ALIKE_DAMPED, MULTIPLE_KNOWN = 1.5, 0.005
# Where its damping is hardly known, a mode that lies as near to the double of another is one as well.
NEAR_DOUBLE = 0.02
# What swings for this many samples and cycles at most, until it has fallen to 1/e, and is over within this share of the
# time of another mode, may be a flash: a switch or a contact makes such. Wheels take a tenth of the time of a body.
FLASH_SAMPLES, FLASH_CYCLES, FLASH_TIME = 10.0, 3.0, 0.01
# A mode that makes this many cycles before it has fallen to 1/e is plain to see. A pulse of force makes fewer, and
# noise in a band keeps its phase for fewer.
MANY_CYCLES = 10.0


def check_of(code: ModeCheck, level: Level, numbers: Mapping[str, Number] | None = None) -> Check:
    """Return a check of an identification."""
    return Check(Remark(code, numbers or {}), level)


def check_halves(found: Identification) -> Iterator[Check]:
    """Check that both halves of the decay show the same modes."""
    apart = found.halves
    known = np.isfinite(apart)
    for mode, value in enumerate(apart.tolist(), 1):
        if value > SURE:
            yield check_of(ModeCheck.HALVES_DISAGREE, Level.CARE, {"mode": mode, "apart": value})
    if np.any(known) and np.nanmax(apart) <= SURE:
        which = "every mode" if np.all(known) else f"mode {', '.join(map(str, numbers_of(known)))}"
        yield check_of(ModeCheck.HALVES_AGREE, Level.SOUND, {"which": which, "most": float(np.nanmax(apart))})


def check_amplitudes(found: Identification) -> Iterator[Check]:
    """Check whether the decay is linear; if not, how each mode depends on its amplitude."""
    if not found.forces:
        return
    kinds = tuple(dict.fromkeys(force.kind.value for force in found.forces))
    # Where all modes of a nonlinear fit fall by half in their first cycle, a pulse of force without ringing looks the
    # same. Friction ends a motion that swung at first.
    first = [each.known.ends[0][1] for each in found.amplitude_dependence]
    swings = bool(min([*found.modes.zeta.tolist(), *first]) < np.log(2) / (2 * np.pi))
    yield check_of(ModeCheck.NONLINEAR, Level.CARE if swings else Level.DOUBTFUL, {"forces": kinds})
    if len(found.modes) == 1 and any(each.beats for each in found.amplitude_dependence):
        yield check_of(ModeCheck.BEATS, Level.DOUBTFUL)
    for mode, every in enumerate(found.amplitude_dependence, 1):
        if not every.varies:
            continue
        each = every.known
        (high_wn, high_zeta), (low_wn, low_zeta) = each.ends
        numbers: dict[str, Number] = {
            "mode": mode,
            "high": float(np.max(each.amplitude)),
            "high_hz": high_wn / (2 * np.pi),
            "high_zeta": high_zeta,
            "high_within": NORMAL_95 * float(each.zeta_std[int(np.argmax(each.amplitude))]),
            "low": float(np.min(each.amplitude)),
            "low_hz": low_wn / (2 * np.pi),
            "low_zeta": low_zeta,
            "low_within": NORMAL_95 * float(each.zeta_std[int(np.argmin(each.amplitude))]),
            "channel": printable(each.channel),
            "holds": each.holds_at,
        }
        yield check_of(ModeCheck.AMPLITUDE, Level.NOTE, numbers)


def check_resolution(found: Identification) -> Iterator[Check]:
    """Check that no mode may as well be two."""
    partners = [c.pole for c in found.considered if c.remark.code is Reason.UNRESOLVED]
    modes = sorted({int(np.argmin(np.abs(found.modes.poles - pole))) + 1 for pole in partners})
    if modes:
        yield check_of(ModeCheck.UNRESOLVED, Level.CARE, {"modes": tuple(modes)})


def check_parts(found: Identification) -> Iterator[Check]:
    """Check that no two modes lie as near each other as the parts of one that bends.

    That counts where the fit leaves them loud, or where all channels see a broad line and a narrow one alike.
    """
    if found.forces:
        return
    poles, loud, pairs = found.modes.poles, found.loudness > LOUD, found.modes.poles.imag > 0
    rates, size = np.abs(poles.real), np.log(np.abs(poles))
    # A part that is gone at once is as broad as its line: the wider of the two counts.
    widths = np.maximum(rates[:, None], rates)
    near = (np.abs(poles[:, None] - poles) < BENT * widths) & pairs[:, None] & pairs & ~np.eye(len(poles), dtype=bool)
    parts = numbers_of(np.any(near & loud[:, None] & loud, axis=1))
    if parts:
        yield check_of(ModeCheck.PARTS, Level.DOUBTFUL, {"modes": parts})
    elif found.modes.shapes is not None:
        broad = widths > BROAD_BESIDE_NARROW * np.minimum(rates[:, None], rates)
        alike = np.abs(size[:, None] - size) < np.log(ONE_FREQUENCY)
        alike &= modal_assurance(found.modes.shapes, found.modes.shapes) > ONE_SHAPE
        parts = numbers_of(np.any(near & broad & alike, axis=1))
        if parts:
            yield check_of(ModeCheck.BROAD_AND_NARROW, Level.DOUBTFUL, {"modes": parts})


def check_rows(found: Identification) -> Iterator[Check]:
    """Check that no more modes stand in a row, side by side, than the channels can tell from a band of noise."""
    poles = found.modes.poles[found.modes.poles.imag > 0]
    order = np.argsort(poles.imag)
    frequency, width = poles.imag[order], np.abs(poles.real)[order]
    breaks = np.diff(frequency) > SIDE_BY_SIDE * (width[1:] + width[:-1])
    numbers = np.flatnonzero(found.modes.poles.imag > 0)[order]
    for row in np.split(numbers, np.flatnonzero(breaks) + 1):
        if row.size > len(found.noise_std) + TOLD_BY_FREQUENCY:
            modes = tuple(sorted(int(number) + 1 for number in row))
            yield check_of(ModeCheck.IN_A_ROW, Level.DOUBTFUL, {"modes": modes, "channels": len(found.noise_std)})


def check_pulses(found: Identification) -> Iterator[Check]:
    """Check that the modes are not the lines of a train of pulses, each lower than the one before."""
    harmonics = [c.pole for c in found.considered if c.remark.code is Reason.HARMONIC]
    duration = as_signal(held(found, "response")).duration
    shared = repeated_in(found.modes.poles, np.array(harmonics, complex), duration)
    if shared is not None:
        numbers = {"hertz": shared / (2 * np.pi), "seconds": 2 * np.pi / shared}
        yield check_of(ModeCheck.PULSE_TRAIN, Level.DOUBTFUL, numbers)


def check_flashes(found: Identification) -> Iterator[Check]:
    """Check that no mode is over in a few samples, long before the others have begun to decay."""
    brief = flashes(found)
    if np.any(brief):
        yield check_of(ModeCheck.FLASH, Level.DOUBTFUL, {"modes": numbers_of(brief)})


def flashes(found: Identification) -> NDArray[np.bool_]:
    """Return which modes are over in a few samples, long before the others have begun to decay, (mode,)."""
    poles, step = found.modes.poles, as_signal(held(found, "response")).step
    falls = -poles.real
    brief = (poles.imag > 0) & (falls * step > 1 / FLASH_SAMPLES) & ~np.isfinite(found.halves)
    brief &= np.abs(poles.imag) < 2 * np.pi * FLASH_CYCLES * falls
    return np.asarray(brief & (falls * FLASH_TIME > np.min(falls, initial=np.inf)))


def check_followed(found: Identification) -> Iterator[Check]:
    """Check that the modes stand out of the residual near them."""
    kept = [c.pole for c in found.considered if c.remark.code is Reason.FOLLOWED]
    modes = sorted({int(np.argmin(np.abs(found.modes.poles - pole))) + 1 for pole in kept})
    if modes:
        yield check_of(ModeCheck.FOLLOWED, Level.DOUBTFUL, {"modes": tuple(modes)})


def check_phases(found: Identification) -> Iterator[Check]:
    """Check whether all channels of each mode move in phase or antiphase."""
    modes = numbers_of((np.array(found.modes.kinds) == "pair") & (found.collinearity < OUT_OF_PHASE))
    if len(found.modes.channels) > 1 and modes:
        yield check_of(ModeCheck.OUT_OF_PHASE, Level.NOTE, {"modes": modes})


def check_multiples(found: Identification) -> Iterator[Check]:
    """Check that no mode turns at twice or three times the frequency of another and is damped as that is.

    The first is named: strings have many. Of a mode whose damping is hardly known, that is said of the double.
    """
    modes = found.modes
    if modes.wn_std is None or modes.zeta_std is None:
        return
    rough = NORMAL_95 * modes.zeta_std > ROUGH_ZETA * np.abs(modes.zeta)
    wd = np.where(np.array(modes.kinds) == "pair", np.abs(modes.poles.imag), np.nan)
    for one, other in itertools.permutations(range(len(modes)), 2):
        for multiple in OVERTONES:
            std = float(np.hypot(multiple * modes.wn_std[one], modes.wn_std[other]))
            off = abs(wd[other] - multiple * wd[one])
            alike = 1 / ALIKE_DAMPED < modes.zeta[other] / max(modes.zeta[one], 1e-300) < ALIKE_DAMPED
            known = alike and std < MULTIPLE_KNOWN * wd[other] and off < SURE * std
            as_far = modes.zeta_std[one] + modes.zeta_std[other]
            apart = abs(modes.zeta[other] - modes.zeta[one])
            loosely = rough[other] and multiple == 2 and apart < SURE * as_far
            if known or (loosely and off < min(SURE * std, NEAR_DOUBLE * wd[other])):
                numbers = {"one": one + 1, "other": other + 1, "multiple": multiple}
                yield check_of(ModeCheck.MULTIPLE, Level.CARE, numbers)
                return


def check_cycles(found: Identification) -> Iterator[Check]:
    """Check that each oscillation is seen over several cycles or until it has decayed, and that there is one."""
    poles, duration = found.modes.poles, as_signal(held(found, "response")).duration
    cycles = np.abs(poles.imag) * duration / (2 * np.pi)
    few = (poles.imag != 0) & (cycles < CYCLES_SEEN) & (-poles.real * duration < CYCLES_SEEN)
    for k in np.flatnonzero(few).tolist():
        yield check_of(ModeCheck.FEW_CYCLES, Level.CARE, {"mode": k + 1, "cycles": float(cycles[k])})
    if not np.any(poles.imag != 0):
        # What the residual contradicts is a drift; two and more follow any slow fall, as of one whose rate changes.
        guessed = len(found.modes) > 1 or bool(np.any(found.loudness > 1))
        yield check_of(ModeCheck.REAL_ONLY, Level.DOUBTFUL if guessed else Level.CARE)


def check_precision(modes: ModalSet, loudness: RealArray, halves: RealArray, level: Ratio) -> Iterator[Check]:
    """Check how wide the intervals are; ``halves`` are NaN where nothing but the fit supports a mode."""
    if modes.covariance is None:
        return
    ends = modes.interval(level)
    pairs = np.array(modes.kinds) == "pair"
    wn = (ends.wn[:, 1] - modes.wn) / np.where(modes.wn > 0, modes.wn, 1.0)
    zeta = (ends.zeta[:, 1] - modes.zeta) / np.where(modes.zeta != 0, np.abs(modes.zeta), 1.0)
    vague = pairs & (zeta > UNKNOWN_ZETA)
    rough = pairs & ~vague & (zeta > ROUGH_ZETA) | pairs & (wn > ROUGH_WN)
    if np.any(vague):
        other = bool(np.any(loudness[vague] > LINE_OF_OTHER_MOTION))
        yield check_of(ModeCheck.DAMPING_UNKNOWN, Level.DOUBTFUL if other else Level.CARE, {"modes": numbers_of(vague)})
    for k in np.flatnonzero(rough).tolist():
        numbers: dict[str, Number] = {"mode": k + 1}
        numbers |= {"wn": float(wn[k])} if wn[k] > ROUGH_WN else {}
        numbers |= {"zeta": float(zeta[k])} if ROUGH_ZETA < zeta[k] <= UNKNOWN_ZETA else {}
        other = wn[k] > OPEN_WN and loudness[k] > LINE_OF_OTHER_MOTION
        yield check_of(ModeCheck.KNOWN_ROUGHLY, Level.DOUBTFUL if other else Level.CARE, numbers)
    hardly, loose = pairs & ((zeta > OPEN_ZETA) | (wn > OPEN_WN)), pairs & (zeta > ROUGH_ZETA)
    unchecked = loose & ~np.isfinite(halves) if np.sum(loose) > FEWEST_OPEN else np.zeros_like(loose)
    for which, share in ((hardly, MOST), (unchecked, NEARLY_EACH)):
        if max(FEWEST_OPEN, np.sum(pairs) * share) < np.sum(which):
            yield check_of(ModeCheck.MOSTLY_OPEN, Level.DOUBTFUL, {"modes": numbers_of(which)})
            break
    if np.any(pairs) and not np.any(vague | rough):
        most = {"wn": float(np.max(wn[pairs])), "zeta": float(np.max(zeta[pairs])), "level": float(level)}
        yield check_of(ModeCheck.KNOWN, Level.SOUND, most)


def swings_many_times(modes: ModalSet, duration: Second) -> NDArray[np.bool_]:
    """Return which modes make `MANY_CYCLES` before they have fallen to 1/e, or a record ends, (mode,)."""
    return np.asarray(cycles_seen(modes, duration, nepers=1.0) > MANY_CYCLES)


def cycles_seen(modes: ModalSet, duration: Second, *, nepers: float) -> RealArray:
    """Return how many cycles each mode makes before it has fallen by this much, or a record ends, (mode,).

    Examples
    --------
    >>> from suspid import ModalSet
    >>> modes = ModalSet(poles=np.array([-1 + 20j * np.pi]))
    >>> cycles_seen(modes, 2.0, nepers=1.0).round(6), cycles_seen(modes, 2.0, nepers=3.0).round(6)
    (array([10.]), array([20.]))
    """
    lasting = np.minimum(duration, nepers / np.abs(modes.poles.real).clip(1e-300))
    return np.asarray(np.abs(modes.poles.imag) * lasting / (2 * np.pi))


def numbers_of(which: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> tuple[int, ...]:
    """Return the numbers of modes, from 1 on."""
    return tuple(int(k) + 1 for k in np.flatnonzero(which))
