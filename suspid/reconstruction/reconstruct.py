"""From modes back to springs and dampers, for known topology: every suspension that has them, and how sure it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import InputError, ReconstructionError
from suspid.model import ModalSet, Suspension
from suspid.reconstruction.alternatives import farness, told_apart
from suspid.reconstruction.observations import ModalTest, modal_tests
from suspid.reconstruction.problem import NEAR_MISS, Problem, candidates, posed
from suspid.reconstruction.suspects import suspects
from suspid.reconstruction.unknowns import QUANTITIES, Bounds, parameter_names, parameter_vector
from suspid.reconstruction.verdicts import (
    check_fit,
    check_seen,
    goodness,
    misfit,
    parameter_covariance,
    pole_errors,
    remarks,
)
from suspid.units import Kilogram, NewtonPerMetre, NewtonSecondPerMetre, Ratio, RealArray
from suspid.values import FrozenMapping, frozen_real, rounded, spread, text_table

TOLERANCE = 0.02  # of a pole's modulus
ROUNDED = 1e-9  # of a pole's modulus: nearer, modes without covariance are met
LEVEL = 3.84  # rise of chi-square up to which two suspensions are equally likely: 95 % of one degree of freedom
KINDS = (".stiffness", ".damping", ".mass")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reconstruction:
    """The suspension whose modes are the given ones, the others that have them too, and its certainty.

    Parameters
    ----------
    suspension : Suspension
        Springs and dampers (and masses) found: of those that have the modes equally well, the one nearest to nominal.
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
        deviations are widened by its root over `freedom`, and are a guess; `status` names the gains and masses that
        would explain the modes, or where the misfit sits. Without a covariance: whether the root mean square of what
        the fit leaves of the poles, relative, and of a tenth of the shapes is within the tolerance.
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
            far = (
                f"worst pole off by {distance:.1e}"
                if self.chi_square is None
                else f"chi-square {distance if distance > 1e-6 else 0:.3g}"
            )
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
        holds for all that are not 0. A mass named here, as in ``{"tire.mass": 0.005}``, is unknown but for that.
    free_masses : sequence of str
        Masses that are unknown too, by coordinate; only known masses (others, or added ones) can give them a scale.
    tolerance : float, optional
        Largest distance of a reconstructed pole from the given one, relative to the latter, that is accepted [1];
        five standard deviations of the pole are accepted as well. Default: 0.02. If given, modes without a
        covariance count as known to it where alternatives are listed. If not, they count as exact; but those that
        were printed (w and zeta, or the poles, are numbers of at most eight digits, w perhaps in Hz) as known to
        0.005, for nobody knows how they were found.
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
        (which is named), if the search ends at no optimum, or if no suspension of this topology with k > 0 and
        c >= 0 has these modes: a pole is further off than ``tolerance``. ``best`` is the nearest one met. Modes that
        are met within the tolerance, but not within their covariance, are no error: ``explains`` is then False.

    Notes
    -----
    From w and zeta alone several suspensions may have the same modes; of those that the data hold equally likely
    the one nearest to the nominal values is returned, the others are ``alternatives``. Shapes, a parameter held, or
    a test with an added mass decide. All intervals hold for the masses as given; ``nominal_std`` of the masses puts
    their error into them. If all masses are wrong by one factor, all k and c are too, and no modes can tell.

    Examples
    --------
    >>> from suspid import eigenmodes, quarter_car
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

    def pose(tests: Sequence[ModalTest], suspension: Suspension) -> tuple[Problem, list[str]]:
        return posed(tests, suspension, fixed, bounds, ties, nominal_std, free_masses, tolerance)

    problem, notes = pose(tests, suspension)
    points, costs = candidates(problem, search=search)
    accepted = [i for i, cost in enumerate(costs) if cost <= problem.allowed(min(costs))]
    # The data come first: nearness to the nominal car decides only between cars that they hold equally likely.
    level = min(costs) ** 2 + LEVEL if problem.weighted else np.inf
    accepted.sort(key=lambda i: (costs[i] ** 2 > level, farness(points[i], problem.unknowns)))
    for i in accepted:
        points[i] = problem.answer(points[i]).x
        costs[i] = float(np.linalg.norm(problem.deciding(points[i])[0]))
    best, cost = points[accepted[0]], costs[accepted[0]]
    car = problem.unknowns.suspension(best)
    notes += check_seen(problem, best, car)
    accuracy = TOLERANCE if tolerance is None else tolerance
    nearest = int(np.argmin(costs))
    try:
        residual, mac = check_fit(problem, tests, car, accuracy)
    except ReconstructionError as error:
        causes = suspects(tests, suspension, lambda t, s: pose(t, s)[0], points[nearest]) if problem.weighted else []
        if not causes:
            raise
        raise ReconstructionError("; ".join([str(error), *causes]), best=car) from None
    if mac is not None and not problem.exact(best):
        notes.append(f"least MAC of the shapes {mac:.4f}")
    notes += remarks(problem, best, cost)
    others = [problem.unknowns.suspension(points[i]) for i in accepted[1:]]
    if problem.weighted:
        distances = tuple(costs[i] ** 2 for i in accepted[1:])
    else:
        distances = tuple(max(float(pole_errors(test, other).max()) for test in tests) for other in others)
        if others and tolerance is None and problem.known_to:
            notes.append(f"modes of so few digits count as known to {problem.known_to:.1%}; tolerance=… says otherwise")
        missed = [c for i, c in enumerate(costs) if i not in accepted and c <= NEAR_MISS]
        if missed and not problem.unknowns.has_prior.any():
            notes.append(
                f"another suspension comes within {min(missed):.1e} of these modes: "
                f"give their uncertainty, or tolerance=…, to have it judged"
            )
    chi_square, freedom, explains = goodness(problem, best, cost, accuracy)
    if nearest != accepted[0]:
        _, _, explains = goodness(problem, points[nearest], costs[nearest], accuracy)
    if chi_square is not None:
        notes.append(f"chi-square {chi_square if chi_square > 1e-6 else 0:.3g} at {freedom} degrees of freedom")
    elif freedom > 0 and residual > ROUNDED:
        left = misfit(problem, best)
        notes.append(f"the modes are met to {left:.1e} rms (shapes to ten times that)")
    if not explains:
        notes.append(
            f"this topology does not explain these modes: more is left than {accuracy:.1%}"
            if chi_square is None
            else "this topology does not explain these modes: standard deviations are widened for it"
        )
        if chi_square is not None:
            notes += suspects(tests, suspension, lambda t, s: pose(t, s)[0], points[nearest])
    widening = 1.0 if explains or chi_square is None else float(np.sqrt(chi_square / max(freedom, 1)))
    covariance = parameter_covariance(problem, best, widening)
    named = dict.fromkeys(parameter_names(suspension), 0.0)
    if covariance is not None:
        named |= dict(zip(problem.unknowns.names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    stds = [FrozenMapping({n.rpartition(".")[0]: s for n, s in named.items() if n.endswith(q)}) for q in KINDS]
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


def _with_spread(
    title: str, spread_title: str, values: RealArray, stds: Mapping[str, float] | None, names: Sequence[str]
) -> dict[str, Sequence[str]]:
    """Return a column of values, and one of their standard deviations if there are any."""
    if stds is None:
        return {title: [f"{value:.7g}" for value in values]}
    known = np.array([stds[name] for name in names])
    # Columns need names of their own: the unit tells them apart.
    return {title: rounded(values, known), spread_title: [spread(std) for std in known]}
