"""Doubts about a car with state feedback: travel of struts, wheel lift, and damping of the closed loop."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from suspid.errors import InputError
from suspid.model import FORCE, Suspension, statespace
from suspid.performance.contact import lift_of, static_loads, wheels_of
from suspid.performance.figure_plan import MOST_CLEARANCE
from suspid.performance.figures import exceedances
from suspid.performance.plausibility import LEAST_ZETA
from suspid.simulation import Road
from suspid.units import ComplexArray, Hertz, RealArray, Second
from suspid.words import Check, Level, Number, Remark
from suspid.words.active import ActiveCheck
from suspid.words.ride import RideCheck

# Frequencies over the band of a road, and about a resonance, to which the points are closer the weaker its damping.
OVER_BAND, OVER_PEAK = 2048, 257
# Half widths of a resonance, as the hyperbolic sine of this, beyond which the points of the band are near enough.
PEAK_REACH = 8.0


def possible(
    car: Suspension, actuator: str, gain: RealArray, level: float, road: Road, duration: Second
) -> Iterator[Check]:
    """Yield what no vehicle does with a feedback on the states: a wheel in the air, a strut without end, a vibration.

    ``level`` is the two-sided density of the slope in time [m2/s2 s]. Travels count all wavelengths, as the outputs of
    the feedback do, the load those of the road, as in a ride.
    """
    system = statespace(
        car,
        outputs=[*(f"{strut.name}_travel" for strut in car.struts), *(f"{c}_acceleration" for c in car.coordinates)],
        forces=[actuator],
        roads=car.roads,
    )
    A, B, C, D = (np.asarray(m, float) for m in (system.A, system.B, system.C, system.D))
    labels = list(system.input_labels)
    height, rate, force = (
        labels.index(name) for name in (car.roads[0], f"{car.roads[0]}_rate", f"{actuator.removesuffix(FORCE)}{FORCE}")
    )
    # States count from the road, which at rest lifts the whole car: A lift + B_road = 0.
    lift = -np.linalg.solve(A, B[:, height])
    G = B[:, rate] - lift
    closed, rows = A - np.outer(B[:, force], gain), C - np.outer(D[:, force], gain)
    poles = np.linalg.eigvals(closed)
    yield from _undamped(poles)
    yield from _far(car, closed, G, rows[: len(car.struts)], level)
    hertz = _frequencies(poles, road.band)
    s = 2j * np.pi * hertz
    states = np.linalg.solve(s[:, None, None] * np.eye(len(A)) - closed, G[None, :, None])[:, :, 0]
    accelerations = states @ rows[len(car.struts) :].T + D[len(car.struts) :, rate]
    yield from _lifted(car, accelerations, hertz, level, duration)


def _undamped(poles: ComplexArray) -> Iterator[Check]:
    swinging = poles[np.abs(poles.imag) > 0]
    zeta = -swinging.real / np.abs(swinging)
    if zeta.size and np.min(zeta) < LEAST_ZETA:
        hertz = float(np.abs(swinging[np.argmin(zeta)])) / (2 * np.pi)
        numbers: dict[str, Number] = {"zeta": float(np.min(zeta)), "hertz": hertz, "limit": LEAST_ZETA}
        yield Check(Remark(ActiveCheck.UNDAMPED, numbers), Level.DOUBTFUL)


def _far(car: Suspension, closed: RealArray, G: RealArray, rows: RealArray, level: float) -> Iterator[Check]:
    from scipy.linalg import solve_continuous_lyapunov

    with warnings.catch_warnings():
        # Gains without end are said elsewhere.
        warnings.simplefilter("ignore", RuntimeWarning)
        P = solve_continuous_lyapunov(closed, -level * np.outer(G, G))
    travels = np.sqrt(np.maximum(np.einsum("is,st,it->i", rows, P, rows), 0.0))
    for strut, travel in zip(car.struts, travels.tolist(), strict=True):
        if travel > MOST_CLEARANCE:
            numbers: dict[str, Number] = {"strut": strut.name, "travel": travel, "limit": MOST_CLEARANCE}
            yield Check(Remark(ActiveCheck.FAR, numbers), Level.DOUBTFUL)


def _lifted(
    car: Suspension, accelerations: ComplexArray, hertz: RealArray, level: float, duration: Second
) -> Iterator[Check]:
    """Yield whether the wheel leaves the road: what moves the car up and down is the force under its wheel alone."""
    from scipy.integrate import trapezoid

    try:
        wheels = wheels_of(car)
        load, rise = float(static_loads(wheels)[0][0]), lift_of(wheels)
    except InputError:
        return  # Not every car with one road stands on a wheel.
    density = 2 * level * np.abs(accelerations @ (np.diag(car.M) * rise)) ** 2
    variance = float(trapezoid(density, hertz))
    rises = float(np.sqrt(trapezoid(hertz**2 * density, hertz) / variance))
    times = duration * exceedances(rises, load / float(np.sqrt(variance)))
    if variance > load**2:
        numbers: dict[str, Number] = {"wheel": wheels.names[0], "rms": float(np.sqrt(variance)), "load": load}
        yield Check(Remark(ActiveCheck.AIRBORNE, numbers), Level.DOUBTFUL)
    elif times > 1:
        lifted: dict[str, Number] = {"wheel": wheels.names[0], "times": times, "seconds": duration}
        yield Check(Remark(RideCheck.LIFTS, lifted), Level.CARE)


def _frequencies(poles: ComplexArray, band: tuple[Hertz, Hertz]) -> RealArray:
    """Return the frequencies of a road, closer about the resonances."""
    near = np.sinh(np.linspace(-PEAK_REACH, PEAK_REACH, OVER_PEAK))
    about = [(np.abs(p) + np.abs(p.real) * near) / (2 * np.pi) for p in poles[poles.imag > 0]]
    every = np.unique(np.concatenate([np.geomspace(*band, OVER_BAND), *about]))
    return np.asarray(every[(every >= band[0]) & (every <= band[1])])
