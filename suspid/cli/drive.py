"""The command for recorded drives: usable stretches, springs and dampers, or the frequencies of a body alone."""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import click

from suspid.analysis import Settings
from suspid.cli.measured import checked_picture, drafted, save_picture, sources_of
from suspid.cli.option_groups import Grouped
from suspid.cli.options import packed, progress, reading
from suspid.cli.output import check_apart, said_warnings
from suspid.cli.parameters import BEHIND, ROAD_MODEL, WHEEL_RADIUS, Outputs, Wanted, conclude, led_by, wanting, writing
from suspid.cli.quantities import Positive
from suspid.cli.streams import CAR, FILE, FOUND, RECORD
from suspid.files import printable, real_path, replacing
from suspid.greybox import DriveLimits, Drives

DEFAULTS = DriveLimits()


def way_of(
    speed: str | None, speed_unit: str | None, longitudinal: str | None, lateral: str | None
) -> dict[str, str | None]:
    """Return the channels of the motion along the way by argument of `find_drives`."""
    return {"speed": speed, "speed_unit": speed_unit, "longitudinal": longitudinal, "lateral": lateral}


def limits_of(least_speed: float, most_braking: float, most_cornering: float, shortest: float) -> DriveLimits:
    """Return the limits that the options ask for."""
    return DriveLimits(least_speed=least_speed, longitudinal=most_braking, lateral=most_cornering, shortest=shortest)


WAY = (
    click.option("--speed", metavar="NAME", help="Speed channel; none: use the vibration. [by name]"),
    click.option("--speed-unit", metavar="UNIT", help="Its unit, if the file states none: km/h, m/s, mph, kn."),
    click.option("--longitudinal", metavar="NAME", help="Channel of acceleration along the car. [by name]"),
    click.option("--lateral", metavar="NAME", help="Channel of acceleration across the car. [by name]"),
)
LIMITS = (
    click.option("--least-speed", type=Positive("m/s"), default=DEFAULTS.least_speed, show_default=True,
                 help="Slower is left."),
    click.option("--most-braking", type=Positive("m/s2"), default=DEFAULTS.longitudinal, show_default=True,
                 help="Leave out harder braking or accelerating."),
    click.option("--most-cornering", type=Positive("m/s2"), default=DEFAULTS.lateral, show_default=True,
                 help="Leave out harder cornering."),
    click.option("--shortest", type=Positive("seconds"), default=DEFAULTS.shortest, show_default=True,
                 help="Leave out shorter stretches."),
)  # fmt: skip


def road_of(road: str | None, wheel_radius: float | None, behind: tuple[str, ...]) -> dict[str, Any]:
    """Return the arguments of `analyse_drive` on the road."""
    return {"road": road, "wheel_radius": wheel_radius, "behind": led_by(behind) or None}


ROAD_TOO = (ROAD_MODEL, WHEEL_RADIUS, BEHIND)


@click.command("drive", cls=Grouped)
@click.argument("files", type=RECORD, nargs=-1, required=True, metavar="FILE...")
@click.option("--car", type=CAR, metavar="CAR", help="Masses and nominal struts (.toml). [frequencies alone]")
@reading
@packed(way_of, WAY, "way")
@packed(limits_of, LIMITS, "limits")
@packed(road_of, ROAD_TOO, "road")
@wanting
@click.option("--before", type=FOUND, metavar="JSON", multiple=True, help="Earlier result to judge wear by; repeat.")
@click.option("--plot", type=FILE, metavar="FILE", help="Write pictures of the drive (.png, .svg, .pdf).")
@click.option("--page", type=FILE, metavar="FILE", help="Write a report (.html, .pdf).")
@writing
def drive_command(
    files: tuple[Path, ...],
    car: Path | None,
    settings: Settings,
    way: dict[str, str | None],
    limits: DriveLimits,
    road: dict[str, Any],
    wanted: Wanted,
    before: tuple[Path, ...],
    plot: Path | None,
    page: Path | None,
    outputs: Outputs,
) -> None:
    """Find springs and dampers from recorded drives.

    FILEs are recordings of one car with the same sensors, of any length. Usable stretches are found: the car moves,
    does not brake or corner hard, and the sensors are in range. Channels in other units become SI.

    If CAR names a channel of the motion of each wheel, springs and dampers are estimated over all stretches. If the
    body alone was measured, its frequencies are found; damping is not, because the road is not known.

    Each damper's curve is tested whether it is a line. Its wear and its wheel's grip are judged against nominal values,
    or against earlier drives: --before takes the JSON of this command or of `suspid estimate`, in order of time. With
    --road iso8608 tires, the modes of the whole car and the road's class are found too; where rear wheels follow front
    wheels on one track, --behind makes tires and wheel masses several times more exact.

    Ends with 3 if the car that was found does not explain the records.
    """
    from suspid.analysis import analyse_drive
    from suspid.identification import to_json
    from suspid.model import car_to_toml, read_car
    from suspid.reporting import content_of, drive_to_dict, plot_drive, read_curves, read_estimate, report

    if len({real_path(path) for path in files}) < len(files):
        raise click.UsageError("One of the FILES is named twice: name each once.")
    if wanted.added:
        raise click.UsageError("--added is for tests; state the masses of the loaded car in CAR.")
    if outputs.output and car is None:
        raise click.UsageError("--output writes a car: give one with --car.")
    check_apart([*files, *before, *([car] if car else [])], [plot, page, outputs.output, outputs.json_file])
    steps = [*["reading", "finding stretches"] * len(files), "estimating", "finding curves", "drawing"]
    with (
        replacing(checked_picture(plot)) if plot else nullcontext() as figure_draft,
        drafted(page) as write_page,
        outputs.drafts() as (draft, json_draft),
        said_warnings() as said,
        progress(*steps) as step,
    ):
        found = analyse_drive(
            list(files),
            car=None if car is None else read_car(car),
            settings=settings,
            limits=limits,
            way=way,
            unknowns=wanted.unknowns(),
            before=[read_estimate(path) for path in before],
            curves_before=[read_curves(path) for path in before],
            **road,
            progress=step,
        )
        text = outputs.words(found.estimate, found)
        step("drawing")
        if not found.explains:
            said.append("the car that was found does not explain these records")
        if draft:
            _write(car_to_toml(found.estimate.suspension) if found.estimate else None, draft, outputs, said)
        if json_draft:
            json_draft.write_text(to_json(drive_to_dict(found, level=outputs.probability)), encoding="utf-8")
        if write_page:
            content = content_of(found, source=sources_of(files), level=outputs.probability, warnings=said)
            write_page(report(content))
        if figure_draft:
            save_picture(partial(plot_drive, found), figure_draft)
    conclude("\n\n".join([*map(listed, found.drives), text]), explains=found.explains)


def _write(car: str | None, draft: Path, outputs: Outputs, said: list[str]) -> None:
    """Write the car that was found; where there is none, leave the file as it is, and say so."""
    if car is not None:
        draft.write_text(car, encoding="utf-8")
        return
    if draft.is_file():
        draft.unlink()
    said.append(_left(outputs.output))


def _left(name: Path | None) -> str:
    """Return why a file of springs and dampers is as it was."""
    return f"{name}: not written, because no springs and dampers were found"


def listed(drives: Drives) -> str:
    """Return the stretches of a file as text: each of them, or how long was left for which reason."""
    from suspid.greybox import stretch_table, summary_table

    # More stretches than fit on a screen are summed up: lengths by reason.
    table = stretch_table(drives) if len(drives) <= 30 else summary_table(drives)
    return f"{printable(drives.title)}\n{table}"
