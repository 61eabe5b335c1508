"""The command of a ride: comfort, travel and wheel load of a car or a record."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from suspid.analysis import Settings
from suspid.cli.measured import checked_picture, save_picture
from suspid.cli.named_values import pairs
from suspid.cli.option_groups import Grouped
from suspid.cli.options import AT_SPEED, LINEARISE, ON_ROAD, reading, road_named
from suspid.cli.output import check_apart, said_warnings, say, shown
from suspid.cli.quantities import Positive, Probability
from suspid.cli.ridden import OF_CARS, linear_car_of, record_of
from suspid.cli.streams import FILE, JSON_FILE, RECORD
from suspid.files import naming, replacing
from suspid.text_tables import bound_columns, text_table
from suspid.words.ride import RideCheck

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from suspid.performance import Ride, Sensitivities
    from suspid.results import Result
    from suspid.words import Check

NO_UNCERTAINTY = "--level: this car states no uncertainty. Give --nominal-std, or the JSON of an estimate."

STATED_STD = click.option(
    "--nominal-std",
    type=Positive("share"),
    metavar="SHARE",
    help="Relative standard deviation of springs and dampers that were not estimated, such as 0.05.",
)
GIVEN_STOPS = click.option(
    "--clearance", metavar="STRUT=METRES", multiple=True, help="Distance of a strut to its stops; repeat."
)
PICTURE_OF_RIDE = click.option("--plot", type=FILE, metavar="FILE", help="Write a picture (.png, .svg, .pdf).")


@click.command("ride", cls=Grouped)
@click.argument("source", type=RECORD, metavar="CAR|RECORD")
@reading
@ON_ROAD
@AT_SPEED
@click.option("--duration", type=Positive("seconds"), help="Time of doses and peaks. [3600; the record's]")
@click.option(
    "--weighting",
    "weightings",
    metavar="CHANNEL=Wk,…",
    multiple=True,
    help="Weightings; repeat. [Wk and Wf; We of rotation]",
)
@GIVEN_STOPS
@LINEARISE
@STATED_STD
@click.option(
    "--level",
    type=Probability(),
    help="Print intervals of this probability, such as 0.95.",
)
@click.option(
    "--sensitivities", "tables", is_flag=True, help="Show the sensitivity of modes and figures to springs and dampers."
)
@PICTURE_OF_RIDE
@click.option("--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write figures and intervals as JSON.")
def ride_command(
    source: Path,
    settings: Settings,
    road: str | None,
    speed: float | None,
    duration: float | None,
    weightings: tuple[str, ...],
    clearance: tuple[str, ...],
    linearise: float | None,
    nominal_std: float | None,
    level: float | None,
    tables: bool,
    plot: Path | None,
    json_file: Path | None,
) -> None:
    """Show comfort, travel and wheel load of CAR.

    Of a car on a road, or comfort and travel of a record.

    CAR is a description (.toml), or the JSON of `suspid estimate` or `report`, whose uncertainty is carried through;
    both need --road and --speed. Any other file is a RECORD with channels such as seat_acceleration, or named by
    --weighting; the options on channels and time are those of `suspid estimate`. Channels in other units become SI. -
    is the standard input.

    With --sensitivities, of modes, figures and grip, --plot draws these.
    """
    from suspid.identification import to_json
    from suspid.levels import LEVEL
    from suspid.performance import ride, sensitivities
    from suspid.reporting import ride_to_dict

    check_apart([source], [plot, json_file])
    of_car = source.suffix.lower() in OF_CARS
    if of_car != (road is not None) or (road is None) != (speed is None):
        what_it_is = "a car" if of_car else "a record, since cars are .toml or .json"
        raise click.UsageError(
            f"A car needs --road and --speed, such as --road C --speed 20; a record takes none of them. "
            f"{shown(source.name)} is {what_it_is}."
        )
    if of_car and settings != Settings(decay=settings.decay):
        raise click.UsageError("A car has no channels and no time: options for records do not apply.")
    if not of_car and (clearance or linearise is not None or nominal_std is not None):
        raise click.UsageError("A record has no struts: --clearance, --linearise and --nominal-std go with a car.")
    if tables and not of_car:
        raise click.UsageError("--sensitivities need a car; this is a record.")
    kinds = {c: tuple(w.split(",")) for c, w in pairs(weightings, "--weighting", str).items()} or None
    gaps = pairs(clearance, "--clearance", float) or None
    with (
        drawing(plot) as draw,
        replacing(json_file) if json_file else nullcontext() as json_draft,
        said_warnings() as said,
        naming(source),
    ):
        against: tuple[Check, ...] = ()
        what: Any = None
        if of_car:
            what, against = linear_car_of(source, linearise, RideCheck.LINEARISED, said)
        else:
            what, against = record_of(source, settings, said)
        about: dict[str, Any] = {"road": road_named(road), "speed": speed, "clearance": gaps} if of_car else {}
        if of_car:
            about["nominal_std"] = nominal_std
        found = ride(what, duration=duration, weightings=kinds, **about)
        found = replace(found, verdict=replace(found.verdict, checks=(*found.verdict.checks, *against)))
        if level is not None and not np.any(found.std):
            raise click.UsageError(NO_UNCERTAINTY)
        text = str(found) if level is None else f"{found}\n\n{_intervals(found, level)}"
        turned = None
        if tables:
            turned = sensitivities(
                what,
                road=road_named(road),
                speed=speed,
                duration=found.duration,
                weightings=kinds,
                clearance=gaps,
                bench=True,
            )
            text += f"\n\n{turned}"
        draw(_picture(found, turned, level or LEVEL), turned or found)
        if json_draft:
            json_draft.write_text(to_json(ride_to_dict(found, level=level or LEVEL)), encoding="utf-8")
    say(text)


def _intervals(found: Ride, level: float) -> str:
    ends = found.interval(level)
    return text_table(
        {
            f"{100 * level:g} % interval": [f"{n} [{u}]" for n, u in zip(found.figures, found.units, strict=True)],
            **bound_columns(list(ends.values())),
        }
    )


@contextmanager
def drawing(plot: Path | None) -> Iterator[Callable[[Callable[[Figure], object], Result], None]]:
    """Give a function that saves a picture of a result in its size, or does nothing where none is wanted."""
    if plot is None:
        yield lambda _, __: None
        return
    with replacing(checked_picture(plot)) as draft:
        yield lambda draw, found: save_picture(draw, draft, size=size_of_picture(found))


def size_of_picture(found: Result) -> tuple[float, float] | None:
    """Return the size that a result's own picture has."""
    from suspid.reporting import drawing_of

    drawn = drawing_of(found)
    return None if drawn is None else drawn.size


def _picture(found: Ride, turned: Sensitivities | None, level: float) -> Callable[[Figure], object]:
    from suspid.reporting import plot_ride, plot_sensitivities

    if turned is None:
        return partial(plot_ride, found, level=level)
    shown = turned
    return lambda figure: plot_sensitivities(shown, figure.subplots())
