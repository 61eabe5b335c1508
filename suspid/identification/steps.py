"""The wavelet steps on one record."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import IdentificationError
from suspid.model import ModalSet
from suspid.samples import Samples, as_samples
from suspid.signals import Signal
from suspid.units import RadianPerSecond, RealArray
from suspid.wavelets import (
    BandwidthSearch,
    Ridge,
    Scalogram,
    best_bandwidth,
    cwt,
    find_ridges,
    fit_ridges,
    fit_skeleton,
    row_frequencies,
)

if TYPE_CHECKING:
    import control

# Precision of the scalogram on which ridges are found; skeletons are then transformed anew, to rounding.
SEARCH_PRECISION = 1e-6


@dataclass(frozen=True, kw_only=True)
class FourSteps:
    """The four wavelet steps on one record, each computed when first used.

    Parameters
    ----------
    signal : Signal
        The record less its mean.
    count : int or None
        How many ridges; None: all significant ones.
    band : (float, float)
        Angular frequencies of the first and last row [rad/s].
    bandwidth : float or None
        N of the wavelet; None: that of least entropy.
    candidates : tuple of float
        Bandwidths among which to choose.
    chosen : bool
        Whether these were requested.

    Examples
    --------
    >>> from suspid import as_record, identify
    >>> t = np.arange(0, 5, 0.01)
    >>> found = identify(as_record(np.exp(-0.5 * t) * np.cos(20 * t), timepts=t), method="ridge", modes=1)
    >>> steps = found.steps
    >>> len(steps.ridges), steps.modes.wn.round(1)
    (1, array([20.]))
    """

    signal: Signal
    count: int | None
    band: tuple[RadianPerSecond, RadianPerSecond]
    bandwidth: float | None
    candidates: tuple[float, ...]
    chosen: bool = False

    @cached_property
    def response(self) -> control.TimeResponseData:
        """The record less its mean.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> steps = identify(decay, method="ridge", modes=1, bandwidth=8.0).steps
        >>> bool(abs(steps.response.outputs.mean()) < 1e-12)
        True
        """
        return self._samples.response

    @cached_property
    def _samples(self) -> Samples:
        return as_samples(self.signal.timepts, self.signal.values, self.signal.channels)

    @cached_property
    def omega(self) -> RealArray:
        """Angular frequencies of the rows [rad/s], (row,): the band, evenly spaced in its logarithm.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> steps = identify(decay, method="ridge", modes=1, bandwidth=8.0).steps
        >>> bool(np.ptp(np.diff(np.log(steps.omega))) < 1e-9)
        True
        """
        return row_frequencies(self.signal, self.band)

    @cached_property
    def search(self) -> BandwidthSearch | None:
        """Step 1: entropy against bandwidth; None if the bandwidth was given.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> steps = identify(decay, method="ridge", modes=1, bandwidth=8.0).steps
        >>> steps.search is None
        True
        """
        if self.bandwidth is not None:
            return None
        return best_bandwidth(self._samples, omega=self.omega, candidates=self.candidates)

    @cached_property
    def scalogram(self) -> Scalogram:
        """Step 2: the transform with the bandwidth given or of least entropy.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> steps = identify(decay, method="ridge", modes=1, bandwidth=8.0).steps
        >>> loudest = np.argmax([np.abs(row).max() for row in steps.scalogram.rows])
        >>> bool(abs(steps.scalogram.omega[loudest] - 20.0) < 0.5)
        True
        """
        bandwidth = self.bandwidth if self.search is None else self.search.best
        assert bandwidth is not None
        return cwt(self._samples, omega=self.omega, bandwidth=bandwidth, precision=SEARCH_PRECISION)

    @cached_property
    def ridges(self) -> tuple[Ridge, ...]:
        """Step 3: the ridges, each with the wavelet (this or a shorter one) that leaves its pole least uncertain.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> steps = identify(decay, method="ridge", modes=1, bandwidth=8.0).steps
        >>> round(steps.ridges[0].omega)
        20
        """
        attempts: list[tuple[Ridge, ...]] = []
        failure: IdentificationError | None = None
        # Each ridge may use the wavelet of least entropy or one shorter by these factors: short wavelets suit heavy
        # damping.
        for factor in (1.0, 0.5, 0.25, 0.125):
            transform = self.scalogram
            if factor != 1.0:
                bandwidth = self.scalogram.wavelet.bandwidth * factor
                transform = cwt(self._samples, omega=self.omega, bandwidth=bandwidth, precision=SEARCH_PRECISION)
            try:
                attempts.append(find_ridges(transform, count=self.count))
            except IdentificationError as error:
                failure = failure or error
        if not attempts:
            assert failure is not None
            raise failure
        steady = []
        for ridge in attempts[0]:
            # Ridges of two wavelets within this ratio of frequency, in its logarithm, are the same ridge.
            same = [r for other in attempts for r in other if abs(np.log(r.omega / ridge.omega)) < 0.02]
            steady.append(min(same, key=lambda r: fit_skeleton(r).variance))
        return tuple(steady)

    @cached_property
    def modes(self) -> ModalSet:
        """Step 4: modes from the lines through the skeletons.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> steps = identify(decay, method="ridge", modes=1, bandwidth=8.0).steps
        >>> steps.modes.zeta.round(3)
        array([0.05])
        """
        return fit_ridges(self.ridges)
