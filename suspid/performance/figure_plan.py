"""Plan of the figures of a ride: signals on a road, and the figures computed from their moments."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension, check_linear, output_rows, output_weights
from suspid.performance.contact import carried_loads, wheels_of
from suspid.performance.figures import (
    Formula,
    Moment,
    crest,
    crossings,
    dose,
    lift_rate,
    lifts,
    peak,
    rms,
    share,
    sickness,
)
from suspid.performance.road_response import Grid, Signals, exact_grid, moments
from suspid.performance.weightings import weighting_named
from suspid.simulation import Road
from suspid.units import Metre, RealArray, Second
from suspid.values import is_size, nearest_names
from suspid.wording import Argument

# ISO 2631-1: of seat and floor, vertical vibration counts by Wk, its slow part by Wf (motion sickness), rotation by We.
VERTICAL, ROTATION = ("Wk", "Wf"), ("We",)
SICKNESS = "Wf"
ANGLES = ("pitch", "roll")
# Largest distance to a stop that any vehicle has room for [m].
MOST_CLEARANCE = 1.5
ACCELERATION, TRAVEL = "_acceleration", "_travel"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Plan:
    """What is asked of a ride: which signals on which road, and what becomes of their moments.

    ``formulas`` are, by name of a figure, its unit, the place of its signal and its formula.
    """

    car: Suspension
    road: Road
    duration: Second
    signals: Signals
    formulas: Mapping[str, tuple[str, int, Formula]]
    weightings: Mapping[str, tuple[str, ...]]  # of each channel

    def only(self, names: Sequence[str]) -> Plan:
        """Return the plan for some of its figures.

        Raises
        ------
        InputError
            If the car has no such figure.
        """
        for name in names:
            if name not in self.formulas:
                raise InputError(f"there is no figure {name!r}.{nearest_names(name, self.formulas)}")
        motions = len(self.signals.weightings)
        used = sorted({self.formulas[name][1] for name in names if self.formulas[name][1] < motions})
        loads = self.signals.loads if any(self.formulas[name][1] >= motions for name in names) else 0
        rows = self.signals.rows
        place = {old: new for new, old in enumerate(used)} | {motions + i: len(used) + i for i in range(loads)}
        return replace(
            self,
            signals=Signals(
                rows=type(rows)(rows.orders[used], rows.coordinates[used], rows.roads[used]),
                weightings=tuple(self.signals.weightings[i] for i in used),
                loads=loads,
            ),
            formulas={
                name: (self.formulas[name][0], place[self.formulas[name][1]], self.formulas[name][2]) for name in names
            },
        )

    def values(
        self,
        car: Suspension,
        *,
        parameters: Sequence[str] = (),
        grid: Grid | None = None,
        relaxations: Mapping[str, Second] | None = None,
    ) -> tuple[RealArray, RealArray]:
        """Return all figures of a car and their derivatives, (figure,) and (figure, parameter).

        Without a grid the integrals are refined until they are exact.
        """
        used = exact_grid(car, self.signals, self.road) if grid is None else grid
        found = moments(car, self.signals, used, parameters=parameters, relaxations=relaxations)
        loads: tuple[RealArray, RealArray] | None = None
        if self.signals.loads:
            loads = carried_loads(wheels_of(car), parameters)
        motions = len(self.signals.weightings)
        pairs = []
        for _, at, formula in self.formulas.values():
            wheel = at - motions
            static = (float(loads[0][wheel]), loads[1][:, wheel]) if loads is not None and wheel >= 0 else None
            pairs.append(formula(Moment.of(found, at), self.duration, static))
        return np.array([value for value, _ in pairs]), np.array([slopes for _, slopes in pairs]).reshape(
            len(pairs), len(parameters)
        )


OF_WHEEL: tuple[tuple[str, str, Formula], ...] = (
    ("load", "N", rms),
    ("load_share", "1", share),
    ("lifts", "1", lifts),
    ("lift_rate", "1/s", lift_rate),
)


def plan_of(
    car: Suspension,
    road: Road,
    *,
    duration: Second,
    weightings: Mapping[str, str | Sequence[str]] | None = None,
    clearance: Mapping[str, Metre | tuple[Metre, Metre]] | None = None,
) -> Plan:
    """Return all figures that a car has on a road."""
    check_linear(car, "the ride by spectra")
    wheels = wheels_of(car)
    chosen = default_weightings(car, wheels.names) if weightings is None else checked_weightings(weightings)
    struts = [s.name for s in car.struts if not any(s.arms.get(r) for r in car.roads)]
    given = _limits(clearance or {}, struts)
    names: list[str] = []
    filters: list[str | None] = []
    formulas: dict[str, tuple[str, int, Formula]] = {}
    for channel in chosen:
        if output_weights(car, channel)[0] != 2:
            raise InputError(
                Argument("weightings"),
                f": {channel!r} is not an acceleration, and only these are weighted; name one such as "
                f"'{channel.partition('_')[0]}{ACCELERATION}'",
            )
    for channel, kinds in chosen.items():
        turn = "rad" if channel.removesuffix(ACCELERATION) in ANGLES else "m"
        formulas[f"{channel}.rms"] = f"{turn}/s2", len(names), rms
        names.append(channel)
        filters.append(None)
        comfort = comfort_of(kinds)
        for kind in kinds:
            for figure, unit, formula in _of_acceleration(kind, turn, first=kind == comfort):
                formulas[f"{channel}.{figure}"] = unit, len(names), formula
            names.append(channel)
            filters.append(kind)
    for strut in struts:
        for figure, unit, formula in _of_travel(given.get(strut)):
            formulas[f"{strut}.{figure}"] = unit, len(names), formula
        names.append(f"{strut}{TRAVEL}")
        filters.append(None)
    for i, wheel in enumerate(wheels.names):
        for figure, unit, formula in OF_WHEEL:
            formulas[f"{wheel}.{figure}"] = unit, len(names) + i, formula
    return Plan(
        car=car,
        road=road,
        duration=duration,
        signals=Signals(rows=output_rows(car, names), weightings=tuple(filters), loads=len(wheels.names)),
        formulas=formulas,
        weightings=chosen,
    )


def _of_acceleration(kind: str, turn: str, *, first: bool) -> Iterator[tuple[str, str, Formula]]:
    """Yield the figures of an acceleration by one weighting; dose and crest are those of the first one for comfort."""
    yield kind, f"{turn}/s2", rms
    if kind == SICKNESS:
        yield "MSDV", f"{turn}/s1.5", sickness
    elif first:
        yield "VDV", f"{turn}/s1.75", dose
        yield "crest", "1", crest


def _of_travel(limits: tuple[Metre, Metre] | None) -> Iterator[tuple[str, str, Formula]]:
    yield "travel", "m", rms
    yield "peak_travel", "m", peak
    if limits is not None:
        yield "stops", "1/s", crossings(limits)


def default_weightings(car: Suspension, wheels: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the accelerations that people feel: sensors of acceleration off the wheels, else all other coordinates."""
    felt = [c for c in car.coordinates if c not in wheels]
    sensors = [
        s.name
        for s in car.sensors
        if s.motion == "acceleration"
        and not isinstance(s.of, str)
        and not any(s.of.get(w) for w in (*wheels, *car.roads))
    ]
    channels = [*(f"{c}{ACCELERATION}" for c in felt), *sensors]
    return {c: ROTATION if c.removesuffix(ACCELERATION) in ANGLES else VERTICAL for c in channels}


def comfort_of(kinds: Sequence[str]) -> str | None:
    """Return the first weighting that is one of comfort, on which dose, crest and reaction rest."""
    return next((kind for kind in kinds if kind != SICKNESS), None)


def checked_weightings(given: Mapping[str, str | Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Return the weightings of each channel, checked."""
    form = ' must map channels to weightings, as in {"seat_acceleration": "Wk"} or ["Wk", "Wf"]'
    if not isinstance(given, Mapping):
        raise InputError(Argument("weightings", f"{given!r:.80}"), form)
    if not given:
        raise InputError(Argument("weightings"), " is empty; leave it out for Wk and Wf of all accelerations; it", form)
    for channel, kinds in given.items():
        if not isinstance(channel, str):
            raise InputError(Argument("weightings"), f": {channel!r} is not the name of a channel; it", form)
        listed = [kinds] if isinstance(kinds, str) else kinds
        if not (isinstance(listed, list | tuple) and all(isinstance(kind, str) for kind in listed)):
            raise InputError(Argument("weightings"), f": {channel!r} has {kinds!r:.40}; it", form)
        if len(set(listed)) < len(listed):
            raise InputError(Argument("weightings"), f": {channel!r} has a weighting twice, {', '.join(listed)}")
    chosen = {channel: (kinds,) if isinstance(kinds, str) else tuple(kinds) for channel, kinds in given.items()}
    for channel, kinds in chosen.items():
        for kind in kinds:
            weighting_named(kind)
        if not kinds:
            raise InputError(Argument("weightings"), f": {channel!r} has none; leave the channel out")
    return chosen


def _limits(given: Mapping[str, Metre | tuple[Metre, Metre]], struts: Sequence[str]) -> dict[str, tuple[Metre, Metre]]:
    limits: dict[str, tuple[Metre, Metre]] = {}
    if not isinstance(given, Mapping):
        raise InputError(
            Argument("clearance", f"{given!r:.80}"), ' must map struts to distances [m], as in {"chassis": 0.08}'
        )
    for name, ends in given.items():
        if name not in struts:
            raise InputError(
                Argument("clearance"), f": there is no strut {name!r} off the road.{nearest_names(name, struts)}"
            )
        both = tuple(ends) if isinstance(ends, tuple | list) else (ends, ends)
        if all(is_size(end) for end in both) and max(both) > MOST_CLEARANCE:
            raise InputError(
                Argument("clearance"),
                f": {name!r} = {max(both):g} m is more than any suspension has, {MOST_CLEARANCE:g} m; give it in m",
            )
        if len(both) != 2 or not all(is_size(end) for end in both):
            raise InputError(
                Argument("clearance"), f": {name!r} = {ends!r} must be positive distances to the stops [m]"
            )
        limits[name] = float(both[0]), float(both[1])
    return limits
