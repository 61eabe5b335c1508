"""From modes back to springs and dampers.

`reconstruct` finds stiffness and damping from poles and shapes by convex programs, with the covariance carried
through, and lists every other suspension that the same modes allow. Below it: `observations` (modes as data),
`unknowns` (parameters and bounds), `equations` and `polynomials` (residuals), `programs` (solvers),
`alternatives`, `suspects` and `results`.
"""

from suspid.reconstruction.alternatives import even_starts
from suspid.reconstruction.asked import Bounds, unknowns_of
from suspid.reconstruction.car_json import parameters_from_dict, reconstruction_to_dict
from suspid.reconstruction.descent import LARGEST_STEP, descend
from suspid.reconstruction.observations import ModalTest
from suspid.reconstruction.posed import Asked, check_asked
from suspid.reconstruction.reconstruct import Reconstruction, reconstruct
from suspid.reconstruction.results import tables_of_reconstruction
from suspid.reconstruction.unknowns import (
    QUANTITIES,
    Unknowns,
    parameter_names,
    parameter_values,
    parameter_vector,
    unit_of,
    with_values,
)
from suspid.reconstruction.wishes import Constraints, wishes_of

__all__ = [
    "LARGEST_STEP",
    "QUANTITIES",
    "Asked",
    "Bounds",
    "Constraints",
    "ModalTest",
    "Reconstruction",
    "Unknowns",
    "check_asked",
    "descend",
    "even_starts",
    "parameter_names",
    "parameter_values",
    "parameter_vector",
    "parameters_from_dict",
    "reconstruct",
    "reconstruction_to_dict",
    "tables_of_reconstruction",
    "unit_of",
    "unknowns_of",
    "wishes_of",
    "with_values",
]
