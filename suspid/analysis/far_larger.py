"""Choice between decays that are all doubtful: one that holds far more of the motion than the others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.used import Used
from suspid.identification import Identification
from suspid.signals import as_signal
from suspid.units import RealArray

if TYPE_CHECKING:
    import control

# Of two decays that are both doubtful, one with more than this many times the energy of the other is used: a tenth of
# the amplitude is seen beside the noise, and not as the event.
FAR_MORE = 100.0


def far_larger(record: control.TimeResponseData, tries: Sequence[Used]) -> Used:
    """Return the first of several decays that are all doubtful, or one that holds far more of the motion.

    A knock in the calm end of a record looks like a decay more often than the motion that was to be recorded.
    """
    whole = as_signal(record).values
    about = np.sum((whole - whole.mean(axis=1, keepdims=True)) ** 2, axis=1)
    shares = [0.0 if one.identification is None else _share(one.identification, about) for one in tries]
    most = int(np.argmax(shares))
    return tries[most] if shares[most] > FAR_MORE * shares[0] else tries[0]


def _share(found: Identification, about: RealArray) -> float:
    """Return the share of the energy of a record that the modes of a part explain, in the best of its channels."""
    if not len(found.modes):
        return 0.0
    fitted = as_signal(found.fitted).values
    return float(np.max(np.sum((fitted - fitted.mean(axis=1, keepdims=True)) ** 2, axis=1) / np.maximum(about, 1e-300)))
