"""A run over many records: on the cores of this machine or on a cluster, resumable, into Parquet tables."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from suspid.analysis import Settings
from suspid.errors import InputError
from suspid.files import printable
from suspid.fleet.engine import Engine, finished
from suspid.fleet.folder import begun, check_end, check_part, is_of, not_empty, own, taken, write_manifest
from suspid.fleet.job import DriveJob, Job
from suspid.fleet.listing import Records, listing
from suspid.fleet.manifest import FLEET_FORMAT
from suspid.fleet.parts import part_counts, part_path, read_table, write_part
from suspid.fleet.records import Entry, in_chunks
from suspid.model import Suspension, car_to_toml
from suspid.units import Second
from suspid.wording import names_in_use
from suspid.words import count as counted

if TYPE_CHECKING:
    import pyarrow as pa

Progress: TypeAlias = Callable[[int, int, int | None], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class FleetRun:
    """Results of a run in its folder.

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
        Remarks on the run.

    Examples
    --------
    >>> import numpy as np
    >>> import tempfile
    >>> from suspid import as_record, identify_many
    >>> t = np.arange(0, 3, 0.01)
    >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t, channels=["seat"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = identify_many([("bump", decay)], output=folder, workers=1)
    ...     names = run.modes.column_names
    >>> run.records, run.failed, names[:3]
    (1, 0, ['record', 'sha256', 'suspid'])
    """

    output: Path
    records: int
    failed: int
    kept: int = 0
    notes: tuple[str, ...] = ()

    @property
    def modes(self) -> pa.Table:
        """One row per record and mode, of a run of `identify_many`.

        Examples
        --------
        >>> import tempfile
        >>> import numpy as np
        >>> from suspid import as_record, identify_many
        >>> t = np.arange(0, 3, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t, channels=["seat"])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     run = identify_many([("bump", decay)], output=folder, workers=1)
        ...     rows = run.modes.to_pylist()
        >>> [(row["record"], round(row["wn_rad_per_s"])) for row in rows]
        [('bump', 20)]
        """
        return read_table(self.output, "modes")

    @property
    def drives(self) -> pa.Table:
        """One row per vehicle and drive, of a run of `estimate_many`.

        Examples
        --------
        >>> import tempfile
        >>> from suspid import estimate_many, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     names = estimate_many(["nowhere.csv"], output=folder, car=car, workers=1).drives.column_names
        >>> {"vehicle", "chassis.damping", "chassis.damping_std", "chassis.wear"} <= set(names)
        True
        """
        return read_table(self.output, "drives")

    @property
    def springs(self) -> pa.Table:
        """One row per record and parameter of the car; none without a car.

        Examples
        --------
        >>> import tempfile
        >>> from suspid import identify_many
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     run = identify_many(["nowhere.csv"], output=folder, workers=1)
        ...     springs = run.springs
        >>> springs.num_rows, "parameter" in springs.column_names
        (0, True)
        """
        return read_table(self.output, "springs")

    @property
    def failures(self) -> pa.Table:
        """One row per record that failed, with the step and the reason.

        Examples
        --------
        >>> import tempfile
        >>> from suspid import identify_many
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     run = identify_many(["nowhere.csv"], output=folder, workers=1)
        ...     rows = run.failures.to_pylist()
        >>> [(row["record"], row["step"]) for row in rows]
        [('nowhere.csv', 'read')]
        """
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


def run(
    records: Records,
    job: Job,
    engine: AbstractContextManager[Engine],
    *,
    output: str | os.PathLike[str],
    chunk: int,
    progress: Progress | None,
    placed: Callable[[Entry], Entry] = lambda entry: entry,
) -> FleetRun:
    """Do the job on every record, or on those that an earlier run has not done; ``placed`` completes an entry."""
    folder, layout = Path(output), job.layout
    # Before anything is written: a run in the wrong folder must not hold the folder of the results.
    source = not_empty(listing(records, output=folder), folder)
    with own(folder), engine as hands:
        manifest = begun(folder, {"format": FLEET_FORMAT, **job.to_dict(), "chunk": chunk, "records": source.source})
        entries, total, notes = taken(folder, source, layout)
        damaged: list[int] = []
        counts = {"records": 0, "failed": 0, "kept": 0, "parts": 0}

        def to_do() -> Iterator[tuple[int, tuple[Entry, ...]]]:
            for number, some in enumerate(in_chunks(map(placed, entries), chunk)):
                counts["parts"] = number + 1
                there = part_counts(folder, number, layout)
                if there is None or (source.listed and not is_of(folder, number, some, layout)):
                    damaged.extend([number] if part_path(folder, layout.main, number).exists() else [])
                    yield number, some
                    continue
                check_part(folder, number, some, layout, listed=source.listed)
                tally(*there, kept=there[0])

        def tally(done: int, failed: int, *, kept: int = 0) -> None:
            counts["records"] += done
            counts["failed"] += failed
            counts["kept"] += kept
            if progress is not None:
                progress(counts["records"], counts["failed"], total)

        for number, part in finished(hands, job, to_do()):
            write_part(folder, number, part, layout)
            tally(part.records, part.failed)
        check_end(folder, counts["parts"], layout)
        if damaged:
            notes = (*notes, f"{counted(len(damaged), 'damaged part')} made again: number {_listed(damaged)}")
        kept = counts.pop("kept")
        write_manifest(folder, {**manifest, "complete": counts})
    if hands.note:
        notes = (*notes, hands.note)
    return FleetRun(output=folder, records=counts["records"], failed=counts["failed"], kept=kept, notes=notes)


def _listed(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers[:10])) + (" …" if len(numbers) > 10 else "")


def job_of(car: Suspension | None, settings: Settings, time_limit: Second | None, drive: DriveJob | None = None) -> Job:
    """Return what is done with every record, for workers that may run in another folder."""
    if settings.dbc is not None:
        settings = replace(settings, dbc=os.path.abspath(settings.dbc))
    toml = None if car is None else car_to_toml(car)
    return Job(settings=settings, car=toml, time_limit=time_limit, drive=drive, options=names_in_use())


def check_way_to_run(chunk: int, workers: int | None, scheduler: object) -> None:
    """Refuse chunks and workers that cannot be meant."""
    if isinstance(chunk, bool) or not isinstance(chunk, int) or chunk < 1:
        raise InputError(f"{chunk=} must be a number of records, 1 or more")
    if workers is not None and scheduler is not None:
        raise InputError("give workers (of this machine) or scheduler (a cluster), not both")
