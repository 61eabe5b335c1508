"""What is unknown of a suspension: stiffnesses, dampings and masses, less what is held or tied."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.units import RadianPerSecond, Ratio, RealArray
from suspid.values import frozen_real, nearest_names

QUANTITIES = ("stiffness", "damping")
LEAST = 1e-6  # of nominal: k > 0 and mass > 0 as closed bounds
NEXT_TO_NONE = 1e-3  # of nominal: a spring that small is judged beside the nominal one
ROUNDING = 1e-13  # of the strongest damper

Bounds: TypeAlias = Mapping[str, tuple[float | None, float | None]]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Unknowns:
    """Dimensionless unknowns x, each the value of one parameter (or of several tied ones) over its scale.

    All parameters of a suspension are one vector p: k of every strut, c of every strut, every mass.

    Parameters
    ----------
    car : Suspension
        The nominal suspension.
    names : tuple of str
        Of the parameters that are not held, in the order of p.
    rows : list of int
        Where each of `names` stands in p.
    column : list of int
        Which unknown each of `names` is; tied ones share theirs.
    scale : ndarray (unknown,)
        What 1 means [N/m, N s/m or kg].
    nominal : ndarray (unknown,)
        Nominal values over `scale`.
    positive : ndarray (unknown,)
        Which are stiffnesses or masses: stepped in their logarithm.
    lower, upper : ndarray (unknown,)
        Bounds over `scale`.
    prior_std : ndarray (unknown,)
        Standard deviation of the nominal value over `scale`; infinite where none is stated.
    base, spread : ndarray (parameter,), (parameter, unknown)
        ``p = base + spread @ x``.
    arms : ndarray (strut, coordinate)
        Elongation of each strut per unit of each coordinate.
    """

    car: Suspension
    names: tuple[str, ...]
    rows: list[int]
    column: list[int]
    scale: RealArray
    nominal: RealArray
    positive: NDArray[np.bool_]
    lower: RealArray
    upper: RealArray
    prior_std: RealArray
    base: RealArray
    spread: RealArray
    arms: RealArray

    def __len__(self) -> int:
        return len(self.scale)

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each unknown: of the parameter, or of those tied, joined by ``=``."""
        return tuple(
            " = ".join(n for n, c in zip(self.names, self.column, strict=True) if c == i) for i in range(len(self))
        )

    @property
    def has_prior(self) -> NDArray[np.bool_]:
        """Of which unknowns a nominal value with a standard deviation is data."""
        return np.isfinite(self.prior_std)

    def parameters(self, x: RealArray) -> RealArray:
        """Return p = (k, c, masses) of unknowns x, (…, parameter), in SI units."""
        return np.asarray(self.base + x @ self.spread.T)

    def sizes(self, x: RealArray) -> RealArray:
        """Return what a change of 1 means: of springs and masses themselves, unless there is next to none; else 1."""
        return np.where(self.positive & (x > NEXT_TO_NONE), x, 1.0)

    def settled(self, x: RealArray) -> RealArray:
        """Return x with dampers that are nothing but rounding on their bound."""
        strongest = np.max(x[~self.positive], initial=0.0)
        return np.where(~self.positive & (x - self.lower < ROUNDING * strongest), self.lower, x)

    def suspension(self, x: RealArray) -> Suspension:
        """Return the suspension with these unknowns."""
        p, struts = self.parameters(x).tolist(), [s.name for s in self.car.struts]
        n = len(struts)
        return self.car.with_parameters(
            stiffness=dict(zip(struts, p[:n], strict=True)),
            damping=dict(zip(struts, p[n : 2 * n], strict=True)),
            masses=dict(zip(self.car.coordinates, p[2 * n :], strict=True)),
        )

    def prior(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return how far x is from the nominal values in their standard deviations, and the derivatives."""
        told = self.has_prior
        std = self.prior_std[told]
        return (x - self.nominal)[told] / std, np.eye(len(x))[told] / std[:, None]


def parameter_vector(car: Suspension) -> RealArray:
    """Return p = (k of every strut, c of every strut, every mass)."""
    return np.array([*(s.stiffness for s in car.struts), *(s.damping for s in car.struts), *car.masses.values()])


def parameter_names(car: Suspension) -> list[str]:
    """Return the names of p.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> parameter_names(car)[1:5]
    ['tire.stiffness', 'chassis.damping', 'tire.damping', 'chassis.mass']
    """
    return [*(f"{s.name}.{q}" for q in QUANTITIES for s in car.struts), *(f"{m}.mass" for m in car.masses)]


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

    Parameters
    ----------
    rate : float
        Angular frequency [rad/s] by which dampings are scaled.

    Raises
    ------
    InputError
        If a name is unknown, wishes contradict each other, or nothing is left to find.
    """
    every, p = parameter_names(car), parameter_vector(car)
    named = nominal_std if isinstance(nominal_std, Mapping) else {}
    free = [free_masses] if isinstance(free_masses, str) else list(free_masses)
    # A mass that is known to a standard deviation is an unknown with a measured value.
    held = _held(car, every, fixed, [*free, *(name for name in named if name in every[2 * len(car.struts) :])])
    for name in named:
        if _index(every, name, "nominal_std") in held:
            raise InputError(f"nominal_std: {name!r} is held, so it needs no spread; leave out one of the two")
    group = list(range(len(every)))
    for tie in ties:
        members = [_index(every, name, "ties") for name in ([tie] if isinstance(tie, str) else tie)]
        kinds = {every[i].rpartition(".")[2] for i in members}
        if len(members) < 2 or len(kinds) > 1:
            raise InputError(f"ties: {tuple(tie)!r} must be at least two parameters of one kind")
        joined = {group[i] for i in members}
        group = [min(joined) if g in joined else g for g in group]
    base = p.copy()
    for g in set(group):
        members = [i for i, other in enumerate(group) if other == g]
        stuck = [i for i in members if i in held]
        if stuck and len(members) > 1:
            if np.ptp(p[stuck]) > 1e-12 * np.max(np.abs(p[stuck])):
                raise InputError(f"ties: {', '.join(every[i] for i in stuck)} are held at different values")
            base[members] = p[stuck[0]]
            held |= set(members)
    rows = [i for i in range(len(every)) if i not in held]
    if not rows:
        raise InputError("fixed holds every parameter; there is nothing to find")
    first = sorted({group[i] for i in rows})
    column = [first.index(group[i]) for i in rows]
    members_of = [[r for r, c in zip(rows, column, strict=True) if c == i] for i in range(len(first))]
    struts, stiffest = len(car.struts), float(np.max(p[: len(car.struts)], initial=0.0)) or 1.0
    scale, nominal = np.empty(len(first)), np.empty(len(first))
    for i, members in enumerate(members_of):
        value = float(np.mean(p[members]))
        if struts <= members[0] < 2 * struts:
            springs = p[[m - struts for m in members]]
            scale[i] = float(np.mean(np.where(springs > 0, springs, stiffest))) / rate
        else:
            scale[i] = value
        nominal[i] = value / scale[i]
    base[rows] = 0.0
    spread = np.zeros((len(every), len(first)))
    spread[rows, column] = scale[column]
    positive = np.array([not struts <= members[0] < 2 * struts for members in members_of])
    lower, upper = np.where(positive, LEAST, 0.0), np.full(len(first), np.inf)
    for name, ends in (bounds or {}).items():
        at = _index(every, name, "bounds")
        if at not in rows:
            raise InputError(f"bounds: {name!r} is held, so it needs no bounds; leave out one of the two")
        i = column[rows.index(at)]
        low, high = _ends(name, ends)
        lower[i], upper[i] = max(lower[i], low / scale[i]), min(upper[i], high / scale[i])
        if not lower[i] < upper[i]:
            raise InputError(f"bounds: nothing is left for {name!r} between {lower[i] * scale[i]:g} and {high:g}")
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


def _held(car: Suspension, every: Sequence[str], fixed: Sequence[str], free_masses: Sequence[str]) -> set[int]:
    """Return which parameters are not asked for: held, masses that are known, and springs that are none."""
    struts, free = [s.name for s in car.struts], set()
    for name in [free_masses] if isinstance(free_masses, str) else free_masses:
        mass = name if name in every else f"{name}.mass"
        if mass not in every[2 * len(struts) :]:
            raise InputError(f"free_masses: there is no mass {name!r}.{nearest_names(name, car.coordinates)}")
        free.add(every.index(mass))
    held = {i for i, s in enumerate(car.struts) if s.stiffness == 0}
    held |= {i for i in range(2 * len(struts), len(every)) if i not in free}
    for name in [fixed] if isinstance(fixed, str) else fixed:
        if name not in every and name not in struts:
            raise InputError(f"fixed: there is no strut parameter {name!r}.{nearest_names(name, [*every, *struts])}")
        if name in every and every.index(name) in free:
            raise InputError(f"{name!r} stands in both fixed and free_masses; leave out one of the two")
        held |= {every.index(name)} if name in every else {every.index(f"{name}.{q}") for q in QUANTITIES}
    return held


def _index(every: Sequence[str], name: str, argument: str) -> int:
    if name not in every:
        raise InputError(f"{argument}: there is no parameter {name!r}.{nearest_names(str(name), every)}")
    return every.index(name)


def _ends(name: str, ends: tuple[float | None, float | None]) -> tuple[float, float]:
    if not isinstance(ends, Sequence) or isinstance(ends, str) or len(ends) != 2:
        raise InputError(f"bounds: {name!r} has {ends!r}; give (low, high), with None for no bound")
    low, high = (-np.inf if ends[0] is None else float(ends[0])), (np.inf if ends[1] is None else float(ends[1]))
    if not low < high:
        raise InputError(f"bounds: {name!r} has low = {low:g} and high = {high:g}; low must be below high")
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
            raise InputError(f"nominal_std: {empty[0]!r} is 0, and no share of it is a spread; use bounds or fixed")
    else:
        named = {i: float(given) for i in rows if p[i] > 0}
    for i, value in named.items():
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"nominal_std: {every[i]!r} has {value}; it must be positive, as 0.3 for 30 %")
    return [named.get(i) for i in rows]
