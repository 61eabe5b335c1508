"""Many recordings.

`identify_many` passes every record of a list or folder to `analyse`, `estimate_many` every drive to `analyse_drive`, on
local cores or a Dask cluster, resumable, into Parquet tables. `fleet_summary` reads them: failures, verdicts,
distributions, outliers, trends of each vehicle. Below them: `run`, `listing` and `records` (what to do), `job` (how),
`rows`, `drive_rows` and `tables` (results), `engine` with `workers` and `children` (who), `parts`, `manifest` and
`folder` (what makes a run resumable); `csv_tables`.
"""

from suspid.fleet.csv_tables import write_csv
from suspid.fleet.damper_trends import DamperTrend, DamperTrends, damper_trends, trends_of_rates
from suspid.fleet.distributions import Distribution, Outlier, known_columns
from suspid.fleet.estimate_many import DRIVES_CHUNK, estimate_many
from suspid.fleet.fleet_summary import fleet_summary
from suspid.fleet.identify_many import CHUNK, identify_many
from suspid.fleet.run import FleetRun, Progress
from suspid.fleet.summary import LEGEND, FleetSummary
from suspid.fleet.summary_text import MOST_SHOWN, no_outlier
from suspid.fleet.trends import Trend
from suspid.fleet.vehicles import check_vehicles

__all__ = [
    "CHUNK",
    "DRIVES_CHUNK",
    "LEGEND",
    "MOST_SHOWN",
    "DamperTrend",
    "DamperTrends",
    "Distribution",
    "FleetRun",
    "FleetSummary",
    "Outlier",
    "Progress",
    "Trend",
    "check_vehicles",
    "damper_trends",
    "estimate_many",
    "fleet_summary",
    "identify_many",
    "known_columns",
    "no_outlier",
    "trends_of_rates",
    "write_csv",
]
