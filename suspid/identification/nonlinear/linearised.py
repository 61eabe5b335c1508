"""Equivalent linear system of a structure: its poles over a stretch, and their uncertainty."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from suspid.identification.covariance import estimate_of, with_changes
from suspid.identification.noise import loudness, power_near, shared_noise
from suspid.identification.nonlinear.amplitude import over_windows
from suspid.identification.nonlinear.dependence import AmplitudeDependence
from suspid.identification.nonlinear.describing import describing
from suspid.identification.nonlinear.forces import OF_SPEED
from suspid.identification.nonlinear.local import local_changes
from suspid.identification.nonlinear.motion import Motion, Structures
from suspid.identification.nonlinear.structure import StructureFit
from suspid.identification.nonlinear.swings import by_pole, cuts_of
from suspid.levels import SURE
from suspid.model import ModalSet
from suspid.units import ComplexArray, RealArray, Second
from suspid.values import frozen_real

# Cycles in which a decrement is measured, at least.
DECREMENT_CYCLES = 3


def poles_within(structures: Structures, motion: Motion, window: slice) -> ComplexArray:
    """Return the poles of the equivalent linear systems within a window, (structure, pole).

    A force is replaced by a damper or a spring for each mode, by its describing functions.
    """
    theta, places, count = structures.theta, structures.places, structures.theta.shape[1]
    by = places * (theta[:, :, None] if structures.kind in OF_SPEED else 1.0)
    sizes = np.sqrt(np.mean(np.abs(motion.states[:, :, window]) ** 2, axis=2))[:, :, None] * np.abs(by)
    others = np.sqrt(np.maximum(np.sum(sizes**2, axis=1, keepdims=True) - sizes**2, 0.0))
    nearest = describing(structures.kind, sizes / structures.scales, others / structures.scales) / structures.scales
    shares = 0.5 * nearest * by
    own = theta[:, :, None] * np.eye(count) + np.einsum("skj,slj->skl", structures.gains, shares)
    twin = np.einsum("skj,slj->skl", structures.gains, shares.conj())
    whole = np.concatenate(
        [np.concatenate([own, twin], axis=2), np.concatenate([twin.conj(), own.conj()], axis=2)], axis=1
    )
    values = np.linalg.eigvals(whole)
    out = np.einsum("pkk->pk", own).copy()
    for one, found in enumerate(values):
        upper = list(found[found.imag > 0])
        if len(upper) == count:
            for k in range(count):
                out[one, k] = upper.pop(int(np.argmin(np.abs(np.array(upper) - out[one, k]))))
    return np.asarray(out)


def mean_poles(fit: StructureFit, structures: Structures, motion: Motion, window: slice = slice(None)) -> ComplexArray:
    """Return the poles of the equivalent linear systems over a window, (structure, pole).

    Forces that follow a speed change no natural frequency. Natural frequency and damping ratio are the means over the
    cycles of the slowest mode, from every half cycle on, of those in which a mode is seen above the noise of the fit.
    """
    windows = _cycles(fit, window)
    seen = np.array([_seen(fit, cycle) for cycle in windows])
    poles = np.array([poles_within(structures, motion, cycle) for cycle in windows])
    weights = (seen | ~np.any(seen, axis=0))[:, None, :].astype(float)
    zeta = np.sum(weights * (-poles.real / np.abs(poles)), axis=0) / np.sum(weights, axis=0)
    wn = np.abs(structures.theta)
    if structures.kind not in OF_SPEED:
        wn = np.sum(weights * np.abs(poles), axis=0) / np.sum(weights, axis=0)
    return np.asarray(wn * (-zeta + 1j * np.sqrt(np.maximum(1 - zeta**2, 0.0))))


def _cycles(fit: StructureFit, window: slice) -> list[slice]:
    """Return the cycles of the slowest mode within a window, from about every half of one on: all of a shorter one.

    Whole numbers of them, side by side, would change all means where one more has room.
    """
    first, last, _ = window.indices(fit.motion.states.shape[-1])
    cycle = min(max(4, round(2 * np.pi / float(np.min(fit.theta.imag)))), last - first)
    starts = np.linspace(first, last - cycle, 1 + -(-2 * (last - first - cycle) // cycle))
    return [slice(start, start + cycle + 1) for start in starts.astype(int).tolist()]


def _seen(fit: StructureFit, window: slice) -> NDArray[np.bool_]:
    """Return whether each mode is larger than the noise within a window in its strongest channel, (pole,)."""
    sizes = np.mean(np.abs(fit.motion.states[0][:, window]), axis=1)
    over = np.max(np.abs(fit.amplitudes) / np.sqrt(fit.variance), axis=1)
    return np.asarray(sizes * over > SURE)


def slopes_of(fit: StructureFit) -> tuple[ComplexArray, RealArray]:
    """Return the mean poles (pole,) and their derivatives by the parameters, (Re and Im of each pole, parameter)."""
    near = fit.nearby
    whole = slice(None)
    own = mean_poles(fit, fit.structures, fit.motion, whole)[0]
    apart = (mean_poles(fit, near.structures, near.motion, whole) - own) / near.steps[:, None]
    return own, np.stack([apart.real, apart.imag], axis=2).reshape(len(near.steps), -1).T


def modes_of_structure(
    fit: StructureFit, *, timepts: RealArray, channels: tuple[str, ...]
) -> tuple[ModalSet, RealArray, tuple[AmplitudeDependence, ...]]:
    """Return the modes, how loud the residual is near each, (mode,), and how each depends on its amplitude."""
    step, poles, count = float(timepts[-1] - timepts[0]) / (len(timepts) - 1), len(fit.theta), len(timepts)
    exponents, slopes = slopes_of(fit)
    order = np.argsort(np.abs(exponents), kind="stable")
    rows = np.ravel([[2 * k, 2 * k + 1] for k in order])
    weights = np.abs(fit.amplitudes[order]).T ** 2 / fit.variance[:, None]
    beside = power_near(fit.residual, fit.variance, exponents[order])
    loud = loudness(fit.residual, fit.variance, exponents[order], beside=beside, weights=weights)
    covariance = fit.covariance
    size = 2 * poles * len(fit.residual)
    # Shapes of one structure follow its exponents among the parameters.
    dragged = np.zeros((size, slopes.shape[1]))
    for mode, k in enumerate(order):
        for c in range(len(fit.residual)):
            at, own = 2 * (c * poles + mode), 2 * (poles + k * len(fit.residual) + c)
            dragged[[at, at + 1], [own, own + 1]] = 1.0
    joint = estimate_of(
        exponents[order],
        fit.structures.shapes[0][order].T,
        chosen=slopes[rows],
        of_parameters=covariance,
        dragged=dragged,
        noise=np.zeros((size, size)),
        inflation=loud * shared_noise(fit.residual),
    )
    found = joint.modes(step=step, channels=channels)
    found = _with_windows(found, fit, order, exponents, count, step)
    widening = loud * shared_noise(fit.residual)
    depends = tuple(
        _dependence(fit, int(k), complex(exponents[k]), covariance * wide, timepts, channels)
        for k, wide in zip(order, widening, strict=True)
    )
    return found, frozen_real(loud), depends


def _with_windows(
    modes: ModalSet, fit: StructureFit, order: NDArray[np.intp], exponents: ComplexArray, count: int, step: Second
) -> ModalSet:
    """Return the modes with what other choices do to each pole in its covariance.

    The stretch may start half a period of the slowest mode later, or end a fifth earlier. For the slowest mode, the
    decrement and the frequency of its motion may be taken instead of the poles of equivalent linear systems. Friction
    may act elsewhere.
    """
    half = min(int(np.pi / float(np.min(fit.theta.imag))), count // 2)
    means = [
        mean_poles(fit, fit.structures, fit.motion, window)[0]
        for window in (slice(half, count), slice(0, count - count // 5))
    ]
    means += [_decrement(fit, exponents), *_elsewhere(fit, exponents)]
    return with_changes(modes, [(others - exponents)[order] / step for others in means])


def _elsewhere(fit: StructureFit, exponents: ComplexArray) -> list[ComplexArray]:
    """Return the exponents, (pole,), if friction acts elsewhere, where a record does not tell."""
    found, order = list[ComplexArray](), np.argsort(np.abs(exponents))
    for other in fit.others:
        poles = mean_poles(other, other.structures, other.motion)[0]
        if len(poles) == len(exponents):
            found.append(np.empty_like(exponents))
            found[-1][order] = poles[np.argsort(np.abs(poles))]
    return found


def _decrement(fit: StructureFit, exponents: ComplexArray) -> ComplexArray:
    """Return the exponents, (pole,), with that of the slowest mode as its motion has it from first cycle to last.

    The last is that in which it is seen above the noise. The states of faster modes follow the forces of the slowest in
    the end, and do not tell their own decay.
    """
    out, k = exponents.copy(), int(np.argmin(exponents.imag))
    cycle, count = round(2 * np.pi / float(exponents[k].imag)), fit.motion.states.shape[2]
    seen = [_seen(fit, slice(a, a + cycle))[k] for a in range(0, count - cycle + 1, cycle)]
    end = cycle * (seen.index(False) if False in seen else len(seen))
    if end < DECREMENT_CYCLES * cycle:
        return out
    turned = fit.motion.states[0, k, :end] * np.exp(-exponents[k] * np.arange(end))
    first, last = np.mean(turned[:cycle]), np.mean(turned[-cycle:])
    if abs(first) > 0 and abs(last) > 0:
        out[k] += np.log(last / first) / (end - cycle)
    return out


def _dependence(
    fit: StructureFit,
    pole: int,
    holds: complex,
    covariance: RealArray,
    timepts: RealArray,
    channels: tuple[str, ...],
) -> AmplitudeDependence:
    """Return how a mode depends on its amplitude, over parts of the decay."""
    strongest = int(np.argmax(np.abs(fit.amplitudes[pole])))
    envelope = np.log(np.abs(fit.amplitudes[pole, strongest] * fit.motion.states[0, pole]) + 1e-300)
    cycle = int(np.ceil(2 * np.pi / float(np.min(fit.theta.imag))))
    parts = list(pairwise(cuts_of(envelope, least=max(8, cycle))))
    # What is lost in the noise was not met.
    spans = [(a, b) for a, b in parts if _seen(fit, slice(a, b + 1))[pole]] or parts[:1]
    near, poles, stds = fit.nearby, np.empty(len(spans), complex), np.empty((len(spans), 2))
    for i, (a, b) in enumerate(spans):
        window = slice(a, b + 1)
        poles[i] = poles_within(fit.structures, fit.motion, window)[0, pole]
        apart = (poles_within(near.structures, near.motion, window)[:, pole] - poles[i]) / near.steps
        slopes = by_pole(poles[i]) @ np.array([apart.real, apart.imag])
        stds[i] = np.sqrt(np.diag(slopes @ covariance @ slopes.T))
    changes = local_changes(fit.motion.states[0, pole], fit.amplitudes[pole], fit.residual, spans)
    amplitude = np.array([np.exp(np.mean(envelope[a : b + 1])) for a, b in spans])
    return over_windows(spans, channels[strongest], amplitude, poles, stds, changes, holds=holds, timepts=timepts)
