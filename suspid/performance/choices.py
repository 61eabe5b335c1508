"""Choices of a tuning: its parameters, figures, and the box of the search."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.performance.uncertain import Uncertain
from suspid.reconstruction import QUANTITIES, parameter_values, with_values
from suspid.units import Ratio, RealArray
from suspid.values import is_size, nearest_names
from suspid.wording import Argument

# Parameters are looked for within this factor of the car's own, both ways.
REACH_OF_BOUNDS = 4.0
# A bound, a limit or the result of another search is reached to this share.
REACHED = 1e-3


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Choice:
    """The unknowns: groups of parameters that keep their ratios, and the cars that are looked at for each choice."""

    base: Suspension
    groups: tuple[tuple[str, ...], ...]
    values: Mapping[str, float]
    scenarios: tuple[Mapping[str, float], ...]  # factors of parameters that are uncertain

    @property
    def names(self) -> tuple[str, ...]:
        """All parameters that are chosen."""
        return tuple(name for group in self.groups for name in group)

    def chosen(self, x: RealArray) -> dict[str, float]:
        """Return the parameters at logarithms of factors, one for each group."""
        factors = np.exp(x)
        pairs = zip(self.groups, factors.tolist(), strict=True)
        return {name: self.values[name] * factor for group, factor in pairs for name in group}

    def car(self, x: RealArray, scenario: Mapping[str, float]) -> Suspension:
        """Return the car with chosen parameters, in a scenario."""
        drawn = {name: self.values[name] * factor for name, factor in scenario.items()}
        return with_values(self.base, {**drawn, **self.chosen(x)})


def choice_of(about: Uncertain, parameters: Sequence[str | Sequence[str]], robust: Ratio) -> Choice:
    """Return the unknowns of a request."""
    known = parameter_values(about.car)
    listed = isinstance(parameters, tuple | list) and all(
        isinstance(one, str) or (isinstance(one, tuple | list) and one and all(isinstance(name, str) for name in one))
        for one in parameters
    )
    if not (listed and parameters):
        raise InputError(
            Argument("parameters", repr(parameters)), " must be a sequence of names such as ['chassis.damping']"
        )
    groups = tuple((one,) if isinstance(one, str) else tuple(one) for one in parameters)
    names = [name for group in groups for name in group]
    for name in names:
        if name not in known or name.rpartition(".")[2] not in QUANTITIES:
            allowed = [one for one in known if one.rpartition(".")[2] in QUANTITIES]
            raise InputError(f"there is no spring or damper {name!r}.{nearest_names(name, allowed)}")
        if names.count(name) > 1:
            raise InputError(f"parameter {name!r} is given twice")
        if not known[name]:
            raise InputError(f"parameter {name!r} is zero, and a factor does not change it; give the car a first guess")
    scenarios: tuple[Mapping[str, float], ...] = ({},)
    if robust:
        rows = [i for i, name in enumerate(about.parameters) if name in known and name not in names and known[name]]
        if not rows:
            raise InputError(
                Argument("robust"),
                ": nothing is uncertain apart from the tuned parameters; use an estimated car, or state ",
                Argument("nominal_std"),
            )
        uncertain_names = [about.parameters[i] for i in rows]
        at = np.array([known[name] for name in uncertain_names])
        relative = about.covariance[np.ix_(rows, rows)] / np.outer(at, at)
        values, vectors = np.linalg.eigh(relative)
        reach = vectors * np.sqrt(np.maximum(values, 0.0) * len(rows))
        moves = [sign * column for column in reach.T for sign in (1.0, -1.0)]
        scenarios = tuple(dict(zip(uncertain_names, np.exp(move).tolist(), strict=True)) for move in moves)
    return Choice(base=about.car, groups=groups, values=known, scenarios=scenarios)


def check_ascent(ends: object, *, of: str | None = None) -> None:
    """Refuse bounds that are no two positive numbers, the larger one last."""
    if not (isinstance(ends, tuple | list) and len(ends) == 2 and all(map(is_size, ends)) and ends[0] < ends[1]):
        given = repr(ends) if of is None else f"{of!r} = {ends!r}"
        raise InputError(Argument("bounds"), f": {given} must be two numbers that ascend from above 0")


def box_of(choice: Choice, bounds: Mapping[str, tuple[float, float]]) -> tuple[RealArray, RealArray]:
    """Return the bounds of the logarithms of factors, of each group."""
    firsts = [group[0] for group in choice.groups]
    if not isinstance(bounds, Mapping):
        raise InputError(
            Argument("bounds", f"{bounds!r:.60}"),
            " must map parameters to pairs, as in {'chassis.damping': (500, 4000)}",
        )
    for name in bounds:
        if name not in firsts:
            raise InputError(Argument("bounds"), f": {name!r} is not tuned.{nearest_names(str(name), firsts)}")
    ends = [
        bounds.get(name, (choice.values[name] / REACH_OF_BOUNDS, choice.values[name] * REACH_OF_BOUNDS))
        for name in firsts
    ]
    for name, pair in zip(firsts, ends, strict=True):
        check_ascent(pair, of=name)
    logs = np.log(np.array(ends) / np.array([[choice.values[name]] for name in firsts]))
    return logs[:, 0], logs[:, 1]
