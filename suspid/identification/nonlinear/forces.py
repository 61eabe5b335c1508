"""Forces that depend on the motion, other than in proportion: friction, drag, and springs and dampers that bend."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from suspid.units import RealArray


class ForceKind(Enum):
    """How a force follows the displacement d or the speed v between two points of a structure."""

    FRICTION = "friction"  # sign(v): Coulomb; the damping falls with 1 / amplitude
    DRAG = "quadratic damping"  # |v| v: the damping rises with the amplitude
    BENT_DAMPER = "bilinear damping"  # |v|: rebound unlike compression
    CUBIC = "cubic stiffness"  # d^3
    SQUARE = "quadratic stiffness"  # d^2
    BENT_SPRING = "bilinear stiffness"  # |d|


# Kinds that follow a speed; the others follow a displacement.
OF_SPEED = (ForceKind.FRICTION, ForceKind.DRAG, ForceKind.BENT_DAMPER)
# Kinds that are the same for a motion and for its opposite: over a cycle they do no work, and are no spring.
EVEN = (ForceKind.BENT_DAMPER, ForceKind.SQUARE, ForceKind.BENT_SPRING)


@dataclass(frozen=True, kw_only=True, slots=True)
class Force:
    """A force between two measured points, or between one and the ground.

    Parameters
    ----------
    kind : ForceKind
        How it follows the motion.
    channel : int
        Channel whose motion it follows.
    other : int or None
        Channel to which that motion is relative; None: the ground.
    """

    kind: ForceKind
    channel: int
    other: int | None

    def sampled(self, motion: RealArray, speed: RealArray) -> RealArray:
        """Return the mean of the force from each sample to the next, of unit size, (sample,).

        The displacements and speeds of the channels are (channel, sample).
        """
        d, v = self._between(motion), self._between(speed)
        force = mean_sign(v) if self.kind is ForceKind.FRICTION else means(size_of(self.kind, d, v))
        return np.asarray(force / (np.sqrt(np.mean(force**2)) + 1e-300))

    def _between(self, each: RealArray) -> RealArray:
        relative = each[self.channel] - (0.0 if self.other is None else each[self.other])
        return np.asarray(relative / (np.max(np.abs(relative)) + 1e-300))


def forces_of(kind: ForceKind, channels: int, *, most: int) -> tuple[Force, ...]:
    """Return the forces of a kind at every channel, and between every two where those are at most ``most`` in all."""
    single = [Force(kind=kind, channel=c, other=None) for c in range(channels)]
    between = [Force(kind=kind, channel=c, other=other) for c in range(channels) for other in range(c)]
    return tuple(single + between if len(single) + len(between) <= most else single[:most])


def size_of(kind: ForceKind, d: RealArray, v: RealArray) -> RealArray:
    """Return a force by displacement and speed, each over that at which the force is 1."""
    if kind is ForceKind.FRICTION:
        return np.asarray(np.sign(v))
    if kind is ForceKind.DRAG:
        return np.asarray(np.abs(v) * v)
    if kind is ForceKind.BENT_DAMPER:
        return np.asarray(np.abs(v))
    if kind is ForceKind.CUBIC:
        # A power takes five times as long.
        return np.asarray(d * d * d)
    return np.asarray(d**2 if kind is ForceKind.SQUARE else np.abs(d))


def slope_of(kind: ForceKind, followed: RealArray) -> RealArray:
    """Return the derivative of a force other than friction by what it follows, over that at which the force is 1."""
    if kind is ForceKind.DRAG:
        return np.asarray(2 * np.abs(followed))
    if kind is ForceKind.CUBIC:
        return np.asarray(3 * followed * followed)
    return np.asarray(2 * followed if kind is ForceKind.SQUARE else np.sign(followed))


def means(values: RealArray) -> RealArray:
    """Return the mean from each sample to the next, (…, sample), of values that run straight between samples."""
    return np.concatenate([0.5 * (values[..., 1:] + values[..., :-1]), values[..., -1:]], axis=-1)


def mean_sign(speed: RealArray) -> RealArray:
    """Return the mean of the sign between samples of a speed that runs straight from one to the next."""
    before, after = speed[:-1], speed[1:]
    turns = before * after < 0
    share = np.abs(before) / (np.abs(before) + np.abs(after) + 1e-300)
    return np.append(np.where(turns, np.sign(before) * (2 * share - 1), np.sign(before)), np.sign(speed[-1]))
