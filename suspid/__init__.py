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

from suspid import performance
from suspid.analysis import (
    Analysis,
    CarSettings,
    CheckedLimits,
    DriveAnalysis,
    Limit,
    Settings,
    analyse,
    analyse_drive,
    check_limits,
    read_limits,
)
from suspid.cleaning import Cleaned, Finding, Vertical, as_record, clean, read_record, scaled, to_si, vertical
from suspid.decays import Decay, Decays, find_decays
from suspid.errors import (
    EstimationError,
    IdentificationError,
    InputError,
    ReconstructionError,
    RecordError,
    RecordWarning,
    SuspidError,
)
from suspid.fleet import (
    DamperTrends,
    FleetRun,
    FleetSummary,
    damper_trends,
    estimate_many,
    fleet_summary,
    identify_many,
)
from suspid.greybox import (
    BodyMode,
    BodyModes,
    DamperCurve,
    Drive,
    DriveLimits,
    Drives,
    Estimate,
    LineTest,
    RecordTest,
    RoadEstimate,
    body_modes,
    damper_curve,
    estimate,
    find_drives,
)
from suspid.identification import (
    Considered,
    FourSteps,
    Identification,
    Repeats,
    Stabilization,
    identify,
    identify_repeats,
    read_modes,
    stabilization,
    write_modes,
)
from suspid.io import read_recording, write_record
from suspid.model import (
    Comparison,
    Interval,
    ModalSet,
    Sensor,
    Strut,
    Suspension,
    assert_modes_close,
    compare,
    eigenmodes,
    full_car,
    half_car,
    quarter_car,
    read_car,
    statespace,
    write_car,
)
from suspid.performance import *  # noqa: F403 - all of its __all__ is public
from suspid.reconstruction import ModalTest, Reconstruction, reconstruct
from suspid.recordings import RawChannel, Recording
from suspid.records import cut
from suspid.reporting import (
    Source,
    content_of,
    damper_curve_to_dict,
    plot_amplitude,
    plot_comparison,
    plot_damper_curve,
    plot_drive,
    plot_entropy,
    plot_estimate,
    plot_fit,
    plot_frf,
    plot_grip,
    plot_identification,
    plot_ride,
    plot_scalogram,
    plot_sensitivities,
    plot_shapes,
    plot_skeletons,
    plot_spectra,
    plot_stabilization,
    plot_tuning,
    read_estimate,
    report,
    report_to_dict,
    source_of,
)
from suspid.simulation import Road, add_noise, free_decay, road, road_profile, simulate
from suspid.wavelets import (
    BandwidthSearch,
    Morlet,
    Ridge,
    Scalogram,
    SkeletonFit,
    Window,
    best_bandwidth,
    cwt,
    denoise,
    find_ridges,
    fit_ridges,
)
from suspid.words import Check, Code, DamperState, Level, Remark, Verdict

__version__ = version("suspid")

# fmt: off
__all__ = [  # noqa: RUF022 - grouped by step
    # a model
    "Strut", "Sensor", "Suspension", "quarter_car", "half_car", "full_car", "statespace", "read_car", "write_car",
    # its modes
    "ModalSet", "Interval", "eigenmodes",
    # its responses, and measured ones
    "free_decay", "simulate", "road", "Road", "road_profile", "add_noise", "read_record", "write_record", "cut",
    "denoise",
    # arrays and files as they come, cleaned, and the decays in them
    "as_record", "read_recording", "Recording", "RawChannel", "clean", "Cleaned", "Finding",
    "vertical", "Vertical", "scaled", "to_si", "find_decays", "Decays", "Decay",
    "find_drives", "Drives", "Drive", "DriveLimits", "body_modes", "BodyModes", "BodyMode",
    # the whole recipe
    "analyse", "Analysis", "Settings", "CarSettings", "analyse_drive", "DriveAnalysis",
    "check_limits", "CheckedLimits", "Limit", "read_limits",
    # a record's modes, at once or step by step, and those of repeats
    "identify", "Identification", "FourSteps", "Considered", "identify_repeats", "Repeats",
    "stabilization", "Stabilization", "read_modes", "write_modes",
    "best_bandwidth", "BandwidthSearch", "cwt", "Scalogram", "Morlet",
    "find_ridges", "Ridge", "Window", "fit_ridges", "SkeletonFit",
    # back to springs and dampers, and how near that is
    "reconstruct", "Reconstruction", "ModalTest", "compare", "Comparison",
    "assert_modes_close",
    # the car itself, straight from records
    "estimate", "Estimate", "RecordTest", "RoadEstimate", "read_estimate",
    # one damper as it is
    "damper_curve", "DamperCurve", "LineTest", "damper_curve_to_dict",
    # a page for others, and many records
    "report", "report_to_dict", "content_of", "Source", "source_of",
    "identify_many", "estimate_many", "FleetRun", "fleet_summary", "FleetSummary", "damper_trends", "DamperTrends",
    # pictures of each step
    "plot_scalogram", "plot_skeletons", "plot_spectra", "plot_frf", "plot_amplitude", "plot_entropy", "plot_fit",
    "plot_shapes", "plot_identification", "plot_stabilization",
    "plot_estimate", "plot_damper_curve", "plot_grip", "plot_ride", "plot_tuning", "plot_sensitivities", "plot_drive",
    "plot_comparison",
    # what is said of a result
    "Verdict", "Level", "Check", "Remark", "Code", "DamperState",
    # what goes wrong
    "SuspidError", "InputError", "RecordError", "RecordWarning", "IdentificationError", "ReconstructionError",
    "EstimationError",
]
# fmt: on
# figures that a car is judged by
__all__ += performance.__all__
