"""Stamps of a fixed number of significant digits, as ``%.3g`` writes them: the resolution grows with the time."""

from __future__ import annotations

from typing import Any

import numpy as np

from suspid.units import RealArray, Second


def resolutions(stamps: RealArray) -> RealArray | None:
    """Return the resolution of each stamp [s], if all have the same few significant digits; None if they have more.

    Examples
    --------
    >>> resolutions(np.array([0.0, 0.333, 9.67, 10.3, 20.0])).round(9).tolist()
    [0.0, 0.001, 0.01, 0.1, 0.1]
    """
    size = np.abs(stamps)
    decades = np.floor(np.log10(np.where(size > 0, size, 1.0)) + 1e-12)
    # Most significant digits that are looked for: more resolve any sampling step of a record of this many rows.
    for digits in range(2, 7 + 1):
        steps = 10.0 ** (decades - digits + 1)
        if np.all(np.abs(stamps / steps - np.round(stamps / steps)) < 1e-6):
            return np.asarray(np.where(size > 0, steps, 0.0))
    return None


def least_excess(stamps: RealArray, wide: RealArray) -> Second:
    """Return a lower bound of the excess of any line, by how far stamps lie off the chords of others.

    Where no stamp lies further from a line than half of its resolution and the excess, none lies further from a chord
    than two halves and twice the excess.
    """
    least = 0.0
    for apart in (stamps.size // 3 >> k for k in range(5)):
        if apart < 1:
            break
        left, middle, right = (slice(k * apart, stamps.size - (2 - k) * apart) for k in range(3))
        off = np.abs(stamps[middle] - 0.5 * (stamps[left] + stamps[right]))
        allowed = 0.5 * (wide[middle] + np.maximum(wide[left], wide[right]))
        least = max(least, 0.5 * float(np.max(off - allowed)))
    return least


def line_within(stamps: RealArray, wide: RealArray) -> tuple[Second, Second, Second, Second]:
    """Return start, step, its standard deviation and the excess of the clock that is nearest to the stamps.

    Row ``i`` has the time ``start + step i``. No stamp lies further from that than half of its resolution ``wide`` and
    the excess. The standard deviation is that of a uniform distribution over all steps for which this holds.
    """
    from scipy.optimize import linprog

    scale, last = float(stamps[-1] - stamps[0]), stamps.size - 1
    # Rows of which the line is found; the others are checked against it.
    some = np.unique(np.linspace(0, last, min(stamps.size, 20_000)).astype(int))
    line = np.column_stack([np.ones(some.size), some / last])
    half, centred = 0.5 * wide[some] / scale, (stamps[some] - stamps[0]) / scale
    limits = np.vstack([np.column_stack([line, -np.ones(some.size)]), np.column_stack([-line, -np.ones(some.size)])])
    values = np.concatenate([centred + half, half - centred])
    free = [(None, None), (None, None)]
    best: Any = linprog([0.0, 0.0, 1.0], A_ub=limits, b_ub=values, bounds=[*free, (0.0, None)])
    most = best.x[2] + 0.05 * float(np.median(wide)) / scale
    ends: list[Any] = [
        linprog([0.0, sign, 0.0], A_ub=limits, b_ub=values, bounds=[*free, (0.0, most)]) for sign in (1.0, -1.0)
    ]
    spread = float(ends[1].x[1] - ends[0].x[1]) * scale / last
    start, step = float(stamps[0] + best.x[0] * scale), float(best.x[1] * scale / last)
    beyond = np.abs(start + step * np.arange(stamps.size) - stamps) - 0.5 * wide
    return start, step, spread / float(np.sqrt(12)), max(0.0, float(np.max(beyond)))
