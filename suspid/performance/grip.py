"""Grip of the wheels of a car on a test bench."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.levels import LEVEL
from suspid.model import Suspension, check_linear, positive_number
from suspid.performance.bench import Bench, bench, check_loads
from suspid.performance.contact import Wheels, static_loads, wheels_of
from suspid.performance.grips import PHASE_LIMIT, Grip, class_of_adhesion
from suspid.performance.plausibility import plausible, plausible_loads
from suspid.performance.reaches import bends_of, spreads
from suspid.performance.uncertain import Car, Uncertain, uncertain
from suspid.units import Hertz, Metre, Newton, Ratio, RealArray, Second
from suspid.values import frozen_real, within_numbers
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.grip import GripCheck, GripHeadline

PLATFORM: Metre = 0.003  # EUSAMA: a stroke of 6 mm
# Smaller platforms move a tire within its noise, larger ones lift every wheel.
LEAST_AMPLITUDE, MOST_AMPLITUDE = 1e-4, 0.1
SWEEP_TOP: Hertz = 25.0  # where it begins
MOST_TOP: Hertz = 1000.0  # no car description holds that far


@explained
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
    itself does not matter to first order. They hold no car with a negative spring, damper or relaxation of a mount; by
    relaxations near zero they are to second order, and a mount that may be rigid is taken as rigid too. The least
    phase is "the lowest value of the phase shift determined during the test between the sprung and unsprung mass
    resonant frequencies" (EGEA SWG6, suspension tester specification, AICA, 14 November 2017, which became
    SPECSUS2018), here from the lowest natural frequency of the car to that of the wheel under a body held still, both
    undamped. It rises with the damper as long as it is met at a local minimum. With a strong damper it is met at the
    wheel's resonance, and falls as the damper gets stronger still: a seized one holds the body to the wheel. So the
    figure is continuous in the damper, but not monotone, and the verdict tells where it falls. The classes of EUSAMA
    and the limit of EGEA, 35 deg, are those that publications quote, not taken from the recommendations themselves.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=650, tire_damping=60)
    >>> print(grip(car))
    wheel  load [N]  adhesion [%]  class  at [Hz]  least phase [deg]  at [Hz]
    -----  --------  ------------  -----  -------  -----------------  -------
     tire      3923          29.6   fair     11.0               35.9     1.80
    Verdict: grip of tire: sound. Every check that could be made was passed.
    note: Taken as known, without any error in the intervals: all springs, dampers and masses.
    """
    with within_numbers():
        about = uncertain(car, nominal_std)
        _check(amplitude, highest)
        check_linear(about.car, "grip")
        check_loads(loads, wheels_of(about.car).names)
        check_sweep(wheels_of(about.car), highest)

        def tested(one: Suspension, relaxations: Mapping[str, Second]) -> Bench:
            return bench(wheels_of(one, relaxations), about.parameters, loads, amplitude, highest)

        own = tested(about.car, about.relaxations)
        bends = bends_of(about, len(own.figures), lambda one, relaxations: tested(one, relaxations).jacobian)
        count = len(own.wheels.names)
        found = Grip(
            wheels=own.wheels.names,
            load=frozen_real(own.load),
            least=frozen_real(own.figures[:count]),
            phase=frozen_real(own.figures[count:]),
            adhesion_hertz=frozen_real(own.at[:count]),
            phase_hertz=frozen_real(own.at[count:]),
            hertz=frozen_real(own.hertz),
            adhesion_curve=frozen_real(own.least),
            phase_curve=frozen_real(own.phase),
            adhesion_band=frozen_real(_stds(own.least_slopes, about)),
            phase_band=frozen_real(_stds(own.phase_slopes, about)),
            resonances=frozen_real(own.ends),
            amplitude=float(amplitude),
            parameters=about.parameters,
            parameter_values=about.values,
            covariance=about.covariance,
            jacobian=frozen_real(own.jacobian),
            bends=frozen_real(bends),
            verdict=Verdict(Remark(GripHeadline.GRIP, {"names": own.wheels.names})),
        )
        return _judged(found, about, loads or {})


def grip_if_any(car: Car, nominal_std: Ratio | Mapping[str, Ratio] | None = None) -> Grip | None:
    """Return the grip of a car; None of one that has no wheel on a road, or whose springs do not hold it."""
    uncertain(car, nominal_std)
    try:
        return grip(car, nominal_std=nominal_std)
    except InputError:
        return None


def _check(amplitude: object, highest: object) -> None:
    stroke = positive_number("amplitude", amplitude, "m")
    if not LEAST_AMPLITUDE <= stroke <= MOST_AMPLITUDE:
        raise InputError(
            f"amplitude = {stroke:g} m is outside of {LEAST_AMPLITUDE:g} to {MOST_AMPLITUDE:g} m, the range of test "
            f"benches; EUSAMA uses {PLATFORM:g} m"
        )
    top = positive_number("highest", highest, "Hz")
    if top > MOST_TOP:
        raise InputError(f"highest = {top:g} Hz is beyond {MOST_TOP:g} Hz; test benches sweep from {SWEEP_TOP:g} Hz")


def check_sweep(wheels: Wheels, highest: Hertz) -> None:
    """Refuse a sweep from less than usual that does not pass the resonance of each wheel."""
    _, high = wheels.resonances()
    i = int(np.argmax(high))
    if highest <= high[i] and highest < SWEEP_TOP:
        raise InputError(
            f"highest = {highest:g} Hz is not above the resonance of wheel {wheels.names[i]!r}, {high[i]:.3g} Hz, that "
            f"the sweep must pass; test benches sweep from {SWEEP_TOP:g} Hz"
        )


def _stds(slopes: RealArray, about: Uncertain) -> RealArray:
    """Return the standard deviations of curves, (wheel, frequency)."""
    flat = slopes.reshape(len(slopes), slopes.shape[1] * slopes.shape[2])
    return spreads(flat, about.covariance, about.values).reshape(slopes.shape[1:])


def _judged(found: Grip, about: Uncertain, weighed: Mapping[str, Newton]) -> Grip:
    """Return the grip with its verdict."""
    checks = [*plausible(about.car), *_weighed(found, about.car, weighed), *_against_limits(found)]
    if found.amplitude != PLATFORM:
        numbers: dict[str, Number] = {"amplitude": found.amplitude, "usual": PLATFORM}
        checks.append(Check(Remark(GripCheck.AMPLITUDE, numbers), Level.CARE))
    if about.doubt is not None:
        checks.append(Check(Remark(GripCheck.UNTRUSTED, {"level": about.doubt.label}), about.doubt))
    if about.nominal:
        checks.append(Check(Remark(GripCheck.STAYED_NOMINAL, {"names": about.nominal}), Level.CARE))
    if about.known:
        checks.append(Check(Remark(GripCheck.KNOWN, {"names": about.known}), Level.NOTE))
    return replace(found, verdict=Verdict(found.verdict.headline, tuple(checks)))


def _weighed(found: Grip, car: Suspension, weighed: Mapping[str, Newton]) -> Iterator[Check]:
    """Yield weighed loads that are far from those of the masses, where these can be told."""
    if weighed:
        with suppress(InputError):
            own = static_loads(wheels_of(car))[0]
            yield from plausible_loads(dict(zip(found.wheels, own.tolist(), strict=True)), weighed)


def _between_classes(found: Grip, wheel: int, ends: tuple[float, float]) -> Iterator[Check]:
    """Yield which classes of adhesion the interval of a wheel reaches, where it reaches several."""
    low, high = (class_of_adhesion(end) for end in ends)
    if low != high:
        numbers: dict[str, Number] = {
            "wheel": found.wheels[wheel], "least": 100 * float(found.adhesion[wheel]), "low": 100 * float(ends[0]),
            "high": 100 * float(ends[1]), "worst": low, "best": high,
        }  # fmt: skip
        yield Check(Remark(GripCheck.BETWEEN_CLASSES, numbers), Level.CARE)


def _against_limits(found: Grip) -> Iterator[Check]:
    """Yield what the limit of the phase says of each wheel, and which wheels leave the platform."""
    ends, limit = found.interval(LEVEL), float(np.degrees(PHASE_LIMIT))
    for i, wheel in enumerate(found.wheels):
        phase = float(np.degrees(found.phase[i]))
        low, high = (float(np.degrees(end)) for end in ends[f"{wheel}.phase"])
        numbers: dict[str, Number] = {"wheel": wheel, "phase": phase, "low": low, "high": high, "limit": limit}
        if low <= limit <= high and low < high:
            yield Check(Remark(GripCheck.NEAR, numbers), Level.CARE)
        else:
            passes = phase >= limit
            yield Check(
                Remark(GripCheck.PASSES if passes else GripCheck.FAILS, numbers), Level.SOUND if passes else Level.CARE
            )
        yield from _between_classes(found, i, ends[f"{wheel}.adhesion"])
        if found.resonances[i, 1] > found.hertz[-1]:
            top: dict[str, Number] = {
                "wheel": wheel, "hertz": float(found.resonances[i, 1]), "highest": float(found.hertz[-1]),
            }  # fmt: skip
            yield Check(Remark(GripCheck.BEYOND, top), Level.CARE)
        if found.stiff[i]:
            yield Check(Remark(GripCheck.STIFF, {"wheel": wheel}), Level.NOTE)
        if found.least[i] <= 0:
            hertz = float(found.adhesion_hertz[i])
            yield Check(Remark(GripCheck.LIFTS, {"wheel": wheel, "hertz": hertz}), Level.CARE)
