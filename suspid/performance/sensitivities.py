"""Sensitivities of modes and figures to springs and dampers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.levels import ROUNDING
from suspid.model import Suspension, check_linear, statespace
from suspid.performance.bench import bench as bench_of
from suspid.performance.contact import wheels_of
from suspid.performance.figure_plan import plan_of
from suspid.performance.figures import check_exposure
from suspid.performance.grip import PLATFORM, SWEEP_TOP
from suspid.performance.larger_better import BENCH_FIGURES
from suspid.performance.ride import HOUR, driven_road
from suspid.performance.strut_slopes import strut_slopes
from suspid.performance.uncertain import Car, uncertain
from suspid.reconstruction import parameter_names, parameter_values
from suspid.results import Result
from suspid.simulation import Road
from suspid.text_tables import TERMINAL, figures_of, text_table
from suspid.units import ComplexArray, Metre, RealArray, Second
from suspid.values import check_parameters, frozen_real, listed, nearest_names


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Sensitivities(Result):
    """Relative change of modes and figures per relative change of parameters.

    Parameters
    ----------
    names : tuple of str
        Modes, as ``"mode 1.wn"`` and ``"mode 1.zeta"`` in ascending frequency, then figures of a `Ride`, then of wheels
        on a test bench ``"tire.adhesion"`` and ``"tire.phase"``.
    values : ndarray (name,)
        Their values.
    units : tuple of str
        Their units: SI, phases in rad.
    parameters : tuple of str
        The parameters.
    elasticity : ndarray (name, parameter)
        ``d ln value / d ln parameter``, exact: per cent for each per cent. NaN where a value is zero.

    Examples
    --------
    >>> from suspid import quarter_car, sensitivities
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = sensitivities(car)
    >>> found.names[0], found.parameters[0], round(float(found.elasticity[0, 0]), 2)
    ('mode 1.wn', 'chassis.stiffness', 0.45)
    """

    names: tuple[str, ...]
    values: RealArray
    units: tuple[str, ...]
    parameters: tuple[str, ...]
    elasticity: RealArray

    def _table(self) -> Mapping[str, Sequence[object]]:
        columns = dict(zip(self.parameters, self.elasticity.T.tolist(), strict=True))
        return {"name": self.names, "value": self.values.tolist(), "unit": self.units, **columns}

    def _brief(self) -> str:
        return f"{len(self.names)} figures by {len(self.parameters)} parameters: {listed(self.parameters)}"

    def __str__(self) -> str:
        columns = {
            "% for each %": list(self.names),
            "value": [figures_of(value) for value in self.values.tolist()],
            "unit": list(self.units),
        }
        for name, column in zip(self.parameters, self.elasticity.T, strict=True):
            columns[name] = [per_cent(one) for one in column.tolist()]
        return text_table(columns, widest=TERMINAL)


def per_cent(elasticity: float) -> str:
    """Return per cent for each per cent as text; nothing for what is not known.

    Examples
    --------
    >>> per_cent(0.447), per_cent(-0.004), per_cent(-12.345), per_cent(float("nan"))
    ('+0.45', '0.00', '-12.35', '')
    """
    if np.isnan(elasticity):
        return ""
    return f"{elasticity:+.2f}" if f"{abs(elasticity):.2f}" != "0.00" else "0.00"


@explained
def sensitivities(
    car: Car,
    *,
    parameters: Sequence[str] | None = None,
    road: Road | str | float | None = None,
    speed: float | None = None,
    duration: Second = HOUR,
    weightings: Mapping[str, str | Sequence[str]] | None = None,
    clearance: Mapping[str, Metre | tuple[Metre, Metre]] | None = None,
    bench: bool = False,
) -> Sensitivities:
    """Return which spring and which damper moves which mode, and on a road which figure of the ride.

    Parameters
    ----------
    car : Suspension, Estimate or Reconstruction
        The car, as described or as found.
    parameters : sequence of str, optional
        Parameters such as ``"chassis.damping"`` or ``"tire.mass"``. Default: every stiffness and damping that is not
        zero.
    road, speed, duration, weightings, clearance
        As in `ride`; without a road only modes are looked at.

    bench : bool
        Whether adhesion and least phase of the wheels on a test bench are looked at too, see `grip`.

    Returns
    -------
    Sensitivities
        ``.elasticity`` and, by ``str()``, a table of per cent for each per cent.

    Raises
    ------
    InputError
        If a parameter is unknown or zero, or `ride` would refuse the request.

    Notes
    -----
    The pole lambda of ``D(lambda) phi = 0``, with ``D = M lambda^2 + arms^T b(lambda) arms``, moves by
    ``-phi^T dD phi / (phi^T D' phi)``.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> print(sensitivities(car))
    % for each %   value   unit  chassis.stiffness  tire.stiffness  chassis.damping
    ------------  ------  -----  -----------------  --------------  ---------------
       mode 1.wn   7.606  rad/s              +0.45           +0.04            +0.02
     mode 1.zeta  0.2025      1              -0.65           +0.14            +1.01
       mode 2.wn   67.55  rad/s              +0.05           +0.46            -0.02
     mode 2.zeta  0.1971      1              -0.03           -0.48            +1.01
    """
    own = uncertain(car)
    about, relaxations = own.car, own.relaxations
    check_linear(about, "sensitivities")
    known = parameter_values(about)
    check_exposure(duration)
    if parameters is None:
        parameters = [name for name in parameter_names(about) if known[name] and not name.endswith(".mass")]
    check_parameters(parameters)
    if road is None and (speed is not None or weightings is not None or clearance is not None):
        raise InputError("speed, weightings and clearance need a road; without one only modes are computed")
    for name in parameters:
        if name not in known:
            raise InputError(f"there is no parameter {name!r}.{nearest_names(name, known)}")
        if not known[name]:
            raise InputError(f"parameter {name!r} is zero: it has no relative change")
    at = np.array([known[name] for name in parameters])
    poles, slopes = pole_slopes(about, parameters)
    names, values, units, rows = [], [], [], []
    for mode, (pole, slope) in enumerate(zip(poles, slopes, strict=True), 1):
        wn, by_wn = abs(pole), np.real(np.conj(pole) * slope) / abs(pole) ** 2 * at
        names += [f"mode {mode}.wn", f"mode {mode}.zeta"]
        values += [wn, -pole.real / wn]
        units += ["rad/s", "1"]
        with np.errstate(divide="ignore", invalid="ignore"):
            by_zeta = np.where(abs(pole.real) > ROUNDING * wn, np.real(slope) / pole.real * at - by_wn, np.nan)
        rows += [by_wn, by_zeta]
    if road is not None:
        plan = plan_of(
            about, driven_road(about, road, speed), duration=duration, weightings=weightings, clearance=clearance
        )
        figures, jacobian = plan.values(about, parameters=parameters, relaxations=relaxations)
        names += list(plan.formulas)
        units += [unit for unit, _, _ in plan.formulas.values()]
        values += figures.tolist()
        rows += list(_relative(figures, jacobian * at))
    if bench:
        tested = bench_of(wheels_of(about, relaxations), parameters, None, PLATFORM, SWEEP_TOP)
        names += [f"{wheel}.{figure}" for figure in BENCH_FIGURES for wheel in tested.wheels.names]
        units += [unit for unit, _ in BENCH_FIGURES.values() for _ in tested.wheels.names]
        count = len(tested.wheels.names)
        # A wheel that leaves the platform has no adhesion, as in `grip`.
        values += [*np.maximum(tested.figures[:count], 0.0).tolist(), *tested.figures[count:].tolist()]
        rows += list(_relative(tested.figures, tested.jacobian * at))
    return Sensitivities(
        names=tuple(names),
        values=frozen_real(values),
        units=tuple(units),
        parameters=tuple(parameters),
        elasticity=frozen_real(np.array(rows).reshape(len(names), len(parameters))),
    )


def _relative(figures: RealArray, slopes: RealArray) -> RealArray:
    """Return slopes over figures, (figure, parameter); NaN where a figure is zero, negative or missing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(figures[:, None] > 0, slopes / figures[:, None], np.nan)


def pole_slopes(car: Suspension, parameters: Sequence[str]) -> tuple[ComplexArray, ComplexArray]:
    """Return the poles on and above the real axis, ascending, and their derivatives, (pole, parameter)."""
    poles, vectors = np.linalg.eig(np.asarray(statespace(car).A, float))
    use = np.flatnonzero((poles.imag >= 0) & (np.abs(poles) > 0))
    use = use[np.argsort(np.abs(poles[use]))]
    arms, n = car.arms(car.coordinates), len(car.coordinates)
    s = np.asarray(poles[use], np.complex128)
    relaxation = np.array([strut.relaxation for strut in car.struts])
    c = np.array([strut.damping for strut in car.struts])
    _, changes = strut_slopes(car, relaxation, (), s, parameters)
    slopes = np.zeros((len(s), len(parameters)), np.complex128)
    for row, (pole, shape) in enumerate(zip(s, vectors[:n, use].T, strict=True)):
        stretched = (arms @ shape) ** 2
        turned = np.sum((2 * pole * np.diag(car.M)) * shape**2) + np.sum(c / (1 + relaxation * pole) ** 2 * stretched)
        for p, name in enumerate(parameters):
            change = changes[p]
            owner = name.rpartition(".")[0]
            if change is not None:
                slopes[row, p] = -change[1][row] * stretched[change[0]] / turned
            elif owner in car.coordinates:
                slopes[row, p] = -(pole**2) * shape[car.coordinates.index(owner)] ** 2 / turned
    return s, slopes
