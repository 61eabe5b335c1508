"""A suspension as a linear model, and its modes.

`Strut` and `Suspension` describe masses, springs and dampers of any topology; `quarter_car`, `half_car` and
`full_car` are the usual ones. `statespace` builds the `control.StateSpace`, `eigenmodes` its modes as a
`ModalSet`: the ground truth, of the same type as what `suspid.identification` estimates. `compare` compares two
of either kind. `read_car` and `write_car` keep a suspension as TOML.
"""

from suspid.model.car_files import car_from_toml, car_to_toml, parsed_toml, read_car, write_car
from suspid.model.comparison import Comparison, compare
from suspid.model.modes import Interval, ModalSet, eigenmodes, modal_table, pole_distances, scaled_shapes
from suspid.model.presets import full_car, half_car, quarter_car
from suspid.model.suspension import Strut, Suspension, output_weights, statespace

__all__ = [
    "Comparison",
    "Interval",
    "ModalSet",
    "Strut",
    "Suspension",
    "car_from_toml",
    "car_to_toml",
    "compare",
    "eigenmodes",
    "full_car",
    "half_car",
    "modal_table",
    "output_weights",
    "parsed_toml",
    "pole_distances",
    "quarter_car",
    "read_car",
    "scaled_shapes",
    "statespace",
    "write_car",
]
