"""Lines of something that turns: poles that together make one motion that goes on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from suspid.identification.selection import Selection
from suspid.units import ComplexArray, RealArray
from suspid.words import Reason

# Poles nearer to each other than this many resolutions of the record, ``2 pi / duration``, and than this share of
# their frequency are of one line: its speed wanders, and poles that lie closer follow it by turns. Larger numbers take
# modes for parts of a tone beside them.
REACH, WANDER = 3.5, 0.1
# A mode is none if what goes on beside it reaches this share of its first amplitude. A smaller share rejects modes
# beside hum.
COMPARABLE = 0.5
STEADY = (Reason.TONE, Reason.GROWING)


def without_lines(selection: Selection) -> Selection:
    """Return the poles of a record, of which those that are parts of a line that goes on are no modes.

    A shaft whose speed wanders is fitted by several poles, of which some decay by chance. They stay in the fit.
    """
    poles, count = selection.fit.poles.pairs, selection.fit.count
    reasons = list(selection.reasons)
    steady = np.array([reason in STEADY for reason in reasons[: len(poles)]], bool)
    if not np.any(steady):
        return selection
    line = lines_of(poles, count)
    amplitudes = np.abs(selection.fit.amplitudes[: len(poles)]) ** 2 / (selection.fit.squares + 1e-300)
    first = np.sqrt(np.sum(amplitudes, axis=1))
    largest = first * np.exp(np.maximum(poles.real, 0.0) * count)
    # Weakest first: parts of a line beside its strongest one are not steady themselves.
    for k in np.argsort(first).tolist():
        beside = steady & (line == line[k])
        if reasons[k] is None and np.sum(largest[beside]) > COMPARABLE * first[k]:
            reasons[k], steady[k] = Reason.LINE, True
    return replace(selection, reasons=tuple(reasons))


def lines_of(pairs: ComplexArray, count: int) -> NDArray[np.intp]:
    """Return the number of the line of each pair: poles of one line are within its reach of each other."""
    return _connected(pairs.imag, np.minimum(REACH * 2 * np.pi / count, WANDER * pairs.imag))


def _connected(frequencies: RealArray, reach: RealArray) -> NDArray[np.intp]:
    """Return the number of the group of each frequency; in order, one is within reach of the next of its group.

    Examples
    --------
    >>> _connected(np.array([3.0, 1.0, 3.4, 2.6]), np.full(4, 0.5))
    array([1, 0, 1, 1])
    """
    order = np.argsort(frequencies)
    groups = np.empty(len(order), np.intp)
    groups[order] = np.cumsum(np.diff(frequencies[order], prepend=frequencies[order[:1]]) > reach[order])
    return groups
