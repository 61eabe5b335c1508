"""Channels that do not move when the others do: sensors that are not connected, broken, or across the motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.analysis.used import without_channels
from suspid.levels import LEVEL
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Note, Remark

if TYPE_CHECKING:
    import control

# A record is compared in this many parts of at least this many samples: fewer hide when it moves, or by how much.
PARTS, LEAST_EACH = 40, 24
# A part moves if a channel has this many times the energy there that it has in the calmest quarter of the record; what
# moves less may be noise that changes.
MOVING, CALMEST = 25.0, 0.25
# What has more than this many times the energy of its calmest twentieth in no part is noise, or something steady.
NEARLY_STEADY, CALMEST_OF_ALL = 6.0, 0.05
# Unless its energy falls from part to part: the ranks of forty parts of noise have a correlation with time beyond this
# by a chance of one in a million, a decay has -1.
FALLS = -0.7


def without_idle(record: control.TimeResponseData) -> tuple[control.TimeResponseData, tuple[Remark, ...]]:
    """Return the record without channels that do not move when others do, and what was left out.

    Examples
    --------
    >>> from suspid.records import as_response
    >>> t = np.arange(4000) / 1000
    >>> noise = np.random.default_rng(1).standard_normal(4000)
    >>> record = as_response(t, np.stack([np.exp(-3 * t) * np.sin(40 * t), noise]), ["x", "not connected"])
    >>> left, notes = without_idle(record)
    >>> list(left.output_labels), len(notes)
    (['x'], 1)
    """
    return without_channels(record, idle(as_signal(record).values), Note.IDLE_CHANNEL)


def idle(values: RealArray) -> NDArray[np.bool_]:
    """Return which channels have the same noise, whether others move or not, (channel,).

    Examples
    --------
    A slow decay is no noise, though a channel beside it is knocked:

    >>> t = np.arange(4000) / 1000
    >>> motion = np.exp(-3 * t) * np.sin(40 * t)
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal((2, 4000))
    >>> idle(np.stack([motion, 0.03 * motion, 0.0 * motion])[:, ::-1] + np.append(noise, noise[:1, ::-1], axis=0))
    array([False, False,  True])
    >>> idle(np.stack([motion, np.exp(-0.2 * t) * np.sin(40 * t)]) + noise)
    array([False, False])
    """
    each = values.shape[1] // PARTS
    none = np.zeros(len(values), bool)
    if each < LEAST_EACH or len(values) < 2:
        return none
    about = values[:, : PARTS * each] - np.mean(values, axis=1, keepdims=True)
    parts = about.reshape(len(values), PARTS, each)
    energies = np.mean(parts**2, axis=2)
    calm = np.quantile(energies, CALMEST, axis=1)[:, None]
    moves = np.any(energies > MOVING * calm, axis=0)
    if not moves.any() or moves.all():
        return none
    least = np.quantile(energies, CALMEST_OF_ALL, axis=1)
    steady = (np.max(energies, axis=1) <= NEARLY_STEADY * least) & (_with_time(energies) > FALLS)
    return np.asarray(steady & _alike(parts[:, moves], parts[:, ~moves]))


def _with_time(energies: RealArray) -> RealArray:
    """Return the correlation of the ranks of energies (channel, part) with time, (channel,).

    Examples
    --------
    >>> _with_time(np.array([[9.0, 4.0, 1.0], [1.0, 3.0, 2.0]]))
    array([-1. ,  0.5])
    """
    times = np.arange(energies.shape[1])
    ranks = np.argsort(np.argsort(energies, axis=1), axis=1)
    return np.asarray(np.corrcoef(times, ranks)[0, 1:])


def _alike(there: RealArray, elsewhere: RealArray) -> NDArray[np.bool_]:
    """Return which channels have no more energy at any frequency in some parts than in others, but for chance.

    Both are (channel, part, sample).
    """
    from scipy.special import fdtrc

    window = np.hanning(there.shape[2])
    ours, theirs = (np.mean(np.abs(np.fft.rfft(window * part, axis=2)) ** 2, axis=1) for part in (there, elsewhere))
    chance = fdtrc(2 * there.shape[1], 2 * elsewhere.shape[1], ours / np.maximum(theirs, 1e-300))
    return np.asarray(np.min(chance, axis=1) > (1 - LEVEL) / ours.shape[1])
