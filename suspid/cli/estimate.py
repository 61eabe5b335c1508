"""The command that fits the car itself to records."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from suspid.analysis import Settings, read
from suspid.cli.measured import checked_picture, save_picture
from suspid.cli.options import FILE, METHOD, READING, STRETCH, progress, settings_of
from suspid.cli.support import (
    Positive,
    added_masses,
    bounds_by_name,
    check_apart,
    equal_names,
    interval_table,
    named,
    said_warnings,
    say,
)
from suspid.files import replacing

if TYPE_CHECKING:
    from suspid.greybox import Estimate

EXIT_UNEXPLAINED = 3
OPTIONS = (
    click.option("--car", type=FILE, metavar="CAR", required=True, help="Masses and nominal struts (.toml)."),
    click.option(
        "--given", metavar="NAME,…", default="", help="Causes that were measured: roads, forces, wheels. [free decay]"
    ),
    click.option("--added", metavar="FILE:NAME=KG", multiple=True, help="Mass added at NAME in the test FILE; repeat."),
    click.option(
        "--fixed", metavar="STRUT[.stiffness|.damping]", multiple=True, help="Hold at the nominal value; repeat."
    ),
    click.option(
        "--bound",
        "bounds",
        type=(str, float, float),
        metavar="NAME LOW HIGH",
        multiple=True,
        help="Least and largest value of a parameter such as tire.stiffness; 0 and inf are no bounds; repeat.",
    ),
    click.option("--tie", "ties", metavar="A=B", multiple=True, help="Parameters that are equal; repeat."),
    click.option(
        "--nominal-std",
        type=Positive("share"),
        metavar="SHARE",
        help="Relative standard deviation of the nominal values, such as 0.3.",
    ),
    click.option("--free-mass", "free_masses", metavar="NAME", multiple=True, help="Mass that is unknown too; repeat."),
    click.option(
        "--level",
        type=click.FloatRange(0, 1, min_open=True, max_open=True),
        help="Print intervals of this probability, as 0.95.",
    ),
    click.option("--plot", type=FILE, metavar="FILE", help="Write pictures of the estimate (.png, .svg, .pdf)."),
    click.option("-o", "--output", type=FILE, metavar="FILE", help="Write the car that was found as TOML."),
    click.option(
        "--json", "json_file", type=FILE, metavar="FILE", help="Write parameters, uncertainty and modes as JSON."
    ),
)


def _reading(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of reading and the times to use, as its argument ``settings``, and its own."""
    unused = {"which": "whole", "modes": None, "method": METHOD, "band": None}
    packed = [name for name in inspect.signature(settings_of).parameters if name not in unused]

    @wraps(command)
    def unpacked(**values: Any) -> Any:
        settings = settings_of(**{name: values.pop(name) for name in packed}, **unused)
        return command(settings=settings, **values)

    made: Any = unpacked
    for option in reversed((*READING, *STRETCH[:2], *OPTIONS)):
        made = option(made)
    made = click.argument("files", type=FILE, nargs=-1, required=True, metavar="FILE...")(made)
    return cast("Callable[..., Any]", made)


@click.command("estimate")
@_reading
def estimate_command(
    files: tuple[Path, ...],
    settings: Settings,
    car: Path,
    given: str,
    added: tuple[str, ...],
    fixed: tuple[str, ...],
    bounds: tuple[tuple[str, float, float], ...],
    ties: tuple[str, ...],
    nominal_std: float | None,
    free_masses: tuple[str, ...],
    level: float | None,
    plot: Path | None,
    output: Path | None,
    json_file: Path | None,
) -> None:
    """Find springs and dampers from records of any motion.

    A FILE has channels named as in CAR: sensors, coordinates such as chassis or chassis_acceleration, travels such as
    chassis_travel; --rename gives them these names. Several FILES are tests of one car.

    Without --given a record is a free decay. --given road is a rig or a known road, --given chassis_force an actuator,
    --given wheel everyday driving: the motion of the wheel is measured, and the road is not needed.

    Ends with 3 if the car that was found does not explain the records.
    """
    from suspid.greybox import RecordTest, estimate
    from suspid.model import car_to_toml, read_car
    from suspid.reporting import plot_estimate
    from suspid.signals import cut

    if len({path.resolve() for path in files}) < len(files):
        raise click.UsageError("One of the FILES is named twice: every test counts once.")
    check_apart([*files, car], [plot, output, json_file])
    masses, limits, groups = added_masses(added, files), bounds_by_name(bounds), equal_names(ties)
    causes = [name.strip() for name in given.split(",") if name.strip()]
    with ExitStack() as outputs, said_warnings() as said, progress("reading", "estimating", "drawing") as step:
        figure_draft = outputs.enter_context(replacing(checked_picture(plot))) if plot else None
        draft = outputs.enter_context(replacing(output)) if output else None
        json_draft = outputs.enter_context(replacing(json_file)) if json_file else None
        suspension, tests = read_car(car), []
        step("reading")
        for file, kg in zip(files, masses, strict=True):
            with named(file):
                opened = read(file, settings)
                said += [f"{file}: {finding}" for finding in opened.cleaned.findings]
                said += [f"{file}: {note}" for note in opened.notes]
                record = cut(opened.cleaned.record, start=settings.start, stop=settings.stop)
            tests.append(RecordTest(record=record, added_masses=kg))
        step("estimating")
        found = estimate(
            tests,
            suspension,
            given=causes,
            fixed=fixed,
            bounds=limits,
            ties=groups,
            nominal_std=nominal_std,
            free_masses=free_masses,
        )
        step("drawing")
        if not found.explains:
            said.append("the car that was found does not explain these records")
        if draft:
            draft.write_text(car_to_toml(found.suspension), encoding="utf-8")
        if json_draft:
            json_draft.write_text(_as_json(found, level or 0.95), encoding="utf-8")
        if figure_draft:
            save_picture(partial(plot_estimate, found, level=level or 0.95), figure_draft)
    say(str(found) if level is None else f"{found}\n\n{interval_table(found, level)}")
    if not found.explains:
        click.get_current_context().exit(EXIT_UNEXPLAINED)


def _as_json(found: Estimate, level: float) -> str:
    from suspid.identification import to_json
    from suspid.reporting import estimate_to_dict

    return to_json(estimate_to_dict(found, level=level))
