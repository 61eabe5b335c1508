"""Common parts of the commands that find stiffness and damping: options, files written, exit codes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from suspid.cli.named_values import names_in, pairs
from suspid.cli.option_names import in_options
from suspid.cli.options import Decorator, packed
from suspid.cli.output import say
from suspid.cli.quantities import Positive, Probability
from suspid.cli.streams import CAR_FILE, JSON_FILE
from suspid.files import replacing
from suspid.levels import LEVEL
from suspid.simulation import ROUGHNESS

if TYPE_CHECKING:
    from suspid.greybox import Estimate
    from suspid.reconstruction import Reconstruction

# Exit code if a car was found and written, but does not explain the data.
EXIT_UNEXPLAINED = 3


@dataclass(frozen=True, kw_only=True, slots=True)
class Wanted:
    """What is asked for and known beforehand, as the options say it."""

    added: tuple[str, ...]
    fixed: tuple[str, ...]
    bounds: tuple[tuple[str, float, float], ...]
    ties: tuple[str, ...]
    nominal_std: float | None
    free_masses: tuple[str, ...]

    def unknowns(self) -> dict[str, Any]:
        """Return arguments of `reconstruct` and `estimate`, or refuse the options as a usage error."""
        return {
            "fixed": names_in(self.fixed),
            "bounds": bounds_by_name(self.bounds),
            "ties": _equal_names(self.ties),
            "nominal_std": self.nominal_std,
            "free_masses": names_in(self.free_masses),
        }

    def added_masses(self, files: Sequence[Path]) -> list[dict[str, float]]:
        """Return the masses [kg] added in the test of each file, from texts as ``FILE:NAME=KG``."""
        tests: list[dict[str, float]] = [{} for _ in files]
        for text in self.added:
            left, equals, value = text.rpartition("=")
            file, colon, name = left.rpartition(":")
            try:
                mass = float(value)
            except ValueError:
                equals = ""
            if not equals or not name or not (colon or len(files) == 1):
                raise click.BadParameter(f"{text!r}: write FILE:NAME=KG.", param_hint="'--added'")
            if colon and Path(file) not in files:
                known = ", ".join(str(path) for path in files)
                raise click.BadParameter(
                    f"{text!r}: {file!r} is not one of the MODES, {known}.", param_hint="'--added'"
                )
            masses = tests[files.index(Path(file)) if colon else 0]
            if name in masses:
                raise click.BadParameter(f"{text!r}: {name!r} already has a mass there.", param_hint="'--added'")
            masses[name] = mass
        return tests


wanting: Decorator = packed(
    Wanted,
    (
        click.option(
            "--added", metavar="FILE:NAME=KG", multiple=True, help="Mass added at NAME in the test FILE; repeat."
        ),
        click.option(
            "--fixed",
            metavar="STRUT[.stiffness|.damping]",
            multiple=True,
            help="Fix at the nominal value; repeat, or NAME,NAME.",
        ),
        click.option(
            "--bound",
            "bounds",
            type=(str, float, float),
            metavar="NAME LOW HIGH",
            multiple=True,
            help="Smallest and largest value of a parameter such as tire.stiffness; 0 and inf: no bound; repeat.",
        ),
        click.option("--tie", "ties", metavar="A=B", multiple=True, help="Parameters that are equal; repeat."),
        click.option(
            "--nominal-std",
            type=Positive("share"),
            metavar="SHARE",
            help="Relative standard deviation of the nominal values, such as 0.3.",
        ),
        click.option(
            "--free-mass",
            "free_masses",
            metavar="NAME",
            multiple=True,
            help="Mass to estimate as well; repeat, or NAME,NAME.",
        ),
    ),
    "wanted",
)


class RoadModel(click.Choice[str]):
    """A model of the road; the class of a road is not one."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name of the model."""
        if str(value).upper() in ROUGHNESS:
            self.fail(f"{value!r} is a class; the class is estimated here: write --road iso8608.", param, ctx)
        return super().convert(value, param, ctx)


ROAD_MODEL = click.option(
    "--road", type=RoadModel(["iso8608"]), help="Model of the road: tires and whole car too. [none]"
)
WHEEL_RADIUS = click.option("--wheel-radius", type=Positive("m"), help="Rolling radius of the wheels, for --road.")

BEHIND = click.option(
    "--behind", metavar="ROAD=OTHER:METRES", multiple=True, help="ROAD follows OTHER METRES later. [independent]"
)


def led_by(behind: Sequence[str]) -> dict[str, tuple[str, float]]:
    """Return which road follows which, and how far behind [m].

    Examples
    --------
    >>> led_by(["road_rear=road_front:2.7"])
    {'road_rear': ('road_front', 2.7)}
    """
    found = {}
    for name, led in pairs(behind, "--behind", str).items():
        other, _, metres = led.rpartition(":")
        try:
            found[name] = other, float(metres)
        except ValueError:
            raise click.BadParameter(
                f"'{name}={led}': write ROAD=OTHER:METRES, such as road_rear=road_front:2.7.", param_hint="'--behind'"
            ) from None
    return found


@dataclass(frozen=True, kw_only=True, slots=True)
class Outputs:
    """What to write of a car that was found."""

    level: float | None
    output: Path | None
    json_file: Path | None

    @property
    def probability(self) -> float:
        """Probability of the intervals in files and pictures [1]."""
        return self.level or LEVEL

    @contextmanager
    def drafts(self) -> Iterator[tuple[Path | None, Path | None]]:
        """Give drafts of the car and the JSON, which replace the files at the end."""
        with ExitStack() as stack:
            yield (
                stack.enter_context(replacing(self.output)) if self.output else None,
                stack.enter_context(replacing(self.json_file)) if self.json_file else None,
            )

    def words(self, found: Reconstruction | Estimate | None, whole: object = None) -> str:
        """Return what was found as text, or the whole that it is a part of, or refuse intervals that there are not."""
        with in_options():
            said = str(found if whole is None else whole)
        return said if self.level is None or found is None else f"{said}\n\n{_interval_table(found, self.level)}"


def conclude(text: str, *, explains: bool) -> None:
    """Print the result; end with `EXIT_UNEXPLAINED` where it does not explain what it was found from."""
    say(text)
    if not explains:
        click.get_current_context().exit(EXIT_UNEXPLAINED)


writing: Decorator = packed(
    Outputs,
    (
        click.option(
            "--level",
            type=Probability(),
            help="Print intervals of this probability, such as 0.95.",
        ),
        click.option("-o", "--output", type=CAR_FILE, metavar="FILE", help="Write the car that was found as TOML."),
        click.option(
            "--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write parameters and uncertainty as JSON."
        ),
    ),
    "outputs",
)


def bounds_by_name(given: Sequence[tuple[str, float, float]]) -> dict[str, tuple[float, float]]:
    """Return the bounds by parameter, each given once."""
    bounds: dict[str, tuple[float, float]] = {}
    for name, low, high in given:
        if name in bounds:
            raise click.BadParameter(f"{name!r} already has bounds.", param_hint="'--bound'")
        bounds[name] = (low, high)
    return bounds


def _equal_names(given: Sequence[str]) -> list[list[str]]:
    """Return the names in each text as ``A=B``."""
    groups = [[name.strip() for name in text.split("=")] for text in given]
    for text, names in zip(given, groups, strict=True):
        if len(names) < 2 or not all(names):
            raise click.BadParameter(f"{text!r}: write A=B, two parameters or more.", param_hint="'--tie'")
    return groups


def _interval_table(found: Reconstruction | Estimate, level: float) -> str:
    """Return the table of the lower and the upper end of every parameter, with units."""
    from suspid.greybox import parameter_unit
    from suspid.text_tables import text_table

    ends = found.interval(level)
    return text_table(
        {
            f"{100 * level:g} % interval": [f"{name} [{parameter_unit(name)}]" for name in ends],
            "lower": [f"{low:.7g}" for low, _ in ends.values()],
            "upper": [f"{high:.7g}" for _, high in ends.values()],
        }
    )
