"""The command that writes a page on records: modes of decays, springs and dampers of drives and rigs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from suspid.analysis import STEPS, Analysis, Settings, analyse, check_springs, read_limits
from suspid.cli.fitting import GIVEN, fitted, tests_of
from suspid.cli.measured import MOST_FINDINGS, said_of, sources_of, writer
from suspid.cli.option_groups import Grouped
from suspid.cli.options import AT_SPEED, ON_ROAD, analysing, progress, road_named
from suspid.cli.output import check_apart, said_warnings, say
from suspid.cli.quantities import Probability
from suspid.cli.streams import CAR, FILE, JSON_FILE, RECORD
from suspid.errors import EstimationError
from suspid.files import naming, printable, replacing
from suspid.levels import LEVEL
from suspid.words import MOST_NAMED, Level, count

if TYPE_CHECKING:
    from suspid.greybox import Estimate, RecordTest
    from suspid.model import Suspension
    from suspid.performance import Ride
    from suspid.reconstruction import Reconstruction


@click.command("report", cls=Grouped)
@click.argument("files", type=RECORD, nargs=-1, required=True, metavar="FILE...")
@click.option("-o", "--output", type=FILE, metavar="FILE", required=True, help="The report to write (.html, .pdf).")
@analysing
@click.option("--car", type=CAR, metavar="CAR", help="Masses and nominal struts (.toml): springs and dampers as well.")
@GIVEN
@ON_ROAD
@AT_SPEED
@click.option("--limits", type=CAR, metavar="FILE", help="Limits of modes, springs and dampers (.toml).")
@click.option("--format", "kind", type=click.Choice(["html", "pdf"]), help="Format of the report. [that of the name]")
@click.option("--level", type=Probability(), default=LEVEL, show_default=True,
              help="Probability of the intervals.")  # fmt: skip
@click.option("--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write the contents of the report as JSON.")
@click.option("--title", metavar="TEXT", help="Title of the report. [name of the file]")
@click.option("--date", metavar="TEXT", help="Date of the report. [now]")
def report_command(
    files: tuple[Path, ...],
    output: Path,
    settings: Settings,
    car: Path | None,
    given: str,
    limits: Path | None,
    kind: str | None,
    road: str | None,
    speed: float | None,
    level: float,
    json_file: Path | None,
    title: str | None,
    date: str | None,
) -> None:
    """Write a report on the modes in FILE, its springs and dampers.

    The report is one HTML file: first the results and what to do next, then the evidence. With --car it includes the
    grip of the wheels on a test bench, with --road and --speed the ride as well.

    Several FILEs are tests of one structure: their decays are joined, and the page compares them.

    With --car, a drive in which the motion of the wheels was measured, or a rig with its road, gives a report on
    springs and dampers, and on the modes that follow from them; --given states what moved the car.
    """
    from suspid.identification import to_json
    from suspid.model import read_car, read_constraints
    from suspid.reporting import content_of, report, report_to_dict, source_of

    if (road is None) != (speed is None) or (road is not None and car is None):
        raise click.UsageError("--road and --speed go together, and need --car.")
    if given and car is None:
        raise click.UsageError("--given needs --car.")
    write = writer(output, kind)
    check_apart([*files, *filter(None, (car, limits))], [output, json_file])
    with ExitStack() as outputs, said_warnings() as said, progress(*STEPS, "drawing") as step:
        draft = outputs.enter_context(replacing(output))
        json_draft = outputs.enter_context(replacing(json_file)) if json_file else None
        suspension = None if car is None else read_car(car)
        constraints = () if car is None else read_constraints(car)
        settings = replace(settings, level=level, springs=replace(settings.springs, constraints=constraints))
        if suspension is not None:
            check_springs(settings.springs, suspension)
        found = _found(files, settings, suspension, given, said, step)
        asked = () if limits is None else read_limits(limits)
        described = None if car is None else source_of(car, text=True)
        step("drawing")
        sources = sources_of(files, date=date)
        if isinstance(found, Analysis):
            ride = _ride_of(found.estimate or found.reconstruction, road, speed)
            shown = content_of(found, source=sources, car=described, limits=asked, ride=ride)
            page, plain, judged = report(shown, title=title), report_to_dict(shown), shown.limits
            said += said_of(found, most_left_out=MOST_NAMED, most_findings=MOST_FINDINGS)
        else:
            ride = _ride_of(found, road, speed)
            content = content_of(
                found, source=sources, level=level, warnings=said, car=described, limits=asked, ride=ride
            )
            page, plain = report(content, title=title), report_to_dict(content)
            judged = content.limits
        write(page, draft)
        if json_draft:
            json_draft.write_text(to_json(plain), encoding="utf-8")
    modes = count(len(found.modes), "mode") if len(found.modes) else "no mode"
    what = modes if isinstance(found, Analysis) else f"springs, dampers and {modes}"
    say(f"{printable(str(output))}: {what} in {', '.join(printable(str(file)) for file in files)}")
    if judged is not None:
        say(str(judged))


def _found(
    files: Sequence[Path],
    settings: Settings,
    suspension: Suspension | None,
    given: str,
    said: list[str],
    step: Callable[[str], None],
) -> Analysis | Estimate:
    """Return the estimate of a car whose cause was named, or was measured and explains; else the modes of decays.

    Where the modes of decays are in doubt, springs and dampers under a measured cause that explains the whole record
    come first; where there is no mode at all, even those under one that does not.
    """
    if suspension is None:
        return _analysed(files, settings, None, step)
    heard: list[str] = []
    tests = tests_of(files, suspension, settings, [{} for _ in files], heard)
    if given:
        found = fitted(tests, suspension, given, heard, {})
        said += heard
        return found
    from suspid.greybox import likely_causes

    likely = likely_causes(tests, suspension)
    measured, first = [cause for cause in likely if cause], list(takewhile(bool, likely))
    driven, moved = _driven(tests, suspension, first) if first else (None, [])
    if driven is not None and driven.explains:
        said += [*heard, *moved]
        return driven
    analysis = _analysed(files, settings, suspension, step)
    # Sound modes that no car explains are those of decays of another car, or of several cars.
    if not measured or replace(analysis, reconstruction=None, estimate=None).verdict.level > Level.DOUBTFUL:
        return analysis
    if first != measured:
        driven, moved = _driven(tests, suspension, measured)
    if driven is None or (len(analysis.modes) and not driven.explains):
        said += [] if driven else moved
        return analysis
    said += [
        *heard,
        f"no clear free decay was found: {'; '.join(moved)}"
        + "; the car that was found does not explain these records" * (not driven.explains)
        + "; suspid drive uses the suitable stretches of a drive" * (driven.band_hz is not None),
    ]
    return driven


def _driven(
    tests: Sequence[RecordTest], suspension: Suspension, likely: Sequence[tuple[str, ...]]
) -> tuple[Estimate | None, list[str]]:
    """Return the estimate under the first of some causes that explains, and what is to be said of it.

    None where none is determined, with the reason.
    """
    moved: list[str] = []
    try:
        return fitted(tests, suspension, "", moved, {}, likely=likely), moved
    except EstimationError as error:
        return None, [str(error)]


def _analysed(
    files: Sequence[Path], settings: Settings, suspension: Suspension | None, step: Callable[[str], None]
) -> Analysis:
    if len(files) > 1:
        return analyse(list(files), car=suspension, settings=settings, progress=step)
    with naming(files[0]):
        return analyse(files[0], car=suspension, settings=settings, progress=step)


def _ride_of(car: Estimate | Reconstruction | None, road: str | None, speed: float | None) -> Ride | None:
    """Return the ride of the car that was found, if there is one and a road is asked for."""
    from suspid.performance import ride

    return None if car is None or road is None else ride(car, road=road_named(road), speed=speed)
