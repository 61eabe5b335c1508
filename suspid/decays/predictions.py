"""Find the start of free motion by backward prediction from the decay.

A free motion of a few modes obeys a linear recurrence; a force on it is an error of the recurrence. Friction, gaps and
springs that harden are small errors everywhere in the decay, while a held, pulled or pushed mass is a large one. So the
start is found even where no sum of exponentials fits the decay to its noise.
"""

from __future__ import annotations

import numpy as np

from suspid.cleaning import runs
from suspid.decays.envelopes import finest as finest_of
from suspid.decays.envelopes import spectrum_and_noise
from suspid.decays.rests import rests_until
from suspid.decays.trials import BLOCKS_A_CYCLE, block_size
from suspid.signals import Signal
from suspid.units import Hertz, RealArray, Second

# Share of the power of the velocity below the highest frequency that counts; more of it follows noise.
POWER = 0.98
# Noise counts this many times its mean power, which its exponential distribution exceeds in 1 of 100 lines.
NOISE = 4.6
# The recurrence is fitted from the last time at which the kinetic energy, smoothed over half a period, is at least this
# share of its largest value, over this many periods of the strongest frequency and at least this many blocks.
STRONG_ENERGY, FITTED_PERIODS, FEWEST_FITTED = 0.7, 4.0, 24
# The recurrence has at most this many coefficients per channel, and one for each `BLOCKS_EACH` blocks.
MOST_COEFFICIENTS, BLOCKS_EACH = 16, 5
# An error this many times the largest one within the decay is a force. Less stops at the jumps of friction; more lets
# a weak force pass.
FORCED_ERROR = 3.0
# A recurrence that noise would predict as well by chance, this often, predicts nothing: all motion is an error of it.
CHANCE_OF_NOISE = 0.01
# Fewest samples of a rest.
FEWEST_RESTING = 8
# A force smaller than this share of the motion is left to the fit, which sees it better.
SMALL_FORCE = 0.003


def at_rest_from(values: RealArray, finest: RealArray) -> int:
    """Return the sample from which on every channel stays within its resolution, (channel, sample); one is kept.

    Parameters
    ----------
    values : ndarray (channel, sample)
        The samples.
    finest : ndarray (channel,)
        Standard deviation of the rounding and quantisation error of each channel.

    Examples
    --------
    >>> at_rest_from(np.array([[0.0, 2.0, 8.0, 5.0, 5.0, 5.0]]), np.array([0.29]))
    4
    """
    return int(values.shape[1]) - at_rest_until(values[:, ::-1], finest)


def at_rest_until(values: RealArray, finest: RealArray) -> int:
    """Return the last of the first samples in which every channel stays within its resolution, (channel, sample).

    Examples
    --------
    >>> at_rest_until(np.array([[5.0, 5.0, 5.0, 8.0, 2.0, 0.0]]), np.array([0.29]))
    2
    """
    # A value at the border of a step changes between two neighbours.
    within = 1.5 * np.sqrt(12.0) * finest
    moving = np.flatnonzero(np.any(_reaches(values) > within[:, None], axis=0))
    return int(moving[0]) - 1 if moving.size else values.shape[1] - 1


def released_at(values: RealArray, finest: RealArray) -> int:
    """Return the last sample of the last rest in a stretch after which it moves further than before; 0 without one.

    A decay does not grow: what rests for longer than it then takes to move half of its way has been held and let go.

    Examples
    --------
    A mass is pulled within 20 samples, held for 80 and let go:

    >>> time = np.arange(300.0)
    >>> free = np.exp(-0.01 * (time - 100)) * np.cos(0.1 * (time - 100))
    >>> released_at(np.where(time < 100, np.minimum(time / 20, 1.0), free)[None], np.array([1e-4]))
    100
    """
    within = 1.5 * np.sqrt(12.0) * finest
    still = np.all(np.abs(np.diff(values, axis=1)) <= within[:, None], axis=0)
    begins, ends = runs(still)
    inner = (ends - begins > FEWEST_RESTING) & (ends < still.size)
    ends = ends[inner] - 1
    # The motion before each end and after it.
    behind, ahead = _reaches(values)[:, ends + 1], _reaches(values[:, ::-1])[:, ::-1][:, ends + 1]
    grown = np.any(ahead > np.maximum(behind, within[:, None]), axis=0)
    for end in ends[grown][::-1].tolist():
        after, before = values[:, end + 1 :], values[:, : end + 2]
        rest = before.shape[1] - at_rest_from(before, finest)
        sizes = np.ptp(after, axis=1)
        moved = np.any(np.abs(after - after[:, :1]) > 0.5 * np.where(sizes > within, sizes, np.inf)[:, None], axis=0)
        if rest > max(FEWEST_RESTING, int(np.argmax(moved))):
            return int(end) + at_rest_until(after, finest) + 1
    return 0


def _reaches(values: RealArray) -> RealArray:
    """Return how far the samples up to each one reach, from the lowest to the highest, (channel, sample)."""
    return np.asarray(np.maximum.accumulate(values, axis=1) - np.minimum.accumulate(values, axis=1))


def releases_before(signal: Signal, time: Second) -> tuple[Second, ...]:
    """Return the times of the first samples of free motion before a time: after a mass is held, after a force.

    A mass that was held shows both; one that was struck or pushed only the second.

    Examples
    --------
    >>> time = np.arange(300.0)
    >>> free = np.exp(-0.01 * (time - 100)) * np.cos(0.1 * (time - 100))
    >>> values = np.where(time < 100, np.minimum(time / 20, 1.0), free)[None].round(4)
    >>> releases_before(Signal(start=0.0, step=0.01, values=values, channels=("mass",)), 2.0)
    (1.01, 1.05)
    """
    finest = finest_of(signal.values)
    held, (_, forced) = released_at(signal.values, finest), freed_at(signal.values, finest, step=signal.step)
    # It is let go between the last sample that is held and the next.
    left = 0 if held else rests_until(signal.values)
    firsts = [*([held + 1] if held else []), *([left] if left else []), *([forced] if forced else [])]
    times = dict.fromkeys(signal.start + signal.step * sample for sample in firsts)
    return tuple(each for each in times if each < time)


def rests_from(signal: Signal) -> Second:
    """Return the time from which on every channel rests within its resolution; the last time where one moves.

    Examples
    --------
    >>> time = np.arange(300.0)
    >>> stopped = np.where(time < 200, np.cos(0.1 * time), np.cos(20.0))[None].round(4)
    >>> rests_from(Signal(start=0.0, step=0.01, values=stopped, channels=("mass",)))
    2.0
    """
    first = at_rest_from(signal.values, finest_of(signal.values))
    return float(signal.timepts[min(first, signal.values.shape[1] - 1)])


def freed_at(values: RealArray, finest: RealArray, *, step: Second) -> tuple[int, int]:
    """Return between which samples the motion becomes free: the first that may be, and the first that is.

    They are the ends of two blocks, or both 0 where no force is seen.

    The recurrence is fitted after the largest kinetic energy, on means over blocks, by least squares; then the motion
    is followed back block by block until the error of the prediction exceeds `FORCED_ERROR` times those of the fit.

    Parameters
    ----------
    values : ndarray (channel, sample)
        An event up to the end of its decay.
    finest : ndarray (channel,)
        Standard deviation of the rounding and quantisation error of each channel.
    step : float
        Sampling step [s].

    Examples
    --------
    A mass is held for 2 s and let go:

    >>> time = np.arange(0, 8, 0.01)
    >>> motion = np.where(time < 2, 1.0, np.exp(-0.2 * (time - 2)) * np.cos(9 * (time - 2)))
    >>> first, sure = freed_at(motion[None], np.zeros(1), step=0.01)
    >>> first <= 200 <= sure, sure - first
    (True, 14)
    """
    top, strongest = frequencies(values, finest, step)
    size = block_size(step, top)
    count = values.shape[1] // size
    surplus = values.shape[1] - count * size
    means = values[:, surplus:].reshape(len(values), count, size).mean(axis=2)
    period = max(2, round(1 / (strongest * step * size)))
    anchor = max(0, min(_anchor(means), count - FEWEST_FITTED))
    length = min(max(FEWEST_FITTED, round(FITTED_PERIODS * period)), count - anchor)
    decay = means[:, anchor : anchor + length]
    spread = np.std(decay, axis=1, keepdims=True)
    # A channel that rests while the others decay says nothing.
    spread = np.where(spread > 1e-9 * np.max(np.abs(means), axis=1, keepdims=True), spread, np.inf)
    scaled = (means - np.mean(decay, axis=1, keepdims=True)) / spread
    lags = max(2, -(-min(MOST_COEFFICIENTS, length // BLOCKS_EACH) // len(values)))
    ahead = np.concatenate([scaled[:, lag : count - lags + lag] for lag in range(1, lags + 1)])
    known = np.vstack([ahead, np.ones(count - lags)])
    inside = slice(anchor, anchor + length - lags)
    normal = known[:, inside] @ known[:, inside].T
    # Share of the variance added to the normal equations against rounding.
    normal += 1e-6 * (length - lags) * np.eye(len(normal))
    weights = np.linalg.solve(normal, known[:, inside] @ scaled[:, inside].T)
    errors = scaled[:, : count - lags] - weights.T @ known
    usual = np.sqrt(np.mean(errors[:, inside] ** 2, axis=1, keepdims=True))
    if not _predicts(usual[:, 0], length - lags, len(known)):
        return 0, 0
    error = np.sqrt(np.mean((errors / np.maximum(usual, SMALL_FORCE / FORCED_ERROR)) ** 2, axis=0))
    forced = np.flatnonzero(error[:anchor] > FORCED_ERROR * max(1.0, float(np.max(error[inside]))))
    if not forced.size:
        return 0, 0
    # The release may lie in the last block that is forced, or in the one after it.
    last = surplus + int(forced[-1]) * size
    return last, last + 2 * size


def _predicts(usual: RealArray, count: int, unknowns: int) -> bool:
    """Return whether a recurrence predicts a channel better than chance, by the F test of each, (channel,).

    ``usual`` are the root mean squares of the errors over the standard deviations of the channels.
    """
    from scipy.special import fdtrc

    free = count - unknowns
    if free < 1:
        return True
    left = np.maximum(usual**2, 1e-30)
    ratio = np.maximum(1 - left, 0.0) / left * free / (unknowns - 1)
    return bool(np.min(fdtrc(unknowns - 1, free, ratio)) < CHANCE_OF_NOISE / len(usual))


def frequencies(values: RealArray, finest: RealArray, step: Second) -> tuple[Hertz, Hertz]:
    """Return the highest frequency that counts and the strongest one, of the velocity less white noise."""
    power, white = spectrum_and_noise(values - values.mean(axis=1, keepdims=True), finest)
    power = np.maximum(power - NOISE * white[:, None], 0.0)
    frequency = np.fft.rfftfreq(values.shape[1], step)
    power = power * np.sin(np.pi * frequency * step) ** 2
    total = np.maximum(np.sum(power, axis=1, keepdims=True), 1e-300)
    top = int(np.max(np.argmax(np.cumsum(power, axis=1) >= POWER * total, axis=1)))
    strongest = int(np.argmax(np.sum(power / total, axis=0)))
    return float(frequency[max(top, 1)]), float(frequency[max(strongest, 1)])


def _anchor(means: RealArray) -> int:
    """Return the last block at which the kinetic energy is near its largest value."""
    change = np.diff(means, axis=1)
    energy = np.sum(change**2 / np.maximum(np.mean(change**2, axis=1, keepdims=True), 1e-300), axis=0)
    width = max(1, round(BLOCKS_A_CYCLE / 2))
    smooth = np.convolve(energy, np.ones(width) / width, "same")
    return int(np.flatnonzero(smooth >= STRONG_ENERGY * np.max(smooth))[-1])
