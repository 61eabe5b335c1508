"""Figures that a car or a record is judged by: comfort, grip, wear.

A metric is a module of its name with a function that takes a `suspid.Suspension`, a `suspid.Estimate` or a record and
returns a frozen result in SI units. `grip`: wheels on a test bench; below it `contact` (forces at the road) and
`uncertain` (what is not known of a car). `wear`: dampers against limits and earlier estimates; below it `losses` (the
rule and its interval).
"""

from suspid.performance.damper_rates import dampers_of, rates_of
from suspid.performance.grip import grip
from suspid.performance.grips import CLASSES, PHASE_LIMIT, Grip
from suspid.performance.losses import Loss, Rates, WearRule, loss_of
from suspid.performance.wear import wear
from suspid.performance.wears import DamperWear, ParameterChange, Wear

__all__ = [
    "CLASSES",
    "PHASE_LIMIT",
    "DamperWear",
    "Grip",
    "Loss",
    "ParameterChange",
    "Rates",
    "Wear",
    "WearRule",
    "dampers_of",
    "grip",
    "loss_of",
    "rates_of",
    "wear",
]
