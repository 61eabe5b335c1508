"""Analyse a recording: read, clean, find the decays, identify or join, reconstruct, judge."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from suspid.analysis.analysis import Analysis
from suspid.analysis.background import with_background
from suspid.analysis.begun_tones import with_begun_tones
from suspid.analysis.car_channels import in_terms_of
from suspid.analysis.choice import level_of
from suspid.analysis.commanded import after_commands
from suspid.analysis.far_larger import larger_elsewhere
from suspid.analysis.fewer_channels import with_fewer_channels, without_clipped
from suspid.analysis.means import with_means, with_means_of_longest
from suspid.analysis.other_parts import other_part
from suspid.analysis.reading import Read, read, tests_of
from suspid.analysis.settings import Settings
from suspid.analysis.several import Part, alike, check_each_once, source_names
from suspid.analysis.springs import Springs, check_springs, springs_of
from suspid.analysis.stretch import part_asked_for, stretch_of
from suspid.analysis.support import doubted_as_wave, of_a_wave, supported
from suspid.analysis.tries import identified, kept_tries
from suspid.analysis.until_locked import after_lock
from suspid.analysis.used import Used
from suspid.arguments import explained
from suspid.cleaning import RecordLike
from suspid.errors import InputError, SuspidError
from suspid.files import naming
from suspid.identification import (
    Identification,
    Repeats,
    identify_repeats,
    patience,
)
from suspid.model import Suspension
from suspid.recordings import Recording
from suspid.records import cut, of_channels
from suspid.samples import held
from suspid.signals import as_signal
from suspid.threads import in_one_thread
from suspid.wording import Argument
from suspid.words import Level, Note, Remark

if TYPE_CHECKING:
    import control


Source: TypeAlias = "str | os.PathLike[str] | Recording | RecordLike"

# The steps of `analyse`, in order; ``progress`` is called with each as it begins.
STEPS = ("reading", "finding decays", "identifying", "reconstructing")


@explained
@in_one_thread
def analyse(
    source: Source | Sequence[Source],
    *,
    car: Suspension | None = None,
    settings: Settings | None = None,
    progress: Callable[[str], None] | None = None,
) -> Analysis:
    """Return modes, and with a car springs and dampers, from a raw recording.

    The steps are those a careful user would take: `read_recording`, `clean`, `identify` where the record is a free
    decay from its first sample on, else `find_decays` and `identify` of the best one (or `identify_repeats` of
    several), and `reconstruct` if a car is given, or `estimate` from the record itself where the modes do not determine
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
        If the source cannot be used, or fewer modes than requested are significant.

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
        record = held(opened.cleaned, "record")
        identification, repeats, stretch = _found(record, settings, begin, of_car=car is not None)
        part = part_asked_for(record, settings)
        if part is not None and settings.decay == "auto" and _asks_for_more(identification, settings):
            # What is refused there, as a channel that stands still from its release on, leaves what was found.
            with contextlib.suppress(SuspidError):
                free = replace(settings, start=None, stop=None)
                within, joint, decay = _found(part, free, lambda _: None, of_car=car is not None)
                clear = level_of(within, decay.used, decay.decays) > Level.DOUBTFUL
                if clear or not len(identification.modes):
                    identification, repeats = within, joint
                    stretch = replace(decay, notes=(Remark(Note.SOUGHT_WITHIN), *decay.notes))
    notes = [*opened.notes, *stretch.notes]
    if repeats is None and settings.decay == "auto" and part is None:
        notes += [*larger_elsewhere(record, stretch), *after_lock(record, stretch, identification.modes)]
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
        raise InputError(
            "several recordings are joined by likelihood; ",
            Argument("method", repr(settings.method)),
            " takes one at a time",
        )
    names = source_names(sources)
    begin(STEPS[0])
    opened = [_read(source, car, settings) for source in sources]
    begin(STEPS[1])
    stretches = []
    for name, one in zip(names, opened, strict=True):
        with naming(name):
            stretches.append(_alone(held(one.cleaned, "record"), settings, of_car=car is not None))
    whole = [set(as_signal(held(one.cleaned, "record")).channels) for one in opened]
    kept = [set(as_signal(stretch.record).channels) for stretch in stretches]
    shared = set.intersection(*kept) if all(names == whole[0] for names in whole) else set[str]()
    parts = [
        Part(source=k, name=name, record=record)
        for k, (name, one, stretch) in enumerate(zip(names, opened, stretches, strict=True))
        for record in _decays_of(one, stretch)
    ]
    if shared:
        # What one of them leaves out, as a channel of blows, is no motion in the others.
        parts = [replace(part, record=_only(part.record, shared)) for part in parts]
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


def _alone(record: control.TimeResponseData, settings: Settings, *, of_car: bool) -> Used:
    """Return the stretch of a recording that its analysis by itself ends with, at the rate of the recording."""
    with patience(), kept_tries():
        # One test may show fewer modes than are asked of all.
        free = replace(settings, modes=None)
        stretch = stretch_of(record, free)
        if part_asked_for(record, free) is not None or len(stretch.used) > 1:
            return stretch
        try:
            used = _found(record, free, lambda _: None, of_car=of_car, stretch=stretch)[2]
        except SuspidError:
            return stretch
    ends = as_signal(used.record)
    if len(used.used) > 1:
        return used
    part = cut(record, start=ends.start, stop=float(ends.timepts[-1]))
    return replace(used, record=of_channels(part, ends.channels))


def _only(record: control.TimeResponseData, names: set[str]) -> control.TimeResponseData:
    """Return some channels of a record, in its order."""
    return of_channels(record, tuple(name for name in as_signal(record).channels if name in names))


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
        raise InputError(Argument("car", f"{car!r:.80}"), " must be a Suspension; read_car reads one from a file")


def _asks_for_more(found: Identification, settings: Settings) -> bool:
    """Return whether a part that was asked for may hold a decay that begins later: no mode is found from its start on.

    Who names the end alone has not said where the decay begins: then a doubtful result does not tell, either.
    """
    return not len(found.modes) or (settings.start is None and found.verdict.level <= Level.DOUBTFUL)


def _found(
    record: control.TimeResponseData,
    settings: Settings,
    begin: Callable[[str], None],
    *,
    of_car: bool,
    stretch: Used | None = None,
) -> tuple[Identification, Repeats | None, Used]:
    """Return what is identified in the best decay of a record, and that decay; its stretch, if it is known."""
    with patience(), kept_tries():
        stretch = with_means(record, stretch_of(record, settings) if stretch is None else stretch, settings)
        if not of_car:
            stretch = with_fewer_channels(record, stretch, settings, stretch_of)
        stretch = with_means_of_longest(record, stretch, settings)
        begin(STEPS[2])
        return _identified(record, stretch, settings)


def _identified(
    whole: control.TimeResponseData, stretch: Used, settings: Settings
) -> tuple[Identification, Repeats | None, Used]:
    """Return the identification of the decay and, where several are used, that of all jointly; and what was used."""
    if len(stretch.used) < 2:
        stretch = without_clipped(stretch, settings)
        found = stretch.identification or identified(stretch.record, settings)
        wave, alone = of_a_wave(found, stretch, settings, whole)
        kept = supported(found, stretch, settings, whole=whole, wave=alone)
        asked = after_commands(whole, stretch, kept, settings)
        if asked is not None and asked.identification is not None:
            repeats = _jointly(whole, asked, settings) if len(asked.used) > 1 else None
            if repeats is None or len(repeats.modes):
                return asked.identification if repeats is None else repeats.each[0], repeats, asked
        other = other_part(whole, stretch, kept, settings, wave=wave)
        if other is not None and other.identification is not None:
            kept, stretch = other.identification, other
        elif wave:
            return kept, None, doubted_as_wave(stretch)
        kept, stretch = with_background(with_begun_tones(kept, whole), stretch, whole)
        return kept, None, stretch
    repeats = _jointly(whole, stretch, settings)
    return repeats.each[0], repeats, stretch


def _jointly(whole: control.TimeResponseData, stretch: Used, settings: Settings) -> Repeats:
    """Return what several decays of a record show jointly, in the channels that are used."""
    motion = of_channels(whole, as_signal(stretch.record).channels)
    return identify_repeats(motion, stretch.used, modes=settings.modes, band_hz=settings.band_hz)
