"""Variances of what a car does on a random road, with exact derivatives by springs, dampers and masses.

A unit motion of road r moves the coordinates by q and elongates the struts by E; with ``b = k + c s / (1 + rho s)`` of
each strut and ``D = M s^2 + arms^T b arms``, an output ``y = (h q + g) road`` changes by ``dy/db_j = (g_j - h D^-1 a_j)
E_j`` and ``dy/dm_i = -(h D^-1)_i s^2 q_i``, where ``g_j`` is the direct part of strut j in y. A variance is the
integral of ``G |W|^2 y S y^H`` over the band of the road, G its density and S what its inputs share.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.model import OutputRows, Suspension
from suspid.performance.strut_slopes import strut_slopes
from suspid.performance.weightings import weighting
from suspid.simulation import Road
from suspid.units import ComplexArray, Ratio, RealArray, Second

# Gauss points of each panel, panels to begin with, and at most: a mode with a damping ratio of 1e-4 needs some 4000.
GAUSS_POINTS, PANELS, MOST_PANELS = 8, 32, 8192
# Relative change of every variance by twice as many panels up to which the integral is exact.
EXACT_VARIANCE = 1e-8


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Signals:
    """What is looked at: motions by channel with the weighting of each, then the contact force on each road."""

    rows: OutputRows
    weightings: tuple[str | None, ...]  # of each motion
    loads: int  # number of roads whose contact force follows the motions


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Moments:
    """Variances of signals and of their rates, with derivatives by parameters; in SI units squared."""

    variance: RealArray  # (signal,)
    rate: RealArray  # (signal,)
    variance_slopes: RealArray  # (signal, parameter)
    rate_slopes: RealArray  # (signal, parameter)


def nodes(road: Road, panels: int) -> tuple[RealArray, RealArray]:
    """Return frequencies [Hz] in the band of a road, and weights of an integral over it [Hz]."""
    low, high = np.log(road.band)
    x, w = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    width = (high - low) / panels
    f = np.exp(low + width * (np.arange(panels)[:, None] + (x + 1) / 2)).ravel()
    return f, f * np.tile(w * width / 2, panels)


def enough_panels(variances: Callable[[int], RealArray], change: Ratio = EXACT_VARIANCE) -> int:
    """Return a number of panels at which variances no longer change by a share."""
    panels, before = PANELS, variances(PANELS)
    while panels < MOST_PANELS:
        panels *= 2
        now = variances(panels)
        if np.all(np.abs(now - before) <= change * np.abs(now)):
            return panels // 2
        before = now
    return panels


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Response:
    """Responses of signals to unit motions of the roads at some frequencies, and what their derivatives need."""

    signals: ComplexArray  # (frequency, signal, road)
    elongation: ComplexArray  # (frequency, strut, road)
    motion: ComplexArray  # (frequency, coordinate, road)
    by_strut: ComplexArray  # (frequency, signal, strut)
    by_mass: ComplexArray  # (frequency, signal, coordinate)
    slopes: Sequence[tuple[int, ComplexArray] | None]  # of each parameter


def response(
    car: Suspension,
    wanted: Signals,
    hertz: RealArray,
    *,
    parameters: Sequence[str] = (),
    relaxations: Mapping[str, Second] | None = None,
) -> Response:
    """Return the responses of signals to unit motions of the roads."""
    given = relaxations or {}
    s: ComplexArray = 2j * np.pi * np.asarray(hertz, np.complex128)
    relaxation = np.array([given.get(strut.name, strut.relaxation) for strut in car.struts])
    b, slopes = strut_slopes(car, relaxation, tuple(given), s, parameters)
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    pulled = arms.T * b[:, None, :]
    inverse = np.linalg.inv(pulled @ arms + (s**2)[:, None, None] * car.M)
    q = -inverse @ (pulled @ road_arms)
    elongation = arms @ q + road_arms
    order = s[:, None] ** wanted.rows.orders
    h = order[:, :, None] * wanted.rows.coordinates
    direct = order[:, :, None] * wanted.rows.roads
    through = np.zeros((len(hertz), len(h[0]), len(car.struts)), np.complex128)
    if wanted.loads:
        carried = road_arms.T * b[:, None, :]
        h = np.concatenate([h, carried @ arms], axis=1)
        direct = np.concatenate([direct, carried @ road_arms], axis=1)
        through = np.concatenate([through, np.broadcast_to(road_arms.T, carried.shape)], axis=1)
    adjoint = h @ inverse
    return Response(
        signals=h @ q + direct,
        elongation=elongation,
        motion=q,
        by_strut=through - adjoint @ arms.T,
        by_mass=-adjoint * (s**2)[:, None, None],
        slopes=slopes,
    )


def densities(car: Suspension, wanted: Signals, road: Road, hertz: RealArray) -> RealArray:
    """Return the spectral density of each signal with its weighting, (signal, frequency)."""
    y = response(car, wanted, hertz).signals
    power = np.einsum("fyr,frs,fys->yf", y, road.shares(hertz), y.conj(), optimize=True).real
    return np.asarray(power * road.spectrum(hertz) * _filters(wanted, hertz))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Grid:
    """Where the spectra of signals on a road are summed, and all that does not depend on the car."""

    hertz: RealArray  # (frequency,)
    level: RealArray  # (2, signal, frequency): density of the road times weighting, and that of rates
    shares: ComplexArray  # (frequency, road, road)


def grid_of(wanted: Signals, road: Road, panels: int) -> Grid:
    """Return the grid of some signals on a road."""
    f, weights = nodes(road, panels)
    level = weights * road.spectrum(f) * _filters(wanted, f)
    return Grid(hertz=f, level=np.stack([level, level * (2 * np.pi * f) ** 2]), shares=road.shares(f))


def exact_grid(car: Suspension, wanted: Signals, road: Road, change: Ratio = EXACT_VARIANCE) -> Grid:
    """Return a grid that is fine enough for a car: variances on twice as many panels differ by less than a share."""

    def variances(panels: int) -> RealArray:
        grid = grid_of(wanted, road, panels)
        return moments(car, wanted, grid).variance

    return grid_of(wanted, road, enough_panels(variances, change))


def moments(
    car: Suspension,
    wanted: Signals,
    grid: Grid,
    *,
    parameters: Sequence[str] = (),
    relaxations: Mapping[str, Second] | None = None,
) -> Moments:
    """Return the variances of signals on a road, and of their rates, with derivatives by parameters."""
    found = response(car, wanted, grid.hertz, parameters=parameters, relaxations=relaxations)
    shared = grid.shares @ found.signals.conj().transpose(0, 2, 1)
    power = np.sum(found.signals * shared.transpose(0, 2, 1), axis=2).real.T
    variance, rate = np.sum(grid.level * power, axis=2)
    slopes = np.zeros((2, len(power), len(parameters)))
    along = found.elongation @ shared
    for p, name in enumerate(parameters):
        slope = found.slopes[p]
        owner, _, quantity = name.rpartition(".")
        if slope is not None:
            j, change = slope
            moved = change[:, None] * found.by_strut[:, :, j] * along[:, j]
        elif quantity == "mass" and owner in car.coordinates:
            i = car.coordinates.index(owner)
            moved = found.by_mass[:, :, i] * (found.motion[:, i : i + 1] @ shared)[:, 0]
        else:
            continue
        slopes[:, :, p] = 2 * np.sum(grid.level * moved.real.T, axis=2)
    return Moments(variance=variance, rate=rate, variance_slopes=slopes[0], rate_slopes=slopes[1])


def _filters(wanted: Signals, hertz: RealArray) -> RealArray:
    """Return the squared response of each signal's weighting, (signal, frequency)."""
    made: dict[str | None, RealArray] = {None: np.ones(len(hertz))}
    for name in wanted.weightings:
        if name is not None and name not in made:
            made[name] = np.abs(weighting(name, hertz)) ** 2
    rows = [made[name] for name in (*wanted.weightings, *[None] * wanted.loads)]
    # A car may have nothing to look at.
    return np.array(rows).reshape(len(rows), len(hertz))
