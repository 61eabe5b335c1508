"""Transfer from measured causes to the other channels, with derivatives of rank one.

With q the free coordinates and g those whose motion is given, ``D(s) q = N(s) g + i(s)``. A channel shows
``P g + H D^-1 i``. The channels are split into causes (as many as given coordinates, ``P_g`` invertible) and outputs:
``T = P_o P_g^-1``. A parameter changes P by ``a beta`` (channel by given coordinate), so it changes T by
``(a_o - T a_g) beta P_g^-1``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.greybox.small_matrices import inverses
from suspid.greybox.trials import Trial
from suspid.model import Suspension
from suspid.units import ComplexArray, RealArray
from suspid.values import listed
from suspid.wording import Argument

# Terms of the polynomial that the ends of a stretch leave: momentum and motion, and two that sampling folds back. With
# fewer, k of a car without any noise is off by 2e-5, with these by 1e-7. A damper on a mount needs one more.
ENDS = 4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Layout:
    """Which coordinates are given, and which channels show them."""

    free: tuple[int, ...]
    given: tuple[int, ...]
    causes: tuple[int, ...]  # channels, one for each given coordinate
    outputs: tuple[int, ...]  # the other channels
    orders: NDArray[np.intp]  # (channel,)
    on_free: RealArray  # (channel, free coordinate)
    on_given: RealArray  # (channel, given coordinate)
    arms_free: RealArray  # (strut, free coordinate)
    arms_given: RealArray  # (strut, given coordinate)
    pushes: RealArray  # (free coordinate, given): of forces that are measured

    @property
    def bridges(self) -> tuple[int, ...]:
        """Struts that act on a free coordinate."""
        return tuple(np.flatnonzero(np.any(self.arms_free != 0, axis=1)).tolist())


def layout_of(car: Suspension, trial: Trial) -> Layout:
    """Return the layout of a trial whose cause is measured motion.

    Raises
    ------
    InputError
        If a free coordinate stands on a road that is not given, nothing is left free, or the channels do not show the
        given motion, or nothing else.
    """
    if len(trial.sensed_roads) + trial.sensed_forces:
        return _of_inputs(car, trial)
    given = list(trial.wheels)
    free = [i for i in range(len(car.coordinates)) if i not in given]
    if not free:
        raise InputError(Argument("given"), ": the motion of every coordinate is given; nothing is left to fit")
    arms = car.arms(car.coordinates)
    on_road = np.any(car.arms(car.roads) != 0, axis=1)
    for i, strut in enumerate(car.struts):
        if on_road[i] and np.any(arms[i, free]):
            raise InputError(
                Argument("given"),
                f": strut {strut.name!r} connects {listed([car.coordinates[j] for j in free if arms[i, j]])} to a "
                f"road whose motion is not known; give {listed([car.coordinates[j] for j in free if arms[i, j]])} too",
            )
    on_given = trial.weights[:, given]
    mixed = np.any(trial.weights[:, free] != 0, axis=1)
    causes: list[int] = []
    for channel in np.argsort(mixed, kind="stable").tolist():
        if np.linalg.matrix_rank(on_given[[*causes, channel]]) > len(causes):
            causes.append(channel)
    missing = [car.coordinates[g] for i, g in enumerate(given) if not np.any(on_given[:, i])]
    if len(causes) < len(given):
        names = listed(missing or [car.coordinates[g] for g in given])
        raise InputError(
            Argument("given"),
            f": no channel measures the motion of {names}, or several channels measure the same motion",
        )
    outputs = [i for i in range(len(trial.channels)) if i not in causes]
    if not any(np.any(trial.weights[i, free]) for i in (*causes, *outputs)) or not outputs:
        raise InputError(
            Argument("given"), f": no channel measures the motion of {listed([car.coordinates[i] for i in free])}"
        )
    return Layout(
        free=tuple(free),
        given=tuple(given),
        causes=tuple(causes),
        outputs=tuple(outputs),
        orders=trial.orders,
        on_free=trial.weights[:, free],
        on_given=on_given,
        arms_free=arms[:, free],
        arms_given=arms[:, given],
        pushes=np.zeros((len(free), len(given))),
    )


def _of_inputs(car: Suspension, trial: Trial) -> Layout:
    """Return the layout of a trial whose last channels measure the roads and forces that move it."""
    roads, forces, channels = len(trial.sensed_roads), trial.sensed_forces, len(trial.channels)
    arms, on_force = car.arms(car.coordinates), np.zeros((channels, forces))
    on_force[channels - forces :] = np.eye(forces)
    return Layout(
        free=tuple(range(len(car.coordinates))),
        given=tuple(range(roads + forces)),
        causes=tuple(range(channels - roads - forces, channels)),
        outputs=tuple(range(channels - roads - forces)),
        orders=trial.orders,
        on_free=trial.weights,
        on_given=np.hstack([trial.road_weights[:, list(trial.sensed_roads)], on_force]),
        arms_free=arms,
        arms_given=np.hstack([car.arms(car.roads)[:, list(trial.sensed_roads)], np.zeros((len(arms), forces))]),
        pushes=np.hstack([np.zeros((len(car.coordinates), roads)), trial.forces.T]),
    )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Physics:
    """Values of all parameters."""

    stiffness: RealArray  # (strut,)
    damping: RealArray  # (strut,)
    masses: RealArray  # (coordinate,)
    relaxation: RealArray  # (strut,) [s]
    gains: RealArray  # (channel,)
    delays: RealArray  # (channel,) [s]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Transfer:
    """Transfer at every line, and how parameters change it: ``dT = left right[:, place]`` by parameter."""

    T: ComplexArray  # (line, output, cause)
    left: ComplexArray  # (line, output, parameter)
    right: ComplexArray  # (line, place, cause): spring, damper and mount of a strut act at one place
    ends: ComplexArray  # (line, channel, column): what the ends of a stretch leave
    ends_right: ComplexArray  # (line, place, column): parameters change it by ``a ends_right[:, place]``
    places: tuple[int, ...]  # of each parameter
    outputs: tuple[int, ...]
    causes: tuple[int, ...]

    @property
    def left_by_ends(self) -> ComplexArray:
        """What the ends of a stretch leave in the residual, (line, output, column)."""
        return np.asarray(self.ends[:, list(self.outputs)] - self.T @ self.ends[:, list(self.causes)])


class _Motion(NamedTuple):
    """What the motion of a car follows from, at every line."""

    rate: ComplexArray  # (line, strut): s / (1 + s tau)
    derive: ComplexArray  # (line, channel): what a channel makes of a displacement
    inverse: ComplexArray  # (line, free, free): D^-1
    N: ComplexArray  # (line, free, given)
    shown: ComplexArray  # (line, channel, free): H D^-1
    P: ComplexArray  # (line, channel, given)


def _motion(layout: Layout, s: ComplexArray, physics: Physics) -> _Motion:
    rate = s[:, None] / (1 + s[:, None] * physics.relaxation)
    b = physics.stiffness + physics.damping * rate
    af, ag, struts = layout.arms_free, layout.arms_given, len(physics.stiffness)
    D = (b @ (af[:, :, None] * af[:, None, :]).reshape(struts, -1)).reshape(len(s), af.shape[1], af.shape[1])
    own = np.arange(len(layout.free))
    D[:, own, own] += s[:, None] ** 2 * physics.masses[list(layout.free)]
    N = -(b @ (af[:, :, None] * ag[:, None, :]).reshape(struts, -1)).reshape(len(s), af.shape[1], ag.shape[1])
    if np.any(layout.pushes):
        N = N + layout.pushes
    inverse = inverses(np.asarray(D, complex))
    derive = np.stack([_power(s, order) for order in layout.orders.tolist()], axis=1) * physics.gains
    if np.any(physics.delays):
        derive = derive * np.exp(-s[:, None] * physics.delays)
    shown = np.asarray((layout.on_free @ inverse) * derive[:, :, None], complex)
    return _Motion(rate, derive, inverse, N, shown, shown @ N + layout.on_given * derive[:, :, None])


def shown_by_causes(layout: Layout, s: ComplexArray, physics: Physics) -> ComplexArray:
    """Return T alone, (line, output, cause)."""
    P = _motion(layout, s, physics).P
    return np.asarray(P[:, list(layout.outputs)] @ inverses(P[:, list(layout.causes)]))


def transfer(
    layout: Layout,
    s: ComplexArray,
    physics: Physics,
    rows: Sequence[int],
    *,
    mounts: Sequence[int],
    gains: Sequence[int],
    delays: Sequence[int],
) -> Transfer:
    """Return the transfer with its derivatives by the parameters ``rows`` of the car, mounts, gains and delays.

    ``rows`` count stiffnesses, then dampings, then masses. Gains and delays are given by channel.
    """
    o, g = list(layout.outputs), list(layout.causes)
    struts, af, ag = len(physics.stiffness), layout.arms_free, layout.arms_given
    rate, derive, inverse, N, shown, P = _motion(layout, s, physics)
    back = inverses(P[:, g])
    T = P[:, o] @ back
    motion: Any = inverse @ N
    unit = s / np.abs(s).max()
    # The ends leave ``D^-1 (i_0 + i_1 s)`` where causes and outputs are derivatives of one order, and as many more
    # powers as their orders differ.
    reference, orders = int(layout.orders[g].max()), layout.orders[o]
    lowest, highest = -max(0, int(orders.max()) - reference), ENDS + max(0, reference - int(orders.min()))
    highest += bool(len(mounts) or np.any(physics.relaxation))
    own_ends = _own_ends(layout, unit, reference)
    powers = np.stack([_power(unit, m - reference) for m in range(lowest, highest)], axis=1)[:, None, :, None]
    nothing = own_ends.shape[2]

    def with_powers(values: Any) -> ComplexArray:
        made = np.zeros((len(s), values.shape[1], powers.shape[2] * values.shape[2] + nothing), complex)
        shifted = powers * values[:, :, None, :]
        made[:, :, : made.shape[2] - nothing] = shifted.reshape(len(s), values.shape[1], -1)
        return made

    ends, ends_of_mass = with_powers(shown), with_powers(inverse)
    stretch, motion = (af @ motion + ag) @ back, motion @ back
    per_strut, per_mass = -shown @ af.T, -shown * s[:, None, None] ** 2
    lefts, keys = [], list[tuple[str, int]]()
    for row in rows:
        j = row % struts if row < 2 * struts else row - 2 * struts
        if row < 2 * struts:
            lefts.append(per_strut[:, :, j] if row < struts else per_strut[:, :, j] * rate[:, j : j + 1])
            keys.append(("strut", j))
        elif j in layout.free:
            lefts.append(per_mass[:, :, layout.free.index(j)])
            keys.append(("mass", layout.free.index(j)))
        else:
            lefts.append(np.zeros_like(derive))
            keys.append(("channel", 0))
    for j in mounts:
        lefts.append(-physics.damping[j] * rate[:, j : j + 1] ** 2 * per_strut[:, :, j])
        keys.append(("strut", j))
    lines = np.ones(len(s))
    for channel, factor in [(c, lines / physics.gains[c]) for c in gains] + [(c, -s) for c in delays]:
        alone = np.zeros_like(derive)
        alone[:, channel] = factor
        lefts.append(alone)
        keys.append(("channel", channel))
    shows = P @ back

    def acts(kind: str, at: int) -> tuple[ComplexArray, ComplexArray]:
        """Return what acts at a place, an elongation, a motion or a channel, by causes and by ends."""
        if kind == "strut":
            return stretch[:, at], np.asarray(af[at] @ ends_of_mass)
        return (motion[:, at], ends_of_mass[:, at]) if kind == "mass" else (shows[:, at], ends[:, at])

    places = list(dict.fromkeys(keys))
    right, ends_right = (np.stack(one, axis=1) for one in zip(*[acts(*key) for key in places], strict=True))
    ends[:, :, ends.shape[2] - own_ends.shape[2] :] = own_ends
    a = np.stack(lefts, axis=2)
    return Transfer(
        T=T,
        left=a[:, o] - T @ a[:, g],
        right=right,
        ends=ends,
        ends_right=ends_right,
        places=tuple(places.index(key) for key in keys),
        outputs=layout.outputs,
        causes=layout.causes,
    )


def _power(values: ComplexArray, exponent: int) -> ComplexArray:
    """Return an integer power; that of NumPy takes logarithms of complex numbers, fifty times as long."""
    made = np.ones_like(values)
    for _ in range(abs(exponent)):
        made = made * values
    return np.asarray(1 / made if exponent < 0 else made)


def _own_ends(layout: Layout, unit: ComplexArray, reference: int) -> ComplexArray:
    """Return what the ends of a stretch leave in outputs that show given motion themselves, (line, channel, column).

    Where the given motion is measured as a derivative of another order, ``reference``, the two differ by powers of s.
    """
    columns = [
        (c, m)
        for c in layout.outputs
        if np.any(layout.on_given[c])
        for m in range(min(0, int(layout.orders[c]) - reference), max(0, int(layout.orders[c]) - reference))
    ]
    ends = np.zeros((len(unit), len(layout.orders), len(columns)), complex)
    for i, (channel, power) in enumerate(columns):
        ends[:, channel, i] = _power(unit, power)
    return ends
