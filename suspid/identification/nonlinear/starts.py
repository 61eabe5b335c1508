"""Starts of the search for a structure: linear fits of the modes, and single modes with another pole beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from suspid.identification.fitting import OTHER_FREQUENCY
from suspid.identification.nonlinear.driven import DrivenFit, maximize
from suspid.identification.nonlinear.feedback import ROUGH_STEPS, Bent, Record
from suspid.identification.nonlinear.own import repeated
from suspid.units import ComplexArray

# Poles that differ by less than this share are the same start: steps of a fit go farther.
ALIKE = 0.03
# Poles that are tried beside a single mode, of the linear fit and of a residual, and their damping ratio at first: that
# of a second mode of rigs. More take seconds each.
OTHER_POLES, LIGHT = 2, 0.02


def starts_of(record: Record, strong: DrivenFit, bent: Bent | None) -> list[DrivenFit]:
    """Return the fits to start from: that of several modes with forces, and the linear one of the `strongest`."""
    starts = [bent.fit] if bent is not None and bent.count > 1 else []
    # From the same poles the same is found.
    if not any(_alike(start.drive.theta, strong.drive.theta) for start in starts):
        starts = [*starts, strong]
    if len(strong.drive.theta) == 1:
        beside = _with_other(record, strong)
        starts = starts if beside is None else [beside, *starts]
    decaying = (_decaying(record, start) for start in starts)
    return [start for start in decaying if start is not None]


def _decaying(record: Record, start: DrivenFit) -> DrivenFit | None:
    """Return a start with light damping in place of growth: over the first cycles, friction bends a fit to that.

    A start with forces is none.
    """
    theta = start.drive.theta
    grows = theta.real >= 0
    if not grows.any():
        return start
    if len(start.drive.forces):
        return None
    light = np.where(grows, -LIGHT * np.abs(theta) + 1j * theta.imag, theta)
    return maximize(record.values, replace(start.drive, theta=light), record.noise, steps=0)


def _with_other(record: Record, alone: DrivenFit) -> DrivenFit | None:
    """Return the fit of a single mode with the strongest other pole of the linear fit, one that is no multiple of it.

    Parts of a mode that friction bends may be stronger than the next mode. Where all others lie at multiples, the next
    mode may be one of them. None if there is no other.
    """
    weights = record.amplitudes / np.sqrt(alone.variance)
    single = alone.amplitudes / np.sqrt(alone.variance)
    others = np.flatnonzero((record.theta.imag > 0) & (record.theta.real < 0))
    if not others.size:
        return None
    apart = _apart(record.theta[others], alone)
    if not apart.any():
        return None
    own = apart & [not repeated(complex(record.theta[k]), weights[k], alone.drive.theta, single) for k in others]
    apart = own if own.any() else apart
    decays = -record.theta.real[others]
    energy = np.where(apart, np.sum(np.abs(weights[others]) ** 2, axis=1) / decays, 0.0)
    theta = complex(record.theta[others[int(np.argmax(energy))]])
    both = maximize(record.values, alone.drive.with_pole(theta), record.noise, steps=ROUGH_STEPS)
    if both is None or both.bic >= alone.bic:
        return None
    # What forces do to a strong mode may draw the pole of a weak one away: then it is found beside the forces.
    stray = np.min(np.abs(np.log(np.abs(both.drive.theta / theta))))
    return both if stray < np.log(OTHER_FREQUENCY) else None


def beside_single(record: Record, alone: DrivenFit, residual: ComplexArray) -> list[DrivenFit]:
    """Return a single mode with each of the first other poles of the linear fit, then of a ``residual``.

    They are damped lightly and not fitted: what friction does to a strong mode draws the pole of a weak one away, or
    makes it grow.
    """
    energy = np.where(record.theta.imag > 0, np.sum(np.abs(record.amplitudes) ** 2, axis=1), 0.0)
    linear = record.theta[np.argsort(-energy)[: np.count_nonzero(energy)]]
    starts = list[DrivenFit]()
    for theta in (linear, residual):
        others = theta[_apart(theta, alone)][:OTHER_POLES]
        light = [complex(-LIGHT * abs(each), each.imag) for each in others]
        trials = (maximize(record.values, alone.drive.with_pole(each), record.noise, steps=0) for each in light)
        starts += [trial for trial in trials if trial is not None]
    return starts


def _apart(theta: ComplexArray, alone: DrivenFit) -> NDArray[np.bool_]:
    """Return which poles have another frequency than a single mode, (pole,)."""
    return np.asarray(np.abs(np.log(np.abs(theta / alone.drive.theta[0]))) > np.log(OTHER_FREQUENCY))


def _alike(one: ComplexArray, other: ComplexArray) -> bool:
    return len(one) == len(other) and bool(np.all(np.abs(one - other) < ALIKE * np.abs(other)))


def strongest(record: Record, plain: DrivenFit) -> DrivenFit:
    """Return a linear fit, or that with its two strongest poles apart where it has more: others may be distortion."""
    energy = np.sum(np.abs(plain.amplitudes) ** 2 / plain.variance, axis=1) * np.sum(np.abs(plain.states) ** 2, axis=1)
    size = np.log(np.abs(plain.drive.theta))
    kept = list[int]()
    for index in np.argsort(-energy).tolist():
        # The middle of a swing that moves with its size is no mode: it does not turn.
        turns = plain.drive.theta[index].imag > -plain.drive.theta[index].real
        if turns and len(kept) < 2 and np.all(np.abs(size[index] - size[kept]) > np.log(OTHER_FREQUENCY)):
            kept.append(index)
    fewer = plain.drive
    for index in reversed(range(len(size))):
        fewer = fewer if index in kept else fewer.without_pole(index)
    less = None
    if kept and fewer is not plain.drive:
        less = maximize(record.values, fewer, record.noise, steps=ROUGH_STEPS)
    return plain if less is None else less
