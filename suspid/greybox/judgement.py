"""The checks of an estimate."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from suspid.greybox.parameter_ends import ends_of
from suspid.levels import LEVEL, SURE
from suspid.model import Suspension, value_in
from suspid.reconstruction import Unknowns
from suspid.units import RealArray
from suspid.words import Check, Level, Remark
from suspid.words.greybox import EstimateCheck

# Springs and masses within this factor of the least positive value are not needed.
NEXT_TO_LEAST = 1.01
MOST_GAIN = 2.0  # no sensor is off by such a factor, but units are
# Sensors of motion are calibrated to some percent; a tenth is more than mounting and temperature do.
MOST_MISCALIBRATED = 0.1
# Share of the relaxation of a mount by which a delay may differ from it where both are one thing, folded motion: steep
# edges make them alike to a few percent; real ones differ by any amount.
CANCELLED = 0.1
# Springs are within a factor of 2 of what anyone expects; units (ft, lbf, g, in, mm) are off by more than 3.
MOST_CHANGE = 3.0


def on_bounds(unknowns: Unknowns, x: RealArray) -> Iterator[Check]:
    """Yield which unknowns ended on a bound."""
    u = unknowns
    ends = u.on_bounds(x)
    vanished = ends & u.positive & (x <= NEXT_TO_LEAST * u.lower)
    for chosen, code, level in (
        (vanished, EstimateCheck.VANISHED, Level.CARE),
        (ends & ~vanished, EstimateCheck.AT_BOUND, Level.NOTE),
    ):
        names = tuple(label for label, one in zip(u.labels, chosen, strict=True) if one)
        if names:
            yield Check(Remark(code, {"names": names}), level)


def rests_on(car: Suspension, parameters: Sequence[str], *, still: Sequence[str], forced: bool) -> Iterator[Check]:
    """Yield which masses were taken as known; those of coordinates whose motion is given do not matter."""
    known = tuple(f"the mass of {m}" for m in car.masses if f"{m}.mass" not in parameters and m not in still)
    if known:
        yield Check(Remark(EstimateCheck.MASSES, {"names": known}), Level.NOTE)
    elif forced:
        yield Check(Remark(EstimateCheck.SCALE), Level.NOTE)


def gains_off(parameters: Sequence[str], values: RealArray, std: RealArray) -> Iterator[Check]:
    """Yield which gains are those of another unit, and which are surely those of no calibrated sensor."""
    far: list[str] = []
    odd: list[str] = []
    for name, value, sd in zip(parameters, values.tolist(), std.tolist(), strict=True):
        if not name.endswith(".gain"):
            continue
        if not 1 / MOST_GAIN <= value <= MOST_GAIN:
            far.append(f"{name} = {value:.3g}")
        elif abs(value - 1) > MOST_MISCALIBRATED + SURE * sd:
            odd.append(f"{name} = {value:.3g}")
    for code, names in ((EstimateCheck.GAIN, far), (EstimateCheck.MISCALIBRATED, odd)):
        if names:
            yield Check(Remark(code, {"names": tuple(names)}), Level.CARE)


def folded(parameters: Sequence[str], values: RealArray, std: RealArray) -> Iterator[Check]:
    """Yield which mounts and delays are there for sure, and cancel.

    A sensor that is late by just what a mount takes is rare. Motion above half the sampling rate that folds into the
    band does both: it turns the phase of the wheel at the upper end of the band, as either would, and leaves that below
    as it is. The spectrum does not tell it, since that of a logger with a filter may end as high.
    """
    mounts = [i for i, name in enumerate(parameters) if name.endswith(".relaxation") and values[i] > SURE * std[i]]
    delays = [i for i, name in enumerate(parameters) if name.endswith(".delay")]
    for i in mounts:
        for j in delays:
            if abs(values[j] - values[i]) < CANCELLED * values[i]:
                names = (parameters[i], parameters[j])
                yield Check(Remark(EstimateCheck.FOLDED, {"names": names, "seconds": float(values[i])}), Level.CARE)


def changed_check(names: tuple[str, ...]) -> Check:
    """Return the check of the parameters that differ from nominal."""
    remark = Remark(EstimateCheck.CHANGED, {"names": names}) if names else Remark(EstimateCheck.UNCHANGED)
    return Check(remark, Level.NOTE)


def far_or_vague(
    nominal: Suspension,
    parameters: Sequence[str],
    values: RealArray,
    std: RealArray,
    *,
    assumed: Collection[str] = (),
) -> Iterator[Check]:
    """Yield which springs may be in other units, and which parameters are hardly known, except those ``assumed``."""
    old = np.array([np.nan if one is None else one for one in (value_in(nominal, name) for name in parameters)])
    low, high = ends_of(parameters, values, std, LEVEL)
    vague = []
    for name, value, a, b, one in zip(parameters, values, low, high, old, strict=True):
        # A ratio is known to be positive; its interval is wider than the value where it spans a factor of 3.
        if np.isfinite(one) and name not in assumed and (b - a > 2 * value if a > 0 else value > 0):
            vague.append(name)
    far = tuple(
        name
        for name, value, a, b in zip(parameters, values.tolist(), low.tolist(), high.tolist(), strict=True)
        if name.endswith(".stiffness") and _far(value, a, b, value_in(nominal, name))
    )
    if far:
        yield Check(Remark(EstimateCheck.UNITS, {"names": far, "factor": MOST_CHANGE}), Level.CARE)
    if vague:
        yield Check(Remark(EstimateCheck.VAGUE, {"names": tuple(vague)}), Level.CARE)


def _far(value: float, low: float, high: float, nominal: float | None) -> bool:
    """Return whether a value is beyond the factor that springs differ from nominal by, and its interval excludes it."""
    if not nominal:
        return False
    return value > MOST_CHANGE * nominal < low or value < nominal / MOST_CHANGE > high
