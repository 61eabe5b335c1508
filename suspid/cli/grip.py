"""The command of a grip: the wheels of a car on a test bench."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from suspid.cli.named_values import pairs
from suspid.cli.option_groups import Grouped
from suspid.cli.options import LINEARISE
from suspid.cli.output import check_apart, said_warnings, say
from suspid.cli.quantities import Positive, Probability
from suspid.cli.ridden import linear_car_of
from suspid.cli.ride import NO_UNCERTAINTY, PICTURE_OF_RIDE, STATED_STD, drawing
from suspid.cli.streams import CAR, JSON_FILE
from suspid.files import naming, replacing
from suspid.levels import LEVEL
from suspid.text_tables import bound_columns, text_table
from suspid.words.grip import GripCheck

if TYPE_CHECKING:
    from suspid.performance import Grip


@click.command("grip", cls=Grouped)
@click.argument("source", type=CAR, metavar="CAR")
@click.option("--load", "loads", metavar="WHEEL=N", multiple=True, help="Static contact force as weighed; repeat.")
@click.option("--amplitude", type=Positive("metres"), help="Amplitude of the platform. [0.003]")
@LINEARISE
@STATED_STD
@click.option("--level", type=Probability(), help="Print intervals of this probability, such as 0.95.")
@PICTURE_OF_RIDE
@click.option("--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write figures and intervals as JSON.")
def grip_command(
    source: Path,
    loads: tuple[str, ...],
    amplitude: float | None,
    linearise: float | None,
    nominal_std: float | None,
    level: float | None,
    plot: Path | None,
    json_file: Path | None,
) -> None:
    """Show the grip of the wheels of CAR on a test bench.

    Adhesion after EUSAMA and least phase after EGEA of each wheel. CAR is a description (.toml), or the JSON of
    `suspid estimate`, whose uncertainty is carried through.
    """
    from suspid.identification import to_json
    from suspid.performance import grip
    from suspid.reporting import grip_result, plot_grip

    check_apart([source], [plot, json_file])
    with (
        drawing(plot) as draw,
        replacing(json_file) if json_file else nullcontext() as json_draft,
        said_warnings() as said,
        naming(source),
    ):
        car, against = linear_car_of(source, linearise, GripCheck.LINEARISED, said)
        found = grip(
            car,
            **({} if amplitude is None else {"amplitude": amplitude}),
            loads=pairs(loads, "--load", float) or None,
            nominal_std=nominal_std,
        )
        found = replace(found, verdict=replace(found.verdict, checks=(*found.verdict.checks, *against)))
        if level is not None and not np.any(found.covariance):
            raise click.UsageError(NO_UNCERTAINTY)
        draw(partial(plot_grip, found, level=level or LEVEL), found)
        if json_draft:
            json_draft.write_text(to_json(grip_result(found, level=level or LEVEL)), encoding="utf-8")
    say(str(found) if level is None else f"{found}\n\n{_intervals(found, level)}")


def _intervals(found: Grip, level: float) -> str:
    intervals = found.interval(level)
    units = [("deg", float(np.degrees(1.0))) if name.endswith(".phase") else ("%", 100.0) for name in intervals]
    names = [f"{name} [{unit}]" for name, (unit, _) in zip(intervals, units, strict=True)]
    ends = [(low * scale, high * scale) for (low, high), (_, scale) in zip(intervals.values(), units, strict=True)]
    return text_table({f"{100 * level:g} % interval": names, **bound_columns(ends)})
