"""Traces: weak motion beside a strong mode, of which too little is known to tell it from what a sensor adds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.identification.selection import Selection
from suspid.levels import NORMAL_95
from suspid.model import ModalSet

# A trace in a single channel has less than the first share of the energy of the strongest mode, 30 dB less; in several,
# which show its shape, the second. Stuck codes of converters, plays and scales that bend make such; larger shares lose
# modes that a release hardly excites.
TRACE, TRACE_OF_SEVERAL = 1e-3, 1e-4
# Its damping is not known to the first share of it, so that neither half of a decay knows it to a third and none can be
# asked; or its frequency not to the second.
KNOWN_TO_HALF, HARDLY_PLACED = 0.5, 0.25


def traces(selection: Selection, modes: ModalSet) -> NDArray[np.bool_]:
    """Return which modes are traces, (mode,): weak beside the strongest one, and hardly known.

    ``modes`` are those of the selection by their natural frequency, with the intervals that are shown.
    """
    fit, order = selection.fit, selection.modes_by_wn
    if len(order) < 2 or modes.wn_std is None or modes.zeta_std is None:
        return np.zeros(len(order), bool)
    # The squares of a motion that falls at this rate, over the record; a small rate, of one that stays.
    rate = np.minimum(2 * fit.poles.every[order].real, -1e-9)
    energy = fit.strengths[order] * np.expm1(rate * fit.count) / rate
    share = TRACE if len(fit.squares) == 1 else TRACE_OF_SEVERAL
    hardly = NORMAL_95 * modes.zeta_std > KNOWN_TO_HALF * np.abs(modes.zeta)
    hardly |= NORMAL_95 * modes.wn_std > HARDLY_PLACED * modes.wn
    return np.asarray((modes.poles.imag > 0) & hardly & (energy < share * np.max(energy)))
