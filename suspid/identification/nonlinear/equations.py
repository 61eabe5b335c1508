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
from suspid.identification.nonlinear.forces import Force, ForceKind, forces_of, mean_sign
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


def from_equations(record: Record, turn: float) -> list[list[StructureFit]]:
    """Return starts from the equations of displacements with friction, as many modes as channels.

    The first starts are the likeliest of each place of friction (see `rubbing`), then the next ones. The slowest mode
    turns by about ``turn`` from sample to sample [rad].
    """
    period, values = 2 * np.pi / turn, record.values
    halves = list(dict.fromkeys(max(FEWEST_IN_HALF, round(width * period)) for width in WIDTHS))
    ground = forces_of(ForceKind.FRICTION, len(values), most=len(values))
    first = _starts(record, ground, halves)
    if not first:
        return []
    half = min(first, key=lambda half: first[half].loss)
    equations = equations_of(values, _signs(values, ground, half)[0], ground, half)
    chains = rubbing(equations.stiffness) if equations is not None else ()
    found = [first, *(_starts(record, chain, halves) for chain in chains)]
    ranks = [sorted(starts.values(), key=lambda start: start.loss) for starts in found]
    return [sorted((each[k] for each in ranks if k < len(each)), key=lambda s: s.loss) for k in range(MOST_WIDTHS)]


def rubbing(stiffness: RealArray) -> tuple[tuple[Force, ...], ...]:
    """Return where friction acts in the struts of a chain: each channel may be the mass on the ground.

    From there on the chain goes to the mass that is coupled most, (channel, channel) stiffness over masses. That on
    which the ground acts most comes first.

    Examples
    --------
    >>> [[(force.channel, force.other) for force in forces] for forces in rubbing(np.array([[5.0, -2.0], [-3.0, 3.0]]))]
    [[(0, None), (1, 0)], [(1, None), (0, 1)]]
    """
    coupled = np.abs(stiffness * stiffness.T)
    chains = list[tuple[Force, ...]]()
    for lower in np.argsort(-np.sum(stiffness, axis=1)).tolist():
        chain, left = [lower], set(range(len(stiffness))) - {lower}
        while left:
            chain.append(max(left, key=lambda other: (coupled[chain[-1], other], -other)))
            left.remove(chain[-1])
        links = zip(chain, (None, *chain), strict=False)
        chains.append(tuple(Force(kind=ForceKind.FRICTION, channel=c, other=below) for c, below in links))
    return tuple(chains)


def _starts(record: Record, forces: tuple[Force, ...], halves: list[int]) -> dict[int, StructureFit]:
    """Return starts with friction at a place by half the widths of the weights, where there are some."""
    starts = {half: _start(record, forces, half) for half in halves}
    return {half: start for half, start in starts.items() if start is not None}


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
    second = 2 * WEIGHT_POWER * base ** (WEIGHT_POWER - 2) * (2 * (WEIGHT_POWER - 1) * t**2 - base)
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
