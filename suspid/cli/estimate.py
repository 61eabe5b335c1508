"""The command that fits the car itself to records."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from functools import partial
from pathlib import Path
from typing import Any

import click

from suspid.analysis import Settings, check_limits, read_limits
from suspid.cli.fitting import GIVEN, fitted, sensing, tests_of
from suspid.cli.measured import checked_picture, drafted, save_picture, sources_of
from suspid.cli.option_groups import Grouped
from suspid.cli.options import packed, progress, reading
from suspid.cli.output import check_apart, said_warnings
from suspid.cli.parameters import BEHIND, ROAD_MODEL, WHEEL_RADIUS, Outputs, Wanted, conclude, led_by, wanting, writing
from suspid.cli.streams import CAR, FILE, RECORD
from suspid.files import real_path, replacing


def road_of(road: str | None, speed: str | None, wheel_radius: float | None, behind: tuple[str, ...]) -> dict[str, Any]:
    """Return the arguments of `estimate` on the road; a speed is a number [m/s] or the name of a channel."""
    known: str | float | None = speed
    with suppress(TypeError, ValueError):
        known = float(speed)  # type: ignore[arg-type]
    return {"road": road, "speed": known, "wheel_radius": wheel_radius, "behind": led_by(behind) or None}


ROAD = (
    ROAD_MODEL,
    click.option("--speed", metavar="NAME|M/S", help="Channel of speed, or its value, for --road."),
    WHEEL_RADIUS,
    BEHIND,
)


SENSORS = """\b
Sensors in CAR, at a point of the body [m], in a damper, and in the middle of an axle:
  [sensors]
  az_seat = { acceleration = "heave", ahead = 0.3, left = 0.4 }
  damper_pot = { travel = "front" }
  lift = { displacement = { front = 0.5, rear = 0.5 } }"""


@click.command("estimate", cls=Grouped, epilog=SENSORS)
@click.argument("files", type=RECORD, nargs=-1, required=True, metavar="FILE...")
@reading
@click.option("--car", type=CAR, metavar="CAR", required=True, help="Masses and nominal struts (.toml).")
@GIVEN
@packed(road_of, ROAD, "road")
@sensing
@wanting
@click.option("--limits", type=CAR, metavar="FILE", help="Limits of modes, springs and dampers (.toml).")
@click.option("--plot", type=FILE, metavar="FILE", help="Write pictures of the estimate (.png, .svg, .pdf).")
@click.option("--page", type=FILE, metavar="FILE", help="Write a report (.html, .pdf).")
@writing
def estimate_command(
    files: tuple[Path, ...],
    settings: Settings,
    car: Path,
    given: str,
    road: dict[str, Any],
    sensing: dict[str, Any],
    wanted: Wanted,
    limits: Path | None,
    plot: Path | None,
    page: Path | None,
    outputs: Outputs,
) -> None:
    """Find springs and dampers from records of any motion.

    A FILE has channels named as in CAR: sensors, coordinates such as chassis or chassis_acceleration, travels such as
    chassis_travel; --rename gives them these names. Several FILES are tests of one car. Sensors at other points, or of
    other names, are described in CAR, as shown at the end.

    Causes that were measured are given: --given wheels in everyday driving, where the road is not needed; --given road
    on a rig or a known road, --given chassis_force with an actuator. Without --given a record is a free decay if it
    dies down, or else moved by the roads or wheels that were measured. With --road iso8608 tires and the modes of the
    whole car are found too, by a model of the road.

    Ends with 3 if the car that was found does not explain the records.
    """
    from suspid.identification import to_json
    from suspid.model import car_to_toml, read_car
    from suspid.reporting import content_of, estimate_to_dict, plot_estimate, report

    if len({real_path(path) for path in files}) < len(files):
        raise click.UsageError("One of the FILES is named twice: name each once.")
    check_apart([*files, car, *filter(None, (limits,))], [plot, page, outputs.output, outputs.json_file])
    asked = () if limits is None else read_limits(limits)
    masses, unknowns = wanted.added_masses(files), wanted.unknowns()
    with (
        replacing(checked_picture(plot)) if plot else nullcontext() as figure_draft,
        drafted(page) as write_page,
        outputs.drafts() as (draft, json_draft),
        said_warnings() as said,
        progress("reading", "estimating", "drawing") as step,
    ):
        suspension = read_car(car)
        step("reading")
        tests = tests_of(files, suspension, settings, masses, said)
        step("estimating")
        found = fitted(tests, suspension, given, said, {**road, **sensing, **unknowns})
        judged = check_limits(found, asked, level=outputs.probability) if asked else None
        text = "\n\n".join([outputs.words(found), *([] if judged is None else [str(judged)])])
        step("drawing")
        if not found.explains:
            said.append("the car that was found does not explain these records")
        if draft:
            draft.write_text(car_to_toml(found.suspension), encoding="utf-8")
        if json_draft:
            plain = estimate_to_dict(found, level=outputs.probability, limits=judged)
            json_draft.write_text(to_json(plain), encoding="utf-8")
        if write_page:
            sources = sources_of(files)
            content = content_of(found, source=sources, level=outputs.probability, warnings=said, limits=asked)
            write_page(report(content))
        if figure_draft:
            save_picture(partial(plot_estimate, found, level=outputs.probability), figure_draft)
    conclude(text, explains=found.explains)
