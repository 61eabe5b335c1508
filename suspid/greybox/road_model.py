"""Spectrum of a wheel on a road of ISO 8608: a power law, a smooth departure from it, wheel orders and noise.

``S(f) = L |M|^2 f^-w exp(g) + sum_h A_h p_h(f) |O|^2 + noise`` at each stretch, with M and O the transfers from road
and from a force on the wheel. The level L is free in each stretch, w is free, g a Gaussian process of the logarithm of
wave number (of frequency, where the speed is unknown), p_h the distribution of the h-th order over frequency.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from suspid.greybox.reach import Reach
from suspid.greybox.wheel_power import Track
from suspid.units import Hertz, Metre, Ratio, RealArray

EXPONENT = (2.0, 1.0)  # mean and standard deviation of the exponent, before the record is asked; ISO 8608 has 2
DEPARTURE = 0.3  # standard deviation of the logarithm of the density about the power law
LENGTH = 0.6  # of the departure's correlation, in the logarithm of frequency: shorter ones look like resonances
REFERENCE_HERTZ: Hertz = 4.0  # at which the level is taken, in the middle of the band
NOISE_STD = 0.3  # of the logarithm of the noise of the wheel's motion, about what the suspension's fit found
WHEEL_ORDERS = (1, 2, 3)  # of wheel rotation
# Force of an order [N]: typical size, and standard deviation of the logarithm of its square, 0.2 to 500 N.
ORDER_FORCE, ORDER_STD = 10.0, 4.0
# Power of the speed to which the square of the force grows: 0 for a tire out of round, 4 for an unbalanced one.
ORDER_GROWTH = (2.0, 2.0)
RADIUS_STD: Ratio = 0.02  # of the radius of a rolling wheel, relative, and so of a speed's scale


class Prior(NamedTuple):
    """Mean and standard deviation of each of the road's unknowns."""

    mean: RealArray
    std: RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RoadModel:
    """The unknowns of one wheel's road: w, those of g, the noise, then those of wheel orders."""

    track: Track
    orders: tuple[int, ...]
    radius: Metre
    functions: RealArray  # (point, component): of the departure, at even points
    first: float  # logarithm of wave number (or of frequency) at the first point
    step: float
    components: RealArray  # (stretch, wide line, component): of the departure at the lines

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return 2 + int(self.functions.shape[1]) + (len(self.orders) + 2 if self.orders else 0)

    @property
    def prior(self) -> Prior:
        """What is known before the record is asked."""
        parts = self.functions.shape[1]
        mean, std = [EXPONENT[0], *[0.0] * parts, 0.0], [EXPONENT[1], *[1.0] * parts, NOISE_STD]
        if self.orders:
            mean += [*[float(np.log(ORDER_FORCE**2 / 2))] * len(self.orders), ORDER_GROWTH[0], 0.0]
            std += [*[ORDER_STD] * len(self.orders), ORDER_GROWTH[1], RADIUS_STD]
        return Prior(np.array(mean), np.array(std))

    def departure(self, where: RealArray) -> RealArray:
        """Return the components of g where the logarithm of wave number (or of frequency) is given, (…, component)."""
        return _between(self.functions, (where - self.first) / self.step)

    def rotations(self, order: int, growth: float, log_radius: float) -> RealArray:
        """Return the power of an order of unit variance over the lines of the model, (stretch, wide line).

        Each moment's power goes to the two lines about its frequency. A unit sine of many samples shows half their
        number, summed over the lines.
        """
        track = self.track
        assert track.speeds is not None
        stretches, lines = len(track.power), len(track.wide)
        hertz = order * track.speeds / (2 * np.pi * self.radius * np.exp(log_radius))
        place = (hertz - track.wide[0]) / track.spacing
        below = np.floor(place).astype(int)
        typical = np.exp(np.mean(track.log_speed))
        power = track.samples / 2 * track.weights * (track.speeds / typical) ** growth
        made = np.zeros(stretches * lines)
        row = np.arange(stretches)[:, None] * lines
        for line, share in ((below, 1 - (place - below)), (below + 1, place - below)):
            inside = (line >= 0) & (line < lines)
            made += np.bincount((row + line)[inside], weights=(power * share)[inside], minlength=len(made))
        return made.reshape(stretches, lines)

    def power(self, own: RealArray, levels: RealArray, moved: Reach) -> RealArray:
        """Return the expected power at unknowns of the road, levels by stretch, and a car, (stretch, line)."""
        parts = self._parts(own, levels, moved)
        return np.asarray((parts.road + parts.turning) @ self.track.kernel.T + parts.noise)

    def expected(self, own: RealArray, levels: RealArray, moved: Reach) -> Expected:
        """Return the expected power, and its derivatives."""
        onto, made = self.track.kernel.T, self._parts(own, levels, moved)
        total = (made.road + made.turning) @ onto + made.noise
        columns = [-(made.road * made.ratio) @ onto]
        columns += [(made.road * self.components[:, :, i]) @ onto for i in range(self.components.shape[2])]
        columns += [np.broadcast_to(made.noise, total.shape), *(one @ onto for one in made.rotating)]
        if self.orders:
            for unknown in (-2, -1):
                near = own.copy()
                near[unknown] += SMALL_MOVE
                again = np.sum(self._rotating(near, moved), axis=0)
                columns.append(((again - made.turning) / SMALL_MOVE) @ onto)
        by_car = [
            (made.road * a + made.turning * b) @ onto for a, b in zip(moved.by_road.T, moved.by_force.T, strict=True)
        ]
        return Expected(
            power=total,
            share=made.road @ onto / total,
            by_road=np.stack(columns, axis=2) / total[:, :, None],
            by_car=np.array(by_car).reshape(len(by_car), *total.shape).transpose(1, 2, 0) / total[:, :, None],
        )

    def _parts(self, own: RealArray, levels: RealArray, moved: Reach) -> _Parts:
        track, count = self.track, self.functions.shape[1]
        ratio = np.log(track.wide / REFERENCE_HERTZ)
        logarithm = levels[:, None] + np.log(moved.road) - own[0] * ratio + self.components @ own[1 : 1 + count]
        rotating = self._rotating(own, moved)
        return _Parts(
            ratio=ratio,
            road=np.exp(logarithm),
            rotating=rotating,
            turning=np.sum(rotating, axis=0) if rotating else np.zeros_like(logarithm),
            noise=np.exp(own[1 + count]) * track.noise,
        )

    def _rotating(self, own: RealArray, moved: Reach) -> list[RealArray]:
        if not self.orders:
            return []
        amounts = np.exp(own[-2 - len(self.orders) : -2])
        growth, log_radius = own[-2:].tolist()
        return [
            a * moved.force * self.rotations(h, growth, log_radius) for a, h in zip(amounts, self.orders, strict=True)
        ]


class _Parts(NamedTuple):
    ratio: RealArray  # (wide line,): logarithm of frequency over its reference
    road: RealArray  # (stretch, wide line)
    rotating: list[RealArray]  # by order, (stretch, wide line)
    turning: RealArray  # their sum
    noise: RealArray  # (line,)


SMALL_MOVE = 1e-4  # of the growth of orders and of the logarithm of the radius, in derivatives


class Expected(NamedTuple):
    """Expected power, and derivatives of its logarithm: by the level, by the road's unknowns, by the car's."""

    power: RealArray  # (stretch, line)
    share: RealArray  # (stretch, line)
    by_road: RealArray  # (stretch, line, unknown)
    by_car: RealArray  # (stretch, line, parameter)


def road_model(track: Track, *, radius: Metre | None) -> RoadModel:
    """Return the model of one wheel's road; wheel orders are in it where speed and radius are known."""
    logs = np.log(track.wide) - track.log_speed[:, None]
    # Points at which the departure is worked out.
    points = np.linspace(np.min(logs), np.max(logs), 100)
    covariance = DEPARTURE**2 * np.exp(-0.5 * ((points[:, None] - points) / LENGTH) ** 2)
    values, vectors = np.linalg.eigh(covariance)
    # Power of a component over that of the largest, below which it is left out.
    keep = values > 1e-4 * values[-1]
    orders: tuple[int, ...] = ()
    if track.speeds is not None and radius is not None:
        turns = np.array([np.min(track.speeds), np.max(track.speeds)]) / (2 * np.pi * radius)
        orders = tuple(h for h in WHEEL_ORDERS if h * turns[0] < track.hertz[-1] and h * turns[1] > track.hertz[0])
    functions = vectors[:, keep] * np.sqrt(values[keep])
    return RoadModel(
        track=track,
        orders=orders,
        radius=radius or 1.0,
        functions=functions,
        components=_between(functions, (logs - points[0]) / (points[1] - points[0])),
        first=float(points[0]),
        step=float(points[1] - points[0]),
    )


def _between(rows: RealArray, where: RealArray) -> RealArray:
    """Return rows at places between them, on straight lines, (…, column)."""
    place = np.clip(where, 0, len(rows) - 1.001)
    below = place.astype(int)
    share = (place - below)[..., None]
    return np.asarray(rows[below] * (1 - share) + rows[below + 1] * share)
