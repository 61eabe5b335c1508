"""A suspension as a linear model, and its modes.

`Strut` and `Suspension` describe masses, springs and dampers of any topology; `quarter_car`, `half_car` and
`full_car` make the usual ones. `statespace` builds the `control.StateSpace`, `eigenmodes` its modes as a
`ModalSet`: the ground truth, of the same type as what `suspid.identification` estimates. `compare` compares two
of either kind. `read_car` and `write_car` keep a suspension as TOML.
"""

from suspid.model.assert_modes_close import assert_modes_close
from suspid.model.car_files import car_from_toml, read_car, read_constraints, write_car
from suspid.model.car_text import car_to_toml
from suspid.model.checks import added_masses, finite_number, positive_number
from suspid.model.compare import compare
from suspid.model.comparison import Comparison
from suspid.model.covariance import check_definite, jacobian_of
from suspid.model.eigenmodes import eigenmodes, scaled_shapes
from suspid.model.force_curves import Curve, equal_work, piecewise, slopes
from suspid.model.found_parameters import FoundCar, FoundParameters, found_parameters, value_in
from suspid.model.full_car import full_car
from suspid.model.half_car import half_car
from suspid.model.interval import Interval
from suspid.model.matching import common_mac, modal_assurance, paired, pole_distances
from suspid.model.modal_table import modal_table
from suspid.model.modes import ModalSet
from suspid.model.outputs import FORCE, OutputRows, force_weights, names_channel, output_rows, output_weights
from suspid.model.quarter_car import quarter_car
from suspid.model.sensor import Sensor
from suspid.model.statespace import state_matrix, statespace
from suspid.model.strut import Strut
from suspid.model.suspension import Suspension
from suspid.model.suspension_checks import check_linear, check_plain

__all__ = [
    "FORCE",
    "Comparison",
    "Curve",
    "FoundCar",
    "FoundParameters",
    "Interval",
    "ModalSet",
    "OutputRows",
    "Sensor",
    "Strut",
    "Suspension",
    "added_masses",
    "assert_modes_close",
    "car_from_toml",
    "car_to_toml",
    "check_definite",
    "check_linear",
    "check_plain",
    "common_mac",
    "compare",
    "eigenmodes",
    "equal_work",
    "finite_number",
    "force_weights",
    "found_parameters",
    "full_car",
    "half_car",
    "jacobian_of",
    "modal_assurance",
    "modal_table",
    "names_channel",
    "output_rows",
    "output_weights",
    "paired",
    "piecewise",
    "pole_distances",
    "positive_number",
    "quarter_car",
    "read_car",
    "read_constraints",
    "scaled_shapes",
    "slopes",
    "state_matrix",
    "statespace",
    "value_in",
    "write_car",
]
