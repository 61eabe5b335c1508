"""Force of a damper over its velocity: piecewise linear curves, friction, and the viscous damper of equal work."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from suspid.errors import InputError
from suspid.model.checks import finite_number
from suspid.units import MetrePerSecond, Newton, NewtonSecondPerMetre, RealArray

# Points of a damper's curve: velocity [m/s] and force [N], both positive in extension.
Curve: TypeAlias = Sequence[tuple[MetrePerSecond, Newton]]


def checked_curve(owner: str, given: object, *, strictly: bool) -> tuple[tuple[float, float], ...]:
    """Return the points of a curve as floats; refuse one that does not rise through zero.

    Raises
    ------
    InputError
        If there are fewer than two points, one is not finite, velocities do not increase, forces fall (with
        ``strictly``: or stay), or the force is not zero at rest.
    """
    if isinstance(given, str) or not isinstance(given, Sequence | np.ndarray) or len(given) < 2:
        raise InputError(f"{owner}: curve = {given!r} must have two or more points (velocity [m/s], force [N])")
    points = []
    for number, point in enumerate(given, start=1):
        if isinstance(point, str) or not isinstance(point, Sequence | np.ndarray) or len(point) != 2:
            raise InputError(f"{owner}: curve: point {number} = {point!r} must be a pair (velocity [m/s], force [N])")
        velocity = finite_number(f"{owner}: curve: velocity {number}", point[0], "m/s")
        points.append((velocity, finite_number(f"{owner}: curve: force {number}", point[1], "N")))
    for number, ((v, f), (later, larger)) in enumerate(pairwise(points), start=1):
        if later <= v:
            raise InputError(f"{owner}: curve: velocity {number + 1} = {later:g} m/s does not exceed {v:g} m/s")
        if larger < f or (strictly and larger == f):
            raise InputError(
                f"{owner}: curve: the force falls from {f:g} to {larger:g} N between {v:g} and {later:g} m/s; it must "
                f"rise with the velocity"
                + (", and strictly where the damper is on a mount" if strictly and larger == f else "")
            )
    rest = float(piecewise(points, np.zeros(1))[0])
    # A curve may miss zero by this share of its largest force: rounding of the points.
    if abs(rest) > 1e-9 * max(abs(f) for _, f in points):
        raise InputError(
            f"{owner}: curve: the force at rest is {rest:g} N and must be 0; a static force belongs to the position "
            f"of rest, a force that changes sign with the velocity is friction = {abs(rest):g}"
        )
    return tuple(points)


def slopes(points: Curve) -> RealArray:
    """Return the slopes [N s/m] of the pieces between the points."""
    table = np.array(points, float)
    return np.asarray(np.diff(table[:, 1]) / np.diff(table[:, 0]))


def piecewise(points: Curve, velocity: RealArray) -> RealArray:
    """Return the force [N] at velocities [m/s], extrapolated with the slopes at the ends."""
    table, rate = np.array(points, float), slopes(points)
    piece = np.clip(np.searchsorted(table[:, 0], velocity) - 1, 0, len(rate) - 1)
    return np.asarray(table[piece, 1] + rate[piece] * (velocity - table[piece, 0]))


def equal_work(points: Curve, friction: Newton, amplitude: MetrePerSecond) -> NewtonSecondPerMetre:
    """Return the viscous damping that takes as much work per cycle of ``amplitude sin(omega t)`` [N s/m].

    ``c = 2 / (pi V) integral F(V sin phi) sin phi dphi`` from -pi/2 to pi/2, which is ``4 friction / (pi V)`` for
    friction alone; the amplitude V is one of velocity.

    Examples
    --------
    >>> equal_work(((0.0, 0.0), (1.0, 1300.0)), 0.0, 0.2), equal_work(((-1, -500), (0, 0), (1, 1500)), 0.0, 0.2)
    (1300.0, 1000.0)
    """
    table, rate = np.array(points, float), slopes(points)
    inner = table[np.abs(table[:, 0]) < amplitude, 0]
    phi = np.arcsin(np.concatenate([[-1.0], inner / amplitude, [1.0]]))
    middle = amplitude * np.sin((phi[1:] + phi[:-1]) / 2)
    piece = np.clip(np.searchsorted(table[:, 0], middle) - 1, 0, len(rate) - 1)
    offset = table[piece, 1] - rate[piece] * table[piece, 0]
    work = np.sum(-offset * np.diff(np.cos(phi)) + rate[piece] * amplitude * np.diff(phi / 2 - np.sin(2 * phi) / 4))
    return float(2 / (math.pi * amplitude) * work + 4 * friction / (math.pi * amplitude))
