"""Channels computed from another: its copy in another unit, its derivative or integral; programs often export both."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.levels import SEVEN_DIGITS
from suspid.records import of_channels
from suspid.signals import as_signal
from suspid.units import RealArray, Second
from suspid.words import Note, Remark

if TYPE_CHECKING:
    import control

# Channels of which each is compared with each, at most: of more, the comparisons would fill the memory.
MOST_RELATED = 1000
# Samples on either side from which a derivative is computed at most, and of its own past from which a motion is
# predicted. Programs use two or three on either side; a past of four modes is longer than most need.
SAMPLES_ABOUT, PAST_SAMPLES = 5, 8
# Samples for each of these weights: with fewer, any channel is a weighted sum of samples of another.
SAMPLES_EACH_WEIGHT = 4
# A derivative has this gain to within this share, but for a power of ten of the units: other points of a structure do
# not.
GAIN_ERROR = 0.01
# Share of the noise of a channel, at most, that another channel leaves of it: a sensor of its own leaves all, but noise
# that is not white is known by its past to less than it is.
OWN_SHARE = 0.5
# Least correlation with a central difference: a coarser screen only costs time.
ALIKE_CORRELATION = 0.5
# Correlation with a copy, less than 1 by this at most. Steps of the last digit in the range of a channel, or in its
# noise, from which on no other one agrees with it to that digit.
COPY_CORRELATION, FEWEST_STEPS, ROUGH = 1e-5, 1000, 2.0
# Samples from the beginning that tell; more only cost time.
SAMPLES_READ = 20_000


def without_derivatives(record: control.TimeResponseData) -> tuple[control.TimeResponseData, tuple[Remark, ...]]:
    """Return the record without channels that were computed from another, and what: copies, derivatives, integrals.

    Their noise is that of the motion once more: it is neither white nor independent of it, and they tell nothing else.
    A sensor of its own has noise that no other channel tells.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid.records import as_response
    >>> time, rng = np.arange(2000) / 100, np.random.default_rng(0)
    >>> motion = np.round(np.exp(-time / 8) * np.sin(5 * time) + 1e-3 * rng.standard_normal(2000), 4)
    >>> record = as_response(time, np.stack([motion, np.gradient(motion, 0.01)]), ["x", "v"])
    >>> left, notes = without_derivatives(record)
    >>> list(left.output_labels), len(notes)
    (['x'], 1)
    """
    signal = as_signal(record)
    if len(signal.channels) < 2 or signal.values.shape[1] < SAMPLES_EACH_WEIGHT * (SAMPLES_ABOUT + PAST_SAMPLES):
        return record, ()
    sources = _sources(signal.values[:, :SAMPLES_READ], signal.step)
    if not sources:
        return record, ()
    notes = tuple(
        Remark(code, {"channel": signal.channels[k], "source": signal.channels[source]})
        for k, (source, code) in sources.items()
    )
    kept = [name for k, name in enumerate(signal.channels) if k not in sources]
    return of_channels(record, kept), notes


def _sources(values: RealArray, step: Second) -> dict[int, tuple[int, Note]]:
    """Return from which channel each channel that was computed comes, by row, and how."""
    if len(values) > MOST_RELATED:
        return {}
    centred = values - values.mean(axis=1, keepdims=True)
    copies = _copies(centred)
    sources = dict(copies)
    slopes = [_correlated(np.gradient(centred, axis=1), centred), _correlated(np.diff(centred, 2, axis=1), centred)]
    alike = np.maximum(*slopes) > ALIKE_CORRELATION
    for k in (k for k in range(len(values)) if k not in copies):
        for source in (row for row in np.flatnonzero(alike[:, k]).tolist() if row not in copies):
            how = None if source == k else _computed(centred[source], centred[k], step)
            if how is Note.INTEGRATED_CHANNEL:
                sources.setdefault(source, (k, how))
            elif how is not None:
                sources[k] = source, how
                break
    return sources


def _copies(centred: RealArray) -> dict[int, tuple[int, Note]]:
    """Return which channels are another one before, but for a factor and an offset, to rounding, by row.

    Two sensors never agree so, unless there is no noise in a record.
    """
    found = dict[int, tuple[int, Note]]()
    size = np.linalg.norm(centred, axis=1)
    alike = np.abs(centred @ centred.T) > (1 - COPY_CORRELATION) * np.outer(size, size)
    for k, source in zip(*np.nonzero(np.tril(alike, -1)), strict=True):
        if k not in found and source not in found and size[k] > 0 and _is_copy(centred[source], centred[k]):
            found[int(k)] = int(source), Note.COPIED_CHANNEL
    return found


def _is_copy(source: RealArray, other: RealArray) -> bool:
    factor = float(source @ other / (source @ source))
    digits = (_last_digit(other), abs(factor) * _last_digit(source))
    if not np.max(np.abs(other - factor * source)) <= 0.51 * sum(digits) + SEVEN_DIGITS**2 * np.ptp(other):
        return False
    at = np.arange(PAST_SAMPLES, len(other))
    _, new = _regressed(other[at], other[at[:, None] - np.arange(1, PAST_SAMPLES + 1)])
    # Of few steps, two sensors without noise agree in each sample.
    told = FEWEST_STEPS * max(digits) <= np.ptp(other) or new >= ROUGH * max(digits)
    return told and new >= SEVEN_DIGITS * float(np.std(other))


def _last_digit(values: RealArray) -> float:
    """Return the smallest step between samples, which is the last digit of those that are rounded."""
    steps = np.abs(np.diff(values))
    return float(np.min(steps[steps > SEVEN_DIGITS**2 * np.ptp(values)], initial=np.inf))


def _correlated(slopes: RealArray, values: RealArray) -> RealArray:
    """Return the correlations of some derivatives with all channels, without sign, (derivative, channel)."""
    cut = (values.shape[1] - slopes.shape[1]) // 2
    inner = values[:, cut : values.shape[1] - cut]
    sizes = np.outer(np.linalg.norm(slopes, axis=1), np.linalg.norm(inner, axis=1))
    return np.asarray(np.abs(slopes @ inner.T) / np.maximum(sizes, 1e-300))


def _computed(source: RealArray, other: RealArray, step: Second) -> Note | None:
    """Return whether a channel is a weighted sum of a few samples of another that differentiates it once or twice.

    That tells most of its noise, which is what is new in it beside its own past. Where a few samples of the derivative
    tell the differences of the other better, it was integrated.
    """
    at = np.arange(max(SAMPLES_ABOUT, PAST_SAMPLES), len(other) - SAMPLES_ABOUT)
    shifts = np.arange(-SAMPLES_ABOUT, SAMPLES_ABOUT + 1)
    weights, left = _regressed(other[at], source[at[:, None] + shifts])
    order = _order_of(weights, np.asarray(shifts * step, float))
    if not order:
        return None
    past, new = _regressed(other[at], other[at[:, None] - np.arange(1, PAST_SAMPLES + 1)])
    # A record without noise is told to the last digit by whatever moves with it.
    if new < SEVEN_DIGITS * np.std(other) or left >= OWN_SHARE * new / float(np.sqrt(1 + past @ past)):
        return None
    changes = np.diff(source, order) / step**order
    inner = at[2 + order : -2]
    terms, lost = _regressed(changes[inner - order], other[inner[:, None] + np.arange(-2, 3)])
    # In the unit of the derivative, but for a power of ten. Exact differences are sums the other way round: what counts
    # in steps, as an encoder does, was measured.
    exact = left <= SEVEN_DIGITS * float(np.std(other))
    integrated = not exact and lost < left * abs(float(np.sum(terms)))
    return Note.INTEGRATED_CHANNEL if integrated else Note.DERIVED_CHANNEL


def _regressed(values: RealArray, columns: RealArray) -> tuple[RealArray, float]:
    """Return the weights of columns that explain values best, and the median size of what is left.

    A jump is new beside the past, but no noise.
    """
    level = np.ones((len(values), 1))
    weights = np.linalg.lstsq(np.hstack([columns, level]), values, rcond=None)[0]
    left = values - columns @ weights[:-1] - weights[-1]
    return np.asarray(weights[:-1]), float(np.median(np.abs(left)))


def _order_of(weights: RealArray, shifts: RealArray) -> int:
    """Return whether weights of samples differentiate once or twice, but for a power of ten; 0 where they do not."""
    reach = float(np.max(shifts))
    # The sum is as many times the motion, its slope and its second derivative.
    times = np.abs(weights @ np.stack([shifts**0, shifts, shifts**2 / 2], axis=1))
    for order in (1, 2):
        lower = times[:order] * reach ** (order - np.arange(order))
        gain = float(times[order])
        if np.all(lower < GAIN_ERROR * gain) and abs(gain / 10.0 ** round(np.log10(gain)) - 1) < GAIN_ERROR:
            return order
    return 0
