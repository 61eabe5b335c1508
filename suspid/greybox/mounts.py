"""Mounts of unknown stiffness in series with dampers, as further unknowns of a car."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.reconstruction import Unknowns
from suspid.units import RealArray, Second
from suspid.values import nearest_names

TIMES: Second = 0.01  # unit of delays and relaxations
FIRST_RELAXATION = 0.1  # of `TIMES`: at 0 a mount would begin on its bound
RIGID = 1e-3  # of `TIMES`: the least relaxation in time, as good as a rigid mount


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class MountedUnknowns(Unknowns):
    """Unknowns with the relaxation ``c / mount_stiffness`` of some struts at the end of p."""

    mounts: tuple[int, ...]  # struts

    def suspension(self, x: RealArray) -> Suspension:
        """Return the suspension with these unknowns."""
        car = Unknowns.suspension(self, x)
        relaxations = self.parameters(x)[len(self.base) - len(self.mounts) :].tolist()
        struts = list(car.struts)
        for i, relaxation in zip(self.mounts, relaxations, strict=True):
            damping = struts[i].damping
            struts[i] = replace(struts[i], mount_stiffness=damping / relaxation if damping > 0 else None)
        return replace(car, struts=struts)


def with_mounts(unknowns: Unknowns, mounts: Sequence[int]) -> Unknowns:
    """Return unknowns with the relaxation of some struts as well; none for no struts."""
    if not mounts:
        return unknowns
    u, count = unknowns, len(mounts)
    first = [max(u.car.struts[i].relaxation / TIMES, FIRST_RELAXATION) for i in mounts]
    spread = np.zeros((len(u.base) + count, len(u) + count))
    spread[: len(u.base), : len(u)] = u.spread
    spread[len(u.base) :, len(u) :] = TIMES * np.eye(count)
    more = {
        "names": (*u.names, *(f"{u.car.struts[i].name}.relaxation" for i in mounts)),
        "rows": [*u.rows, *(len(u.base) + i for i in range(count))],
        "column": [*u.column, *(len(u) + i for i in range(count))],
        "scale": np.append(u.scale, np.full(count, TIMES)),
        "nominal": np.append(u.nominal, first),
        "positive": np.append(u.positive, np.zeros(count, bool)),
        "lower": np.append(u.lower, np.full(count, RIGID)),
        "upper": np.append(u.upper, np.full(count, np.inf)),
        "prior_std": np.append(u.prior_std, np.full(count, np.inf)),
        "base": np.append(u.base, np.zeros(count)),
        "spread": spread,
    }
    kept = {field.name: getattr(u, field.name) for field in fields(Unknowns) if field.name not in more}
    return MountedUnknowns(**kept, **more, mounts=tuple(mounts))  # type: ignore[arg-type]


def mounts_of(unknowns: Unknowns) -> tuple[int, ...]:
    """Return the struts whose relaxation is unknown."""
    return unknowns.mounts if isinstance(unknowns, MountedUnknowns) else ()


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
            raise InputError(f"{argument}: {name!r} is none of those that can be found.{nearest_names(name, known)}")
    return chosen
