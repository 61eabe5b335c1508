"""The verdict on an identification, and on repeats: the checks, their levels and numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.identification.classification import LEAST_EXPLAINED
from suspid.identification.lines import clear_line
from suspid.identification.noise import ABOVE_RESOLUTION, most_shared, resolution, shared_noise
from suspid.identification.pulses import one_shape
from suspid.levels import LEVEL
from suspid.samples import held
from suspid.signals import Signal, as_signal, late_start
from suspid.units import Ratio
from suspid.words import Check, Headline, Level, ModeCheck, Number, Reason, Remark, Verdict, amount

if TYPE_CHECKING:
    from suspid.identification.identification import Identification
    from suspid.identification.identify_repeats import Repeats

# Disagreement of the halves [sd] beyond which it is no chance: 0.3 % for a Gaussian.
HALVES_APART = 3.0
# Half widths of the interval, as shares of the value, from which on zeta is unknown, zeta is rough, wn is rough.
UNKNOWN_ZETA, ROUGH_ZETA, ROUGH_WN = 1.0, 0.25, 0.05
# Fewer samples per unknown of a channel than this: the fit follows any motion.
SAMPLES_EACH = 8
# Phase collinearity below which the channels of a mode are out of phase.
OUT_OF_PHASE = 0.5
# A mode with fewer cycles in the record than this, that has not decayed by as many nepers, is known from few cycles.
CYCLES_SEEN = 3.0


def verdict_of(found: Identification, level: Ratio = LEVEL) -> Verdict:
    """Return the verdict on an identification; ``level`` is that of the intervals whose width is checked.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> found = identify(free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0}))
    >>> verdict_of(found).level.label, str(verdict_of(found).headline)
    ('sound', '2 modes found')
    """
    if not len(found.modes):
        checks = (*_why_none(found), *_late_motion(found), *_steady_tones(found))
        return Verdict(Remark(Headline.NO_MODE), checks)
    return Verdict(Remark(Headline.MODES, {"modes": len(found.modes)}), tuple(_checks(found, level)))


def _checks(found: Identification, level: Ratio) -> Iterator[Check]:
    yield from _explained(found)
    yield from _dropped(found)
    growing = _numbers(found.modes.poles.real > 0)
    if growing:
        yield _of(ModeCheck.GROWING, Level.DOUBTFUL, {"modes": growing})
    yield from _amplitudes(found)
    if any(c.removed and c.remark.code is Reason.HARMONIC for c in found.considered):
        yield _of(ModeCheck.HARMONICS, Level.CARE)
    yield from _halves(found)
    if found.method != "ridge":
        yield from _residual(found)
    rough = list(_precision(found, level))
    yield from rough
    yield from _few_cycles(found)
    yield from _unresolved(found)
    few = list(_few_samples(found))
    yield from few
    blind = () if found.forces else _numbers(~np.isfinite(found.halves) & (np.array(found.modes.kinds) == "pair"))
    if blind:
        # Where nothing but the fit itself supports the modes, a loose fit is not enough.
        alone = not np.any(np.isfinite(found.halves))
        loose = few or any(check.level < Level.NOTE for check in rough)
        pulse = alone and _one_shape(found)
        weight = Level.NOTE if not alone else Level.DOUBTFUL if loose or pulse else Level.CARE
        yield _of(ModeCheck.NOT_CROSS_CHECKED, weight, {"modes": blind})
        if pulse:
            yield _of(ModeCheck.ONE_SHAPE, Level.DOUBTFUL)
    if np.max(found.explained) >= LEAST_EXPLAINED:
        yield from _unexplained(found)
    yield from _out_of_phase(found)
    yield from _steady_tones(found)
    if np.any(found.loudness > 1):
        yield from _late_motion(found)


def _of(code: ModeCheck, level: Level, numbers: Mapping[str, Number] | None = None) -> Check:
    return Check(Remark(code, numbers or {}), level)


def _why_none(found: Identification) -> Iterator[Check]:
    considered = found.considered
    away = [c for c in considered if c.remark.code in (Reason.OUTSIDE_THE_BAND, Reason.BEYOND)]
    best = float(np.max(found.explained))
    if away:
        yield _of(ModeCheck.NOT_IN_BAND, Level.NONE, {"poles": len(away)})
    elif best > LEAST_EXPLAINED or any(c.removed for c in considered):
        yield _of(ModeCheck.NO_FREE_DECAY, Level.NONE, {"explained": best})
    else:
        yield _of(ModeCheck.NOTHING_DECAYS, Level.NONE)
        strongest = considered[0].pole if considered else 0j
        signal = as_signal(held(found, "response"))
        line = clear_line(signal.values, signal.step)
        near = line is not None and abs(2 * np.pi * line - strongest.imag) < 4 * np.pi / signal.duration
        # A pole that decays by less than e^-1 in more than 10 cycles is a steady line.
        steady = abs(strongest.real) * signal.duration < 1.0
        if steady and near and strongest.imag * signal.duration > 20 * np.pi:
            yield _of(ModeCheck.STEADY_LINE, Level.NONE, {"hertz": strongest.imag / (2 * np.pi)})


def _late_motion(found: Identification) -> Iterator[Check]:
    signal = as_signal(held(found, "response"))
    late = late_start(signal)
    if late is not None:
        yield _of(ModeCheck.LATE_MOTION, Level.CARE, {"delay": late - signal.start, "time": late})


def _explained(found: Identification) -> Iterator[Check]:
    share = found.explained
    least, most = float(np.min(share)), float(np.max(share))
    if most < LEAST_EXPLAINED:
        yield _of(ModeCheck.HARDLY_EXPLAINED, Level.DOUBTFUL, {"most": most})
    elif least < LEAST_EXPLAINED:
        yield _of(ModeCheck.BEST_EXPLAINED, Level.SOUND, {"most": most})
    else:
        yield _of(ModeCheck.EXPLAINED, Level.SOUND, {"least": least, "most": most, "channels": len(share)})
    # A fit that leaves 7 dB of noise or other motion in the best channel is never called sound.
    if LEAST_EXPLAINED <= most < 0.8:
        yield _of(ModeCheck.LITTLE_EXPLAINED, Level.CARE, {"most": most})


def _unexplained(found: Identification) -> Iterator[Check]:
    names = as_signal(held(found, "response")).channels
    weak = [
        f"{printable(name)} ({100 * float(share):.4g} %)"
        for name, share in zip(names, found.explained, strict=True)
        if share < LEAST_EXPLAINED
    ]
    if weak:
        yield _of(ModeCheck.CHANNELS_UNEXPLAINED, Level.CARE, {"channels": ", ".join(weak)})


def _halves(found: Identification) -> Iterator[Check]:
    apart = found.halves
    known = np.isfinite(apart)
    for mode, value in enumerate(apart.tolist(), 1):
        if value > HALVES_APART:
            yield _of(ModeCheck.HALVES_DISAGREE, Level.CARE, {"mode": mode, "apart": value})
    if np.any(known) and np.nanmax(apart) <= HALVES_APART:
        which = "every mode" if np.all(known) else f"mode {', '.join(map(str, _numbers(known)))}"
        yield _of(ModeCheck.HALVES_AGREE, Level.SOUND, {"which": which, "most": float(np.nanmax(apart))})


def _amplitudes(found: Identification) -> Iterator[Check]:
    """Check whether the decay is linear; if not, how each mode depends on its amplitude."""
    if not found.forces:
        return
    kinds = tuple(dict.fromkeys(force.kind.value for force in found.forces))
    # Where all modes of a nonlinear fit fall by half in a cycle, a pulse of force without ringing looks the same.
    swings = bool(np.min(found.modes.zeta) < np.log(2) / (2 * np.pi))
    yield _of(ModeCheck.NONLINEAR, Level.CARE if swings else Level.DOUBTFUL, {"forces": kinds})
    for mode, each in enumerate(found.amplitude_dependence, 1):
        (high_wn, high_zeta), (low_wn, low_zeta) = each.ends
        numbers: dict[str, Number] = {
            "mode": mode,
            "high": float(np.max(each.amplitude)),
            "high_hz": high_wn / (2 * np.pi),
            "high_zeta": high_zeta,
            "low": float(np.min(each.amplitude)),
            "low_hz": low_wn / (2 * np.pi),
            "low_zeta": low_zeta,
            "channel": printable(each.channel),
            "holds": each.holds_at,
        }
        yield _of(ModeCheck.AMPLITUDE, Level.NOTE, numbers)


def _unresolved(found: Identification) -> Iterator[Check]:
    """Check that no mode may as well be two."""
    partners = [c.pole for c in found.considered if c.remark.code is Reason.UNRESOLVED]
    modes = sorted({int(np.argmin(np.abs(found.modes.poles - pole))) + 1 for pole in partners})
    if modes:
        yield _of(ModeCheck.UNRESOLVED, Level.CARE, {"modes": tuple(modes)})


def _one_shape(found: Identification) -> bool:
    """Return whether all channels move alike: the fitted motion beside its principal direction is noise."""
    unknowns = 2 * (len(found.modes) + sum(c.removed for c in found.considered))
    return one_shape(as_signal(held(found, "fitted")).values, found.noise_std, unknowns)


def _few_samples(found: Identification) -> Iterator[Check]:
    samples = as_signal(held(found, "response")).values.shape[1]
    poles = [*found.modes.poles, *(c.pole for c in found.considered if c.removed)]
    unknowns = 1 + sum(2 if pole.imag else 1 for pole in poles)
    if samples < SAMPLES_EACH * unknowns:
        yield _of(ModeCheck.FEW_SAMPLES, Level.CARE, {"samples": samples, "unknowns": unknowns})


def _out_of_phase(found: Identification) -> Iterator[Check]:
    modes = _numbers((np.array(found.modes.kinds) == "pair") & (found.collinearity < OUT_OF_PHASE))
    if len(found.modes.channels) > 1 and modes:
        yield _of(ModeCheck.OUT_OF_PHASE, Level.NOTE, {"modes": modes})


def _residual(found: Identification) -> Iterator[Check]:
    loud = [f"{k} ({amount(value)} times)" for k, value in enumerate(found.loudness, 1) if value > 1]
    if loud:
        yield _of(ModeCheck.RESIDUAL_LOUD, Level.CARE, {"modes": tuple(loud)})
    else:
        yield _of(ModeCheck.RESIDUAL_WHITE, Level.SOUND)
    residual = as_signal(held(found, "residual"))
    yield from _structure(found, residual)
    if shared_noise(residual.values) > 1:
        one, other, correlation = most_shared(residual.values)
        pair = {"one": residual.channels[one], "other": residual.channels[other]}
        yield _of(ModeCheck.SHARED_NOISE, Level.NOTE, {**pair, "correlation": correlation})


def _structure(found: Identification, residual: Signal) -> Iterator[Check]:
    """Check that nothing but noise is left: no colour and no line, where the residual exceeds rounding."""
    size = np.sqrt(np.mean(residual.values**2, axis=1))
    rough = size > ABOVE_RESOLUTION * resolution(as_signal(held(found, "response")).values)
    lag = np.where(rough, found.whiteness, 0.0)
    worst = int(np.argmax(np.abs(lag)))
    # A larger correlation over one sample is not that of white noise; a sensor's filter leaves less.
    if abs(lag[worst]) > 0.5:
        where: dict[str, Number] = {"correlation": float(lag[worst]), "channel": residual.channels[worst]}
        yield _of(ModeCheck.RESIDUAL_COLOURED, Level.CARE, where)
    line = clear_line(residual.values[rough], residual.step) if np.any(rough) else None
    if line is not None:
        yield _of(ModeCheck.RESIDUAL_LINE, Level.CARE, {"hertz": line})


def _few_cycles(found: Identification) -> Iterator[Check]:
    """Check that each oscillation is seen over several cycles or until it has decayed, and that there is one."""
    poles, duration = found.modes.poles, as_signal(held(found, "response")).duration
    cycles = np.abs(poles.imag) * duration / (2 * np.pi)
    few = (poles.imag != 0) & (cycles < CYCLES_SEEN) & (-poles.real * duration < CYCLES_SEEN)
    for k in np.flatnonzero(few).tolist():
        yield _of(ModeCheck.FEW_CYCLES, Level.CARE, {"mode": k + 1, "cycles": float(cycles[k])})
    if not np.any(poles.imag != 0):
        # What the residual contradicts is a drift.
        yield _of(ModeCheck.REAL_ONLY, Level.DOUBTFUL if np.any(found.loudness > 1) else Level.CARE)


def _precision(found: Identification, level: Ratio) -> Iterator[Check]:
    modes = found.modes
    if modes.covariance is None:
        return
    ends = modes.interval(level)
    pairs = np.array(modes.kinds) == "pair"
    wn = (ends.wn[:, 1] - modes.wn) / np.where(modes.wn > 0, modes.wn, 1.0)
    zeta = (ends.zeta[:, 1] - modes.zeta) / np.where(modes.zeta != 0, np.abs(modes.zeta), 1.0)
    vague = pairs & (zeta > UNKNOWN_ZETA)
    rough = pairs & ~vague & (zeta > ROUGH_ZETA) | pairs & (wn > ROUGH_WN)
    if np.any(vague):
        yield _of(ModeCheck.DAMPING_UNKNOWN, Level.CARE, {"modes": _numbers(vague)})
    for k in np.flatnonzero(rough).tolist():
        numbers: dict[str, Number] = {"mode": k + 1}
        numbers |= {"wn": float(wn[k])} if wn[k] > ROUGH_WN else {}
        numbers |= {"zeta": float(zeta[k])} if ROUGH_ZETA < zeta[k] <= UNKNOWN_ZETA else {}
        yield _of(ModeCheck.KNOWN_ROUGHLY, Level.CARE, numbers)
    if np.any(pairs) and not np.any(vague | rough):
        most = {"wn": float(np.max(wn[pairs])), "zeta": float(np.max(zeta[pairs])), "level": float(level)}
        yield _of(ModeCheck.KNOWN, Level.SOUND, most)


def _steady_tones(found: Identification) -> Iterator[Check]:
    tones = [c for c in found.considered if c.removed and c.remark.code is Reason.TONE]
    if tones:
        hertz = ", ".join([f"{abs(c.pole) / (2 * np.pi):.4g}" for c in tones[:4]] + ["…"] * (len(tones) > 4))
        yield _of(ModeCheck.STEADY_TONES, Level.NOTE, {"number": len(tones), "hertz": hertz})


def _dropped(found: Identification) -> Iterator[Check]:
    """Check that no significant pole was left out because fewer modes were asked for."""
    beyond = [abs(c.pole) / (2 * np.pi) for c in found.considered if c.remark.code is Reason.BEYOND]
    if beyond:
        hertz = ", ".join(f"{value:.4g}" for value in beyond)
        yield _of(ModeCheck.DROPPED, Level.CARE, {"number": len(beyond), "hertz": hertz})


def verdict_of_repeats(repeats: Repeats, level: Ratio = LEVEL) -> Verdict:
    """Return the verdict on several decays jointly: their agreement beside the checks of the first decay."""
    decays = len(repeats.spans)
    first = verdict_of(repeats.each[0], level)
    if not len(repeats.modes):
        none = _of(ModeCheck.NO_COMMON_MODE, Level.NONE, {"decays": decays})
        return Verdict(Remark(Headline.NO_MODE), (none, *first.checks))
    apart = _numbers(np.array([agreement.widening > 1 for agreement in repeats.consistency]))
    check = _of(ModeCheck.REPEATS_AGREE, Level.SOUND, {"decays": decays})
    if apart:
        check = _of(ModeCheck.REPEATS_DISAGREE, Level.CARE, {"decays": decays, "modes": apart})
    return Verdict(Remark(Headline.MODES, {"modes": len(repeats.modes)}), (check, *first.checks))


def _numbers(which: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> tuple[int, ...]:
    """Return the numbers of modes, from 1 on."""
    return tuple(int(k) + 1 for k in np.flatnonzero(which))
