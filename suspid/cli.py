"""The command ``suspid``: from a record to modes, from modes to springs and dampers, and back to a record.

It ends with 0 if all went well, with 1 and one line on stderr if `suspid` refuses, with 2 if the command line is
wrong, and with 3 if a car was found and written, but does not explain the modes within their uncertainty.
"""

from __future__ import annotations

import inspect
import math
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import click
import numpy as np

from suspid.cli_support import (
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
from suspid.errors import InputError
from suspid.files import printable, replacing
from suspid.identification import Identification, Method, identify
from suspid.signals import as_signal, cut

if TYPE_CHECKING:
    import control

    from suspid.modes import ModalSet

METHOD = inspect.signature(identify).parameters["method"].default
FILE = click.Path(path_type=Path)
MOST_SAMPLES = 50_000_000
# Below this share of a channel's energy, the modes are hardly those of the record.
LEAST_EXPLAINED = 0.5
LEVEL = 0.95
UNEXPLAINED = 3


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="suspid", message="suspid %(version)s")
def main() -> None:
    """Find the modes of a suspension in its measured free decay, and its springs and dampers from its modes."""


@main.command("identify")
@click.argument("file", type=FILE)
@click.option("--channel", "channels", metavar="NAME", multiple=True, help="Channel to use; may be given again. [all]")
@click.option("--time", "time", metavar="NAME", help="Column of time, if it is not named like one.")
@click.option(
    "--fs", type=Positive("Hz"), metavar="HZ", help="Sampling rate; it must agree with the column of time, if any."
)
@click.option("--modes", type=click.IntRange(min=1), metavar="N", help="How many modes to find. [all that stand out]")
@click.option("--method", type=click.Choice(get_args(Method)), default=METHOD, show_default=True, help="How to find.")
@click.option(
    "--band", type=Positive("Hz"), nargs=2, metavar="LOW HIGH", help="Lowest and highest frequency to look at [Hz]."
)
@click.option("--from", "start", type=float, metavar="SECONDS", help="Time at which the decay begins.")
@click.option("--to", "stop", type=float, metavar="SECONDS", help="Last time to use.")
@click.option("--plot", type=FILE, metavar="FILE", help="Write pictures of the identification (.png, .svg, .pdf).")
@click.option("--json", "json_file", type=FILE, metavar="FILE", help="Write modes, uncertainty and settings as JSON.")
def identify_command(
    file: Path,
    channels: tuple[str, ...],
    time: str | None,
    fs: float | None,
    modes: int | None,
    method: Method,
    band: tuple[float, float] | None,
    start: float | None,
    stop: float | None,
    plot: Path | None,
    json_file: Path | None,
) -> None:
    """Find the modes in the record FILE (.csv, .txt, .tsv or .mat), a free decay."""
    from suspid.modal_json import identification_to_dict, to_json
    from suspid.records import read_record

    if band and not band[0] < band[1]:
        raise click.BadParameter(f"{band[0]:g} Hz is not below {band[1]:g} Hz.", param_hint="'--band'")
    check_apart([file], [plot, json_file])
    with ExitStack() as outputs, said_warnings() as said:
        figure_draft = outputs.enter_context(replacing(_checked_picture(plot))) if plot else None
        json_draft = outputs.enter_context(replacing(json_file)) if json_file else None
        record = read_record(file, channels=channels or None, time=time, fs=fs)
        if start is not None or stop is not None:
            record = cut(record, start=start, stop=stop)
        rad_band = (2 * math.pi * band[0], 2 * math.pi * band[1]) if band else None
        identification = identify(record, modes=modes, method=method, band=rad_band)
        said += _doubts(identification)
        if json_draft:
            content = identification_to_dict(identification, file=str(file), warnings=said)
            json_draft.write_text(to_json(content), encoding="utf-8")
        if figure_draft:
            _draw(identification, figure_draft)
    say(f"{printable(str(file))}: {_record_in_words(record)}\n\n{identification}")


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
    "--nominal-std", type=Positive("share"), metavar="SHARE", help="Trust the nominal values to this, as 0.3."
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
    """Find springs and dampers from MODES (JSON of identify, or .toml) and the masses and nominal struts of CAR.

    Several MODES are tests of one car, perhaps with masses added: suspid reconstruct empty.json loaded.json car.toml
    --added loaded.json:chassis=75. FILE is written as among the MODES; if there is one, NAME=KG will do.

    Ends with 3 if the car that was found does not explain the modes within their uncertainty.
    """
    from suspid.car_json import reconstruction_to_dict
    from suspid.cars import car_to_toml, read_car
    from suspid.modal_json import read_modes, to_json
    from suspid.observations import ModalTest
    from suspid.reconstruction import reconstruct

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
        )
        text = str(found) if level is None else f"{found}\n\n{interval_table(found, level)}"
        if not found.explains:
            said.append("the car that was found does not explain these modes within their uncertainty")
        if draft:
            draft.write_text(car_to_toml(found.suspension), encoding="utf-8")
        if json_draft:
            json_draft.write_text(to_json(reconstruction_to_dict(found, level=level or LEVEL)), encoding="utf-8")
    say(text)
    if not found.explains:
        click.get_current_context().exit(UNEXPLAINED)


@main.command("simulate")
@click.argument("car", type=FILE)
@click.option("-o", "--output", type=FILE, metavar="FILE", required=True, help="The record to write (.csv).")
@click.option("--fs", type=Positive("Hz"), default=500.0, show_default=True, help="Sampling rate.")
@click.option("--duration", type=Positive("s"), default=10.0, show_default=True, help="Length of the record.")
@click.option("--impulse", metavar="INPUT", help="Input that gets a unit impulse, such as road.")
@click.option("--initial", metavar="STATE=VALUE", multiple=True, help="Start, such as v_tire=1 [m/s]; repeat.")
@click.option("--channel", "channels", metavar="NAME", multiple=True, help="Output; repeat. [all displacements]")
@click.option("--snr", type=float, metavar="dB", help="Add white noise at this ratio to every channel.")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the noise; needed with --snr.")
@click.option("--digits", type=click.IntRange(1, 17), help="Significant digits of the samples. [every bit]")
def simulate_command(
    car: Path,
    output: Path,
    fs: float,
    duration: float,
    impulse: str | None,
    initial: tuple[str, ...],
    channels: tuple[str, ...],
    snr: float | None,
    seed: int | None,
    digits: int | None,
) -> None:
    """Write the free decay of CAR (.toml) as a record."""
    from suspid.cars import read_car
    from suspid.modes import eigenmodes
    from suspid.records import check_record_name, write_record
    from suspid.simulation import add_noise, free_decay
    from suspid.suspension import statespace

    if (impulse is None) == (not initial):
        raise click.UsageError("Give either --impulse or --initial.")
    if (snr is None) != (seed is None):
        raise click.UsageError("Give --snr and --seed together: the same seed makes the same noise.")
    count = round(fs * duration) if fs * duration <= MOST_SAMPLES else 0
    if count < 2:
        raise click.UsageError(f"{fs:g} Hz for {duration:g} s must be between 2 and {MOST_SAMPLES} samples.")
    state = _initial_state(initial)
    check_record_name(output)
    check_apart([car], [output])
    with replacing(output) as draft, said_warnings() as said:
        suspension = read_car(car)
        system = statespace(suspension, outputs=channels or None)
        timepts = np.arange(count) / fs
        record = free_decay(system, timepts, initial_state=state or None, impulse=impulse)
        if snr is not None:
            record = add_noise(record, snr_db=snr, rng=np.random.default_rng(seed))
        highest = float(np.max(np.abs(eigenmodes(suspension).poles.imag), initial=0.0)) / (2 * math.pi)
        if highest >= fs / 2:
            said.append(f"a mode at {highest:.4g} Hz lies above half the sampling rate and is aliased")
        write_record(record, draft, digits=digits)
    say(f"{printable(str(output))}: {_record_in_words(record)}")


@main.command("modes")
@click.argument("car", type=FILE)
@click.option("--json", "json_file", type=FILE, metavar="FILE", help="Write the modes as JSON.")
def modes_command(car: Path, json_file: Path | None) -> None:
    """Show the exact modes of CAR (.toml)."""
    from suspid.cars import read_car
    from suspid.modal_json import modes_to_dict, to_json
    from suspid.modes import eigenmodes

    check_apart([car], [json_file])
    with ExitStack() as outputs:
        draft = outputs.enter_context(replacing(json_file)) if json_file else None
        modes: ModalSet = eigenmodes(read_car(car))
        if draft:
            draft.write_text(to_json(modes_to_dict(modes)), encoding="utf-8")
    say(str(modes))


def _initial_state(given: tuple[str, ...]) -> dict[str, float]:
    state: dict[str, float] = {}
    for text in given:
        name, equals, value = text.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            equals = ""
        if not equals or not name or name in state:
            raise click.BadParameter(f"{text!r}: write STATE=VALUE, each state once.", param_hint="'--initial'")
        state[name] = number
    return state


def _doubts(identification: Identification) -> list[str]:
    channels = as_signal(identification.residual).channels
    doubts = [
        f"the modes explain only {100 * share:.0f} % of channel {name!r}"
        for name, share in zip(channels, identification.explained, strict=True)
        if share < LEAST_EXPLAINED
    ]
    modes = identification.modes
    growing = [f"mode {k} ({wn:.4g} rad/s) grows" for k, wn in enumerate(modes.wn, 1) if modes.poles[k - 1].real > 0]
    return doubts + growing


def _record_in_words(record: control.TimeResponseData) -> str:
    signal = as_signal(record)
    names = ", ".join(signal.channels[:6]) + (", …" if len(signal.channels) > 6 else "")
    return (
        f"{signal.values.shape[1]} samples at {1 / signal.step:.6g} Hz from t = {signal.start:.6g} s, "
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

    from suspid.plots import PAGE, plot_identification

    figure = Figure(figsize=PAGE, layout="constrained")
    plot_identification(identification, figure)
    figure.savefig(draft, format=draft.suffix[1:].lower(), dpi=120)
