"""Many recordings.

`identify_many` identifies every record of a list or folder on local cores or a Dask cluster, resumable, into
Parquet tables. `fleet_summary` reads them: distributions, outliers, trends of each vehicle. Below them:
`records` (the list), `rows` and `parts` (the tables), `work` and `engine` (processes), `manifest` and `folder`
(what makes a run resumable).
"""

from suspid.fleet.fleet_summary import FleetSummary, fleet_summary
from suspid.fleet.identify_many import CHUNK, FleetRun, Progress, identify_many

__all__ = ["CHUNK", "FleetRun", "FleetSummary", "Progress", "fleet_summary", "identify_many"]
