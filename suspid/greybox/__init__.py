"""Springs and dampers straight from a recording, whatever moved the car.

`estimate` fits the parameters of a `suspid.Suspension` to records by maximum likelihood. `trials` are records as
data; in the time domain `dynamics` (exact motion and its derivatives), `responses` (output error of one record),
`problem`, `further` (unknowns: mounts, gains, delays), `search` and `time_domain`; in the frequency domain `spectra`,
`transfers`, `measured_causes` (errors in variables), `noise_levels`, `wheel_problem` and `frequency_domain`.
`whiteness`, `leftover`, `identifiability`, `modal` and `judgement` say how far the result can be trusted, `estimates`
holds it.
"""

from suspid.greybox.estimate import estimate
from suspid.greybox.estimates import Estimate, nominal_value, parameter_table, parameter_unit
from suspid.greybox.trials import RecordTest

__all__ = ["Estimate", "RecordTest", "estimate", "nominal_value", "parameter_table", "parameter_unit"]
