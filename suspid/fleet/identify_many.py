"""Many records: the same `identify`, and `reconstruct`, over a folder on this machine or over a fleet on a cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from suspid.errors import InputError, ReconstructionError
from suspid.files import printable
from suspid.fleet.cluster import dask_engine
from suspid.fleet.engine import finished
from suspid.fleet.folder import begun, check_part, only_others, own, taken, write_manifest
from suspid.fleet.local import local_engine
from suspid.fleet.manifest import FORMAT, require_fleet
from suspid.fleet.parts import part_counts, part_numbers, read_table, write_part
from suspid.fleet.records import Entry, Records, in_chunks, listing
from suspid.fleet.rows import Job
from suspid.identification import Method
from suspid.model import Suspension, car_to_toml, eigenmodes
from suspid.reconstruction import Bounds, reconstruct
from suspid.units import Hertz, Kilogram, RadianPerSecond, Ratio, Second

if TYPE_CHECKING:
    import pyarrow as pa
    from distributed import Client

# Records in a chunk: at two hundredths of a second each, a task takes a second and costs its handling ten milliseconds.
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
    channels: Sequence[str] | str | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
    dbc: str | os.PathLike[str] | None = None,
    start: Second | None = None,
    stop: Second | None = None,
    modes: int | None = None,
    method: Method = "likelihood",
    band: tuple[RadianPerSecond, RadianPerSecond] | None = None,
    bandwidth: float | None = None,
    candidates: Iterable[float] = range(1, 51),
    fixed: Sequence[str] = (),
    bounds: Bounds | None = None,
    ties: Sequence[Sequence[str]] = (),
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
    free_masses: Sequence[str] = (),
    added_masses: Mapping[str, Kilogram] | None = None,
    tolerance: Ratio | None = None,
    search: bool = True,
    halves: bool = False,
    time_limit: Second | None = None,
    chunk: int = CHUNK,
    workers: int | None = None,
    scheduler: str | Client | None = None,
    progress: Progress | None = None,
) -> FleetRun:
    """Identify many records, on all cores or on a Dask cluster, into Parquet tables.

    The tables are written as the work goes, in parts that are complete or absent. Killed at any moment and called
    again with the same arguments it does the rest; the files are then those of a run that was not interrupted, byte
    by byte, whatever the number of workers (given the same versions and the same kind of processor). A record that
    cannot be read or identified becomes a row among the failures, even one that kills its process.

    Parameters
    ----------
    records : path, address, sequence of these, or iterable
        A folder (all records in and below it, by name), a pattern as ``"tests/*/run?.csv"``, a list of files, or
        addresses that fsspec knows, as ``"s3://fleet/2024/"``; or an iterable of responses, of (name, response)
        pairs or of paths, which is taken as the work goes and may be of any length; its names should differ, and
        to go on after an interruption it must come again in the same order. Workers of a cluster read files
        themselves: they must see the paths.
    output : path
        Folder of the results on a file system that the client sees; new, empty, or of the same run.
    car : Suspension, optional
        Known masses and nominal struts: springs and dampers are then reconstructed from each record's modes.
    channels, time, fs, dbc
        As in `read_record`, for every file.
    start, stop : float, optional
        As in `cut`: first and last time to use of every record [s].
    modes, method, band, bandwidth, candidates
        As in `identify`.
    fixed, bounds, ties, nominal_std, free_masses, tolerance, search
        As in `reconstruct`.
    added_masses : mapping of str to float, optional
        Masses [kg] added to the car in all of these tests, by coordinate.
    halves : bool
        Whether to compute `Identification.halves` of every mode, which costs more fits.
    time_limit : float, optional
        Longest time for one record [s]; one that takes longer is a failure. Default: none.
    chunk : int
        Records per task and part. For millions of records 1000 leaves fewer files.
    workers : int, optional
        Processes on this machine. Default: one per core.
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
        If the cluster is lost. The same call goes on.

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
    job = Job(
        channels=None if channels is None else (channels,) if isinstance(channels, str) else tuple(channels),
        time=time,
        fs=fs,
        dbc=None if dbc is None else os.path.abspath(dbc),
        start=start,
        stop=stop,
        modes=modes,
        method=method,
        band=None if band is None else (float(band[0]), float(band[1])),
        bandwidth=bandwidth,
        candidates=tuple(float(n) for n in candidates),
        car=None if car is None else car_to_toml(car),
        fixed=tuple(fixed),
        bounds=tuple((name, low, high) for name, (low, high) in (bounds or {}).items()),
        ties=tuple(tuple(group) for group in ties),
        nominal_std=tuple(nominal_std.items()) if isinstance(nominal_std, Mapping) else nominal_std,
        free_masses=tuple(free_masses),
        added_masses=tuple((added_masses or {}).items()),
        tolerance=tolerance,
        search=search,
        halves=halves,
        time_limit=time_limit,
    )
    _check_settings(job, car)
    folder = Path(output)
    source = listing(records, output=folder)
    engine = local_engine(workers) if scheduler is None else dask_engine(scheduler)
    with own(folder), engine as hands:
        manifest = begun(folder, {"format": FORMAT, **job.settings(), "chunk": chunk, "records": source.source})
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
        beyond = [number for number in part_numbers(folder, "modes") if number >= counts["parts"]]
        if beyond:
            raise InputError(
                f"{printable(str(folder))}: holds parts from number {beyond[0]} on, but the records end before: "
                f"fewer came than when the run began; give the same ones, or another folder for the results"
            )
        if total is not None and not total:
            raise InputError(f"there is no record in what was given{only_others(source)}")
        kept = counts.pop("kept")
        write_manifest(folder, {**manifest, "complete": counts})
    if hands.note:
        notes = (*notes, hands.note)
    return FleetRun(output=folder, records=counts["records"], failed=counts["failed"], kept=kept, notes=notes)


def _check_settings(job: Job, car: Suspension | None) -> None:
    """Refuse at once what would be every record's failure."""
    if job.method not in ("likelihood", "ridge"):
        raise InputError(f"method={job.method!r} is unknown; the methods are 'likelihood' and 'ridge'")
    if job.modes is not None and job.modes < 1:
        raise InputError(f"modes={job.modes}: ask for at least one mode, or leave it out to find out")
    if job.band is not None and not 0 < job.band[0] < job.band[1]:
        raise InputError(f"band={job.band}: must be two increasing angular frequencies above 0 [rad/s]")
    if job.time_limit is not None and not job.time_limit > 0:
        raise InputError(f"time_limit={job.time_limit} s must be positive")
    if car is None:
        given = [n for n in ("fixed", "bounds", "ties", "free_masses", "added_masses") if getattr(job, n)]
        if given:
            raise InputError(f"{given[0]} is of use only with a car")
        return
    nominal_std = dict(job.nominal_std) if isinstance(job.nominal_std, tuple) else job.nominal_std
    try:
        # The car's own modes, without a search: what is refused here is refused for every record.
        reconstruct(
            eigenmodes(car),
            car,
            fixed=job.fixed,
            bounds={name: (low, high) for name, low, high in job.bounds},
            ties=job.ties,
            nominal_std=nominal_std,
            free_masses=job.free_masses,
            tolerance=job.tolerance,
            search=False,
        )
    except ReconstructionError:
        # A record's modes may determine what these do not.
        return
