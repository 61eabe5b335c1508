"""Further unknowns in the time domain: mounts of dampers, gains and delays of channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.reconstruction import Unknowns
from suspid.units import RealArray, Second
from suspid.values import nearest_names
from suspid.wording import Argument

TIMES: Second = 0.01  # unit of delays and relaxations
FIRST_RELAXATION = 0.1  # of `TIMES`: at 0 a mount would begin on its bound
RIGID = 1e-3  # of `TIMES`: the least relaxation in time, as good as a rigid mount
GAINS = (1e-4, 1e4)  # between which a gain is looked for: a unit may be wrong by a thousand (mm for m)

SENSOR_KINDS = ("mounts", "gains", "delays")  # as arguments of `estimate`
INPUTS = -1  # in the place of a channel: the known input of a test, which is all its channels turned round

Place = tuple[int, int]  # number of the test, and of the channel in it


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Sensing:
    """What the channels of one test do to what they measure."""

    gains: RealArray  # (channel,)
    delays: RealArray  # (channel,) [s]
    # For each unknown gain or delay of all tests: its channel in this test, `INPUTS`, or none.
    gain_of: tuple[int | None, ...] = ()
    delay_of: tuple[int | None, ...] = ()
    input_gain: float = 1.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class FurtherUnknowns(Unknowns):
    """Unknowns with more at the end of p: relaxations ``c / mount_stiffness``, gains, delays."""

    mounts: tuple[int, ...]  # struts
    gains: tuple[Place, ...]
    delays: tuple[Place, ...]

    @property
    def plain(self) -> int:
        """Number of parameters before those of channels."""
        return len(self.base) - len(self.gains) - len(self.delays)

    def suspension(self, x: RealArray) -> Suspension:
        """Return the suspension with these unknowns."""
        car = Unknowns.suspension(self, x)
        relaxations = self.parameters(x)[self.plain - len(self.mounts) : self.plain].tolist()
        struts = list(car.struts)
        for i, relaxation in zip(self.mounts, relaxations, strict=True):
            damping = struts[i].damping
            struts[i] = replace(struts[i], mount_stiffness=damping / relaxation if damping > 0 else None)
        return replace(car, struts=struts)


def with_further(
    unknowns: Unknowns,
    *,
    mounts: Sequence[int] = (),
    gains: Sequence[tuple[str, Place]] = (),
    delays: Sequence[tuple[str, Place]] = (),
    about: Sequence[tuple[Second, Second]] | None = None,
) -> Unknowns:
    """Return unknowns with the relaxation of some struts as well, and gains and delays of channels, by name.

    ``about`` is where each delay is looked for, and how far to either side; by default about 0, without an end.
    """
    u, a, b, c = unknowns, len(mounts), len(gains), len(delays)
    if not a + b + c:
        return unknowns
    relaxations = [max(u.car.struts[i].relaxation / TIMES, FIRST_RELAXATION) for i in mounts]
    names = [f"{u.car.struts[i].name}.relaxation" for i in mounts]
    names += [*(f"{name}.gain" for name, _ in gains), *(f"{name}.delay" for name, _ in delays)]
    scale, count = np.array([TIMES] * a + [1.0] * b + [TIMES] * c), a + b + c
    middles, reaches = np.array([(0.0, np.inf)] * c if about is None else about).reshape(c, 2).T / TIMES
    spread = np.zeros((len(u.base) + count, len(u) + count))
    spread[: len(u.base), : len(u)] = u.spread
    spread[len(u.base) :, len(u) :] = np.diag(scale)
    more: dict[str, Any] = {
        "names": (*u.names, *names),
        "rows": [*u.rows, *(len(u.base) + i for i in range(count))],
        "column": [*u.column, *(len(u) + i for i in range(count))],
        "scale": np.append(u.scale, scale),
        "nominal": np.append(u.nominal, [*relaxations, *[1.0] * b, *middles]),
        "positive": np.append(u.positive, np.array([False] * a + [True] * b + [False] * c, bool)),
        "lower": np.append(u.lower, [*[RIGID] * a, *[GAINS[0]] * b, *(middles - reaches)]),
        "upper": np.append(u.upper, [*[np.inf] * a, *[GAINS[1]] * b, *(middles + reaches)]),
        "prior_std": np.append(u.prior_std, np.full(count, np.inf)),
        "base": np.append(u.base, np.zeros(count)),
        "spread": spread,
    }
    kept: dict[str, Any] = {field.name: getattr(u, field.name) for field in fields(Unknowns) if field.name not in more}
    return FurtherUnknowns(
        **kept, **more, mounts=tuple(mounts), gains=tuple(p for _, p in gains), delays=tuple(p for _, p in delays)
    )


def mounts_of(unknowns: Unknowns) -> tuple[int, ...]:
    """Return the struts whose relaxation is unknown."""
    return unknowns.mounts if isinstance(unknowns, FurtherUnknowns) else ()


def sensing_of(unknowns: Unknowns, p: RealArray, test: int, channels: int) -> Sensing:
    """Return what the channels of a test do at parameters p."""
    gains, delays, high, late = np.ones(channels), np.zeros(channels), 1.0, 0.0
    if not isinstance(unknowns, FurtherUnknowns):
        return Sensing(gains=gains, delays=delays)
    u = unknowns
    first = u.plain + len(u.gains)
    for places, values, into in ((u.gains, p[u.plain : first], gains), (u.delays, p[first:], delays)):
        for (owner, channel), value in zip(places, values.tolist(), strict=True):
            if owner == test and channel != INPUTS:
                into[channel] = value
            elif owner == test:
                high, late = (value, late) if into is gains else (high, value)
    return Sensing(
        gains=gains / high,
        delays=delays - late,
        input_gain=high,
        gain_of=tuple(channel if owner == test else None for owner, channel in u.gains),
        delay_of=tuple(channel if owner == test else None for owner, channel in u.delays),
    )


def chosen_of(
    argument: str, names: Sequence[str] | None, known: Sequence[str], default: Sequence[str]
) -> Sequence[str]:
    """Return the names that were given for an argument, or the default.

    Raises
    ------
    InputError
        If a name is none of ``known``.
    """
    if names is None:
        return default
    chosen = [names] if isinstance(names, str) else list(names)
    for name in chosen:
        if name not in known:
            raise InputError(
                Argument(argument), f": {name!r} is not one of those that can be estimated.{nearest_names(name, known)}"
            )
    return chosen


def check_some_known(argument: str, names: Sequence[str], channels: Sequence[str]) -> None:
    """Refuse gains or delays of all channels.

    Raises
    ------
    InputError
        If no channel is left that the others can be compared with.
    """
    if set(channels) <= set(names):
        told = "ratios" if argument == "gains" else "differences"
        raise InputError(
            Argument(argument), f": of all channels together only {told} can be found; leave one of them out"
        )


def label(channel: str, number: int, tests: int) -> str:
    """Return the name of a channel of a test; with several tests, each logger has its own clock and gains."""
    return channel if tests == 1 else f"{channel}[{number + 1}]"
