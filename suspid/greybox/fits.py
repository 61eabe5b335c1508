"""The best fit of all records, as the two ways of fitting return it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from suspid.greybox.noise_levels import Levels
from suspid.greybox.roads import RoadEstimate
from suspid.greybox.trials import Hold
from suspid.model import Suspension
from suspid.signals import Signal
from suspid.units import Hertz, RealArray
from suspid.words import Check


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Fit:
    """The best fit of all records, judged."""

    x: RealArray  # unknowns of the car
    covariance: RealArray  # (unknown, unknown): those of the car, then the extras
    fitted: tuple[Signal, ...]  # by test
    residual: tuple[Signal, ...]
    noise: tuple[RealArray, ...]
    chi_square: float
    freedom: int
    explains: bool
    alternatives: tuple[Suspension, ...]
    checks: tuple[Check, ...]
    pull: RealArray | None = None  # (unknown,): how far they would be from here without bounds, to first order
    # Unknowns besides those of the car: names, values, bounds, and what 1 means in the covariance.
    extras: tuple[str, ...] = ()
    extra_values: RealArray = field(default_factory=lambda: np.zeros(0))
    extra_ranges: RealArray = field(default_factory=lambda: np.zeros((0, 2)))
    extra_scale: RealArray = field(default_factory=lambda: np.zeros(0))
    levels: tuple[Levels, ...] = ()  # by test, where motion is given
    roads: tuple[RoadEstimate, ...] = ()
    band: tuple[Hertz, Hertz] | None = None  # where motion is given
    holds: tuple[Hold, ...] = ()  # by test: how inputs move between samples, in the time domain
