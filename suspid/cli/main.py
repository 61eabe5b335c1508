"""The command ``suspid``: from a record to modes, from modes to springs and dampers, and back to a record.

It ends with 0 if all went well, with 1 and one line on stderr if `suspid` refuses, with 2 if the command line is
wrong, and with 3 if a car was found and written, but does not explain the modes within their uncertainty.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from suspid.cli.commands import Commands
from suspid.cli.compare import compare_command
from suspid.cli.drive import drive_command
from suspid.cli.estimate import estimate_command
from suspid.cli.fleet import fleet_command
from suspid.cli.grip import grip_command
from suspid.cli.measured import channels_command, identify_command
from suspid.cli.options import LINEARISE
from suspid.cli.output import check_apart, said_warnings, say, shown
from suspid.cli.parameters import Outputs, Wanted, conclude, wanting, writing
from suspid.cli.quantities import Positive
from suspid.cli.report import report_command
from suspid.cli.ridden import OF_CARS, made_linear
from suspid.cli.ride import ride_command
from suspid.cli.simulate import simulate_command
from suspid.cli.streams import CAR, FOUND, JSON_FILE
from suspid.cli.tune import tune_command
from suspid.errors import InputError
from suspid.files import printable, real_path
from suspid.words.ride import dampers_of_equal_work

if TYPE_CHECKING:
    from suspid.model import ModalSet, Suspension


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="suspid", message="suspid %(version)s")
def main() -> None:
    """Find the modes of a suspension in its measured free decay, and its springs and dampers from its modes.

    In place of a file that is read, - is the standard input. In place of a JSON, a car or a simulated record that is
    written, - is the standard output; the text of the result then goes to the standard error.

    Exit codes: 0 done, also where no mode was found; 1 refused, with one line that says why; 2 the command line is
    wrong; 3 a car was found that does not explain the modes; 130 stopped by Ctrl-C, 143 by SIGTERM.
    """


main.add_command(channels_command)
main.add_command(identify_command)
main.add_command(report_command)
main.add_command(estimate_command)
main.add_command(compare_command)
main.add_command(drive_command)
main.add_command(fleet_command)
main.add_command(simulate_command)
main.add_command(ride_command)
main.add_command(grip_command)
main.add_command(tune_command)


@main.command("reconstruct")
@click.argument("modes", type=FOUND, nargs=-1, metavar="MODES...")
@click.argument("car", type=CAR)
@wanting
@click.option("--tolerance", type=Positive("share"), metavar="SHARE", help="Largest relative error of a pole. [0.02]")
@LINEARISE
@click.option("--no-search", is_flag=True, help="Start from the nominal car only, without a search for alternatives.")
@writing
def reconstruct_command(
    modes: tuple[Path, ...],
    car: Path,
    wanted: Wanted,
    tolerance: float | None,
    linearise: float | None,
    no_search: bool,
    outputs: Outputs,
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

    if not modes:
        # One file alone is taken for the last argument.
        one = shown(str(car))
        both = f"modes.json {one}" if car.suffix.lower() == ".toml" else f"{one} car.toml"
        raise click.UsageError(f"MODES and CAR are needed: suspid reconstruct {both}")
    if car.suffix.lower() == ".json" and modes[0].suffix.lower() == ".toml":
        raise click.UsageError(
            f"MODES come first and CAR last: suspid reconstruct {shown(str(car))} {shown(str(modes[0]))}"
        )
    if len({real_path(path) for path in modes}) < len(modes):
        raise click.UsageError("One of the MODES is named twice: name each once.")
    check_apart([*modes, car], [outputs.output, outputs.json_file])
    masses, unknowns = wanted.added_masses(modes), wanted.unknowns()
    with outputs.drafts() as (draft, json_draft), said_warnings() as said:
        nominal, dampers = made_linear(read_car(car), linearise, said)
        if dampers:
            said.append(f"the nominal car: {dampers_of_equal_work(dampers)}")
        found = reconstruct(
            [ModalTest(modes=read_modes(path), added_masses=kg) for path, kg in zip(modes, masses, strict=True)],
            nominal,
            **unknowns,
            tolerance=tolerance,
            search=not no_search,
            constraints=read_constraints(car),
        )
        text = outputs.words(found)
        if not found.explains:
            said.append("the car that was found does not explain these modes within their uncertainty")
        if draft:
            draft.write_text(car_to_toml(found.suspension), encoding="utf-8")
        if json_draft:
            content = reconstruction_to_dict(found, level=outputs.probability)
            json_draft.write_text(to_json(content), encoding="utf-8")
    conclude(text, explains=found.explains)


def described_car(source: Path) -> Suspension:
    """Return the car that a file describes; of a record say which command finds its modes.

    Raises
    ------
    InputError
        If the file describes no car.
    """
    from suspid.model import read_car

    try:
        return read_car(source)
    except InputError:
        if source.suffix.lower() in OF_CARS or not source.is_file():
            raise
        error = InputError(
            "is no description of a car (.toml, as examples/car.toml); `suspid identify` finds the modes of a record"
        )
        raise error.about(printable(str(source))) from None


@main.command("modes")
@click.argument("car", type=CAR)
@LINEARISE
@click.option("--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write the modes as JSON.")
def modes_command(car: Path, linearise: float | None, json_file: Path | None) -> None:
    """Show the exact modes of CAR (.toml)."""
    from suspid.identification import write_modes
    from suspid.model import eigenmodes

    check_apart([car], [json_file])
    with said_warnings() as said:
        modes: ModalSet = eigenmodes(made_linear(described_car(car), linearise, said)[0])
    if json_file:
        write_modes(modes, json_file)
    say(str(modes))
