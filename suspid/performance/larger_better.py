"""Adhesion and least phase in a tuning: figures of a test bench that are maximised or have lower limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.performance.bench import least_figures
from suspid.performance.contact import wheels_of
from suspid.performance.grip import PLATFORM, SWEEP_TOP, check_sweep
from suspid.units import RealArray
from suspid.values import nearest_names
from suspid.wording import Argument

# Units of the figures of a bench, and values that none reaches: a wheel that the platform does not move presses as at
# rest, and the phase of a force without a source of energy lies below a half turn.
BENCH_FIGURES: Mapping[str, tuple[str, float]] = {"adhesion": ("1", 1.0), "phase": ("rad", np.pi)}


def kind_of(name: str) -> str:
    """Return which figure of a bench a name means; empty of others.

    Examples
    --------
    >>> kind_of("tire.phase"), kind_of("tire.load")
    ('phase', '')
    """
    kind = name.rpartition(".")[2]
    return kind if kind in BENCH_FIGURES else ""


def bench_rows(car: Suspension, names: Sequence[str]) -> list[int]:
    """Return the place of figures among those of `least_figures`.

    Raises
    ------
    InputError
        If the car has no such wheel, or the sweep does not pass its resonance.
    """
    if not names:
        return []
    wheels = wheels_of(car)
    known = [f"{wheel}.{kind}" for kind in BENCH_FIGURES for wheel in wheels.names]
    for name in names:
        if name not in known:
            hint = "; ask for one wheel, and limit the others" if "+" in name else nearest_names(name, known)
            raise InputError(f"there is no figure {name!r}.{hint}" if "+" not in name else f"{name!r}{hint}")
    check_sweep(wheels, SWEEP_TOP)
    return [known.index(name) for name in names]


def bench_values(car: Suspension, parameters: Sequence[str], rows: Sequence[int]) -> tuple[RealArray, RealArray]:
    """Return figures of the bench and their derivatives, (figure,) and (figure, parameter)."""
    _, figures, slopes = least_figures(wheels_of(car), parameters, None, PLATFORM, SWEEP_TOP)
    return figures[list(rows)], slopes[list(rows)]


def small(names: Sequence[str], values: RealArray) -> tuple[RealArray, RealArray]:
    """Return what is positive and small where figures are good, (…, figure), and its derivative by the figure.

    Of adhesion it is the swing of the load over the static one, of the phase its inverse, else the figure itself.

    Examples
    --------
    >>> small(["tire.adhesion", "tire.phase", "tire.load"], np.array([0.6, 0.5, 900.0]))[0].tolist()
    [0.4, 2.0, 900.0]
    """
    made, slopes = np.array(values, float), np.ones(np.shape(values))
    for i, name in enumerate(names):
        if kind_of(name) == "adhesion":
            made[..., i], slopes[..., i] = 1 - values[..., i], -1.0
        elif kind_of(name) == "phase":
            made[..., i], slopes[..., i] = 1 / values[..., i], -1 / values[..., i] ** 2
    return made, slopes


def shown(names: Sequence[str], values: RealArray) -> RealArray:
    """Return figures as `grip` states them: the adhesion of a wheel that leaves the platform is zero."""
    off = np.array([kind_of(name) == "adhesion" for name in names])
    return np.where(off, np.maximum(values, 0.0), values)


def check_least(limits: Mapping[str, float]) -> None:
    """Refuse a least adhesion or phase that no car reaches.

    Examples
    --------
    >>> check_least({"tire.phase": 35.0})
    Traceback (most recent call last):
    suspid.errors.InputError: constraints: tire.phase >= 35 rad exceeds all cars, below 3.14; 35 deg are 0.611
    """
    for name, limit in limits.items():
        kind = kind_of(name)
        if kind and limit >= BENCH_FIGURES[kind][1]:
            unit, most = BENCH_FIGURES[kind]
            hint = f"{limit:g} % are {limit / 100:.3g}" if kind == "adhesion" else (
                f"{limit:g} deg are {np.radians(limit):.3g}"
            )  # fmt: skip
            raise InputError(
                Argument("constraints"),
                f": {name} >= {limit:g} {unit} exceeds all cars, below {most:.3g}; {hint}",
            )


def limit_in_words(name: str, limit: float) -> str:
    """Return a limit as text.

    Examples
    --------
    >>> limit_in_words("tire.phase", 0.611), limit_in_words("chassis.travel", 0.02)
    ('tire.phase >= 0.611', 'chassis.travel <= 0.02')
    """
    return f"{name} {'>=' if kind_of(name) else '<='} {limit:g}"
