"""Springs and dampers straight from a recording, whatever moved the car.

`estimate` fits the parameters of a `suspid.Suspension` to records by maximum likelihood. `trials` are records as data
(`car_records`); in time `dynamics`, `responses`, `problem`, `onset` (decays after a rest), `further`, `sensors_asked`
and `sensors_needed` (mounts, gains, delays), `clocks`, `search`, `time_domain`, `noisy_inputs`, `fitted_in_time`; in
frequency `spectra`, `transfers`, `whitened` and `measured_causes` (errors in variables), `noise_levels`,
`wheel_problem`, `settling`, `suspects`, `frequency_domain` and `late_causes` (clocks). `whiteness`, `leftover`,
`misfit`, `identifiability`, `modal` and `judgement` say how far the result can be trusted, `estimates` holds it;
`causes` says what may have moved the car, and `by_cause` tries it in turn. `find_drives`, usable stretches of
recordings: `channel_words`, `stated_units`, `shaken`, `speeds`, `blocks`. With a model of the road: `rolling`,
`wheel_power`, `reach`, `road_model`, `tire_fit`, `whole_car`, `roads`, `two_axles` (`road_maps`, `axle_…`).
`damper_curve`: `strut_motion`, `latent_splines`, `force_basis`, `curve_fit`, `damper_curves`.
"""

from suspid.greybox.axle_data import Led as Led
from suspid.greybox.axle_data import behind_of
from suspid.greybox.body_mode import BodyMode, BodyModes
from suspid.greybox.body_modes import body_modes
from suspid.greybox.by_cause import estimate_by_cause
from suspid.greybox.car_records import nameless_forces
from suspid.greybox.causes import likely_causes
from suspid.greybox.damper_curve import damper_curve
from suspid.greybox.damper_curves import DamperCurve
from suspid.greybox.drive_limits import DriveLimits
from suspid.greybox.drive_tables import nothing_usable, stretch_table, summary_table
from suspid.greybox.drives import Drive, Drives
from suspid.greybox.estimate import estimate
from suspid.greybox.estimate_tables import parameter_table, parameter_unit, quantities_in
from suspid.greybox.estimates import Estimate
from suspid.greybox.find_drives import find_drives
from suspid.greybox.find_drives import recording_of as recording_of
from suspid.greybox.line_test import LineTest
from suspid.greybox.record_test import RecordTest
from suspid.greybox.roads import RoadEstimate
from suspid.greybox.stated_units import own_unit
from suspid.greybox.wheels import body_channels, wheels_missing, wheels_of

__all__ = [
    "BodyMode",
    "BodyModes",
    "DamperCurve",
    "Drive",
    "DriveLimits",
    "Drives",
    "Estimate",
    "LineTest",
    "RecordTest",
    "RoadEstimate",
    "behind_of",
    "body_channels",
    "body_modes",
    "damper_curve",
    "estimate",
    "estimate_by_cause",
    "find_drives",
    "likely_causes",
    "nameless_forces",
    "nothing_usable",
    "own_unit",
    "parameter_table",
    "parameter_unit",
    "quantities_in",
    "stretch_table",
    "summary_table",
    "wheels_missing",
    "wheels_of",
]
