"""Linear relations between the springs and dampers that are chosen, written as for `reconstruct`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.performance.choices import Choice
from suspid.performance.figure_plan import MOST_CLEARANCE
from suspid.reconstruction import Constraints, parameter_names, unknowns_of, wishes_of
from suspid.units import RealArray
from suspid.values import is_size
from suspid.wording import Argument

# What a tuning is bound to: largest values of figures by name, and relations.
Limits: TypeAlias = Mapping[str, float] | Constraints | Sequence[Mapping[str, float] | str | Callable[..., Any]]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Relations:
    """Relations ``matrix @ factors <= limit`` between the factors by which parameters change, or equations."""

    labels: tuple[str, ...]  # of each row
    matrix: RealArray  # (row, parameter), in units in which the largest term of a row is 1
    limit: RealArray
    equal: NDArray[np.bool_]
    member: RealArray  # (parameter, group)

    def room(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the room below each limit at logarithms of factors, (row,), and its derivatives, (row, group)."""
        terms = self.matrix * np.exp(self.member @ x)
        return self.limit - np.sum(terms, axis=1), -terms @ self.member

    def broken(self, x: RealArray) -> RealArray:
        """Return by how much each row is broken, (row,)."""
        room, _ = self.room(x)
        return np.where(self.equal, np.abs(room), np.maximum(-room, 0.0))


def check_largest(limits: Mapping[str, float]) -> None:
    """Refuse a largest value of a figure that is no positive number."""
    if not isinstance(limits, Mapping):
        raise InputError(Argument("constraints", repr(limits)), " must map figures to their largest values")
    for name, limit in limits.items():
        if not is_size(limit):
            raise InputError(
                Argument("constraints"), f": {name!r} = {limit!r} must be a positive number within the usual range"
            )
        if name.endswith("travel") and limit > MOST_CLEARANCE:
            raise InputError(
                Argument("constraints"),
                f": {name} <= {limit:g} m is more than any suspension has, {MOST_CLEARANCE:g} m; give it in m",
            )


def split(given: Limits | None) -> tuple[dict[str, float], list[object]]:
    """Return largest values of figures, and relations, from constraints as a user gives them.

    Examples
    --------
    >>> split(["front.damping == 1.2 * rear.damping", {"front.travel": 0.02}])
    ({'front.travel': 0.02}, ['front.damping == 1.2 * rear.damping'])
    """
    if given is not None and not (isinstance(given, Mapping | str | list | tuple) or callable(given)):
        raise InputError(
            Argument("constraints", f"{given!r:.60}"),
            " must map figures to their largest values, or contain relations such as 'front.damping >= rear.damping'",
        )
    parts = [given] if isinstance(given, Mapping | str) or callable(given) else list(given or ())
    limits: dict[str, float] = {}
    for one in parts:
        if isinstance(one, Mapping):
            limits |= one
    return limits, [one for one in parts if not isinstance(one, Mapping)]


def relations_of(choice: Choice, car: Suspension, given: Sequence[object]) -> Relations:
    """Return relations between what is chosen; everything else is as in the car.

    Raises
    ------
    InputError
        If one cannot be read, is not linear, or holds nothing that is chosen.
    """
    chosen = choice.names
    member = np.array([[name in group for group in choice.groups] for name in chosen], float)
    if not given:
        empty = np.zeros((0, len(chosen)))
        return Relations(labels=(), matrix=empty, limit=np.zeros(0), equal=np.zeros(0, bool), member=member)
    struts = parameter_names(car)[: 2 * len(car.struts)]
    # Springs of zero stiffness are held by themselves.
    unknowns = unknowns_of(car, rate=1.0, fixed=[name for name in struts if name not in chosen])
    made = wishes_of(given, None, unknowns)  # type: ignore[arg-type]
    assert made is not None
    if made.curved:
        raise InputError(f"constraint {made.labels[made.curved[0]]!r} is not linear in k and c; write linear ones")
    for number, label in enumerate(made.labels):
        if number not in made.owner:
            raise InputError(f"constraint {label!r} contains no tuned parameter; these are {', '.join(chosen)}")
    order = [unknowns.names.index(name) for name in chosen]
    now = np.array([choice.values[name] for name in chosen])
    matrix = made.matrix[:, order] / unknowns.scale[order] * now
    size = np.maximum(np.max(np.abs(matrix), axis=1), np.abs(made.limit))
    return Relations(
        labels=tuple(made.labels[i] for i in made.owner.tolist()),
        matrix=matrix / size[:, None],
        limit=made.limit / size,
        equal=made.equal,
        member=member,
    )
