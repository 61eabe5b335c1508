"""Decays beside which a record moves far more: of several that are doubtful another is used, and else it is said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.used import Used
from suspid.decays import SAME_MODE, Decay
from suspid.identification import LEAST_EXPLAINED, Identification
from suspid.levels import FEWEST_SAMPLES, NORMAL_95
from suspid.model import ModalSet
from suspid.samples import held
from suspid.signals import Signal, as_signal
from suspid.units import Flags, Ratio, RealArray, Second
from suspid.words import Level, ModeCheck, Note, Remark

if TYPE_CHECKING:
    import control

# Of two decays that are both doubtful, one with more than this many times the energy of the other is used: a tenth of
# the amplitude is seen beside the noise, and not as the event.
FAR_MORE = 100.0
# A decay is the end of another that has this many times its energy: a third of the amplitude.
MORE = 10.0
# A decay that holds less than this share of the energy of its record may be a part of what is seen. A larger share
# costs the time of more identifications where a record holds many decays.
HARDLY_ANY = 0.03
# Parts of this share of a decay are compared where there is no room for longer ones.
QUARTER = 4
# A motion is slower than another by this factor: a body beside the same body on its tires alone.
SLOWER = 1.5
# Two damping ratios are unlike if they differ by this share, and beyond chance: friction doubles that of the last
# swings, and a decay whose damping is the same from any start is as well known by its end.
UNLIKE = 0.25
# So are two natural frequencies that differ by this share.
UNLIKE_WN = 0.01
# What is said of a fit that leaves a good part of the motion.
LEAVES_MUCH = frozenset({ModeCheck.LITTLE_EXPLAINED, ModeCheck.HARDLY_EXPLAINED})


def far_larger(record: control.TimeResponseData, tries: Sequence[Used]) -> Used:
    """Return the first of several decays that are all doubtful, or one that holds far more of the motion.

    A knock in the calm end of a record looks like a decay more often than the motion that was to be recorded.
    """
    about = _energies(as_signal(record))
    shares = [0.0 if one.identification is None else _share(one.identification, about) for one in tries]
    most = int(np.argmax(shares))
    return tries[most] if shares[most] > FAR_MORE * shares[0] else tries[0]


def only_the_end(whole: Identification, part: Identification | None) -> bool:
    """Return whether a part of a decay is its end, with far less energy, and tells less than the whole.

    Where friction stops what swings, or where a sensor is coarse, the last swings look like a linear decay. The whole
    tells more if forces explain it as well as the end is explained, if its damping is another one, or if they show
    another frequency or damping of larger swings: an end that is linear beyond doubt says nothing of those. One that
    leaves much of itself is no decay: what is pushed again is not that of its last part.
    """
    if part is None or not len(part.modes) or not len(whole.modes):
        return False
    if any(check.remark.code in LEAVES_MUCH for check in whole.verdict.checks):
        return False
    ours, theirs = (_energies(as_signal(held(found, "fitted"))) for found in (whole, part))
    # What a channel carries beside noise tells.
    moved = [name for name, share in zip(theirs, part.explained.tolist(), strict=True) if share > LEAST_EXPLAINED]
    if set(ours) != set(theirs) or not all(ours[name] > MORE * theirs[name] for name in moved or theirs):
        return False
    modes, ends = whole.modes, part.modes
    if modes.zeta_std is None or ends.zeta_std is None:
        return False
    nearest = np.argmin(np.abs(ends.wn[:, None] - modes.wn), axis=1)
    if np.any(np.abs(modes.wn[nearest] / ends.wn - 1) > SAME_MODE):
        return False
    if whole.forces and (whole.verdict.level >= part.verdict.level or _larger_are_unlike(whole, ends)):
        return True
    unlike = _unlike(modes.zeta[nearest], modes.zeta_std[nearest], ends.zeta, ends.zeta_std, UNLIKE)
    return bool(np.any(unlike))


def _larger_are_unlike(whole: Identification, ends: ModalSet) -> bool:
    """Return whether swings of a decay that is not doubtful have another frequency or damping than its end."""
    if whole.verdict.level <= Level.DOUBTFUL or ends.wn_std is None or ends.zeta_std is None:
        return False
    for each in whole.amplitude_dependence:
        one, swings = int(np.argmin(np.abs(ends.wn - np.median(each.wn)))), each.known
        by_wn = _unlike(swings.wn, swings.wn_std, ends.wn[one], ends.wn_std[one], UNLIKE_WN)
        by_zeta = _unlike(swings.zeta, swings.zeta_std, ends.zeta[one], ends.zeta_std[one], UNLIKE)
        if np.any(by_wn | by_zeta):
            return True
    return False


def _unlike(
    larger: RealArray, larger_std: RealArray, end: RealArray | float, end_std: RealArray | float, share: Ratio
) -> Flags:
    """Return which values of larger swings differ from those of their end beyond chance, and by a share of these."""
    chance = NORMAL_95 * np.hypot(larger_std, end_std)
    return np.asarray(np.abs(larger - end) > np.maximum(chance, share * end))


def larger_elsewhere(record: control.TimeResponseData, stretch: Used) -> tuple[Remark, ...]:
    """Return the note that every channel of a decay moves far more in another part of the record.

    Parts of the same length are compared, as a knock at the end of a record is short beside what was to be recorded; or
    of a quarter of that, where the rest of the record is shorter. A channel that is held does not move. Before that, a
    quarter of the decay is compared with what it follows at once: where one channel moves far more, and more slowly
    than any of the modes, it is the end of that motion.

    Examples
    --------
    >>> from suspid.records import as_response, cut
    >>> t = np.arange(1000) / 100
    >>> knock = np.where(t > 8, np.exp(8 - t), 0.0) * np.sin(40 * t)
    >>> record = as_response(t, (np.exp(-t) * np.sin(9 * t) + 1e-3 * knock)[None], ["seat"])
    >>> used = Used(record=cut(record, start=8.0), decays=(), used=(), notes=())
    >>> [str(note) for note in larger_elsewhere(record, used)]
    ['elsewhere the record moves 942 times as much (rms), most about 1.03 s: start and stop choose another part']
    """
    signal, part = as_signal(record), as_signal(stretch.record)
    size, first = signal.values.shape[1], round((part.start - signal.start) / signal.step)
    last = first + part.values.shape[1]
    rows = [signal.channels.index(name) for name in part.channels if name in signal.channels]
    if len(rows) < len(part.channels):
        return ()
    values, count = signal.values[rows], last - first
    room = max(first, size - last)
    # The end of a motion need not be its end in every channel.
    looks = ((count // QUARTER, np.max, True), (count if count <= room else count // QUARTER, np.min, False))
    for length, over_channels, follows in looks:
        # The last samples before, or all.
        of = slice(max(0, first - 3 * length // 2), first) if follows else slice(0, size)
        starts = np.arange(of.start, of.stop - length + 1)
        at = starts[(starts + length <= first) | (starts >= last)]
        if length < FEWEST_SAMPLES or not at.size:
            continue
        own = np.max(_powers(part.values, length), axis=1)
        power = _powers(values[:, of], length)[:, at - of.start]
        more = over_channels(power / np.maximum(own, 1e-300)[:, None], axis=0)
        most = int(np.argmax(more))
        if not FAR_MORE < more[most] < np.inf:
            continue
        if not follows or _moves_slower(values[:, at[most] : at[most] + length], signal.step, stretch):
            time = signal.start + signal.step * float(at[most] + length / 2)
            said = {"times": float(np.sqrt(more[most])), "time": time, "follows": follows}
            return (Remark(Note.LARGER_ELSEWHERE, said),)
    return ()


def _moves_slower(before: RealArray, step: Second, stretch: Used) -> bool:
    """Return whether a motion is slower than any mode of the stretch after it: friction holds what moved slowly."""
    if stretch.identification is None or not len(stretch.identification.modes):
        return True
    bent = before - before.mean(axis=1, keepdims=True)
    power = np.abs(np.fft.rfft(bent * np.hanning(before.shape[1]), axis=1)) ** 2
    strongest = power[np.argmax(np.sum(power, axis=1))]
    wn = 2 * np.pi * float(np.argmax(strongest)) / (before.shape[1] * step)
    return bool(wn * SLOWER < float(np.min(stretch.identification.modes.wn)))


def _powers(values: RealArray, count: int) -> RealArray:
    """Return the energy about their mean of each run of a number of samples, (channel, run)."""
    about = values - values.mean(axis=1, keepdims=True)
    sums, squares = (np.pad(np.cumsum(about**n, axis=1), ((0, 0), (1, 0))) for n in (1, 2))
    means = (sums[:, count:] - sums[:, :-count]) / count
    return np.asarray(squares[:, count:] - squares[:, :-count] - count * means**2)


def time_of(note: Remark) -> Second:
    """Return when a record moves far more, by the note that says so."""
    return float(str(note.numbers["time"]))


def shows_the_same(decays: Sequence[Decay], time: Second, modes: ModalSet) -> bool:
    """Return whether a decay about a time has all of the modes, as far as a quick fit tells."""
    there = [decay.wn for decay in decays if decay.start <= time <= decay.stop and decay.wn.size]
    apart = [np.min(np.abs(modes.wn[:, None] / wn - 1), axis=1) for wn in there]
    return any(bool(np.all(each < UNLIKE_WN)) for each in apart)


def hardly_any(record: control.TimeResponseData, stretch: Used) -> bool:
    """Return whether a part holds next to nothing of the energy of each of its channels in a record.

    One swing of a beat, or of a bell, looks like a decay that ends where the next begins.
    """
    about, part = _energies(as_signal(record)), _energies(as_signal(stretch.record))
    return all(own < HARDLY_ANY * about.get(name, 0.0) for name, own in part.items())


def _share(found: Identification, about: Mapping[str, float]) -> float:
    """Return the share of the energy of a record, by channel, that the modes of a part explain in its best channel."""
    if not len(found.modes):
        return 0.0
    return max(own / max(about[name], 1e-300) for name, own in _energies(as_signal(held(found, "fitted"))).items())


def _energies(signal: Signal) -> dict[str, float]:
    """Return the energy of each channel about its mean."""
    about = signal.values - signal.values.mean(axis=1, keepdims=True)
    return dict(zip(signal.channels, np.sum(about**2, axis=1).tolist(), strict=True))
