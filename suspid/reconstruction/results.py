"""The result of a reconstruction: springs, dampers and masses with their uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import InputError
from suspid.levels import LEVEL, beyond_chance, check_level, normal_reach
from suspid.model import Suspension
from suspid.reconstruction.unknowns import QUANTITIES, parameter_values, unit_of
from suspid.reconstruction.verdict import verdict_of
from suspid.results import Result
from suspid.text_tables import TERMINAL, rounded, spread, text_table
from suspid.units import Kilogram, NewtonPerMetre, NewtonSecondPerMetre, Ratio, RealArray
from suspid.values import numbers_in_words
from suspid.words import (
    Remark,
    Verdict,
)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Reconstruction(Result):
    """The suspension that has the given modes, its uncertainty, and the others that have these modes too.

    Parameters
    ----------
    suspension : Suspension
        Springs and dampers (and masses) found: of those that have the modes equally well, the one nearest to nominal.
    stiffness_std, damping_std : mapping of str to float, or None
        Standard deviations [N/m], [N s/m] by strut, to first order from the covariance of the modes; 0 for fixed
        parameters; for parameters at a bound, as if there were no bound. None if the modes carry no covariance.
    mass_std : mapping of str to float, or None
        The same [kg] by coordinate.
    alternatives : tuple of Suspension
        Every other suspension found that has the modes within their uncertainty, by distance from nominal.
    distances : tuple of float
        Misfit of each alternative: its chi-square; for modes without covariance, its largest relative pole error
        [1].
    told_apart : tuple of str
        What would distinguish each alternative from `suspension`.
    residual : float
        Distance of a pole of `suspension` from the given one, relative to the latter; the worst mode [1].
    remarks : tuple of Remark
        How it was found, and what to know about it, as codes with numbers; `status` is the same as one text.
    held : tuple of str
        The strut parameters fixed at their nominal values, such as ``"tire.damping"``.
    parameters : tuple of str
        The parameters found, such as ``"tire.stiffness"`` or ``"seat.mass"``.
    covariance : ndarray (parameter, parameter), or None
        Joint covariance of `parameters`, in their units squared.
    ranges : ndarray (parameter, 2)
        Bounds of `parameters`, in their units.
    chi_square : float or None
        Squared distance from the data in standard deviations; None if the modes carry no covariance.
    freedom : int
        Degrees of freedom: equations less unknowns.
    explains : bool
        Whether the topology explains the modes: chi-square is not improbably large. If it is, the standard
        deviations are widened by its root over `freedom`, and are a guess; `status` names the gains and masses that
        would explain the modes, or where the misfit sits. Without a covariance: whether the root mean square of what
        the fit leaves of the poles, relative, and of a tenth of the shapes is within the tolerance.
    searched : bool
        Whether alternatives were looked for.
    nominal : Suspension or None
        The suspension that was given.

    Examples
    --------
    >>> from suspid import ModalSet, eigenmodes, quarter_car, reconstruct
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> exact = eigenmodes(car)
    >>> modes = ModalSet.from_wn_zeta(exact.wn, exact.zeta, wn_std=1e-3 * exact.wn, zeta_std=1e-2 * exact.zeta)
    >>> found = reconstruct(modes, car, fixed=["tire.damping"])
    >>> found.explains, round(found.suspension.struts[0].stiffness, -1)
    (True, 20000.0)
    >>> low, high = found.interval(0.95)["chassis.damping"]
    >>> bool(low < 1500 < high)
    True
    """

    suspension: Suspension
    stiffness_std: Mapping[str, NewtonPerMetre] | None
    damping_std: Mapping[str, NewtonSecondPerMetre] | None
    mass_std: Mapping[str, Kilogram] | None = None
    alternatives: tuple[Suspension, ...] = ()
    distances: tuple[float, ...] = ()
    told_apart: tuple[str, ...] = ()
    residual: Ratio
    remarks: tuple[Remark, ...] = ()
    held: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    covariance: RealArray | None = None
    ranges: RealArray
    chi_square: float | None = None
    freedom: int = 0
    explains: bool = True
    searched: bool = True
    nominal: Suspension | None = None

    @property
    def status(self) -> str:
        """How it was found, and what to know about it, as one text.

        Examples
        --------
        >>> from suspid import ModalSet, eigenmodes, quarter_car, reconstruct
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> exact = eigenmodes(car)
        >>> modes = ModalSet.from_wn_zeta(exact.wn, exact.zeta)
        >>> found = reconstruct(modes, car, fixed=["tire.damping"])
        >>> print(found.status)
        sequence of convex fits of poles; largest relative pole error ...e-1...
        """
        return "; ".join(str(remark) for remark in self.remarks)

    @property
    def verdict(self) -> Verdict:
        """How far the springs and dampers can be trusted, and why.

        Examples
        --------
        >>> from suspid import ModalSet, eigenmodes, quarter_car, reconstruct
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> exact = eigenmodes(car)
        >>> modes = ModalSet.from_wn_zeta(exact.wn, exact.zeta)
        >>> found = reconstruct(modes, car, fixed=["tire.damping"])
        >>> print(found.verdict)
        Verdict: 3 parameters of the car found: sound. Every check that could be made was passed.
        note: The modes state no uncertainty, so springs and dampers have no intervals.
        """
        return verdict_of(self)

    def interval(self, level: Ratio = LEVEL) -> dict[str, tuple[float, float]]:
        """Return the ends between which each of `parameters` lies with probability ``level``, cut at its bounds.

        They belong to `suspension`: an alternative has its own.

        Raises
        ------
        InputError
            If the modes carried no covariance, or the level is not between 0 and 1.

        Examples
        --------
        >>> from suspid import ModalSet, eigenmodes, quarter_car, reconstruct
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> modes = eigenmodes(car)
        >>> std = {"wn_std": 0.001 * modes.wn, "zeta_std": 0.01 * modes.zeta}
        >>> found = reconstruct(ModalSet.from_wn_zeta(modes.wn, modes.zeta, **std), car)
        >>> low, high = found.interval(0.95)["chassis.stiffness"]
        >>> low < 20e3 < high
        True
        """
        check_level(level)
        if self.covariance is None:
            raise InputError("the modes carried no covariance, so the parameters have none; identify gives one")
        every = parameter_values(self.suspension)
        reach = normal_reach(level) * np.sqrt(np.diag(self.covariance))
        values = np.array([every[name] for name in self.parameters])
        ends = np.clip(values[:, None] + reach[:, None] * [-1, 1], self.ranges[:, :1], self.ranges[:, 1:])
        return {name: (float(low), float(high)) for name, (low, high) in zip(self.parameters, ends, strict=True)}

    def beyond_chance(self, level: Ratio = LEVEL) -> frozenset[str]:
        """Return which parameters differ from nominal: none of them by chance, with probability ``level``.

        Raises
        ------
        InputError
            If the modes carried no covariance, or the level is not between 0 and 1.

        Examples
        --------
        >>> from suspid import ModalSet, eigenmodes, quarter_car, reconstruct
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> modes = eigenmodes(car)
        >>> std = {"wn_std": 0.001 * modes.wn, "zeta_std": 0.01 * modes.zeta}
        >>> found = reconstruct(ModalSet.from_wn_zeta(modes.wn, modes.zeta, **std), car)
        >>> sorted(found.beyond_chance())
        []
        """
        if self.nominal is None:
            return frozenset()
        old = parameter_values(self.nominal)

        def outside(level: Ratio) -> list[str]:
            return [name for name, (low, high) in self.interval(level).items() if not low <= old[name] <= high]

        return beyond_chance(outside, len(self.parameters), level)

    def _table(self) -> Mapping[str, Sequence[object]]:
        values = parameter_values(self.suspension)
        columns: dict[str, Sequence[object]] = {
            "parameter": self.parameters,
            "value": [values[name] for name in self.parameters],
            "unit": [unit_of(name) for name in self.parameters],
        }
        if self.covariance is not None:
            ends = self.interval()
            columns |= {
                "std": np.sqrt(np.diag(self.covariance)).tolist(),
                "lower": [ends[name][0] for name in self.parameters],
                "upper": [ends[name][1] for name in self.parameters],
            }
        if self.nominal is not None:
            nominal = parameter_values(self.nominal)
            columns["nominal"] = [nominal[name] for name in self.parameters]
        return columns

    def _brief(self) -> str:
        values, units = parameter_values(self.suspension), [unit_of(name) for name in self.parameters]
        return numbers_in_words(self.parameters, [values[name] for name in self.parameters], units)

    def __str__(self) -> str:
        return f"{tables_of_reconstruction(self)}\n{self.verdict}"


def tables_of_reconstruction(found: Reconstruction) -> str:
    """Return springs and dampers, how they were found, and the other suspensions with these modes."""
    struts = found.suspension.struts
    columns: dict[str, Sequence[str]] = {"strut": [s.name for s in struts]}
    for quantity, unit, stds in (("stiffness", "N/m", found.stiffness_std), ("damping", "N s/m", found.damping_std)):
        values = np.array([getattr(s, quantity) for s in struts])
        columns |= _with_spread(f"{quantity} [{unit}]", f"± [{unit}]", values, stds, [s.name for s in struts])
    if any(not name.endswith(".mass") for name in found.held):
        names = {s.name: [q for q in QUANTITIES if f"{s.name}.{q}" in found.held] for s in struts}
        columns["held"] = [", ".join(held) for held in names.values()]
    parts = [text_table(columns, widest=TERMINAL)]
    free = [name for name in found.suspension.masses if f"{name}.mass" in found.parameters]
    if free:
        values = np.array([found.suspension.masses[name] for name in free])
        parts.append(text_table({"mass": free} | _with_spread("[kg]", "± [kg]", values, found.mass_std, free)))
    parts.append(found.status)
    for i, (car, distance) in enumerate(zip(found.alternatives, found.distances, strict=True)):
        k, c = (", ".join(f"{getattr(s, q):.5g}" for s in car.struts) for q in QUANTITIES)
        far = (
            f"largest pole error {distance:.1e}"
            if found.chi_square is None
            else f"chi-square {distance if distance > 1e-6 else 0:.3g}"
        )
        apart = f"; distinguished by {found.told_apart[i]}" if found.told_apart[i] else ""
        parts.append(f"another suspension has these modes: k = {k} N/m, c = {c} N s/m ({far}){apart}")
    return "\n".join(parts)


def _with_spread(
    title: str, spread_title: str, values: RealArray, stds: Mapping[str, float] | None, names: Sequence[str]
) -> dict[str, Sequence[str]]:
    """Return a column of values, and one of their standard deviations if there are any."""
    if stds is None:
        return {title: [f"{value:.7g}" for value in values]}
    known = np.array([stds[name] for name in names])
    # Columns need names of their own: the unit tells them apart.
    return {title: rounded(values, known), spread_title: [spread(std) for std in known]}
