"""The command ``suspid fleet``: a folder of records into tables, and what the tables say."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import click

from suspid.cli.support import Positive, angular_band, said_warnings, say
from suspid.identification import Method

if TYPE_CHECKING:
    from suspid.fleet import Progress

FILE = click.Path(path_type=Path)
# What shells say of a program that Ctrl-C ended.
INTERRUPTED = 130


@click.command("fleet")
@click.argument("folder")
@click.option("-o", "--output", type=FILE, metavar="RESULTS", help="Folder of the results; a run goes on where it was.")
@click.option("--summary", is_flag=True, help="FOLDER holds results: show what they say, and run nothing.")
@click.option("--workers", type=click.IntRange(min=1), metavar="N", help="Processes on this machine. [one per core]")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler in their place, such as tcp://host:8786.")
@click.option("--car", type=FILE, metavar="CAR", help="Find springs and dampers too, of this car (.toml).")
@click.option("--fixed", metavar="STRUT[.stiffness|.damping]", multiple=True, help="Hold at the car's value; repeat.")
@click.option("--channel", "channels", metavar="NAME", multiple=True, help="Channel to use; repeat. [all]")
@click.option("--time", "time", metavar="NAME", help="Column of time, if it is not named like one.")
@click.option("--fs", type=Positive("Hz"), metavar="HZ", help="Sampling rate of all records.")
@click.option("--dbc", type=FILE, metavar="FILE", help="Database that decodes the CAN frames of MDF files.")
@click.option("--from", "start", type=float, metavar="SECONDS", help="Time at which every decay begins.")
@click.option("--to", "stop", type=float, metavar="SECONDS", help="Last time to use.")
@click.option("--modes", type=click.IntRange(min=1), metavar="N", help="How many modes to find. [all that stand out]")
@click.option("--method", type=click.Choice(get_args(Method)), default="likelihood", show_default=True)
@click.option("--band", type=Positive("Hz"), nargs=2, metavar="LOW HIGH", help="Frequencies to look at [Hz].")
@click.option("--halves", is_flag=True, help="Compare the early and the late part of each decay, which costs more.")
@click.option("--time-limit", type=Positive("s"), metavar="SECONDS", help="Longest time for one record. [none]")
@click.option("--chunk", type=click.IntRange(min=1), metavar="N", help="Records per task and part of a table. [32]")
@click.option("--table", type=FILE, metavar="CSV", help="Columns record, vehicle, date: look for trends.")
@click.option("--vehicle-from", "pattern", metavar="PATTERN", help="The same from names: (?P<vehicle>…)/(?P<date>…).")
def fleet_command(
    folder: str,
    output: Path | None,
    summary: bool,
    workers: int | None,
    scheduler: str | None,
    car: Path | None,
    fixed: tuple[str, ...],
    channels: tuple[str, ...],
    time: str | None,
    fs: float | None,
    dbc: Path | None,
    start: float | None,
    stop: float | None,
    modes: int | None,
    method: Method,
    band: tuple[float, float] | None,
    halves: bool,
    time_limit: float | None,
    chunk: int | None,
    table: Path | None,
    pattern: str | None,
) -> None:
    """Identify all records in FOLDER (or that a pattern or an address names) into Parquet tables in RESULTS.

    Killed at any moment and started again with the same command, it does the rest. Afterwards, or with --summary
    RESULTS, it shows how modes and parameters are distributed, which records stand out and, with --table or
    --vehicle-from, whose dampers change over time.

    Ends with 1 if not one record could be identified, with 130 if it was stopped by Ctrl-C.
    """
    from suspid.fleet import CHUNK, fleet_summary, identify_many
    from suspid.model import read_car

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
    angular = angular_band(band)
    with said_warnings() as said, goes_on(), progress_bar() as progress:
        run = identify_many(
            folder,
            output=output,
            car=None if car is None else read_car(car),
            fixed=fixed,
            channels=channels or None,
            time=time,
            fs=fs,
            dbc=dbc,
            start=start,
            stop=stop,
            modes=modes,
            method=method,
            band=angular,
            halves=halves,
            time_limit=time_limit,
            chunk=CHUNK if chunk is None else chunk,
            workers=workers,
            scheduler=scheduler,
            progress=progress,
        )
        said += run.notes
        found = fleet_summary(output, table=table, pattern=pattern)
    say(str(found))
    if not found.distributions:
        click.echo("suspid: error: not one record could be identified", err=True)
        click.get_current_context().exit(1)


@contextmanager
def goes_on() -> Iterator[None]:
    """Say, where the user stops the run, that nothing of it is lost."""
    try:
        yield
    except KeyboardInterrupt:
        click.echo("suspid: stopped; what is done is kept, and the same command continues from there", err=True)
        click.get_current_context().exit(INTERRUPTED)


@contextmanager
def progress_bar() -> Iterator[Progress]:
    """Give what shows records done, their rate, the time left and how many failed, where somebody looks on."""
    from tqdm import tqdm

    with tqdm(unit=" records", disable=not sys.stderr.isatty(), file=sys.stderr) as bar:

        def show(done: int, failed: int, total: int | None) -> None:
            if bar.total != total:
                bar.reset(total)
            bar.set_postfix(failed=failed, refresh=False)
            bar.update(done - bar.n)

        yield show
