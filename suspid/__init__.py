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

from suspid.cars import read_car, write_car
from suspid.comparison import Comparison, compare
from suspid.denoising import denoise
from suspid.errors import (
    IdentificationError,
    InputError,
    ReconstructionError,
    RecordError,
    SuspidError,
)
from suspid.identification import Considered, FourSteps, Identification, identify
from suspid.modes import Interval, ModalSet, eigenmodes
from suspid.observations import ModalTest
from suspid.presets import full_car, half_car, quarter_car
from suspid.reconstruction import Reconstruction, reconstruct
from suspid.records import read_record, write_record
from suspid.ridges import Ridge, SkeletonFit, Window, find_ridges, fit_ridges
from suspid.scalogram import BandwidthSearch, Morlet, Scalogram, best_bandwidth, cwt
from suspid.signals import cut
from suspid.simulation import add_noise, free_decay
from suspid.suspension import Strut, Suspension, statespace

# fmt: off
__all__ = [  # noqa: RUF022 - grouped by step
    # a model
    "Strut", "Suspension", "quarter_car", "half_car", "full_car", "statespace", "read_car", "write_car",
    # its modes
    "ModalSet", "Interval", "eigenmodes",
    # its responses, and measured ones
    "free_decay", "add_noise", "read_record", "write_record", "cut", "denoise",
    # a record's modes, at once or step by step
    "identify", "Identification", "FourSteps", "Considered",
    "best_bandwidth", "BandwidthSearch", "cwt", "Scalogram", "Morlet",
    "find_ridges", "Ridge", "Window", "fit_ridges", "SkeletonFit",
    # back to springs and dampers, and how near that is
    "reconstruct", "Reconstruction", "ModalTest", "compare", "Comparison",
    # what goes wrong
    "SuspidError", "InputError", "RecordError", "IdentificationError", "ReconstructionError",
]
