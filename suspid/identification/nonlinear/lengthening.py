"""Forces found in the beginning of a record, followed on to its end.

The frequency of a pendulum from a large angle, or of a mass on a spring that bends, shifts by many times the width of
its line: over the whole record no single pole follows it, and no fit finds its way from one. Over a few cycles one
does. There the forces are found; then the stretch is made longer step by step, each fit from the one before.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from suspid.identification.nonlinear.driven import DrivenFit, maximize
from suspid.identification.nonlinear.feedback import (
    LEAST_PART,
    ROUGH_STEPS,
    SLOW,
    Bent,
    Record,
    added,
    renewed,
    with_further,
)
from suspid.identification.nonlinear.forces import Force, ForceKind, means
from suspid.units import RealArray

Sample = TypeVar("Sample", np.float64, np.complex128)
# Cycles by which a record is continued at both ends before its Fourier series is taken, and the highest
# frequency of that, over the one of the mode: a spring that bends gives the third multiple.
PADDED, HIGHEST_MULTIPLE = 3, 4.5
# How much longer a stretch is than the one before. A larger step may lose the phase, a smaller one costs time.
STRETCHED = 1.25


def lengthened(record: Record, plain: DrivenFit) -> Bent | None:
    """Return the fit to a record of a single mode that its stiffness shifts, from a linear fit to its beginning.

    A spring that bends shifts it, and what else acts shows when the whole record is fitted. Whether the samples are
    displacements, speeds or accelerations does not show before, either. None if no such fit follows the record.
    """
    found, short = list[Bent](), record.begun(plain.residual.shape[1])
    for order in range(3):
        motions = _measured(record.values, order, float(plain.drive.theta[0].imag))
        early = motions[0][:, : short.values.shape[1]], motions[1][:, : short.values.shape[1]]
        start = added(short, Bent(fit=plain, forces=(), order=order), ForceKind.CUBIC, early)
        fit = None if start is None else maximize(short.values, start.fit.drive, short.noise, steps=ROUGH_STEPS)
        whole = None if start is None or fit is None else _followed(record, replace(start, fit=fit), motions)
        found += [] if whole is None else [whole]
    best = min(found, key=lambda bent: bent.fit.bic, default=None)
    return None if best is None else with_further(record, best)


def at_full_rate(record: Record, found: Bent, factor: int, turn: float) -> Bent | None:
    """Return the fit to a record of what was found in means over several samples, with forces as it was measured."""
    motions, forces = _measured(record.values, found.order, turn), list[RealArray]()
    for force in found.forces:
        raw, columns = force.sampled(*motions), means(np.array([_between(force, each) for each in motions])).T
        rest = raw - columns @ np.linalg.lstsq(columns, raw, rcond=None)[0]
        forces.append(rest / max(_size(rest), LEAST_PART))
    drive = found.fit.drive
    start = replace(
        drive,
        theta=drive.theta / factor,
        gains=drive.gains / factor,
        forces=np.array(forces).reshape(len(forces), record.values.shape[1]),
        nuisances=record.nuisances,
    )
    fit = maximize(record.values, start, record.noise, steps=ROUGH_STEPS)
    return None if fit is None else replace(found, fit=fit)


def _measured(values: RealArray, order: int, turn: float) -> tuple[RealArray, RealArray]:
    """Return displacements and speeds of the channels (channel, sample) as measured: samples of the given order.

    Derivatives and integrals are those of their Fourier series, of the frequencies about the mode and its multiples.
    """
    count = values.shape[1]
    cycle = int(2 * np.pi / turn)
    pad = min(count - 2 * cycle, PADDED * cycle)
    after, before = _continued(values, cycle, pad), _continued(values[:, ::-1], cycle, pad)[:, ::-1]
    series = np.fft.rfft(np.concatenate([before, values, after], axis=1))
    omega = 2 * np.pi * np.fft.rfftfreq(count + 2 * pad)
    used = (omega > SLOW * turn) & (omega < HIGHEST_MULTIPLE * turn)
    rates = np.where(used, 1j * omega, 1.0)
    motion, speed = (
        np.fft.irfft(np.where(used, series * rates**power, 0.0), count + 2 * pad, axis=1)[:, pad : pad + count]
        for power in (-order, 1 - order)
    )
    return np.asarray(motion), np.asarray(speed)


def _continued(values: RealArray, cycle: int, more: int) -> RealArray:
    """Return further samples behind given ones: those before the last turn, which a swing back has again."""
    strongest = int(np.argmax(np.sum(values**2, axis=1)))
    last = values.shape[1] - 1
    turn = last - int(np.argmax(np.abs(values[strongest, : last - cycle : -1])))
    first = 2 * turn - last - 1
    return values[:, first : first - more : -1]


def _followed(record: Record, found: Bent, motions: tuple[RealArray, RealArray]) -> Bent | None:
    """Return the fit to a record with the forces that were found in its beginning; None if it fails.

    On each stretch a force is the sum of what is proportional to the motion over it, which belongs to the pole, and the
    rest. A longer stretch has other shares, so that the pole changes by what moves between the two.
    """
    whole, count = record.values.shape[1], found.fit.residual.shape[1]
    while count < whole:
        before, count = count, min(whole, int(STRETCHED * count) + 1)
        fit = _longer(record.begun(count), found, before, (motions[0][:, :count], motions[1][:, :count]))
        if fit is None:
            return None
        found = replace(found, fit=fit)
    return renewed(record, found)


def _longer(record: Record, found: Bent, before: int, motions: tuple[RealArray, RealArray]) -> DrivenFit | None:
    """Return the fit to a stretch from that to its first samples."""
    old = found.fit.drive
    theta, gains = complex(old.theta[0]), old.gains.copy()
    shapes = found.fit.amplitudes[0] * theta**-found.order
    left = []
    for j, force in enumerate(found.forces):
        raw = force.sampled(*motions)
        columns = means(np.array([_between(force, each) for each in motions])).T
        early, late = (np.linalg.lstsq(columns[:n], raw[:n], rcond=None)[0] for n in (before, len(raw)))
        rest = raw - columns @ late
        size, was = _size(rest), _size(raw[:before] - columns[:before] @ early)
        if min(size, was) < LEAST_PART:
            return None
        stiffness, damping = (late - early) * old.gains[0, j] / was
        theta += (stiffness + damping * complex(old.theta[0])) * complex(_between(force, shapes)) / 2
        gains[0, j] *= size / was
        left.append(rest / size)
    start = replace(old, theta=np.array([theta]), gains=gains, forces=np.array(left), nuisances=record.nuisances)
    return maximize(record.values, start, record.noise, steps=ROUGH_STEPS)


def _between(force: Force, each: NDArray[Sample]) -> NDArray[Sample]:
    """Return what the channels of a force differ by."""
    return np.asarray(each[force.channel] - (0 if force.other is None else each[force.other]))


def _size(values: RealArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
