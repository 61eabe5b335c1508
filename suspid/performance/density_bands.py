"""Bands of spectra of a car that is not known exactly, by the spectra of cars that may be the true one.

At a resonance a density is largest: every other car has less there, and to first order it does not change at all. So
the bands are no derivatives. At each frequency they hold the densities of two sets of cars: those within an ellipsoid
about the parameters, where the true car is found if it moves the density to first order, and those drawn from the
covariance, of which a share as large as the level lies within.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from suspid.levels import normal_reach
from suspid.model import Suspension, output_rows
from suspid.performance.road_response import Signals, densities
from suspid.performance.uncertain import RELAXATION, Uncertain
from suspid.simulation import Road
from suspid.units import Ratio, RealArray, Second

# Frequencies at which bands are computed; between them their ratio to the density is interpolated by logarithms. Over
# the band of a road these are 2.7 % apart, less than the width of a resonance with a damping ratio of 2 %.
BAND_LINES = 256
# Cars drawn, by points that fill the space evenly: of 512, 13 lie beyond each end of 95 %, known to a tenth of these.
DRAWN_CARS = 512
# Directions, each that in which the density at one frequency grows fastest, on both sides of the car, and parts of the
# way to the ellipsoid. Without the cars drawn, and to first order alone, bands are too narrow at a resonance: the laws
# are in tests/test_ride_checks.py.
STEEPEST_WAYS, PARTS_OF_WAY = 32, (0.5, 1.0)
# Share of a spring, damper or mass below which a car lacks it; relaxations of mounts may be zero.
LEAST_LEFT: Ratio = 0.05


def density_bands(
    about: Uncertain, channels: tuple[str, ...], road: Road, hertz: RealArray, level: Ratio
) -> tuple[RealArray, RealArray]:
    """Return lower and upper ends of spectral densities over their values, (channel, frequency).

    Examples
    --------
    The wheel's resonance on a tire that is known to 5 %: at its peak the density may be less, and hardly more.

    >>> from suspid import quarter_car, road
    >>> from suspid.performance.uncertain import uncertain
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=250)
    >>> about = uncertain(car, {"tire.stiffness": 0.05})
    >>> low, high = density_bands(about, ("chassis_acceleration",), road("C", speed=20.0), np.array([10.8]), 0.95)
    >>> bool(low[0, 0] < 0.95), bool(high[0, 0] < 1.1)
    (True, True)
    """
    ones = np.ones((len(channels), len(hertz)))
    if not np.any(about.covariance):
        return ones, ones
    lines = np.geomspace(hertz[0], hertz[-1], BAND_LINES) if len(hertz) > BAND_LINES else hertz
    wanted = Signals(rows=output_rows(about.car, channels), weightings=(None,) * len(channels), loads=0)
    middle, slopes = densities(
        about.car, wanted, road, lines, parameters=about.parameters, relaxations=about.relaxations
    )

    def ratios(moves: RealArray) -> RealArray:
        cars = (_moved(about, move) for move in moves)
        return np.array([densities(car, wanted, road, lines, relaxations=mounts)[0] for car, mounts in cars]) / middle

    reach = normal_reach(level)
    within = ratios(_on_ellipsoid(slopes, about.covariance, reach))
    drawn = np.quantile(ratios(_drawn(about.covariance)), ((1 - level) / 2, (1 + level) / 2), axis=0)
    low = np.minimum(np.min(within, axis=0), np.minimum(drawn[0], 1.0))
    high = np.maximum(np.max(within, axis=0), np.maximum(drawn[1], 1.0))
    ends = [np.array([np.interp(np.log(hertz), np.log(lines), row) for row in np.log(side)]) for side in (low, high)]
    return np.exp(ends[0]), np.exp(ends[1])


def _moved(about: Uncertain, move: RealArray) -> tuple[Suspension, dict[str, Second]]:
    """Return a car and the relaxations of its mounts with parameters moved by ``move``, as far as there are cars."""
    least = [0.0 if name.endswith(RELAXATION) else LEAST_LEFT for name in about.parameters]
    values = np.maximum(about.values + move, least * about.values)
    return about.at(dict(zip(about.parameters, values.tolist(), strict=True)))


def _on_ellipsoid(slopes: RealArray, covariance: RealArray, reach: Ratio) -> RealArray:
    """Return moves of the parameters, (car, parameter), at most ``reach`` standard deviations far."""
    return reach * np.concatenate([share * side * one for one in _steepest(slopes, covariance)
                                   for share in PARTS_OF_WAY for side in (-1, 1)])  # fmt: skip


def _steepest(slopes: RealArray, covariance: RealArray) -> Iterator[RealArray]:
    """Yield, of each channel, moves by one standard deviation in which densities grow fastest, (move, parameter)."""
    count = slopes.shape[2]
    for rows in slopes.transpose(1, 2, 0):
        some = rows[np.unique(np.linspace(0, count - 1, STEEPEST_WAYS).round().astype(int))]
        toward = some @ covariance
        length = np.sqrt(np.sum(some * toward, axis=1, keepdims=True))
        yield toward[length[:, 0] > 0] / length[length[:, 0] > 0]


def _drawn(covariance: RealArray) -> RealArray:
    """Return moves of the parameters drawn from their covariance, (car, parameter), the same at each call."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    values, vectors = np.linalg.eigh(covariance)
    used = values > 0
    points = qmc.Sobol(int(np.sum(used)), scramble=True, rng=1).random(DRAWN_CARS)
    return np.asarray(ndtri(points) * np.sqrt(values[used]) @ vectors[:, used].T)
