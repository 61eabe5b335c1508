"""Analyse a recording: read, clean, find the decays, identify or join, reconstruct, judge."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from suspid.analysis.reading import Read, read
from suspid.analysis.settings import CarSettings, Settings
from suspid.analysis.stretch import Used, stretch_of
from suspid.decays import Decay, Decays
from suspid.errors import InputError, ReconstructionError
from suspid.identification import (
    Identification,
    Repeats,
    identify,
    identify_repeats,
    tables_of,
    tables_of_repeats,
    verdict_of,
    verdict_of_repeats,
)
from suspid.model import ModalSet, Suspension
from suspid.reconstruction import Asked, ModalTest, Reconstruction, check_asked, reconstruct
from suspid.recordings import Recording
from suspid.values import nearest_names
from suspid.words import Check, Defect, Level, ModeCheck, Note, RecordCheck, Remark, Verdict

if TYPE_CHECKING:
    import control

    from suspid.cleaning import Cleaned

# The steps of `analyse`, in order; ``progress`` is called with each as it begins.
STEPS = ("reading", "finding decays", "identifying", "reconstructing")


@dataclass(frozen=True, kw_only=True, eq=False)
class Analysis:
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

    @property
    def record(self) -> control.TimeResponseData:
        """The cleaned record, of which ``identification.response`` is the stretch that was used."""
        return self.cleaned.record

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
        failed = [Check(note, Level.CARE) for note in self.notes if note.code is Note.NO_SPRINGS]
        if len(self.decays) or any(note.code is Note.WHOLE_RECORD for note in self.notes):
            # The search for decays has answered what a late motion would suggest.
            kept = (check for check in found.checks if check.remark.code is not ModeCheck.LATE_MOTION)
            found = Verdict(found.headline, tuple(kept))
        springs = () if self.reconstruction is None else self.reconstruction.verdict.checks
        return found.with_checks([*_of_recording(self.cleaned, self.used), *springs, *failed])

    def __str__(self) -> str:
        parts = [tables_of(self.identification) if self.repeats is None else tables_of_repeats(self.repeats)]
        if self.reconstruction is not None:
            parts.append(str(self.reconstruction))
        return "\n\n".join([*parts, str(self.verdict)])


def analyse(
    source: str | os.PathLike[str] | Recording | control.TimeResponseData,
    *,
    car: Suspension | None = None,
    settings: Settings | None = None,
    progress: Callable[[str], None] | None = None,
) -> Analysis:
    """Return modes, and with a car springs and dampers, of a recording as it comes.

    The steps are those a careful user would take: `read_recording`, `clean`, `find_decays` where the largest motion
    does not come first, `identify` (or `identify_repeats` for several decays), and `reconstruct` if a car is given. The
    commands, the report and the fleet do the same by calling this function.

    Parameters
    ----------
    source : path, Recording or control.TimeResponseData
        A file of any known format, a recording as read, or a record on a uniform clock.
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
    begin(STEPS[0])
    opened = read(source, settings)
    begin(STEPS[1])
    stretch = stretch_of(opened.cleaned.record, settings)
    begin(STEPS[2])
    identification, repeats = _identified(opened, stretch, settings)
    notes = [*opened.notes, *stretch.notes]
    found = None
    if car is not None:
        begin(STEPS[3])
        modes = identification.modes if repeats is None else repeats.modes
        found, why = _springs(modes, car, settings)
        notes += why
    return Analysis(
        settings=settings,
        recording=opened.recording,
        cleaned=opened.cleaned,
        decays=stretch.decays,
        used=stretch.used,
        identification=identification,
        repeats=repeats,
        reconstruction=found,
        notes=tuple(notes),
    )


def _check_types(car: object, settings: object) -> None:
    """Refuse what is neither a car nor settings."""
    if not isinstance(settings, Settings):
        raise InputError(f"settings={settings!r:.80} must be Settings, such as Settings(modes=1)")
    if car is not None and not isinstance(car, Suspension):
        raise InputError(f"car={car!r:.80} must be a Suspension; read_car reads one from a file")


def _identified(opened: Read, stretch: Used, settings: Settings) -> tuple[Identification, Repeats | None]:
    """Return the identification of the decay and, where several are used, that of all jointly."""
    if len(stretch.used) < 2:
        found = identify(
            stretch.record,
            modes=settings.modes,
            method=settings.method,
            band=settings.band,
            bandwidth=settings.bandwidth,
            candidates=settings.candidates,
        )
        return found, None
    repeats = identify_repeats(opened.cleaned.record, stretch.used, modes=settings.modes, band=settings.band)
    return repeats.each[0], repeats


def _springs(modes: ModalSet, car: Suspension, settings: Settings) -> tuple[Reconstruction | None, list[Remark]]:
    """Return springs and dampers, or a note on why there are none."""
    try:
        return reconstruct_as(settings.springs, modes, car), []
    except (ReconstructionError, InputError) as error:
        return None, [Remark(Note.NO_SPRINGS, {"why": str(error)})]


def check_springs(how: CarSettings, car: Suspension) -> None:
    """Refuse what no modes of this car could be reconstructed with: an unknown name, bounds that leave nothing.

    Raises
    ------
    InputError
        If a name is unknown, settings contradict each other, or nothing is left to find.
    """
    for name in how.added_masses:
        if name not in car.coordinates:
            raise InputError(f"added_masses: there is no mass {name!r}.{nearest_names(name, car.masses)}")
    asked = Asked(
        fixed=how.fixed,
        bounds=how.bounds,
        ties=how.ties,
        nominal_std=how.nominal_std,
        free_masses=how.free_masses,
        constraints=how.constraints,
    )
    check_asked(car, asked)


def reconstruct_as(how: CarSettings, modes: ModalSet, car: Suspension) -> Reconstruction:
    """Return springs and dampers, reconstructed as the settings say."""
    return reconstruct(
        [ModalTest(modes=modes, added_masses=how.added_masses)],
        car,
        fixed=how.fixed,
        bounds=how.bounds,
        ties=how.ties,
        nominal_std=how.nominal_std,
        free_masses=how.free_masses,
        tolerance=how.tolerance,
        search=how.search,
        constraints=how.constraints,
    )


def _of_recording(cleaned: Cleaned, used: tuple[Decay, ...]) -> Iterator[Check]:
    """Return the checks of the recording that the identification cannot see."""
    if len(used) == 1:
        for doubt in used[0].doubts:
            yield Check(Remark(RecordCheck.DECAY, {"doubt": str(doubt)}), Level.CARE)
    against = [finding.check for finding in cleaned.findings if finding.check.level < Level.NOTE]
    overridden = [check for check in against if check.remark.code is Defect.OVERRIDDEN_STAMPS]
    yield from overridden
    if len(against) > len(overridden):
        yield Check(Remark(RecordCheck.DEFECTS, {"number": len(against) - len(overridden)}), Level.CARE)
