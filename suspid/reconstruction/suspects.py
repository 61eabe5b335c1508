"""Possible causes of a misfit of the modes: the gain of a channel, a mass, a channel, a mode.

Each is tried as one more unknown. To first order, a direction d of the whitened residual z takes ``(d' z)^2 / d' d``
off chi-square; d and z less what the parameters can follow. What promises most is then refitted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from suspid.errors import SuspidError
from suspid.levels import likely
from suspid.model import ModalSet, Suspension
from suspid.reconstruction.equations import Observed, sensitivities
from suspid.reconstruction.observations import ModalTest
from suspid.reconstruction.problem import Problem
from suspid.reconstruction.wishes import null_space
from suspid.units import ComplexArray, Ratio, RealArray
from suspid.words import Number, Remark, Suspect

Pose: TypeAlias = Callable[[Sequence[ModalTest], Suspension], Problem]


@dataclass(frozen=True, kw_only=True, slots=True)
class Cause:
    """One thing that may be wrong: the gain of a channel, or the mass of a coordinate."""

    name: str
    mass: bool


def suspects(tests: Sequence[ModalTest], car: Suspension, pose: Pose, x: RealArray) -> list[Remark]:
    """Return the single causes that would explain the modes; else where most of chi-square sits; x is the optimum."""
    problem = pose(tests, car)
    z, base = _unexplained(problem, x)
    freedom = problem.rows - len(problem.unknowns)
    gains = [
        (-_gain(_direction(c, problem, tests, x), z, base)[0], i, c) for i, c in enumerate(_causes(problem, tests))
    ]
    explained = []
    # Four single causes are refitted, the most promising first.
    for _, i, cause in sorted(gains)[:4]:
        try:
            error, left = _refitted(cause, tests, car, pose, x)
        except (SuspidError, np.linalg.LinAlgError):
            continue
        # Of a larger error of a gain or a mass something else is the likelier cause.
        if abs(error) <= 0.6 and likely(left, freedom - 1):
            numbers: dict[str, Number] = {"name": cause.name, "chi_square": left, "freedom": freedom - 1}
            numbers |= {"error": error} if cause.mass else {"gain": 1 + error}
            explained.append((left, i, Remark(Suspect.MASS if cause.mass else Suspect.GAIN, numbers)))
    if explained:
        return [remark for _, _, remark in sorted(explained, key=lambda one: one[:2])]
    return _concentration(problem, tests, z, base)


def _causes(problem: Problem, tests: Sequence[ModalTest]) -> list[Cause]:
    """Return the gains and the masses that are taken as known."""
    channels = [
        c
        for test, seen in zip(tests, problem.tests, strict=True)
        if seen.weighed_shapes is not None
        for c in test.modes.channels
    ]
    unknown = {name for name in problem.unknowns.names if name.endswith(".mass")}
    masses = [name for name in problem.unknowns.car.masses if f"{name}.mass" not in unknown]
    return [*(Cause(name=c, mass=False) for c in dict.fromkeys(channels)), *(Cause(name=m, mass=True) for m in masses)]


def _unexplained(problem: Problem, x: RealArray) -> tuple[RealArray, RealArray]:
    """Return the whitened residual less what the parameters can follow, and a basis of the latter (row, …)."""
    u = problem.unknowns
    residual, slope = problem.deciding(x)
    size = np.maximum(np.abs(x), 1e-3)
    free = (x > u.lower + 1e-9 * size) & (x < u.upper - 1e-9 * size)
    moves = np.eye(len(x))[:, free]
    if problem.wishes is not None:
        moves = moves @ null_space(problem.wishes.acting_rows(x)[:, free])
    base, _ = np.linalg.qr(slope @ moves)
    return residual - base @ (base.T @ residual), base


def _gain(direction: RealArray, z: RealArray, base: RealArray) -> tuple[float, float]:
    """Return what an unknown of this direction takes off chi-square, and its value."""
    apart = direction - base @ (base.T @ direction)
    square = float(apart @ apart)
    # Parameters that can follow all but a thousandth of a direction are not told from it.
    if square <= 1e-3**2 * float(direction @ direction):
        return 0.0, 0.0
    along = float(apart @ z)
    return along**2 / square, along / square


def _direction(cause: Cause, problem: Problem, tests: Sequence[ModalTest], x: RealArray) -> RealArray:
    """Return the change of the whitened residual, of all tests, per relative error of a gain or a mass."""
    u = problem.unknowns
    parts = []
    for test, seen in zip(tests, problem.tests, strict=True):
        assert seen.whiten is not None
        if cause.mass:
            at = 2 * len(u.car.struts) + u.car.coordinates.index(cause.name)
            parts.append(
                -seen.whiten @ sensitivities(seen, u.arms, u.parameters(x))[1][:, at] * u.car.masses[cause.name]
            )
        elif seen.weighed_shapes is None or cause.name not in test.modes.channels:
            parts.append(np.zeros(len(seen.whiten)))
        else:
            parts.append(_rows(seen, _of_gain(seen, test.modes.channels, cause.name)))
    return np.concatenate([*parts, np.zeros(problem.rows - sum(len(p) for p in parts))])


def _of_gain(seen: Observed, channels: Sequence[str], name: str) -> ComplexArray:
    """Return the errors of the shapes per relative error of the gain of a channel, (mode, channel)."""
    assert seen.weighed_shapes is not None
    channel, ratios = channels.index(name), seen.weighed_shapes.T
    change = np.zeros_like(ratios)
    change[:, channel] = -ratios[:, channel]
    return np.where((np.argmax(np.abs(ratios), axis=1) == channel)[:, None], ratios, change)


def _rows(seen: Observed, shapes: ComplexArray) -> RealArray:
    """Return changes of the errors of the shapes, (mode, channel), as whitened rows."""
    assert seen.whiten is not None
    assert seen.weighed_shapes is not None
    others = np.arange(shapes.shape[1]) != np.argmax(np.abs(seen.weighed_shapes), axis=0)[:, None]
    flat, real = shapes[others], np.repeat(seen.real, shapes.shape[1] - 1)
    return np.asarray(seen.whiten[:, seen.pole_equations :] @ np.concatenate([flat.real, flat.imag[~real]]))


def _refitted(
    cause: Cause, tests: Sequence[ModalTest], car: Suspension, pose: Pose, x: RealArray
) -> tuple[Ratio, float]:
    """Return the relative error of a gain or a mass that explains the modes best, and the chi-square left."""
    factor, left = 1.0, np.inf
    # Gauss-Newton steps for the size of the cause.
    for _ in range(3):
        corrected = [replace(t, modes=t.modes if cause.mass else _without_gain(t, cause.name, factor)) for t in tests]
        heavier = car.with_parameters(masses={cause.name: car.masses[cause.name] * factor}) if cause.mass else car
        problem = pose(corrected, heavier)
        x = problem.descend(x) if problem.wishes is None else problem.answer(problem.feasible(x)).x
        z, base = _unexplained(problem, x)
        taken, error = _gain(_direction(cause, problem, corrected, x), z, base)
        left = float(z @ z) - taken
        factor *= float(np.clip(1 + error, 0.5, 2.0))
    return factor - 1, left


def _without_gain(test: ModalTest, name: str, factor: float) -> ModalSet:
    """Return the modes of a test with one channel divided by a factor, and its uncertainty with it."""
    modes = test.modes
    if name not in modes.channels or modes.shapes is None or modes.covariance is None:
        return modes
    scale = np.where(np.array(modes.channels) == name, 1 / factor, 1.0)
    every = np.concatenate([np.ones(2 * len(modes)), np.tile(np.repeat(scale, 2), len(modes))])
    every = every[: len(modes.covariance)]
    return replace(modes, shapes=modes.shapes * scale[:, None], covariance=modes.covariance * np.outer(every, every))


def _concentration(problem: Problem, tests: Sequence[ModalTest], z: RealArray, base: RealArray) -> list[Remark]:
    """Return the channel or the mode without which least of chi-square is left, if that is little."""
    total, freedom = float(z @ z), problem.rows - len(problem.unknowns)
    found = []
    for code, name, directions in _blocks(problem, tests):
        apart = directions - base @ (base.T @ directions)
        basis, sizes, _ = np.linalg.svd(apart, full_matrices=False)
        basis = basis[:, sizes > 1e-6 * np.max(sizes, initial=1e-300)]
        left, rest = total - float(np.sum((basis.T @ z) ** 2)), freedom - basis.shape[1]
        # A channel or a mode is named if it takes half of chi-square along.
        if rest > 0 and left < 0.5 * total:
            found.append((left / rest, Remark(code, {"name": name, "chi_square": left, "freedom": rest})))
    return [remark for _, remark in sorted(found, key=lambda one: one[0])[:1]]


def _blocks(problem: Problem, tests: Sequence[ModalTest]) -> Iterator[tuple[Suspect, str, RealArray]]:
    """Yield each channel and each mode with the directions in which it may be wrong, (row, direction)."""
    before = 0
    for number, (test, seen) in enumerate(zip(tests, problem.tests, strict=True), 1):
        assert seen.whiten is not None
        where, count = f" of test {number}" * (len(tests) > 1), len(seen.whiten)

        def whole(directions: RealArray, first: int = before) -> RealArray:
            block = np.zeros((problem.rows, directions.shape[1]))
            block[first : first + len(directions)] = directions
            return block

        shapes, modes = seen.weighed_shapes, np.arange(len(seen.poles))
        # The mode that each row before whitening belongs to.
        own = np.repeat(modes, 0 if shapes is None else len(shapes) - 1)
        own = np.concatenate([modes, modes[~seen.real], own, own[~seen.real[own]]])
        for m, original in enumerate(np.flatnonzero(test.modes.poles != 0)):
            yield Suspect.MODE, f"{original + 1}{where}", whole(seen.whiten[:, own == m])
        for name in () if shapes is None else test.modes.channels:
            change = _of_gain(seen, test.modes.channels, name)
            errors = [unit * change * (modes == m)[:, None] for m in modes for unit in (1.0, 1.0j)]
            yield Suspect.CHANNEL, f"{name}{where}", whole(np.stack([_rows(seen, e) for e in errors], axis=1))
        before += count
