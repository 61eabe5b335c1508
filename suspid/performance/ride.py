"""Comfort, travel and wheel load: of a car on a road by its spectra, of a record from its samples."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike
from suspid.errors import InputError
from suspid.files import printable
from suspid.model import ModalSet, Suspension, output_rows
from suspid.performance.figure_plan import ROTATION, SICKNESS, Plan, comfort_of, plan_of
from suspid.performance.figures import check_exposure
from suspid.performance.plausibility import plausible
from suspid.performance.reaches import bends_of, spreads
from suspid.performance.reactions import reaction
from suspid.performance.recorded import recorded
from suspid.performance.rides import Ride
from suspid.performance.road_response import Signals, densities
from suspid.performance.uncertain import Car, Uncertain, uncertain
from suspid.performance.weightings import weighting_named
from suspid.results import Result
from suspid.simulation import ROUGHNESS, Road, places_of, road_class
from suspid.simulation import road as road_of
from suspid.units import Metre, Ratio, RealArray, Second
from suspid.values import FrozenItems, frozen_real, within_numbers
from suspid.wording import Argument
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.ride import RideCheck, RideHeadline

# Speeds of vehicles on wheels [m/s]: below, a car stands; above, no wheel holds.
LEAST_SPEED, MOST_SPEED = 0.1, 350.0
# G_d(n_0) [m3] above which there is no road: twice the mean of class H, the last.
ROUGHEST = 2 * ROUGHNESS["H"]
# Time on the road for which dose values hold, where no other is given.
HOUR: Second = 3600.0
# Ratio of the ends of an interval from which on a figure is not even known to an order of magnitude.
WIDE_RATIO = 10.0
# Figures that count rare events: these vary by orders of magnitude, and are read by whether one is expected.
RARE = ("lift_rate", "stops")


@explained
def ride(
    car: Car | RecordLike,
    *,
    road: Road | str | float | None = None,
    speed: float | None = None,
    duration: Second | None = None,
    weightings: Mapping[str, str | Sequence[str]] | None = None,
    clearance: Mapping[str, Metre | tuple[Metre, Metre]] | None = None,
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
) -> Ride:
    """Return comfort after ISO 2631-1, travel and wheel load, of a car on a road or of a record.

    Those of a car on a random road are expected values, from its exact spectra without a simulation. Those of a record
    are from its samples: weighted rms, VDV or MSDV and crest factor of each acceleration, rms and largest value of each
    travel.

    Parameters
    ----------
    car : Suspension, Estimate, Reconstruction or record, as `as_record` takes it
        A car as described; as estimated: the figures then have the uncertainty of its parameters; or a record.
    road : Road, str or float
        The road, with a car: from `road`, or its class or G_d(n_0) [m3], driven at ``speed``.
    speed : float
        Speed [m/s], with a road that is a class or a number.
    duration : float, optional
        Time over which doses are taken and peaks expected [s]. Default: an hour; the length of a record.
    weightings : mapping of str to str or sequence of str, optional
        Weightings of accelerations, such as ``{"seat_acceleration": ["Wk", "Wf"]}``; see `weighting`. Default: Wk and
        Wf, We of pitch and roll, of all coordinates of a car but its wheels, of sensors of acceleration on them, and of
        the channels of a record that end in ``_acceleration``.
    clearance : mapping of str to float or tuple of float, optional
        Distances of struts to their stops in compression and rebound [m], with a car.
    nominal_std : float, or mapping of str to float, optional
        Relative standard deviation of parameters that were not estimated, as in `grip`.

    Returns
    -------
    Ride
        ``["chassis_acceleration.Wk"]`` is one figure, ``.interval()`` has the ends of all; ``str()`` is the table.

    Raises
    ------
    InputError
        If the road or its speed is missing or given with a record, a name is unknown, or a number is not positive.

    Notes
    -----
    Variances are integrals of the spectra over the wavelengths of the road, to eight digits. With exponent 2 and all
    wavelengths they are those of the Lyapunov equation with white slopes. Intervals are to first order with exact
    derivatives, by relaxations of mounts near zero to second order. VDV and crest factor are those of a Gaussian
    vibration.

    Intervals of a record are those of a chi-square with the degrees of freedom of its spectrum, where steady tones do
    not count, or by the scatter of twenty pieces where that is significantly larger.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300, tire_damping=60)
    >>> found = ride(car, road="C", speed=20.0)
    >>> round(found["chassis_acceleration.Wk"], 3), round(found["tire.load_share"], 3)
    (1.066, 0.24)
    """
    if car is None or (
        isinstance(car, str | os.PathLike | Mapping | Road | Result | ModalSet) and not isinstance(car, Car)
    ):
        raise _not_taken(car)
    if not isinstance(car, Car):
        if road is not None or speed is not None or clearance is not None or nominal_std is not None:
            raise InputError(
                f"road, speed, clearance and nominal_std go with a car; a {type(car).__name__} is taken as a record"
            )
        return recorded(car, duration=duration, weightings=weightings)
    with within_numbers():
        about = uncertain(car, nominal_std)
        seconds = HOUR if duration is None else duration
        check_exposure(seconds)
        driven = driven_road(about.car, road, speed)
        plan = plan_of(about.car, driven, duration=seconds, weightings=weightings, clearance=clearance)
        values, jacobian = plan.values(about.car, parameters=about.parameters, relaxations=about.relaxations)

        def bent(one: Suspension, relaxations: Mapping[str, Second]) -> RealArray:
            return plan.values(one, parameters=about.parameters, relaxations=relaxations)[1]

        channels = tuple(plan.weightings)
        # Frequencies of the spectra of a car.
        hertz = np.geomspace(*driven.band, 1024)
        plain = Signals(rows=output_rows(about.car, channels), weightings=(None,) * len(channels), loads=0)
        figures = tuple(plan.formulas)
        density, slopes = densities(
            about.car, plain, driven, hertz, parameters=about.parameters, relaxations=about.relaxations
        )
        found = Ride(
            figures=figures,
            values=frozen_real(values),
            units=tuple(unit for unit, _, _ in plan.formulas.values()),
            duration=float(seconds),
            parameters=about.parameters,
            jacobian=frozen_real(jacobian),
            bends=frozen_real(bends_of(about, len(values), bent)),
            parameter_values=about.values,
            covariance=about.covariance,
            scatter=frozen_real(np.zeros(len(figures))),
            hertz=frozen_real(hertz),
            channels=channels,
            density=frozen_real(density),
            density_band=frozen_real(
                spreads(slopes.reshape(len(slopes), density.size), about.covariance, about.values).reshape(
                    density.shape
                )
            ),
            weightings=FrozenItems(plan.weightings),
            road=driven,
            about=about,
            verdict=_judged(plan, dict(zip(figures, values.tolist(), strict=True)), about),
        )
        return replace(found, verdict=replace(found.verdict, checks=(*found.verdict.checks, *_wide(found))))


def _not_taken(given: object) -> InputError:
    """Return the error of what is neither a car nor a record."""
    path = printable(os.fspath(given)) if isinstance(given, str | os.PathLike) else ""
    what = f"the path {path!r}" if path else type(given).__name__
    names = [f"read_{kind}({path!r})" if path else f"read_{kind}(…)" for kind in ("car", "record")]
    return InputError(
        f"ride takes a car or a record, not {what}: ride({names[0]}, ",
        Argument("road", '"C"'),
        ", ",
        Argument("speed", "20.0"),
        f") for a car, ride({names[1]}) for a record",
    )


def driven_road(car: Suspension, road: Road | str | float | None, speed: float | None) -> Road:
    """Return the road under a car, from one or from its class and the speed.

    Raises
    ------
    InputError
        If one of both is missing or too much, or the road is under other inputs than those of the car.
    """
    if isinstance(road, Road):
        if speed is not None:
            raise InputError("the road has a speed of its own; leave speed out, or give the class of the road")
        if set(road.places) != set(car.roads):
            raise InputError(
                f"the road is under {', '.join(road.places)}, the car has {', '.join(car.roads)}: road(…, under=car)"
            )
        if tuple(road.places) != car.roads:
            return road_of(
                road.roughness,
                speed=road.speed,
                under={name: road.places[name] for name in car.roads},
                exponent=road.exponent,
                wavelengths=road.wavelengths,
                coherence=road.coherence,
            )
        return road
    if road is None or speed is None:
        raise InputError(
            "a car needs a road and a speed: ",
            Argument("road", '"C"'),
            ", ",
            Argument("speed", "20.0"),
            ", or ",
            Argument("road", 'road("C", speed=20.0, under=car)'),
        )
    driven = road_of(road, speed=speed, under=places_of(car))
    if not LEAST_SPEED <= driven.speed <= MOST_SPEED:
        raise InputError(
            Argument("speed", f"{driven.speed:g}"),
            f" m/s is outside of {LEAST_SPEED:g} to {MOST_SPEED:g} m/s; 20 m/s are 72 km/h",
        )
    if not driven.roughness:
        raise InputError(
            Argument("road", repr(road)),
            " m3 is a flat road: nothing moves, so there are no figures; give a roughness above 0",
        )
    return driven


def _judged(plan: Plan, values: Mapping[str, float], about: Uncertain) -> Verdict:
    driven = plan.road
    checks = [*plausible(plan.car), *_comforts(plan, values), *_limits_met(plan, values)]
    if driven.roughness > ROUGHEST:
        rough: dict[str, Number] = {"roughness": driven.roughness, "limit": ROUGHEST}
        checks.append(Check(Remark(RideCheck.TOO_ROUGH, rough), Level.DOUBTFUL))
    low = driven.band[0]
    weighs = weighting_named(SICKNESS).f1
    if low > weighs and any(SICKNESS in kinds for kinds in plan.weightings.values()):
        numbers = {"metres": driven.wavelengths[1], "hertz": low}
        checks.append(Check(Remark(RideCheck.LONG_WAVES, numbers), Level.NOTE))
    if about.doubt is not None:
        checks.append(Check(Remark(RideCheck.UNTRUSTED, {"level": about.doubt.label}), about.doubt))
    if about.nominal:
        checks.append(Check(Remark(RideCheck.STAYED_NOMINAL, {"names": about.nominal}), Level.CARE))
    if about.known:
        checks.append(Check(Remark(RideCheck.KNOWN, {"names": about.known}), Level.NOTE))
    roughness = driven.roughness
    said: dict[str, Number] = {"speed": driven.speed, "roughness": roughness, "class": road_class(roughness)}
    return Verdict(Remark(RideHeadline.DRIVEN, said), tuple(checks))


def _comforts(plan: Plan, values: Mapping[str, float]) -> Iterator[Check]:
    """Yield what people say of each vertical or horizontal acceleration."""
    for channel, kinds in plan.weightings.items():
        kind = comfort_of(kinds)
        if kind is not None and kind not in ROTATION:
            yield reaction(channel, values[f"{channel}.{kind}"])


def _limits_met(plan: Plan, values: Mapping[str, float]) -> Iterator[Check]:
    """Yield where the linear figures are not those of the car: wheels that leave the road, stops that are reached."""
    for name, value in values.items():
        part, _, figure = name.rpartition(".")
        code, what = {"lift_rate": (RideCheck.LIFTS, "wheel"), "stops": (RideCheck.STOPS, "strut")}.get(
            figure, (None, "")
        )
        if code is not None and value * plan.duration > 1:
            numbers: dict[str, Number] = {what: part, "times": value * plan.duration, "seconds": plan.duration}
            yield Check(Remark(code, numbers), Level.CARE)


def _wide(found: Ride) -> Iterator[Check]:
    """Yield which figures the parameters do not tell: to an order of magnitude, or whether an event is expected."""
    untold, events = [], []
    for name, (low, high) in found.interval().items() if found.parameters else ():
        figure = name.rpartition(".")[2]
        # No event is more frequent than the fastest motion of the road.
        if figure in RARE and (low * found.duration < 1 < high * found.duration or high > found.hertz[-1]):
            events.append(name)
        elif figure not in (*RARE, "lifts") and high > WIDE_RATIO * low:
            untold.append(name)
    if untold:
        yield Check(Remark(RideCheck.WIDE, {"names": tuple(untold), "ratio": WIDE_RATIO}), Level.CARE)
    if events:
        yield Check(Remark(RideCheck.EVENTS, {"names": tuple(events), "seconds": found.duration}), Level.CARE)
