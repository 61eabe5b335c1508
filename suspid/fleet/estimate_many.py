"""Analyse many drives: on the cores of this machine or on a cluster, resumable, into Parquet tables."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from suspid.analysis import Settings
from suspid.arguments import explained
from suspid.errors import InputError
from suspid.fleet.job import DriveJob, check_drive, check_job
from suspid.fleet.listing import Records
from suspid.fleet.manifest import require_fleet
from suspid.fleet.records import Entry
from suspid.fleet.run import FleetRun, Progress, check_way_to_run, job_of, run
from suspid.fleet.vehicles import read_vehicles, vehicle_in_name, vehicles_from_names
from suspid.fleet.workers import dask_engine, local_engine
from suspid.greybox import DriveLimits, Led
from suspid.model import Suspension
from suspid.units import Metre, Second

if TYPE_CHECKING:
    from distributed import Client

# Drives in a chunk: each takes seconds, and a run that is killed loses the chunks under way.
DRIVES_CHUNK = 4


@explained
def estimate_many(
    drives: Records,
    *,
    output: str | os.PathLike[str],
    car: Suspension | None = None,
    settings: Settings | None = None,
    limits: DriveLimits | None = None,
    way: Mapping[str, str | None] | None = None,
    road: Literal["iso8608"] | None = None,
    wheel_radius: Metre | None = None,
    behind: Led | None = None,
    table: str | os.PathLike[str] | None = None,
    pattern: str | None = None,
    time_limit: Second | None = None,
    chunk: int = DRIVES_CHUNK,
    workers: int | None = None,
    scheduler: str | Client | None = None,
    progress: Progress | None = None,
) -> FleetRun:
    r"""Analyse many recorded drives, on all cores or on a Dask cluster, into Parquet tables.

    Each file is one drive and goes through `analyse_drive`, without curves of dampers. One row per vehicle and drive
    holds verdict, codes, stretches, springs and dampers with standard deviations, and the wear of each damper against
    nominal. Runs are resumable, and failures are rows, as in `identify_many`.

    Parameters
    ----------
    drives : path, address, sequence of these, or iterable
        As the records of `identify_many`. Samples in memory are taken as SI.
    output : path
        Folder of the results on a file system that the client sees; new, empty, or of the same run.
    car : Suspension, optional
        As in `analyse_drive`, for every drive. Without one: frequencies of the body.
    settings : Settings, optional
        As in `analyse_drive`; ``springs`` has what is held, bounded, tied or free.
    limits, way, road, wheel_radius, behind : optional
        As in `analyse_drive`.
    table : path, optional
        CSV with the columns ``record``, ``vehicle`` and ``date``, as in `fleet_summary`.
    pattern : str, optional
        In its place a regular expression with the groups ``vehicle`` and ``date``, as in `fleet_summary`. Without both,
        the vehicle is the folder of the file, and the date is looked for in the file's name.
    time_limit, workers, scheduler, progress : optional
        As in `identify_many`.
    chunk : int
        Drives per task and part.

    Returns
    -------
    FleetRun
        Counts, and the tables ``drives``, ``springs`` and ``failures``. `fleet_summary` draws conclusions from them.

    Raises
    ------
    InputError
        If a setting cannot be used, there are no such records, or the folder contains something else; see
        `identify_many`.
    SuspidError
        If the cluster is lost, or worker processes cannot start. The same call continues the run.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from suspid import add_noise, quarter_car, road_profile, simulate
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> t, rng = np.arange(0, 40, 0.005), np.random.default_rng(1)
    >>> road = road_profile(20.0 * t, roughness="B", rng=rng)
    >>> outputs = ["chassis_acceleration", "tire_acceleration"]
    >>> ride = simulate(car, t, {"road": road}, outputs=outputs, interpolation="cubic")
    >>> ride = add_noise(ride, snr_db=50.0, rng=rng)
    >>> nominal = car.with_parameters(damping={"chassis": 1400})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = estimate_many([("VAN 7/2024-05-31", ride)], output=folder, car=nominal, workers=1)
    ...     row = run.drives.to_pylist()[0]
    >>> row["vehicle"], round(row["chassis.damping"], -1), row["chassis.wear"]
    ('VAN 7', 1500.0, 'good')
    """
    require_fleet()
    check_way_to_run(chunk, workers, scheduler)
    named, place = _placing(table, pattern)
    drive = DriveJob(
        limits=limits or DriveLimits(), way=dict(way or {}), road=road, wheel_radius=wheel_radius,
        behind=dict(behind or {}), vehicles=named,
    )  # fmt: skip
    job = job_of(car, settings or Settings(), time_limit, drive)
    check_job(job, car)
    check_drive(job, drive, car)
    engine = local_engine(workers) if scheduler is None else dask_engine(scheduler)
    return run(drives, job, engine, output=output, chunk=chunk, progress=progress, placed=place)


def _placing(table: str | os.PathLike[str] | None, pattern: str | None) -> tuple[str, Callable[[Entry], Entry]]:
    """Return where vehicles and dates come from, and a function that gives an entry its own."""
    if table is not None and pattern is not None:
        raise InputError("give table or pattern, not both")
    if table is not None:
        listed = read_vehicles(table)
        digest = hashlib.sha256(Path(table).read_bytes()).hexdigest()
        return f"table {digest}", lambda entry: _at(entry, *listed.get(entry.name, (None, None)))
    if pattern is not None:
        vehicles_from_names((), pattern)
        return (
            f"pattern {pattern}",
            lambda entry: _at(entry, *vehicles_from_names([entry.name], pattern).get(entry.name, (None, None))),
        )
    return "names", lambda entry: _at(entry, *vehicle_in_name(entry.name))


def _at(entry: Entry, vehicle: str | None, when: float | None) -> Entry:
    return replace(entry, vehicle=vehicle, when=when)
