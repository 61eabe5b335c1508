"""From modes back to springs and dampers, for known topology: every suspension that has them, and how sure it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.alternatives import distinct, even_starts, farness, spectral_minima, told_apart
from suspid.equations import EXACT, Observed, all_poles, deciding, linear, partners, sensitivities, spectral
from suspid.equations import pole_distances as pole_distances
from suspid.errors import InputError, ReconstructionError
from suspid.modes import ModalSet, eigenmodes
from suspid.observations import ModalTest, modal_tests, observe, unweighted
from suspid.programs import STATIONARY, convex_program, descend, slope_left
from suspid.suspension import Suspension
from suspid.units import Kilogram, NewtonPerMetre, NewtonSecondPerMetre, Ratio, RealArray
from suspid.unknowns import QUANTITIES, Bounds, Unknowns, parameter_names, parameter_vector, unknowns_of
from suspid.values import FrozenMapping, frozen_real, rounded, spread, text_table

TOLERANCE = 0.02  # of a pole's modulus
STARTS = 24  # where the poles alone are too few to search by them
POLISHED = 12  # of the minima that the search finds
BLIND = 1e-8  # of the largest singular value: what the data do not see
LEAST_MAC = 0.8  # below it a shape is another mode's
UNLIKELY = 1e-3  # probability of a chi-square below which the topology does not explain the modes
UNLIKELY_TWIN = 1e-4  # the same, for the rise of chi-square from the best suspension to another
NEAR_MISS = 5e-3  # relative distance from exact poles at which another suspension is mentioned
DATA_AGAINST_PRIOR = 1e6  # weight of modes without covariance, which are exact, beside a nominal car's


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reconstruction:
    """The suspension whose modes are the given ones, the others that have them too, and its certainty.

    Parameters
    ----------
    suspension : Suspension
        Springs and dampers (and masses) found: of those with the modes, the one nearest to nominal.
    stiffness_std, damping_std : mapping of str to float, or None
        Standard deviations [N/m], [N s/m] by strut, to first order from the covariance of the modes; 0 for what was
        held, and as if no bound were there for what ends on one. None if the modes carry no covariance.
    mass_std : mapping of str to float, or None
        The same [kg] by coordinate.
    alternatives : tuple of Suspension
        Every other suspension found that has the modes within their uncertainty, by distance from nominal.
    distances : tuple of float
        How far each alternative is from the data: its chi-square; for modes without covariance, the relative
        distance of its worst pole [1].
    told_apart : tuple of str
        What would tell each alternative from `suspension`.
    residual : float
        Distance of a pole of `suspension` from the given one, relative to the latter; the worst mode [1].
    status : str
        How it was found, and what to know about it.
    held : tuple of str
        The strut parameters held at their nominal values, such as ``"tire.damping"``.
    parameters : tuple of str
        The parameters found, such as ``"tire.stiffness"`` or ``"seat.mass"``.
    covariance : ndarray (parameter, parameter), or None
        Joint covariance of `parameters`, in their units squared.
    ranges : ndarray (parameter, 2)
        Bounds of `parameters`, in their units.
    chi_square : float or None
        Squared distance from the data in standard deviations; None if the modes carry no covariance.
    freedom : int
        Degrees of freedom: equations less unknowns.
    explains : bool
        Whether the topology explains the modes: chi-square is not improbably large. If it is, the standard
        deviations are widened by its root over `freedom`, and are a guess.
    """

    suspension: Suspension
    stiffness_std: Mapping[str, NewtonPerMetre] | None
    damping_std: Mapping[str, NewtonSecondPerMetre] | None
    mass_std: Mapping[str, Kilogram] | None = None
    alternatives: tuple[Suspension, ...] = ()
    distances: tuple[float, ...] = ()
    told_apart: tuple[str, ...] = ()
    residual: Ratio
    status: str
    held: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    covariance: RealArray | None = None
    ranges: RealArray
    chi_square: float | None = None
    freedom: int = 0
    explains: bool = True

    def interval(self, level: Ratio = 0.95) -> dict[str, tuple[float, float]]:
        """Return the ends between which each of `parameters` lies with probability ``level``, cut at its bounds.

        They belong to `suspension`: an alternative has its own.

        Raises
        ------
        InputError
            If the modes carried no covariance, or the level is not between 0 and 1.
        """
        from scipy.special import ndtri

        if not 0 < level < 1:
            raise InputError(f"{level=} must lie between 0 and 1, such as 0.95")
        if self.covariance is None:
            raise InputError("the modes carried no covariance, so the parameters have none; identify gives one")
        every = dict(zip(parameter_names(self.suspension), parameter_vector(self.suspension).tolist(), strict=True))
        reach = float(ndtri((1 + level) / 2)) * np.sqrt(np.diag(self.covariance))
        values = np.array([every[name] for name in self.parameters])
        ends = np.clip(values[:, None] + reach[:, None] * [-1, 1], self.ranges[:, :1], self.ranges[:, 1:])
        return {name: (float(low), float(high)) for name, (low, high) in zip(self.parameters, ends, strict=True)}

    def __str__(self) -> str:
        struts = self.suspension.struts
        columns: dict[str, Sequence[str]] = {"strut": [s.name for s in struts]}
        for quantity, unit, stds in (("stiffness", "N/m", self.stiffness_std), ("damping", "N s/m", self.damping_std)):
            values = np.array([getattr(s, quantity) for s in struts])
            columns |= _with_spread(f"{quantity} [{unit}]", f"± [{unit}]", values, stds, [s.name for s in struts])
        if any(not name.endswith(".mass") for name in self.held):
            names = {s.name: [q for q in QUANTITIES if f"{s.name}.{q}" in self.held] for s in struts}
            columns["held"] = [", ".join(held) for held in names.values()]
        parts = [text_table(columns)]
        free = [name for name in self.suspension.masses if f"{name}.mass" in self.parameters]
        if free:
            values = np.array([self.suspension.masses[name] for name in free])
            parts.append(text_table({"mass": free} | _with_spread("[kg]", "± [kg]", values, self.mass_std, free)))
        parts.append(self.status)
        for i, (car, distance) in enumerate(zip(self.alternatives, self.distances, strict=True)):
            k, c = (", ".join(f"{getattr(s, q):.5g}" for s in car.struts) for q in QUANTITIES)
            far = f"worst pole off by {distance:.1e}" if self.chi_square is None else f"chi-square {distance:.3g}"
            apart = f"; told apart by {self.told_apart[i]}" if self.told_apart[i] else ""
            parts.append(f"another suspension has these modes: k = {k} N/m, c = {c} N s/m ({far}){apart}")
        return "\n".join(parts)


def reconstruct(
    modes: ModalSet | Sequence[ModalTest | ModalSet],
    suspension: Suspension,
    *,
    fixed: Sequence[str] = (),
    bounds: Bounds | None = None,
    ties: Sequence[Sequence[str]] = (),
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
    free_masses: Sequence[str] = (),
    tolerance: Ratio | None = None,
    search: bool = True,
) -> Reconstruction:
    """Find the stiffness and the damping of every strut from modes, for known topology.

    With shapes that show all coordinates, ``(lambda^2 M + lambda C + K) psi = 0`` is linear in k, c and masses: one
    convex program, which needs no start and has one answer; of modes that are not exact, it is itself the start of
    a sequence. Otherwise the poles (and the shapes, if there are two channels at least) are met by a sequence of
    convex programs from the nominal suspension, and from the minima that a reproducible search around it finds.
    Always k > 0, c >= 0 and mass > 0.

    Modes with a covariance are weighted by it, poles and shapes jointly; without one they count as exact, relative
    errors of poles ten times those of shapes. If it covers the poles alone, the shapes choose the suspension and the
    poles alone set its numbers, provided that they can.

    Parameters
    ----------
    modes : ModalSet, or sequence of ModalTest
        The modes, in any scale of the shapes; or those of several tests of one car, some perhaps with known masses
        added. Shapes are used if their channels are named as outputs of `statespace`: a coordinate, its
        ``_velocity`` or ``_acceleration``, the ``_travel`` of a strut. Poles at zero (rigid-body motion) say nothing
        about k and c and are only checked.
    suspension : Suspension
        Known masses and topology; its k and c are the nominal values: the start, the scale, and the value of what is
        held. A strut of nominal stiffness 0 is a damper alone and stays one.
    fixed : sequence of str
        Strut parameters held at their nominal value: ``"tire.damping"``, or ``"tire"`` for both of a strut's.
    bounds : mapping of str to (float, float), optional
        Least and largest value by parameter, such as ``{"tire.stiffness": (150e3, 250e3)}``; None for no bound.
    ties : sequence of sequences of str
        Groups of parameters that are equal, such as ``("left.stiffness", "right.stiffness")``.
    nominal_std : float, or mapping of str to float, optional
        Standard deviation of the nominal parameters, relative [1]: they then count as measured values. A number
        holds for all that are not 0.
    free_masses : sequence of str
        Masses that are unknown too, by coordinate; only known masses (others, or added ones) can give them a scale.
    tolerance : float, optional
        Largest distance of a reconstructed pole from the given one, relative to the latter, that is accepted [1];
        five standard deviations of the pole are accepted as well. Default: 0.02. If given, modes without a
        covariance count as known to it, rather than as exact, where alternatives are listed.
    search : bool
        Whether to look for alternatives. Without, only the nominal suspension is a start, unless it leads nowhere.

    Returns
    -------
    Reconstruction
        ``suspension``, ``alternatives``, ``covariance`` and what else there is to know; ``str()`` is the table.

    Raises
    ------
    InputError
        If an argument is of the wrong type, a name is unknown, wishes contradict each other, there are more poles
        than the suspension has, or a pole or a shape cannot be used.
    ReconstructionError
        If there are fewer equations than unknowns, if the modes do not determine some combination of parameters
        (which is named), or if no suspension of this topology with k > 0 and c >= 0 has these modes: a pole is
        further off than ``tolerance``. ``best`` is the nearest one met. Modes that are met within the tolerance, but
        not within their covariance, are no error: ``explains`` is then False.

    Notes
    -----
    From w and zeta alone several suspensions may have the same modes; the one nearest to the nominal values is
    returned, the others are ``alternatives``. Shapes, a parameter held, or a test with an added mass decide.

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
    one convex program on poles and shapes, which has one answer; worst pole off by ...
    """
    tests = modal_tests(modes, suspension)
    problem, notes = _posed(tests, suspension, fixed, bounds, ties, nominal_std, free_masses)
    points = _candidates(problem, search=search)
    costs = [float(np.linalg.norm(problem.deciding(x)[0])) for x in points]
    accepted = [i for i, cost in enumerate(costs) if cost <= problem.allowed(min(costs), tolerance)]
    accepted.sort(key=lambda i: farness(points[i], problem.unknowns))
    best, cost = points[accepted[0]], costs[accepted[0]]
    car = problem.unknowns.suspension(best)
    _check_seen(problem, best, car)
    accuracy = TOLERANCE if tolerance is None else tolerance
    residual, mac = _check_fit(problem, tests, car, accuracy)
    if mac is not None and not problem.exact(best):
        notes.append(f"least MAC of the shapes {mac:.4f}")
    notes += _remarks(problem, best, cost)
    others = [problem.unknowns.suspension(points[i]) for i in accepted[1:]]
    if problem.weighted:
        distances = tuple(costs[i] ** 2 for i in accepted[1:])
    else:
        distances = tuple(max(_pole_errors(test, other).max() for test in tests) for other in others)
        missed = [c for i, c in enumerate(costs) if i not in accepted and c <= NEAR_MISS]
        if missed and not problem.unknowns.has_prior.any():
            notes.append(
                f"another suspension comes within {min(missed):.1e} of these modes: "
                f"give their uncertainty, or tolerance=…, to have it judged"
            )
    chi_square, freedom, explains = _goodness(problem, best, cost)
    if chi_square is not None:
        notes.append(f"chi-square {chi_square:.3g} at {freedom} degrees of freedom")
    if not explains:
        notes.append("this topology does not explain these modes: standard deviations are widened for it")
    widening = 1.0 if explains or chi_square is None else float(np.sqrt(chi_square / max(freedom, 1)))
    covariance = _covariance(problem, best, widening)
    named = dict.fromkeys(parameter_names(suspension), 0.0)
    if covariance is not None:
        named |= dict(zip(problem.unknowns.names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    stds = [FrozenMapping({n.rpartition(".")[0]: s for n, s in named.items() if n.endswith(q)}) for q in _KINDS]
    watched = [c for c, test in zip(tests[0].modes.channels, problem.tests, strict=False) if test.shapes is not None]
    unknowns = problem.unknowns
    column = unknowns.column
    return Reconstruction(
        suspension=car,
        stiffness_std=None if covariance is None else stds[0],
        damping_std=None if covariance is None else stds[1],
        mass_std=None if covariance is None else stds[2],
        alternatives=tuple(others),
        distances=distances,
        told_apart=tuple(told_apart(car, other, watched) for other in others),
        residual=residual,
        status="; ".join([problem.manner(best), f"worst pole off by {residual:.1e} of its modulus", *notes]),
        held=tuple(n for n in parameter_names(suspension) if n not in unknowns.names and not n.endswith(".mass")),
        parameters=unknowns.names,
        covariance=covariance,
        ranges=frozen_real(np.column_stack([unknowns.lower, unknowns.upper])[column] * unknowns.scale[column, None]),
        chi_square=chi_square,
        freedom=freedom,
        explains=explains,
    )


_KINDS = (".stiffness", ".damping", ".mass")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Problem:
    """Tests, and the unknowns of the suspension."""

    tests: tuple[Observed, ...]
    unknowns: Unknowns

    @property
    def weighted(self) -> bool:
        return self.tests[0].whiten is not None

    @property
    def shaped(self) -> bool:
        return any(test.shapes is not None for test in self.tests)

    @property
    def full(self) -> bool:
        """Whether the shapes make the problem linear."""
        if all(test.full for test in self.tests):
            return True
        return any(test.full for test in self.tests) and not len(
            self.unseen(self.linear_slope(), self.unknowns.nominal)
        )

    @property
    def enough_poles(self) -> bool:
        return sum(test.pole_equations for test in self.tests) >= len(self.unknowns)

    @property
    def enough(self) -> float:
        """Norm of the deciding residual at which no other start is needed."""
        from scipy.special import chdtri

        if not self.weighted:
            return EXACT
        rows = sum(len(test.whiten) for test in self.tests if test.whiten is not None)
        return float(np.sqrt(chdtri(max(rows - len(self.unknowns), 1), UNLIKELY_TWIN)))

    @property
    def reach(self) -> Ratio:
        """Distance from the poles beyond which no minimum by the poles alone can have the modes."""
        if not self.weighted:
            return NEAR_MISS
        return NEAR_MISS + 10 * max(
            float(1 / np.linalg.svd(t.whiten, compute_uv=False).min()) for t in self.tests if t.whiten is not None
        )

    def allowed(self, least: float, tolerance: Ratio | None) -> float:
        """Return the norm of the deciding residual up to which a suspension has the modes, given the least one."""
        from scipy.special import chdtri

        if self.weighted:
            return float(np.sqrt(least**2 + chdtri(1, UNLIKELY_TWIN)))
        return max(EXACT, 1.01 * least, 0.0 if tolerance is None else tolerance)

    def manner(self, x: RealArray) -> str:
        """Return how x was found, in words."""
        if self.full:
            manner = "one convex program on poles and shapes, which has one answer"
            return manner + ", refined by a sequence" * (not self.exact(x))
        return "sequence of convex programs on poles" + " and shapes" * self.shaped

    def exact(self, x: RealArray) -> bool:
        """Return whether shapes of all coordinates, taken as exact, leave nothing to improve."""
        if self.weighted or self.unknowns.has_prior.any() or not all(test.full for test in self.tests):
            return False
        residual, slope = self.linear()
        return bool(np.linalg.norm(residual + slope @ x) <= EXACT)

    def deciding(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual that judges x, weighted, and its derivatives."""
        p, arms, spread = self.unknowns.parameters(x), self.unknowns.arms, self.unknowns.spread
        parts = [(r, s @ spread) for r, s in (deciding(test, arms, p) for test in self.tests)]
        if self.unknowns.has_prior.any():
            weight = 1.0 if self.weighted else DATA_AGAINST_PRIOR
            parts = [(weight * r, weight * s) for r, s in parts]
            parts.append(self.unknowns.prior(x))
        return np.concatenate([r for r, _ in parts]), np.concatenate([s for _, s in parts])

    def spectral(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the characteristic polynomials at the poles, and their derivatives."""
        p, arms, spread = self.unknowns.parameters(x), self.unknowns.arms, self.unknowns.spread
        parts = [spectral(test, arms, p) for test in self.tests]
        return np.concatenate([r for r, _ in parts]), np.concatenate([s for _, s in parts]) @ spread

    def linear(self) -> tuple[RealArray, RealArray]:
        """Return the linear equations of all tests that have them: residual at x = 0 and derivatives."""
        masses = np.diag(self.unknowns.car.M)
        parts = [linear(test, self.unknowns.arms, masses) for test in self.tests if test.full]
        residuals = [r + s @ self.unknowns.base for r, s in parts]
        return np.concatenate(residuals), np.concatenate([s for _, s in parts]) @ self.unknowns.spread

    def linear_slope(self) -> RealArray:
        return self.linear()[1]

    def unseen(self, slope: RealArray, x: RealArray, least: Ratio = BLIND) -> RealArray:
        """Return the directions of the unknowns, relative for springs, that equations of this slope do not see."""
        _, values, directions = np.linalg.svd(slope * np.where(self.unknowns.positive, x, 1.0))
        values = np.concatenate([values, np.zeros(len(directions) - len(values))])
        return np.asarray(directions[values <= least * values[0]])

    def descend(self, x: RealArray, *, by_poles: bool = False) -> RealArray:
        """Return the minimum near x of the deciding residual, or of the polynomials at the poles."""
        u = self.unknowns
        equations = self.spectral if by_poles else self.deciding
        return descend(equations, x, positive=u.positive, lower=u.lower, upper=u.upper)


def _posed(
    tests: Sequence[ModalTest],
    suspension: Suspension,
    fixed: Sequence[str],
    bounds: Bounds | None,
    ties: Sequence[Sequence[str]],
    nominal_std: Ratio | Mapping[str, Ratio] | None,
    free_masses: Sequence[str],
) -> tuple[_Problem, list[str]]:
    """Return the checked, dimensionless problem, and what to tell about it."""
    notes: list[str] = []
    seen: list[Observed] = []
    for test in tests:
        one, said = observe(test, suspension)
        seen.append(one)
        notes += [note for note in said if note not in notes]
    rate = float(np.exp(np.mean(np.log(np.abs(np.concatenate([one.poles for one in seen]))))))
    unknowns = unknowns_of(
        suspension,
        rate=rate,
        fixed=fixed,
        bounds=bounds,
        ties=ties,
        nominal_std=nominal_std,
        free_masses=free_masses,
    )
    known = int(np.sum(unknowns.has_prior))
    equations = sum(one.equations for one in seen)
    if equations + known < len(unknowns):
        lack, names = len(unknowns) - equations - known, unknowns.labels
        raise ReconstructionError(
            f"{len(names)} unknowns ({', '.join(names)}) but {equations} equations from "
            f"{sum(len(one.poles) for one in seen)} modes: add modes, or shapes at more coordinates, or hold at least "
            f"{lack} with fixed=…, such as fixed=[{unknowns.names[-1]!r}]",
            best=suspension,
        )
    weighed = sum(one.pole_equations if one.poles_alone else one.equations for one in seen)
    if tests[0].modes.covariance is not None and weighed + known < len(unknowns):
        notes.append("not weighted: the covariance covers the poles alone, which are too few")
        seen = [unweighted(one) for one in seen]
    problem = _Problem(tests=tuple(seen), unknowns=unknowns)
    for i, one in enumerate(seen):
        meeting = pole_distances(one.poles, all_poles(one.poles)) < 1e-4
        if one.full and np.sum(meeting) > len(one.poles):
            alone = _Problem(tests=(one,), unknowns=unknowns)
            if len(alone.unseen(alone.linear_slope(), unknowns.nominal, 1e-4)):
                notes.append("shapes not used: poles meet (critical damping), and their shapes with them")
                seen[i] = replace(one, shapes=None, weights=one.weights[:0], orders=one.orders[:0])
                problem = _Problem(tests=tuple(seen), unknowns=unknowns)
    return problem, notes


def _candidates(problem: _Problem, *, search: bool) -> list[RealArray]:
    """Return the distinct suspensions, as unknowns, that may have the modes."""
    unknowns = problem.unknowns
    points: list[RealArray] = []

    def cost(x: RealArray) -> float:
        return float(np.linalg.norm(problem.deciding(x)[0]))

    if problem.full:
        residual, slope = problem.linear()
        told, pull = unknowns.prior(np.zeros(len(unknowns)))
        rows, target = np.vstack([slope, pull / DATA_AGAINST_PRIOR]), -np.append(residual, told / DATA_AGAINST_PRIOR)
        start = convex_program(rows, target, unknowns.lower, np.minimum(unknowns.upper, 1e9))
        points.append(start if problem.exact(start) else problem.descend(start))
        if problem.exact(start) or cost(points[0]) <= problem.enough:
            return points
    nominal = unknowns.nominal
    start = problem.descend(nominal, by_poles=True) if problem.enough_poles else nominal
    points.append(problem.descend(start))
    if problem.full or (not search and cost(points[-1]) <= problem.enough):
        return distinct(points, [cost(x) for x in points], unknowns)
    if problem.enough_poles:
        starts = spectral_minima(problem.tests, unknowns, reach=problem.reach)[:POLISHED]
    else:
        starts = list(even_starts(unknowns, STARTS))
    points += [problem.descend(x) for x in starts]
    return distinct(points, [cost(x) for x in points], unknowns)


def _check_seen(problem: _Problem, x: RealArray, car: Suspension) -> None:
    """Raise if some combination of the unknowns leaves the modes as they are."""
    u = problem.unknowns
    p = u.parameters(x)
    if problem.exact(x):
        slope = problem.linear_slope()
    else:
        parts = [(spectral if t.shapes is None else sensitivities)(t, u.arms, p)[1] for t in problem.tests]
        slope = np.concatenate(parts) @ u.spread
    if u.has_prior.any():
        slope = np.concatenate([slope, np.linalg.norm(slope) * u.prior(x)[1] * u.prior_std[u.has_prior][:, None]])
    blind = problem.unseen(slope, x)
    if len(blind):
        weight = np.max(np.abs(blind), axis=0)
        unseen = [name for name, w in zip(u.labels, weight, strict=True) if w > 0.05]
        raise ReconstructionError(
            f"the modes do not determine {', '.join(unseen)}: {len(blind)} of {len(x)} combinations of the parameters "
            f"leave them as they are ({_in_words(blind, x, u)}); hold one with fixed=…, add modes, or add shapes at "
            f"more coordinates",
            best=car,
        )


def _in_words(blind: RealArray, x: RealArray, unknowns: Unknowns) -> str:
    """Return the combinations of parameters that are not seen, as changes that leave the modes as they are."""
    size = np.where(unknowns.positive, x, 1.0) * unknowns.scale
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


def _pole_errors(test: ModalTest, car: Suspension) -> RealArray:
    """Return the relative distance of each pole of a test from the car's own eigenvalue."""
    every = all_poles(eigenmodes(_loaded(car, test)).poles)
    size, given = np.abs(test.modes.poles), test.modes.poles
    partner = partners(all_poles(given), every)[: len(given)]
    return np.asarray(np.abs(every[partner] - given) / np.where(size > 0, size, np.max(size)))


def _loaded(car: Suspension, test: ModalTest) -> Suspension:
    added = {name: car.masses[name] + mass for name, mass in test.added_masses.items() if mass}
    return car.with_parameters(masses=added) if added else car


def _check_fit(
    problem: _Problem, tests: Sequence[ModalTest], car: Suspension, tolerance: Ratio
) -> tuple[float, float | None]:
    """Return the relative distance of the worst pole, from the car's own eigenvalues, and the least MAC."""
    residual, least = 0.0, None
    for i, (test, seen) in enumerate(zip(tests, problem.tests, strict=True)):
        modes, error = test.modes, _pole_errors(test, car)
        where = f" of test {i + 1}" * (len(tests) > 1)
        allowed = np.full(len(modes), tolerance)
        if modes.covariance is not None:
            std = np.sqrt(np.diag(modes.covariance)[: 2 * len(modes)].reshape(-1, 2).sum(axis=1))
            allowed = np.maximum(allowed, 5 * std / np.where(modes.wn > 0, modes.wn, np.max(modes.wn)))
        if np.any(error > allowed):
            worst = int(np.argmax(error / allowed))
            raise ReconstructionError(
                f"no suspension of this topology and these masses with k > 0 and c >= 0 has these modes: in the "
                f"nearest one the pole of mode {worst + 1}{where} is off by {error[worst]:.2%} of its modulus "
                f"({allowed[worst]:.2%} allowed); check the masses, the order of the modes' channels, and what is held",
                best=car,
            )
        residual = max(residual, float(np.max(error, initial=0.0)))
        if seen.shapes is None:
            continue
        mac = _mac(seen, _loaded(car, test))
        if np.min(mac) < LEAST_MAC and (seen.whiten is None or seen.poles_alone):
            raise ReconstructionError(
                f"the nearest suspension has the poles, but not the shape of mode {int(np.argmin(mac)) + 1}{where}: "
                f"MAC {np.min(mac):.2f} where {LEAST_MAC} is needed; check the names of the channels, or leave the "
                f"shapes out",
                best=car,
            )
        least = min(float(np.min(mac)), 1.0 if least is None else least)
    return residual, least


def _mac(seen: Observed, car: Suspension) -> RealArray:
    """Return the modal assurance criterion of each shape with the car's own."""
    assert seen.shapes is not None
    found = eigenmodes(car)
    assert found.shapes is not None
    poles = all_poles(found.poles)
    shapes = np.hstack([found.shapes, found.shapes[:, found.poles.imag != 0].conj()])
    partner = partners(all_poles(seen.poles), poles)[: len(seen.poles)]
    shown = (seen.weights @ shapes[:, partner]) * poles[partner] ** seen.orders[:, None]
    powers = np.sum(np.abs(shown) ** 2, axis=0) * np.sum(np.abs(seen.shapes) ** 2, axis=0)
    overlap = np.abs(np.sum(shown.conj() * seen.shapes, axis=0)) ** 2
    return np.asarray(overlap / np.where(powers > 0, powers, 1.0))


def _remarks(problem: _Problem, x: RealArray, cost: float) -> list[str]:
    """Return what is to be said of an optimum: bounds that act, and whether it is one."""
    u, notes = problem.unknowns, []
    size = np.maximum(np.abs(x), 1e-9)
    ends = [
        label
        for label, value, low, high, s in zip(u.labels, x, u.lower, u.upper, size, strict=True)
        if value <= low + 1e-9 * s or value >= high - 1e-9 * s
    ]
    if ends and cost > EXACT:
        notes.append(f"held back by its bound: {', '.join(ends)}")
    if cost > (0.1 if problem.weighted else EXACT):
        left = slope_left(problem.deciding, x, u.lower, u.upper)
        if left > STATIONARY and left * cost**2 > 1e-3 * problem.weighted:
            notes.append(f"no optimum: a further step would take {left:.1e} of the squared residual")
    return notes


def _goodness(problem: _Problem, x: RealArray, cost: float) -> tuple[float | None, int, bool]:
    """Return chi-square, its degrees of freedom, and whether it is not improbably large."""
    from scipy.special import chdtrc

    u = problem.unknowns
    rows = len(problem.deciding(x)[0])
    freedom = rows - len(u)
    if not problem.weighted:
        return None, freedom, True
    # A bound that acts leaves one unknown less to follow the noise.
    stuck = int(np.sum((x <= u.lower * (1 + 1e-9)) | (x >= u.upper * (1 - 1e-9))))
    return cost**2, freedom, not freedom + stuck or bool(chdtrc(freedom + stuck, cost**2) >= UNLIKELY)


def _covariance(problem: _Problem, x: RealArray, widening: float) -> RealArray | None:
    """Return the joint covariance of the free parameters, to first order and as if there were no bounds."""
    if not problem.weighted:
        return None
    u = problem.unknowns
    _, slope = problem.deciding(x)
    size = np.linalg.norm(slope, axis=0)
    half = widening * (np.linalg.pinv(slope / size) / size[:, None] * u.scale[:, None])[u.column]
    return frozen_real(half @ half.T)


def _with_spread(
    title: str, spread_title: str, values: RealArray, stds: Mapping[str, float] | None, names: Sequence[str]
) -> dict[str, Sequence[str]]:
    """Return a column of values, and one of their standard deviations if there are any."""
    if stds is None:
        return {title: [f"{value:.7g}" for value in values]}
    known = np.array([stds[name] for name in names])
    # Columns need names of their own: the unit tells them apart.
    return {title: rounded(values, known), spread_title: [spread(std) for std in known]}
