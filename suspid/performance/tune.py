"""Springs and dampers that make the best compromises between figures of a ride."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.levels import CERTAIN
from suspid.model import Suspension
from suspid.performance.choices import Choice, box_of, choice_of
from suspid.performance.figure_plan import Plan, plan_of
from suspid.performance.figures import check_exposure
from suspid.performance.fronts import SAME_FIGURE, Search, front_of
from suspid.performance.joined import Joined, joined
from suspid.performance.larger_better import check_least, limit_in_words, shown, small
from suspid.performance.relations import Limits, check_largest, relations_of, split
from suspid.performance.ride import HOUR, driven_road
from suspid.performance.road_response import Grid, exact_grid, exact_parts, grid_of
from suspid.performance.scenarios import for_search, places_in
from suspid.performance.tuning_checks import idle_limits, tuning_checks
from suspid.performance.tuning_defaults import comfort_and_load, equal_groups
from suspid.performance.tunings import Tuning
from suspid.performance.uncertain import Car, uncertain
from suspid.simulation import Road
from suspid.units import Metre, Ratio, RealArray, Second
from suspid.values import frozen_real, is_count, is_size
from suspid.wording import Argument
from suspid.words import Remark, Verdict
from suspid.words.tuning import TuningHeadline

# Cars on a front: it is smooth, and each takes a search.
MOST_CARS = 200
# Figures that are zero to rounding, such as the probability of a rare event, have no logarithm.
NO_FIGURE = 1e-300


@explained
def tune(
    car: Car,
    *,
    parameters: Sequence[str | Sequence[str]] | None = None,
    objective: str | Sequence[str] | None = None,
    road: Road | str | float,
    speed: float | None = None,
    constraints: Limits | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    points: int = 11,
    robust: Ratio = 0.0,
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
    duration: Second = HOUR,
    weightings: Mapping[str, str | Sequence[str]] | None = None,
    clearance: Mapping[str, Metre | tuple[Metre, Metre]] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Tuning:
    """Return the springs and dampers of the best compromises between two figures, or of the best one.

    Parameters
    ----------
    car : Suspension, Estimate or Reconstruction
        The car to begin with.
    parameters : sequence of str or of sequence of str, optional
        What may change, such as ``"chassis.stiffness"``; a sequence of names changes by one factor, such as those of
        both sides of an axle. Default: all struts off the road, left and right ones that are equal by one factor.
    objective : str or sequence of str, optional
        One or two figures of `ride` to be small, such as ``("chassis_acceleration.Wk", "tire.load")``, or of `grip` to
        be large, such as ``"tire.adhesion"`` and ``"tire.phase"``. Figures of a ride of one unit joined by +, such as
        ``"front.load + rear.load"``, are one: the root of the sum of their squares.
        Default: the weighted acceleration of the first coordinate that is no wheel, and the load of all wheels.
    road, speed, duration, weightings, clearance
        As in `ride`.
    constraints : mapping of str to float, str, callable, or sequence of these, optional
        Largest values of figures, such as ``{"chassis.travel": 0.02}``, in SI units; of adhesion [1] and phase [rad]
        the least. Linear relations between springs
        and dampers, as in `reconstruct`: ``"front.stiffness >= 0.8 * rear.stiffness"``, or a function of k and c.
    bounds : mapping of str to tuple of float, optional
        Least and largest value of parameters, in SI units; of a group by its first name. Default: a quarter to four
        times the car's own.
    points : int
        Cars on the front, at least two.
    robust : float
        Standard deviations, over what is uncertain and not chosen, that are added to the mean of each figure: the cars
        are then best for cars as uncertain as this one. Default: none, the car is taken as known.
    nominal_std : float, or mapping of str to float, optional
        Relative standard deviation of parameters that were not estimated, as in `grip`.
    progress : callable, optional
        Called with the name of each step as it begins, such as ``"car 3 of 11"``.

    Returns
    -------
    Tuning
        The cars and their figures; ``.cars[.knee]`` is where the front bends most.

    Raises
    ------
    InputError
        If a name is unknown, no car meets the constraints, or a number is not positive.

    Notes
    -----
    Each point of the front has the least largest of both figures, in logarithms, relative to a point on the line
    between the ends (Das and Dennis, SIAM J. Optimization 8, 1998, 631-657), by sequential quadratic programming with
    exact derivatives. Searches begin at the best of points spread over the box, and at the neighbour on the front; the
    verdict tells how many agree. Scenarios of what is uncertain are its sigma points: one standard deviation times the
    root of their number along each parameter, in principal directions. Where many parameters are uncertain and nothing
    is limited, a search looks at those directions alone in which its figures move; the figures that are returned are
    those of all scenarios.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune(car, parameters=["chassis.damping"], objective=["chassis_acceleration.Wk", "tire.load"],
    ...              road="C", speed=20.0, points=5)
    >>> bool(np.all(np.diff(found.values[:, 0]) > 0) and np.all(np.diff(found.values[:, 1]) < 0))
    True
    """
    about = uncertain(car, nominal_std)
    objective = comfort_and_load(about.car) if objective is None else objective
    wanted = tuple(objective) if isinstance(objective, tuple | list) else (objective,)
    check_exposure(duration)
    limits, related = split(constraints)
    _check(wanted, limits, points, robust)
    driven = driven_road(about.car, road, speed)
    figures = (*wanted, *(name for name in limits if name not in wanted))
    plan = plan_of(about.car, driven, duration=duration, weightings=weightings, clearance=clearance)
    asked = joined(plan, figures)
    choice = choice_of(about, equal_groups(about.car) if parameters is None else parameters, robust)
    low, high = box_of(choice, bounds or {})
    parts = _parts_of_box(asked.plan, choice, low, high) if asked.plan.formulas else 1
    start = np.clip(np.zeros(len(low)), low, high)
    # An objective that is limited too stands once more, as a figure of its own.
    order = [*range(len(wanted)), *(figures.index(name) for name in limits)]

    def grid_for(one: Suspension) -> Grid:
        return grid_of(asked.plan.signals, driven, parts, one)

    # A limit is to be met by the figure itself.
    searched = choice if limits else for_search(asked, choice, places_in(low, high))

    def evaluate(x: RealArray) -> tuple[RealArray, RealArray]:
        values, slopes = _figures(asked, searched, grid_for, x, robust)
        losses, by = small(figures, values)
        losses = np.maximum(losses, NO_FIGURE)
        return np.log(losses)[order], (slopes * (by / losses)[:, None])[order]

    search = Search(
        evaluate=evaluate,
        low=low,
        high=high,
        objectives=len(wanted),
        limits=np.log(small(tuple(limits), np.array(list(limits.values()), float))[0]),
        relations=relations_of(choice, about.car, related),
    )
    front = front_of(search, start, points, progress or (lambda _: None))
    if not front.points:
        asked_for = [*search.relations.labels, *(limit_in_words(name, value) for name, value in limits.items())]
        raise InputError(
            f"no car within the bounds meets the constraints {', '.join(asked_for)}: "
            f"widen the bounds or the limits, or let more parameters change"
        )
    cars = tuple(choice.car(point.x, {}) for point in front.points)
    exact = _figures_of(asked, choice, robust, [point.x for point in front.points])
    now, _ = _figures(asked, choice, _exactly(asked.plan), np.zeros(len(low)), robust)
    chosen = [choice.chosen(point.x) for point in front.points]
    return Tuning(
        objectives=wanted,
        figures=figures,
        units=asked.units,
        values=frozen_real(shown(figures, exact)),
        present=frozen_real(shown(figures, now)),
        parameters=choice.names,
        choices=frozen_real([[one[name] for name in choice.names] for one in chosen]),
        described=frozen_real([choice.values[name] for name in choice.names]),
        cars=cars,
        robust=float(robust),
        verdict=Verdict(
            Remark(TuningHeadline.FRONT, {"points": len(front.points), "parameters": choice.names}),
            (
                *tuning_checks(front, choice, search, robust, about, tuple(bounds or ())),
                *idle_limits(limits, dict(zip(figures, exact.T, strict=True))),
            ),
        ),
    )


def _parts_of_box(plan: Plan, choice: Choice, low: RealArray, high: RealArray) -> int:
    """Return parts of panels that are fine enough for all cars of the box.

    The sharpest resonances are those of the stiffest springs, with the weakest dampers or with dampers so strong that
    the body moves on its tires alone.
    """
    springs = np.array([all(name.endswith(".stiffness") for name in group) for group in choice.groups])
    corners = (np.zeros(len(low)), np.where(springs, high, low), high)
    # Variances to this share, figures to half of it; those of the cars that are found are exact.
    return max(exact_parts(choice.car(x, {}), plan.signals, plan.road, SAME_FIGURE) for x in corners)


def _exactly(plan: Plan) -> Callable[[Suspension], Grid]:
    """Return what makes the grid of a car that is fine enough for it."""
    return lambda car: exact_grid(car, plan.signals, plan.road)


def _figures(
    asked: Joined, choice: Choice, grid_for: Callable[[Suspension], Grid], x: RealArray, robust: Ratio
) -> tuple[RealArray, RealArray]:
    """Return figures at a choice and their derivatives by the logarithms of its factors, (figure, group)."""
    cars = [choice.car(x, each) for each in choice.scenarios]
    pairs = [asked.values(car, choice.names, grid_for) for car in cars]
    values, jacobians = np.array([one for one, _ in pairs]), np.array([two for _, two in pairs])
    at = np.array([choice.chosen(x)[name] for name in choice.names])
    member = np.array([[name in group for group in choice.groups] for name in choice.names], float)
    slopes = (jacobians * at) @ member
    mean, mean_slopes = values.mean(axis=0), slopes.mean(axis=0)
    if not robust:
        return mean, mean_slopes
    about = values - mean
    std = np.sqrt(np.mean(about**2, axis=0))
    std_slopes = np.mean(about[:, :, None] * (slopes - mean_slopes), axis=0) / np.maximum(std, NO_FIGURE)[:, None]
    # Of figures that are to be large the margin lies below the mean.
    margin = robust * asked.signs
    return mean + margin * std, mean_slopes + margin[:, None] * std_slopes


def _figures_of(asked: Joined, choice: Choice, robust: Ratio, where: Sequence[RealArray]) -> RealArray:
    """Return the figures at choices, each on a grid that is fine enough for it."""
    return np.array([_figures(asked, choice, _exactly(asked.plan), x, robust)[0] for x in where])


def _check(wanted: Sequence[str], limits: Mapping[str, float], points: int, robust: Ratio) -> None:
    names = all(isinstance(n, str) for n in wanted)
    if not (names and 1 <= len(wanted) <= 2 and len(set(wanted)) == len(wanted)):
        given = " and ".join(map(str, wanted)) or "nothing"
        raise InputError(Argument("objective"), f" must be one figure or two different ones, not {given}")
    check_largest(limits)
    check_least(limits)
    if not (is_count(points) and 2 <= points <= MOST_CARS):
        raise InputError(
            Argument("points", repr(points)), f" must be a whole number, two or more, and {MOST_CARS} at most"
        )
    if isinstance(robust, bool) or not (is_size(robust) or robust == 0):
        raise InputError(Argument("robust", repr(robust)), " must be a number of standard deviations, 0 or more")
    if robust > CERTAIN:
        raise InputError(
            Argument("robust", f"{robust:g}"),
            f" must be at most {CERTAIN:g} standard deviations: beyond, the result depends on the shape of the "
            f"distribution, which is not known; 1 or 2 are usual",
        )
