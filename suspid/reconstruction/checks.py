"""Checks of a reconstruction: identifiability, misfit, covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.errors import ReconstructionError
from suspid.levels import likely
from suspid.model import Suspension, eigenmodes
from suspid.reconstruction.asked import LEAST
from suspid.reconstruction.descent import slope_left
from suspid.reconstruction.equations import EXACT_POLE, Observed, all_poles, partners, sensitivities, spectral
from suspid.reconstruction.observations import ModalTest
from suspid.reconstruction.problem import Problem
from suspid.reconstruction.programs import Optimum
from suspid.reconstruction.unknowns import Unknowns
from suspid.reconstruction.wishes import null_space
from suspid.units import Ratio, RealArray
from suspid.values import frozen_real, listed
from suspid.wording import Argument
from suspid.words import Number, ReconstructionNote, Remark

LEAST_MAC = 0.8  # below it a shape is another mode's


def check_seen(problem: Problem, x: RealArray, car: Suspension) -> list[Remark]:
    """Return what the nominal values, or the penalty, determine and the modes do not."""
    u = problem.unknowns
    p = u.parameters(x)
    if problem.exact(x):
        slope = problem.linear[1]
    else:
        parts = [(spectral if t.shapes is None else sensitivities)(t, u.arms, p)[1] for t in problem.tests]
        slope = np.concatenate(parts) @ u.spread
    notes: list[Remark] = []
    if u.has_prior.any():
        alone = problem.unseen(slope, x)
        if len(alone):
            names = tuple(involved(alone, u))
            if any(name.endswith(".mass") for name in names):
                notes.append(Remark(ReconstructionNote.WHOLE_BY_NOMINAL, {"names": names}))
            else:
                numbers: dict[str, Number] = {"names": names, "combinations": _in_words(alone, x, u)}
                notes.append(Remark(ReconstructionNote.SPLIT_BY_NOMINAL, numbers))
        slope = np.concatenate([slope, np.linalg.norm(slope) * u.prior(x)[1] * u.prior_std[u.has_prior][:, None]])
    if problem.wishes is not None:
        slope = np.concatenate([slope, np.linalg.norm(slope) * problem.wishes.equations])
    blind = problem.unseen(slope, x)
    if len(blind):
        unseen = involved(blind, u)
        if problem.wishes is not None and problem.wishes.penalty is not None:
            return [*notes, Remark(ReconstructionNote.UNSEEN, {"names": tuple(unseen)})]
        raise ReconstructionError(
            f"the modes do not determine {', '.join(unseen)}: {len(blind)} of {len(x)} combinations of the "
            f"parameters do not change them ({_in_words(blind, x, u)}); fix one with ",
            Argument("fixed", "…"),
            ", add modes, or add shapes at more coordinates",
            best=car,
        )
    return notes


def involved(blind: RealArray, unknowns: Unknowns) -> list[str]:
    """Return the names of the unknowns that take part in directions, whatever their basis."""
    weight = np.linalg.norm(blind, axis=0)
    # Parameters with less of the combination are not named.
    return [name for name, w in zip(unknowns.labels, weight, strict=True) if w > 0.01]


def _in_words(blind: RealArray, x: RealArray, unknowns: Unknowns) -> str:
    """Return the combinations of parameters that are not seen, as changes that leave the modes as they are."""
    size = unknowns.sizes(x) * unknowns.scale
    moves = blind.copy()
    # Gauss-Jordan elimination: each combination in as few parameters as can be.
    for row in range(len(moves)):
        pivot = int(np.argmax(np.abs(moves[row])))
        moves[row] /= moves[row, pivot]
        for other in set(range(len(moves))) - {row}:
            moves[other] -= moves[other, pivot] * moves[row]
    said = []
    for move in moves:
        change = move * size
        first = int(np.argmax(np.abs(move)))
        change = np.where(np.abs(move) > 1e-3, change / abs(change[first]), 0.0)
        units = {"stiffness": "N/m", "damping": "N s/m", "mass": "kg"}
        said.append(
            ", ".join(
                f"{name} {value:+.3g} {units[name.rpartition('.')[2]]}"
                for name, value in zip(unknowns.labels, change, strict=True)
                if value
            )
        )
    return "; or ".join(said)


def pole_errors(test: ModalTest, car: Suspension) -> RealArray:
    """Return the relative distance of each pole of a test from the car's own eigenvalue."""
    every = all_poles(eigenmodes(loaded(car, test)).poles)
    size, given = np.abs(test.modes.poles), test.modes.poles
    partner = partners(all_poles(given), every)[: len(given)]
    return np.asarray(np.abs(every[partner] - given) / np.where(size > 0, size, np.max(size)))


def loaded(car: Suspension, test: ModalTest) -> Suspension:
    """Return the suspension with the masses that were added in a test."""
    added = {name: car.masses[name] + mass for name, mass in test.added_masses.items() if mass}
    return car.with_parameters(masses=added) if added else car


def check_fit(
    problem: Problem, tests: Sequence[ModalTest], car: Suspension, tolerance: Ratio
) -> tuple[float, float | None]:
    """Return the relative distance of the worst pole, from the car's own eigenvalues, and the least MAC."""
    residual, least = 0.0, None
    for i, (test, seen) in enumerate(zip(tests, problem.tests, strict=True)):
        modes, error = test.modes, pole_errors(test, car)
        where = f" of test {i + 1}" * (len(tests) > 1)
        allowed = np.full(len(modes), tolerance)
        if modes.covariance is not None:
            std = np.sqrt(np.diag(modes.covariance)[: 2 * len(modes)].reshape(-1, 2).sum(axis=1))
            allowed = np.maximum(allowed, 5 * std / np.where(modes.wn > 0, modes.wn, np.max(modes.wn)))
        if np.any(error > allowed):
            worst = int(np.argmax(error / allowed))
            labels = () if problem.wishes is None else problem.wishes.labels
            within = f", within the constraints {listed(labels)}," if labels else ""
            check = "the constraints, the masses" if labels else "the masses"
            raise ReconstructionError(
                f"no suspension of this topology and these masses with k > 0 and c >= 0{within} was found to have "
                f"these modes: in the nearest one the pole of mode {worst + 1}{where} is off by {error[worst]:.2%} of "
                f"its modulus ({allowed[worst]:.2%} allowed); check {check}, names and gains of the channels, and what "
                f"is held",
                best=car,
            )
        residual = max(residual, float(np.max(error, initial=0.0)))
        if seen.shapes is None:
            continue
        mac = shape_mac(seen, loaded(car, test))
        if np.min(mac) < LEAST_MAC and (seen.whiten is None or seen.poles_alone):
            raise ReconstructionError(
                f"the nearest suspension has the poles, but not the shape of mode {int(np.argmin(mac)) + 1}{where}: "
                f"MAC {np.min(mac):.2f} where {LEAST_MAC} is needed; check the names of the channels, or leave the "
                f"shapes out",
                best=car,
            )
        least = min(float(np.min(mac)), 1.0 if least is None else least)
    return residual, least


def shape_mac(seen: Observed, car: Suspension) -> RealArray:
    """Return the modal assurance criterion of each shape with the car's own."""
    assert seen.shapes is not None
    found = eigenmodes(car)
    assert found.shapes is not None
    poles = all_poles(found.poles)
    shapes = np.hstack([found.shapes, found.shapes[:, found.poles.imag != 0].conj()])
    partner = partners(all_poles(seen.poles), poles)[: len(seen.poles)]
    shown = (seen.weights @ shapes[:, partner]) * (poles[partner] / np.abs(seen.poles)) ** seen.orders[:, None]
    powers = np.sum(np.abs(shown) ** 2, axis=0) * np.sum(np.abs(seen.shapes) ** 2, axis=0)
    overlap = np.abs(np.sum(shown.conj() * seen.shapes, axis=0)) ** 2
    return np.asarray(overlap / np.where(powers > 0, powers, 1.0))


def remarks(problem: Problem, best: Optimum, cost: float) -> list[Remark]:
    """Return remarks on an optimum: bounds and constraints that act, and how sharp it is."""
    u, x, notes = problem.unknowns, best.x, []
    ends = u.on_bounds(x)
    vanished = ends & u.positive & (x <= 1.01 * LEAST)
    named = np.array(u.labels)
    if np.any(vanished):
        notes.append(Remark(ReconstructionNote.VANISHED, {"names": tuple(named[vanished].tolist())}))
    if np.any(ends & ~vanished) and cost > EXACT_POLE:
        notes.append(Remark(ReconstructionNote.AT_BOUND, {"names": tuple(named[ends & ~vanished].tolist())}))
    if problem.wishes is not None:
        acting = tuple(problem.wishes.labels[i] for i in problem.wishes.acting(x))
        if acting:
            notes.append(Remark(ReconstructionNote.ACTIVE, {"names": acting}))
        if problem.wishes.penalty is not None:
            notes.append(Remark(ReconstructionNote.PENALTY, {"penalty": problem.wishes.penalised(x)}))
    if cost > (0.1 if problem.weighted else EXACT_POLE):
        left = best.left if problem.wishes is not None else slope_left(problem.deciding, x, u.lower, u.upper)
        worth = left * cost**2 if problem.weighted else 1.0
        # A step at an optimum cannot take a hundredth of the squared residual.
        if left > 1e-2 and worth > 1.0:
            raise ReconstructionError(
                f"the search stopped where a further step would still reduce the squared residual by {left:.1%}, so it "
                f"found no optimum; start from a nearer nominal car, fix parameters with ",
                Argument("fixed", "…"),
                ", or add shapes",
                best=u.suspension(x),
            )
        # A step at a sharp optimum can take only this share of the squared residual.
        if left > 1e-6 and worth > 1e-3:
            notes.append(Remark(ReconstructionNote.NOT_SHARP, {"share": left}))
    return notes


def goodness(problem: Problem, best: Optimum, tolerance: Ratio) -> tuple[float | None, int, bool]:
    """Return chi-square, its degrees of freedom, and whether it is not improbably large.

    Without a covariance there is no chi-square; the modes are then explained if the residual is within the tolerance.
    An unknown on a bound, or a constraint that acts, does not follow the noise: each gives a degree of freedom back.
    """
    x, u = best.x, problem.unknowns
    equations = 0 if problem.wishes is None else len(u) - null_space(problem.wishes.equations).shape[1]
    freedom = problem.rows - (len(u) - equations)
    if not problem.weighted:
        return None, freedom, misfit(problem, x) <= tolerance
    chi_square = problem.chi_square(x)
    return chi_square, freedom, likely(chi_square, problem.rows - best.free)


def misfit(problem: Problem, x: RealArray) -> Ratio:
    """Return the root mean square error of unweighted modes for which x would have them exactly; shapes in tenths [1].

    It is corrected for what the fit takes up; 0 where there are no more equations than unknowns.
    """
    told = int(np.sum(problem.unknowns.has_prior))
    freedom = problem.rows - told - len(x)
    if freedom <= 0:
        return 0.0
    unknowns = replace(problem.unknowns, prior_std=np.full(len(x), np.inf))
    plain = replace(problem, unknowns=unknowns, wishes=None)
    return float(np.linalg.norm(plain.deciding(x)[0]) / np.sqrt(freedom))


def parameter_covariance(problem: Problem, x: RealArray, widening: float) -> RealArray | None:
    """Return the joint covariance of the free parameters, to first order.

    Equations among the constraints count as exact. Bounds and inequalities are left out, acting or not, and so is the
    penalty.
    """
    if not problem.weighted:
        return None
    u = problem.unknowns
    _, slope = problem.deciding(x)
    size = np.linalg.norm(slope, axis=0)
    moves = np.eye(len(x)) if problem.wishes is None else null_space(problem.wishes.equations / size)
    inverse = moves @ np.linalg.pinv(slope / size @ moves)
    half = widening * (inverse / size[:, None] * u.scale[:, None])[u.column]
    return frozen_real(half @ half.T)
