"""The wavelet of least entropy: Eq. (14)-(17)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.errors import InputError
from suspid.results import Result
from suspid.signals import as_signal
from suspid.units import Hertz, Radian, RadianPerSecond, RealArray
from suspid.values import frozen_real
from suspid.wavelets.morlet import Morlet
from suspid.wavelets.rows import BLOCK
from suspid.wavelets.scalogram import Scalogram
from suspid.wavelets.transform import row_frequencies, transform

# Bandwidths N of the wavelet that are tried: long wavelets suit light damping, more of them cost time.
BANDWIDTHS = range(1, 51)
# Precision of the transform. A larger value is faster; the accuracy stated in `best_bandwidth` needs this one.
ENTROPY_CUT = 1e-8


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class BandwidthSearch(Result):
    """Wavelet entropy against bandwidth.

    Parameters
    ----------
    candidates : ndarray (candidate,)
        Bandwidths N.
    entropy : ndarray (candidate,)
        Entropy of the transform with each bandwidth [nat].

    Examples
    --------
    >>> from suspid import as_record, best_bandwidth
    >>> t = np.arange(0, 10, 0.02)
    >>> found = best_bandwidth(as_record(np.exp(-0.3 * t) * np.cos(20 * t), timepts=t), candidates=[1, 8, 64, 512])
    >>> found.best, found.at_end
    (64.0, False)
    """

    candidates: RealArray
    entropy: RealArray

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {"bandwidth": self.candidates.tolist(), "entropy_nat": self.entropy.tolist()}

    @property
    def best(self) -> float:
        """N of least entropy.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, best_bandwidth
        >>> t = np.arange(0, 4, 0.01)
        >>> search = best_bandwidth(as_record(np.exp(-t) * np.cos(20 * t), timepts=t), candidates=[2.0, 4.0, 8.0])
        >>> search.best == search.candidates[np.argmin(search.entropy)]
        np.True_
        """
        return float(self.candidates[np.argmin(self.entropy)])

    @property
    def at_end(self) -> bool:
        """Whether the least entropy lies at an end of the candidates: then their range is too small.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import BandwidthSearch
        >>> tried = np.array([2.0, 4.0, 8.0])
        >>> BandwidthSearch(candidates=tried, entropy=np.array([3.0, 2.0, 3.0])).at_end
        False
        >>> BandwidthSearch(candidates=tried, entropy=np.array([1.0, 2.0, 3.0])).at_end
        True
        """
        return self.best in (np.min(self.candidates), np.max(self.candidates))

    def __str__(self) -> str:
        low, high = float(np.min(self.candidates)), float(np.max(self.candidates))
        end = ", an end of the range" if self.at_end else ""
        return f"least entropy {np.min(self.entropy):.4g} nat at N = {self.best:g}{end}; tried {low:g} to {high:g}"


@explained
def best_bandwidth(
    response: RecordLike,
    *,
    fs: Hertz | None = None,
    omega: Sequence[RadianPerSecond] | RealArray | None = None,
    candidates: Iterable[float] = BANDWIDTHS,
    center: Radian = 2 * np.pi,
) -> BandwidthSearch:
    """Return the wavelet entropy of the record against the bandwidth N, Eq. (14).

    ``WE(N) = -sum_j p_j log p_j`` over all coefficients j of the transform, that is over channel, row and time within
    the record, with ``p_j = |CWT_j|^2 / sum |CWT|^2`` in the normalisation of the paper. Rows are stored at their own
    rate and a sample is weighted by the samples of the record that it represents: the entropy is that of the full-rate
    transform within 2e-3 nat (5e-3 if an envelope is longer than the record).

    Least entropy means fewest large coefficients. The entropy over scale alone decreases with every N; the joint
    entropy has a minimum because long wavelets smear the decay and reach beyond the ends of the record. It depends on
    the length of the record and on ``omega``: state both with any N.

    Parameters
    ----------
    response : control.TimeResponseData, or what `as_record` takes
        The record.
    fs : float, optional
        Sampling rate [Hz] of samples that come without a time.
    omega : array_like (row,), optional
        Angular frequencies [rad/s]. Default: as in `cwt`.
    candidates : iterable of float
        Bandwidths to try.
    center : float
        w0 [rad].

    Returns
    -------
    BandwidthSearch
        Entropy against bandwidth; `BandwidthSearch.best` is the bandwidth of least entropy.

    Raises
    ------
    InputError
        As `cwt`, or if there are no candidates, or the record is zero throughout.

    Examples
    --------
    >>> import numpy as np, control
    >>> t = np.arange(0, 10, 0.02)
    >>> decay = control.TimeResponseData(t, np.exp(-0.3 * t) * np.cos(20 * t), issiso=True, output_labels=["seat"])
    >>> best_bandwidth(decay, omega=np.geomspace(10, 40, 60), candidates=[1, 8, 64, 512]).best
    64.0
    """
    signal = as_signal(as_record(response, fs=fs))
    rows = row_frequencies(signal) if omega is None else np.atleast_1d(np.asarray(omega, float))
    tried = np.array([float(n) for n in candidates])
    if not tried.size:
        raise InputError("candidates is empty; give at least one bandwidth")
    if not np.any(signal.values):
        raise InputError("the record is zero throughout and has no entropy; choose channels that move")
    wavelets = [Morlet(center=center, bandwidth=n) for n in tried]
    entropy = [_entropy(transform(signal, omega=rows, wavelet=w, precision=ENTROPY_CUT)) for w in wavelets]
    return BandwidthSearch(candidates=frozen_real(tried), entropy=frozen_real(entropy))


def _entropy(scalogram: Scalogram) -> float:
    """Return ``-sum p log p`` with ``p = e / E``, as ``log E - sum e log e / E``."""
    total = weighted = 0.0
    strides = np.array(scalogram.strides)
    for stride in np.unique(strides):
        # Rows of one rate have one length and one set of weights.
        alike = np.flatnonzero(strides == stride)
        counts = scalogram.weights(int(alike[0]))
        at_once = max(1, BLOCK // scalogram.rows[alike[0]].size)
        for some in np.array_split(alike, -(-len(alike) // at_once)):
            rows = np.concatenate([scalogram.rows[i] for i in some])
            energy = rows.real**2 + rows.imag**2
            total += float(np.sum(energy @ counts))
            energy *= np.log(np.where(energy > 0, energy, 1.0))
            weighted += float(np.sum(energy @ counts))
    return float(np.log(total) - weighted / total)
