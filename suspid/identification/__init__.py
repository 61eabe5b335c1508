"""Identify modes from records of free decay.

`identify` fits damped exponentials to all channels jointly by maximum likelihood and selects the number of poles by
BIC, or runs the wavelet steps (`by_likelihood`, `by_ridges`). `identify_repeats` fits several decays jointly. Below
them: `exponentials` and `poles` (inner products), `noise` (least variance, likelihood, colour), `likelihood` and
`joint_fit` (fits of one decay and of several), `by_amplitude` (decays that are not linear), `candidates`, `fitting`,
`refinement`, `classification`, `selection` (number of poles), `covariance`, `halves` (linearity), `parts` (of a
record), `modes_json` (files). Samples are (channel, sample), poles per sample.
"""

from suspid.identification.classification import LEAST_EXPLAINED
from suspid.identification.common_amplitude import Described, at_common_amplitudes
from suspid.identification.considered import Considered, removed_as
from suspid.identification.covariance import with_changes as with_changes
from suspid.identification.exponentials import synthesize
from suspid.identification.identification import Identification, Method
from suspid.identification.identification_json import described_from_dict, identification_to_dict, repeats_to_dict
from suspid.identification.identify import identify, identify_linear
from suspid.identification.identify_repeats import identify_repeats
from suspid.identification.mode_checks import CYCLES_SEEN as CYCLES_SEEN
from suspid.identification.mode_checks import cycles_seen as cycles_seen
from suspid.identification.mode_checks import flashes as flashes
from suspid.identification.mode_checks import swings_many_times as swings_many_times
from suspid.identification.modes_json import (
    modes_from_dict,
    modes_to_dict,
    read_content,
    read_modes,
    to_json,
    write_modes,
)
from suspid.identification.noise import (
    ABOVE_RESOLUTION,
    UNIFORM_STD,
    WhiteNoise,
    correlated,
    degrees_of_freedom,
    lag_one,
    resolution,
)
from suspid.identification.nonlinear import AmplitudeDependence, Force, ForceKind, patience
from suspid.identification.parts import residual_of_part
from suspid.identification.pulses import FORCED
from suspid.identification.removed_checks import in_hertz
from suspid.identification.repeats import Repeats
from suspid.identification.repeats_verdict import verdict_of_repeats
from suspid.identification.selection import MOST_PAIRS, Selection, select
from suspid.identification.stabilization import Stabilization, stabilization
from suspid.identification.steps import FourSteps
from suspid.identification.tables import tables_of, tables_of_repeats
from suspid.identification.verdict import verdict_of

__all__ = [
    "ABOVE_RESOLUTION",
    "FORCED",
    "LEAST_EXPLAINED",
    "MOST_PAIRS",
    "UNIFORM_STD",
    "AmplitudeDependence",
    "Considered",
    "Described",
    "Force",
    "ForceKind",
    "FourSteps",
    "Identification",
    "Method",
    "Repeats",
    "Selection",
    "Stabilization",
    "WhiteNoise",
    "at_common_amplitudes",
    "correlated",
    "degrees_of_freedom",
    "described_from_dict",
    "identification_to_dict",
    "identify",
    "identify_linear",
    "identify_repeats",
    "in_hertz",
    "lag_one",
    "modes_from_dict",
    "modes_to_dict",
    "patience",
    "read_content",
    "read_modes",
    "removed_as",
    "repeats_to_dict",
    "residual_of_part",
    "resolution",
    "select",
    "stabilization",
    "synthesize",
    "tables_of",
    "tables_of_repeats",
    "to_json",
    "verdict_of",
    "verdict_of_repeats",
    "write_modes",
]
