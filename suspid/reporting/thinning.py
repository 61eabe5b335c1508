"""Thinning of long records for plots: peaks are kept, and transforms are limited to what a picture can show."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from suspid.identification import FourSteps
from suspid.samples import held
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.values import frozen_real

if TYPE_CHECKING:
    from suspid.identification import Identification
    from suspid.wavelets import Scalogram

# Most pieces of a line of which the two extremes are drawn.
PIECES = 2000
# Of a record of more samples than this, all channels together, the wavelet's view is made of its decay alone.
MOST_SAMPLES = 40_000
# With many channels each keeps at least this many samples: fewer show no decay.
FEWEST_DRAWN = 1024
# Cycles of a mode that are drawn enlarged, and the share of the record below which that shows more than the whole.
CYCLES, SMALL_PART = 6.0, 0.6


def extremes(time: RealArray, values: RealArray, *, pieces: int = PIECES) -> tuple[RealArray, RealArray]:
    """Return the samples, or of long lines the least and the greatest of each piece, in their order.

    Examples
    --------
    >>> extremes(np.arange(6.0), np.array([0.0, 9.0, 0.0, 0.0, -7.0, 0.0]), pieces=1)
    (array([0., 1., 4., 5.]), array([ 0.,  9., -7.,  0.]))
    """
    count = len(values)
    if count <= 2 * pieces or np.any(np.isnan(values)):
        step = -(-count // (2 * pieces)) if count else 1
        return time[::step], values[::step]
    bounds = np.linspace(0, count, pieces + 1).astype(int)
    kept = [start + where(values[start:stop]) for start, stop in pairwise(bounds) for where in (np.argmin, np.argmax)]
    index = np.unique([0, *kept, count - 1])
    return time[index], values[index]


def first_cycles(identification: Identification, onset: Second | None = None) -> tuple[Second, Second] | None:
    """Return the span of the first cycles of a mode, from the onset (default: the first sample) on [s].

    The mode is the slowest of which six cycles are a small part of the record. Where there is none, there is nothing
    to enlarge.
    """
    signal, poles = as_signal(held(identification, "response")), identification.modes.poles
    start = signal.start if onset is None else onset
    spans = np.maximum(CYCLES * 2 * np.pi / poles.imag[poles.imag > 0], 20 * signal.step)
    short = spans[spans < SMALL_PART * signal.duration]
    return (start, min(start + float(short.max()), signal.start + signal.duration)) if short.size else None


def pooled(scalogram: Scalogram, weights: RealArray, edges: RealArray) -> RealArray:
    """Return the modulus in each column between edges, (row, column): the largest, or that at the middle."""
    middle = (edges[1:] + edges[:-1]) / 2
    out = np.empty((len(scalogram.rows), len(middle)))
    for i, row in enumerate(scalogram.rows):
        modulus = np.sqrt(weights @ np.abs(row) ** 2)
        time = scalogram.timepts(i)
        first = np.searchsorted(time, edges[:-1])
        if first[-1] < len(time) and np.all(np.diff(first) > 0):
            out[i] = np.maximum.reduceat(modulus, first)
        else:
            out[i] = np.interp(middle, time, modulus)
    return out


def power_weights(scalogram: Scalogram) -> RealArray:
    """Return one over the mean square of each channel, (channel,): no channel's unit matters. Silent ones get 0."""
    power = np.mean(scalogram.signal.values**2, axis=1)
    return np.where(power > 0, 1 / np.where(power > 0, power, 1.0), 0.0)


def row_edges(hertz: RealArray) -> RealArray:
    """Return the boundaries between rows, midway in the logarithm."""
    if len(hertz) == 1:
        return np.array([hertz[0] / 1.05, hertz[0] * 1.05])
    middle = np.sqrt(hertz[1:] * hertz[:-1])
    return np.concatenate([[hertz[0] ** 2 / middle[0]], middle, [hertz[-1] ** 2 / middle[-1]]])


def drawable(identification: Identification) -> Identification:
    """Return the identification with a wavelet's view of it that is quickly made.

    One identified by its ridges, and one of a short record, keeps its own. Of a long record the view is that of its
    first part, until the slowest mode has died away, at a rate that suffices for the fastest; the wavelet is one of a
    dozen.
    """
    signal = identification.steps.signal
    channels, count = signal.values.shape
    if identification.method == "ridge" or channels * count <= MOST_SAMPLES:
        return identification
    most = max(MOST_SAMPLES // channels, FEWEST_DRAWN)
    # Where there is no mode, what was taken for none is of interest.
    beside = [c.pole for c in identification.considered if c.removed or not len(identification.modes)]
    poles = np.array([*identification.modes.poles, *beside])
    decays = -identification.modes.poles.real[identification.modes.poles.imag > 0] * signal.step
    slowest = float(np.min(decays[decays > 0], initial=np.inf))
    # The slowest mode has then fallen to e^-8.
    kept = count if not np.isfinite(slowest) else int(np.clip(8.0 / slowest, FEWEST_DRAWN, count))
    fastest = float(np.max(poles.imag, initial=0.0)) * signal.step
    # The fastest still has four samples a cycle.
    widest = int(2 * np.pi / fastest / 4.0) if fastest > 0 else -(-kept // most)
    stride = max(1, min(widest, -(-kept // most)))
    view = _thinned(signal, min(kept, most * stride), stride)
    rows = identification.steps.band
    low, high = max(rows[0], 8 * np.pi / view.duration), min(rows[1], 0.9 * np.pi / view.step)
    if not low < high:
        return identification
    steps = FourSteps(
        signal=view,
        count=identification.steps.count,
        band=(low, high),
        bandwidth=identification.steps.bandwidth,
        candidates=_some(identification.steps.candidates),
        chosen=identification.steps.chosen,
    )
    return replace(identification, steps=steps)


def _thinned(signal: Signal, count: int, stride: int) -> Signal:
    from scipy.signal import decimate

    values = signal.values[:, :count]
    if stride > 1:
        values = decimate(values, stride, ftype="fir", axis=1)
    centred = values - values.mean(axis=1, keepdims=True)
    return Signal(start=signal.start, step=signal.step * stride, values=frozen_real(centred), channels=signal.channels)


def _some(candidates: tuple[float, ...]) -> tuple[float, ...]:
    """Return those of the few bandwidths that lie within the candidates, or the candidates, if they are few."""
    # An eighth of an octave less in the bandwidth changes no picture.
    few = tuple(
        n
        for n in (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0)
        if min(candidates) <= n <= max(candidates)
    )
    return few if few and len(candidates) > len(few) else candidates


def is_whole(identification: Identification) -> bool:
    """Return whether the wavelet's view is that of every sample of the record."""
    signal, view = as_signal(held(identification, "response")), identification.steps.signal
    return signal.values.shape == view.values.shape
