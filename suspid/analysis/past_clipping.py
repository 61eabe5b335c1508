"""Start of a decay after the samples in which a blow exceeds the range of a sensor."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import clipped_run
from suspid.decays import Decay
from suspid.records import cut
from suspid.signals import as_signal
from suspid.words import DecayDoubt

if TYPE_CHECKING:
    import control

# Clipped samples within this part of a decay are left out, with what is before them. With less than the rest of it the
# decay would not be known.
FIRST_PART = 0.25
# Doubts that end with the clipped samples of a decay.
OF_CLIPPING = frozenset({DecayDoubt.CLIPPED, DecayDoubt.NOT_IDENTIFIED})


def past_clipping(record: control.TimeResponseData, decay: Decay) -> Decay:
    """Return a decay from after its clipped samples on, if these lie in its first part: a blow exceeds the range."""
    if not any(doubt.code is DecayDoubt.CLIPPED for doubt in decay.doubts):
        return decay
    signal = as_signal(cut(record, start=decay.start, stop=decay.stop))
    last = -1
    for samples in signal.values:
        for largest in (True, False):
            run = clipped_run(samples, largest=largest)
            last = last if run is None else max(last, int(np.flatnonzero(samples == samples[run[0]])[-1]))
    if not 0 <= last < FIRST_PART * signal.values.shape[1]:
        return decay
    kept = tuple(doubt for doubt in decay.doubts if doubt.code not in OF_CLIPPING)
    return replace(decay, start=float(signal.timepts[last + 1]), doubts=kept)
