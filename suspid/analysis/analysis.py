"""Result of `analyse`: each step, the verdict, and its text."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from suspid.analysis.choice import doubts_of
from suspid.analysis.commanded import ANSWERED_BY_COMMAND
from suspid.analysis.far_larger import shows_the_same, time_of
from suspid.analysis.settings import Settings
from suspid.analysis.several import belonging
from suspid.decays import Decay, Decays
from suspid.files import printable
from suspid.greybox import Estimate, parameter_table
from suspid.identification import (
    Identification,
    Repeats,
    in_hertz,
    tables_of,
    tables_of_repeats,
    verdict_of,
    verdict_of_repeats,
)
from suspid.io import SLOWEST_STEP, UNNAMED_COLUMN
from suspid.levels import LEVEL
from suspid.model import ModalSet
from suspid.reconstruction import Reconstruction, tables_of_reconstruction
from suspid.recordings import Recording
from suspid.results import Result
from suspid.samples import held
from suspid.signals import as_signal
from suspid.words import Check, Defect, LeftOut, Level, ModeCheck, Note, Number, Reason, RecordCheck, Remark, Verdict

if TYPE_CHECKING:
    import control

    from suspid.cleaning import Cleaned


# A unit of time that is guessed of a column without a name.
UNNAMED_TIME = re.compile(f"unit of '{UNNAMED_COLUMN.pattern}'")
# Notes on what was not used, which call for care with what was found.
CALLS_FOR_CARE = {
    Note.COMMANDED: RecordCheck.COMMANDED,
    Note.ONE_OF_TESTS: RecordCheck.ONE_OF_TESTS,
    Note.FEWER_CHANNELS: RecordCheck.FEWER_CHANNELS,
    Note.LARGER_ELSEWHERE: RecordCheck.LARGER_ELSEWHERE,
    Note.LARGEST_USED: RecordCheck.LARGEST_USED,
    Note.AFTER_LOCK: RecordCheck.AFTER_LOCK,
    Note.MEANS: RecordCheck.MEANS,
}


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Analysis(Result):
    """Result of `analyse`, step by step.

    Parameters
    ----------
    settings : Settings
        The settings used.
    recording : Recording or None
        The channels as the file has them; None if the source was a response.
    cleaned : Cleaned
        The record on a uniform clock, with units and findings.
    decays : Decays
        The decays that were found; empty where none was searched for.
    used : tuple of Decay
        Those that were used; empty if the whole record, or a stretch from the settings, was.
    identification : Identification
        Modes of the stretch that was used; of the first where several decays were.
    repeats : Repeats or None
        Modes of several decays jointly.
    reconstruction : Reconstruction or None
        Springs and dampers, if a car was given and they were found.
    notes : tuple of Remark
        What was done, in order.
    tests : mapping
        The analysis of each recording by its name, where several were given; else empty. What is not joint, such as
        ``record``, is that of the first.
    estimate : Estimate or None
        Springs and dampers fitted to the record itself, if a car was given and its modes did not determine them: there
        was no reconstruction, it does not explain the modes, or other cars have the same.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import analyse, as_record
    >>> t = np.arange(400) / 100
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> found = analyse(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat"]))
    >>> found.modes.wn.round(1), found.record.output_labels, found.used
    (array([20.]), ['seat'], ())
    """

    settings: Settings
    recording: Recording | None
    cleaned: Cleaned
    decays: Decays | tuple[Decay, ...]
    used: tuple[Decay, ...]
    identification: Identification
    repeats: Repeats | None
    reconstruction: Reconstruction | None
    notes: tuple[Remark, ...]
    tests: Mapping[str, Analysis] = field(default_factory=dict)
    estimate: Estimate | None = None

    @property
    def record(self) -> control.TimeResponseData:
        """The cleaned record, of which ``identification.response`` is the stretch that was used.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import analyse, as_record
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = analyse(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat [mm]"]))
        >>> found.record.output_labels
        ['seat [mm]']
        """
        return self.cleaned.record

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each channel of the record that was identified; empty where it is not known.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, analyse
        >>> t = np.arange(400) / 100
        >>> values = np.exp(-t) * np.cos(20 * t) + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> seat = RawChannel(name="seat", unit="mm", timepts=t, values=values, rate=None)
        >>> analyse(Recording(title="bump", channels=(seat,))).units
        ('mm',)
        """
        names, whole = as_signal(held(self.identification, "response")).channels, self.cleaned
        known = dict(zip(as_signal(held(whole, "record")).channels, whole.units, strict=True))
        return tuple(known.get(name, "") for name in names)

    @property
    def modes(self) -> ModalSet:
        """The modes: the joint ones where several decays were used.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import analyse, as_record
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = analyse(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat [mm]"]))
        >>> found.modes.wn.round(1)
        array([20.])
        """
        return self.identification.modes if self.repeats is None else self.repeats.modes

    @cached_property
    def verdict(self) -> Verdict:
        """How far the modes, springs and dampers can be trusted.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import analyse, as_record
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = analyse(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat [mm]"]))
        >>> found.verdict.level.label
        'sound'
        """
        level = self.settings.level
        if self.repeats is not None:
            found = verdict_of_repeats(self.repeats, level)
        elif level == LEVEL:
            found = self.identification.verdict
        else:
            found = verdict_of(self.identification, level)
        failed = [
            Check(Remark(CALLS_FOR_CARE[note.code], note.numbers), Level.DOUBTFUL if _is_an_end(note) else Level.CARE)
            for note in self.notes
            if isinstance(note.code, Note) and note.code in CALLS_FOR_CARE and not self._answered(note)
        ]
        unsettled = () if self.estimate is not None else self.notes
        failed += [Check(note, Level.CARE) for note in unsettled if note.code is Note.NO_SPRINGS]
        codes = {note.code for note in self.notes}
        # The search for decays has answered what a late motion would suggest.
        searched = len(self.decays) or Note.WHOLE_RECORD in codes
        answered = {ModeCheck.LATE_MOTION} if searched else set[ModeCheck]()
        answered |= ANSWERED_BY_COMMAND if Note.COMMANDED in codes else frozenset()
        found = Verdict(found.headline, tuple(check for check in found.checks if check.remark.code not in answered))
        best = self.estimate or self.reconstruction
        springs = () if best is None else best.verdict.checks
        of_recording = list(_of_recording(self))
        if self.tests and self.repeats is not None:
            of_recording = list(belonging(self.repeats, list(self.repeats.names)))
            of_recording += [
                Check(Remark(RecordCheck.IN_TEST, {"test": name, "what": str(check.remark)}), check.level)
                for name, test in self.tests.items()
                for check in (
                    *doubts_of(test.used, test.identification, test.decays),
                    *_of_recording(test),
                )
            ]
        # Those of several tests are said of each of them.
        doubts = () if self.tests else doubts_of(self.used, self.identification, self.decays)
        return Verdict(found.headline, (*doubts, *found.checks, *of_recording, *springs, *failed))

    def _answered(self, note: Remark) -> bool:
        """Return whether larger motion elsewhere is a decay that shows the same modes."""
        larger = note.code is Note.LARGER_ELSEWHERE
        return larger and shows_the_same(self.decays, time_of(note), self.modes)

    def _table(self) -> Mapping[str, Sequence[object]]:
        return self.modes._table()

    def _brief(self) -> str:
        springs = self.estimate or self.reconstruction
        return "; ".join([self.modes._brief(), *([springs._brief()] if springs is not None else [])])

    def __str__(self) -> str:
        return self._text(whole=False)

    def details(self) -> str:
        """Return the tables with all amplitudes, channels and rejected poles, springs and dampers, and the verdict.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import analyse
        >>> t = np.arange(0, 3, 0.01)
        >>> print(analyse((t, np.exp(-t) * np.cos(20 * t))).details().splitlines()[-1])
        Verdict: 1 mode found: sound. Every check that could be made was passed.
        """
        return self._text(whole=True)

    def _text(self, *, whole: bool) -> str:
        modes = self.identification
        parts = [tables_of(modes, whole=whole) if self.repeats is None else tables_of_repeats(self.repeats)]
        if self.estimate is not None:
            parts.append(parameter_table(self.estimate))
        elif self.reconstruction is not None:
            parts.append(tables_of_reconstruction(self.reconstruction))
        return "\n\n".join([*parts, str(self.verdict)])


def _is_an_end(note: Remark) -> bool:
    """Return whether what was identified is the end of a far larger motion."""
    return note.code is Note.LARGER_ELSEWHERE and bool(note.numbers["follows"])


def _of_recording(found: Analysis) -> Iterator[Check]:
    """Return the checks of the recording that the identification cannot see."""
    # What is wrong with a channel that was left out is not wrong with the result.
    used = {"", *as_signal(held(found.identification, "response")).channels}
    against = [one.check for one in found.cleaned.findings if one.check.level < Level.NOTE and one.channel in used]
    overridden = [check for check in against if check.remark.code is Defect.OVERRIDDEN_STAMPS]
    yield from overridden
    # A stated rate takes the place of what was guessed.
    guesses = () if found.recording is None or found.settings.fs is not None else found.recording.left_out
    for name, remark in guesses:
        # Of a column without a name, it is guessed too that it holds the time.
        if remark.code is LeftOut.FINER_UNIT and (remark.numbers["others"] or UNNAMED_TIME.fullmatch(name)):
            guessed: dict[str, Number] = {"name": printable(name), **remark.numbers}
            yield Check(Remark(RecordCheck.GUESSED_UNIT, guessed), Level.CARE)
        if remark.code is LeftOut.TOO_FINE:
            odd: dict[str, Number] = {"name": printable(name), "length": remark.numbers["length"]}
            yield Check(Remark(RecordCheck.ODD_UNIT, odd), Level.CARE)
    of_start = [
        c.pole
        for c in found.identification.considered
        if c.remark.code is Reason.OF_START and c.remark.numbers.get("released")
    ]
    if of_start:
        yield Check(Remark(RecordCheck.OF_START, {"hertz": in_hertz(of_start)}), Level.CARE)
    step = as_signal(held(found.cleaned, "record")).step
    if found.recording is not None and found.settings.fs is None and step >= SLOWEST_STEP:
        yield Check(Remark(RecordCheck.SLOW_SAMPLES, {"step": step, "rate": 1000 / step}), Level.CARE)
    others = [str(check.remark.code) for check in against if check not in overridden]
    if others:
        numbers: dict[str, Number] = {"number": len(others), "kinds": tuple(dict.fromkeys(others))}
        yield Check(Remark(RecordCheck.DEFECTS, numbers), Level.CARE)
