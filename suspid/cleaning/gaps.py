"""Gaps: runs of missing samples, filled where neighbouring samples show that the error is small."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.bridges import bridge
from suspid.cleaning.findings import Finding, found
from suspid.units import Flags, RealArray
from suspid.values import frozen_real
from suspid.words import Defect, Number

# Samples on each side of a gap over which the error is measured: enough for a mean square, near enough for a decay.
NEARBY = 200
# Share of a channel, and of a block of a drive, that may be filled. Above it the noise of the record is no longer that
# of the sensor.
MOST_FILLED = 0.1
# Error up to which a gap is filled, as a share of the rms motion. Larger values fill longer gaps with less of the
# motion in them.
MOST_ERROR = 0.05
# Gaps of a channel beyond the simplest that are bridged: more cost time, and there is little left between them.
MOST_BRIDGES = 500


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Filled:
    """A channel with its short gaps filled.

    Parameters
    ----------
    values : ndarray (sample,)
        NaN where a gap was left.
    findings : tuple of Finding
        The gaps filled, with the error.
    """

    values: RealArray
    findings: tuple[Finding, ...]


def runs(flags: Flags) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first index of each run of true, and the index after its last.

    Examples
    --------
    >>> first, after = runs(np.array([True, False, True, True]))
    >>> first.tolist(), after.tolist()
    ([0, 2], [1, 4])
    """
    beside = np.zeros(flags.size + 2, bool)
    beside[1:-1] = flags
    edges = np.flatnonzero(beside[1:] != beside[:-1])
    return edges[::2], edges[1::2]


def fill(name: str, times: RealArray, values: RealArray) -> Filled:
    """Return a channel with its short gaps filled, and the error of that.

    A gap is filled by the cubic through two samples on each side, or by the line through one on each, whichever has
    the smaller error. The error is measured: neighbouring samples are predicted in the same way as if they were
    missing. A gap of one sample is always filled; a longer one if the error is below a twentieth of the rms motion,
    or little more than that for one sample (which is noise). What is left is bridged by a polynomial through more
    samples on each side where the error of that is below a twentieth of the rms motion. In a sinusoid, gaps up to
    about a third of the period are filled, however many samples that is; in noise, few samples. Gaps at the ends are
    left.

    Parameters
    ----------
    name : str
        The channel.
    times, values : ndarray (sample,)
        Uniform times [s] and samples, NaN where missing.

    Examples
    --------
    >>> t = np.arange(200) / 100
    >>> values = np.sin(10 * t)
    >>> values[50:53] = np.nan
    >>> filled = fill("seat", t, values)
    >>> f"{np.max(np.abs(filled.values - np.sin(10 * t))):.0e}"
    '1e-04'
    """
    missing = np.isnan(values)
    if np.sum(~missing) < 4:
        return Filled(values=values, findings=())
    first, after = runs(missing)
    inner = (first >= 1) & (after <= values.size - 1)
    first, after = first[inner], after[inner]
    if not first.size:
        return Filled(values=values, findings=())
    motion = float(np.std(values[~missing]))
    better = values.copy()
    errors: list[float] = []
    where: list[RealArray] = []
    one = _errors(values, 1, first)
    for length in np.unique(after - first):
        # Longer gaps are left to bridges. The error is measured, so that this only bounds the work.
        if length > 20:
            continue
        chosen = np.flatnonzero(after - first == length)
        cubic, line = _errors(values, int(length), first[chosen])
        single = np.min([error[chosen] for error in one], axis=0)
        error = np.minimum(cubic, line)
        # Multiple of the error for a single sample, which is noise, that is allowed beside the share of the motion.
        allowed = (error <= MOST_ERROR * motion + 1.5 * single) if length > 1 else np.ones(chosen.size, bool)
        for k, by_line, err in zip(chosen[allowed], (line < cubic)[allowed], error[allowed], strict=True):
            gap = slice(first[k], after[k])
            better[gap] = _bridge(values, int(first[k]), int(after[k]), by_line=bool(by_line))
            errors.append(float(err))
            where.append(times[gap])
    left = np.flatnonzero(np.isnan(better[first]))
    for k in left[np.argsort((after - first)[left], kind="stable")][:MOST_BRIDGES]:
        if sum(map(len, where)) + after[k] - first[k] > MOST_FILLED * values.size:
            break
        bridged = bridge(better, ~missing, int(first[k]), int(after[k]))
        if bridged is not None and bridged[1] <= MOST_ERROR * motion:
            better[first[k] : after[k]] = bridged[0]
            errors.append(bridged[1])
            where.append(times[first[k] : after[k]])
    if not where:
        return Filled(values=values, findings=())
    at = np.concatenate(where)
    lengths = [len(gap) for gap in where]
    rms = float(np.sqrt(np.average(np.square(errors), weights=lengths)))
    numbers: dict[str, Number] = {"gaps": len(where), "longest": max(lengths), "error": rms}
    if motion > 0:
        numbers["share"] = rms / motion
    return Filled(values=frozen_real(better), findings=(found(Defect.MISSING, at, at.size, numbers, channel=name),))


def _errors(values: RealArray, length: int, gaps: NDArray[np.intp]) -> tuple[RealArray, RealArray]:
    """Return the rms errors of filling gaps of a length beside the given ones, by the cubic and by the line."""
    count = values.size - length - 3
    if count < 1:
        return np.full(gaps.size, np.inf), np.full(gaps.size, np.inf)
    pieces = [values[i : i + count] for i in (0, 1, length + 2, length + 3)]
    cubic, line = np.zeros(count), np.zeros(count)
    for inside in range(2, length + 2):
        true = values[inside : inside + count]
        weights = _lagrange(np.array([0.0, 1.0, length + 2.0, length + 3.0]), float(inside))
        cubic += (true - sum(w * piece for w, piece in zip(weights, pieces, strict=True))) ** 2 / length
        share = (inside - 1) / (length + 1)
        line += (true - (1 - share) * pieces[1] - share * pieces[2]) ** 2 / length
    known = np.isfinite(cubic)
    if not np.any(known):
        return np.full(gaps.size, np.inf), np.full(gaps.size, np.inf)
    low, high = np.clip(gaps - NEARBY, 0, count), np.clip(gaps + NEARBY, 0, count)
    number = np.concatenate([[0], np.cumsum(known)])
    errors = []
    for squared in (cubic, line):
        total = np.concatenate([[0.0], np.cumsum(np.where(known, squared, 0.0))])
        places = number[high] - number[low]
        mean = np.where(places > 10, (total[high] - total[low]) / np.maximum(places, 1), total[-1] / number[-1])
        errors.append(np.sqrt(np.maximum(mean, 0.0)))
    return errors[0], errors[1]


def _bridge(values: RealArray, first: int, after: int, *, by_line: bool) -> RealArray:
    """Return the samples of one gap from the nearest known ones."""
    before = [k for k in range(first - 1, max(-1, first - 4), -1) if np.isfinite(values[k])][:2]
    behind = [k for k in range(after, min(values.size, after + 3)) if np.isfinite(values[k])][:2]
    if by_line or len(before) < 2 or len(behind) < 2:
        before, behind = before[:1], behind[:1]
    known = np.array([*before[::-1], *behind])
    return np.array([_lagrange(known - float(k), 0.0) @ values[known] for k in range(first, after)])


def _lagrange(knots: RealArray, at: float) -> RealArray:
    """Return the weights of the values at the knots in the polynomial through them."""
    apart = knots[:, None] - knots[None, :]
    np.fill_diagonal(apart, 1.0)
    ahead = np.tile(at - knots, (knots.size, 1))
    np.fill_diagonal(ahead, 1.0)
    return np.asarray(np.prod(ahead, axis=1) / np.prod(apart, axis=1))
