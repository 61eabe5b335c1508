"""Grip and wear from everyday drives: do intervals hold, and how often is a verdict wrong.

Drives come from the independent motion of `validation.motion` and are fitted by `suspid.estimate`, one by one. Only the
rows of trends that say so draw estimates from the covariance that such fits state.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from suspid import (
    DamperState,
    Estimate,
    Suspension,
    SuspidError,
    WearRule,
    estimate,
    grip,
    wear,
)  # fmt: skip
from suspid.fleet import trends_of_rates
from suspid.levels import NORMAL_95
from suspid.performance import Rates, rates_of
from suspid.performance.reaches import reaches
from suspid.text_tables import text_table
from suspid.units import RealArray, Second
from validation.bent_wear import bent_section
from validation.greybox_rows import KNOWN, MOUNTED, QUARTER, given_row, half
from validation.motion import Drive

SEEDS = int(os.environ.get("SUSPID_SEEDS", "100"))
RULE = WearRule()
DRIVES = 10  # of a vehicle with a trend
EARLIER = 8  # drives of a history
STATES = tuple(DamperState)
MANY = 200  # vehicles whose estimates are drawn
FRESH = 50_000  # first seed of the drives of the table of grip, which development has not seen
FITTED = 30  # vehicles of every hundred whose drives are fitted
# Relative covariance of c and k that fits of 60 s state, with gain, delay and mount unknown.
STATED = np.array([[8e-3, 3.5e-3], [3.5e-3, 3.4e-3]]) ** 2
Drawn: TypeAlias = tuple[str, str, float, Rates]

HEAD = """# Grip and wear from everyday drives

Drives of 60 s come from an independent integrator (`validation/motion.py`) and are fitted one by one; gain and delay of
the wheels' sensors and the mounts of the dampers are unknown to the fit. `SUSPID_SEEDS=100 python -m validation wear`
prints these tables."""
GRIP = """## Grip of cars identified from one drive

Class B, 20 m/s ±15 %. Adhesion after EUSAMA and least phase after EGEA of all wheels against those of the true car.
Tires and masses are known. 'stated' is the median standard deviation; coverage is that of 95 % intervals, of the
adhesion before it is cut at 0: at 400 N s/m the wheel leaves the platform, the adhesion is 0 and so are both ends of
its interval. Where there is no mount, its relaxation is estimated as zero in half of the drives. The
drives were not used in development."""
PAIRS = """## Verdicts from two drives

A quarter car, 1300 N s/m when new. From drive to drive its damper varies by {damper:.0%} (temperature), its spring by
{spring:.0%} and the mass of its body by {load:.0%} (load), normal in the logarithm; the fit knows nothing of that.
Roads are of class B or C, speeds 15 to 25 m/s. 'nominal': no earlier drive; the new damper and spring differ from their
nominal values by {nominal:.0%}. 'history': {earlier} earlier drives, whose own scatter is used. The rule is the default
one: at most {rate:.1%} of the dampers that lost no more than {small:.0%} may be called worn, and as many of those that
lost {large:.0%} or more good. A loss of half brings the least phase near EGEA's limit. Cannot tell: the interval is too
wide, or the estimate itself is doubtful."""
TRENDS = """## Trends over {drives} drives

Vehicles as above, each with {drives} drives over which the damper loses its share evenly. 'fits': every drive is
simulated and fitted. 'drawn': k and c are drawn with the covariance that such fits state, {many} vehicles in fleets of
100. 'fleet': all vehicles of a fleet together, whose scatter from drive to drive is shared; 'alone': each vehicle by
itself. Told: watch or worn."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Day:
    """What a drive has of its own, as factors: damper, spring and mass of the body, with road and speed."""

    damper: float
    spring: float
    mass: float
    road: str
    speed: float


def day(rng: np.random.Generator, rule: WearRule = RULE) -> Day:
    """Return another day."""
    damper, spring, mass = np.exp(np.array([rule.damper_std, rule.spring_std, rule.load_std]) * rng.standard_normal(3))
    road = ("B", "C")[int(rng.integers(2))]
    return Day(damper=damper, spring=spring, mass=mass, road=road, speed=float(rng.uniform(15, 25)))


def drive_of(
    car: Suspension,
    drive: Drive,
    seed: int,
    *,
    nominal: Suspension | None = None,
    options: Mapping[str, Any] | None = None,
) -> Estimate | None:
    """Return what is found from a drive of a car; None if nothing is."""
    row = given_row("", drive, car=car, options=options)
    start = row.nominal if nominal is None else nominal
    try:
        record = row.record(np.random.default_rng(seed))
        return estimate(record, start, given=row.given, fixed=row.fixed, **row.options)
    except SuspidError:
        return None


def worn_drive(remaining: float, seed: int, duration: Second = 60.0) -> Estimate | None:
    """Return what is found from a drive on another day with so much of the damping left; the fit knows the new car."""
    own = day(np.random.default_rng([seed, 1]))
    strut = QUARTER.struts[0]
    car = QUARTER.with_parameters(
        damping={"chassis": strut.damping * remaining * own.damper},
        stiffness={"chassis": strut.stiffness * own.spring},
        masses={"chassis": QUARTER.masses["chassis"] * own.mass},
    )
    return drive_of(car, Drive(road=own.road, speed=own.speed, duration=duration), seed, nominal=QUARTER)


def found(estimates: Sequence[Estimate | None]) -> list[Estimate]:
    """Return the drives from which something was found."""
    return [one for one in estimates if one is not None]


def grip_rows(name: str, car: Suspension, count: int, *, options: Mapping[str, Any] | None = None) -> list[list[str]]:
    """Return the rows of a car in the table of grip: one for the adhesion, one for the least phase."""
    truth = grip(car)
    drives = found([drive_of(car, Drive(), seed, options=options) for seed in range(FRESH, FRESH + count)])
    judged = [grip(one) for one in drives]
    rows = []
    reached = [reaches(g.jacobian.T, g.covariance, g.parameter_values, NORMAL_95, g.bends) for g in judged]
    wheels = len(truth.wheels)
    for first, what, deviation, title, scale in (
        (0, "least", "adhesion_std", "adhesion [%]", 100.0),
        (wheels, "phase", "phase_std", "phase [deg]", float(np.degrees(1.0))),
    ):
        low, high = (np.array([pair[side] for pair in reached])[:, first : first + wheels] for side in (0, 1))
        true = getattr(truth, what)
        stds = np.array([getattr(one, deviation) for one in judged])
        error = np.array([getattr(one, what) for one in judged]) - true
        rows.append(
            [
                name,
                title,
                str(count),
                str(count - len(drives)),
                _span(scale * true, "{:.1f}"),
                _span(scale * np.mean(error, axis=0), "{:+.2f}"),
                _span(scale * np.sqrt(np.mean(error**2, axis=0)), "{:.2f}"),
                _span(scale * np.median(stds, axis=0), "{:.2f}"),
                f"{np.mean((error <= low) & (-error <= high)):.1%}",
            ]
        )
    return rows


def _span(values: RealArray, form: str) -> str:
    return ", ".join(form.format(value) for value in values)


def grip_table(seeds: int) -> str:
    """Return the table of grip."""
    heads = ("car", "figure", "drives", "failed", "true", "bias", "RMSE", "stated", "coverage")
    damped = {c: QUARTER.with_parameters(damping={"chassis": c}) for c in (1300, 900, 650, 400)}
    # A share of 0.95 is known to 1.5 % from 200 drives.
    many = max(seeds, 200)
    rows = [
        *(row for c, car in damped.items() for row in grip_rows(f"{c} N s/m", car, many)),
        *grip_rows("650 N s/m, gain, delay, mount known", damped[650], many, options=KNOWN),
        *grip_rows("1300 N s/m, mount 1e6 N/m", MOUNTED, many),
        *grip_rows("half car", half(0.1), many),
        *grip_rows("half car, gain, delay, mount known", half(0.1), many, options=KNOWN),
    ]
    return text_table({head: [row[i] for row in rows] for i, head in enumerate(heads)})


def shares(states: Sequence[DamperState]) -> dict[DamperState, float]:
    """Return the share of each state."""
    return {state: float(np.mean([one is state for one in states])) for state in STATES}


def pair_table(seeds: int, bank: Callable[[float, int, int], list[Estimate]]) -> str:
    """Return the table of verdicts; ``bank`` makes drives of a remaining share, a number of them, from a seed on."""
    columns: dict[str, list[str]] = {name: [] for name in ("against", "lost", "runs", *map(str, STATES))}
    old = bank(1.0, 4 * seeds, 0)
    for remaining, count in ((1.0, 4), (0.9, 1), (0.8, 1), (0.7, 4), (0.5, 1)):
        new = bank(remaining, count * seeds, 100_000)
        rng = np.random.default_rng(5)
        against: dict[str, list[DamperState]] = {"one drive": [], "history": [], "nominal": []}
        for i, one in enumerate(new):
            against["one drive"].append(wear(one, before=old[i % len(old)]).states["chassis"])
            some = [old[k] for k in rng.choice(len(old), EARLIER, replace=False)]
            against["history"].append(wear(one, before=some).states["chassis"])
            against["nominal"].append(wear(replace(one, nominal=_stated(rng))).states["chassis"])
        for name, states in against.items():
            cells = [name, f"{1 - remaining:.0%}", str(len(states)), *(f"{s:.2%}" for s in shares(states).values())]
            for column, cell in zip(columns.values(), cells, strict=True):
                column.append(cell)
    return text_table(columns)


def _stated(rng: np.random.Generator) -> Suspension:
    """Return nominal values from which the new car differs by chance."""
    strut = QUARTER.struts[0]
    factors = np.exp(RULE.nominal_std * rng.standard_normal(2))
    return QUARTER.with_parameters(
        damping={"chassis": strut.damping * factors[0]}, stiffness={"chassis": strut.stiffness * factors[1]}
    )


def trend_table(seeds: int) -> str:
    """Return the table of trends."""
    names = ("estimates", "lost", "scatter", "judged", "vehicles", "told", "worn", "good", "cannot tell", "loss found")
    columns: dict[str, list[str]] = {name: [] for name in names}

    def add(estimates: str, lost: float, scatter: float, fleets: Sequence[Sequence[Drawn]]) -> None:
        rows = [row for fleet in fleets for row in fleet]
        alone = [
            trends_of_rates([row for row in fleet if row[0] == name], RULE)
            for fleet in fleets
            for name in dict.fromkeys(row[0] for row in fleet)
        ]
        for judged, found in (("fleet", [trends_of_rates(fleet, RULE) for fleet in fleets]), ("alone", alone)):
            trends = [one for some in found for one in some.trends]
            said = shares([one.state for one in trends])
            losses = np.array([one.loss.value for one in trends])
            told = said[DamperState.WATCH] + said[DamperState.WORN]
            cells = (
                estimates, f"{lost:.0%}", f"{scatter:.0%}", judged, str(len(rows) // DRIVES), f"{told:.1%}",
                f"{said[DamperState.WORN]:.1%}", f"{said[DamperState.GOOD]:.1%}",
                f"{said[DamperState.CANNOT_TELL]:.1%}", f"{np.mean(losses):.1%} ± {np.std(losses):.1%}",
            )  # fmt: skip
            for column, cell in zip(columns.values(), cells, strict=True):
                column.append(cell)

    for lost, scatter in ((0.0, 0.03), (0.1, 0.0), (0.1, 0.01), (0.1, 0.02), (0.1, 0.03), (0.2, 0.03)):
        rng = np.random.default_rng(9)
        add("drawn", lost, scatter, [drawn_fleet(lost, scatter, rng) for _ in range(MANY // 100)])
    fitted = [
        (f"vehicle {vehicle}", "chassis", float(k), rates_of(one, "chassis"))
        for vehicle in range(FITTED * seeds // 100)
        for k in range(DRIVES)
        for one in found([worn_drive(1 - 0.1 * k / (DRIVES - 1), 300_000 + DRIVES * vehicle + k)])
    ]
    add("fits", 0.1, RULE.damper_std, [fitted])
    return text_table(columns)


def drawn_fleet(lost: float, scatter: float, rng: np.random.Generator) -> list[Drawn]:
    """Return the drives of 100 vehicles, with the errors that fits of 60 s state."""
    rows: list[Drawn] = []
    for vehicle in range(100):
        for k in range(DRIVES):
            own = day(rng, replace(RULE, damper_std=scatter))
            error = rng.multivariate_normal(np.zeros(2), STATED)
            c = 1300 * (1 - lost * k / (DRIVES - 1)) * own.damper / own.mass * np.exp(error[0])
            stiffness = 22e3 * own.spring / own.mass * np.exp(error[1])
            covariance = STATED * np.outer([c, stiffness], [c, stiffness])
            rates = Rates(damping=float(c), stiffness=float(stiffness), covariance=covariance)
            rows.append((f"vehicle {vehicle}", "chassis", float(k), rates))
    return rows


def drives_of(remaining: float, count: int, first: int) -> list[Estimate]:
    """Return what is found from a number of drives with a share of the damping left."""
    return found([worn_drive(remaining, first + round(1e6 * remaining) + seed) for seed in range(count)])


def report() -> str:
    """Return the tables."""
    numbers = {
        "damper": RULE.damper_std, "spring": RULE.spring_std, "load": RULE.load_std, "nominal": RULE.nominal_std,
        "small": RULE.small, "large": RULE.large, "rate": RULE.rate, "earlier": EARLIER, "drives": DRIVES, "many": MANY,
    }  # fmt: skip
    parts = [
        HEAD,
        f"{GRIP}\n\n```\n{grip_table(SEEDS)}\n```",
        f"{PAIRS.format_map(numbers)}\n\n```\n{pair_table(SEEDS, drives_of)}\n```",
        f"{TRENDS.format_map(numbers)}\n\n```\n{trend_table(SEEDS)}\n```",
        bent_section(),
    ]
    return "\n\n".join(parts) + "\n"
