"""From modes back to springs and dampers, for known masses and topology."""

from __future__ import annotations

import contextlib
import functools
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError, ReconstructionError
from suspid.modes import ModalSet, eigenmodes
from suspid.suspension import Suspension
from suspid.units import ComplexArray, NewtonPerMetre, NewtonSecondPerMetre, Ratio, RealArray
from suspid.values import FrozenMapping, nearest_names, rounded, spread, text_table

SOLVER = "CLARABEL"
QUANTITIES = ("stiffness", "damping")
LEAST_STIFFNESS = 1e-6  # of nominal: k > 0 as a closed bound
LARGEST_STEP = 0.5  # in log k, and in c w / k
STARTS = 25
EXACT = 1e-8  # relative error of poles that counts as none
BLIND = 1e-8  # of the largest singular value: what the data do not see
SHAPE_WEIGHT = 0.1  # of errors of shapes against relative errors of poles, which are always known better
LEAST_MAC = 0.8  # below it a shape is another mode's

# Residual and its derivatives by the unknowns, at the unknowns.
Equations: TypeAlias = Callable[[RealArray], tuple[RealArray, RealArray]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Reconstruction:
    """The suspension whose modes are the given ones.

    Parameters
    ----------
    suspension : Suspension
        Springs and dampers found, with the masses and the topology that were known.
    stiffness_std, damping_std : mapping of str to float, or None
        Standard deviations [N/m], [N s/m] by strut, to first order from the covariance of the modes; 0 for what was
        held, and as if no bound were there for what ends on one. None if the modes carry no covariance.
    alternatives : tuple of Suspension
        Other suspensions with the same modes.
    residual : float
        Distance of a pole of `suspension` from the given one, relative to the latter; the worst mode [1].
    status : str
        How it was found, and what to know about it.
    held : tuple of str
        The strut parameters held at their nominal values, such as ``"tire.damping"``.
    """

    suspension: Suspension
    stiffness_std: Mapping[str, NewtonPerMetre] | None
    damping_std: Mapping[str, NewtonSecondPerMetre] | None
    alternatives: tuple[Suspension, ...] = ()
    residual: Ratio
    status: str
    held: tuple[str, ...] = ()

    def __str__(self) -> str:
        struts = self.suspension.struts
        columns: dict[str, Sequence[str]] = {"strut": [s.name for s in struts]}
        for quantity, unit, stds in (("stiffness", "N/m", self.stiffness_std), ("damping", "N s/m", self.damping_std)):
            values = np.array([getattr(s, quantity) for s in struts])
            columns[f"{quantity} [{unit}]"] = [f"{value:.7g}" for value in values]
            if stds is not None:
                known = np.array([stds[s.name] for s in struts])
                columns[f"{quantity} [{unit}]"] = rounded(values, known)
                columns[f"± [{unit}]"] = [spread(std) for std in known]
        if self.held:
            names = {s.name: [q for q in QUANTITIES if f"{s.name}.{q}" in self.held] for s in struts}
            columns["held"] = [", ".join(held) for held in names.values()]
        return f"{text_table(columns)}\n{self.status}"


def reconstruct(
    modes: ModalSet, suspension: Suspension, *, fixed: Sequence[str] = (), tolerance: Ratio = 0.02
) -> Reconstruction:
    """Find the stiffness and the damping of every strut from modes, for known masses and topology.

    With shapes at all coordinates, ``(lambda^2 M + lambda C + K) psi = 0`` is linear in k and c: one convex program,
    which needs no start; of modes that are not exact, it is itself the start of a sequence. Otherwise the poles (and
    the shapes at some coordinates, if there are two at least) are met by a sequence of convex programs from the nominal
    suspension; should that end short of the modes, from others spread reproducibly around it. Always k > 0 and c >= 0.

    Modes with a covariance are weighted by it; without one, relative errors of poles count ten times those of shapes.
    If it covers the poles alone, the shapes choose the suspension and the poles alone set its numbers, provided that
    they can.

    Parameters
    ----------
    modes : ModalSet
        The modes, in any order of the coordinates and any scale of the shapes. Shapes are used if their channels are
        named as coordinates. Poles at zero (rigid-body motion) say nothing about k and c and are only checked.
    suspension : Suspension
        Known masses and topology; its k and c are the nominal values: the start, the scale, and the value of what is
        held. A strut of nominal stiffness 0 is a damper alone and stays one.
    fixed : sequence of str
        Strut parameters held at their nominal value: ``"tire.damping"``, or ``"tire"`` for both of a strut's.
    tolerance : float
        Largest distance of a reconstructed pole from the given one, relative to the latter, that is accepted [1]; five
        standard deviations of the pole are accepted as well.

    Returns
    -------
    Reconstruction
        ``suspension``, ``stiffness_std``, ``damping_std``, ``residual``, ``status``; ``str()`` is the table.

    Raises
    ------
    InputError
        If an argument is of the wrong type, a name in ``fixed`` is unknown, there are more poles than the suspension
        has, or a pole or a shape cannot be used.
    ReconstructionError
        If there are fewer equations than unknowns, if the modes do not determine some parameters (which are named), or
        if no suspension of this topology with k > 0 and c >= 0 has these modes. ``best`` is the nearest one met.

    Notes
    -----
    From w and zeta alone several suspensions may have the same modes; the one reached from the nominal values is
    returned. Shapes, or a parameter held, decide.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> nominal = car.with_parameters(stiffness={"chassis": 15e3, "tire": 250e3}, damping={"chassis": 1000})
    >>> print(reconstruct(eigenmodes(car), nominal, fixed=["tire.damping"]))  # doctest: +ELLIPSIS
      strut    stiffness [N/m]    damping [N s/m]     held
    -------  -----------------  -----------------  -------
    chassis              20000               1500
       tire             200000                  0  damping
    one convex program on poles and shapes; worst pole off by ...
    """
    problem, notes = _posed(modes, suspension, fixed)
    best, cost, again = problem.nominal, np.inf, 0
    for tried, start in enumerate(_starts(problem)):
        x = start if problem.exact(start) else _descend(problem, problem.deciding, start)
        reached = float(np.linalg.norm(problem.deciding(x)[0]))
        again = again + 1 if abs(reached - cost) <= 1e-6 * cost else 0 if reached < cost else again
        if reached < cost:
            best, cost = x, reached
        if cost <= problem.enough or problem.exact(x) or (tried >= 12 and again >= 3):
            break
    car = problem.suspension(best)
    _check_seen(problem, best, car)
    residual, mac = _check_fit(problem, modes, car, tolerance)
    if mac is not None and not problem.exact(best):
        notes.append(f"least MAC of the shapes {mac:.4f}")
    ends = [name for name, x, low in zip(problem.names, best, problem.lower, strict=True) if x <= low * (1 + 1e-9)]
    if ends and cost > EXACT:
        notes.append(f"held back by its bound: {', '.join(ends)}")
    stiffness_std, damping_std = _spread(problem, best)
    return Reconstruction(
        suspension=car,
        stiffness_std=stiffness_std,
        damping_std=damping_std,
        residual=residual,
        status="; ".join([problem.manner(best), f"worst pole off by {residual:.1e} of its modulus", *notes]),
        held=tuple(n for n in _parameter_names(suspension) if n not in problem.names),
    )


def pole_distances(a: ComplexArray, b: ComplexArray) -> RealArray:
    """Return ``|a - b| / max(|a|, |b|)`` of every pole of ``a`` from every pole of ``b``; 0 for two zeros.

    Examples
    --------
    >>> pole_distances(np.array([4j, 10j]), np.array([5j])).round(3)
    array([[0.2],
           [0.5]])
    """
    larger = np.maximum(np.abs(a)[:, None], np.abs(b))
    return np.asarray(np.abs(a[:, None] - b) / np.where(larger > 0, larger, 1.0))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Problem:
    """Modes, and a suspension with unknowns x: k over nominal and c over a scale, of what is free.

    Everything inside is dimensionless: coordinates are scaled by the roots of the masses, equations by the poles.
    """

    car: Suspension
    names: tuple[str, ...]
    struts: list[int]  # of each unknown
    springs: NDArray[np.bool_]  # which unknowns are stiffnesses
    scale: RealArray  # of each unknown [N/m or N s/m]
    poles: ComplexArray  # those not at zero
    rigid: int  # how many are
    real: NDArray[np.bool_]  # overdamped: no imaginary part, nor one of its shape
    shapes: ComplexArray | None  # (observed coordinate, mode)
    observed: list[int]  # coordinates of the shapes, by index
    whiten: RealArray | None  # makes what `sensitivities` returns uncorrelated and of variance 1
    poles_alone: bool  # have a covariance

    @property
    def full(self) -> bool:
        return self.shapes is not None and len(self.observed) == len(self.car.coordinates)

    @property
    def nominal(self) -> RealArray:
        k, c = _parameters(self.car)
        return np.where(self.springs, k[self.struts], c[self.struts]) / self.scale

    @property
    def lower(self) -> RealArray:
        return np.where(self.springs, LEAST_STIFFNESS, 0.0)

    @property
    def arms(self) -> RealArray:
        return np.asarray(self.car.arms(self.car.coordinates) / np.sqrt(np.diag(self.car.M)))

    @property
    def enough(self) -> float:
        """Norm of the deciding residual at which no other start is tried."""
        from scipy.special import chdtri

        if self.whiten is None:
            return EXACT  # of exact modes; with modes that are not, every start is tried
        return float(np.sqrt(chdtri(max(len(self.whiten) - len(self.names), 1), 1e-4)))

    def physical(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return k [N/m] and c [N s/m] of every strut."""
        k, c = _parameters(self.car)
        index = np.array(self.struts)
        k[index[self.springs]] = (x * self.scale)[self.springs]
        c[index[~self.springs]] = (x * self.scale)[~self.springs]
        return k, c

    def suspension(self, x: RealArray) -> Suspension:
        k, c = self.physical(x)
        names = [s.name for s in self.car.struts]
        return self.car.with_parameters(
            stiffness=dict(zip(names, k.tolist(), strict=True)), damping=dict(zip(names, c.tolist(), strict=True))
        )

    def rates(self, poles: ComplexArray) -> ComplexArray:
        """Return the derivative of ``k + pole c`` of its strut by each unknown, (mode, unknown)."""
        return np.asarray(np.where(self.springs, 1.0 + 0j, poles[:, None]) * self.scale)

    def real_rows(self, values: ComplexArray | RealArray, which: NDArray[np.bool_]) -> RealArray:
        """Return real and imaginary parts as rows, without the imaginary parts of ``which``."""
        return np.concatenate([values.real, values.imag[~which]])

    def manner(self, x: RealArray) -> str:
        """Return how x was found, in words."""
        if self.full:
            return "one convex program on poles and shapes" + ", refined by a sequence" * (not self.exact(x))
        return "sequence of convex programs on poles" + " and shapes" * (self.shapes is not None)

    def exact(self, x: RealArray) -> bool:
        """Return whether full shapes, taken as exact, leave nothing to improve."""
        return self.full and self.whiten is None and bool(np.linalg.norm(self.linear(x)[0]) <= EXACT)

    def deciding(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual that judges x, weighted, and its derivatives."""
        if self.whiten is None and self.shapes is None:
            return self.spectral(x)
        residual, slope = self.sensitivities(x)
        if self.whiten is None:
            weights = np.where(np.arange(len(residual)) < _pole_equations(self.real), 1.0, SHAPE_WEIGHT)
            return weights * residual, weights[:, None] * slope
        return self.whiten @ residual, self.whiten @ slope

    def linear(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return ``(lambda^2 M + lambda C + K) psi``, relative to its first term: linear in x."""
        assert self.shapes is not None
        order = np.argsort(self.observed)
        motion = self.shapes[order].T * np.sqrt(np.diag(self.car.M))  # (mode, coordinate)
        motion = motion / np.linalg.norm(motion, axis=1, keepdims=True)
        k, c = self.physical(x)
        travel = motion @ self.arms.T  # (mode, strut)
        forces = (k + self.poles[:, None] * c) * travel
        inertia = self.poles[:, None] ** 2
        residual = motion + forces @ self.arms / inertia
        slope = (
            (self.rates(self.poles) * travel[:, self.struts])[:, :, None] * self.arms[self.struts] / inertia[:, None]
        )
        real = np.repeat(self.real, len(self.car.coordinates))
        columns = np.moveaxis(slope, 1, 2).reshape(len(real), -1)
        return self.real_rows(residual.ravel(), real), self.real_rows(columns, real)

    def spectral(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return ``det(lambda^2 M + lambda C + K)`` at the given poles, and its derivatives.

        Divided by the product of the distances to all other poles it is, near a solution, the relative error of
        the pole; being a polynomial, it needs no pairing of poles and does not mind pairs turning overdamped.
        """
        k, c = self.physical(x)
        n = len(self.car.coordinates)
        nodes, target, spacing = self.nodes()
        forces = k + nodes[:, None] * c
        dynamic = nodes[:, None, None] ** 2 * np.eye(n) + np.einsum("ms,si,sj->mij", forces, self.arms, self.arms)
        U, S, Vh = np.linalg.svd(dynamic)
        others = np.array([np.prod(np.delete(S, i, axis=1), axis=1) for i in range(n)]).T
        turn = np.linalg.det(U) * np.linalg.det(Vh)
        adjugate = (Vh.conj().swapaxes(1, 2) * others[:, None, :]) @ U.conj().swapaxes(1, 2)
        per_force = np.einsum("si,mij,sj->ms", self.arms, adjugate, self.arms)
        slope = (turn / spacing)[:, None] * per_force[:, self.struts] * self.rates(nodes)
        residual = (turn * np.prod(S, axis=1) - target) / spacing
        return self.real_rows(residual, self.real), self.real_rows(slope, self.real)

    def nodes(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return where `spectral` takes the determinant, what it should be there, and what it is divided by.

        These are the poles, and zero. Where poles meet (critical damping), the value at one says nothing of the
        others: as long as all poles are known, points around them do as well.
        """
        n, size = len(self.car.coordinates), np.abs(self.poles)
        everything = _all_poles(np.concatenate([self.poles, np.zeros(self.rigid)]))
        if len(everything) < 2 * n:
            return self.poles, np.zeros_like(self.poles), np.asarray(self.poles / size * size ** (2 * n))
        near = 0.02 * size
        nodes = np.where(self.real, self.poles, self.poles.real + 1j * np.maximum(self.poles.imag, near))
        for i in range(1, len(nodes)):
            while np.any(np.abs(nodes[:i] - nodes[i]) < near[i]):
                nodes[i] *= 1.03
        target = np.prod(nodes[:, None] - everything, axis=1)
        target[nodes == self.poles] = 0.0
        gaps = nodes[:, None] - np.concatenate([nodes, nodes[~self.real].conj(), np.zeros(self.rigid)])
        gaps[np.arange(len(nodes)), np.arange(len(nodes))] = size
        return nodes, target, np.asarray(np.prod(gaps, axis=1))

    def sensitivities(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return relative errors of the poles and errors of the shapes (if weighed), and derivatives of both."""
        k, c = self.physical(x)
        n, roots = len(self.car.coordinates), np.sqrt(np.diag(self.car.M))
        damping, stiffness = self.arms.T * c @ self.arms, self.arms.T * k @ self.arms
        found, vectors = np.linalg.eig(
            np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]]).astype(complex)
        )
        partner = _nearest(self.poles, found)
        pole, motion = found[partner], vectors[:n, partner].T
        modes = np.arange(len(pole))
        shapes = self.weighed_shapes
        largest = np.argmax(np.abs(motion if shapes is None else shapes.T), axis=1)
        reference = largest if shapes is None else np.array(self.observed)[largest]
        at = motion[modes, reference]
        motion = motion / np.where(np.abs(at) > 1e-12, at, 1e-12)[:, None]
        # Poles and shapes together: the dynamic matrix bordered by "the reference coordinate does not move".
        bordered = np.zeros((len(pole), n + 1, n + 1), complex)
        bordered[:, :n, :n] = pole[:, None, None] ** 2 * np.eye(n) + pole[:, None, None] * damping + stiffness
        bordered[:, :n, n] = 2 * pole[:, None] * motion + motion @ damping
        bordered[modes, n, reference] = 1.0
        travel = (motion @ self.arms.T)[:, self.struts] * self.rates(pole)  # (mode, unknown)
        load = np.zeros((len(pole), n + 1, len(self.names)), complex)
        load[:, :n] = -np.einsum("mp,pi->mip", travel, self.arms[self.struts])
        slope = np.asarray(np.linalg.pinv(bordered) @ load, complex)
        size = np.abs(self.poles)
        errors = [self.real_rows((pole - self.poles) / size, self.real)]
        slopes = [self.real_rows(slope[:, n] / size[:, None], self.real)]
        if shapes is not None:
            rows = self.observed
            scale = (roots[reference][:, None] / roots[rows])[:, :, None]  # from scaled coordinates to displacements
            ratio = shapes.T / shapes.T[modes, largest][:, None]
            others = np.arange(len(rows)) != largest[:, None]
            error = (motion[:, rows] * scale[:, :, 0] - ratio)[others]
            real = np.repeat(self.real, len(rows) - 1)
            errors.append(self.real_rows(error, real))
            slopes.append(self.real_rows((slope[:, rows] * scale)[others], real))
        return np.concatenate(errors), np.concatenate(slopes)

    @property
    def weighed_shapes(self) -> ComplexArray | None:
        """The shapes, unless the poles alone have a covariance."""
        return None if self.poles_alone else self.shapes


def _posed(modes: ModalSet, suspension: Suspension, fixed: Sequence[str]) -> tuple[_Problem, list[str]]:
    """Return the checked, dimensionless problem, and what to tell about it."""
    for value, kind in ((modes, ModalSet), (suspension, Suspension)):
        if not isinstance(value, kind):
            part = "modes" if kind is ModalSet else "suspension"
            hint = f"; take its .{part}" if hasattr(value, part) else ""
            raise InputError(f"reconstruct needs a {kind.__name__} here, not {type(value).__name__}{hint}")
    n, total = len(suspension.coordinates), len(_all_poles(modes.poles))
    if total > 2 * n:
        raise InputError(
            f"the modes hold {total} poles (a pair counts twice), but {n} masses have {2 * n}; "
            f"leave out modes that are not the suspension's"
        )
    moving = modes.poles != 0
    names = _free_names(suspension, fixed)
    struts = [[s.name for s in suspension.struts].index(name.split(".")[0]) for name in names]
    springs = np.array([name.endswith("stiffness") for name in names])
    k, _ = _parameters(suspension)
    poles, real = modes.poles[moving], modes.poles[moving].imag == 0
    if not len(poles):
        raise InputError(f"of {len(modes)} modes none says anything about k and c; give modes that are not rigid")
    rate = float(np.exp(np.mean(np.log(np.abs(poles)))))
    scale = np.where(springs, k[struts], np.where(k > 0, k, np.max(k, initial=0.0) or 1.0)[struts] / rate)
    shapes, observed, notes = _usable_shapes(modes, suspension, moving)
    unknowns = len(names)
    per_pole, per_shape = _pole_equations(real), _pole_equations(real) * max(len(observed) - 1, 0)
    equations = per_pole + per_shape
    if equations < unknowns:
        raise ReconstructionError(
            f"{unknowns} unknowns ({', '.join(names)}) but {equations} equations from {len(poles)} modes: add modes, "
            f"or shapes at more coordinates, or hold at least {unknowns - equations} with fixed=…, such as "
            f"fixed=[{names[-1]!r}]",
            best=suspension,
        )
    poles_alone = modes.covariance is not None and (shapes is None or len(modes.covariance) == 2 * len(modes))
    weighted = modes.covariance is not None and not (poles_alone and per_pole < unknowns)
    if poles_alone and not weighted:
        notes.append("not weighted: the covariance covers the poles alone, which are too few")
    problem = _Problem(
        car=suspension,
        names=names,
        struts=struts,
        springs=springs,
        scale=scale,
        poles=poles,
        rigid=int(np.sum(~moving)),
        real=real,
        shapes=shapes,
        observed=observed,
        whiten=_whitening(modes, moving, None if poles_alone else shapes) if weighted else None,
        poles_alone=poles_alone and weighted,
    )
    meeting = pole_distances(poles, _all_poles(poles)) < 1e-4
    if problem.full and np.sum(meeting) > len(poles) and _blind_shapes(problem):
        notes.append("shapes not used: poles meet (critical damping), and their shapes with them")
        problem = replace(problem, shapes=None, observed=[])
    return problem, notes


def _free_names(suspension: Suspension, fixed: Sequence[str]) -> tuple[str, ...]:
    """Return the unknowns: every parameter but those held and the springs that are none."""
    every = _parameter_names(suspension)
    struts = {s.name: s for s in suspension.struts}
    held = {f"{name}.stiffness" for name, strut in struts.items() if strut.stiffness == 0}
    for name in [fixed] if isinstance(fixed, str) else fixed:
        if name not in every and name not in struts:
            raise InputError(f"fixed: there is no strut parameter {name!r}.{nearest_names(name, [*every, *struts])}")
        held |= {name} if name in every else {f"{name}.{q}" for q in QUANTITIES}
    free = tuple(name for name in every if name not in held)
    if not free:
        raise InputError("fixed holds every parameter; there is nothing to find")
    return free


def _parameter_names(suspension: Suspension) -> list[str]:
    return [f"{s.name}.{q}" for q in QUANTITIES for s in suspension.struts]


def _parameters(suspension: Suspension) -> tuple[RealArray, RealArray]:
    return np.array([s.stiffness for s in suspension.struts]), np.array([s.damping for s in suspension.struts])


def _pole_equations(real: NDArray[np.bool_]) -> int:
    return int(2 * len(real) - np.sum(real))


def _all_poles(poles: ComplexArray) -> ComplexArray:
    """Return the poles with the conjugate partners of those that have one."""
    return np.concatenate([poles, poles[poles.imag != 0].conj()])


def _usable_shapes(
    modes: ModalSet, suspension: Suspension, moving: NDArray[np.bool_]
) -> tuple[ComplexArray | None, list[int], list[str]]:
    """Return the shapes whose channels are coordinates, those coordinates, and why not others."""
    if modes.shapes is None:
        return None, [], []
    strange = [c for c in modes.channels if c not in suspension.coordinates]
    twice = [c for c in modes.channels if list(modes.channels).count(c) > 1]
    if strange or twice:
        return None, [], [f"shapes not used: channel {(strange + twice)[0]!r} is not one coordinate"]
    if len(modes.channels) < 2:
        return None, [], ["shapes not used: one channel has none"]
    shapes = np.array(modes.shapes[:, moving])
    for i, shape in enumerate(shapes.T):
        largest = shape[np.argmax(np.abs(shape))]
        if not np.all(np.isfinite(shape)) or largest == 0:
            raise InputError(f"mode {i + 1} has the shape {shape}, which is not finite or zero; leave the mode out")
        shapes[:, i] = shape / largest
    real = modes.poles[moving].imag == 0
    return np.where(real, shapes.real, shapes), [suspension.coordinates.index(c) for c in modes.channels], []


def _whitening(modes: ModalSet, moving: NDArray[np.bool_], shapes: ComplexArray | None) -> RealArray:
    """Return the inverse root of the covariance of what `_Problem.sensitivities` returns."""
    assert modes.covariance is not None
    if not np.all(np.isfinite(modes.covariance)):
        raise InputError("the covariance of the modes is not finite; give modes without it, or a finite one")
    index, channels = np.flatnonzero(moving), len(modes.channels)
    # First-order map from (poles, then shapes mode by mode) to relative poles, then shapes over their reference.
    change = np.zeros((len(index) * (1 + (channels - 1) * (shapes is not None)), len(modes.covariance) // 2), complex)
    change[np.arange(len(index)), index] = 1 / np.abs(modes.poles[index])
    row = len(index)
    real = list(modes.poles[index].imag == 0)
    if shapes is not None and modes.shapes is not None:
        for i, m in enumerate(index):
            largest = int(np.argmax(np.abs(shapes[:, i])))
            at, first = modes.shapes[largest, m], len(modes) + m * channels
            for c in set(range(channels)) - {largest}:
                change[row, [first + c, first + largest]] = 1 / at, -modes.shapes[c, m] / at**2
                row += 1
                real.append(real[i])
    spread = np.empty((2 * len(change), len(modes.covariance)))
    spread[: len(change), 0::2], spread[: len(change), 1::2] = change.real, -change.imag
    spread[len(change) :, 0::2], spread[len(change) :, 1::2] = change.imag, change.real
    # In the order of real_rows: of the poles, then of the shapes, the real parts before the imaginary ones.
    shown = np.concatenate([np.ones(len(change), bool), ~np.array(real)])
    is_pole = np.tile(np.arange(len(change)) < len(index), 2)
    order = np.concatenate([np.flatnonzero(shown & is_pole), np.flatnonzero(shown & ~is_pole)])
    covariance = spread[order] @ modes.covariance @ spread[order].T
    # A variance of zero means as exact as the poles of a matrix are.
    std = np.sqrt(np.diag(covariance) + 1e-24)
    values, vectors = np.linalg.eigh(covariance / np.outer(std, std))
    return np.asarray((vectors / np.sqrt(np.maximum(values, 1e-10))).T / std)


def _starts(problem: _Problem) -> Iterator[RealArray]:
    """Return where to start: by the shapes, else by the poles from nominal, then from others around it."""
    if problem.full:
        residual, slope = problem.linear(np.zeros(len(problem.names)))
        yield _convex_program(slope, -residual, problem.lower, np.full(len(problem.names), 1e9))
        return
    enough_poles = _pole_equations(problem.real) >= len(problem.names)
    # An additive recurrence by powers of the root of g^(d+1) = g + 1 fills the unit cube evenly.
    golden = 2.0
    for _ in range(60):
        golden = (1 + golden) ** (1 / (1 + len(problem.names)))
    around = np.arange(1, STARTS)[:, None] * golden ** -np.arange(1.0, len(problem.names) + 1) % 1
    # Springs within a factor of 3 of nominal, dampers from none to a strong one.
    spread = np.where(problem.springs, 3.0 ** (2 * around - 1), around)
    for start in [problem.nominal, *np.where(problem.springs, spread * problem.nominal, spread)]:
        yield _descend(problem, problem.spectral, start) if enough_poles else start


def _descend(problem: _Problem, equations: Equations, x: RealArray) -> RealArray:
    """Return a minimum of the norm of the equations, by convex programs in a box of trust around x."""
    springs, radius = problem.springs, LARGEST_STEP
    residual, slope = equations(x)
    for _ in range(60):
        per_step = np.where(springs, x, 1.0)  # a step is in log k, and in c
        floor = np.where(springs, np.log(LEAST_STIFFNESS / per_step), -x)
        low = np.maximum(-radius, floor)
        high = np.full(len(x), radius)
        step = _bounded_least_squares(slope * per_step, -residual, low, high)
        expected = residual @ residual - np.sum((residual + slope * per_step @ step) ** 2)
        trial = np.where(springs, x * np.exp(np.where(springs, step, 0.0)), np.maximum(x + step, 0.0))
        trial_residual, trial_slope = equations(trial)
        gained = residual @ residual - trial_residual @ trial_residual
        if gained > 0:
            x, residual, slope = trial, trial_residual, trial_slope
        if np.max(np.abs(step)) < 1e-13 or (gained <= 0 and np.max(np.abs(step)) < 1e-9):
            break
        radius = min(2 * radius, 4.0) if gained > 0.75 * expected else radius if gained > 0.1 * expected else radius / 4
    return x


def _bounded_least_squares(A: RealArray, b: RealArray, low: RealArray, high: RealArray) -> RealArray:
    """Return the x between bounds of least ``|A x - b|``; where no bound acts, that is no more than least squares."""
    x = np.asarray(np.linalg.lstsq(A, b, rcond=None)[0], float)
    return x if np.all((low <= x) & (x <= high)) else _convex_program(A, b, low, high)


def _convex_program(A: RealArray, b: RealArray, low: RealArray, high: RealArray) -> RealArray:
    """Return the x between bounds of least ``|A x - b|``, by the solver, sharpened and tested here.

    The solver says which bounds act; least squares on the others then has all digits. Accepted is what meets the
    conditions of an optimum: no slope along a free unknown, none outward of a bound.
    """
    free_answer = np.linalg.lstsq(A, b, rcond=None)[0]
    size = min(max(float(np.max(np.abs(free_answer))), 1e-300), float(np.max(high)))
    R = np.zeros((A.shape[1], A.shape[1] + 1))  # the same program in as few rows as there are unknowns
    triangle = np.asarray(np.linalg.qr(np.column_stack([A, b / size]), mode="r"))[: A.shape[1]]
    R[: len(triangle)] = triangle / max(float(np.max(np.abs(triangle[:, :-1]))), 1e-300)
    y = _solve(R[:, :-1], R[:, -1], np.maximum(low / size, -1e6), np.minimum(high / size, 1e6))
    x = np.clip(y * size, low, high)
    near = 1e-6 * size
    low_acts, high_acts = x - low < near, high - x < near
    lengths = np.linalg.norm(A, axis=0) * (np.linalg.norm(b) or 1.0) + 1e-300
    for _ in range(5 * len(x)):
        free = ~(low_acts | high_acts)
        x = np.where(low_acts, low, np.where(high_acts, high, 0.0))
        x[free] = np.linalg.lstsq(A[:, free], b - A @ x, rcond=None)[0]
        beyond = np.maximum(low - x, x - high)
        if np.max(beyond) > 0:
            worst = int(np.argmax(beyond))
            low_acts[worst], high_acts[worst] = x[worst] < low[worst], x[worst] > high[worst]
            continue
        outward = (A.T @ (A @ x - b)) / lengths * np.where(low_acts, -1.0, np.where(high_acts, 1.0, 0.0))
        if np.max(outward) <= 1e-12:
            return x
        worst = int(np.argmax(outward))
        low_acts[worst] = high_acts[worst] = False
    raise ReconstructionError(
        f"{SOLVER} left a slope of {np.max(outward, initial=0.0):.1e} at the optimum, which is none; "
        f"check the nominal values and the modes for a slip of units"
    )


def _solve(A: RealArray, b: RealArray, low: RealArray, high: RealArray) -> RealArray:
    """Return what the solver gives for least ``|A x - b|`` between bounds; judged by the caller, not by its status."""
    problem, values, x = _compiled(len(low), threading.get_ident())
    for name, value in (("A", A), ("b", b), ("low", low), ("high", high)):
        values[name].value = value
    from cvxpy.error import SolverError

    with warnings.catch_warnings(), contextlib.suppress(SolverError):
        warnings.simplefilter("ignore")
        problem.solve(solver=SOLVER)
        if x.value is not None:
            return np.asarray(x.value, float)
    return np.clip(np.zeros(len(low)), low, high)


@functools.lru_cache(maxsize=64)
def _compiled(size: int, thread: int) -> tuple[Any, dict[str, Any], Any]:  # noqa: ARG001 - one program per thread
    """Return the program with its parameters and unknowns, compiled once for each number of unknowns."""
    import cvxpy

    cp: Any = cvxpy  # whose types leave out what it makes at run time
    x = cp.Variable(size)
    values = {"A": cp.Parameter((size, size)), **{name: cp.Parameter(size) for name in ("b", "low", "high")}}
    objective = cp.Minimize(cp.sum_squares(values["A"] @ x - values["b"]))
    problem = cp.Problem(objective, [x >= values["low"], x <= values["high"]])
    if not problem.is_dcp(dpp=True):
        raise AssertionError("the program must be disciplined in its parameters, or it is compiled anew each time")
    return problem, values, x


def _nearest(poles: ComplexArray, found: ComplexArray) -> NDArray[np.intp]:
    """Return, for each pole, the index of its partner among the found ones; no partner twice."""
    from scipy.optimize import linear_sum_assignment

    return np.asarray(linear_sum_assignment(pole_distances(poles, found))[1])


def _check_seen(problem: _Problem, x: RealArray, car: Suspension) -> None:
    if problem.shapes is None:
        slope = problem.spectral(x)[1]
    elif problem.full and not problem.poles_alone:
        slope = problem.linear(x)[1]
    else:
        slope = problem.sensitivities(x)[1]
    blind = _unseen(problem, slope, x, BLIND)
    if len(blind):
        weight = np.max(np.abs(blind), axis=0)
        unseen = [name for name, w in zip(problem.names, weight, strict=True) if w > 0.05]
        raise ReconstructionError(
            f"the modes do not determine {', '.join(unseen)}: {len(blind)} of {len(x)} combinations of the parameters "
            f"leave them as they are; hold one with fixed=…, add modes, or add shapes at more coordinates",
            best=car,
        )


def _blind_shapes(problem: _Problem) -> bool:
    """Return whether shapes that meet with their poles leave the linear program short of equations."""
    x = problem.nominal
    return len(_unseen(problem, problem.linear(x)[1], x, 1e-4)) > 0


def _unseen(problem: _Problem, slope: RealArray, x: RealArray, least: Ratio) -> RealArray:
    """Return the directions of the unknowns, relative for springs, that equations of this slope do not see."""
    _, values, directions = np.linalg.svd(slope * np.where(problem.springs, x, 1.0))
    values = np.concatenate([values, np.zeros(len(directions) - len(values))])
    return np.asarray(directions[values <= least * values[0]])


def _check_fit(problem: _Problem, modes: ModalSet, car: Suspension, tolerance: Ratio) -> tuple[float, float | None]:
    """Return the relative distance of the worst pole, from the car's own eigenvalues, and the least MAC."""
    found = eigenmodes(car)
    given, every = _all_poles(modes.poles), _all_poles(found.poles)
    size = np.abs(given)
    partner = _nearest(given, every)
    error = (np.abs(every[partner] - given) / np.where(size > 0, size, np.max(size)))[: len(modes)]
    allowed = np.full(len(modes), tolerance)
    if modes.covariance is not None:
        std = np.sqrt(np.diag(modes.covariance)[: 2 * len(modes)].reshape(-1, 2).sum(axis=1))
        allowed = np.maximum(allowed, 5 * std / np.where(modes.wn > 0, modes.wn, np.max(modes.wn)))
    if np.any(error > allowed):
        worst = int(np.argmax(error / allowed))
        raise ReconstructionError(
            f"no suspension of this topology and these masses with k > 0 and c >= 0 has these modes: in the nearest "
            f"one the pole of mode {worst + 1} is off by {error[worst]:.2%} of its modulus "
            f"({allowed[worst]:.2%} allowed); check the masses, the order of the modes' channels, and what is held",
            best=car,
        )
    residual = float(np.max(error, initial=0.0))
    if problem.shapes is None or found.shapes is None:
        return residual, None
    shapes = np.hstack([found.shapes, found.shapes[:, found.poles.imag != 0].conj()])[problem.observed]
    shapes = shapes[:, partner[: len(modes)][modes.poles != 0]]
    powers = np.sum(np.abs(shapes) ** 2, axis=0) * np.sum(np.abs(problem.shapes) ** 2, axis=0)
    mac = np.abs(np.sum(shapes.conj() * problem.shapes, axis=0)) ** 2 / powers
    if np.min(mac) < LEAST_MAC and (problem.whiten is None or problem.poles_alone):
        raise ReconstructionError(
            f"the nearest suspension has the poles, but not the shape of mode {int(np.argmin(mac)) + 1}: "
            f"MAC {np.min(mac):.2f} where {LEAST_MAC} is needed; check the names of the channels, or leave the "
            f"shapes out",
            best=car,
        )
    return residual, float(np.min(mac))


def _spread(problem: _Problem, x: RealArray) -> tuple[FrozenMapping | None, FrozenMapping | None]:
    """Return the standard deviations of k and of c by strut, to first order."""
    if problem.whiten is None:
        return None, None
    _, slope = problem.deciding(x)
    std = np.linalg.norm(np.linalg.pinv(slope), axis=1) * problem.scale
    named = dict(zip(problem.names, std.tolist(), strict=True))
    k, c = ({s.name: named.get(f"{s.name}.{q}", 0.0) for s in problem.car.struts} for q in QUANTITIES)
    return FrozenMapping(k), FrozenMapping(c)
