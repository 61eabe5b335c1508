"""Files in and out.

`read_recording` reads a file of any known format as a `suspid.Recording`: channels as stored, nothing repaired.
`write_record` writes a record as CSV or Parquet. A format is one module with one function, ``read_<format>``,
which returns a `Table`, and one line in `formats`, whose docstring is the recipe for another one. Text and MDF
are folders of their own. Files are checked for damage before a library reads them that could crash or hang.
"""

from suspid.io.foreign import install_line
from suspid.io.formats import READERS
from suspid.io.names import LONGEST_READ as LONGEST_READ
from suspid.io.names import TEMPERATURES as TEMPERATURES
from suspid.io.names import UNNAMED_COLUMN as UNNAMED_COLUMN
from suspid.io.names import bare_name, bracketed_unit, is_time, unit_in_name
from suspid.io.read_recording import read_recording
from suspid.io.text.cells import clock_seconds
from suspid.io.time_units import SLOWEST_STEP, seconds_in
from suspid.io.write_record import check_record_name, write_record

__all__ = [
    "READERS",
    "SLOWEST_STEP",
    "bare_name",
    "bracketed_unit",
    "check_record_name",
    "clock_seconds",
    "install_line",
    "is_time",
    "read_recording",
    "seconds_in",
    "unit_in_name",
    "write_record",
]
