"""The command of a tuning: springs and dampers of the best compromises."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path

import click

from suspid.cli.named_values import names_in, pairs
from suspid.cli.option_groups import Grouped
from suspid.cli.options import AT_SPEED, LINEARISE, ON_ROAD, progress, road_named
from suspid.cli.output import check_apart, said_warnings, say
from suspid.cli.parameters import bounds_by_name
from suspid.cli.quantities import Positive, Whole
from suspid.cli.ridden import linear_car_of
from suspid.cli.ride import GIVEN_STOPS, PICTURE_OF_RIDE, STATED_STD, drawing
from suspid.cli.streams import CAR, CAR_FILE, JSON_FILE
from suspid.files import naming, replacing
from suspid.words.tuning import TuningCheck


@click.command("tune", cls=Grouped)
@click.argument("source", type=CAR, metavar="CAR")
@ON_ROAD
@AT_SPEED
@click.option(
    "--parameter", "parameters", metavar="NAME[=NAME…]", multiple=True,
    help="Parameter to change, such as chassis.damping; those joined by = change by one factor; repeat. [struts off "
    "the road]",
)  # fmt: skip
@click.option(
    "--objective", "objectives", metavar="FIGURE[+FIGURE…]", multiple=True,
    help="One or two figures of suspid ride to minimise, joined by + as one, or of suspid grip to maximise, such as "
    "tire.adhesion and tire.phase. [comfort and wheel load]",
)  # fmt: skip
@click.option(
    "--limit",
    "limits",
    metavar="FIGURE=VALUE",
    multiple=True,
    help="Largest value of a figure in SI units, of adhesion and phase [rad] the least; repeat.",
)
@click.option(
    "--constraint", "related", metavar="TEXT", multiple=True,
    help='Linear in springs and dampers, as "front.damping >= rear.damping"; repeat. Those of the car file count too.',
)  # fmt: skip
@click.option(
    "--bound", "bounds", type=(str, float, float), metavar="NAME LOW HIGH", multiple=True,
    help="Smallest and largest value of a parameter; repeat. [a quarter to four times]",
)  # fmt: skip
@click.option("--points", type=Whole(2, 200), default=11, show_default=True, help="Number of cars on the Pareto front.")
@click.option(
    "--robust",
    type=Positive("sd"),
    default=None,
    help="Number of standard deviations to add to the mean of each figure, for what is uncertain. [0]",
)
@GIVEN_STOPS
@LINEARISE
@STATED_STD
@PICTURE_OF_RIDE
@click.option("--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write the cars and their figures as JSON.")
@click.option("-o", "--output", type=CAR_FILE, metavar="FILE", help="Write the car at the knee of the front as TOML.")
def tune_command(
    source: Path,
    road: str | None,
    speed: float | None,
    parameters: tuple[str, ...],
    objectives: tuple[str, ...],
    limits: tuple[str, ...],
    related: tuple[str, ...],
    bounds: tuple[tuple[str, float, float], ...],
    points: int,
    robust: float | None,
    clearance: tuple[str, ...],
    linearise: float | None,
    nominal_std: float | None,
    plot: Path | None,
    json_file: Path | None,
    output: Path | None,
) -> None:
    """Find springs and dampers of the best compromises.

    The compromises are those between two figures of CAR (.toml, or JSON of estimate or report).

    Without --objective these are the weighted acceleration of the first coordinate that is no wheel and the dynamic
    load of all wheels; without --parameter all struts off the road change, left and right ones that are equal by one
    factor.
    """
    from suspid.identification import to_json
    from suspid.model import Suspension, car_to_toml, read_constraints
    from suspid.performance import tune, tuning_steps
    from suspid.reporting import plot_tuning, tuning_to_dict

    if road is None or speed is None:
        raise click.UsageError("A car needs --road and --speed.")
    check_apart([source], [plot, json_file, output])
    with (
        drawing(plot) as draw,
        replacing(json_file) if json_file else nullcontext() as json_draft,
        replacing(output) if output else nullcontext() as car_draft,
        said_warnings() as said,
        progress(*tuning_steps(len(names_in(objectives) or (1, 2)), points)) as step,
        naming(source),
    ):
        what, against = linear_car_of(source, linearise, TuningCheck.LINEARISED, said)
        related += read_constraints(source) if isinstance(what, Suspension) else ()
        constraints: list[dict[str, float] | str] = [pairs(limits, "--limit", float), *related]
        found = tune(
            what,
            parameters=[name.split("=") for name in names_in(parameters)] or None,
            objective=names_in(objectives) or None,
            road=road_named(road) or 0.0,
            speed=speed,
            constraints=constraints,
            bounds=bounds_by_name(bounds),
            points=points,
            robust=robust or 0.0,
            clearance=pairs(clearance, "--clearance", float),
            nominal_std=nominal_std,
            progress=step,
        )
        found = replace(found, verdict=replace(found.verdict, checks=(*found.verdict.checks, *against)))
        draw(partial(plot_tuning, found), found)
        if json_draft:
            json_draft.write_text(to_json(tuning_to_dict(found)), encoding="utf-8")
        if car_draft:
            car_draft.write_text(car_to_toml(found.cars[found.knee]), encoding="utf-8")
    say(str(found))
