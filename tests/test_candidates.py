"""Search for the next pole: the largest local maxima of a spectrum."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import find_peaks

from suspid.identification.candidates import LOCAL_MAXIMA, _largest_peaks


def spectrum(kind: str, bins: int) -> NDArray[np.float32]:
    """Return a gain over bins: of noise, of noise on a hill that hides most of it, or of a hill alone."""
    noise = np.random.default_rng(bins).exponential(size=bins)
    hill = 1e6 / (1 + ((np.arange(bins) - bins / 3) / 20) ** 2)
    return np.asarray({"noise": noise, "noise on a hill": noise + hill, "hill": hill}[kind], np.float32)


@pytest.mark.parametrize("bins", [40, 3000, 100_000])
@pytest.mark.parametrize("kind", ["noise", "noise on a hill", "hill"])
def test_largest_peaks_are_those_of_scipy(kind: str, bins: int) -> None:
    """No two samples of these are equal, so that `find_peaks`, which wants a rise and a fall, has the same ones."""
    gain = spectrum(kind, bins)
    peaks, _ = find_peaks(gain)
    largest = peaks[np.argsort(-gain[peaks])][:LOCAL_MAXIMA]
    found = _largest_peaks(gain)
    # Of a hill alone, samples far from its top are equal in single precision: plateaus, which hold no pole.
    found = found[gain[found] > np.min(gain[largest])] if kind == "hill" else found
    largest = largest[gain[largest] > np.min(gain[largest])] if kind == "hill" else largest
    assert sorted(found) == sorted(largest)
