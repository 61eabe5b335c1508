"""Several recordings of one structure: common channels and rate, and tests whether they belong together."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import ONE_RATE, halving_error, interpolate
from suspid.errors import InputError
from suspid.files import printable
from suspid.identification import Repeats
from suspid.levels import EQUAL_RATE
from suspid.recordings import Recording
from suspid.records import like
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.values import listed
from suspid.wording import Argument
from suspid.words import Check, Level, Note, Number, RecordCheck, Remark

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Part:
    """A decay of one of several recordings."""

    # Which of the recordings.
    source: int
    # What it is called.
    name: str
    record: control.TimeResponseData


def source_names(sources: Sequence[str | os.PathLike[str] | Recording | control.TimeResponseData]) -> list[str]:
    """Return what each of several sources is called: files by the shortest different ends of their paths, or by number.

    Examples
    --------
    >>> source_names(["a/run 1.csv", "a/run 2.csv"]), source_names(["x/a/run.csv", "x/b/run.csv"])
    (['run 1.csv', 'run 2.csv'], ['a/run.csv', 'b/run.csv'])
    """
    full = [
        os.fspath(one) if isinstance(one, str | os.PathLike) else one.title if isinstance(one, Recording) else ""
        for one in sources
    ]
    parts = [Path(name).parts for name in full]
    most = max(map(len, parts), default=0)
    ends = ([os.path.join("", *part[-depth:]) for part in parts] for depth in range(1, most + 1))
    names = next((each for each in ends if len(set(each)) == len(each)), full)
    return [printable(name) or f"record {k}" for k, name in enumerate(names, 1)]


def check_each_once(sources: Sequence[object]) -> None:
    """Refuse fewer than two sources, and a file that is named twice."""
    if len(sources) < 2:
        raise InputError("several recordings are joined: give two or more, or the recording itself")
    files = [os.path.realpath(one) for one in sources if isinstance(one, str | os.PathLike)]
    twice = next((name for k, name in enumerate(files) if name in files[:k]), None)
    if twice is not None:
        raise InputError(f"{printable(twice)} is named twice: name each once")


def alike(parts: Sequence[Part]) -> tuple[list[Part], list[Remark]]:
    """Return decays with the channels of the first, in its order and at its rate, and what was done for that.

    Raises
    ------
    InputError
        If one of them has other channels, another rate, or the samples of another one.
    """
    first, notes, made = parts[0], list[Remark](), list[Part]()
    wanted = as_signal(first.record)
    for part in parts:
        signal = as_signal(part.record)
        missing = [name for name in wanted.channels if name not in signal.channels]
        other = [name for name in signal.channels if name not in wanted.channels]
        if missing or other:
            raise InputError(
                f"{part.name} does not belong to {first.name}: it has the channels {listed(signal.channels)}, "
                f"{first.name} has {listed(wanted.channels)}; name those that they share ({Argument('channels')}), "
                f"or identify them separately"
            )
        apart = abs(signal.step / wanted.step - 1)
        if apart > ONE_RATE:
            raise InputError(
                f"{part.name} is sampled at {1 / signal.step:.6g} Hz, {first.name} at {1 / wanted.step:.6g} Hz; "
                f"decays are joined at one rate only: identify them separately"
            )
        rows = signal.values[[signal.channels.index(name) for name in wanted.channels]]
        timepts: RealArray = signal.timepts
        if apart > EQUAL_RATE:
            error = max(halving_error(timepts, row) for row in rows)
            timepts = signal.start + wanted.step * np.arange(int((timepts[-1] - signal.start) / wanted.step) + 1.0)
            rows = np.array([interpolate(timepts, signal.timepts, row, widest=np.inf) for row in rows])
            numbers: dict[str, Number] = {
                "name": part.name,
                "rate": 1 / signal.step,
                "onto": 1 / wanted.step,
                "error": error,
            }
            notes.append(Remark(Note.RESAMPLED, numbers))
        record = part.record
        if apart > EQUAL_RATE or signal.channels != wanted.channels:
            record = like(record, timepts, rows, wanted.channels, title=part.name)
        copied = next((one.name for one in made if _same_samples(one.record, record)), None)
        if copied is not None:
            raise InputError(
                f"{part.name} has the samples of {copied}: a copy is no second test, and intervals would be too "
                f"narrow; leave one out"
            )
        made.append(Part(source=part.source, name=part.name, record=record))
    return made, notes


def _same_samples(one: control.TimeResponseData, other: control.TimeResponseData) -> bool:
    """Return whether two records have the same samples: noise of two tests never is the same."""
    return np.array_equal(as_signal(one).values, as_signal(other).values)


def belonging(repeats: Repeats, names: Sequence[str]) -> Iterator[Check]:
    """Yield what speaks against it that the decays are of one structure: which of them, and on which mode."""
    everyone = set(range(len(names)))
    held = [set(agreement.held) for agreement in repeats.consistency]
    agreeing = [some for some, a in zip(held, repeats.consistency, strict=True) if len(some) > 1 and a.widening == 1]
    alone = everyone - set().union(*agreeing) if agreeing else set[int]()
    if held and not any(len(some) > 1 for some in held):
        yield Check(Remark(RecordCheck.NO_SHARED_MODE, {"tests": ", ".join(names)}), Level.DOUBTFUL)
    for i in sorted(alone):
        yield Check(Remark(RecordCheck.SHARES_NO_MODE, {"test": names[i]}), Level.DOUBTFUL)
    for k, (agreement, some) in enumerate(zip(repeats.consistency, held, strict=True), 1):
        if some and some != everyone:
            having = ", ".join(names[i] for i in sorted(some))
            without = ", ".join(names[i] for i in sorted(everyone - some))
            yield Check(Remark(RecordCheck.NOT_IN_ALL, {"mode": k, "held": having, "not_in": without}), Level.CARE)
        # Of a test that shares no mode it is said above, of all modes at once.
        if agreement.widening > 1 and agreement.odd is not None and agreement.odd not in alone and len(some) > 2:
            odd: dict[str, Number] = {
                "mode": k,
                "test": names[agreement.odd],
                "of": len(some),
                "apart": agreement.chi_square,
            }
            yield Check(Remark(RecordCheck.ODD_TEST, {**odd, "without": agreement.without_odd}), Level.CARE)
