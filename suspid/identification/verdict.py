"""The verdict on an identification: the checks, their levels and numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.identification.classification import LEAST_EXPLAINED, SAMPLES_EACH
from suspid.identification.considered import removed_as
from suspid.identification.harmonics import LOW_ORDER
from suspid.identification.lines import clear_line, dies_away, is_even
from suspid.identification.mode_checks import (
    NEARLY_EACH,
    check_amplitudes,
    check_cycles,
    check_flashes,
    check_followed,
    check_halves,
    check_multiples,
    check_of,
    check_parts,
    check_phases,
    check_precision,
    check_pulses,
    check_resolution,
    check_rows,
    cycles_seen,
    numbers_of,
    swings_many_times,
)
from suspid.identification.noise import ABOVE_RESOLUTION, most_shared, resolution, shared_noise
from suspid.identification.pulses import one_shape
from suspid.identification.removed_checks import (
    check_dropped,
    check_growing,
    check_removed,
    check_tones,
    check_too_many,
    in_hertz,
)
from suspid.levels import LEVEL
from suspid.records import late_start
from suspid.samples import held
from suspid.signals import Signal, as_signal
from suspid.units import Hertz, Ratio, RealArray
from suspid.words import (
    MOST_LISTED,
    Check,
    Headline,
    Level,
    ModeCheck,
    Number,
    Reason,
    Remark,
    Verdict,
    amount,
)

if TYPE_CHECKING:
    from suspid.identification.identification import Identification

# Power near a mode over white noise: what is below widens an interval by less than 3 %.
NOTICEABLE = 1.05
# Correlations of the residual over one sample that are not those of white noise: a sensor's filter leaves less than the
# first number. The second holds in channels of which less than the third share is explained.
FILTERED, OTHER_MOTION, WELL_EXPLAINED = 0.5, 0.3, 0.9
# Power near a mode over white noise above which what is left there is not noise.
OTHER_THAN_NOISE = 10.0
# A free decay of one mode has its largest motion before that has fallen to this: 1/e. Where n masses pass a motion on,
# the last has it when they have fallen to this to the power of n - 1; one power is left for noise.
STILL_THERE = 0.37
# Cycles of a single mode, and the share of the energy of a channel that it explains, with which it is plainly seen. A
# voice has fewer cycles in a burst, or other tones beside.
PLAINLY_SEEN = ((5.0, 0.95), (3.0, 0.999))
# Nepers by which such a mode falls at least: of one that hardly does, a longer part tells more.
LEAST_SEEN_DECAY = 0.25
# What is damped by more beside a motion that is not linear is a part of it as likely as a mode.
MOST_DAMPED = 0.3
# A line within this share of a mode or of one of these multiples is what the fit to it leaves, not another motion.
NEAR_A_MODE, HARMONICS_LEFT = 0.03, 7


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
        tones = check_tones(found)
        checks = (*_why_none(found), *_late_motion(found), *tones)
        return Verdict(Remark(Headline.NO_MODE), checks)
    return Verdict(Remark(Headline.MODES, {"modes": len(found.modes)}), tuple(_checks(found, level)))


def _checks(found: Identification, level: Ratio) -> Iterator[Check]:
    yield from _explained(found)
    yield from check_dropped(found)
    growing = numbers_of(found.modes.poles.real > 0)
    if growing:
        yield check_of(ModeCheck.GROWING, Level.DOUBTFUL, {"modes": growing})
    yield from check_growing(found)
    yield from check_amplitudes(found)
    harmonics = removed_as(found.considered, Reason.HARMONIC)
    if harmonics:
        swings = any(one.pole.imag for one in harmonics)
        yield check_of(ModeCheck.HARMONICS if swings else ModeCheck.MIDDLE, Level.CARE)
    if any(c.remark.code is Reason.STANDS_STILL for c in found.considered):
        yield check_of(ModeCheck.STANDS_STILL, Level.DOUBTFUL)
    yield from _outside(found)
    yield from check_halves(found)
    if found.method != "ridge":
        yield from _residual(found)
    rough = list(check_precision(found.modes, found.loudness, found.halves, level))
    yield from rough
    yield from check_cycles(found)
    yield from check_multiples(found)
    yield from check_resolution(found)
    yield from check_too_many(found)
    yield from check_removed(found, Reason.TRACE, ModeCheck.TRACES, Level.CARE)
    yield from check_parts(found)
    yield from check_rows(found)
    yield from check_pulses(found)
    yield from check_followed(found)
    yield from check_flashes(found)
    few = list(_few_samples(found))
    yield from few
    pairs = np.array(found.modes.kinds) == "pair"
    blind = () if found.forces else numbers_of(~np.isfinite(found.halves) & pairs)
    if blind:
        # Where nothing but the fit itself supports the modes, a loose fit is not enough; nor is one of few samples
        # where that is so of nearly each mode.
        alone = not np.any(np.isfinite(found.halves))
        nearly = bool(few) and len(blind) > NEARLY_EACH * np.sum(pairs)
        loose = few or any(check.level < Level.NOTE for check in rough)
        pulse = alone and _one_shape(found)
        weight = Level.CARE if alone else Level.NOTE
        weight = Level.DOUBTFUL if nearly or (alone and (loose or pulse)) else weight
        yield check_of(ModeCheck.NOT_CROSS_CHECKED, weight, {"modes": blind})
        if pulse:
            yield check_of(ModeCheck.ONE_SHAPE, Level.DOUBTFUL, {"channels": len(found.noise_std)})
    if np.max(found.explained) >= LEAST_EXPLAINED:
        yield from _unexplained(found)
    yield from check_phases(found)
    yield from check_tones(found)
    if found.method != "ridge":
        yield from _idle_bandwidths(found)
    if np.any(found.loudness > 1):
        yield from _late_motion(found)


def _idle_bandwidths(found: Identification) -> Iterator[Check]:
    """Say that a bandwidth, or bandwidths to choose among, did not make these modes."""
    steps = found.steps
    if steps.bandwidth is not None:
        yield check_of(ModeCheck.BANDWIDTH, Level.NOTE, {"bandwidth": steps.bandwidth})
    elif steps.chosen:
        yield check_of(ModeCheck.CANDIDATES, Level.NOTE)


def _why_none(found: Identification) -> Iterator[Check]:
    considered = found.considered
    away = [c for c in considered if c.remark.code in (Reason.OUTSIDE_THE_BAND, Reason.BEYOND)]
    best = float(np.max(found.explained))
    if away:
        yield check_of(ModeCheck.NOT_IN_BAND, Level.NONE, {"poles": len(away)})
    elif best > LEAST_EXPLAINED or any(c.removed for c in considered):
        yield check_of(ModeCheck.NO_FREE_DECAY, Level.NONE, {"explained": best})
    else:
        yield check_of(ModeCheck.NOTHING_DECAYS, Level.NONE)
        strongest = considered[0].pole if considered else 0j
        signal = as_signal(held(found, "response"))
        line = clear_line(signal.values, signal.step)
        near = line is not None and abs(2 * np.pi * line - strongest.imag) < 4 * np.pi / signal.duration
        # A pole that decays by less than e^-1 in more than 10 cycles is a steady line.
        steady = abs(strongest.real) * signal.duration < 1.0
        lasts = steady and near and strongest.imag * signal.duration > 20 * np.pi
        if lasts and is_even(signal.values, strongest.imag * signal.step):
            yield check_of(ModeCheck.STEADY_LINE, Level.NONE, {"hertz": strongest.imag / (2 * np.pi)})


def _late_motion(found: Identification) -> Iterator[Check]:
    signal = as_signal(held(found, "response"))
    late = late_start(signal)
    if late is None:
        return
    rates = -found.modes.poles.real
    fallen = float(np.exp(-np.min(rates, initial=np.inf) * (late - signal.start))) if rates.size else 1.0
    if fallen < STILL_THERE ** max(1, int(np.sum(found.modes.poles.imag > 0))):
        numbers: dict[str, Number] = {"delay": late - signal.start, "time": late, "fallen": fallen}
        yield check_of(ModeCheck.HELD_UP, Level.DOUBTFUL, numbers)
    else:
        yield check_of(ModeCheck.LATE_MOTION, Level.CARE, {"delay": late - signal.start, "time": late})


def _explained(found: Identification) -> Iterator[Check]:
    share = found.explained
    least, most = float(np.min(share)), float(np.max(share))
    if most < LEAST_EXPLAINED:
        yield check_of(ModeCheck.HARDLY_EXPLAINED, Level.DOUBTFUL, {"most": most})
    elif least < LEAST_EXPLAINED:
        yield check_of(ModeCheck.BEST_EXPLAINED, Level.SOUND, {"most": most})
    else:
        yield check_of(ModeCheck.EXPLAINED, Level.SOUND, {"least": least, "most": most, "channels": len(share)})
    # A fit that leaves 7 dB of noise or other motion in the best channel is never called sound.
    if LEAST_EXPLAINED <= most < 0.8:
        # What is left is other motion at the frequency of a mode.
        other = np.max(found.loudness, initial=0.0) > OTHER_THAN_NOISE
        yield check_of(ModeCheck.LITTLE_EXPLAINED, Level.DOUBTFUL if other else Level.CARE, {"most": most})


def _unexplained(found: Identification) -> Iterator[Check]:
    names = as_signal(held(found, "response")).channels
    weak = [
        f"{printable(name)} ({100 * float(share):.4g} %)"
        for name, share in zip(names, found.explained, strict=True)
        if share < LEAST_EXPLAINED
    ]
    if weak:
        more = len(weak) - MOST_LISTED
        others = f" and {more} other{'s' * (more > 1)}" if more > 0 else ""
        yield check_of(ModeCheck.CHANNELS_UNEXPLAINED, Level.CARE, {"channels": ", ".join(weak[:MOST_LISTED]) + others})


def _one_shape(found: Identification) -> bool:
    """Return whether all channels move alike: the fitted motion beside its principal direction is noise.

    A single mode that swings many times before it has fallen to 1/e is no pulse. Nor is one that is seen to decay, of
    which there are fewer cycles before it has fallen to a tenth, and hardly anything else.
    """
    duration = as_signal(held(found, "response")).duration
    if len(found.modes) == 1:
        cycles, most = cycles_seen(found.modes, duration, nepers=np.log(10))[0], np.max(found.explained)
        decays = -found.modes.poles[0].real * duration > LEAST_SEEN_DECAY
        plain = decays and any(cycles > few and most > share for few, share in PLAINLY_SEEN)
        if plain or swings_many_times(found.modes, duration).all():
            return False
    unknowns = 2 * (len(found.modes) + sum(c.removed for c in found.considered))
    return one_shape(as_signal(held(found, "fitted")).values, found.noise_std, unknowns)


def _few_samples(found: Identification) -> Iterator[Check]:
    samples = as_signal(held(found, "response")).values.shape[1]
    poles = [*found.modes.poles, *(c.pole for c in found.considered if c.removed)]
    unknowns = 1 + sum(2 if pole.imag else 1 for pole in poles)
    if samples < SAMPLES_EACH * unknowns:
        yield check_of(ModeCheck.FEW_SAMPLES, Level.CARE, {"samples": samples, "unknowns": unknowns})


def _residual(found: Identification) -> Iterator[Check]:
    loud = [f"{k} ({amount(value)} times)" for k, value in enumerate(found.loudness, 1) if value > NOTICEABLE]
    if loud:
        yield check_of(ModeCheck.RESIDUAL_LOUD, Level.CARE, {"modes": tuple(loud)})
    else:
        yield check_of(ModeCheck.RESIDUAL_WHITE, Level.SOUND)
    residual, finest = as_signal(held(found, "residual")), resolution(as_signal(held(found, "response")).values)
    yield from _structure(found, residual, finest)
    if shared_noise(residual.values, finest) > 1:
        one, other, correlation = most_shared(residual.values)
        pair = {"one": residual.channels[one], "other": residual.channels[other]}
        yield check_of(ModeCheck.SHARED_NOISE, Level.NOTE, {**pair, "correlation": correlation})


def _structure(found: Identification, residual: Signal, finest: RealArray) -> Iterator[Check]:
    """Check that nothing but noise is left: no colour and no line, where the residual exceeds rounding."""
    size = np.sqrt(np.mean(residual.values**2, axis=1))
    rough = size > ABOVE_RESOLUTION * finest
    lag = np.where(rough, found.whiteness, 0.0)
    # A sensor's filter correlates samples. Where it leaves much of a channel, other motion does.
    most = np.where(found.explained < WELL_EXPLAINED, OTHER_MOTION, FILTERED)
    worst = int(np.argmax(np.abs(lag) / most))
    if abs(lag[worst]) > most[worst]:
        where: dict[str, Number] = {"correlation": float(lag[worst]), "channel": residual.channels[worst]}
        yield check_of(ModeCheck.RESIDUAL_COLOURED, Level.CARE, where)
    line = clear_line(residual.values[rough], residual.step) if np.any(rough) else None
    if line is not None and not _left_by_a_mode(found, line):
        dies = dies_away(residual.values[rough], 2 * np.pi * line * residual.step)
        yield check_of(ModeCheck.RESIDUAL_MODE if dies else ModeCheck.RESIDUAL_LINE, Level.CARE, {"hertz": line})


def _outside(found: Identification) -> Iterator[Check]:
    """Say what a linear fit has as further poles that decay as modes do, where a fit with forces has none there."""
    poles = [c.pole for c in found.considered if c.remark.code is Reason.DISTORTION and not c.removed]
    decaying = [pole for pole in poles if 0 < -pole.real < MOST_DAMPED * abs(pole)]
    if found.forces and decaying:
        yield check_of(ModeCheck.OUTSIDE, Level.CARE, {"hertz": in_hertz(decaying)})


def _left_by_a_mode(found: Identification, line: Hertz) -> bool:
    """Return whether a line is at a mode near which the residual is loud, or at a multiple: what its fit leaves."""
    loud = found.modes.poles[found.loudness > 1].imag / (2 * np.pi)
    orders = np.arange(1, HARMONICS_LEFT + 1)
    off = np.abs(np.outer(loud[loud > 0], orders) - line)
    resolution_hz = 1 / as_signal(held(found, "residual")).duration
    # High multiples are near every frequency.
    near = NEAR_A_MODE * np.outer(loud[loud > 0], np.minimum(orders, LOW_ORDER))
    return bool(np.any(off < np.maximum(near, 3 * resolution_hz)))
