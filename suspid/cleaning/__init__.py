"""From a recording as stored to a record on a uniform clock.

`clean` puts all channels on one uniform clock and repairs what can be repaired safely: time stamps, gaps,
outliers, sentinels. Each repair, and each defect left alone, is a `Finding`. `read_record` reads and cleans a
file in one step, `as_record` takes arrays and tables. `vertical` combines the axes of a tilted accelerometer,
`scaled` and `to_si` convert units.
"""

from suspid.cleaning.aligned import Aligned, aligned, parts_of
from suspid.cleaning.as_record import as_record
from suspid.cleaning.clean import clean
from suspid.cleaning.cleaned import Cleaned
from suspid.cleaning.clipping import CLIPPED, clipped_run, clipping, is_clipped
from suspid.cleaning.clock import DRIFT
from suspid.cleaning.constant import moves
from suspid.cleaning.conversions import name_in_si, scaled, si_unit, to_si
from suspid.cleaning.data_forms import RecordLike, is_pair
from suspid.cleaning.faults import clipped_times, stuck_times, unmarked
from suspid.cleaning.findings import Finding
from suspid.cleaning.gaps import MOST_FILLED, runs
from suspid.cleaning.joining import ONE_RATE
from suspid.cleaning.placing import halving_error, interpolate
from suspid.cleaning.quantities import (
    MOTION_OF_UNIT,
    derivative_order,
    derivative_orders,
    named_quantities,
    named_quantity,
)
from suspid.cleaning.read_record import read_record
from suspid.cleaning.sentinels import without_sentinels
from suspid.cleaning.vertical import vertical
from suspid.cleaning.verticals import Vertical

__all__ = [
    "CLIPPED",
    "DRIFT",
    "MOST_FILLED",
    "MOTION_OF_UNIT",
    "ONE_RATE",
    "Aligned",
    "Cleaned",
    "Finding",
    "RecordLike",
    "Vertical",
    "aligned",
    "as_record",
    "clean",
    "clipped_run",
    "clipped_times",
    "clipping",
    "derivative_order",
    "derivative_orders",
    "halving_error",
    "interpolate",
    "is_clipped",
    "is_pair",
    "moves",
    "name_in_si",
    "named_quantities",
    "named_quantity",
    "parts_of",
    "read_record",
    "runs",
    "scaled",
    "si_unit",
    "stuck_times",
    "to_si",
    "unmarked",
    "vertical",
    "without_sentinels",
]
