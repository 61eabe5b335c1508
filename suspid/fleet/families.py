"""Families of modes: modes of different records that correspond to each other."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from suspid.units import RealArray

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from suspid.model import ModalSet

# The label of a mode that belongs to no family.
OTHERS = -1
# Bandwidth of the density of log frequency: modes 8 % apart blur into one peak. Larger merges families, smaller splits
# one family by its scatter.
BANDWIDTH = 0.08
# Grid of the density: an eighth of the bandwidth.
STEP = BANDWIDTH / 8
# Largest difference of log frequency to a mode of the car (a factor of 1.6); larger takes spurious modes for it.
BEYOND = 0.5


def families_by_density(f: RealArray, zeta: RealArray, record: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the family of each mode, numbered from 0 in order of frequency; `OTHERS` where there are too few.

    A family is a peak of the density of log frequency. Where most records have two or more modes in one peak, these
    are separated by damping or by frequency, whichever separates them better. A family takes at most one mode of a
    record, the nearest to its middle. Each row of ``f`` (in any unit), ``zeta`` and ``record`` (its number) is one
    mode.

    Examples
    --------
    >>> f = np.tile([1.0, 1.1, 10.0], 20) * np.repeat(np.linspace(0.97, 1.03, 20), 3)
    >>> families_by_density(f, np.tile([0.3, 0.1, 0.2], 20), np.repeat(np.arange(20), 3))[:6]
    array([1, 0, 2, 1, 0, 2])
    """
    label = np.full(len(f), OTHERS, dtype=np.int64)
    usable = np.isfinite(f) & (f > 0)
    if not np.any(usable):
        return label
    x = np.log(np.where(usable, f, 1.0))
    edges = _valleys(x[usable])
    peak = np.where(usable, np.searchsorted(edges, x), OTHERS)
    records, count = len(np.unique(record)), 0
    for k in range(len(edges) + 1):
        here = np.flatnonzero(peak == k)
        # A family holds at least two records of a hundred, and three. Less makes families of spurious modes.
        if len(np.unique(record[here])) < max(3, 0.02 * records):
            continue
        parts = _told_apart(x[here], np.log(np.maximum(np.abs(zeta[here]), 1e-4)), record[here])
        label[here] = np.where(parts == OTHERS, OTHERS, count + parts)
        count += int(np.max(parts)) + 1
    return label


def families_of_car(f: RealArray, zeta: RealArray, record: NDArray[np.int64], modes: ModalSet) -> NDArray[np.int64]:
    """Return for each row the number of the car's mode that it is, from 0; `OTHERS` where it is none of them.

    Each mode of a record is assigned to the nearest mode of the car in log frequency and log damping. Each mode of the
    car takes at most one mode of a record, the nearest.

    Examples
    --------
    >>> from suspid import ModalSet
    >>> car = ModalSet.from_wn_zeta([2 * np.pi, 20 * np.pi], [0.3, 0.2])
    >>> families_of_car(np.array([1.1, 1.3, 9.0, 40.0]), np.full(4, 0.25), np.zeros(4, int), car)
    array([ 0, -1,  1, -1])
    """
    centre = np.log(np.maximum(modes.wn, 1e-12) / (2 * np.pi))
    damped = np.log(np.maximum(np.abs(modes.zeta), 1e-3))
    x, y = np.log(np.maximum(f, 1e-12)), np.log(np.maximum(np.abs(zeta), 1e-3))
    apart = np.abs(x[:, None] - centre)
    # Log damping weighs a fifth of log frequency: it varies more between vehicles and tests.
    far = np.hypot(apart, 0.2 * (y[:, None] - damped))
    nearest = np.argmin(far, axis=1)
    rows = np.arange(len(f))
    label = np.where(apart[rows, nearest] < BEYOND, nearest, OTHERS)
    # Of several rows of one record that are nearest to one mode, only the nearest is assigned.
    return _nearest_alone(np.asarray(label, dtype=np.int64), far[rows, nearest], record)


def _valleys(x: RealArray) -> RealArray:
    """Return the minima of the density of x between separate peaks."""
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import find_peaks

    low, high = np.min(x) - 5 * BANDWIDTH, np.max(x) + 5 * BANDWIDTH
    count, edges = np.histogram(x, bins=max(8, int(np.ceil((high - low) / STEP))), range=(low, high))
    density = gaussian_filter1d(count.astype(float), BANDWIDTH / (edges[1] - edges[0]), mode="constant")
    peaks, found = find_peaks(density, prominence=0)
    # Prominence of a peak relative to its height. A larger share merges neighbours, a smaller one splits a peak by
    # chance.
    peaks = peaks[found["prominences"] >= 0.3 * density[peaks]]
    valleys = [a + int(np.argmin(density[a:b])) for a, b in itertools.pairwise(peaks)]
    return np.asarray(edges[valleys] + STEP / 2, float)


def _told_apart(x: RealArray, y: RealArray, record: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the number of each row among the modes that most records have in this peak, from 0; else `OTHERS`."""
    _, place, counts = np.unique(record, return_inverse=True, return_counts=True)
    many = int(np.median(counts))
    if many < 2:
        return _nearest_alone(np.zeros(len(x), dtype=np.int64), np.abs(x - np.median(x)), place)
    full = counts[place] == many
    best: tuple[float, RealArray, RealArray] | None = None
    for values in (x, y):
        order = np.lexsort((values[full], place[full]))
        ranked = values[full][order].reshape(-1, many)
        middle = np.median(ranked, axis=0)
        parted = float(np.min(np.diff(middle)) / (np.mean(np.abs(ranked - middle)) + 1e-12))
        if best is None or parted > best[0]:
            best = parted, values, middle
    assert best is not None
    _, values, middle = best
    label = np.argmin(np.abs(values[:, None] - middle), axis=1)
    # Within a record that has all of them, the order is more reliable than the distance.
    rows = np.flatnonzero(full)
    order = rows[np.lexsort((values[full], place[full]))]
    label[order] = np.tile(np.arange(many), len(order) // many)
    return _nearest_alone(np.asarray(label, dtype=np.int64), np.abs(values - middle[label]), place)


def _nearest_alone(label: NDArray[np.int64], far: RealArray, record: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the labels, of which each record keeps one of a kind: that of its nearest row; `OTHERS` of the rest."""
    order = np.lexsort((far, label, record))
    same = (record[order][1:] == record[order][:-1]) & (label[order][1:] == label[order][:-1])
    alone = label.copy()
    alone[order[1:][same]] = OTHERS
    return alone
