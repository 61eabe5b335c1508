"""The recipe: read, clean, find the decays, identify or join, reconstruct, judge.

`analyse` does it for a file, a recording or a record, as `Settings` ask for it, and returns an `Analysis`: every step's
result, and the verdict on all. The commands, the report and the fleet call it and nothing else.
`analyse_drive` is the recipe for drives: stretches, car, curves and wear of its dampers (`drive_dampers`).
`check_limits` judges what was found by limits from a file.
"""

from suspid.analysis.analyse import STEPS, analyse
from suspid.analysis.analyse_drive import analyse_drive
from suspid.analysis.analysis import Analysis
from suspid.analysis.car_channels import in_terms_of
from suspid.analysis.check_limits import check_limits
from suspid.analysis.checked_limits import CheckedLimit, CheckedLimits
from suspid.analysis.drive_analysis import DriveAnalysis
from suspid.analysis.limits import SCALES, Limit, read_limits
from suspid.analysis.reading import Read as Read
from suspid.analysis.reading import read
from suspid.analysis.settings import CarSettings, Settings
from suspid.analysis.springs import check_springs

__all__ = [
    "SCALES",
    "STEPS",
    "Analysis",
    "CarSettings",
    "CheckedLimit",
    "CheckedLimits",
    "DriveAnalysis",
    "Limit",
    "Settings",
    "analyse",
    "analyse_drive",
    "check_limits",
    "check_springs",
    "in_terms_of",
    "read",
    "read_limits",
]
