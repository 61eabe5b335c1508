"""The optimal curve of a damper for several roads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model import Strut, Suspension, positive_number
from suspid.performance.choices import REACH_OF_BOUNDS, REACHED, check_ascent
from suspid.performance.damper_rates import dampers_between
from suspid.performance.damper_search import OnRoad, Search, on_road
from suspid.performance.damper_tunings import DamperTuning
from suspid.performance.figure_plan import plan_of
from suspid.performance.plausibility import plausible
from suspid.performance.relations import check_largest
from suspid.performance.ride import HOUR, driven_road
from suspid.performance.uncertain import Car, Uncertain, uncertain
from suspid.simulation import Road
from suspid.units import Metre, NewtonSecondPerMetre, Ratio, RealArray, Second
from suspid.values import frozen_real, is_size, nearest_names
from suspid.wording import Argument
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.ride import RideCheck
from suspid.words.tuning import DamperTuningCheck, DamperTuningHeadline

# Force in rebound over that in compression, or the inverse; beyond, one direction has no damper to speak of.
MOST_REBOUND = 10.0
# Points of a curve on each side of zero, between these multiples of the least and the largest rms velocity.
KNOTS, KNOTS_FROM, KNOTS_TO = 6, 0.5, 2.5
# Damper rates at which each road is computed; between them figures are on splines, to 1e-6.
RATES = 33
# Rates among which the best for one road, and the best single one, are looked for.
FINE = 2001


@explained
def tune_damper(
    car: Car,
    *,
    strut: str,
    roads: Sequence[tuple[str | float, float] | Road],
    objective: str,
    constraints: Mapping[str, float] | None = None,
    bounds: tuple[NewtonSecondPerMetre, NewtonSecondPerMetre] | None = None,
    rebound: Ratio = 1.0,
    duration: Second = HOUR,
    weightings: Mapping[str, str | Sequence[str]] | None = None,
    clearance: Mapping[str, Metre | tuple[Metre, Metre]] | None = None,
) -> DamperTuning:
    """Return the curve of a damper that is best over several roads.

    For where one damper rate does not do: soft on smooth roads, and strong where wheel load or travel ask for it.

    Parameters
    ----------
    car : Suspension, Estimate or Reconstruction
        The car to begin with.
    strut : str
        The strut whose damper is chosen.
    roads : sequence of (class, speed) or Road
        The roads: class of ISO 8608 or G_d(n_0) [m3] with the speed [m/s], or from `road`.
    objective : str
        The figure of `ride` that is to be small on each road, such as ``"chassis_acceleration.Wk"``.
    constraints : mapping of str to float, optional
        Largest values of figures on every road, such as ``{"tire.load_share": 1 / 3}``, in SI units.
    bounds : tuple of float, optional
        Least and largest damper rate [N s/m]. Default: a quarter to four times the strut's own.
    rebound : float
        Force in rebound over that in compression, positive.
    duration, weightings, clearance
        As in `ride`.

    Returns
    -------
    DamperTuning
        ``.strut`` has the curve; ``str()`` is the table of roads.

    Raises
    ------
    InputError
        If a name is unknown, no damper rate meets the constraints on one of the roads, no curve those on all, or a
        number is not positive.

    Notes
    -----
    Under a Gaussian velocity of standard deviation s a curve f takes as much work as the damper rate E[f'(v)]
    (statistical linearisation; J. B. Roberts and P. D. Spanos, Random Vibration and Statistical Linearization, Wiley
    1990, ch. 5). The slopes of the curve are those with the least mean logarithm of the objective over the roads that
    keep the limits on all of them, by sequential quadratic programming. The figures are those of the damper rate of
    equal work on each road; how far those of the curve itself are from them is measured by ``python -m validation
    ride``. A curve that is stronger in one direction moves the position of rest, which is left out.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune_damper(car, strut="chassis", roads=[("A", 30.0), ("C", 20.0), ("D", 14.0)],
    ...                     objective="chassis_acceleration.Wk", constraints={"chassis.travel": 0.018})
    >>> bool(found.damping[2] > 1.5 * found.damping[0])
    True
    """
    found = uncertain(car)
    start = found.car
    about = _between(start, strut)
    if not isinstance(objective, str):
        raise InputError(
            Argument("objective", repr(objective)), " must be the name of a figure such as 'chassis_acceleration.Wk'"
        )
    positive_number("duration", duration, "s")
    check_largest(constraints or {})
    if not (is_size(rebound) and 1 / MOST_REBOUND <= rebound <= MOST_REBOUND):
        raise InputError(
            f"{rebound=!r:.40} must be a positive ratio of forces, from {1 / MOST_REBOUND:g} to {MOST_REBOUND:g}; "
            f"dampers of cars have 1 to 5"
        )
    limits = dict(constraints or {})
    figures = (objective, *(name for name in limits if name != objective))
    if isinstance(roads, str | Road) or not isinstance(roads, Sequence):
        raise InputError(f"roads: {roads!r:.60} must be a list of pairs of class and speed such as [('C', 20.0)]")
    driven = [driven_road(start, *_pair(one)) for one in roads]
    if not driven:
        raise InputError("roads is empty; give pairs of class and speed such as ('C', 20.0)")
    if bounds is None and not about.damping:
        raise InputError(f"strut {strut!r} has no damper to begin with; give bounds of its rate [N s/m]")
    ends = (about.damping / REACH_OF_BOUNDS, about.damping * REACH_OF_BOUNDS) if bounds is None else bounds
    check_ascent(ends)
    low, high = ends
    rates = np.geomspace(low, high, RATES)
    plans = [plan_of(start, one, duration=duration, weightings=weightings, clearance=clearance) for one in driven]
    places = [on_road(start, strut, plan.only(figures), rates) for plan in plans]
    tops = np.array([limits.get(name, np.inf) for name in figures])
    fine = np.geomspace(low, high, FINE)
    every = np.array([place.at(fine) for place in places])  # (road, rate, figure)
    met = np.all(every <= tops, axis=2)
    for one, possible in zip(driven, met, strict=True):
        if not np.any(possible):
            raise InputError(
                f"no damper rate within {low:.4g} and {high:.4g} N s/m meets {limits} on the road of "
                f"{1e6 * one.roughness:.4g}e-6 m3 at {one.speed:.4g} m/s; widen the bounds or the limits"
            )
    cost = np.log(every[:, :, 0])
    best = fine[np.argmin(np.where(met, cost, np.inf), axis=1)]
    together = np.where(np.all(met, axis=0), np.mean(cost, axis=0), np.inf)
    single = float(fine[np.argmin(together)]) if np.any(np.isfinite(together)) else None
    slow, fast = (float(np.exp(place.speed(np.log(c)))) for place, c in _ends(places, best))
    knots = np.geomspace(KNOTS_FROM * slow, KNOTS_TO * fast, KNOTS)
    search = Search(places=places, knots=knots, low=low, high=high, tops=np.log(tops))
    slopes, damping, agreed = search.best([best, np.full(len(best), single or np.exp(np.mean(np.log(best))))])
    if slopes is None:
        raise InputError(f"no curve with slopes within {low:.4g} and {high:.4g} N s/m meets {limits} on all roads")
    values = np.array([place.at(c) for place, c in zip(places, damping, strict=True)])
    return DamperTuning(
        strut=_curved(about, knots, slopes, rebound, float(np.mean(damping))),
        car=start,
        roads=tuple(driven),
        figures=figures,
        units=places[0].units,
        asked=frozen_real(best),
        damping=frozen_real(damping),
        velocity=frozen_real([np.exp(place.speed(np.log(c))) for place, c in zip(places, damping, strict=True)]),
        values=frozen_real(values),
        best=frozen_real([place.at(c) for place, c in zip(places, best, strict=True)]),
        single=single,
        single_values=frozen_real([] if single is None else [place.at(single) for place in places]),
        verdict=Verdict(
            Remark(DamperTuningHeadline.CURVE, {"strut": strut, "roads": len(driven)}),
            (
                *_checks(agreed, rebound, single, found),
                *_at_ends(damping, ends, stated=bounds is not None),
            ),
        ),
    )


def _pair(one: tuple[str | float, float] | Road) -> tuple[Road | str | float, float | None]:
    if isinstance(one, Road):
        return one, None
    if not (isinstance(one, tuple | list) and len(one) == 2):
        raise InputError(f"roads: {one!r} must be a pair of class and speed such as ('C', 20.0), or a Road")
    return one[0], one[1]


def _ends(places: Sequence[OnRoad], rates: RealArray) -> list[tuple[OnRoad, float]]:
    """Return the roads on which the damper is slowest and fastest, each with its rate."""
    speeds = [float(place.speed(np.log(c))) for place, c in zip(places, rates, strict=True)]
    return [(places[i], float(rates[i])) for i in (int(np.argmin(speeds)), int(np.argmax(speeds)))]


def _curved(about: Strut, knots: RealArray, slopes: RealArray, rebound: Ratio, rate: float) -> Strut:
    """Return the strut with the curve: force over velocity, stronger in rebound, of equal work in the mean."""
    ends = np.append(knots, 2 * knots[-1])
    force = np.cumsum(slopes * np.diff(np.concatenate([[0.0], ends])))
    out, back = 2 * rebound / (1 + rebound), 2 / (1 + rebound)
    velocities, forces = (
        np.concatenate([-ends[::-1], [0.0], ends]),
        np.concatenate([-back * force[::-1], [0.0], out * force]),
    )
    return replace(about, damping=rate, curve=tuple(zip(velocities.tolist(), forces.tolist(), strict=True)))


def _at_ends(damping: RealArray, ends: tuple[float, float], *, stated: bool) -> Iterator[Check]:
    """Yield on how many roads a bound of the damper rate decides; one that nobody stated is a doubt."""
    for side, end in zip(("least", "largest"), ends, strict=True):
        count = int(np.sum(np.abs(np.log(damping / end)) < REACHED))
        if count:
            numbers: dict[str, Number] = {"side": side, "rate": end, "count": count, "roads": len(damping)}
            yield Check(Remark(DamperTuningCheck.AT_BOUND, numbers), Level.NOTE if stated else Level.CARE)


def _between(car: Suspension, name: str) -> Strut:
    """Return the strut of that name between masses."""
    between = {one.name: one for one in dampers_between(car)}
    if name in between:
        return between[name]
    if name in [one.name for one in car.struts]:
        raise InputError(
            f"strut {name!r} is on the road: the damping of a tire cannot be tuned; name a strut between masses, "
            f"{', '.join(between)}"
        )
    raise InputError(f"there is no strut {name!r}.{nearest_names(str(name), between)}")


def _checks(agreed: Ratio, rebound: Ratio, single: float | None, about: Uncertain) -> Iterator[Check]:
    yield from plausible(about.car)
    if about.doubt is not None:
        yield Check(Remark(RideCheck.UNTRUSTED, {"level": about.doubt.label}), about.doubt)
    yield Check(Remark(DamperTuningCheck.STARTS, {"share": agreed}), Level.SOUND if agreed > 0.5 else Level.CARE)
    if single is None:
        yield Check(Remark(DamperTuningCheck.NO_SINGLE), Level.NOTE)
    if rebound != 1:
        yield Check(Remark(DamperTuningCheck.UNEVEN, {"ratio": rebound}), Level.NOTE)
    yield Check(Remark(DamperTuningCheck.GAUSSIAN), Level.NOTE)
