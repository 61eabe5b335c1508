"""Starts of a fit with friction from the equations of motion: their coefficients are regressed on the record.

Friction hides modes from a linear fit, and of those that it finds the damping. In the equations, multiplied by smooth
weights and integrated by parts, stiffness, damping and friction are linear in what was measured.

References
----------
Shinbrot, M. (1954). On the analysis of linear and nonlinear dynamical systems from transient-response data. NACA TN
3288.
Messenger, D. A. and Bortz, D. M. (2021). Weak SINDy for partial differential equations. J. Comput. Phys. 443, 110525.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.forces import Force, mean_sign
from suspid.identification.nonlinear.motion import Structures
from suspid.identification.nonlinear.structure import StructureFit, evaluated, gains_of
from suspid.units import ComplexArray, RealArray

# Half the widths of the weights, in periods of the slowest mode: narrow ones show fast modes, wide ones hide noise.
WIDTHS = (0.03, 0.06, 0.1, 0.17, 0.3)
# Samples in half a weight at least, and its power of 1 - t^2: its first derivatives are smooth.
FEWEST_IN_HALF, WEIGHT_POWER = 4, 6
# Speeds are weighted over less: their signs turn at once.
NARROWER = 3
# Equations for each unknown, at least.
FEWEST_EQUATIONS = 5
# Widths whose starts are fitted, for each choice of where friction acts.
MOST_WIDTHS = 3
# Damping ratio in place of growth, at first: friction takes what dampers seem to give.
LIGHTLY = 0.01


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Equations:
    """Equations of motion ``x'' = -stiffness x - damping x' - slowed s + offset``, per sample, with signs ``s``."""

    stiffness: RealArray  # (channel, channel)
    damping: RealArray  # (channel, channel)
    slowed: RealArray  # (channel, force)

    @property
    def modes(self) -> tuple[ComplexArray, ComplexArray] | None:
        """Poles (pole,) and displacements (pole, channel) of the modes, as many as channels; None where some do not."""
        count = len(self.stiffness)
        upper = np.concatenate([np.zeros((count, count)), np.eye(count)], axis=1)
        values, vectors = np.linalg.eig(np.concatenate([upper, -np.concatenate([self.stiffness, self.damping], 1)]))
        turning = np.flatnonzero(values.imag > 0)
        if len(turning) < count:
            return None
        turning = turning[np.argsort(np.abs(values[turning]))]
        theta = values[turning]
        light = np.where(theta.real < 0, theta.real, -LIGHTLY * np.abs(theta))
        return np.asarray(light + 1j * theta.imag), np.asarray(vectors[:count, turning].T)


def from_equations(record: Record, places: tuple[tuple[Force, ...], ...], turn: float) -> list[list[StructureFit]]:
    """Return starts from the equations of displacements with friction at some places, as many modes as channels.

    The first starts are the likeliest of each, then the next ones. The slowest mode turns by about ``turn`` from sample
    to sample [rad].
    """
    period, found = 2 * np.pi / turn, [list[StructureFit]() for _ in range(MOST_WIDTHS)]
    halves = dict.fromkeys(max(FEWEST_IN_HALF, round(width * period)) for width in WIDTHS)
    for forces in places:
        starts = (start for half in halves if (start := _start(record, forces, half)) is not None)
        for rank, start in zip(found, sorted(starts, key=lambda start: start.loss), strict=False):
            rank.append(start)
    return [sorted(rank, key=lambda start: start.loss) for rank in found]


def _start(record: Record, forces: tuple[Force, ...], half: int) -> StructureFit | None:
    signs, speeds = _signs(record.values, forces, half)
    equations = equations_of(record.values, signs, forces, half)
    modes = None if equations is None else equations.modes
    if equations is None or modes is None:
        return None
    theta, shapes = modes
    if np.max(np.abs(theta)) > np.pi:
        return None
    gains = gains_of(theta, shapes, equations.slowed)
    begins = _beginnings(record, theta, shapes, gains, signs)
    structures = Structures(
        theta=theta[None],
        shapes=(begins[:, None] * shapes)[None],
        gains=(gains / begins[:, None])[None],
        forces=forces,
        scales=np.max(np.abs(speeds), axis=1) + 1e-300,
    )
    return evaluated(record, structures, 0)


def equations_of(values: RealArray, signs: RealArray, forces: tuple[Force, ...], half: int) -> Equations | None:
    """Return the equations of least squares for displacements (channel, sample) and signs of speeds (force, sample).

    Weights are ``2 half + 1`` samples wide. None where there are too few.
    """
    count, unknowns = len(values), 2 * len(values) + len(forces) + 1
    if values.shape[1] - 2 * half < FEWEST_EQUATIONS * unknowns:
        return None
    place, speed, rise = (_weighted(values - values[:, :1], weight) for weight in _weights(half))
    signs = _weighted(signs, _weights(half)[0])
    stiffness, damping, slowed = np.zeros((count, count)), np.zeros((count, count)), np.zeros((count, len(forces)))
    for c in range(count):
        acts = [j for j, force in enumerate(forces) if c in (force.channel, force.other)]
        columns = np.column_stack([place.T, speed.T, signs[acts].T, np.ones(place.shape[1])])
        norms = np.linalg.norm(columns, axis=0) + 1e-300
        parts = -np.linalg.lstsq(columns / norms, rise[c], rcond=None)[0] / norms
        stiffness[c], damping[c], slowed[c, acts] = parts[:count], parts[count : 2 * count], parts[2 * count : -1]
    return Equations(stiffness=stiffness, damping=damping, slowed=slowed)


def _signs(values: RealArray, forces: tuple[Force, ...], half: int) -> tuple[RealArray, RealArray]:
    """Return the means of the signs of the speeds that forces follow, and the speeds, (force, sample)."""
    narrow = max(2, half // NARROWER)
    edges = np.pad(values, ((0, 0), (narrow, narrow)), mode="reflect", reflect_type="odd")
    speed = _weighted(edges, _weights(narrow)[1])
    follows = np.array([speed[f.channel] - (0.0 if f.other is None else speed[f.other]) for f in forces])
    return np.array([mean_sign(each) for each in follows]), follows


def _weights(half: int) -> RealArray:
    """Return a weight of sum 1, and weights that give speeds and accelerations, (derivative, sample)."""
    t = np.arange(-half, half + 1) / (half + 1)
    base = 1 - t**2
    first = 2 * WEIGHT_POWER * t * base ** (WEIGHT_POWER - 1)
    second = 4 * WEIGHT_POWER * (WEIGHT_POWER - 1) * t**2 * base ** (WEIGHT_POWER - 2) - 2 * WEIGHT_POWER * base ** (
        WEIGHT_POWER - 1
    )
    total = np.sum(base**WEIGHT_POWER)
    return np.asarray(np.stack([base**WEIGHT_POWER, first / (half + 1), second / (half + 1) ** 2]) / total)


def _weighted(values: RealArray, weight: RealArray) -> RealArray:
    """Return the sums of values (row, sample) under a weight, wherever it has room."""
    return np.array([np.convolve(row, weight[::-1], mode="valid") for row in values])


def _beginnings(
    record: Record, theta: ComplexArray, shapes: ComplexArray, gains: ComplexArray, signs: RealArray
) -> ComplexArray:
    """Return the states of modes at the first sample that fit a record best beside what friction adds, (pole,)."""
    from scipy.signal import lfilter

    samples = np.arange(record.values.shape[1])
    free = np.exp(np.outer(theta, samples))
    pushed = np.zeros(free.shape, complex)
    for k, each in enumerate(theta):
        push = (gains[k] @ signs)[:-1]
        pushed[k, 1:] = lfilter([np.expm1(each) / each], [1, -np.exp(each)], push)
    moved = (shapes.T @ pushed).real
    fixed = np.exp(np.outer(samples, record.nuisances))
    parts = [(shapes[:, c, None] * free).T for c in range(len(moved))]
    offsets = np.kron(np.eye(len(moved)), fixed)
    columns = np.column_stack(
        [np.concatenate([p.real for p in parts]), np.concatenate([-p.imag for p in parts]), offsets]
    )
    found = np.linalg.lstsq(columns, (record.values - moved).ravel(), rcond=None)[0]
    return np.asarray(found[: len(theta)] + 1j * found[len(theta) : 2 * len(theta)])
