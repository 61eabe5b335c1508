"""From a recording as stored to a record that can be used.

`clean` puts all channels on one uniform clock and repairs what can be repaired safely: time stamps, gaps,
outliers, sentinels. Each repair, and each defect left alone, is a `Finding`. `read_record` reads and cleans a
file in one step. `vertical`, `scaled` and `to_si` turn sensor axes and units into what is wanted.
"""

from suspid.cleaning.clean import Cleaned, clean
from suspid.cleaning.conversions import to_si
from suspid.cleaning.findings import Finding
from suspid.cleaning.gaps import runs
from suspid.cleaning.inspection import CLIPPED, clipped_run
from suspid.cleaning.read_record import read_record
from suspid.cleaning.sensors import Vertical, scaled, vertical

__all__ = [
    "CLIPPED",
    "Cleaned",
    "Finding",
    "Vertical",
    "clean",
    "clipped_run",
    "read_record",
    "runs",
    "scaled",
    "to_si",
    "vertical",
]
