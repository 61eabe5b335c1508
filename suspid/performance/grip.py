"""Grip of the wheels of a car on a test bench."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from suspid.errors import InputError
from suspid.levels import LEVEL
from suspid.model import check_linear
from suspid.performance.contact import Wheels, contact, static_loads, wheels_of
from suspid.performance.grips import PHASE_LIMIT, Grip
from suspid.performance.reaches import spreads
from suspid.performance.uncertain import Car, Uncertain, uncertain
from suspid.units import ComplexArray, Hertz, Metre, Newton, Ratio, RealArray
from suspid.values import frozen_real, nearest_names, within_numbers
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.grip import GripCheck, GripHeadline

PLATFORM: Metre = 0.003  # EUSAMA: a stroke of 6 mm
SWEEP_TOP: Hertz = 25.0  # where it begins
MOST_TOP: Hertz = 1000.0  # no car description holds that far
GRID: Hertz = 0.05  # of the curves; a least value is refined between its neighbours


def grip(
    car: Car,
    *,
    amplitude: Metre = PLATFORM,
    highest: Hertz = SWEEP_TOP,
    loads: Mapping[str, Newton] | None = None,
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
) -> Grip:
    """Return the grip of each wheel on a test bench: adhesion after EUSAMA and least phase after EGEA SPECSUS2018.

    A platform moves one wheel up and down, from a high frequency to zero, while the others stand still. The adhesion
    is the least contact force over the static one; the least phase is that of the contact force against the platform
    between the resonances of the body and of the wheel.

    Parameters
    ----------
    car : Suspension, Estimate or Reconstruction
        A car as described, or as estimated: the figures then have the uncertainty of its parameters, with the mounts
        as estimated. A wheel is a coordinate that a strut holds to a road.
    amplitude : float
        Amplitude of the platform [m]; only the adhesion depends on it.
    highest : float
        Where the sweep begins [Hz].
    loads : mapping of str to float, optional
        Static contact forces that were weighed, by wheel [N]. Default: by the masses and springs of the car, each
        spring unstressed at one height; of a quarter and a half car the springs do not matter.
    nominal_std : float, or mapping of str to float, optional
        Relative standard deviation of parameters that were not estimated [1], independent of all others. A number holds
        for springs and dampers; masses are named, as in ``{"tire.stiffness": 0.05, "chassis.mass": 0.02}``. Default:
        they are taken as known, and the verdict names them.

    Returns
    -------
    Grip
        Figures, curves, intervals; ``str()`` is the table.

    Raises
    ------
    InputError
        If an argument is of the wrong type, a name is unknown, the car has no wheel on a road, its springs do not hold
        it, or a strut has friction or a curve.

    Notes
    -----
    Intervals are to first order with exact derivatives: those of the curves at the frequency of the least value, which
    itself does not matter to first order. They hold no car with a negative spring, damper or relaxation of a mount. The
    least phase is the lowest of the local minima between
    the lowest natural frequency of the car and that of the wheel under a body held still, both undamped. With strong
    dampers there is none; the phase then falls steadily.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=650, tire_damping=60)
    >>> print(grip(car))
      wheel    load [N]    adhesion [%]    class    at [Hz]    least phase [deg]    at [Hz]
    -------  ----------  --------------  -------  ---------  -------------------  ----------
       tire        3923            29.6     fair       11.0                 35.9        1.80
    Verdict: grip of tire: sound. Every check that could be made was passed.
    note: Taken as known, without any error in the intervals: all springs, dampers and masses.
    """
    with within_numbers():
        about = uncertain(car, nominal_std)
        _check(amplitude, highest, loads)
        check_linear(about.car, "grip")
        wheels = wheels_of(about.car, about.relaxations)
        load, load_slopes = _loads(wheels, about.parameters, loads)
        hertz = np.arange(1, int(np.ceil(highest / GRID)) + 1) * (highest / np.ceil(highest / GRID))

        def least_at(f: RealArray) -> tuple[RealArray, RealArray]:
            return _adhesion(*contact(wheels, f, about.parameters), load, load_slopes, amplitude)

        def phase_at(f: RealArray) -> tuple[RealArray, RealArray]:
            return _phase(*contact(wheels, f, about.parameters))

        low, high = wheels.resonances()
        ends = np.column_stack([np.full(len(high), low), high])
        (least, least_slopes), (phase, phase_slopes) = least_at(hertz), phase_at(hertz)
        everywhere = np.array([[0.0, highest]] * len(high))
        lowest = [_least_of(least_at, hertz, least[i], everywhere[i], i) for i in range(len(high))]
        turned = [_least_of(phase_at, hertz, phase[i], ends[i], i, inside=True) for i in range(len(high))]
        jacobian = np.array([slopes for _, _, slopes in (*lowest, *turned)])
        found = Grip(
            wheels=wheels.names,
            load=frozen_real(load),
            least=frozen_real([value for _, value, _ in lowest]),
            phase=frozen_real([value for _, value, _ in turned]),
            adhesion_hertz=frozen_real([f for f, _, _ in lowest]),
            phase_hertz=frozen_real([f for f, _, _ in turned]),
            hertz=frozen_real(hertz),
            adhesion_curve=frozen_real(least),
            phase_curve=frozen_real(phase),
            adhesion_band=frozen_real(_stds(least_slopes, about)),
            phase_band=frozen_real(_stds(phase_slopes, about)),
            resonances=frozen_real(ends),
            amplitude=float(amplitude),
            parameters=about.parameters,
            jacobian=frozen_real(jacobian.reshape(2 * len(high), len(about.parameters))),
            parameter_values=about.values,
            covariance=about.covariance,
            verdict=Verdict(Remark(GripHeadline.GRIP, {"names": wheels.names})),
        )
        return _judged(found, about)


def grip_if_any(car: Car, nominal_std: Ratio | Mapping[str, Ratio] | None = None) -> Grip | None:
    """Return the grip of a car; None of one that has no wheel on a road, or whose springs do not hold it."""
    uncertain(car, nominal_std)
    try:
        return grip(car, nominal_std=nominal_std)
    except InputError:
        return None


def _check(amplitude: object, highest: float, loads: object) -> None:
    if loads is not None and not isinstance(loads, Mapping):
        raise InputError(f"loads = {loads!r} must map wheels to forces [N], as in {{'tire': 3500.0}}")
    for name, value, unit in (("amplitude", amplitude, "m"), ("highest", highest, "Hz")):
        if not (isinstance(value, int | float | np.number) and np.isfinite(value) and value > 0):
            raise InputError(f"{name} = {value!r} must be a positive number of {unit}")
    if highest > MOST_TOP:
        raise InputError(
            f"highest = {highest:g} Hz is beyond {MOST_TOP:g} Hz; test benches sweep from {SWEEP_TOP:g} Hz"
        )


def _loads(
    wheels: Wheels, parameters: Sequence[str], given: Mapping[str, Newton] | None
) -> tuple[RealArray, RealArray]:
    """Return static contact forces and their derivatives; those that were weighed have none."""
    for name, value in (given or {}).items():
        if name not in wheels.names:
            raise InputError(f"loads: there is no wheel {name!r}.{nearest_names(name, wheels.names)}")
        if not (isinstance(value, int | float | np.number) and np.isfinite(value) and value > 0):
            raise InputError(f"loads: {name!r} = {value!r} must be a positive number of N")
    if given and set(given) == set(wheels.names):
        return np.array([given[name] for name in wheels.names], float), np.zeros((len(parameters), len(given)))
    load, slopes = static_loads(wheels, parameters)
    for i, name in enumerate(wheels.names):
        if name in (given or {}):
            load[i], slopes[:, i] = (given or {})[name], 0.0
        if load[i] <= 0:
            raise InputError(f"wheel {name!r} carries {load[i]:.0f} N: the car as described stands on fewer wheels")
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


def _least_of(
    curve: Callable[[RealArray], tuple[RealArray, RealArray]],
    hertz: RealArray,
    values: RealArray,
    ends: RealArray,
    wheel: int,
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
        return np.nan, np.nan, np.full(len(curve(hertz[:1])[1]), np.nan)
    best = int(np.argmin(np.where(valley, values, np.inf)))
    around = float(hertz[max(best - 1, 0)]), float(hertz[min(best + 1, len(hertz) - 1)])
    found = minimize_scalar(
        lambda f: float(curve(np.array([f]))[0][wheel, 0]), bounds=around, method="bounded", options={"xatol": 1e-7}
    )
    at = float(found.x) if found.fun <= values[best] else float(hertz[best])
    value, slopes = curve(np.array([at]))
    return at, float(value[wheel, 0]), slopes[:, wheel, 0]


def _stds(slopes: RealArray, about: Uncertain) -> RealArray:
    """Return the standard deviations of curves, (wheel, frequency)."""
    flat = slopes.reshape(len(slopes), slopes.shape[1] * slopes.shape[2])
    return spreads(flat, about.covariance, about.values).reshape(slopes.shape[1:])


def _judged(found: Grip, about: Uncertain) -> Grip:
    """Return the grip with its verdict."""
    checks = [*_against_limits(found)]
    if about.doubt is not None:
        checks.append(Check(Remark(GripCheck.UNTRUSTED, {"level": about.doubt.label}), about.doubt))
    if about.known:
        checks.append(Check(Remark(GripCheck.KNOWN, {"names": about.known}), Level.NOTE))
    return replace(found, verdict=Verdict(found.verdict.headline, tuple(checks)))


def _against_limits(found: Grip) -> Iterator[Check]:
    """Yield what the limit of the phase says of each wheel, and which wheels leave the platform."""
    ends, limit = found.interval(LEVEL), float(np.degrees(PHASE_LIMIT))
    for i, wheel in enumerate(found.wheels):
        phase = float(np.degrees(found.phase[i]))
        low, high = (float(np.degrees(end)) for end in ends[f"{wheel}.phase"])
        numbers: dict[str, Number] = {"wheel": wheel, "phase": phase, "low": low, "high": high, "limit": limit}
        if np.isnan(phase):
            yield Check(Remark(GripCheck.NO_LEAST, {"wheel": wheel}), Level.NOTE)
        elif low <= limit <= high and low < high:
            yield Check(Remark(GripCheck.NEAR, numbers), Level.CARE)
        else:
            passes = phase >= limit
            yield Check(
                Remark(GripCheck.PASSES if passes else GripCheck.FAILS, numbers), Level.SOUND if passes else Level.CARE
            )
        if found.least[i] <= 0:
            hertz = float(found.adhesion_hertz[i])
            yield Check(Remark(GripCheck.LIFTS, {"wheel": wheel, "hertz": hertz}), Level.NOTE)
