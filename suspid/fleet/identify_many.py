"""Analyse many records: on the cores of this machine or on a cluster, resumable, into Parquet tables."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from suspid.analysis import Settings
from suspid.arguments import explained
from suspid.fleet.job import check_job
from suspid.fleet.listing import Records
from suspid.fleet.manifest import require_fleet
from suspid.fleet.run import FleetRun, Progress, check_way_to_run, job_of, run
from suspid.fleet.workers import dask_engine, local_engine
from suspid.model import Suspension
from suspid.units import Second

if TYPE_CHECKING:
    from distributed import Client

# Records in a chunk: at 0.02 s each, a task takes 0.6 s and its handling 10 ms. Fewer cost more handling and files;
# more lose more work when the run is killed.
CHUNK = 32


@explained
def identify_many(
    records: Records,
    *,
    output: str | os.PathLike[str],
    car: Suspension | None = None,
    settings: Settings | None = None,
    time_limit: Second | None = None,
    chunk: int = CHUNK,
    workers: int | None = None,
    scheduler: str | Client | None = None,
    progress: Progress | None = None,
) -> FleetRun:
    """Analyse many records, on all cores or on a Dask cluster, into Parquet tables.

    Each record goes through `analyse`; its rows hold what that returns. The tables are written as the work goes, in
    parts that are complete or absent. If the run is killed, the same call does the rest; the files are then those of
    a run that was not interrupted, byte by byte, for any number of workers (given the same versions and the same kind
    of processor). Columns whose names do not say what they hold have a description among their metadata
    (``pyarrow.parquet.read_schema``). A record that cannot be analysed becomes a row among the failures, even one
    that kills its process.

    Parameters
    ----------
    records : path, address, sequence of these, or iterable
        A folder (all records in and below it, by name), a pattern as ``"tests/*/run?.csv"``, a list of files, or
        addresses that fsspec knows, as ``"s3://fleet/2024/"``; or an iterable of responses, of (name, response)
        pairs or of paths, which is taken as the work goes and may be of any length; its names should differ, and
        to continue after an interruption it must come again in the same order. Workers of a cluster read files
        themselves: they must see the paths.
    output : path
        Folder of the results on a file system that the client sees; new, empty, or of the same run.
    car : Suspension, optional
        Known masses and nominal struts: springs and dampers are then reconstructed from each record's modes.
    settings : Settings, optional
        As in `analyse`, for every record. Default: ``Settings()``.
    time_limit : float, optional
        Longest time for one record [s]; one that takes longer is a failure. Default: none.
    chunk : int
        Records per task and part. For millions of records 1000 leaves fewer files.
    workers : int, optional
        Processes on this machine. Default: one for each core that this process may use.
    scheduler : str or distributed.Client, optional
        A Dask cluster in place of this machine's cores: the address of its scheduler, or a client.
    progress : callable, optional
        Called with records done, records failed, and their number (None if it is not known) after each chunk.

    Returns
    -------
    FleetRun
        Counts, and the tables ``modes``, ``springs`` and ``failures``. `fleet_summary` draws conclusions from them.

    Raises
    ------
    InputError
        If a setting cannot be used, there are no such records, the folder contains something else, a run with other
        settings or versions, or one that is still running.
    SuspidError
        If the cluster is lost, or worker processes cannot start. The same call continues the run.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> decay = free_decay(car, np.arange(0, 4, 0.01), initial_state={"v_tire": 1.0})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = identify_many([("bump", decay), ("no record", 0)], output=folder, workers=1)
    ...     modes, failures = run.modes.to_pydict(), run.failures.to_pydict()
    >>> modes["record"], modes["mode"], np.round(modes["zeta"], 4)
    (['bump', 'bump'], [1, 2], array([0.2314, 0.2596]))
    >>> failures["record"], failures["reason"]
    (['no record'], ['expected a response or a path, not int'])
    """
    require_fleet()
    check_way_to_run(chunk, workers, scheduler)
    job = job_of(car, settings or Settings(), time_limit)
    check_job(job, car)
    engine = local_engine(workers) if scheduler is None else dask_engine(scheduler)
    return run(records, job, engine, output=output, chunk=chunk, progress=progress)
