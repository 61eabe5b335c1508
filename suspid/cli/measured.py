"""The commands that start from a measured record: what is in a file, its modes, and the report on them."""

from __future__ import annotations

import inspect
import shlex
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import click

from suspid.analysis import LEAST_EXPLAINED
from suspid.cli.reading import FILE, STRETCH, ReadOptions, Stretch, progress, read_cleaned, reading, stretch_of
from suspid.cli.support import ARGUMENTS, Positive, angular_band, check_apart, said_warnings, say
from suspid.errors import InputError
from suspid.files import printable, replacing
from suspid.identification import Identification, Method, identify
from suspid.signals import as_signal

if TYPE_CHECKING:
    import control

    from suspid.identification import Repeats
    from suspid.model import ModalSet
    from suspid.reconstruction import Reconstruction

METHOD = inspect.signature(identify).parameters["method"].default

SETTINGS = (
    click.option(
        "--modes", type=click.IntRange(min=1), metavar="N", help="How many modes to find. [all that stand out]"
    ),
    click.option(
        "--method", type=click.Choice(get_args(Method)), default=METHOD, show_default=True, help="How to find."
    ),
    click.option(
        "--band", type=Positive("Hz"), nargs=2, metavar="LOW HIGH", help="Lowest and highest frequency to look at [Hz]."
    ),
)


@click.command("channels")
@click.argument("file", type=FILE)
@click.option("--time", "time", metavar="NAME", help="Column of time, if it is not named like one.")
@click.option("--fs", type=Positive("Hz"), metavar="HZ", help="Sampling rate, if the file does not tell it.")
@click.option("--dbc", type=FILE, metavar="FILE", help="Database that decodes the CAN frames of an MDF file.")
def channels_command(file: Path, time: str | None, fs: float | None, dbc: Path | None) -> None:
    """List the channels in FILE: names, units, rates, lengths, gaps, and what else it holds."""
    from suspid.io import read_recording

    with said_warnings():
        recording = read_recording(file, time=time, fs=fs, dbc=dbc)
    say(str(recording))


@click.command("identify")
@click.argument("file", type=FILE)
@reading(*STRETCH, *SETTINGS)
@click.option("--plot", type=FILE, metavar="FILE", help="Write pictures of the identification (.png, .svg, .pdf).")
@click.option("--json", "json_file", type=FILE, metavar="FILE", help="Write modes, uncertainty and settings as JSON.")
def identify_command(
    file: Path,
    read: ReadOptions,
    modes: int | None,
    method: Method,
    band: tuple[float, float] | None,
    start: float | None,
    stop: float | None,
    which: str,
    plot: Path | None,
    json_file: Path | None,
) -> None:
    """Find the modes in the record FILE, of any format that `suspid channels` reads."""
    from suspid.identification import identification_to_dict, modes_to_dict, to_json
    from suspid.reporting import judgement_of

    rad_band = angular_band(band)
    check_apart([file], [plot, json_file])
    with ExitStack() as outputs, said_warnings() as said, progress("reading", "finding decays", "identifying") as step:
        figure_draft = outputs.enter_context(replacing(_checked_picture(plot))) if plot else None
        json_draft = outputs.enter_context(replacing(json_file)) if json_file else None
        step()
        cleaned, notes = read_cleaned(file, read, start=start, stop=stop)
        said += notes
        step()
        stretch = stretch_of(cleaned.record, start, stop, which)
        said += stretch.said
        step()
        identification, repeats = _identified(cleaned.record, stretch, modes, method, rad_band)
        said += doubts(identification)
        if json_draft:
            content = identification_to_dict(identification, file=str(file), warnings=said)
            content |= {} if repeats is None else modes_to_dict(repeats.modes)
            json_draft.write_text(to_json(content), encoding="utf-8")
        if figure_draft:
            _draw(identification, figure_draft)
        verdict = judgement_of(
            identification, cleaned=cleaned, decays=stretch.decays, repeats=repeats, reconstruction=None, level=0.95
        )
    lines = [f"Verdict: {verdict.headline}. {verdict.said}", *(f"- {doubt}" for doubt in verdict.doubts)]
    found = repeats or identification
    say("\n\n".join([f"{printable(str(file))}: {record_in_words(stretch.record)}", str(found), "\n".join(lines)]))


@click.command("report")
@click.argument("file", type=FILE)
@click.option("-o", "--output", type=FILE, metavar="FILE", required=True, help="The page to write (.html).")
@reading(*STRETCH, *SETTINGS)
@click.option("--car", type=FILE, metavar="CAR", help="Masses and nominal struts (.toml): springs and dampers as well.")
@click.option("--level", type=click.FloatRange(0, 1, min_open=True, max_open=True), default=0.95, show_default=True,
              help="Probability of the intervals.")  # fmt: skip
@click.option("--json", "json_file", type=FILE, metavar="FILE", help="Write all that the page shows as JSON.")
@click.option("--title", metavar="TEXT", help="Heading of the page. [name of the file]")
@click.option("--date", metavar="TEXT", help="Date on the page. [now]")
def report_command(
    file: Path,
    output: Path,
    read: ReadOptions,
    modes: int | None,
    method: Method,
    band: tuple[float, float] | None,
    start: float | None,
    stop: float | None,
    which: str,
    car: Path | None,
    level: float,
    json_file: Path | None,
    title: str | None,
    date: str | None,
) -> None:
    """Write a page on the modes in FILE: one HTML file to print or to send, with all that the result rests on."""
    from suspid.identification import to_json
    from suspid.reporting import drawable, report, report_to_dict, source_of

    rad_band = angular_band(band)
    if output.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{printable(str(output))}: reports are written as .html; choose such a name")
    check_apart([file, *([car] if car else [])], [output, json_file])
    created = date or datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    steps = ("reading", "finding decays", "identifying", "reconstructing", "drawing")
    with ExitStack() as outputs, said_warnings() as said, progress(*steps) as step:
        draft = outputs.enter_context(replacing(output))
        json_draft = outputs.enter_context(replacing(json_file)) if json_file else None
        step()
        cleaned, notes = read_cleaned(file, read, start=start, stop=stop)
        source = source_of(file, command=_command_line(), created=created)
        step()
        stretch = stretch_of(cleaned.record, start, stop, which)
        step()
        identification, repeats = _identified(cleaned.record, stretch, modes, method, rad_band)
        identification = drawable(identification)
        step()
        found, why = _springs(identification.modes if repeats is None else repeats.modes, car)
        step()
        # What was cleaned and which decay was taken has its own place on the page.
        warnings = [*why, *(note for note in notes if note.startswith("in the file: "))]
        page = report(
            identification,
            source=source,
            cleaned=cleaned,
            decays=stretch.decays,
            repeats=repeats,
            reconstruction=found,
            level=level,
            warnings=warnings,
            title=title,
        )
        draft.write_text(page, encoding="utf-8")
        if json_draft:
            content = report_to_dict(
                identification,
                source=source,
                cleaned=cleaned,
                decays=stretch.decays,
                repeats=repeats,
                reconstruction=found,
                level=level,
                warnings=warnings,
            )
            json_draft.write_text(to_json(content), encoding="utf-8")
        said += [*notes, *stretch.said, *why, *doubts(identification)]
    modes_found = identification.modes if repeats is None else repeats.modes
    say(f"{printable(str(output))}: {_modes_in_words(modes_found)} in {printable(str(file))}")


def _identified(
    record: control.TimeResponseData,
    stretch: Stretch,
    modes: int | None,
    method: Method,
    band: tuple[float, float] | None,
) -> tuple[Identification, Repeats | None]:
    """Return the identification of the decay and, where several are used, that of all jointly."""
    from suspid.identification import identify_repeats

    if len(stretch.used) < 2:
        return identify(stretch.record, modes=modes, method=method, band=band), None
    if method != "likelihood":
        raise click.UsageError(f"--decay all joins decays by their likelihood; --method {method} takes one at a time.")
    repeats = identify_repeats(record, stretch.used, modes=modes, band=band)
    return repeats.each[0], repeats


def _springs(modes: ModalSet, car: Path | None) -> tuple[Reconstruction | None, list[str]]:
    """Return springs and dampers, or why there are none."""
    from suspid.errors import InputError, ReconstructionError
    from suspid.model import read_car
    from suspid.reconstruction import reconstruct

    if car is None:
        return None, []
    suspension = read_car(car)
    try:
        return reconstruct(modes, suspension), []
    except (ReconstructionError, InputError) as error:
        return None, [f"springs and dampers were not found: {error}"]


def _command_line() -> str:
    arguments = click.get_current_context().meta.get(ARGUMENTS, [])
    return shlex.join(["suspid", *arguments])


def doubts(identification: Identification) -> list[str]:
    """Return what makes the modes hardly those of the record."""
    channels = as_signal(identification.residual).channels
    unexplained = [
        f"the modes explain only {100 * share:.0f} % of channel {name!r}"
        for name, share in zip(channels, identification.explained, strict=True)
        if share < LEAST_EXPLAINED
    ]
    modes = identification.modes
    growing = [f"mode {k} ({wn:.4g} rad/s) grows" for k, wn in enumerate(modes.wn, 1) if modes.poles[k - 1].real > 0]
    return unexplained + growing


def _modes_in_words(modes: ModalSet) -> str:
    count = len(modes)
    return "no mode" if not count else f"{count} mode{'s' * (count > 1)}"


def record_in_words(record: control.TimeResponseData) -> str:
    """Return length, rate, start and channels of a record in one line."""
    signal = as_signal(record)
    # What is rounding beside a sampling step is nought.
    start = signal.start if abs(signal.start) > 1e-9 * signal.step else 0.0
    names = ", ".join(signal.channels[:6]) + (", …" if len(signal.channels) > 6 else "")
    return (
        f"{signal.values.shape[1]} samples at {1 / signal.step:.6g} Hz from t = {start:.6g} s, "
        f"{len(signal.channels)} channel{'s' * (len(signal.channels) > 1)}: {names}"
    )


def _checked_picture(path: Path) -> Path:
    """Return the path, if its suffix is a kind of picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    known = sorted(FigureCanvasAgg.filetypes)
    if path.suffix[1:].lower() not in known:
        raise InputError(
            f"{printable(str(path))}: pictures of type {path.suffix!r} are not known; known: {', '.join(known)}"
        )
    return path


def _draw(identification: Identification, draft: Path) -> None:
    from matplotlib.figure import Figure

    from suspid.reporting import PAGE, plot_identification

    figure = Figure(figsize=PAGE, layout="constrained")
    plot_identification(identification, figure)
    figure.savefig(draft, format=draft.suffix[1:].lower(), dpi=120)
