"""The command ``suspid fleet``: a folder of records into tables, and what the tables say."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from suspid.analysis import CarSettings, Settings
from suspid.cli.options import FILE, analysing
from suspid.cli.support import Positive, said_warnings, say

if TYPE_CHECKING:
    from suspid.fleet import Progress


@click.command("fleet")
@click.argument("folder")
@analysing
@click.option(
    "-o", "--output", type=FILE, metavar="RESULTS", help="Folder of the results; an interrupted run continues."
)
@click.option("--summary", is_flag=True, help="FOLDER holds results: show what they say, and run nothing.")
@click.option("--workers", type=click.IntRange(min=1), metavar="N", help="Processes on this machine. [one per core]")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler in their place, such as tcp://host:8786.")
@click.option("--car", type=FILE, metavar="CAR", help="Find springs and dampers too, of this car (.toml).")
@click.option("--fixed", metavar="STRUT[.stiffness|.damping]", multiple=True, help="Hold at the car's value; repeat.")
@click.option("--time-limit", type=Positive("s"), metavar="SECONDS", help="Longest time for one record. [none]")
@click.option("--chunk", type=click.IntRange(min=1), metavar="N", help="Records per task and part of a table. [32]")
@click.option("--table", type=FILE, metavar="CSV", help="Columns record, vehicle, date: look for trends.")
@click.option("--vehicle-from", "pattern", metavar="PATTERN", help="The same from names: (?P<vehicle>…)/(?P<date>…).")
def fleet_command(
    folder: str,
    settings: Settings,
    output: Path | None,
    summary: bool,
    workers: int | None,
    scheduler: str | None,
    car: Path | None,
    fixed: tuple[str, ...],
    time_limit: float | None,
    chunk: int | None,
    table: Path | None,
    pattern: str | None,
) -> None:
    """Identify all records in FOLDER.

    FOLDER may also be a pattern or an address. The results are Parquet tables in RESULTS.

    The options are those of `suspid identify`, for every record. If the run is killed, the same command does the
    rest. Afterwards, or with --summary RESULTS, it shows verdicts, how modes and parameters are distributed, which
    records stand out and, with --table or --vehicle-from, whose dampers change over time.

    The exit code is 1 if no record could be identified, and 130 after Ctrl-C.
    """
    from suspid.fleet import CHUNK, fleet_summary, identify_many
    from suspid.model import read_car, read_constraints

    if table is not None and pattern is not None:
        raise click.UsageError("Give --table or --vehicle-from, not both.")
    if summary:
        if output is not None:
            raise click.UsageError("--summary shows what is there: leave -o out.")
        say(str(fleet_summary(folder, table=table, pattern=pattern)))
        return
    if output is None:
        raise click.UsageError("Missing option '-o': the folder of the results.")
    if workers is not None and scheduler is not None:
        raise click.UsageError("Give --workers or --scheduler, not both.")
    constraints = () if car is None else read_constraints(car)
    with said_warnings() as said, goes_on(), progress_bar() as progress:
        run = identify_many(
            folder,
            output=output,
            car=None if car is None else read_car(car),
            settings=replace(settings, springs=CarSettings(fixed=fixed, constraints=constraints)),
            time_limit=time_limit,
            chunk=CHUNK if chunk is None else chunk,
            workers=workers,
            scheduler=scheduler,
            progress=progress,
        )
        said += run.notes
        found = fleet_summary(output, table=table, pattern=pattern)
    say(str(found))
    # Each record that was identified has a verdict; distributions need several records.
    if not found.verdicts:
        click.echo("suspid: error: no record could be identified", err=True)
        click.get_current_context().exit(1)


@contextmanager
def goes_on() -> Iterator[None]:
    """Say, when the user stops the run, that its results are kept."""
    try:
        yield
    except KeyboardInterrupt:
        click.echo("suspid: stopped; what is done is kept, and the same command continues from there", err=True)
        # The exit code that shells give to a program ended by Ctrl-C.
        click.get_current_context().exit(130)


@contextmanager
def progress_bar() -> Iterator[Progress]:
    """Give what shows records done, their rate, the time left and how many failed, on a terminal only."""
    from tqdm import tqdm

    with tqdm(unit=" records", disable=not sys.stderr.isatty(), file=sys.stderr) as bar:

        def show(done: int, failed: int, total: int | None) -> None:
            if bar.total != total:
                bar.reset(total)
            bar.set_postfix(failed=failed, refresh=False)
            bar.update(done - bar.n)

        yield show
