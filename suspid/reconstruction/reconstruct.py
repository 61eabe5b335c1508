"""Stiffness and damping of a suspension from its modes, for known topology."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from suspid.arguments import explained
from suspid.errors import ReconstructionError
from suspid.levels import CHI_SQUARE_95
from suspid.model import ModalSet, Suspension
from suspid.reconstruction.alternatives import farness, told_apart
from suspid.reconstruction.asked import Bounds
from suspid.reconstruction.candidates import candidates
from suspid.reconstruction.checks import (
    check_fit,
    check_seen,
    goodness,
    misfit,
    parameter_covariance,
    pole_errors,
    remarks,
)
from suspid.reconstruction.convexity import Maker
from suspid.reconstruction.observations import ModalTest, modal_tests
from suspid.reconstruction.posed import Asked, posed
from suspid.reconstruction.problem import NEAR_MISS, Problem
from suspid.reconstruction.programs import Optimum
from suspid.reconstruction.results import Reconstruction
from suspid.reconstruction.suspects import suspects
from suspid.reconstruction.unknowns import parameter_names
from suspid.reconstruction.wishes import Constraints
from suspid.threads import in_one_thread
from suspid.units import Ratio, RealArray
from suspid.values import FrozenMapping, frozen_real
from suspid.words import ReconstructionNote, Remark

__all__ = ["Reconstruction", "reconstruct"]


@explained
@in_one_thread
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
    constraints: Constraints | None = None,
    penalty: Maker | None = None,
) -> Reconstruction:
    """Find stiffness and damping of every strut from modes, for known topology.

    With shapes that show all coordinates, ``(lambda^2 M + lambda C + K) psi = 0`` is linear in k, c and masses: one
    convex program, which needs no start and has a unique solution. If the modes are not exact, it is the start of a
    sequence. Otherwise poles (and shapes of at least two channels) are fitted by a sequence of convex programs,
    started at the nominal suspension and at the minima that a reproducible search around it finds. The last program,
    which gives the answer, is solved by cvxpy; its optimality is tested, and that of the alternatives. Always k > 0,
    c >= 0 and mass > 0.

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
        Known masses and topology; its k and c are the nominal values: the start, the scale, and the values of fixed
        parameters. A strut of nominal stiffness 0 is a damper alone and stays one.
    fixed : sequence of str
        Strut parameters fixed at their nominal values: ``"tire.damping"``, or ``"tire"`` for both of a strut's.
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
        0.005: how they were found is not known.
    search : bool
        Whether to look for alternatives. Without, only the nominal suspension is a start, unless it leads nowhere.
    constraints : str, callable, or sequence of them, optional
        Convex constraints on stiffness and damping. As text, linear ones: ``"front.stiffness >= 1.5 *
        rear.stiffness"``. As a function, any that cvxpy accepts: ``lambda k, c: [cp.norm2(cp.hstack([c["front"],
        c["rear"]])) <= 4e3]``; k and c map each strut to a cvxpy expression [N/m], [N s/m].
    penalty : callable, optional
        ``lambda k, c: …``, a convex term in k and c that is never negative, added to chi-square [1]: a penalty of 1
        weighs as much as one standard deviation of one measured value. Divide by what counts as one: ``lambda k, c:
        10 * sum(cp.abs(c[s] / c0[s] - 1) for s in c0)`` charges 1 for a change by 10 %. To name the single parameter
        that changed, divide by conditional standard deviations (see the examples). Modes without a covariance are
        fitted as if exact, so the penalty only decides what they leave open.

    Returns
    -------
    Reconstruction
        ``suspension``, ``alternatives``, ``covariance`` and more; ``str()`` is the table.

    Raises
    ------
    InputError
        If an argument is of the wrong type, a name is unknown, arguments or constraints contradict each other (those
        that do are named), a constraint or a penalty is not convex, there are more poles than the suspension has, or
        a pole or a shape cannot be used.
    ReconstructionError
        If there are fewer equations than unknowns, if the modes do not determine some combination of parameters
        (which is named), if the search ends at no optimum, or if no suspension of this topology with k > 0 and
        c >= 0 has these modes: a pole is further off than ``tolerance``. ``best`` is the nearest one met. Modes that
        are met within the tolerance, but not within their covariance, are no error: ``explains`` is then False.

    Notes
    -----
    From w and zeta alone several suspensions may have the same modes; of those that the data hold equally likely
    the one nearest to the nominal values is returned, the others are ``alternatives``. Shapes, a fixed parameter, or a
    test with an added mass decide between them. All intervals hold for the masses as given; ``nominal_std`` of the
    masses puts their error into them. If all masses are wrong by one factor, all k and c are too; modes cannot show
    this.

    Equations among the constraints enter the intervals as exact knowledge. Inequalities do not, even where they hold
    with equality: the standard deviations are then those of the data without them, as for bounds; `status` and
    `verdict` name them. The penalty does not enter the intervals either: it biases the values, and the intervals do not
    contain the bias. Parameters that only the penalty determines have no intervals. An active constraint gives back its
    degree of freedom in the test of chi-square. Mean costs are a few ms a quarter car, ten times that with constraints.

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
    linear convex fit of poles and shapes (unique solution); largest relative pole error ...

    With the tire known to be at least 11 times as stiff as the chassis spring:

    >>> held = reconstruct(eigenmodes(car), nominal, fixed=["tire.damping"],
    ...                    constraints="tire.stiffness >= 11 * chassis.stiffness", tolerance=0.1)
    >>> k = {strut.name: strut.stiffness for strut in held.suspension.struts}
    >>> round(k["tire"] / k["chassis"], 6)
    11.0

    An l1 penalty names the one parameter that changed, here a damper, where parameters are strongly correlated only if
    each change is divided by the conditional standard deviation of the parameter, which is that with all others known:

    >>> import numpy as np
    >>> import cvxpy as cp
    >>> from suspid import ModalSet
    >>> exact = eigenmodes(car.with_parameters(damping={"chassis": 900}))
    >>> modes = ModalSet.from_wn_zeta(exact.wn, exact.zeta, wn_std=1e-3 * exact.wn, zeta_std=1e-2 * exact.zeta)
    >>> free = reconstruct(modes, car)
    >>> sd = dict(zip(free.parameters, np.diag(np.linalg.inv(free.covariance)) ** -0.5))
    >>> def l1(k, c):
    ...     changes = [(k[s.name] - s.stiffness) / sd[f"{s.name}.stiffness"] for s in car.struts]
    ...     changes += [(c[s.name] - s.damping) / sd[f"{s.name}.damping"] for s in car.struts]
    ...     return 10 * cp.norm1(cp.hstack(changes))
    >>> found = reconstruct(modes, car, penalty=l1).suspension
    >>> [s.name for s, was in zip(found.struts, car.struts) if abs(s.damping - was.damping) > 1]
    ['chassis']
    """
    tests = modal_tests(modes, suspension)
    asked = Asked(
        fixed=fixed,
        bounds=bounds,
        ties=ties,
        nominal_std=nominal_std,
        free_masses=free_masses,
        tolerance=tolerance,
        constraints=constraints,
        penalty=penalty,
    )
    problem, notes = posed(tests, suspension, asked)
    # Of a pole's modulus.
    accuracy = 0.02 if tolerance is None else tolerance

    def causes(x: RealArray) -> list[Remark]:
        return suspects(tests, suspension, lambda t, s: posed(t, s, asked)[0], x) if problem.weighted else []

    points, costs = candidates(problem, search=search)
    accepted = _accepted(problem, points, costs)
    best, nearest = problem.answer(points[accepted[0]]), int(np.argmin(costs))
    cost, car = problem.cost(best.x), problem.unknowns.suspension(best.x)
    notes += check_seen(problem, best.x, car)
    try:
        residual, mac = check_fit(problem, tests, car, accuracy)
    except ReconstructionError as error:
        found = causes(points[nearest])
        if not found:
            raise
        raise ReconstructionError("; ".join(map(str, [error, *found])), best=car) from None
    if mac is not None and not problem.exact(best.x):
        notes.append(Remark(ReconstructionNote.LEAST_MAC, {"mac": mac}))
    notes += remarks(problem, best, cost)
    minima = [problem.alternative(points[i], costs[i]) for i in accepted[1:]]
    others = [problem.unknowns.suspension(x) for x in minima]
    if problem.weighted:
        distances = tuple(problem.cost(x) ** 2 for x in minima)
    else:
        distances = tuple(max(float(pole_errors(test, other).max()) for test in tests) for other in others)
        missed = [c for i, c in enumerate(costs) if i not in accepted]
        notes += _unweighted_notes(problem, missed, few=bool(others) and tolerance is None)
    chi_square, freedom, explains = goodness(problem, best, accuracy)
    if nearest != accepted[0]:
        explains = goodness(problem, problem.answer(points[nearest]), accuracy)[2]
    widening = 1.0 if explains or chi_square is None else float(np.sqrt(chi_square / max(freedom, 1)))
    notes += _fit_notes(problem, best, residual, chi_square, freedom)
    if not explains and chi_square is None:
        notes.append(Remark(ReconstructionNote.BEYOND_TOLERANCE, {"tolerance": accuracy}))
    elif not explains:
        notes += [Remark(ReconstructionNote.UNEXPLAINED, {"widening": widening}), *causes(points[nearest])]
    undetermined = any(note.code is ReconstructionNote.UNSEEN for note in notes)
    covariance = None if undetermined else parameter_covariance(problem, best.x, widening)
    stds = _standard_deviations(problem, covariance)
    watched = [c for c, test in zip(tests[0].modes.channels, problem.tests, strict=False) if test.shapes is not None]
    u = problem.unknowns
    return Reconstruction(
        suspension=car,
        nominal=suspension,
        stiffness_std=stds[0],
        damping_std=stds[1],
        mass_std=stds[2],
        alternatives=tuple(others),
        distances=distances,
        told_apart=tuple(told_apart(car, other, watched) for other in others),
        residual=residual,
        remarks=(
            problem.manner(best.x),
            Remark(ReconstructionNote.POLE_ERROR, {"residual": residual}),
            *notes,
        ),
        held=tuple(n for n in parameter_names(suspension) if n not in u.names and not n.endswith(".mass")),
        parameters=u.names,
        covariance=covariance,
        ranges=frozen_real(np.column_stack([u.lower, u.upper])[u.column] * u.scale[u.column, None]),
        chi_square=chi_square,
        freedom=freedom,
        explains=explains,
        searched=search or problem.unique,
    )


def _accepted(problem: Problem, points: Sequence[RealArray], costs: Sequence[float]) -> list[int]:
    """Return which points have the modes, the answer first.

    The data come first: nearness to the nominal car decides only between cars that they hold equally likely.
    """
    level = min(costs) ** 2 + CHI_SQUARE_95 if problem.weighted else np.inf
    accepted = [i for i, cost in enumerate(costs) if cost <= problem.allowed(min(costs))]
    return sorted(accepted, key=lambda i: (costs[i] ** 2 > level, farness(points[i], problem.unknowns)))


def _unweighted_notes(problem: Problem, missed: Sequence[float], *, few: bool) -> list[Remark]:
    """Return remarks on other suspensions where the modes have no covariance."""
    notes = []
    if few and problem.known_to:
        notes.append(Remark(ReconstructionNote.FEW_DIGITS, {"known_to": problem.known_to}))
    near = [cost for cost in missed if cost <= NEAR_MISS]
    if near and not problem.has_nominal:
        notes.append(Remark(ReconstructionNote.NEAR_MISS, {"distance": min(near)}))
    return notes


def _fit_notes(
    problem: Problem, best: Optimum, residual: float, chi_square: float | None, freedom: int
) -> list[Remark]:
    """Return how well the modes are met."""
    if chi_square is not None:
        return [Remark(ReconstructionNote.CHI_SQUARE, {"chi_square": chi_square, "freedom": freedom})]
    # Of a pole's modulus: nearer, modes without covariance are met.
    if freedom > 0 and residual > 1e-9:
        return [Remark(ReconstructionNote.MISFIT, {"misfit": misfit(problem, best.x)})]
    return []


def _standard_deviations(problem: Problem, covariance: RealArray | None) -> list[Mapping[str, float] | None]:
    """Return the standard deviations of stiffnesses, dampings and masses by name; 0 for what is held."""
    if covariance is None:
        return [None, None, None]
    named = dict.fromkeys(parameter_names(problem.unknowns.car), 0.0)
    named |= dict(zip(problem.unknowns.names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    return [
        FrozenMapping({n.rpartition(".")[0]: s for n, s in named.items() if n.endswith(q)})
        for q in (".stiffness", ".damping", ".mass")
    ]
