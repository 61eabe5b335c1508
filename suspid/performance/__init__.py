"""Figures that a car or a record is judged by: comfort, travel, wheel load, grip, wear; and a better suspension.

A metric is a module of its name with a function that takes a `suspid.Suspension`, a `suspid.Estimate` or a record and
returns a frozen result in SI units. `grip`: wheels on a test bench; below it `contact` (forces at the road) and
`uncertain` (what is not known of a car). `wear`: dampers against limits and earlier estimates; below it `losses` (the
rule and its interval). `ride`: cars on roads (`road_response`: variances and their derivatives; `figures`: what is made
of them) and records (`recorded`), weighted as ISO 2631-1 says (`weightings`). `classify_road`: measured roads.
"""

from suspid.performance.active_tuning import ActiveTuning
from suspid.performance.contact import wheels_of
from suspid.performance.damper_rates import dampers_between, dampers_of, rates_of, spring_beside
from suspid.performance.damper_tunings import DamperTuning
from suspid.performance.felt import ACCELERATIONS
from suspid.performance.figure_plan import ANGLES
from suspid.performance.grip import grip, grip_if_any
from suspid.performance.grips import CLASSES, PHASE_LIMIT, Grip
from suspid.performance.losses import Loss, Rates, WearRule, loss_of
from suspid.performance.ride import ride
from suspid.performance.rides import Ride
from suspid.performance.road_classes import ROAD_LIMITS, RoadClass, classify_road
from suspid.performance.sensitivities import Sensitivities, per_cent, sensitivities
from suspid.performance.tune import tune
from suspid.performance.tune_active import tune_active
from suspid.performance.tune_damper import tune_damper
from suspid.performance.tunings import Tuning, short
from suspid.performance.wear import wear
from suspid.performance.wears import DamperWear, ParameterChange, Wear
from suspid.performance.weightings import weighting

__all__ = [
    "ACCELERATIONS",
    "ANGLES",
    "CLASSES",
    "PHASE_LIMIT",
    "ROAD_LIMITS",
    "ActiveTuning",
    "DamperTuning",
    "DamperWear",
    "Grip",
    "Loss",
    "ParameterChange",
    "Rates",
    "Ride",
    "RoadClass",
    "Sensitivities",
    "Tuning",
    "Wear",
    "WearRule",
    "classify_road",
    "dampers_between",
    "dampers_of",
    "grip",
    "grip_if_any",
    "loss_of",
    "per_cent",
    "rates_of",
    "ride",
    "sensitivities",
    "short",
    "spring_beside",
    "tune",
    "tune_active",
    "tune_damper",
    "wear",
    "weighting",
    "wheels_of",
]
