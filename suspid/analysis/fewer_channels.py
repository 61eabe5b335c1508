"""Fewer channels of a record, where some of them make the result doubtful: a sensor that hardly moves, a mark."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.analysis.choice import FAR_FROM_NOISE, NO_CYCLE, level_of, settled_by_forces
from suspid.analysis.forced_start import SAME_POLE
from suspid.analysis.longer import with_identification
from suspid.analysis.settings import Settings
from suspid.analysis.shown_modes import shared_modes
from suspid.analysis.swelling import left_by_modes
from suspid.analysis.used import Used, without_channels
from suspid.cleaning import is_clipped
from suspid.decays import DRIVEN
from suspid.errors import SuspidError
from suspid.identification import Identification
from suspid.model import ModalSet
from suspid.records import cut, of_channels
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Level, Note, Remark

if TYPE_CHECKING:
    import control

# Where no mode was found, channels with less than this share of their energy outside half an octave about their peak
# are tried alone, at most the second number: each takes the time of an analysis.
STRAY, TRIED_ALONE = 0.1, 2
# Of the channels that stay, a fit leaves this many times less: what crosses a swing, and moves twice a cycle,
# bends it.
FAR_CLOSER = 2.0
# A channel that moves at the frequency of a mode shows another one where this share of its energy is not that mode's.
ANOTHER = 0.02
# Modes are close whose frequencies are within this factor: pitch and bounce of a car.
CLOSE_MODES = 1.4
# Multiples of a mode that a channel may show alone: what moves across it has the second, springs that bend the third.
SHOWN_ALONE = (2, 3)


def with_fewer_channels(
    record: control.TimeResponseData,
    used: Used,
    settings: Settings,
    stretch_of: Callable[[control.TimeResponseData, Settings], Used],
) -> Used:
    """Return the part of a record that is used of fewer channels, if that of all is doubtful, has no mode, or is loose.

    First those are left out of whose motion the fit leaves too much, then all but the one of which it leaves least;
    where there is no mode, all but one that moves most at one frequency.
    What is found then must be less doubtful, or be the same modes with far less left of the channels that stay. Where
    channels are named, all of those are used.
    """
    if settings.channels is not None or settings.decay != "auto" or settings.method != "likelihood":
        return used
    names = as_signal(used.record).channels
    if len(names) < 2:
        return used
    used = with_identification(used, settings)
    found = used.identification
    before = Level.NONE if found is None else level_of(found, used.used, used.decays)
    if found is None or (before > Level.DOUBTFUL and np.max(found.loudness, initial=0.0) < FAR_FROM_NOISE):
        return used
    # Forces between channels that leave only noise need all of them.
    if settled_by_forces(found) and any(force.other is not None for force in found.forces):
        return used
    tries = _fewer(names, found.explained) if len(found.modes) else _alone(names, _beside_peak(found))
    for kept in tries:
        try:
            fewer = stretch_of(of_channels(record, kept), settings)
        except SuspidError:
            continue
        again = with_identification(fewer, settings).identification
        if again is None or multiples_alone(found.modes, again.modes):
            continue
        out = tuple(name for name in names if name not in kept)
        others = of_channels(record, out)
        if _otherwise(others, again) or _loses_a_close_mode(others, again, found):
            continue
        level = level_of(again, fewer.used, fewer.decays)
        clearer = level > before if before <= Level.DOUBTFUL else level >= before and _far_closer(again, found)
        if clearer and not _louder(again, found):
            return replace(
                fewer, identification=again, notes=(Remark(Note.FEWER_CHANNELS, {"names": out}), *fewer.notes)
            )
    return used


def _otherwise(others: control.TimeResponseData, found: Identification) -> bool:
    """Return whether a channel moves at the frequency of a mode that was found in others, but not as that mode does.

    It shows a second mode close to the first. The motion of one is that of the fit, in any phase.
    """
    fitted = as_signal(held(found, "fitted"))
    motion = as_signal(cut(others, start=fitted.start - 0.5 * fitted.step, stop=float(fitted.timepts[-1])))
    count = min(motion.values.shape[1], fitted.values.shape[1])
    if abs(motion.step / fitted.step - 1) > SAME_POLE or not len(found.modes):
        return False
    beside, peaks = _about_peaks(motion.values)
    cycles = motion.duration * found.modes.wn / (2 * np.pi)
    near = np.min(np.abs(np.log2(np.maximum(peaks, 1)[:, None] / cycles)), axis=1) < 0.5
    own = fitted.values[:, :count]
    together = replace(motion, values=motion.values[:, :count])
    left = left_by_modes(together, found.modes, beside=(*own, *np.gradient(own, axis=1)))
    own_left = 1 - float(np.min(found.explained))
    return bool(np.any(near & (beside < STRAY) & (left - beside > max(ANOTHER, FAR_CLOSER * own_left))))


def _loses_a_close_mode(others: control.TimeResponseData, fewer: Identification, found: Identification) -> bool:
    """Return whether fewer channels show fewer modes near each other, and the others tell that there are more.

    Close modes have shapes: what tells one from the next is how several channels move.
    """
    swing = found.modes[(found.modes.poles.imag > 0) & (found.modes.zeta < NO_CYCLE)]
    of_all, of_fewer = (
        np.sum(np.abs(np.log(modes.wn[:, None] / fewer.modes.wn)) < np.log(CLOSE_MODES), axis=0)
        for modes in (swing, fewer.modes)
    )
    if not np.any(of_all > of_fewer):
        return False
    ours, theirs = (as_signal(held(each, "response")) for each in (fewer, found))
    start, stop = max(ours.start, theirs.start), float(min(ours.timepts[-1], theirs.timepts[-1]))
    if stop - start < 0.5 * ours.duration:
        return False
    motion = as_signal(cut(others, start=start, stop=stop))
    left, least = (left_by_modes(motion, modes) for modes in (fewer.modes, found.modes))
    return bool(np.any((least < STRAY) & (left > FAR_CLOSER * least)))


def _louder(fewer: Identification, found: Identification) -> bool:
    """Return whether a fit to fewer channels leaves far more than noise, where that to all explains each of them."""
    ours, theirs = (float(np.max(each.loudness, initial=0.0)) for each in (fewer, found))
    return ours > max(FAR_FROM_NOISE, theirs) and bool(np.min(found.explained) >= 1 - DRIVEN**2)


def _far_closer(fewer: Identification, found: Identification) -> bool:
    """Return whether a fit to fewer channels has the same modes and leaves far less of each channel."""
    rows = [found.modes.channels.index(name) for name in fewer.modes.channels]
    closer = np.all(FAR_CLOSER * fewer.noise_std < found.noise_std[rows])
    return bool(closer) and min(shared_modes([fewer, found])) == 1.0


def without_clipped(used: Used, settings: Settings) -> Used:
    """Return the part of a record that is used without channels that are clipped in it, if others are left.

    Where channels are named, or an identification has gone well, all of those stay.
    """
    if settings.channels is not None or used.identification is not None:
        return used
    clipped = np.array([is_clipped(samples) for samples in as_signal(used.record).values])
    record, notes = without_channels(used.record, clipped, Note.CLIPPED_CHANNEL)
    return replace(used, record=record, notes=(*notes, *used.notes))


def multiples_alone(of_all: ModalSet, of_fewer: ModalSet) -> bool:
    """Return whether fewer channels only show multiples of modes that all channels show.

    A sensor across the motion of a pendulum, or of a tower, moves twice a cycle: what it shows alone is no mode.
    """
    ratios = of_fewer.wn[:, None] / of_all.wn
    lacking = np.all(np.abs(ratios - 1) > SAME_POLE, axis=0)
    multiple = np.any([np.abs(ratios / times - 1) < SAME_POLE for times in SHOWN_ALONE], axis=0) & lacking
    return bool(len(of_fewer)) and bool(np.all(np.any(multiple, axis=1)))


def _beside_peak(found: Identification) -> RealArray:
    """Return the share of the energy of each channel that lies outside half an octave about its peak, (channel,)."""
    return _about_peaks(as_signal(held(found, "response")).values)[0]


def _about_peaks(values: RealArray) -> tuple[RealArray, NDArray[np.intp]]:
    """Return the share of the energy outside half an octave about the peak of each channel, and the peaks."""
    window = np.hanning(values.shape[1])
    power = np.abs(np.fft.rfft((values - values.mean(axis=1, keepdims=True)) * window, axis=1)) ** 2
    # What makes fewer cycles is drift.
    power[:, :3] = 0.0
    peaks, places = np.argmax(power, axis=1), np.arange(power.shape[1])
    near = np.abs(np.log2(np.maximum(places, 1) / np.maximum(peaks, 1)[:, None])) < 0.5
    return 1 - np.sum(power * near, axis=1) / np.maximum(np.sum(power, axis=1), 1e-300), peaks


def _fewer(names: tuple[str, ...], explained: RealArray) -> list[list[str]]:
    """Return the sets of channels to try: those that a fit explains, and the one that it explains best."""
    most = float(np.max(explained))
    kept = [name for name, share in zip(names, explained, strict=True) if share >= min(1 - DRIVEN**2, most)]
    best = [names[int(np.argmax(explained))]]
    return [tried for tried in ([kept] if kept != best else []) + [best] if len(tried) < len(names)]


def _alone(names: tuple[str, ...], strays: RealArray) -> list[list[str]]:
    """Return single channels to try where no mode was found: those whose motion is most of one frequency."""
    order = np.argsort(strays, kind="stable")[:TRIED_ALONE].tolist()
    return [[names[k]] for k in order if strays[k] < STRAY]
