"""Whether motion swells and fades as one smooth wave: then nothing set it free, and its fall is no free decay."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from suspid.identification import Identification
from suspid.levels import SURE
from suspid.model import ModalSet
from suspid.samples import held
from suspid.signals import Signal, as_signal, block_means
from suspid.units import Ratio, RealArray
from suspid.words import ModeCheck

if TYPE_CHECKING:
    import control

# Periods of the strongest mode that are looked at before and after a time. In fewer, one blow looks like a wave; in
# more, the envelope of a swept sine needs more than two orders of time.
LOOKED_AT = 1.5
# The rise is at this share of the power of the top. Where no motion before has less, none rises in the record: the slow
# fall of a light decay is as smooth as a wave.
RISEN = 0.5
# Samples of a period that tell its course; means are taken over more.
A_PERIOD = 24
# One wave leaves at most this share of the energy of the motion. One half sine of force of up to half a period leaves
# more, for damping ratios up to 0.35.
LEFT_BY_WAVE = 0.01
# Samples of all channels for each unknown of the wave, at least. With fewer it follows anything.
WAVE_SAMPLES_EACH = 4
# A wave fades about as fast as it swells. What stays above that share for this many times as long as it took to
# rise from it to near its top, and for that many periods, is set free at the end of a push, however smooth.
FADES_SLOWLY, LASTING_PERIODS, NEAR_TOP = 20.0, 10.0, 0.9
# Share by which the power rises on the way to its top. A smaller one follows noise to the top of another motion.
RISES = 0.02
# A wave of a mode has its frequency where it is largest within this factor: what rises at another frequency is another
# motion, beside which the mode may have begun at once.
OF_ANOTHER = 2.0
# Evaluations in the descent to a wave: more only where there is none.
MOST_EVALUATIONS = 500


def beyond_wave(record: control.TimeResponseData, found: Identification) -> Ratio:
    """Return the share of the energy of a motion that one smooth wave through its rise and its top leaves of it.

    The wave is ``exp(a t + b t^2)`` with complex a and b, and a size and phase of its own in each channel: logarithmic
    amplitude and phase are of second order in time, as those of a swept sine under a Gaussian. Free motion begins with
    a release, a blow or the end of a force, each within a part of a period, and no such wave goes through that.

    Parameters
    ----------
    record : control.TimeResponseData
        The whole record.
    found : Identification
        What was identified in a part of it.

    Returns
    -------
    float
        Share beyond the noise of the fit [1]; 0 where the wave leaves that noise alone. Infinite where no motion rises
        in the record, where it fades far more slowly than it rose, or no wave goes through it.

    Examples
    --------
    >>> from suspid import identify
    >>> from suspid.records import as_response, cut
    >>> t = np.arange(1000) / 100
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> swept = np.exp(-((t - 5) ** 2)) * np.cos(20 * t + 0.3 * t**2)
    >>> free = np.where(t > 5, np.exp(-(t - 5)) * np.sin(20 * (t - 5)), 0.0)
    >>> records = [as_response(t, (motion + noise)[None], ["seat"]) for motion in (swept, free)]
    >>> [beyond_wave(record, identify(cut(record, start=5.2), modes=1)) for record in records]
    [0.0, inf]
    """
    scaled = _scaled(as_signal(record), found)
    if scaled is None:
        return np.inf
    values, start, pole = scaled
    period = max(2, round(2 * np.pi / abs(pole)))
    level = _level(values, period)
    top = _top(level, start, period)
    low = np.flatnonzero(level[:top] < RISEN * level[top])
    reach = max(round(LOOKED_AT * period), -(-_fewest(len(values)) // 2))
    # A period before the rise shows whether it begins at once.
    if not low.size or low[-1] < period:
        return np.inf
    if _lasts(level, int(low[-1]), top, period):
        return np.inf
    beyond = 0.0
    for place in (int(low[-1]), top):
        beyond = max(beyond, _beyond(values[:, max(0, place - reach) : place + reach], pole))
        if beyond > LEFT_BY_WAVE:
            return np.inf
    return beyond


def _lasts(level: RealArray, low: int, top: int, period: int) -> bool:
    """Return whether a motion that rises from a sample on fades far more slowly than it rose.

    The way up a slow fall, from period to period, is no rise: it has risen where it is near its top for the first time.
    """
    risen = low + int(np.argmax(level[low : top + 1] > NEAR_TOP * level[top]))
    fallen = np.flatnonzero(level[top:] < RISEN * level[top])
    last = top + int(fallen[0]) if fallen.size else len(level)
    return last - risen > max(FADES_SLOWLY * (risen - low), LASTING_PERIODS * period)


def beats(found: Identification) -> int:
    """Return how often a motion sinks to a share of its power and rises again, where two modes or more explain it.

    They leave no more than one wave may, which rises once. What a few modes explain again and again is of one phase,
    and no half of it has other modes. Fewer times than there are modes count as none: with many, modes follow any
    motion.

    Examples
    --------
    >>> from suspid import identify
    >>> from suspid.records import as_response
    >>> t = np.arange(4000) / 100
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> one, two = (np.exp(-0.01 * t) * np.cos(wn * t) for wn in (9.0, 9.5))
    >>> [beats(identify(as_response(t, (motion + noise)[None], ["left"]))) for motion in (one - two, one)]
    [3, 0]
    """
    from scipy.signal import find_peaks

    disagree = any(check.remark.code is ModeCheck.HALVES_DISAGREE for check in found.verdict.checks)
    if len(found.modes) < 2 or disagree:
        return 0
    signal = as_signal(held(found, "response"))
    left = left_by_modes(signal, found.modes)
    clearest = int(np.argmin(left))
    period = max(2, round(2 * np.pi / (abs(_strongest(found)) * signal.step)))
    level = _level(as_signal(held(found, "fitted")).values[[clearest]], period)
    sunk, _ = find_peaks(-np.log(np.maximum(level, 1e-300)), prominence=-np.log(RISEN))
    return len(sunk) if left[clearest] <= LEFT_BY_WAVE and len(sunk) > len(found.modes) - 2 else 0


def left_by_modes(signal: Signal, modes: ModalSet, *, beside: Iterable[RealArray] = ()) -> RealArray:
    """Return the share of the energy of each channel that modes with a constant level leave, (channel,).

    Further motions ``beside`` them, each (sample,), may be followed too.
    """
    about = signal.values - signal.values.mean(axis=1, keepdims=True)
    time = signal.step * np.arange(about.shape[1])
    courses = np.exp(modes.poles[:, None] * time)
    basis, _ = np.linalg.qr(np.stack([*courses.real, *courses.imag, *beside, np.ones(len(time))], axis=1))
    return np.asarray(1 - np.sum((about @ basis) ** 2, axis=1) / np.sum(about**2, axis=1).clip(1e-300))


def _scaled(signal: Signal, found: Identification) -> tuple[RealArray, int, complex] | None:
    """Return a record over the noise of a fit to a part, (channel, sample), where the part starts, and its pole."""
    part = as_signal(held(found, "response"))
    if not len(found.modes) or not np.all(found.noise_std > 0) or not set(part.channels) <= set(signal.channels):
        return None
    pole, size = _strongest(found), max(1, round(part.step / signal.step))
    more = max(1, int(2 * np.pi / (abs(pole) * part.step * A_PERIOD)))
    scaled = signal.values[[signal.channels.index(name) for name in part.channels]] / found.noise_std[:, None]
    start = round((part.start - signal.start) / (signal.step * size * more))
    return block_means(scaled, size * more) * np.sqrt(more), start, pole * part.step * more


def _strongest(found: Identification) -> complex:
    """Return the pole of the mode that explains most of the fitted motion by itself [1/s]."""
    fitted = as_signal(held(found, "fitted"))
    scaled = (fitted.values - fitted.values.mean(axis=1, keepdims=True)) / found.noise_std[:, None]
    time = fitted.step * np.arange(fitted.values.shape[1])
    energies = []
    for pole in found.modes.poles:
        course = np.exp(pole * time)
        basis, _ = np.linalg.qr(np.stack([course.real, course.imag], axis=1))
        energies.append(float(np.sum((scaled @ basis) ** 2)))
    return complex(found.modes.poles[int(np.argmax(energies))])


def _level(values: RealArray, period: int) -> RealArray:
    """Return the power of a motion (channel, sample) over a period, all channels together, (sample,)."""
    from scipy.ndimage import uniform_filter1d

    # A mass that is held away from its rest does not move.
    about = values - uniform_filter1d(values, period, axis=1, mode="nearest")
    # Running sums may round below zero.
    return np.maximum(uniform_filter1d(np.sum(about**2, axis=0), period, mode="nearest"), 0.0)


def _top(level: RealArray, start: int, period: int) -> int:
    """Return the sample of the largest power, of the motion that is there in the first period from a sample on."""
    start = min(start, len(level) - 1)
    top = start + int(np.argmax(level[start : start + period]))
    while True:
        first = max(0, top - period)
        higher = first + int(np.argmax(level[first : top + period + 1]))
        if level[higher] <= (1 + RISES) * level[top]:
            return top
        top = higher


def _fewest(channels: int) -> int:
    """Return the samples without which a wave, with four unknowns and three for each channel, follows any motion."""
    return -(-WAVE_SAMPLES_EACH * (4 + 3 * channels) // channels)


def _beyond(values: RealArray, pole: complex) -> Ratio:
    """Return the share of the energy of a motion (channel, sample) that one wave leaves beyond noise of one."""
    if values.shape[1] < _fewest(len(values)):
        return np.inf
    about = values - values.mean(axis=1, keepdims=True)
    noise = values.size - SURE * np.sqrt(2.0 * values.size)
    more = _left_by_wave(values, pole * values.shape[1]) - float(noise)
    return max(0.0, more) / max(float(np.sum(about**2)), 1e-300)


def _left_by_wave(values: RealArray, turn: complex) -> float:
    """Return the energy that the best wave leaves of a motion (channel, sample), sought from the ``turn`` of a mode.

    It is infinite where all that are found have another frequency.
    """
    from scipy.optimize import least_squares

    time = np.linspace(-0.5, 0.5, values.shape[1])

    def left(wave: RealArray) -> RealArray:
        exponent = (wave[0] + 1j * wave[1]) * time + (wave[2] + 1j * wave[3]) * time**2
        course = np.exp(exponent - np.max(exponent.real))
        basis, _ = np.linalg.qr(np.stack([course.real, course.imag, np.ones(len(time))], axis=1))
        return np.asarray((values - (values @ basis) @ basis.T).ravel())

    # From the mode and from near it: a swept sine has another frequency at its top than later on.
    begun = [(turn.real, turn.imag), *((0.0, share * turn.imag) for share in (0.75, 1.0, 1.3))]
    descents = [
        least_squares(left, [fall, cycles, 0.0, 0.0], method="lm", max_nfev=MOST_EVALUATIONS) for fall, cycles in begun
    ]
    cycles = abs(turn.imag)
    alike = [one for one in descents if cycles / OF_ANOTHER < _cycles_at_top(one.x) < cycles * OF_ANOTHER]
    return 2 * min((float(one.cost) for one in alike), default=np.inf)


def _cycles_at_top(wave: RealArray) -> float:
    """Return how fast a wave turns where it is largest of what is looked at [rad over that]."""
    fall, turn, narrow, bend = wave.tolist()
    top = np.clip(-0.5 * fall / narrow, -0.5, 0.5) if narrow < 0 else np.copysign(0.5, fall)
    return float(abs(turn + 2 * bend * top))
