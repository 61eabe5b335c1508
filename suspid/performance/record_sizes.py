"""Doubts about a record whose samples no ride has, most likely because of their unit."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from suspid.cleaning import to_si
from suspid.performance.felt import Felt
from suspid.performance.figure_plan import SICKNESS
from suspid.units import STANDARD_GRAVITY
from suspid.words import Check, Level, Number, Remark
from suspid.words.ride import RideCheck

# Weighted accelerations [m/s2]. ISO 2631-1 calls 2 extremely uncomfortable; minutes at three times the acceleration of
# gravity nobody survives. Rotation counts by 0.2 to 0.63 m/rad, so that as many rad/s2 are 6 m/s2 and more.
# People feel nothing below 0.01, and the noise of the best sensors of vehicles is above the lower limit.
MOST_FELT, LEAST_FELT = 30.0, 1e-4
# What ordinary rides have [m/s2]: from a tenth of what is felt to more than the roughest military tracks.
USUAL = (1e-3, 10.0)
# No suspension moves farther from its mean [m]; with 0.4 m, those of trophy trucks and tanks are the longest.
FARTHEST_TRAVEL = 1.0
# The mean of a vertical accelerometer is gravity: to its offset, some hundredths, and the cosine of its tilt.
TILTED = 0.08
# Units of loggers, the usual ones first.
UNITS_OF_LOGGERS: Mapping[str, tuple[str, ...]] = {
    "m": ("g", "mg", "mm/s2", "cm/s2"), "rad": ("deg/s2",), "length": ("mm", "cm"),
}  # fmt: skip


def implausible(
    felt: Sequence[Felt], travels: Sequence[Felt], figures: Mapping[str, float], stated: Collection[str]
) -> Iterator[Check]:
    """Yield what no ride has, with the units that would explain it.

    ``stated`` are the channels whose unit their name states.
    """
    for one in felt:
        gravity = _gravity(one)
        if gravity == ("m/s2",):
            yield Check(Remark(RideCheck.GRAVITY, {"channel": one.name, "mean": one.level}), Level.NOTE)
        elif gravity and one.name not in stated:
            numbers: dict[str, Number] = {"channel": one.name, "mean": one.level, "units": gravity}
            yield Check(Remark(RideCheck.GRAVITY_IN, numbers), Level.DOUBTFUL)
        rms = max((figures[f"{one.name}.{kind}"] for kind in one.kinds if kind != SICKNESS), default=MOST_FELT)
        numbers = {"channel": one.name, "weighted": rms, "unit": f"{one.turn}/s2"}
        if rms > MOST_FELT:
            units = gravity or tuple(_explaining(rms, UNITS_OF_LOGGERS[one.turn], USUAL))
            yield Check(Remark(RideCheck.TOO_LARGE, {**numbers, "limit": MOST_FELT, "units": units}), Level.DOUBTFUL)
        elif rms < LEAST_FELT:
            yield Check(Remark(RideCheck.TOO_SMALL, {**numbers, "limit": LEAST_FELT}), Level.DOUBTFUL)
    for one in travels:
        peak = float(np.max(np.abs(one.samples)))
        if peak > FARTHEST_TRAVEL:
            units = tuple(_explaining(peak, UNITS_OF_LOGGERS["length"], (0.0, FARTHEST_TRAVEL)))
            far: dict[str, Number] = {"channel": one.name, "peak": peak, "limit": FARTHEST_TRAVEL, "units": units}
            yield Check(Remark(RideCheck.TOO_FAR, far), Level.DOUBTFUL)


def _explaining(value: float, units: Sequence[str], usual: tuple[float, float]) -> Iterator[str]:
    """Yield the units in which a value is a usual one."""
    for unit in units:
        if usual[0] <= value * float(to_si(1.0, unit)[0]) <= usual[1]:
            yield unit


def _gravity(one: Felt) -> tuple[str, ...]:
    """Return the units in which the mean of an acceleration is that of gravity, beside less motion."""
    mean = abs(one.level)
    if one.turn != "m" or float(np.std(one.samples)) > mean / 2:
        return ()
    held = {unit: mean * float(to_si(1.0, unit)[0]) / STANDARD_GRAVITY for unit in ("m/s2", *UNITS_OF_LOGGERS["m"])}
    return tuple(unit for unit, share in held.items() if abs(share - 1) < TILTED)
