"""Variances of the outputs of a car on a random road, with exact derivatives by springs, dampers and masses.

A unit motion of road r moves the coordinates by q and elongates the struts by E; with ``b = k + c s / (1 + rho s)`` of
each strut and ``D = M s^2 + arms^T b arms``, an output ``y = (h q + g) road`` changes by ``dy/db_j = (g_j - h D^-1 a_j)
E_j`` and ``dy/dm_i = -(h D^-1)_i s^2 q_i``, where ``g_j`` is the direct part of strut j in y. A variance is the
integral of ``G |W|^2 y S y^H`` over the band of the road, G its density and S what its inputs share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import InputError
from suspid.model import OutputRows, Suspension, state_matrix
from suspid.performance.strut_slopes import strut_slopes
from suspid.performance.weightings import weighting
from suspid.simulation import Road
from suspid.units import ComplexArray, Hertz, Ratio, RealArray, Second

# Gauss points of each panel, and panels of the same ratio of frequencies over the band; about a weakly damped mode they
# halve until they are as narrow as its resonance. All are cut into parts, at most 256.
GAUSS_POINTS, PANELS, MOST_PARTS = 8, 32, 256
# Half width of the narrowest resonance that panels follow, over its frequency: modes without damping have no variance.
NARROWEST: Ratio = 1e-6
# Relative change of every variance by twice as many panels up to which the integral is exact.
EXACT_VARIANCE = 1e-8
# The same up to which a variance exists at all, if not yet exactly.
SMALL_CHANGE = 0.1


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


def nodes(road: Road, parts: int, car: Suspension | None = None) -> tuple[RealArray, RealArray]:
    """Return frequencies [Hz] in the band of a road, and weights of an integral over it [Hz].

    With a car its resonances have panels of their own.
    """
    low, high = np.log(road.band)
    panels = np.linspace(low, high, PANELS + 1)
    if car is not None:
        near = np.log(_about_resonances(car, (high - low) / PANELS))
        panels = np.union1d(panels, near[(near > low) & (near < high)])
    x, w = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    width = np.repeat(np.diff(panels) / parts, parts)
    start = (panels[:-1, None] + np.diff(panels)[:, None] * np.arange(parts) / parts).ravel()
    f = np.exp(start[:, None] + width[:, None] * (x + 1) / 2).ravel()
    return f, f * np.ravel(width[:, None] * w / 2)


def _about_resonances(car: Suspension, widest: Ratio) -> RealArray:
    """Return ends of panels of quadrature about the resonances of a car [Hz].

    The first is half a half width from the resonance, each further one twice as far.

    The panels are at most as wide as ``widest`` times the frequency. A panel is no wider than its distance from the
    pole, so that points of Gauss converge fast.
    """
    found = [np.zeros(0)]
    for pole in np.linalg.eigvals(state_matrix(car)):
        hertz = abs(float(pole.imag)) / (2 * np.pi)
        half = max(abs(float(pole.real)) / (2 * np.pi), NARROWEST * hertz) / 2
        if pole.imag > 0 and half < widest * hertz:
            steps = half * 2.0 ** np.arange(np.ceil(np.log2(widest * hertz / half)) + 1)
            found.append(np.concatenate([hertz - steps[steps < hertz], [hertz], hertz + steps]))
    return np.concatenate(found)


def enough_parts(variances: Callable[[int], RealArray], change: Ratio = EXACT_VARIANCE) -> int:
    """Return a number of parts of each panel at which variances no longer change by a share."""
    parts, before = 1, variances(1)
    while parts < MOST_PARTS:
        parts *= 2
        now = variances(parts)
        if np.all(np.abs(now - before) <= change * np.abs(now)):
            return parts // 2
        before = now
    return parts


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
    inverse = np.linalg.inv(_summed(b, arms, arms) + (s**2)[:, None, None] * car.M)
    q = -inverse @ _summed(b, arms, road_arms)
    elongation = arms @ q + road_arms
    order = s[:, None] ** wanted.rows.orders
    h = order[:, :, None] * wanted.rows.coordinates
    direct = order[:, :, None] * wanted.rows.roads
    through = np.zeros((len(hertz), len(h[0]), len(car.struts)), np.complex128)
    if wanted.loads:
        h = np.concatenate([h, _summed(b, road_arms, arms)], axis=1)
        direct = np.concatenate([direct, _summed(b, road_arms, road_arms)], axis=1)
        through = np.concatenate([through, np.broadcast_to(road_arms.T, (len(b), *road_arms.T.shape))], axis=1)
    adjoint = h @ inverse
    return Response(
        signals=h @ q + direct,
        elongation=elongation,
        motion=q,
        by_strut=through - adjoint @ arms.T,
        by_mass=-adjoint * (s**2)[:, None, None],
        slopes=slopes,
    )


def _summed(b: ComplexArray, left: RealArray, right: RealArray) -> ComplexArray:
    """Return ``left^T b right`` at each frequency, as one product of matrices."""
    pairs = (left[:, :, None] * right[:, None, :]).reshape(len(left), -1)
    return np.asarray((b @ pairs).reshape(len(b), left.shape[1], right.shape[1]))


def densities(
    car: Suspension,
    wanted: Signals,
    road: Road,
    hertz: RealArray,
    *,
    parameters: Sequence[str] = (),
    relaxations: Mapping[str, Second] | None = None,
) -> tuple[RealArray, RealArray]:
    """Return the spectral density of each signal with its weighting, (signal, frequency), and derivatives of it.

    These are by parameters, (parameter, signal, frequency).
    """
    found = response(car, wanted, hertz, parameters=parameters, relaxations=relaxations)
    level = road.spectrum(hertz) * _filters(wanted, hertz)
    power, slopes = _powers(found, road.shares(hertz), car, parameters)
    return np.asarray(power * level), np.array([slope * level for slope in slopes]).reshape(-1, *power.shape)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Grid:
    """Where the spectra of signals on a road are summed, and all that does not depend on the car."""

    hertz: RealArray  # (frequency,)
    level: RealArray  # (2, signal, frequency): density of the road times weighting, and that of rates
    shares: ComplexArray  # (frequency, road, road)


def grid_of(wanted: Signals, road: Road, parts: int, car: Suspension | None = None) -> Grid:
    """Return the grid of some signals on a road, with panels about the resonances of a car."""
    f, weights = nodes(road, parts, car)
    level = weights * road.spectrum(f) * _filters(wanted, f)
    return Grid(hertz=f, level=np.stack([level, level * (2 * np.pi * f) ** 2]), shares=road.shares(f))


def exact_parts(car: Suspension, wanted: Signals, road: Road, change: Ratio = EXACT_VARIANCE) -> int:
    """Return parts of panels fine enough for a car: with twice as many, variances differ by less than a share."""

    def variances(parts: int) -> RealArray:
        return moments(car, wanted, grid_of(wanted, road, parts, car)).variance

    endless = _without_damping(car, road)
    # What a mode without damping adds to a sum over lines doubles with their number.
    if endless and np.any(np.abs(variances(2) - variances(1)) > SMALL_CHANGE * variances(2)):
        raise InputError(
            f"the mode at {endless[0]:.3g} Hz has no damping: on a random road it grows without bound, so there are "
            f"no figures; add damping to a strut that moves in it"
        )
    return enough_parts(variances, change)


def _without_damping(car: Suspension, road: Road) -> list[Hertz]:
    """Return the frequencies, in the band of a road, of modes that have next to no damping."""
    poles = np.linalg.eigvals(state_matrix(car))
    free = poles[(poles.imag > 0) & (np.abs(poles.real) < NARROWEST * poles.imag)].imag / (2 * np.pi)
    return sorted(free[(free > road.band[0]) & (free < road.band[1])].tolist())


def exact_grid(car: Suspension, wanted: Signals, road: Road) -> Grid:
    """Return a grid that is fine enough for a car."""
    return grid_of(wanted, road, exact_parts(car, wanted, road), car)


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
    power, changes = _powers(found, grid.shares, car, parameters)
    variance, rate = np.sum(grid.level * power, axis=2)
    slopes = np.zeros((2, len(power), len(parameters)))
    for p, change in enumerate(changes):
        slopes[:, :, p] = np.sum(grid.level * change, axis=2)
    return Moments(variance=variance, rate=rate, variance_slopes=slopes[0], rate_slopes=slopes[1])


def _powers(
    found: Response, shares: ComplexArray, car: Suspension, parameters: Sequence[str]
) -> tuple[RealArray, Iterator[RealArray]]:
    """Return the power of each signal on a road of density one, (signal, frequency), and its derivatives."""
    shared = shares @ found.signals.conj().transpose(0, 2, 1)
    power = np.sum(found.signals * shared.transpose(0, 2, 1), axis=2).real.T
    along = found.elongation @ shared

    def slope_of(p: int, name: str) -> RealArray:
        slope = found.slopes[p]
        owner, _, quantity = name.rpartition(".")
        if slope is not None:
            j, change = slope
            moved = change[:, None] * found.by_strut[:, :, j] * along[:, j]
        elif quantity == "mass" and owner in car.coordinates:
            i = car.coordinates.index(owner)
            moved = found.by_mass[:, :, i] * (found.motion[:, i : i + 1] @ shared)[:, 0]
        else:
            return np.zeros_like(power)
        return np.asarray(2 * moved.real.T)

    return power, (slope_of(p, name) for p, name in enumerate(parameters))


def _filters(wanted: Signals, hertz: RealArray) -> RealArray:
    """Return the squared response of each signal's weighting, (signal, frequency)."""
    made: dict[str | None, RealArray] = {None: np.ones(len(hertz))}
    for name in wanted.weightings:
        if name is not None and name not in made:
            made[name] = np.abs(weighting(name, hertz)) ** 2
    rows = [made[name] for name in (*wanted.weightings, *[None] * wanted.loads)]
    # A car may have nothing to look at.
    return np.array(rows).reshape(len(rows), len(hertz))
