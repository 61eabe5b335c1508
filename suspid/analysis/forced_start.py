"""Whether a force still acts at the start of a decay: short modes that are hardly known stand for its end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.identification import FORCED, Considered, Identification, flashes, removed_as
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Second
from suspid.words import Reason, Remark

if TYPE_CHECKING:
    import control

# A mode whose frequency has at least this relative standard deviation may be a force that ends. Heavily damped modes
# that matter are known to 1 % at a signal-to-noise ratio of 40 dB.
HARDLY_KNOWN = 0.025
# One whose frequency is not known to this is tried so even where nothing drove the record: it is of no use.
OF_NO_USE = 0.1
# Later starts that are tried, in periods of the slowest mode that is known better.
PERIODS_LATER = (0.25, 0.5, 1.0, 1.5)
# The record is driven before the decay if it moves by this many times the noise from `PERIODS_BEFORE` periods to half a
# period before the start: a bump is shorter, and a held mass only shows the noise.
DRIVEN_BEFORE, PERIODS_BEFORE, SLOW_RELEASE = 10.0, 2.0, 0.2
# What is over in a few samples is left out by a start where it has fallen by these [neper].
FLASH_OVER = (1.0, 3.0)
# A mass is at rest for at least this many samples, and has moved where two in a row are this many standard deviations
# of the noise from the mean of those before.
FEWEST_AT_REST, MOVED = 3, 4.0
# A mode is the same if its pole lies within this share of its modulus.
SAME_POLE = 0.05


def later_starts(record: control.TimeResponseData, found: Identification) -> Iterator[Second]:
    """Yield how much later a decay may begin: nothing where no pole stands for a force before it, or for the start."""
    blow = behind_blow(found)
    if blow is not None:
        yield blow
    brief = flashes(found)
    if brief.any() and not brief.all():
        # The search for decays may begin one a few samples before its release.
        yield from (nepers / float(np.min(-found.modes.poles.real[brief])) for nepers in FLASH_OVER)
    hardly = _hardly_known(found)
    if not hardly.any() or hardly.all():
        return
    rests = _rests_for(found)
    if rests:
        yield rests
    period = 2 * np.pi / float(np.min(found.modes.wn[~hardly]))
    std = found.modes.wn_std
    of_no_use = std is not None and bool(np.max(std / found.modes.wn) > OF_NO_USE)
    if of_no_use or _driven_before(record, found, period):
        yield from (share * period for share in PERIODS_LATER)


def behind_blow(found: Identification) -> Second | None:
    """Return how much later motion begins than what was identified, where its first samples are of a blow; else None.

    The poles that stand for a blow are gone by then.
    """
    brief = [-c.pole.real for c in removed_as(found.considered, *FORCED) if c.pole.real < 0]
    return FLASH_OVER[-1] / min(brief) if brief else None


def without_start(found: Identification, later: Identification, *, released: bool = False) -> Identification:
    """Return what a later start has, with what was left out among the poles that were considered.

    Where a mass was ``released`` from rest, no force may have acted: that is said with the verdict.
    """
    apart = np.min(np.abs(found.modes.poles[:, None] - later.modes.poles), axis=1)
    lost = found.modes.poles[apart >= SAME_POLE * found.modes.wn]
    remark = Remark(Reason.OF_START, {"released": True} if released else {})
    said = tuple(Considered(pole=complex(pole), remark=remark, removed=False) for pole in lost)
    return replace(later, considered=(*later.considered, *said))


def freed(found: Identification, later: Identification) -> bool:
    """Return whether a later start has the modes that are well known, and no others."""
    kept = found.modes.poles[~(_hardly_known(found) | flashes(found))]
    if len(later.modes) != len(kept):
        return False
    apart = np.abs(kept[:, None] - later.modes.poles)
    return bool(np.all(np.min(apart, axis=1) < SAME_POLE * np.abs(kept)))


def _hardly_known(found: Identification) -> NDArray[np.bool_]:
    std = found.modes.wn_std
    return np.zeros(len(found.modes), bool) if std is None else np.asarray(std > HARDLY_KNOWN * found.modes.wn)


def _rests_for(found: Identification) -> Second:
    """Return for how long all channels of what was identified rest before they move; 0 where they move at once."""
    signal = as_signal(held(found, "response"))
    first = signal.values[:, : signal.values.shape[1] // 2]
    # The mean of the samples before each one, from the third on.
    means = np.cumsum(first, axis=1)[:, FEWEST_AT_REST - 1 : -1] / np.arange(FEWEST_AT_REST, first.shape[1])
    moved = np.any(np.abs(first[:, FEWEST_AT_REST:] - means) > MOVED * found.noise_std[:, None], axis=0)
    # Of white noise, one sample alone may be as far from the others.
    both = np.flatnonzero(moved[:-1] & moved[1:])
    return signal.step * (FEWEST_AT_REST + int(both[0])) if both.size and both[0] else 0.0


def _driven_before(record: control.TimeResponseData, found: Identification, period: Second) -> bool:
    """Return whether the record moves for longer than a bump before the first sample of an identification."""
    signal, fitted = as_signal(record), as_signal(held(found, "residual"))
    start, channels = fitted.start, [signal.channels.index(name) for name in fitted.channels]
    time = signal.timepts
    before = (time >= start - PERIODS_BEFORE * period) & (time < start - SLOW_RELEASE * period)
    if not before.any():
        return False
    values = signal.values[channels][:, before]
    moved = np.max(np.abs(values - np.median(values, axis=1, keepdims=True)), axis=1)
    return bool(np.any(moved > DRIVEN_BEFORE * found.noise_std))
