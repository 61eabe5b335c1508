"""A test bench: contact forces of all wheels of a car over the sweep, their least values and derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np

from suspid.errors import InputError
from suspid.model import positive_number, state_matrix
from suspid.performance.contact import Wheels, check_carried, contact, contact_by_hertz, resonance_slopes, static_loads
from suspid.units import ComplexArray, Hertz, Metre, Newton, RealArray
from suspid.values import nearest_names
from suspid.wording import Argument

GRID: Hertz = 0.05  # of the curves; a least value is refined between its neighbours
# Places about a resonance that is narrower than the grid, in units of its half width: a valley between two of them is
# followed to its bottom.
ABOUT = np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
# Values of all wheels at frequencies, (wheel, frequency), and derivatives by parameters, (parameter, …).
Values: TypeAlias = tuple[RealArray, RealArray]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Bench:
    """Curves of all wheels and their least values: of the contact force over the static one, then of the phase."""

    wheels: Wheels
    load: RealArray  # (wheel,)
    ends: RealArray  # (wheel, 2), between which the least phase is looked for
    hertz: RealArray  # (frequency,)
    least: RealArray  # (wheel, frequency)
    phase: RealArray
    least_slopes: RealArray  # (parameter, wheel, frequency)
    phase_slopes: RealArray
    at: RealArray  # (figure,), where they are met
    figures: RealArray  # (figure,)
    jacobian: RealArray  # (figure, parameter)


def bench(
    wheels: Wheels,
    parameters: Sequence[str],
    loads: Mapping[str, Newton] | None,
    amplitude: Metre,
    highest: Hertz,
) -> Bench:
    """Return what a bench finds of a car."""
    load, load_slopes = _loads(wheels, parameters, loads)
    hertz = _sweep(wheels, highest)
    curves = _Curves(wheels=wheels, load=load, load_slopes=load_slopes, amplitude=amplitude)
    (least, least_slopes), (phase, phase_slopes) = curves.both(hertz, parameters)
    at, figures, jacobian = _least_figures(curves, parameters, hertz, least, phase)
    return Bench(
        wheels=wheels,
        load=load,
        ends=_ends(wheels),
        hertz=hertz,
        least=least,
        phase=phase,
        least_slopes=least_slopes,
        phase_slopes=phase_slopes,
        at=at,
        figures=figures,
        jacobian=jacobian,
    )


def least_figures(
    wheels: Wheels,
    parameters: Sequence[str],
    loads: Mapping[str, Newton] | None,
    amplitude: Metre,
    highest: Hertz,
) -> tuple[RealArray, RealArray, RealArray]:
    """Return where each figure of `Bench` is met, the figures, and their derivatives, (figure, parameter).

    A least value over frequencies moves with a parameter as the curve does at the frequency where it is met.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> from suspid.performance.contact import wheels_of
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=650, tire_damping=60)
    >>> at, figures, _ = least_figures(wheels_of(car), ["chassis.damping"], None, 0.003, 25.0)
    >>> at.round(1).tolist(), figures.round(3).tolist()
    ([11.0, 1.8], [0.296, 0.627])
    """
    load, load_slopes = _loads(wheels, parameters, loads)
    hertz = _sweep(wheels, highest)
    curves = _Curves(wheels=wheels, load=load, load_slopes=load_slopes, amplitude=amplitude)
    (least, _), (phase, _) = curves.both(hertz)
    return _least_figures(curves, parameters, hertz, least, phase)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Curves:
    """The curves of a bench at any frequencies, with derivatives by parameters."""

    wheels: Wheels
    load: RealArray
    load_slopes: RealArray
    amplitude: Metre

    def both(self, f: RealArray, by: Sequence[str] = ()) -> tuple[Values, Values]:
        """Return adhesion and phase."""
        G, slopes = contact(self.wheels, f, by)
        return _adhesion(G, slopes, self.load, self.load_slopes[: len(by)], self.amplitude), _phase(G, slopes)

    def adhesion(self, f: RealArray, by: Sequence[str] = ()) -> Values:
        """Return least over static contact force."""
        return self.both(f, by)[0]

    def phase(self, f: RealArray, by: Sequence[str] = ()) -> Values:
        """Return the phase of the contact force [rad]."""
        return self.both(f, by)[1]


def _least_figures(
    curves: _Curves, parameters: Sequence[str], hertz: RealArray, least: RealArray, phase: RealArray
) -> tuple[RealArray, RealArray, RealArray]:
    """Return what `least_figures` does, from the curves over the sweep."""
    wheels = curves.wheels
    ends, everywhere = _ends(wheels), np.array([0.0, hertz[-1]])
    by_body, by_wheel = resonance_slopes(wheels, parameters)
    found = [_least_of(curves.adhesion, hertz, least[i], everywhere, i, parameters) for i in range(len(ends))]
    for i in range(len(ends)):
        inner = _least_of(curves.phase, hertz, phase[i], ends[i], i, parameters, inside=True)
        found.append(_least_phase(wheels, inner, ends[i], i, parameters, (by_body, by_wheel[:, i])))
    return (
        np.array([one for one, _, _ in found]),
        np.array([one for _, one, _ in found]),
        np.array([one for _, _, one in found]).reshape(len(found), len(parameters)),
    )


def _ends(wheels: Wheels) -> RealArray:
    """Return the frequencies between which the least phase of each wheel is looked for, (wheel, 2)."""
    low, high = wheels.resonances()
    return np.column_stack([np.full(len(high), low), high])


def _sweep(wheels: Wheels, highest: Hertz) -> RealArray:
    """Return the frequencies of the curves: evenly spaced, and closer at resonances that are narrower than that."""
    even = np.arange(1, int(np.ceil(highest / GRID)) + 1) * (highest / np.ceil(highest / GRID))
    poles = np.linalg.eigvals(state_matrix(wheels.car)) / (2 * np.pi)
    sharp = poles[(poles.imag > 0) & (-poles.real < GRID)]
    about = np.abs(sharp)[:, None] + np.abs(sharp.real)[:, None] * ABOUT
    return np.unique(np.concatenate([even, about[(about > 0) & (about <= highest)]]))


def check_loads(given: object, wheels: Sequence[str]) -> None:
    """Refuse loads that are none of the wheels.

    Raises
    ------
    InputError
        If a wheel is unknown, or a load is no positive number.
    """
    if given is None:
        return
    if not isinstance(given, Mapping):
        raise InputError(Argument("loads", repr(given)), " must map wheels to forces [N], as in {'tire': 3500.0}")
    for name, value in given.items():
        if name not in wheels:
            raise InputError(Argument("loads"), f": there is no wheel {name!r}.{nearest_names(str(name), wheels)}")
        positive_number(f"load of {name!r}", value, "N")


def _loads(
    wheels: Wheels, parameters: Sequence[str], given: Mapping[str, Newton] | None
) -> tuple[RealArray, RealArray]:
    """Return static contact forces and their derivatives; those that were weighed have none."""
    if given and set(given) == set(wheels.names):
        return np.array([given[name] for name in wheels.names], float), np.zeros((len(parameters), len(given)))
    load, slopes = static_loads(wheels, parameters)
    for i, name in enumerate(wheels.names):
        if name in (given or {}):
            load[i], slopes[:, i] = (given or {})[name], 0.0
        check_carried(name, load[i])
    return load, slopes


def _adhesion(
    G: ComplexArray, slopes: ComplexArray, load: RealArray, load_slopes: RealArray, amplitude: Metre
) -> tuple[RealArray, RealArray]:
    """Return least over static contact force, (wheel, frequency), and its derivatives, (parameter, …)."""
    size = np.abs(G)
    share = amplitude * size / load[:, None]
    by_force = np.real(np.conj(G) * slopes) / size**2
    return 1 - share, -share * (by_force - (load_slopes / load)[:, :, None])


def _phase(G: ComplexArray, slopes: ComplexArray) -> tuple[RealArray, RealArray]:
    """Return the phase of the contact force [rad], (wheel, frequency), and its derivatives, (parameter, …).

    A car without a source of energy has phases between 0 and pi.
    """
    return np.angle(G), np.imag(slopes / G)


def _least_phase(
    wheels: Wheels,
    inner: tuple[Hertz, float, RealArray],
    ends: RealArray,
    wheel: int,
    parameters: Sequence[str],
    end_slopes: tuple[RealArray, RealArray],
) -> tuple[Hertz, float, RealArray]:
    """Return the least phase between two resonances, at a local minimum or at one of them, which parameters move."""
    best = inner
    for end, by_parameter in zip(ends.tolist(), end_slopes, strict=True):
        G, slopes = contact(wheels, np.array([end]), parameters)
        value, held = _phase(G, slopes)
        if not best[1] <= value[wheel, 0]:
            along = float(np.imag(contact_by_hertz(wheels, end)[wheel] / G[wheel, 0]))
            best = end, float(value[wheel, 0]), held[:, wheel, 0] + along * by_parameter
    return best


class Curve(Protocol):
    """Values of all wheels at frequencies, (wheel, frequency), and derivatives by parameters, (parameter, …)."""

    def __call__(self, f: RealArray, by: Sequence[str] = ()) -> tuple[RealArray, RealArray]:
        """Return both."""


def _least_of(
    curve: Curve,
    hertz: RealArray,
    values: RealArray,
    ends: RealArray,
    wheel: int,
    parameters: Sequence[str],
    *,
    inside: bool = False,
) -> tuple[Hertz, float, RealArray]:
    """Return where a curve is least between two frequencies, its value there and derivatives; NaN if it has no such.

    With ``inside`` only local minima count.
    """
    from scipy.optimize import minimize_scalar

    padded = np.concatenate([[np.inf], values, [np.inf]])
    valley = (values <= padded[:-2]) & (values <= padded[2:]) & (hertz > ends[0]) & (hertz < ends[1] * (1 + 1e-12))
    valley[-1] &= not inside
    valley[0] &= not inside
    if not np.any(valley):
        return np.nan, np.nan, np.full(len(parameters), np.nan)
    best = int(np.argmin(np.where(valley, values, np.inf)))
    around = float(hertz[max(best - 1, 0)]), float(hertz[min(best + 1, len(hertz) - 1)])
    found = minimize_scalar(
        lambda f: float(curve(np.array([f]))[0][wheel, 0]), bounds=around, method="bounded", options={"xatol": 1e-7}
    )
    at = float(found.x) if found.fun <= values[best] else float(hertz[best])
    value, slopes = curve(np.array([at]), parameters)
    return at, float(value[wheel, 0]), slopes[:, wheel, 0]
