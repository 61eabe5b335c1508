"""Which parameters are asked for: what is held, tied, bounded or known beforehand, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.reconstruction.unknowns import QUANTITIES, Unknowns, parameter_names, parameter_vector
from suspid.units import RadianPerSecond, Ratio, RealArray
from suspid.values import frozen_real, nearest_names
from suspid.wording import Argument

LEAST = 1e-6  # of nominal: k > 0 and mass > 0 as closed bounds

Bounds: TypeAlias = Mapping[str, tuple[float | None, float | None]]


def unknowns_of(
    car: Suspension,
    *,
    rate: RadianPerSecond,
    fixed: Sequence[str] = (),
    bounds: Bounds | None = None,
    ties: Sequence[Sequence[str]] = (),
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
    free_masses: Sequence[str] = (),
) -> Unknowns:
    """Return what is to be found, checked; see `reconstruct` for the arguments.

    Dampings are scaled by the angular ``rate`` [rad/s].
    """
    every, p = parameter_names(car), parameter_vector(car)
    named = nominal_std if isinstance(nominal_std, Mapping) else {}
    free = [free_masses] if isinstance(free_masses, str) else list(free_masses)
    # A mass that is known to a standard deviation is an unknown with a measured value.
    held = _held(car, every, fixed, [*free, *(name for name in named if name in every[2 * len(car.struts) :])])
    for name in named:
        if _index(every, name, "nominal_std") in held:
            raise InputError(
                Argument("nominal_std"), f": {name!r} is fixed, so it needs no spread; leave out one of the two"
            )
    group = _groups(every, ties)
    held, base = _tied_to_held(every, group, held, p)
    rows = [i for i in range(len(every)) if i not in held]
    if not rows:
        raise InputError(Argument("fixed"), " contains every parameter: leave out those that are to be found")
    first = sorted({group[i] for i in rows})
    column = [first.index(group[i]) for i in rows]
    members = [[r for r, c in zip(rows, column, strict=True) if c == i] for i in range(len(first))]
    struts = len(car.struts)
    positive = np.array([not struts <= one[0] < 2 * struts for one in members])
    values = np.array([float(np.mean(p[one])) for one in members])
    scale = np.where(positive, values, [_critical(one, p, struts, rate) for one in members])
    nominal = values / scale
    base[rows] = 0.0
    spread = np.zeros((len(every), len(first)))
    spread[rows, column] = scale[column]
    lower, upper = _bounded(every, rows, column, bounds, scale, positive)
    std = np.full(len(first), np.inf)
    for i, share in enumerate(_relative_stds(every, rows, nominal_std, p)):
        if share is not None:
            std[column[i]] = min(std[column[i]], share * nominal[column[i]])
    return Unknowns(
        car=car,
        names=tuple(every[i] for i in rows),
        rows=rows,
        column=column,
        scale=frozen_real(scale),
        nominal=frozen_real(np.clip(nominal, lower, upper)),
        positive=positive,
        lower=frozen_real(lower),
        upper=frozen_real(upper),
        prior_std=frozen_real(std),
        base=frozen_real(base),
        spread=frozen_real(spread),
        arms=frozen_real(car.arms(car.coordinates)),
    )


def _groups(every: Sequence[str], ties: Sequence[Sequence[str]]) -> list[int]:
    """Return the group of each parameter: the first of those that it is tied to."""
    group = list(range(len(every)))
    for tie in ties:
        members = [_index(every, name, "ties") for name in ([tie] if isinstance(tie, str) else tie)]
        kinds = {every[i].rpartition(".")[2] for i in members}
        if len(members) < 2 or len(kinds) > 1:
            raise InputError(Argument("ties"), f": {tuple(tie)!r} must be at least two parameters of one kind")
        joined = {group[i] for i in members}
        group = [min(joined) if g in joined else g for g in group]
    return group


def _tied_to_held(
    every: Sequence[str], group: Sequence[int], held: set[int], p: RealArray
) -> tuple[set[int], RealArray]:
    """Return which parameters are held, those tied to a held one as well, and the values of all."""
    held, base = set(held), p.copy()
    for g in set(group):
        members = [i for i, other in enumerate(group) if other == g]
        stuck = [i for i in members if i in held]
        if not stuck or len(members) == 1:
            continue
        if np.ptp(p[stuck]) > 1e-12 * np.max(np.abs(p[stuck])):
            raise InputError(Argument("ties"), f": {', '.join(every[i] for i in stuck)} are fixed at different values")
        base[members] = p[stuck[0]]
        held |= set(members)
    return held, base


def _critical(members: Sequence[int], p: RealArray, struts: int, rate: RadianPerSecond) -> float:
    """Return the scale of a damping [N s/m]: stiffness of its strut over an angular frequency; 1 for other kinds."""
    if not struts <= members[0] < 2 * struts:
        return 1.0
    springs, stiffest = p[[m - struts for m in members]], float(np.max(p[:struts], initial=0.0)) or 1.0
    return float(np.mean(np.where(springs > 0, springs, stiffest))) / rate


def _bounded(
    every: Sequence[str],
    rows: Sequence[int],
    column: Sequence[int],
    bounds: Bounds | None,
    scale: RealArray,
    positive: NDArray[np.bool_],
) -> tuple[RealArray, RealArray]:
    """Return lower and upper bounds of the unknowns."""
    lower, upper = np.where(positive, LEAST, 0.0), np.full(len(scale), np.inf)
    for name, ends in (bounds or {}).items():
        at = _index(every, name, "bounds")
        if at not in rows:
            raise InputError(
                Argument("bounds"), f": {name!r} is fixed, so it needs no bounds; leave out one of the two"
            )
        i = column[list(rows).index(at)]
        low, high = _ends(name, ends)
        lower[i], upper[i] = max(lower[i], low / scale[i]), min(upper[i], high / scale[i])
        if not lower[i] < upper[i]:
            raise InputError(
                Argument("bounds"), f": no value is left for {name!r} between {lower[i] * scale[i]:g} and {high:g}"
            )
    return lower, upper


def _held(car: Suspension, every: Sequence[str], fixed: Sequence[str], free_masses: Sequence[str]) -> set[int]:
    """Return which parameters are not asked for: held, masses that are known, and springs that are none."""
    struts, free = [s.name for s in car.struts], set()
    for name in [free_masses] if isinstance(free_masses, str) else free_masses:
        mass = name if name in every else f"{name}.mass"
        if mass not in every[2 * len(struts) :]:
            raise InputError(
                Argument("free_masses"), f": there is no mass {name!r}.{nearest_names(name, car.coordinates)}"
            )
        free.add(every.index(mass))
    held = {i for i, s in enumerate(car.struts) if s.stiffness == 0}
    held |= {i for i in range(2 * len(struts), len(every)) if i not in free}
    for name in [fixed] if isinstance(fixed, str) else fixed:
        if name not in every and name not in struts:
            raise InputError(
                Argument("fixed"), f": there is no strut parameter {name!r}.{nearest_names(name, [*every, *struts])}"
            )
        if name in every and every.index(name) in free:
            raise InputError(
                f"{name!r} is in both ",
                Argument("fixed"),
                " and ",
                Argument("free_masses"),
                "; leave out one of the two",
            )
        held |= {every.index(name)} if name in every else {every.index(f"{name}.{q}") for q in QUANTITIES}
    return held


def _index(every: Sequence[str], name: str, argument: str) -> int:
    if name not in every:
        raise InputError(Argument(argument), f": there is no parameter {name!r}.{nearest_names(str(name), every)}")
    return every.index(name)


def _ends(name: str, ends: tuple[float | None, float | None]) -> tuple[float, float]:
    if not isinstance(ends, Sequence) or isinstance(ends, str) or len(ends) != 2:
        raise InputError(Argument("bounds"), f": {name!r} has {ends!r}; give (low, high), with None for no bound")
    low, high = (-np.inf if ends[0] is None else float(ends[0])), (np.inf if ends[1] is None else float(ends[1]))
    if not low < high:
        raise InputError(
            Argument("bounds"), f": {name!r} has low = {low:g} and high = {high:g}; low must be below high"
        )
    return low, high


def _relative_stds(
    every: Sequence[str], rows: Sequence[int], given: Ratio | Mapping[str, Ratio] | None, p: RealArray
) -> list[float | None]:
    """Return the relative standard deviation of the nominal value by free parameter; None where there is none."""
    if given is None:
        return [None] * len(rows)
    if isinstance(given, Mapping):
        named = {_index(every, name, "nominal_std"): float(value) for name, value in given.items()}
        empty = [every[i] for i in named if p[i] == 0]
        if empty:
            raise InputError(
                Argument("nominal_std"),
                f": {empty[0]!r} is 0, and a relative spread of 0 is none; use ",
                Argument("bounds"),
                " or ",
                Argument("fixed"),
            )
    else:
        named = {i: float(given) for i in rows if p[i] > 0}
    for i, value in named.items():
        if not (np.isfinite(value) and value > 0):
            raise InputError(
                Argument("nominal_std"), f": {every[i]!r} has {value}; it must be positive, as 0.3 for 30 %"
            )
    return [named.get(i) for i in rows]
