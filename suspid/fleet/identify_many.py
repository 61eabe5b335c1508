"""Analyse many records: on the cores of this machine or on a cluster, resumable, into Parquet tables."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from suspid.analysis import Settings
from suspid.errors import InputError
from suspid.files import printable
from suspid.fleet.engine import finished
from suspid.fleet.folder import begun, check_end, check_part, only_others, own, taken, write_manifest
from suspid.fleet.job import Job, check_job
from suspid.fleet.listing import Records, listing
from suspid.fleet.manifest import FLEET_FORMAT, require_fleet
from suspid.fleet.parts import part_counts, read_table, write_part
from suspid.fleet.records import Entry, in_chunks
from suspid.fleet.workers import dask_engine, local_engine
from suspid.model import Suspension, car_to_toml
from suspid.units import Second

if TYPE_CHECKING:
    import pyarrow as pa
    from distributed import Client

# Records in a chunk: at 0.02 s each, a task takes 0.6 s and its handling 10 ms. Fewer cost more handling and files;
# more lose more work when the run is killed.
CHUNK = 32

Progress: TypeAlias = Callable[[int, int, int | None], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class FleetRun:
    """What a run left in its folder.

    Parameters
    ----------
    output : path
        The folder of the results.
    records : int
        How many records there are.
    failed : int
        How many of them have a row among the failures.
    kept : int
        How many were done by an earlier run that was interrupted.
    notes : tuple of str
        What the user should know of the run.
    """

    output: Path
    records: int
    failed: int
    kept: int = 0
    notes: tuple[str, ...] = ()

    @property
    def modes(self) -> pa.Table:
        """One row per record and mode."""
        return read_table(self.output, "modes")

    @property
    def springs(self) -> pa.Table:
        """One row per record and parameter of the car; none without a car."""
        return read_table(self.output, "springs")

    @property
    def failures(self) -> pa.Table:
        """One row per record that failed, with the step and the reason."""
        return read_table(self.output, "failures")

    def __str__(self) -> str:
        kept = f", {self.kept} of them by an earlier run" if self.kept else ""
        return "\n".join(
            [
                f"{printable(str(self.output))}: {self.records} records{kept}; {self.records - self.failed} without "
                f"failure, {self.failed} with",
                *self.notes,
            ]
        )


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
        If a setting cannot be used, there are no such records, the folder holds something else, a run of other
        settings or versions, or one that is still going on.
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
    if isinstance(chunk, bool) or not isinstance(chunk, int) or chunk < 1:
        raise InputError(f"{chunk=} must be a number of records, 1 or more")
    if workers is not None and scheduler is not None:
        raise InputError("give workers (of this machine) or scheduler (a cluster), not both")
    job = _job(car, settings or Settings(), time_limit)
    check_job(job, car)
    folder = Path(output)
    source = listing(records, output=folder)
    engine = local_engine(workers) if scheduler is None else dask_engine(scheduler)
    with own(folder), engine as hands:
        manifest = begun(folder, {"format": FLEET_FORMAT, **job.to_dict(), "chunk": chunk, "records": source.source})
        entries, total, notes = taken(folder, source)
        counts = {"records": 0, "failed": 0, "kept": 0, "parts": 0}

        def to_do() -> Iterator[tuple[int, tuple[Entry, ...]]]:
            for number, some in enumerate(in_chunks(entries, chunk)):
                counts["parts"] = number + 1
                there = part_counts(folder, number)
                if there is None:
                    yield number, some
                    continue
                check_part(folder, number, some, listed=source.listed)
                tally(*there, kept=there[0])

        def tally(done: int, failed: int, *, kept: int = 0) -> None:
            counts["records"] += done
            counts["failed"] += failed
            counts["kept"] += kept
            if progress is not None:
                progress(counts["records"], counts["failed"], total)

        for number, part in finished(hands, job, to_do()):
            write_part(folder, number, part)
            tally(part.records, part.failed)
        check_end(folder, counts["parts"])
        if total is not None and not total:
            raise InputError(f"there is no record in what was given{only_others(source)}")
        kept = counts.pop("kept")
        write_manifest(folder, {**manifest, "complete": counts})
    if hands.note:
        notes = (*notes, hands.note)
    return FleetRun(output=folder, records=counts["records"], failed=counts["failed"], kept=kept, notes=notes)


def _job(car: Suspension | None, settings: Settings, time_limit: Second | None) -> Job:
    if settings.dbc is not None:
        # Workers may run in another folder.
        settings = replace(settings, dbc=os.path.abspath(settings.dbc))
    return Job(settings=settings, car=None if car is None else car_to_toml(car), time_limit=time_limit)
