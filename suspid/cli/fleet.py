"""The command ``suspid fleet``: a folder of records into tables, and their summary."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from suspid.analysis import CarSettings, Settings
from suspid.cli.commands import stopped_code
from suspid.cli.drive import LIMITS, ROAD_TOO, WAY, limits_of, road_of, way_of
from suspid.cli.measured import drafted, sources_of
from suspid.cli.option_groups import Grouped
from suspid.cli.options import analysing, packed
from suspid.cli.output import said_warnings, say
from suspid.cli.parameters import Wanted, wanting
from suspid.cli.quantities import Positive, Whole
from suspid.cli.streams import CAR, FILE, RECORD
from suspid.files import printable
from suspid.greybox import DriveLimits

if TYPE_CHECKING:
    from suspid.fleet import FleetSummary, Progress

# Options of one kind of record alone, by the names of their parameters.
OF_DRIVES = (
    "speed", "speed_unit", "longitudinal", "lateral", "least_speed", "most_braking", "most_cornering", "shortest",
    "road", "wheel_radius", "behind",
)  # fmt: skip
OF_DECAYS = ("which", "modes", "method", "band")


@click.command("fleet", cls=Grouped)
@click.argument("folder")
@analysing
@click.option(
    "-o", "--output", type=FILE, metavar="RESULTS", help="Folder of the results; an interrupted run continues."
)
@click.option("--summary", is_flag=True, help="FOLDER contains results: only summarise them.")
@click.option("--page", type=FILE, metavar="FILE", help="Write the summary as a report (.html, .pdf).")
@click.option("--csv", is_flag=True, help="Write the tables of RESULTS as CSV too.")
@click.option("--drives", is_flag=True, help="Each record is a drive, as for `suspid drive`.")
@click.option("--workers", type=Whole(1), help="Processes on this machine. [one per core]")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler instead, such as HOST:8786.")
@click.option("--car", type=CAR, metavar="CAR", help="Masses and nominal struts (.toml): springs and dampers as well.")
@wanting
@packed(way_of, WAY, "way")
@packed(limits_of, LIMITS, "limits")
@packed(road_of, ROAD_TOO, "road")
@click.option("--time-limit", type=Positive("seconds"), help="Longest time for one record. [none]")
@click.option("--chunk", type=Whole(1), help="Records per task and part of a table. [32; 4 drives]")
@click.option("--table", type=RECORD, metavar="CSV", help="Columns record, vehicle, date: look for trends.")
@click.option(
    "--vehicle-from", "pattern", metavar="PATTERN", help="Vehicle and date from file names: (?P<vehicle>…)/(?P<date>…)."
)
def fleet_command(
    folder: str,
    settings: Settings,
    output: Path | None,
    summary: bool,
    page: Path | None,
    csv: bool,
    workers: int | None,
    scheduler: str | None,
    drives: bool,
    car: Path | None,
    wanted: Wanted,
    way: dict[str, str | None],
    limits: DriveLimits,
    road: dict[str, Any],
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

    With --drives each file is a drive, and the options are those of `suspid drive`. The table has a row for each
    vehicle and drive. Without --table and --vehicle-from, the vehicle is the file's folder, and the date is looked for
    in the file's name.

    The exit code is 1 if no record could be identified, 130 after Ctrl-C and 143 after SIGTERM.
    """
    from suspid.fleet import CHUNK, DRIVES_CHUNK, check_vehicles, estimate_many, fleet_summary, identify_many
    from suspid.model import read_car, read_constraints

    if table is not None and pattern is not None:
        raise click.UsageError("Give --table or --vehicle-from, not both.")
    if summary:
        if output is not None:
            raise click.UsageError("--summary shows existing results: leave -o out.")
        with drafted(page) as write:
            _conclude(fleet_summary(folder, table=table, pattern=pattern), write, csv=csv, said=())
        return
    if output is None:
        raise click.UsageError("Missing option '-o': the folder of the results.")
    if workers is not None and scheduler is not None:
        raise click.UsageError("Give --workers or --scheduler, not both.")
    if wanted.added:
        raise click.UsageError("--added is for single tests; state the masses of the loaded car in CAR.")
    _check_kind(drives)
    check_vehicles(table, pattern)
    constraints = () if car is None or drives else read_constraints(car)
    settings = replace(settings, springs=CarSettings(**wanted.unknowns(), constraints=constraints))
    asked: dict[str, Any] = {
        "output": output,
        "car": None if car is None else read_car(car),
        "settings": settings,
        "time_limit": time_limit,
        "workers": workers,
        "scheduler": scheduler,
    }
    with drafted(page) as write, said_warnings() as said:
        with goes_on(), progress_bar() as progress:
            if drives:
                asked |= {"limits": limits, "way": way, "table": table, "pattern": pattern, **road}
                run = estimate_many(folder, chunk=chunk or DRIVES_CHUNK, progress=progress, **asked)
            else:
                run = identify_many(folder, chunk=chunk or CHUNK, progress=progress, **asked)
            said += run.notes
            found = fleet_summary(output, table=table, pattern=pattern)
        _conclude(found, write, csv=csv, said=said)
    # Each record that was identified has a verdict; distributions need several records.
    if not found.verdicts:
        click.echo("suspid: error: no record could be identified", err=True)
        click.get_current_context().exit(1)


def _conclude(found: FleetSummary, write: Callable[[str], None] | None, *, csv: bool, said: Sequence[str]) -> None:
    """Show what the results say, and write the page and the tables that are asked for."""
    from suspid.fleet import write_csv
    from suspid.reporting import content_of, report

    if write is not None:
        source = sources_of([found.folder / "manifest.json"])
        write(report(content_of(found, source=source, warnings=said)))
    say(str(found))
    for file in write_csv(found.folder) if csv else ():
        click.echo(f"suspid: {printable(str(file))} written", err=True)


def _check_kind(drives: bool) -> None:
    """Refuse options that belong to the other kind of record."""
    context = click.get_current_context()
    for parameter in context.command.params:
        if parameter.name not in (OF_DECAYS if drives else OF_DRIVES):
            continue
        if context.get_parameter_source(parameter.name) is ParameterSource.COMMANDLINE:
            other = "leave --drives out" if drives else "give --drives too"
            raise click.UsageError(f"{parameter.opts[0]} is for {'decays' if drives else 'drives'}: {other}.")


@contextmanager
def goes_on() -> Iterator[None]:
    """Say, when the user stops the run, that its results are kept."""
    try:
        yield
    except KeyboardInterrupt as stop:
        click.echo("suspid: stopped; the results so far are kept, and the same command continues", err=True)
        click.get_current_context().exit(stopped_code(stop))


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
