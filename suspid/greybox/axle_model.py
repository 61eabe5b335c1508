"""Spectral matrix of the road's slopes under two wheels on one track, and its derivatives.

``S = L n^(2-w) exp(g) [[1, c], [c, 1]] + orders + noise`` in each stretch, with n the wave number, g the departure from
the power law and ``c = 1 / (1 + rho)``: rho, a smooth function of wave number too, is what the two wheels do not share
(a wheel beside the other's track, a soft road). Where the car is wrong, the slopes are those of one road no more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.greybox.axle_data import AxleRecord, Behind, Lag, best_motion, cross_power
from suspid.greybox.noise_levels import Levels
from suspid.greybox.road_maps import MapProblem, RoadMap
from suspid.greybox.road_model import (
    EXPONENT,
    NOISE_STD,
    ORDER_FORCE,
    ORDER_GROWTH,
    RADIUS_STD,
    SMALL_MOVE,
    Prior,
    RoadModel,
)
from suspid.simulation import REFERENCE
from suspid.units import ComplexArray, RealArray, Second

Spectral: TypeAlias = RealArray | ComplexArray  # matrices of spectra, whether or not they are real
# Logarithm of rho at the reference wave number: less than 1 % of a road's power is the wheels' own, known to nothing.
UNSHARED = (-5.0, 3.0)
# Power of wave number with which rho grows: 2 for wheels some centimetres beside each other's track.
UNSHARED_GROWTH = (2.0, 1.0)
UNSHARED_CHANGE = 1.0  # standard deviation of the logarithm of rho about that power
# Power of a wheel order over that of a force of `ORDER_FORCE`, 500 N at most. It is linear here: the logarithm of none
# has no end.
LARGEST_ORDER = 2500.0
# Standard deviation of the time by which the rear wheel is later besides: a speed of which a logger smooths away a
# twentieth of the swings leaves 5 % of the delay, some ms.
LATE_STD: Second = 5e-3
SMALL_STEP = 1e-4  # of unknowns, in derivatives of maps by differences


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AxleModel:
    """One track in all stretches of one logger: the first two roads of the maps, of which one follows the other.

    Its own unknowns are w, g, the noise of each cause, rho's, then those of wheel orders.
    """

    behind: Behind
    maps: MapProblem
    records: tuple[AxleRecord, ...]
    road: RoadModel  # of its stretches: speeds, orders, components of departures
    s: ComplexArray  # (line,)
    lines: NDArray[np.intp]  # (line,): numbers
    weigh: ComplexArray  # (line, cause, output)
    noise: ComplexArray  # (line, cause, cause)
    by_speed: RealArray  # (stretch,): mean of 1 / speed^2

    @property
    def stretches(self) -> int:
        """Number of stretches."""
        return len(self.by_speed)

    @property
    def taper_loss(self) -> float:
        """Variance of mean powers over that of whole stretches: tapers leave a part of each unused."""
        weights = self.road.track.weights
        return float(len(weights) * np.sum(weights**2))

    @property
    def count(self) -> int:
        """Number of own unknowns."""
        return len(self.prior.mean)

    @property
    def prior(self) -> Prior:
        """What is known before the record is asked."""
        parts, causes, orders = self.road.functions.shape[1], self.noise.shape[2], len(self.road.orders)
        mean = [EXPONENT[0], *[0.0] * (parts + causes), UNSHARED[0], *[0.0] * parts, UNSHARED_GROWTH[0]]
        std = [EXPONENT[1], *[1.0] * parts, *[NOISE_STD] * causes]
        std += [UNSHARED[1], *[1.0] * parts, UNSHARED_GROWTH[1]]
        if orders:
            mean += [*[0.0] * (2 * orders), ORDER_GROWTH[0], 0.0]
            std += [*[LARGEST_ORDER] * (2 * orders), ORDER_GROWTH[1], RADIUS_STD]
        return Prior(np.array(mean), np.array(std))

    @property
    def lower(self) -> RealArray:
        """Bounds of own unknowns: no wheel order has less than no power."""
        lower, orders = np.full(self.count, -np.inf), len(self.road.orders)
        if orders:
            lower[-2 - 2 * orders : -2] = 0.0
        return lower

    def first(self, front: RealArray, rear: RealArray) -> RealArray:
        """Return own unknowns to begin with: wheel orders as the models of each wheel's road found them."""
        orders, own = len(self.road.orders), self.prior.mean.copy()
        if orders:
            both = [np.exp(one[-2 - orders : -2]) / (ORDER_FORCE**2 / 2) for one in (front, rear)]
            own[-2 - 2 * orders :] = np.concatenate([*both, (front[-2:] + rear[-2:]) / 2])
        return own

    @property
    def components(self) -> RealArray:
        """Components of departures at the lines, (stretch, line, component)."""
        first = int(np.argmax(self.road.track.kernel[0]))
        return self.road.components[:, first : first + len(self.s)]

    @property
    def log_ratio(self) -> RealArray:
        """Logarithm of wave number over its reference, (stretch, line)."""
        return np.asarray(np.log(self.s.imag / (2 * np.pi * REFERENCE)) - self.road.track.log_speed[:, None])

    def measured(self, z: RealArray, x: RealArray, lag: Lag) -> ComplexArray:
        """Return the spectral matrix of the slopes that a car makes of the records, (stretch, line, 2, 2)."""
        rows = [record.slopes(self.maps, z, x, lag) for record in self.records]
        return cross_power(rows, [r.starts for r in self.records], self.road.track.samples, self.lines)

    def shared(self, own: RealArray) -> RealArray:
        """Return the coherence of the two roads at the lines, (stretch, line)."""
        parts, at = self.road.functions.shape[1], self._at_unshared
        departs = UNSHARED_CHANGE / self._departure * (self.components @ own[at + 1 : at + 1 + parts])
        log_rho = own[at] + own[at + 1 + parts] * self.log_ratio + departs
        return np.asarray(1 / (1 + np.exp(log_rho)))

    @property
    def _at_unshared(self) -> int:
        """Place of rho's logarithm at the reference among the own unknowns."""
        return 1 + int(self.road.functions.shape[1]) + int(self.noise.shape[2])

    @property
    def _departure(self) -> float:
        """Standard deviation of what the components make."""
        return float(np.sqrt(np.mean(np.sum(self.components**2, axis=2))))

    def expected(self, here: RoadMap, own: RealArray, levels: RealArray, lag: Lag) -> Expected:
        """Return the expected spectral matrix."""
        parts, track = self.road.functions.shape[1], self.road.track
        late = np.ones((self.stretches, len(self.s), 2), complex)
        late[:, :, 0] = np.exp(-self.s * lag.delays(track.log_speed)[:, None])
        per_metre = np.abs(self.s) ** 2 * self.by_speed[:, None]
        uneven = np.exp(own[1 + parts : self._at_unshared] / 2)
        back = here.roads[:, :2]
        noise = back @ (self.noise * uneven[:, None] * uneven) @ back.conj().swapaxes(1, 2)
        power = np.exp(levels[:, None] - (own[0] - 2) * self.log_ratio + self.components @ own[1 : 1 + parts])
        road = np.zeros((self.stretches, len(self.s), 2, 2))
        road[..., 0, 0] = road[..., 1, 1] = power
        road[..., 0, 1] = road[..., 1, 0] = power * self.shared(own)
        return Expected(
            late=late,
            per_metre=per_metre,
            road=road,
            noise=turned(noise, late) * per_metre[..., None, None],
            orders=self._orders(here, own, per_metre),
        )

    def by_own(self, here: RoadMap, own: RealArray, made: Expected) -> list[Spectral]:
        """Return the derivatives of the expected spectral matrix by own unknowns."""
        parts, orders = self.road.functions.shape[1], len(self.road.orders)
        road, components = made.road, self.components
        columns: list[Spectral] = [-self.log_ratio[..., None, None] * road]
        columns += [components[:, :, i, None, None] * road for i in range(parts)]
        uneven, back = np.exp(own[1 + parts : self._at_unshared] / 2), here.roads[:, :2]
        for half in np.eye(len(uneven)) / 2:
            change = self.noise * uneven[:, None] * uneven * (half[:, None] + half)
            change = back @ change @ back.conj().swapaxes(1, 2)
            columns.append(turned(change, made.late) * made.per_metre[..., None, None])
        shared = self.shared(own)
        unshared = np.zeros_like(road)
        unshared[..., 0, 1] = unshared[..., 1, 0] = -road[..., 0, 0] * shared * (1 - shared)
        columns.append(unshared)
        scale = UNSHARED_CHANGE / self._departure
        columns += [scale * components[:, :, i, None, None] * unshared for i in range(parts)]
        columns.append(self.log_ratio[..., None, None] * unshared)
        if orders:
            at = len(own) - 2 - 2 * orders
            for i in range(2 * orders):
                alone = own.copy()
                alone[at : at + 2 * orders] = 0.0
                alone[at + i] = 1.0
                columns.append(self._orders(here, alone, made.per_metre))
            for i in (-2, -1):
                near = own.copy()
                near[i] += SMALL_MOVE
                columns.append((self._orders(here, near, made.per_metre) - made.orders) / SMALL_MOVE)
        return columns

    def by_car(
        self,
        here: RoadMap,
        made: Expected,
        z: RealArray,
        x: RealArray,
        directions: Sequence[tuple[RealArray, RealArray]],
    ) -> list[Spectral]:
        """Return the derivatives along directions of (z, x): what a change of the car makes of roads, and of orders."""
        back, weighed = np.linalg.inv(here.roads), here.roads @ self.weigh
        columns: list[Spectral] = []
        for dz, dx in directions:
            one, other = (self.maps.maps(self.s, z + h * dz, x + h * dx) for h in (SMALL_STEP, -SMALL_STEP))
            change = one.roads - other.roads - weighed @ (one.outputs - other.outputs)
            # Of other tracks' roads only what moves with these would come in: that is left out of the slope.
            turn = (change @ back)[:, :2, :2] / (2 * SMALL_STEP)
            pushed = turn + np.linalg.solve(here.tires, one.tires - other.tires)[:, :2, :2] / (2 * SMALL_STEP)
            moved = turned(turn, made.late) @ made.road + turned(pushed, made.late) @ made.orders
            columns.append(-(moved + moved.conj().swapaxes(2, 3)))
        return columns

    def by_lag(self, made: Expected, lag: Lag) -> list[Spectral]:
        """Return the derivatives by the logarithm of the way, and by the time in `LATE_STD`."""
        columns: list[Spectral] = []
        for delay in (lag.way * np.exp(-self.road.track.log_speed), np.full(self.stretches, LATE_STD)):
            moved = np.zeros_like(made.noise)
            moved[..., 0, :] = (self.s * delay[:, None])[..., None] * (made.road + made.orders)[..., 0, :]
            columns.append(moved + moved.conj().swapaxes(2, 3))
        return columns

    def _orders(self, here: RoadMap, own: RealArray, per_metre: RealArray) -> ComplexArray:
        """Return the power of the wheels' orders, which count as incoherent."""
        made = np.zeros((self.stretches, len(self.s), 2, 2), complex)
        if not self.road.orders:
            return made
        orders, (growth, log_radius) = self.road.orders, own[-2:].tolist()
        amounts = ORDER_FORCE**2 / 2 * own[-2 - 2 * len(orders) : -2].reshape(2, -1)
        # One wheel stands on each road.
        gives = np.sum(np.abs(np.linalg.inv(here.tires)[:, :2]) ** 2, axis=2)
        for order, both in zip(orders, amounts.T, strict=True):
            power = self.road.rotations(order, growth, log_radius) @ self.road.track.kernel.T * per_metre
            for wheel in range(2):
                made[..., wheel, wheel] += both[wheel] * power * gives[:, wheel]
        return made


class Expected(NamedTuple):
    """The parts of the expected spectral matrix, (stretch, line, 2, 2)."""

    late: ComplexArray  # (stretch, line, 2): the front is later by the delay
    per_metre: RealArray  # (stretch, line): power of a slope per metre over that of the height
    road: RealArray
    noise: ComplexArray
    orders: ComplexArray

    @property
    def whole(self) -> ComplexArray:
        """The spectral matrix."""
        return np.asarray(self.road + self.noise + self.orders)


def turned(matrix: Spectral, late: ComplexArray) -> ComplexArray:
    """Return a matrix by line with the front as late as it is in each stretch, (stretch, line, 2, 2)."""
    return np.asarray(late[..., :, None] * matrix * late.conj()[..., None, :])


def axle_model(
    behind: Behind, maps: MapProblem, z: RealArray, levels: Levels, records: Sequence[AxleRecord], road: RoadModel
) -> AxleModel:
    """Return the model of the stretches of one logger; ``road`` is the model of their speeds."""
    track = road.track
    lines = np.round(track.hertz / track.spacing).astype(int)
    s = np.asarray(2j * np.pi * track.hertz, complex)
    weigh, noise = best_motion(maps.problem, z, maps.number, levels, s)
    assert track.speeds is not None
    return AxleModel(
        behind=behind,
        maps=maps,
        records=tuple(records),
        road=road,
        s=s,
        lines=lines,
        weigh=weigh,
        noise=noise,
        by_speed=np.asarray(track.speeds**-2.0 @ track.weights),
    )
