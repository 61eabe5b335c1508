"""Steady lines in a spectrum: narrower than any mode could be, and significant."""

from __future__ import annotations

import math

import numpy as np

from suspid.units import Hertz, RealArray, Second

# Probability with which white noise shows a line. A larger level reports chance in long records.
LINE_LEVEL = 1e-6
# The level beside a line is the median over this many bins on each side, without the bins that the window fills.
BINS_BESIDE, BINS_FILLED = 24, 3
# Power this many bins from the peak, relative to it, above which the peak is broad: a mode or coloured noise.
BROAD_AT, BROAD = (4, 5, 6), 0.05
# Parts of a record in which a steady line is compared, and the largest ratio of its sizes there.
EVEN_PARTS, EVEN_TO = 8, 2.0


def clear_line(values: RealArray, step: Second) -> Hertz | None:
    """Return the frequency of the clearest steady line in any channel (channel, sample) [Hz], or None.

    The Hann-windowed periodogram is compared with its median nearby. In white noise a bin is exponentially
    distributed, so a ratio above ``ln(bins / level)`` has the probability ``level`` in a record.

    Examples
    --------
    >>> noise = np.random.default_rng(1).standard_normal((1, 2000))
    >>> clear_line(noise, 0.01) is None
    True
    >>> hum = noise + np.cos(2 * np.pi * 12.0 * 0.01 * np.arange(2000))
    >>> round(clear_line(hum, 0.01), 1)
    12.0
    """
    count = values.shape[1]
    if count < 128:
        return None
    window = np.hanning(count + 2)[1:-1]
    power = np.abs(np.fft.rfft((values - values.mean(axis=1, keepdims=True)) * window, axis=1)) ** 2
    power[:, : BINS_FILLED + 1] = 0.0
    best: tuple[float, int] | None = None
    limit = math.log(values.size / 2 / LINE_LEVEL)
    for row in power:
        # Few bins can exceed the limit; only those are looked at.
        for k in np.argsort(row)[-8:].tolist():
            ratio = _ratio(row, k)
            if ratio > limit and (best is None or ratio > best[0]):
                best = (ratio, k)
    return None if best is None else float(best[1] / (count * step))


def is_even(values: RealArray, omega: float) -> bool:
    """Return whether a line, at an angle per sample, has about the same size in each part of a record.

    In the channel that shows it most.

    Examples
    --------
    >>> hum = np.cos(0.3 * np.arange(2000))[None]
    >>> is_even(hum, 0.3), is_even(np.exp(-np.arange(2000) / 1200) * hum, 0.3)
    (True, False)
    """
    sizes = _sizes(values, omega)
    return bool(np.max(sizes) < EVEN_TO * np.min(sizes))


def dies_away(values: RealArray, omega: float) -> bool:
    """Return whether motion at an angle per sample is smaller in the second half of a record, and smaller at its end.

    Examples
    --------
    >>> hum = np.cos(0.3 * np.arange(2000))[None]
    >>> dies_away(hum, 0.3), dies_away(np.exp(-np.arange(2000) / 1200) * hum, 0.3)
    (False, True)
    """
    sizes = _sizes(values, omega)
    early, late = sizes[: EVEN_PARTS // 2], sizes[EVEN_PARTS // 2 :]
    return bool(np.max(early) > EVEN_TO * sizes[-1] and np.min(early) > np.max(late))


def _sizes(values: RealArray, omega: float) -> RealArray:
    """Return the size of a line in each part of a record, in the channel that shows it most."""
    each = values.shape[1] // EVEN_PARTS
    parts = values[:, : EVEN_PARTS * each].reshape(len(values), EVEN_PARTS, each)
    window = np.hanning(each + 2)[1:-1] * np.exp(-1j * omega * np.arange(each))
    sizes = np.abs((parts - parts.mean(axis=2, keepdims=True)) @ window)
    return np.asarray(sizes[int(np.argmax(sizes.sum(axis=1)))])


def _ratio(row: RealArray, k: int) -> float:
    """Return the power of a bin over that nearby; 0 if the peak is broad or no peak."""
    low, high = max(BINS_FILLED + 1, k - BINS_BESIDE), min(len(row), k + BINS_BESIDE + 1)
    beside = np.concatenate([row[low : max(low, k - BINS_FILLED)], row[k + BINS_FILLED + 1 : high]])
    near = [row[k + d] for offset in BROAD_AT for d in (offset, -offset) if 0 <= k + d < len(row)]
    peak = row[max(0, k - 1) : k + 2].max() == row[k]
    if not peak or beside.size < BINS_BESIDE or max(near) > BROAD * row[k]:
        return 0.0
    level = float(np.median(beside)) / math.log(2)
    return float(row[k]) / level if level > 0 else math.inf
