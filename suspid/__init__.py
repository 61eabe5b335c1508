"""From a suspension's measured response to its modes, and from its modes back to its springs and dampers.

>>> from suspid import eigenmodes, quarter_car
>>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
...                   tire_stiffness=200e3, chassis_damping=1500)
>>> print(eigenmodes(car))
  mode    f [Hz]    wn [rad/s]    zeta [1]
------  --------  ------------  ----------
     1   1.08458       6.81462    0.231436
     2   11.6775       73.3716    0.259608
"""

from importlib.metadata import version

from suspid.cars import read_car, write_car
from suspid.cleaning import Cleaned, clean
from suspid.comparison import Comparison, compare
from suspid.decays import Decay, Decays, find_decays
from suspid.denoising import denoise
from suspid.errors import (
    IdentificationError,
    InputError,
    ReconstructionError,
    RecordError,
    RecordWarning,
    SuspidError,
)
from suspid.fleet import FleetRun, identify_many
from suspid.fleet_summary import FleetSummary, fleet_summary
from suspid.identification import Considered, FourSteps, Identification, identify
from suspid.mending.conversions import to_si
from suspid.mending.findings import Finding
from suspid.modes import Interval, ModalSet, eigenmodes
from suspid.presets import full_car, half_car, quarter_car
from suspid.reconstruction import Reconstruction, reconstruct
from suspid.recordings import RawChannel, Recording
from suspid.records import read_record, read_recording, write_record
from suspid.repeats import Repeats, identify_repeats
from suspid.report_json import Source, report_to_dict, source_of
from suspid.reporting import report
from suspid.ridges import Ridge, SkeletonFit, Window, find_ridges, fit_ridges
from suspid.scalogram import BandwidthSearch, Morlet, Scalogram, best_bandwidth, cwt
from suspid.sensors import Vertical, scaled, vertical
from suspid.signals import cut
from suspid.simulation import add_noise, free_decay
from suspid.springs.observations import ModalTest
from suspid.suspension import Strut, Suspension, statespace

__version__ = version("suspid")

# fmt: off
__all__ = [  # noqa: RUF022 - grouped by step
    # a model
    "Strut", "Suspension", "quarter_car", "half_car", "full_car", "statespace", "read_car", "write_car",
    # its modes
    "ModalSet", "Interval", "eigenmodes",
    # its responses, and measured ones
    "free_decay", "add_noise", "read_record", "write_record", "cut", "denoise",
    # files as they come, cleaned, and the decays in them
    "read_recording", "Recording", "RawChannel", "clean", "Cleaned", "Finding",
    "vertical", "Vertical", "scaled", "to_si", "find_decays", "Decays", "Decay",
    # a record's modes, at once or step by step, and those of repeats
    "identify", "Identification", "FourSteps", "Considered", "identify_repeats", "Repeats",
    "best_bandwidth", "BandwidthSearch", "cwt", "Scalogram", "Morlet",
    "find_ridges", "Ridge", "Window", "fit_ridges", "SkeletonFit",
    # back to springs and dampers, and how near that is
    "reconstruct", "Reconstruction", "ModalTest", "compare", "Comparison",
    # a page for others, and many records
    "report", "report_to_dict", "Source", "source_of", "identify_many", "FleetRun", "fleet_summary", "FleetSummary",
    # what goes wrong
    "SuspidError", "InputError", "RecordError", "RecordWarning", "IdentificationError", "ReconstructionError",
]
