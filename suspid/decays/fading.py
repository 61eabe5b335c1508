"""A decay that no sum of exponentials follows: swings so large that frequency and damping change with them."""

from __future__ import annotations

import numpy as np

from suspid.decays.decay import Decay
from suspid.decays.refusals import DECAYING_SHARE, DRIVEN
from suspid.decays.rests import as_decay
from suspid.decays.trials import unexplained
from suspid.errors import SuspidError
from suspid.identification import Identification, identify
from suspid.samples import as_samples, held
from suspid.signals import Signal, as_signal
from suspid.units import Decibel
from suspid.values import frozen_real
from suspid.words import DecayDoubt, Remark

# The record is split into this many parts, of which this many in a row must move less and less. By chance a motion that
# keeps its size does so once in 720 records; fewer parts are more often in order, more need more cycles.
FADING_PARTS, FEWEST_FALLING = 16, 6
# The motion falls by this much over those parts at least [neper]: then its damping is seen.
LEAST_FADED = 1.0
# Starts that are tried, as shares of the stretch. The first may fail where the swings are largest; from the middle on
# half of the amplitudes, on a logarithmic scale, are left.
FADING_STARTS = (0.0, 0.25, 0.5)


def decay_of_fading(signal: Signal, *, level: Decibel) -> Decay | None:
    """Return the decay in a record that moves less and less, from the first start at which `identify` explains it.

    It may have forces that are not linear. Swings before the start, of which the frequency changes more than those
    forces tell, are left out, and a doubt says so. None where the motion does not fall steadily, or no fit leaves less
    than what a linear decay may leave.

    Parameters
    ----------
    signal : Signal
        The recording.
    level : float
        Power above the background [dB], for the decay.

    Examples
    --------
    A tone of which the size falls and the frequency rises with it:

    >>> time = np.arange(3000) / 25
    >>> size = np.exp(-0.02 * time)
    >>> turned = np.cumsum(6.0 - 1.2 * size**2) / 25
    >>> signal = Signal(start=0.0, step=0.04, values=(size * np.cos(turned))[None], channels=("angle",))
    >>> found = decay_of_fading(signal, level=20.0)
    >>> found.wn.round(0), [doubt.code.value for doubt in found.doubts]
    (array([6.]), ['nonlinear'])
    """
    stretch = falling(signal)
    if stretch is None:
        return None
    first, last = stretch
    before = first
    for share in FADING_STARTS:
        begin = first + round(share * (last - first))
        found = _explained(signal, begin, last)
        if found is None:
            before = begin
            continue
        middle = (before + begin) // 2
        earlier = _explained(signal, middle, last) if begin > before else None
        begin, found = (begin, found) if earlier is None else (middle, earlier)
        later = Remark(DecayDoubt.LATER, {"first": float(signal.timepts[first]), "start": float(signal.timepts[begin])})
        return as_decay(found, signal, (begin, last), level=level, doubts=(later,) if begin > first else ())
    return None


def falling(signal: Signal) -> tuple[int, int] | None:
    """Return the samples between which a record moves less and less, the last excluded; None where it does not.

    The motion of a part is that about its own mean, of all channels, each relative to its largest.

    Examples
    --------
    >>> time = np.arange(1600) / 100
    >>> motion = np.where(time < 2, 0.0, np.exp(-0.3 * time) * np.cos(20 * time))
    >>> falling(Signal(start=0.0, step=0.01, values=motion[None], channels=("seat",)))
    (200, 1600)
    """
    size = signal.values.shape[1] // FADING_PARTS
    if size < 2:
        return None
    parts = signal.values[:, : FADING_PARTS * size].reshape(-1, FADING_PARTS, size)
    power = np.var(parts, axis=2)
    power = np.sum(power / np.maximum(np.max(power, axis=1, keepdims=True), 1e-300), axis=0)
    largest = int(np.argmax(power))
    falls = np.diff(power[largest:]) < 0
    count = falls.size if falls.all() else int(np.argmin(falls))
    if (
        count + 1 < FEWEST_FALLING
        or np.log(power[largest] / max(float(power[largest + count]), 1e-300)) < 2 * LEAST_FADED
    ):
        return None
    return largest * size, signal.values.shape[1] if falls.all() else (largest + count + 1) * size


def _explained(signal: Signal, begin: int, last: int) -> Identification | None:
    """Return what `identify` finds between two samples where that explains them as a linear decay is explained."""
    part = frozen_real(signal.values[:, begin:last])
    try:
        found = identify(as_samples(signal.timepts_of(begin, last), part, signal.channels))
    except SuspidError:
        return None
    if not len(found.modes):
        return None
    motion, left = as_signal(held(found, "fitted")).values, as_signal(held(found, "residual")).values
    about = motion - motion.mean(axis=1, keepdims=True)
    share = np.sum(about**2, axis=1) / np.sum((about + left) ** 2, axis=1)
    best = int(np.argmax(share))
    return found if share[best] > DECAYING_SHARE and unexplained(about, left)[best] <= DRIVEN else None
