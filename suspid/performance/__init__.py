"""Figures that a car or a record is judged by: comfort, travel, wheel load, grip, wear; and a better suspension.

A metric is a module of its name with a function that takes a `suspid.Suspension`, a `suspid.Estimate` or a record and
returns a frozen result in SI units. `grip`: wheels on a test bench; below it `contact` (forces at the road) and
`uncertain` (what is not known of a car). `wear`: dampers against limits and earlier estimates; below it `losses` (the
rule and its interval). `ride`: cars on roads (`road_response`: variances and their derivatives; `figures`: what is made
of them) and records (`recorded`), weighted as ISO 2631-1 says (`weightings`). `classify_road`: measured roads.

To add a metric: write its module and import its names below, in ``__all__``: `suspid` exports every name of that list.
Names for other packages alone are imported ``as`` themselves and stay out of it.
"""

from suspid.performance.active_tuning import ActiveTuning
from suspid.performance.classify_road import classify_road
from suspid.performance.damper_rates import dampers_between as dampers_between
from suspid.performance.damper_rates import dampers_of as dampers_of
from suspid.performance.damper_rates import parallel_spring as parallel_spring
from suspid.performance.damper_rates import rates_of as rates_of
from suspid.performance.damper_tunings import DamperTuning
from suspid.performance.felt import ACCELERATIONS as ACCELERATIONS
from suspid.performance.figure_plan import ANGLES as ANGLES
from suspid.performance.fronts import tuning_steps as tuning_steps
from suspid.performance.grip import grip
from suspid.performance.grip import grip_if_any as grip_if_any
from suspid.performance.grips import CLASSES as CLASSES
from suspid.performance.grips import PHASE_LIMIT as PHASE_LIMIT
from suspid.performance.grips import Grip
from suspid.performance.losses import Loss as Loss
from suspid.performance.losses import Rates as Rates
from suspid.performance.losses import WearRule
from suspid.performance.losses import loss_of as loss_of
from suspid.performance.recorded import SHARED_HALF as SHARED_HALF
from suspid.performance.ride import ride
from suspid.performance.rides import Ride
from suspid.performance.rides import power_ends as power_ends
from suspid.performance.road_classes import ROAD_LIMITS as ROAD_LIMITS
from suspid.performance.road_classes import RoadClass
from suspid.performance.sensitivities import Sensitivities, sensitivities
from suspid.performance.sensitivities import per_cent as per_cent
from suspid.performance.tune import tune
from suspid.performance.tune_active import tune_active
from suspid.performance.tune_damper import tune_damper
from suspid.performance.tunings import Tuning
from suspid.performance.wear import wear
from suspid.performance.wear_checks import LEVELS as LEVELS
from suspid.performance.wears import DamperWear, Wear
from suspid.performance.wears import ParameterChange as ParameterChange
from suspid.performance.weightings import weighting

__all__ = [
    "ActiveTuning",
    "DamperTuning",
    "DamperWear",
    "Grip",
    "Ride",
    "RoadClass",
    "Sensitivities",
    "Tuning",
    "Wear",
    "WearRule",
    "classify_road",
    "grip",
    "ride",
    "sensitivities",
    "tune",
    "tune_active",
    "tune_damper",
    "wear",
    "weighting",
]
