"""Common parts of the commands that fit a car to records: reading, causes of the motion, and the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from suspid.analysis import Read, Settings, in_terms_of, read
from suspid.cli.named_values import names_in
from suspid.cli.options import Decorator, packed
from suspid.cli.ridden import damage_of
from suspid.files import naming

if TYPE_CHECKING:
    from suspid.greybox import Estimate, RecordTest
    from suspid.model import Suspension

GIVEN = click.option(
    "--given",
    metavar="NAME,…",
    default="",
    help="Measured causes of the motion: wheels, roads, forces, or single ones by their names in CAR; none: a free "
    "decay. [what explains the records]",
)


def sensing_of(
    gains: tuple[str, ...], delays: tuple[str, ...], mounts: tuple[str, ...], noisy: tuple[str, ...]
) -> dict[str, tuple[str, ...] | None]:
    """Return the arguments of `estimate` on channels and mounts; ``none`` leaves none unknown."""
    asked = {"gains": gains, "delays": delays, "mounts": mounts, "noisy": noisy}
    return {
        name: tuple(one for one in names_in(chosen) if one != "none") if chosen else None
        for name, chosen in asked.items()
    }


def _unknown(option: str, argument: str, metavar: str, what: str) -> Any:
    return click.option(
        option,
        argument,
        metavar=f"{metavar}|none",
        multiple=True,
        help=f"{what} is unknown; repeat, or NAME,NAME. [as needed]",
    )


sensing: Decorator = packed(
    sensing_of,
    (
        _unknown("--gain", "gains", "CHANNEL", "Channel whose gain"),
        _unknown("--delay", "delays", "CHANNEL", "Channel whose delay"),
        _unknown("--mount", "mounts", "STRUT", "Strut the mount of whose damper"),
        _unknown("--noisy", "noisy", "CAUSE", "Given road or force whose noise"),
    ),
    "sensing",
)


def tests_of(
    files: Sequence[Path],
    suspension: Suspension,
    settings: Settings,
    masses: Sequence[Mapping[str, float]],
    said: list[str],
) -> list[RecordTest]:
    """Return the records in files as tests, in the terms of a car, and add what was found in them to what is said."""
    from suspid.greybox import RecordTest, nameless_forces
    from suspid.records import cut
    from suspid.samples import held
    from suspid.signals import as_signal

    tests = []
    for file, kg in zip(files, masses, strict=True):
        with naming(file):
            opened = in_terms_of(_read_of_car(file, suspension, settings), suspension)
            said += [f"{file}: {text}" for text in damage_of(opened.recording)]
            said += [f"{file}: {finding}" for finding in opened.cleaned.findings]
            said += [f"{file}: {note}" for note in opened.notes]
            units = dict(zip(as_signal(held(opened.cleaned, "record")).channels, opened.cleaned.units, strict=True))
            said += [f"{file}: {text}" for text in nameless_forces(units, suspension)]
            record = cut(opened.cleaned.record, start=settings.start, stop=settings.stop)
        tests.append(RecordTest(record=record, added_masses=kg))
    return tests


def _read_of_car(file: Path, suspension: Suspension, settings: Settings) -> Read:
    """Return a record; channels of the car on a slower clock of their own are interpolated, and not left out."""
    from suspid.io import bare_name
    from suspid.model import names_channel
    from suspid.samples import held
    from suspid.signals import as_signal
    from suspid.words import Defect

    opened, renamed = read(file, settings), dict(settings.rename)
    left: list[str] = []
    for finding in opened.cleaned.findings if settings.channels is None else ():
        names = finding.remark.numbers.get("channels")
        if finding.kind is Defect.SLOWER_CLOCK and isinstance(names, tuple):
            left += [str(name) for name in names]
    wanted = [name for name in left if names_channel(suspension, bare_name(str(renamed.get(name, name))))]
    if not wanted or opened.recording is None:
        return opened
    there = as_signal(held(opened.cleaned, "record")).channels
    used = [name for name in opened.recording.names if renamed.get(name, name) in there]
    return read(file, replace(settings, channels=(*used, *wanted)))


def fitted(
    tests: Sequence[RecordTest],
    suspension: Suspension,
    given: str,
    said: list[str],
    options: Mapping[str, Any],
    *,
    likely: Sequence[tuple[str, ...]] | None = None,
) -> Estimate:
    """Return the estimate under the causes that are named, or under those that explain the records.

    ``likely`` are the causes to try, in order. Default: all that the records show.

    Raises
    ------
    EstimationError, RecordError
        If no cause leads to an estimate.
    """
    from suspid.greybox import estimate, estimate_by_cause

    causes = [name.strip() for name in given.split(",") if name.strip()]
    if causes or options.get("road"):
        causes = [] if causes == ["none"] else causes or ["wheels"]
        return estimate(tests, suspension, given=causes, **options)
    found, cause = estimate_by_cause(tests, suspension, causes=likely, options=options)
    if cause:
        moved = any(name in {*suspension.coordinates, *suspension.roads} for name in cause)
        explains = ": it explains the rest of the records" if found.explains else ""
        said.append(
            f"{'the motion of ' * moved}{', '.join(cause)} was taken as the cause, as --given {','.join(cause)} "
            f"does{explains}{'; a test without it is a free decay' * (not all(found.causes))}"
        )
    return found
