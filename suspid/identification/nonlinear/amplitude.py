"""Natural frequency and damping ratio of a mode as functions of its amplitude."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from suspid.identification.information import inverse_information
from suspid.identification.nonlinear.dependence import AmplitudeDependence
from suspid.identification.nonlinear.driven import DrivenFit, maximize
from suspid.identification.nonlinear.forces import means
from suspid.identification.nonlinear.local import local_changes
from suspid.identification.nonlinear.swings import by_pole, cuts_of, mean_of, swings_of
from suspid.levels import SURE
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real

# Harmonics of each mode beside which the part of a force in step with another mode is found.
HARMONICS = (2, 3, 4, 5)
# Cycles of the slowest mode that are described at least, however weak a mode is.
CYCLES_DESCRIBED = 2


def mean_pole(fit: DrivenFit, pole: int, window: slice = slice(None)) -> tuple[complex, RealArray]:
    """Return the mean pole of a mode over a window, and its derivatives, (2, parameter).

    Of a single mode it has the mean natural frequency and damping ratio of its cycles. In what several modes do
    together the swings of one are not seen alone: there it is that of the equivalent linear system.
    """
    swings = swings_of(fit, pole, window) if len(fit.drive.theta) == 1 else None
    return _equivalent_pole(fit, pole, window) if swings is None else swings.mean()


def mean_over_parts(fit: DrivenFit, pole: int) -> tuple[complex, RealArray]:
    """Return the mean pole of a mode over its decay, and its derivatives, (2, parameter).

    Of several modes it is the mean of the parts by which the mode is described over its amplitude, each by its length.
    """
    if len(fit.drive.theta) == 1:
        return mean_pole(fit, pole)
    pairs = _part_pairs(fit, pole)
    return mean_of([_equivalent_pole(fit, pole, slice(a, b + 1)) for a, b in pairs], [b - a for a, b in pairs])


def _equivalent_pole(fit: DrivenFit, pole: int, window: slice) -> tuple[complex, RealArray]:
    """Return a pole of the equivalent linear system over a window, and its derivatives, (2, parameter)."""
    poles, by_gain = _equivalent(fit, window)
    return complex(poles[pole]), _pole_slopes(fit, pole, by_gain[pole])


def _part_pairs(fit: DrivenFit, pole: int) -> list[tuple[int, int]]:
    """Return first and last samples of the parts of a decay between which a mode falls by about equal parts.

    What is lost in the noise of every channel was not met.
    """
    cycle = int(np.ceil(2 * np.pi / float(np.min(np.abs(fit.drive.theta.imag)))))
    above = float(np.max(np.abs(fit.amplitudes[pole]) / np.sqrt(fit.variance)))
    seen = np.flatnonzero(above * np.abs(fit.states[pole]) > SURE)
    end = max(int(seen[-1]) if seen.size else 0, CYCLES_DESCRIBED * cycle)
    envelope = np.log(np.abs(fit.states[pole, : end + 1]) + 1e-300)
    return list(pairwise(cuts_of(envelope, least=max(8, cycle))))


def _equivalent(fit: DrivenFit, window: slice = slice(None)) -> tuple[ComplexArray, ComplexArray]:
    """Return the poles of the equivalent linear system (pole,), and their derivatives by the gains (pole, force).

    Each force is replaced by the combination of the states nearest to it within the window.
    """
    drive = fit.drive
    theta, out, count = drive.theta, drive.theta.copy(), len(drive.theta)
    if not len(drive.forces):
        return out, np.zeros(drive.gains.shape, complex)
    states = fit.states[:, window]
    columns = means(np.concatenate([2 * states.real, -2 * states.imag])).T
    if count > 1 and len(columns) > 8 * (columns.shape[1] + 4 * count * len(HARMONICS)):
        # What one mode's harmonics are to another's frequency is no stiffness of that.
        turns = states / (np.abs(states) + 1e-300)
        beside = [turns**m * size for m in HARMONICS for size in (1.0, np.abs(states))]
        columns = np.column_stack([columns, *(means(np.concatenate([each.real, each.imag])).T for each in beside)])
    nearest = np.linalg.lstsq(columns, drive.forces[:, window].T, rcond=1e-6)[0]
    parts = nearest[:count] + 1j * nearest[count : 2 * count]
    # z' = theta z + gains (h z + conj(h z)): a real system in z and its conjugate.
    own, other = np.diag(theta) + drive.gains @ parts.T, drive.gains @ parts.T.conj()
    system = np.block([[own, other], [other.conj(), own.conj()]])
    values = np.linalg.eigvals(system)
    values = values[values.imag > 0]
    if len(values) == count:
        # Each pole goes to the nearest of what the diagonal says, strongest first.
        left = list(values)
        for k in np.argsort(np.abs(own.diagonal() - theta)):
            out[k] = left.pop(int(np.argmin(np.abs(np.array(left) - own[k, k]))))
    else:
        out = own.diagonal()
    return out, parts


def _pole_slopes(fit: DrivenFit, pole: int, by_gain: ComplexArray) -> RealArray:
    """Return the derivatives of Re and Im of an equivalent pole by the parameters of a fit, (2, parameter)."""
    drive = fit.drive
    out = np.zeros((2, drive.free), dtype=float)
    out[0, 2 * pole], out[1, 2 * pole + 1] = 1.0, 1.0
    for i, (k, j) in enumerate(drive.gain_places):
        if k == pole:
            at, h = 2 * len(drive.theta) + 2 * i, complex(by_gain[j])
            out[:, at] = h.real, h.imag
            out[:, at + 1] = -h.imag, h.real
    return out


def window_changes(fit: DrivenFit, pole: int, theta: complex, *, refit: bool = False) -> ComplexArray:
    """Return by how much the mean pole of a mode changes with the stretch, (window,).

    A decay that starts half a period later, or ends a fifth earlier, has other amplitudes and so another mean. With
    ``refit`` the parts are fitted anew: where the forces are not quite the true ones, they have other values.
    """
    count = fit.states.shape[1]
    half = min(int(np.pi / theta.imag), count // 2)
    windows = (slice(half, count), slice(0, count - count // 5))
    parts = [_within(fit, window) if refit else None for window in windows]
    means = [
        mean_pole(fit, pole, window) if part is None else mean_pole(part, pole)
        for part, window in zip(parts, windows, strict=True)
    ]
    return np.array([mean - theta for mean, _ in means])


def _within(fit: DrivenFit, window: slice) -> DrivenFit | None:
    """Return the fit to a window of the record, from the same poles and forces on."""
    first = fit.states[:, window.start]
    drive = replace(fit.drive, gains=fit.drive.gains / first[:, None], forces=fit.drive.forces[:, window])
    # Steps of the fit to a part of the record; they begin at the fit to the whole.
    return maximize(fit.values[:, window], drive, fit.noise, steps=5)


def covariance_of(fit: DrivenFit) -> RealArray:
    """Return the covariance of the parameters of a fit, (parameter, parameter)."""
    return inverse_information(fit.information * (fit.freedom / fit.residual.shape[1]))


def dependence(
    fit: DrivenFit, pole: int, *, holds: complex, widening: float, timepts: RealArray, channels: tuple[str, ...]
) -> AmplitudeDependence:
    """Return how a mode depends on its amplitude; ``holds`` is the mean of its exponent over the record."""
    strongest = int(np.argmax(np.abs(fit.amplitudes[pole])))
    covariance = covariance_of(fit) * widening
    parts, amplitude = _parts(fit, pole, size=float(np.abs(fit.amplitudes[pole, strongest])))
    poles, stds = np.empty(len(parts), complex), np.empty((len(parts), 2))
    for i, (theta, slopes, _) in enumerate(parts):
        by_parameter = by_pole(np.asarray(theta)) @ slopes
        poles[i], stds[i] = theta, np.sqrt(np.diag(by_parameter @ covariance @ by_parameter.T))
    spans = [span for _, _, span in parts]
    changes = local_changes(fit.states[pole], fit.amplitudes[pole], fit.residual, spans)
    return over_windows(spans, channels[strongest], amplitude, poles, stds, changes, holds=holds, timepts=timepts)


def over_windows(
    spans: Sequence[tuple[float, float]],
    channel: str,
    amplitude: RealArray,
    poles: ComplexArray,
    stds: RealArray,
    changes: ComplexArray,
    *,
    holds: complex,
    timepts: RealArray,
) -> AmplitudeDependence:
    """Return the dependence of a mode on its amplitude, from its pole per sample in each window.

    ``spans`` are in samples; ``stds`` are those of natural frequency and damping ratio, (window, 2), without the
    ``changes`` of the pole that the residual shows.
    """
    moved = np.einsum("vwi,wi->wv", by_pole(poles), np.stack([changes.real, changes.imag], axis=1))
    stds = np.hypot(stds, moved)
    step = float(timepts[-1] - timepts[0]) / (len(timepts) - 1)
    return AmplitudeDependence(
        spans=tuple((float(timepts[0] + step * a), float(timepts[0] + step * b)) for a, b in spans),
        channel=channel,
        amplitude=frozen_real(amplitude),
        wn=frozen_real(np.abs(poles) / step),
        zeta=frozen_real(-poles.real / np.abs(poles)),
        wn_std=frozen_real(stds[:, 0] / step),
        zeta_std=frozen_real(stds[:, 1]),
        holds_at=where_holds(holds, poles, amplitude),
    )


def _parts(
    fit: DrivenFit, pole: int, *, size: float
) -> tuple[list[tuple[complex, RealArray, tuple[float, float]]], RealArray]:
    """Return exponent, derivatives and span in samples of each part of a decay, and the amplitude in each, (part,)."""
    swings = swings_of(fit, pole) if len(fit.drive.theta) == 1 else None
    if swings is not None:
        pairs = _whole_cycles(swings.size)
        between = np.array([np.sqrt(swings.size[a] * swings.size[b]) for a, b in pairs])
        return [(*swings.pole(a, b), (float(swings.time[a]), float(swings.time[b]))) for a, b in pairs], between
    pairs = _part_pairs(fit, pole)
    envelope = np.log(size * np.abs(fit.states[pole]) + 1e-300)
    inside = np.array([np.exp(np.mean(envelope[a : b + 1])) for a, b in pairs])
    return [(*_equivalent_pole(fit, pole, slice(a, b + 1)), (float(a), float(b))) for a, b in pairs], inside


def _whole_cycles(sizes: RealArray) -> list[tuple[int, int]]:
    """Return first and last swings of windows of whole cycles, between which the sizes fall by about equal parts.

    A spring that bends to one side may part the two swings of a cycle unevenly. The last window ends with the last
    swing; where that is one too many, it begins a swing later.

    Examples
    --------
    >>> [_whole_cycles(0.5 ** np.arange(swings)) for swings in (2, 3, 4, 7, 8)]
    [[(0, 1)], [(0, 2)], [(0, 3)], [(0, 2), (2, 4), (4, 6)], [(0, 2), (2, 4), (5, 7)]]
    """
    last = len(sizes) - 1
    if last < 4:
        return [(0, last)]
    pairs = [(2 * a, 2 * b) for a, b in pairwise(cuts_of(np.log(sizes[::2]), least=1))]
    over = last - pairs[-1][1]
    return [*pairs[:-1], (pairs[-1][0] + over, last)]


def where_holds(holds: complex, poles: ComplexArray, amplitude: RealArray) -> float:
    """Return the amplitude at which the line through given poles is nearest to a pole."""
    order = np.argsort(amplitude)
    poles, logs = poles[order], np.log(amplitude[order])
    if len(poles) < 2:
        return float(amplitude[0])
    # Frequency and damping count alike, each over the range that it has.
    wn, zeta = np.abs(poles), -poles.real / np.abs(poles)
    ranges = max(float(np.ptp(wn)), 1e-300), max(float(np.ptp(zeta)), 1e-300)
    places = wn / ranges[0] + 1j * zeta / ranges[1]
    target = complex(abs(holds) / ranges[0], -holds.real / abs(holds) / ranges[1])
    legs = np.diff(places)
    shares = np.clip(((target - places[:-1]) * legs.conj()).real / np.maximum(np.abs(legs) ** 2, 1e-300), 0.0, 1.0)
    nearest = int(np.argmin(np.abs(places[:-1] + shares * legs - target)))
    return float(np.exp(logs[nearest] + shares[nearest] * (logs[nearest + 1] - logs[nearest])))
