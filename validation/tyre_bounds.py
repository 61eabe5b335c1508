"""Cramér-Rao bounds of tires and wheel masses on a road whose spectrum is known but for a few things.

A quarter car's body and wheel are moved by one road, so both accelerations are a Gaussian process whose spectral matrix
is ``S(f) M M^H + noise``. The information of its lines (P. Whittle, J. R. Stat. Soc. B 15 (1953) 125-139) is taken with
all that `estimate` does not know of a drive: spring, damper and the sensor of the wheel, the level of every stretch,
the road's exponent, and a smooth departure from the power law, a Gaussian process of the logarithm of wave number. An
unbalanced wheel and its unknown force are left out: a line costs little where the speed varies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.units import ComplexArray, RealArray, Second

MASS, WHEEL, SPRING, TIRE, DAMPER, TIRE_DAMPER = 350.0, 50.0, 22e3, 210e3, 1300.0, 60.0
UNKNOWN = ("tire", "wheel", "tire_damper", "spring", "damper", "gain", "delay", "mount")
BAND = (0.5, 24.0)  # [Hz]
SPACING = 0.1  # of the lines [Hz]; the integral over them does not change with it
STRETCH: Second = 8.3  # over which the level is free
NOISE = np.array([0.03, 0.1])  # of body and wheel [m/s2]
RATE = 200.0
SWING: Second = 30.0  # period of the speed
DEPARTURE, LENGTH = 0.3, 0.6  # of the road from its power law: standard deviation, and length in the logarithm
EXPONENT_STD = 1.0
BOUND_NAMES = ("kt/mu", "kt", "mu", "f1", "zeta1", "f2", "zeta2")
KNOWN = 1e10  # information of what is known


@dataclass(frozen=True, kw_only=True, slots=True)
class Asked:
    """A drive, and what is known of it."""

    duration: Second = 300.0
    speed: float = 20.0
    spread: float = 0.15
    exponent: float = 2.0
    roughness: float = 64e-6
    departure: float = DEPARTURE
    tire_damper_std: float = 30.0  # 0: known
    wheel_known: bool = False


def responses(f: RealArray, factors: RealArray) -> ComplexArray:
    """Return the accelerations of body and wheel per motion of the road, (line, 2), written out from the equations.

    ``factors`` are those of `UNKNOWN`, as ratios; of delay and mount in milliseconds.
    """
    tire, wheel, tire_damper, spring, damper, gain, delay, mount = factors
    s = 2j * np.pi * f
    strut = SPRING * spring + DAMPER * damper * s / (1 + 1e-3 * mount * s)
    follows = strut / (MASS * s**2 + strut)
    rolls = TIRE * tire + TIRE_DAMPER * tire_damper * s
    moved = rolls / (WHEEL * wheel * s**2 + strut * (1 - follows) + rolls)
    return np.asarray(np.stack([s**2 * follows * moved, s**2 * moved * gain * np.exp(-1e-3 * delay * s)], axis=1))


def modes_of(factors: RealArray) -> RealArray:
    """Return the logarithms of natural frequency and damping ratio of body and wheel: f1, zeta1, f2, zeta2."""
    tire, wheel, tire_damper, spring, damper = factors[:5]
    strut = np.array([0.0, DAMPER * damper, SPRING * spring])
    rolls = np.array([0.0, TIRE_DAMPER * tire_damper, TIRE * tire])
    body, wheel_row = np.array([MASS, 0.0, 0.0]) + strut, np.array([WHEEL * wheel, 0.0, 0.0]) + strut + rolls
    roots = np.roots(np.polysub(np.polymul(body, wheel_row), np.polymul(strut, strut)))
    poles = sorted(roots[roots.imag > 0], key=abs)
    return np.log([value for pole in poles for value in (abs(pole), -pole.real / abs(pole))])


def tire_bound(asked: Asked) -> dict[str, float]:
    """Return the least relative standard deviations of kt, mu, kt/mu, and of the modes."""
    f = np.arange(BAND[0], BAND[1], SPACING)
    stretches = max(1, round(asked.duration / STRETCH))
    length = asked.duration / stretches
    speeds = asked.speed * (1 + asked.spread * np.sin(2 * np.pi * length * (np.arange(stretches) + 0.5) / SWING))
    start = np.array([1.0, 1, 1, 1, 1, 1, 0, 0])
    here, step = responses(f, start), 1e-5
    slopes = [(responses(f, start + row) - responses(f, start - row)) / (2 * step) for row in step * np.eye(len(start))]
    shapes, at = _departures(np.log(f)[None] - np.log(speeds)[:, None], asked.departure)
    cars, road = len(UNKNOWN), len(UNKNOWN) + 1 + shapes.shape[1]
    information = np.zeros((road + stretches, road + stretches))
    for j, speed in enumerate(speeds):
        density = asked.roughness * 0.1**asked.exponent * speed ** (asked.exponent - 1) * f**-asked.exponent
        moved = density[:, None, None] * here[:, :, None] * here[:, None].conj()
        whole = np.linalg.inv(moved + np.diag(NOISE**2) / (RATE / 2))
        by_car = [
            density[:, None, None] * (one[:, :, None] * here[:, None].conj() + here[:, :, None] * one[:, None].conj())
            for one in slopes
        ]
        by_road = [-np.log(f / 4), *(np.interp(at[0][j], at[1], shape) for shape in shapes.T), np.ones_like(f)]
        columns = np.array([whole @ one for one in (*by_car, *(moved * one[:, None, None] for one in by_road))])
        own = length * SPACING * np.einsum("afij,bfji->ab", columns, columns).real
        place = np.append(np.arange(road), road + j)
        information[np.ix_(place, place)] += own
    prior = np.zeros(len(information))
    prior[cars], prior[cars + 1 : road] = EXPONENT_STD**-2.0, 1.0
    prior[UNKNOWN.index("tire_damper")] = (TIRE_DAMPER / asked.tire_damper_std) ** 2 if asked.tire_damper_std else KNOWN
    prior[UNKNOWN.index("wheel")] = KNOWN if asked.wheel_known else 0.0
    covariance = np.linalg.inv(information + np.diag(prior))[:cars, :cars]
    turned = np.array([(modes_of(start + row) - modes_of(start - row)) / (2 * step) for row in step * np.eye(cars)]).T
    ratio = np.zeros(cars)
    ratio[:2] = 1, -1
    rows = np.vstack([ratio, np.eye(cars)[:2], turned])
    stds = np.sqrt(np.einsum("ai,ij,aj->a", rows, covariance, rows))
    return dict(zip(BOUND_NAMES, stds.tolist(), strict=True))


def _departures(logs: RealArray, departure: float) -> tuple[RealArray, tuple[RealArray, RealArray]]:
    """Return the components of the departure at even points (point, component), and where lines and points are."""
    points = np.linspace(np.min(logs), np.max(logs), 60)
    values, vectors = np.linalg.eigh(np.exp(-0.5 * ((points[:, None] - points) / LENGTH) ** 2))
    keep = values > 1e-6 * values[-1]
    return departure * vectors[:, keep] * np.sqrt(values[keep]), (logs, points)
