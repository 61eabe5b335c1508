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

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.forces import Force, ForceKind, forces_of, mean_sign
from suspid.identification.nonlinear.motion import Structures, steps_of
from suspid.identification.nonlinear.structure import StructureFit, evaluated, gains_of
from suspid.levels import EXACT
from suspid.units import ComplexArray, RealArray

# Half the widths of the weights, in periods of the slowest mode: narrow ones show fast modes, wide ones hide noise.
WIDTHS = (0.015, 0.03, 0.06, 0.1, 0.17, 0.3)
# Samples in half a weight at least, and its power of 1 - t^2: its first derivatives are smooth.
FEWEST_IN_HALF, WEIGHT_POWER = 4, 6
# Displacements, speeds or accelerations are measured.
ORDERS = 3
# Speeds are weighted over less: their signs turn at once.
NARROWER = 3
# Equations for each unknown, at least.
FEWEST_EQUATIONS = 5
# Widths whose starts are fitted, for each choice of where friction acts.
MOST_WIDTHS = 3
# Damping ratio in place of growth, at first: friction takes what dampers seem to give.
LIGHTLY = 0.01


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Measured:
    """Displacements (order 0), speeds (1) or accelerations (2) of masses, with offsets, (channel, sample)."""

    values: RealArray
    order: int
    moved: RealArray  # displacements, or for the other orders speeds
    least: float  # share of the accelerations of each channel that equations must tell
    longest: int  # steps of the motion of a start, at most

    @classmethod
    def of(cls, values: RealArray, order: int, theta: ComplexArray, least: float, longest: int) -> Measured:
        """Return what was measured with its motion, in which a linear fit has the exponents ``theta``.

        Offsets, and the line that they become in sums, are told from the motion by that fit.
        """
        if not order:
            return cls(values=values, order=order, moved=values, least=least, longest=longest)
        about = values - values[:, :1]
        sums = about if order == 1 else np.cumsum(about, axis=1) - 0.5 * about
        samples = np.arange(values.shape[1])
        lines = (samples / len(samples))[:, None] ** np.arange(order)
        swings = np.exp(np.outer(samples, theta))
        parts = np.linalg.lstsq(np.column_stack([lines, swings.real, swings.imag]), sums.T, rcond=None)[0]
        moved = np.asarray(sums - (lines @ parts[:order]).T)
        return cls(values=values, order=order, moved=moved, least=least, longest=longest)

    def signs(self, forces: tuple[Force, ...], half: int) -> tuple[RealArray, RealArray]:
        """Return the means of the signs of the speeds that forces follow, and the speeds, (force, sample)."""
        narrow = max(2, half // NARROWER)
        edges = np.pad(self.moved, ((0, 0), (narrow, narrow)), mode="reflect", reflect_type="odd")
        speed = _weighted(edges, _weights(narrow)[0 if self.order else 1])
        follows = np.array([speed[f.channel] - (0.0 if f.other is None else speed[f.other]) for f in forces])
        return np.array([mean_sign(each) for each in follows]), follows


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Equations:
    """Equations of motion ``x'' = -stiffness x - damping x' - slowed s + offset``, per sample, with signs ``s``."""

    stiffness: RealArray  # (channel, channel)
    damping: RealArray  # (channel, channel)
    slowed: RealArray  # (channel, force)
    forces: tuple[Force, ...]
    told: RealArray  # (channel,): share of the weighted accelerations that they tell
    signs: RealArray  # (force, sample): means of the signs of the speeds that forces follow, about each sample
    speeds: RealArray  # (force, sample): and the speeds

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


def from_equations(
    record: Record, theta: ComplexArray, *, longest: int, least: float = 0.0
) -> Iterator[list[list[StructureFit]]]:
    """Yield starts from the equations of motion with friction, as many modes as channels.

    The channels are displacements, speeds or accelerations: first what equations tell most of, then what the likeliest
    start has, then displacements. Of each, the first starts are the likeliest of each place of friction (see
    `rubbing`), then the next ones. A linear fit has the exponents ``theta``. Equations tell at ``least`` this share of
    the accelerations, and no motion takes more steps than the ``longest``.
    """
    period = 2 * np.pi / float(np.min(theta.imag))
    halves = list(dict.fromkeys(max(FEWEST_IN_HALF, round(width * period)) for width in WIDTHS))
    measured = [Measured.of(record.values, order, theta, least, longest) for order in range(ORDERS)]
    ground = [_on_the_ground(each, halves) for each in measured]
    first = int(np.argmin([_untold(equations) for equations in ground]))
    likely = {first: _likely(record, measured[first], ground[first])}
    yield _ranks(record, measured[first], likely[first], halves)
    likely |= {k: _likely(record, measured[k], ground[k]) for k in range(ORDERS) if k != first}
    losses = [min((s.loss for starts in likely[k] for s in starts.values()), default=np.inf) for k in range(ORDERS)]
    for order in dict.fromkeys((int(np.argmin(losses)), 0)):
        if order != first:
            yield _ranks(record, measured[order], likely[order], halves)


def _ranks(
    record: Record, measured: Measured, likely: list[dict[int, StructureFit]], halves: list[int]
) -> list[list[StructureFit]]:
    """Return the likeliest starts of each place of friction, then the next ones."""
    found = [
        starts | _starts(record, measured, forces, [half for half in halves if half not in starts])
        for starts in likely
        for forces in [next(iter(starts.values())).forces]
    ]
    ranks = [sorted(starts.values(), key=lambda start: start.loss) for starts in found]
    return [sorted((each[k] for each in ranks if k < len(each)), key=lambda s: s.loss) for k in range(MOST_WIDTHS)]


def _on_the_ground(measured: Measured, halves: list[int]) -> dict[int, Equations]:
    """Return the equations with friction against the ground by half the widths of the weights, where there are some."""
    forces = forces_of(ForceKind.FRICTION, len(measured.values), most=len(measured.values))
    equations = {half: equations_of(measured, forces, half) for half in halves}
    return {half: each for half, each in equations.items() if each is not None}


def _untold(ground: dict[int, Equations]) -> float:
    """Return the mean logarithm of what equations do not tell of accelerations."""
    return float(np.mean([np.sum(np.log(np.maximum(1 - each.told, EXACT))) for each in ground.values()] or [np.inf]))


def _likely(record: Record, measured: Measured, ground: dict[int, Equations]) -> list[dict[int, StructureFit]]:
    """Return starts by half widths with friction at each place: those of chains with the likeliest of the ground."""
    starts = {half: start for half, each in ground.items() if (start := _start(record, measured, each)) is not None}
    if not starts:
        return []
    half = min(starts, key=lambda half: starts[half].loss)
    chains = rubbing(ground[half].stiffness)
    return [starts, *(places for forces in chains if (places := _starts(record, measured, forces, [half])))]


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


def _starts(
    record: Record, measured: Measured, forces: tuple[Force, ...], halves: list[int]
) -> dict[int, StructureFit]:
    """Return starts with friction at a place by half the widths of the weights, where there are some."""
    equations = {half: equations_of(measured, forces, half) for half in halves}
    starts = {half: _start(record, measured, each) for half, each in equations.items() if each is not None}
    return {half: start for half, start in starts.items() if start is not None}


def _start(record: Record, measured: Measured, equations: Equations) -> StructureFit | None:
    modes = equations.modes
    if modes is None or np.min(equations.told) < measured.least:
        return None
    theta, shapes = modes
    steps = steps_of(theta, record.values.shape[1], ForceKind.FRICTION)
    if np.max(np.abs(theta)) > np.pi or steps > measured.longest:
        return None
    gains = gains_of(theta, shapes, equations.slowed)
    begins = _beginnings(record, measured.order, theta, shapes, gains, equations.signs)
    structures = Structures(
        theta=theta[None],
        shapes=(begins[:, None] * shapes)[None],
        gains=(gains / begins[:, None])[None],
        forces=equations.forces,
        scales=np.max(np.abs(equations.speeds), axis=1) + 1e-300,
    )
    return evaluated(record, structures, measured.order)


def equations_of(measured: Measured, forces: tuple[Force, ...], half: int) -> Equations | None:
    """Return the equations of least squares for what was measured, and the signs of its speeds.

    Weights are ``2 half + 1`` samples wide. None where there are too few.
    """
    values = measured.values
    count, unknowns = len(values), 2 * len(values) + len(forces) + 1
    if values.shape[1] - 2 * half < FEWEST_EQUATIONS * unknowns:
        return None
    place, speed, rise = (_weighted(values - values[:, :1], weight) for weight in _weights(half))
    # The equations of speeds and accelerations are derivatives of those of displacements.
    about, speeds = measured.signs(forces, half)
    signs = _weighted(about, _weights(half)[measured.order])
    stiffness, damping, slowed = np.zeros((count, count)), np.zeros((count, count)), np.zeros((count, len(forces)))
    told = np.zeros(count)
    for c in range(count):
        acts = [j for j, force in enumerate(forces) if c in (force.channel, force.other)]
        columns = np.column_stack([place.T, speed.T, signs[acts].T, np.ones(place.shape[1])])
        norms = np.linalg.norm(columns, axis=0) + 1e-300
        unit = np.linalg.lstsq(columns / norms, rise[c], rcond=None)[0]
        parts, told[c] = -unit / norms, 1 - np.var(rise[c] - columns / norms @ unit) / (np.var(rise[c]) + 1e-300)
        stiffness[c], damping[c], slowed[c, acts] = parts[:count], parts[count : 2 * count], parts[2 * count : -1]
    return Equations(
        stiffness=stiffness, damping=damping, slowed=slowed, forces=forces, told=told, signs=about, speeds=speeds
    )


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
    record: Record, order: int, theta: ComplexArray, shapes: ComplexArray, gains: ComplexArray, signs: RealArray
) -> ComplexArray:
    """Return the states of modes at the first sample that fit a record best beside what friction adds, (pole,)."""
    from scipy.signal import lfilter

    samples = np.arange(record.values.shape[1])
    free = np.exp(np.outer(theta, samples))
    pushed = np.zeros(free.shape, complex)
    for k, each in enumerate(theta):
        push = (gains[k] @ signs)[:-1]
        pushed[k, 1:] = lfilter([np.expm1(each) / each], [1, -np.exp(each)], push)
    seen = shapes * theta[:, None] ** order
    moved = (seen.T @ pushed).real
    if order == 2:
        # A force shows in the accelerations at once.
        moved = moved + ((shapes * theta[:, None]).T @ gains).real @ signs
    fixed = np.exp(np.outer(samples, record.nuisances))
    parts = [(seen[:, c, None] * free).T for c in range(len(moved))]
    offsets = np.kron(np.eye(len(moved)), fixed)
    columns = np.column_stack(
        [np.concatenate([p.real for p in parts]), np.concatenate([-p.imag for p in parts]), offsets]
    )
    found = np.linalg.lstsq(columns, (record.values - moved).ravel(), rcond=None)[0]
    return np.asarray(found[: len(theta)] + 1j * found[len(theta) : 2 * len(theta)])
