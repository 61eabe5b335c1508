"""The command ``suspid``: from a record to modes, from modes to springs and dampers, and back to a record.

It ends with 0 if all went well, with 1 and one line on stderr if `suspid` refuses, with 2 if the command line is
wrong, and with 3 if a car was found and written, but does not explain the modes within their uncertainty.
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from suspid.cli.estimate import estimate_command
from suspid.cli.fleet import fleet_command
from suspid.cli.measured import channels_command, identify_command, report_command
from suspid.cli.options import FILE
from suspid.cli.simulate import simulate_command
from suspid.cli.support import (
    Commands,
    Positive,
    added_masses,
    bounds_by_name,
    check_apart,
    equal_names,
    interval_table,
    said_warnings,
    say,
)
from suspid.files import replacing

if TYPE_CHECKING:
    from suspid.model import ModalSet

EXIT_UNEXPLAINED = 3


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="suspid", message="suspid %(version)s")
def main() -> None:
    """Find the modes of a suspension in its measured free decay, and its springs and dampers from its modes.

    Exit codes: 0 done, also where no mode was found; 1 refused, with one line that says why; 2 the command line is
    wrong; 3 a car was found that does not explain the modes; 130 stopped by Ctrl-C.
    """


main.add_command(channels_command)
main.add_command(identify_command)
main.add_command(report_command)
main.add_command(estimate_command)
main.add_command(fleet_command)
main.add_command(simulate_command)


@main.command("reconstruct")
@click.argument("modes", type=FILE, nargs=-1, required=True)
@click.argument("car", type=FILE)
@click.option("--added", metavar="FILE:NAME=KG", multiple=True, help="Mass added at NAME in the test FILE; repeat.")
@click.option("--fixed", metavar="STRUT[.stiffness|.damping]", multiple=True, help="Hold at the nominal value; repeat.")
@click.option(
    "--bound",
    "bounds",
    type=(str, float, float),
    metavar="NAME LOW HIGH",
    multiple=True,
    help="Least and largest value of a parameter such as tire.stiffness; 0 and inf are no bounds; repeat.",
)
@click.option("--tie", "ties", metavar="A=B", multiple=True, help="Parameters that are equal; repeat.")
@click.option(
    "--nominal-std",
    type=Positive("share"),
    metavar="SHARE",
    help="Relative standard deviation of the nominal values, such as 0.3.",
)
@click.option("--free-mass", "free_masses", metavar="NAME", multiple=True, help="Mass that is unknown too; repeat.")
@click.option("--tolerance", type=Positive("share"), metavar="SHARE", help="Largest relative error of a pole. [0.02]")
@click.option("--no-search", is_flag=True, help="Start from the nominal car alone: look for no alternatives.")
@click.option("--level", type=click.FloatRange(0, 1, min_open=True, max_open=True), help="Print intervals, as 0.95.")
@click.option("-o", "--output", type=FILE, metavar="FILE", help="Write the car that was found as TOML.")
@click.option("--json", "json_file", type=FILE, metavar="FILE", help="Write parameters and uncertainty as JSON.")
def reconstruct_command(
    modes: tuple[Path, ...],
    car: Path,
    added: tuple[str, ...],
    fixed: tuple[str, ...],
    bounds: tuple[tuple[str, float, float], ...],
    ties: tuple[str, ...],
    nominal_std: float | None,
    free_masses: tuple[str, ...],
    tolerance: float | None,
    no_search: bool,
    level: float | None,
    output: Path | None,
    json_file: Path | None,
) -> None:
    """Find springs and dampers from MODES and CAR.

    MODES is the JSON of `suspid identify`, or a .toml; CAR (.toml) has the masses and the nominal struts.

    Several MODES are tests of one car, perhaps with masses added: suspid reconstruct empty.json loaded.json car.toml
    --added loaded.json:chassis=75. FILE in --added is one of the MODES, written in the same way; with one MODES,
    NAME=KG is enough.

    Ends with 3 if the car that was found does not explain the modes within their uncertainty.
    """
    from suspid.identification import read_modes, to_json
    from suspid.model import car_to_toml, read_car, read_constraints
    from suspid.reconstruction import ModalTest, reconstruct, reconstruction_to_dict

    if len({path.resolve() for path in modes}) < len(modes):
        raise click.UsageError("One of the MODES is named twice: every test counts once.")
    check_apart([*modes, car], [output, json_file])
    masses, limits, groups = added_masses(added, modes), bounds_by_name(bounds), equal_names(ties)
    with ExitStack() as outputs, said_warnings() as said:
        draft = outputs.enter_context(replacing(output)) if output else None
        json_draft = outputs.enter_context(replacing(json_file)) if json_file else None
        found = reconstruct(
            [ModalTest(modes=read_modes(path), added_masses=kg) for path, kg in zip(modes, masses, strict=True)],
            read_car(car),
            fixed=fixed,
            bounds=limits,
            ties=groups,
            nominal_std=nominal_std,
            free_masses=free_masses,
            tolerance=tolerance,
            search=not no_search,
            constraints=read_constraints(car),
        )
        text = str(found) if level is None else f"{found}\n\n{interval_table(found, level)}"
        if not found.explains:
            said.append("the car that was found does not explain these modes within their uncertainty")
        if draft:
            draft.write_text(car_to_toml(found.suspension), encoding="utf-8")
        if json_draft:
            json_draft.write_text(to_json(reconstruction_to_dict(found, level=level or 0.95)), encoding="utf-8")
    say(text)
    if not found.explains:
        click.get_current_context().exit(EXIT_UNEXPLAINED)


@main.command("modes")
@click.argument("car", type=FILE)
@click.option("--json", "json_file", type=FILE, metavar="FILE", help="Write the modes as JSON.")
def modes_command(car: Path, json_file: Path | None) -> None:
    """Show the exact modes of CAR (.toml)."""
    from suspid.identification import modes_to_dict, to_json
    from suspid.model import eigenmodes, read_car

    check_apart([car], [json_file])
    with ExitStack() as outputs:
        draft = outputs.enter_context(replacing(json_file)) if json_file else None
        modes: ModalSet = eigenmodes(read_car(car))
        if draft:
            draft.write_text(to_json(modes_to_dict(modes)), encoding="utf-8")
    say(str(modes))
