"""Analyse a recording: read, clean, find the decays, identify or join, reconstruct, judge."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from suspid.analysis.car_channels import in_terms_of
from suspid.analysis.choice import doubts_of, identified
from suspid.analysis.reading import Read, read, tests_of
from suspid.analysis.settings import Settings
from suspid.analysis.several import Part, alike, belonging, check_each_once, source_names
from suspid.analysis.springs import Springs, check_springs, springs_of
from suspid.analysis.stretch import Used, stretch_of
from suspid.cleaning import RecordLike
from suspid.decays import Decay, Decays
from suspid.errors import InputError
from suspid.files import naming
from suspid.greybox import Estimate, parameter_table
from suspid.identification import (
    Identification,
    Repeats,
    identify_repeats,
    tables_of,
    tables_of_repeats,
    verdict_of,
    verdict_of_repeats,
)
from suspid.model import ModalSet, Suspension
from suspid.reconstruction import Reconstruction
from suspid.recordings import Recording
from suspid.results import Result
from suspid.samples import held
from suspid.signals import as_signal, cut
from suspid.words import Check, Defect, Level, ModeCheck, Note, RecordCheck, Remark, Verdict

if TYPE_CHECKING:
    import control

    from suspid.cleaning import Cleaned


Source: TypeAlias = "str | os.PathLike[str] | Recording | RecordLike"

# The steps of `analyse`, in order; ``progress`` is called with each as it begins.
STEPS = ("reading", "finding decays", "identifying", "reconstructing")


@dataclass(frozen=True, kw_only=True, eq=False)
class Analysis(Result):
    """What `analyse` found, step by step.

    Parameters
    ----------
    settings : Settings
        What it was told.
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
        What was done on the way, in order.
    tests : mapping
        The analysis of each recording by its name, where several were given; else empty. What is not joint, such as
        ``record``, is that of the first.
    estimate : Estimate or None
        Springs and dampers fitted to the record itself, if a car was given and its modes did not settle them: there was
        no reconstruction, it does not explain the modes, or other cars have the same.

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
        """The cleaned record, of which ``identification.response`` is the stretch that was used."""
        return self.cleaned.record

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each channel of the record that was identified; empty where it is not known."""
        names, whole = as_signal(held(self.identification, "response")).channels, self.cleaned
        known = dict(zip(as_signal(held(whole, "record")).channels, whole.units, strict=True))
        return tuple(known.get(name, "") for name in names)

    @property
    def modes(self) -> ModalSet:
        """The modes: the joint ones where several decays were used."""
        return self.identification.modes if self.repeats is None else self.repeats.modes

    @cached_property
    def verdict(self) -> Verdict:
        """How far the modes, springs and dampers can be trusted."""
        level = self.settings.level
        found = verdict_of(self.identification, level)
        if self.repeats is not None:
            found = verdict_of_repeats(self.repeats, level)
        several = [note for note in self.notes if note.code is Note.ONE_OF_TESTS]
        failed = [Check(Remark(RecordCheck.ONE_OF_TESTS, note.numbers), Level.CARE) for note in several]
        unsettled = () if self.estimate is not None else self.notes
        failed += [Check(note, Level.CARE) for note in unsettled if note.code is Note.NO_SPRINGS]
        if len(self.decays) or any(note.code is Note.WHOLE_RECORD for note in self.notes):
            # The search for decays has answered what a late motion would suggest.
            kept = (check for check in found.checks if check.remark.code is not ModeCheck.LATE_MOTION)
            found = Verdict(found.headline, tuple(kept))
        best = self.estimate or self.reconstruction
        springs = () if best is None else best.verdict.checks
        of_recording = list(_of_recording(self.cleaned))
        if self.tests and self.repeats is not None:
            of_recording = list(belonging(self.repeats, list(self.repeats.names)))
            of_recording += [
                Check(Remark(RecordCheck.IN_TEST, {"test": name, "what": str(check.remark)}), check.level)
                for name, test in self.tests.items()
                for check in (
                    *(doubts_of(test.used[0], test.identification) if len(test.used) == 1 else ()),
                    *_of_recording(test.cleaned),
                )
            ]
        doubts = doubts_of(self.used[0], self.identification) if len(self.used) == 1 else ()
        return Verdict(found.headline, (*doubts, *found.checks, *of_recording, *springs, *failed))

    def _table(self) -> Mapping[str, Sequence[object]]:
        return self.modes._table()

    def __str__(self) -> str:
        parts = [tables_of(self.identification) if self.repeats is None else tables_of_repeats(self.repeats)]
        if self.estimate is not None:
            parts.append(parameter_table(self.estimate))
        elif self.reconstruction is not None:
            parts.append(str(self.reconstruction))
        return "\n\n".join([*parts, str(self.verdict)])


def analyse(
    source: Source | Sequence[Source],
    *,
    car: Suspension | None = None,
    settings: Settings | None = None,
    progress: Callable[[str], None] | None = None,
) -> Analysis:
    """Return modes, and with a car springs and dampers, of a recording as it comes.

    The steps are those a careful user would take: `read_recording`, `clean`, `identify` where the record is a free
    decay from its first sample on, else `find_decays` and `identify` of the best one (or `identify_repeats` of
    several), and `reconstruct` if a car is given, or `estimate` from the record itself where the modes do not settle
    springs and dampers. The commands, the report and the fleet do the same by calling this function.

    Parameters
    ----------
    source : path, Recording, control.TimeResponseData or what `as_record` takes, or a list of them
        A file of any known format, a recording as read, or a record on a uniform clock. Several are tests of one
        structure: the decays of all are joined.
    car : Suspension, optional
        Masses and nominal springs and dampers.
    settings : Settings, optional
        Everything else. Default: ``Settings()``.
    progress : callable, optional
        Called with the name of each step as it begins.

    Returns
    -------
    Analysis
        What was found, step by step, with its verdict. A reconstruction that fails is a note and not an error.

    Raises
    ------
    InputError
        If a setting cannot be meant for this source or this car.
    SuspidError
        If the source cannot be used, or fewer modes than asked for stand out.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 5, 0.005), initial_state={"v_tire": 1.0})
    >>> found = analyse(add_noise(record, snr_db=40.0, rng=np.random.default_rng(1)), car=car)
    >>> len(found.modes), found.verdict.level.label
    (2, 'sound')
    >>> found.reconstruction.explains
    True
    """
    settings = Settings() if settings is None else settings
    _check_types(car, settings)
    if car is not None:
        check_springs(settings.springs, car)
    begin = progress or (lambda _: None)
    if isinstance(source, list) or (isinstance(source, tuple) and not hasattr(source[0], "dtype")):
        return _of_several(source, car, settings, begin)
    # In place of the name of a test: all of them, jointly.
    if settings.test == "all" and isinstance(source, str | os.PathLike | Recording):
        tests = tests_of(source, settings)
        if len(tests) > 1:
            return _of_several(tests, car, replace(settings, test=None), begin)
        source, settings = tests[0], replace(settings, test=None)
    with naming(source if isinstance(source, str | os.PathLike) else ""):
        begin(STEPS[0])
        opened = _read(source, car, settings)
        begin(STEPS[1])
        stretch = stretch_of(held(opened.cleaned, "record"), settings)
        begin(STEPS[2])
        identification, repeats = _identified(opened, stretch, settings)
    notes = [*opened.notes, *stretch.notes]
    springs = Springs()
    if car is not None:
        begin(STEPS[3])
        modes = identification.modes if repeats is None else repeats.modes
        springs = springs_of(modes, _decays_of(opened, stretch), car, settings.springs)
        notes += springs.notes
    return Analysis(
        settings=settings,
        recording=opened.recording,
        cleaned=opened.cleaned,
        decays=stretch.decays,
        used=stretch.used,
        identification=identification,
        repeats=repeats,
        reconstruction=springs.reconstruction,
        estimate=springs.estimate,
        notes=tuple(notes),
    )


def _of_several(
    sources: Sequence[Source], car: Suspension | None, settings: Settings, begin: Callable[[str], None]
) -> Analysis:
    """Return the joint analysis of several recordings."""
    check_each_once(sources)
    if settings.method != "likelihood":
        raise InputError(f"several recordings are joined by likelihood; method={settings.method!r} takes one at a time")
    names = source_names(sources)
    begin(STEPS[0])
    opened = [_read(source, car, settings) for source in sources]
    begin(STEPS[1])
    stretches = []
    for name, one in zip(names, opened, strict=True):
        with naming(name):
            stretches.append(stretch_of(held(one.cleaned, "record"), settings))
    parts = [
        Part(source=k, name=name, record=record)
        for k, (name, one, stretch) in enumerate(zip(names, opened, stretches, strict=True))
        for record in _decays_of(one, stretch)
    ]
    parts, resampled = alike(parts)
    begin(STEPS[2])
    repeats = identify_repeats(
        [part.record for part in parts],
        modes=settings.modes,
        band_hz=settings.band_hz,
        names=[part.name for part in parts],
    )
    springs = Springs()
    if car is not None:
        begin(STEPS[3])
        springs = springs_of(repeats.modes, [part.record for part in parts], car, settings.springs)
    first = [next(i for i, part in enumerate(parts) if part.source == k) for k in range(len(names))]
    tests = {
        name: Analysis(
            settings=settings,
            recording=one.recording,
            cleaned=one.cleaned,
            decays=stretch.decays,
            used=stretch.used,
            identification=repeats.each[k],
            repeats=None,
            reconstruction=None,
            notes=(*one.notes, *stretch.notes),
        )
        for name, one, stretch, k in zip(names, opened, stretches, first, strict=True)
    }
    return replace(
        tests[names[0]],
        repeats=repeats,
        reconstruction=springs.reconstruction,
        estimate=springs.estimate,
        notes=(*resampled, *springs.notes),
        tests=tests,
    )


def _read(source: Source, car: Suspension | None, settings: Settings) -> Read:
    """Return a source as read, in the terms of the car, if one is given."""
    opened = read(source, settings)
    return opened if car is None else in_terms_of(opened, car)


def _decays_of(opened: Read, stretch: Used) -> list[control.TimeResponseData]:
    """Return the decays of a recording that are used, or the stretch that is."""
    if len(stretch.used) < 2:
        return [stretch.record]
    return [cut(held(opened.cleaned, "record"), start=decay.start, stop=decay.stop) for decay in stretch.used]


def _check_types(car: object, settings: object) -> None:
    """Refuse what is neither a car nor settings."""
    if not isinstance(settings, Settings):
        raise InputError(f"settings={settings!r:.80} must be Settings, such as Settings(modes=1)")
    if car is not None and not isinstance(car, Suspension):
        raise InputError(f"car={car!r:.80} must be a Suspension; read_car reads one from a file")


def _identified(opened: Read, stretch: Used, settings: Settings) -> tuple[Identification, Repeats | None]:
    """Return the identification of the decay and, where several are used, that of all jointly."""
    if len(stretch.used) < 2:
        return stretch.identification or identified(stretch.record, settings), None
    repeats = identify_repeats(
        held(opened.cleaned, "record"), stretch.used, modes=settings.modes, band_hz=settings.band_hz
    )
    return repeats.each[0], repeats


def _of_recording(cleaned: Cleaned) -> Iterator[Check]:
    """Return the checks of the recording that the identification cannot see."""
    against = [finding.check for finding in cleaned.findings if finding.check.level < Level.NOTE]
    overridden = [check for check in against if check.remark.code is Defect.OVERRIDDEN_STAMPS]
    yield from overridden
    if len(against) > len(overridden):
        yield Check(Remark(RecordCheck.DEFECTS, {"number": len(against) - len(overridden)}), Level.CARE)
