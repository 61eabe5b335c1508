"""The commands on a measured record: list its channels, identify its modes."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from suspid.analysis import STEPS, Analysis, Settings, analyse
from suspid.cli.commands import ARGUMENTS
from suspid.cli.option_groups import Grouped
from suspid.cli.options import DBC_OPTION, FS_OPTION, TIME_OPTION, analysing, progress
from suspid.cli.output import check_apart, in_the_file, said_warnings, say, shown
from suspid.cli.streams import FILE, JSON_FILE, RECORD
from suspid.errors import InputError, SuspidError
from suspid.files import naming, printable, replacing
from suspid.samples import held
from suspid.signals import as_signal
from suspid.values import samples_in_words
from suspid.words import ASIDE, DAMAGE, MOST_NAMED, OTHER_LENGTHS, NextStep, Note, Remark, count

if TYPE_CHECKING:
    import control
    from matplotlib.figure import Figure

    from suspid.reporting import Source

# Findings of the cleaning that are warned of; the report lists all.
MOST_FINDINGS = 5


@click.command("channels", cls=Grouped)
@click.argument("file", type=RECORD)
@TIME_OPTION
@FS_OPTION
@DBC_OPTION
def channels_command(file: Path, time: str | None, fs: float | None, dbc: Path | None) -> None:
    """List the channels in FILE.

    The list has names, units, rates, lengths and gaps, and names the other contents of the file.
    """
    from suspid.io import read_recording

    with said_warnings():
        recording = read_recording(file, time=time, fs=fs, dbc=dbc)
    say(str(recording))


@click.command("identify", cls=Grouped)
@click.argument("files", type=RECORD, nargs=-1, required=True, metavar="FILE...")
@analysing
@click.option("--plot", type=FILE, metavar="FILE", help="Write pictures of the identification (.png, .svg, .pdf).")
@click.option(
    "--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write modes, uncertainty and settings as JSON."
)
def identify_command(files: tuple[Path, ...], settings: Settings, plot: Path | None, json_file: Path | None) -> None:
    """Find the modes in the record FILE.

    FILE has any format that `suspid channels` reads; - is the standard input. The exit code is 0 even if no mode is
    found.

    Several FILEs are tests of one structure: their decays are joined.
    """
    from suspid.identification import to_json
    from suspid.reporting import plot_identification

    check_apart(list(files), [plot, json_file])
    if plot and len(files) > 1:
        raise click.UsageError("--plot takes one record: name one FILE, or write a page of several with suspid report.")
    with ExitStack() as outputs, said_warnings() as said, progress(*STEPS[:3]) as step:
        figure_draft = outputs.enter_context(replacing(checked_picture(plot))) if plot else None
        json_draft = outputs.enter_context(replacing(json_file)) if json_file else None
        if len(files) > 1:
            found = analyse(list(files), settings=settings, progress=step)
        else:
            with naming(files[0]):
                found = analyse(files[0], settings=settings, progress=step)
        used, tests = _tests_of(found)
        if tests and (plot or json_file):
            raise InputError(
                f"contains {len(tests) + 1} tests: choose one with --test, such as --test {shlex.quote(used)}, or join "
                f"them with --test all"
            ).about(printable(str(files[0])))
        if tests:
            found = replace(found, notes=tuple(note for note in found.notes if note.code is not Note.ONE_OF_TESTS))
        if json_draft:
            json_draft.write_text(to_json(_json_of(found, files, said)), encoding="utf-8")
        if figure_draft:
            page = partial(plot_identification, found.identification, title=files[0].name, verdict=found.verdict)
            save_picture(partial(page, units=found.units), figure_draft)
        said += said_of(found, most_left_out=MOST_NAMED, most_findings=MOST_FINDINGS)
    if tests:
        say(f"{printable(str(files[0]))}: {len(tests) + 1} tests, one after the other; --test chooses one\n")
    say(_in_words(files, found))
    for test in tests:
        _say_test(files[0], test, settings)


def _say_test(file: Path, test: str, settings: Settings) -> None:
    """Say what is found in another test of a file as soon as it is: the next one may take long, or be refused."""
    with said_warnings() as said, progress(*STEPS[:3]) as step:
        try:
            found = analyse(file, settings=replace(settings, test=test), progress=step)
        except SuspidError as refusal:
            words = f"test {test!r}: {refusal}"
        else:
            words = _in_words([file], found)
            # What is no channel of the file was said with the first test.
            notes = said_of(found, most_left_out=0, most_findings=MOST_FINDINGS)
            said += [note for note in notes if not note.startswith("in the file: ")]
    say(f"\n{words}")


def _tests_of(found: Analysis) -> tuple[str, list[str]]:
    """Return the test that was used because none was chosen, and the others in the file; none if it is alone."""
    for note in found.notes:
        names = note.numbers["tests"] if note.code is Note.ONE_OF_TESTS else ()
        if isinstance(names, tuple) and names:
            used = note.numbers["used"]
            return str(used), [str(name) for name in names if name != used]
    return "", []


def _in_words(files: Sequence[Path], found: Analysis) -> str:
    """Return what was found, below a line on each record."""
    tests = list(found.tests.values()) or [found]
    names = [printable(str(file)) for file in files] if len(tests) == len(files) else list(found.tests)
    lines = [
        f"{name}: {record_in_words(held(test.identification, 'response'))}"
        for name, test in zip(names, tests, strict=True)
    ]
    # Without a mode, what is needed is another record; with one, the doubts say what to do.
    step = [] if len(found.modes) else [f"Next: {Remark(NextStep.RECORD_A_DECAY)}"]
    return "\n".join([*lines, "", str(found), *step])


def _json_of(found: Analysis, files: Sequence[Path], said: Sequence[str]) -> dict[str, object]:
    """Return an analysis for JSON; that of several files has the joint modes, and each file as one of its tests."""
    from suspid.identification import identification_to_dict, modes_to_dict, repeats_to_dict

    if not found.tests:
        warnings = [shown(line) for line in (*said, *said_of(found))]
        content = identification_to_dict(found.identification, file=shown(str(files[0])), warnings=warnings)
        content |= {} if found.repeats is None else repeats_to_dict(found.repeats)
    else:
        tests = [
            identification_to_dict(test.identification, file=shown(file), warnings=said_of(test))
            for file, test in zip(map(str, files) if len(files) > 1 else found.tests, found.tests.values(), strict=True)
        ]
        joint = modes_to_dict(found.modes) if found.repeats is None else repeats_to_dict(found.repeats)
        content = {**joint, "tests": tests, "warnings": [*said, *map(str, found.notes)]}
    return {**content, "verdict": found.verdict.to_dict()}


def said_of(found: Analysis, *, most_left_out: int | None = None, most_findings: int | None = None) -> list[str]:
    """Return what was left out, repaired and done on the way, a sentence each; what is beyond the most is counted.

    Columns that a selection of channels leaves out are not mentioned, damage is.
    """
    if found.tests:
        said = [
            f"{name}: {line}"
            for name, test in found.tests.items()
            for line in said_of(test, most_left_out=most_left_out, most_findings=most_findings)
        ]
        return [*said, *map(str, found.notes)]
    everything = () if found.recording is None else found.recording.left_out
    selected = found.settings.channels is not None
    told = [(name, why) for name, why in everything if why.code not in ASIDE]
    left_out = _without_tables([(name, why) for name, why in told if not selected or why.code in DAMAGE])
    said = [in_the_file(name, why) for name, why in left_out[:most_left_out]]
    if len(left_out) > len(said):
        said.append(f"in the file: {len(left_out) - len(said)} more not used as channels; see `suspid channels`")
    findings = found.cleaned.findings
    shown = [str(finding) for finding in findings[:most_findings]]
    if len(findings) > len(shown):
        shown.append(f"{count(len(findings) - len(shown), 'further finding')}; `suspid report` lists all")
    # The doubts about a decay are part of the verdict.
    return [*said, *shown, *(str(note) for note in found.notes if note.code is not Note.DECAY_DOUBT)]


def _without_tables(left_out: Sequence[tuple[str, Remark]]) -> list[tuple[str, Remark]]:
    """Return what was left out but columns of another length that several have: tables beside that of the record."""
    lengths = Counter(why.numbers["samples"] for _, why in left_out if why.code in OTHER_LENGTHS)
    return [
        (name, why) for name, why in left_out if why.code not in OTHER_LENGTHS or lengths[why.numbers["samples"]] == 1
    ]


def record_in_words(record: control.TimeResponseData) -> str:
    """Return length, rate, start and channels of a record in one line."""
    signal = as_signal(record)
    return samples_in_words(signal.timepts, signal.channels)


def checked_page(path: Path) -> Path:
    """Return the path, if it is one of an HTML file."""
    if path.suffix.lower() not in (".html", ".htm"):
        raise InputError("reports are written as .html or .pdf; choose such a name").about(printable(str(path)))
    return path


def writer(path: Path, kind: str | None) -> Callable[[str, Path], None]:
    """Return how a page is written, by the kind that is asked for or by the suffix of the file."""
    from suspid.reporting import browser, write_pdf

    suffix = path.suffix.lower()
    if (kind or "pdf") == "pdf" and suffix == ".pdf":
        browser()
        return write_pdf
    if suffix == ".pdf" or kind == "pdf":
        error = InputError(f"--format {kind} and this name do not agree; name it .{kind}")
        raise error.about(printable(str(path)))
    checked_page(path)
    return _write_text


@contextmanager
def drafted(page: Path | None) -> Iterator[Callable[[str], None] | None]:
    """Give what writes a page, whose name and place are checked first."""
    if page is None:
        yield None
        return
    write = writer(page, None)
    with replacing(page) as draft:
        yield lambda text: write(text, draft)


def _write_text(page: str, draft: Path) -> None:
    draft.write_text(page, encoding="utf-8")


def sources_of(files: Sequence[Path], *, date: str | None = None) -> list[Source]:
    """Return where each file's record comes from, with the command that is running and the date or now."""
    from suspid.reporting import source_of

    command = shlex.join(["suspid", *click.get_current_context().meta.get(ARGUMENTS, [])])
    created = date or datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    sources = [source_of(file, command=command, created=created) for file in files]
    return [replace(one, file=shown(one.file)) for one in sources]


def checked_picture(path: Path) -> Path:
    """Return the path, if its suffix is a kind of picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    known = sorted(FigureCanvasAgg.filetypes)
    if path.suffix[1:].lower() not in known:
        error = InputError(f"pictures of type {path.suffix!r} are not known; known: {', '.join(known)}")
        raise error.about(printable(str(path)))
    return path


def save_picture(draw: Callable[[Figure], object], draft: Path, *, size: tuple[float, float] | None = None) -> None:
    """Write a page that a function draws, of the kind that the name says."""
    from matplotlib.figure import Figure

    from suspid.reporting import PAGE

    figure = Figure(figsize=size or PAGE, layout="constrained")
    draw(figure)
    figure.savefig(draft, format=draft.suffix[1:].lower(), dpi=120)
