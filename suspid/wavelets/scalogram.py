"""The continuous wavelet transform with the modified Morlet wavelet, and its entropy: Eq. (12)-(17)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from suspid.errors import InputError
from suspid.signals import Signal, as_signal
from suspid.units import ComplexArray, Radian, RadianPerSecond, RealArray
from suspid.values import frozen_complex, frozen_real

if TYPE_CHECKING:
    import control

# Relative size below which the wavelet and its spectrum count as nothing.
CUT = 1e-13
# The same where only the entropy is wanted: what `best_bandwidth` says of its accuracy rests on it.
ENTROPY_CUT = 1e-8
# Most samples of all rows together that are transformed at once.
BLOCK = 2**21
# A wavelet whose envelope is longer than this many records sees nothing but the record's ends.
LONGEST = 10.0

Normalization = Literal["paper", "amplitude"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Morlet:
    """The modified Morlet wavelet ``psi(t) = exp(j w0 t) exp(-t^2 / N)``, Eq. (13).

    It is PyWavelets' ``cmorB-C`` with B = N and w0 = 2 pi C, but for that one's constant factor.

    Parameters
    ----------
    center : float
        w0 [rad]: the scale of angular frequency omega is ``w0 / omega``.
    bandwidth : float
        N [1]: the larger, the finer in frequency and the coarser in time.

    Examples
    --------
    >>> Morlet(center=6.0, bandwidth=2.0).spectrum(6.0).round(4)
    np.float64(2.5066)
    """

    center: Radian
    bandwidth: float

    def __post_init__(self) -> None:
        for name, value in (("center", self.center), ("bandwidth", self.bandwidth)):
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value} of the wavelet must be positive and finite")

    def waveform(self, t: ArrayLike) -> ComplexArray:
        """Return ``psi(t)``."""
        t = np.asarray(t, float)
        return np.asarray(np.exp(1j * self.center * t - t**2 / self.bandwidth))

    def spectrum(self, omega: ArrayLike) -> RealArray:
        """Return ``psi^(w) = sqrt(pi N) exp(-N (w - w0)^2 / 4)``."""
        away = np.asarray(omega, float) - self.center
        return np.asarray(np.sqrt(np.pi * self.bandwidth) * np.exp(-self.bandwidth * away**2 / 4))

    def gain(self, pole: ArrayLike, scale: ArrayLike) -> ComplexArray:
        """Return the transform of ``exp(pole t)`` at tau = 0: ``sqrt(pi N s) exp(N (s pole - j w0)^2 / 4)``.

        At any other tau it is this times ``exp(pole tau)``, far from the record's ends. So a skeleton
        along one row is exactly an exponential, and its slopes carry no bias of damping.
        """
        scale = np.asarray(scale, float)
        away = scale * np.asarray(pole, complex) - 1j * self.center
        return np.asarray(np.sqrt(np.pi * self.bandwidth * scale) * np.exp(self.bandwidth * away**2 / 4))

    def envelope(self, omega: ArrayLike) -> RealArray:
        """Return the time ``s sqrt(N)`` in which the envelope falls by e [s], at angular frequencies [rad/s]."""
        return np.asarray(self.center / np.asarray(omega, float) * np.sqrt(self.bandwidth))

    def noise_gain(self) -> float:
        """Return the transform's standard deviation for white noise of unit density: ``(pi N / 2)^(1/4)``.

        For samples of standard deviation sigma at a step h, that of any row is ``sigma sqrt(h)`` times this.
        """
        return float((np.pi * self.bandwidth / 2) ** 0.25)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Scalogram:
    """The transform of a record, row by row, each row at the sampling rate that its bandwidth needs.

    Parameters
    ----------
    signal : Signal
        The record.
    wavelet : Morlet
        The wavelet.
    normalization : {"paper", "amplitude"}
        See `cwt`.
    omega : ndarray (row,)
        Angular frequencies [rad/s].
    rows : tuple of ndarray (channel, row sample)
        Coefficients; row i holds every ``strides[i]``-th sample of the record.
    strides : tuple of int
        Samples of the record per sample of the row.
    """

    signal: Signal
    wavelet: Morlet
    normalization: Normalization
    omega: RealArray
    rows: tuple[ComplexArray, ...]
    strides: tuple[int, ...]

    @property
    def scale(self) -> RealArray:
        """Scales ``w0 / omega`` [s], (row,)."""
        return np.asarray(self.wavelet.center / self.omega)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return self.signal.channels

    @property
    def cone(self) -> RealArray:
        """Cone of influence [s], (row,): closer than this to either end the edge reaches the coefficients.

        It is the time ``s sqrt(N)`` in which the wavelet's envelope falls by e.
        """
        return self.wavelet.envelope(self.omega)

    @property
    def coefficients(self) -> ComplexArray:
        """All coefficients, (channel, row, sample), of a transform made with ``full_rate=True``.

        Raises
        ------
        InputError
            If the rows are stored at their own rates.
        """
        if set(self.strides) - {1}:
            raise InputError(
                "the rows are stored at their own rates; use cwt(..., full_rate=True), or timepts() and rows"
            )
        return np.stack(self.rows, axis=1)

    def timepts(self, row: int) -> RealArray:
        """Return the times of the samples of a row [s]."""
        count = self.rows[row].shape[1]
        return np.asarray(self.signal.start + self.signal.step * self.strides[row] * np.arange(count), float)

    def weights(self, row: int) -> RealArray:
        """Return how many samples of the record each sample of a row stands for.

        These are the trapezoidal rule's, corrected to second order at both ends, where a long wavelet's
        modulus need not be small.
        """
        stride, count = self.strides[row], self.rows[row].shape[1]
        weights = np.full(count, float(stride))
        if stride == 1:
            return weights
        beyond = self.signal.values.shape[1] - 0.5 - stride * (count - 1)
        if count < 3:
            weights[-1] += 0.5 - stride + beyond
            return weights
        outward = np.array([3.0, -4.0, 1.0]) / (2 * stride)
        for end, reach in ((weights[:3], 0.5), (weights[-1:-4:-1], beyond)):
            end += (reach**2 / 2 - stride**2 / 12) * outward
            end[0] += reach - stride / 2
        return weights

    def inside(self, row: int, *, cones: float = 1.0) -> NDArray[np.bool_]:
        """Return which samples of a row lie at least ``cones`` cones away from both ends."""
        time, reach = self.timepts(row), cones * self.cone[row]
        end = self.signal.start + self.signal.duration
        return np.asarray((time >= self.signal.start + reach) & (time <= end - reach))

    def modulus(self, timepts: ArrayLike) -> RealArray:
        """Return the modulus at any times, (channel, row, time), linear between the samples of each row."""
        time = np.asarray(timepts, float)
        out = np.empty((len(self.channels), len(self.omega), time.size))
        for i, row in enumerate(self.rows):
            for j, samples in enumerate(np.abs(row)):
                out[j, i] = np.interp(time, self.timepts(i), samples)
        return out


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BandwidthSearch:
    """Wavelet entropy against bandwidth.

    Parameters
    ----------
    candidates : ndarray (candidate,)
        Bandwidths N that were tried.
    entropy : ndarray (candidate,)
        Entropy of the transform with each [nat].
    """

    candidates: RealArray
    entropy: RealArray

    @property
    def best(self) -> float:
        """N of least entropy."""
        return float(self.candidates[np.argmin(self.entropy)])

    @property
    def at_end(self) -> bool:
        """Whether the least entropy lies at an end of the candidates: then the range decided, not the record."""
        return self.best in (np.min(self.candidates), np.max(self.candidates))


def cwt(
    response: control.TimeResponseData,
    *,
    omega: Sequence[RadianPerSecond] | RealArray,
    bandwidth: float,
    center: Radian = 2 * np.pi,
    normalization: Normalization = "paper",
    full_rate: bool = False,
    precision: float = CUT,
) -> Scalogram:
    """Return the continuous wavelet transform of all channels, Eq. (12).

    ``CWT(s, tau) = s^-1/2 sum_n x(t_n) conj(psi((t_n - tau) / s)) h`` with h the sampling step, from
    the wavelet's exact spectrum: no wavelet is truncated or sampled. Before and after the record the
    signal counts as zero, so the coefficients within the cone of influence carry the edge.

    Parameters
    ----------
    response : control.TimeResponseData
        The record, uniformly sampled.
    omega : array_like (row,)
        Angular frequencies of the rows [rad/s], below the Nyquist frequency; the scale is ``center / omega``.
    bandwidth : float
        N of the modified Morlet wavelet.
    center : float
        w0 [rad].
    normalization : {"paper", "amplitude"}
        "paper": Eq. (12). "amplitude": divided by ``sqrt(pi N s) / 2``, so that ``A cos(omega t)``
        has modulus A on its row.
    full_rate : bool
        False: each row holds only the samples that its bandwidth needs, and an inverse FFT of those
        Fourier bins alone makes it. True: every row holds every sample of the record.
    precision : float
        Share of its peak below which the wavelet's spectrum counts as zero; the coefficients are off by
        about that share of the largest. To look at, 1e-5 is enough and costs less than half.

    Returns
    -------
    Scalogram
        Rows in the order of ``omega``.

    Raises
    ------
    InputError
        If a frequency is not between 0 and Nyquist, or a wavelet is over ten times as long as the record.
    RecordError
        If the record cannot be used, see `read_record`.

    Examples
    --------
    >>> import numpy as np, control
    >>> t = np.arange(0, 10, 0.01)
    >>> tone = control.TimeResponseData(t, 3 * np.cos(20 * t), issiso=True, output_labels=["seat"])
    >>> scalogram = cwt(tone, omega=[20.0], bandwidth=4.0, normalization="amplitude")
    >>> float(np.abs(scalogram.rows[0][0, scalogram.inside(0, cones=3)]).mean().round(6))
    3.0
    """
    return transform(
        as_signal(response),
        omega=np.atleast_1d(np.asarray(omega, float)),
        wavelet=Morlet(center=center, bandwidth=bandwidth),
        normalization=normalization,
        full_rate=full_rate,
        precision=precision,
    )


def transform(
    signal: Signal,
    *,
    omega: RealArray,
    wavelet: Morlet,
    normalization: Normalization = "paper",
    full_rate: bool = False,
    precision: float = CUT,
) -> Scalogram:
    """Return the transform of checked samples; see `cwt`. Below ``precision`` the wavelet counts as zero."""
    from scipy.fft import fft

    _check_rows(signal, omega, wavelet)
    if not CUT / 10 <= precision < 0.1:
        raise InputError(f"{precision=} must be a share between {CUT / 10:g} and 0.1, such as {CUT:g}")
    scale = wavelet.center / omega
    count = signal.values.shape[1]
    reach = np.sqrt(-np.log(precision) * wavelet.bandwidth) * np.max(scale) / signal.step
    length = _length(count + int(np.ceil(reach)))
    fourier = fft(signal.values, n=length, axis=1)
    per_bin = 2 * np.pi / (length * signal.step)
    halfwidth = 2 * np.sqrt(-np.log(precision) / wavelet.bandwidth)
    first = np.ceil((wavelet.center - halfwidth) / scale / per_bin).astype(int)
    last = np.floor((wavelet.center + halfwidth) / scale / per_bin).astype(int)
    doublings = np.maximum(np.floor(np.log2(length / (last - first + 1))), 0).astype(int)
    strides = 1 << np.minimum(doublings, _twos(length)) if not full_rate else np.ones_like(first)
    factor = np.sqrt(scale) if normalization == "paper" else 2 / np.sqrt(np.pi * wavelet.bandwidth) + 0 * scale
    rows: list[ComplexArray] = [np.empty(0, complex)] * len(omega)
    for stride in np.unique(strides):
        members = np.flatnonzero(strides == stride)
        at_once = max(1, BLOCK // (len(signal.channels) * (length // stride)))
        for some in np.array_split(members, -(-len(members) // at_once)):
            block = _row_block(fourier, first[some], last[some], scale[some] * per_bin, wavelet, length // stride)
            block = block[..., : -(-count // stride)] * (factor[some, None] / stride)
            for i, index in enumerate(some):
                rows[index] = frozen_complex(block[:, i])
    return Scalogram(
        signal=signal,
        wavelet=wavelet,
        normalization=normalization,
        omega=frozen_real(omega),
        rows=tuple(rows),
        strides=tuple(int(s) for s in strides),
    )


def best_bandwidth(
    response: control.TimeResponseData,
    *,
    omega: Sequence[RadianPerSecond] | RealArray,
    candidates: Iterable[float] = range(1, 51),
    center: Radian = 2 * np.pi,
) -> BandwidthSearch:
    """Return the wavelet entropy of the record against the bandwidth N, Eq. (14).

    ``WE(N) = -sum_j p_j log p_j`` over all coefficients j of the transform, that is over channel, row
    and time within the record, ``p_j = |CWT_j|^2 / sum |CWT|^2`` with the paper's normalisation. Rows
    are stored at their own rate and a sample counts as often as the samples of the record that it stands
    for, so the figure is that of the full-rate transform to 2e-3 nat (5e-3 where an envelope outlasts the record).

    Least entropy means fewest large coefficients. Over scale alone it would fall forever with N; it
    has a minimum because long wavelets smear the decay and reach over the record's ends. Hence it
    depends on the record's length and on ``omega``: state both with any N.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    omega : array_like (row,)
        Angular frequencies [rad/s].
    candidates : iterable of float
        Bandwidths to try.
    center : float
        w0 [rad].

    Returns
    -------
    BandwidthSearch
        The whole curve, and `BandwidthSearch.best`.

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
    signal, rows = as_signal(response), np.atleast_1d(np.asarray(omega, float))
    tried = np.array([float(n) for n in candidates])
    if not tried.size:
        raise InputError("no candidates for the bandwidth were given")
    if not np.any(signal.values):
        raise InputError("the record is zero throughout: it has no entropy")
    wavelets = [Morlet(center=center, bandwidth=n) for n in tried]
    entropy = [_entropy(transform(signal, omega=rows, wavelet=w, precision=ENTROPY_CUT)) for w in wavelets]
    return BandwidthSearch(candidates=frozen_real(tried), entropy=frozen_real(entropy))


def _entropy(scalogram: Scalogram) -> float:
    """Return ``-sum p log p`` with ``p = e / E``, as ``log E - sum e log e / E``."""
    total = weighted = 0.0
    for index, row in enumerate(scalogram.rows):
        energy, counts = row.real**2 + row.imag**2, scalogram.weights(index)
        total += float(np.sum(energy @ counts))
        weighted += float(np.sum((energy * np.log(np.where(energy > 0, energy, 1.0))) @ counts))
    return float(np.log(total) - weighted / total)


def _row_block(
    fourier: ComplexArray,
    first: NDArray[np.intp],
    last: NDArray[np.intp],
    per_bin: RealArray,
    wavelet: Morlet,
    length: int,
) -> ComplexArray:
    """Return rows (channel, row, length): inverse FFTs of the Fourier bins first … last, folded to ``length``."""
    from scipy.fft import ifft

    whole = fourier.shape[1]
    folded = np.zeros((len(fourier), len(first), length), complex)
    width = int(np.max(last - first)) + 1
    kernels = wavelet.spectrum((first[:, None] + np.arange(width)) * per_bin[:, None])
    for row, (start, kernel) in enumerate(zip(first, kernels, strict=True)):
        done = 0
        # Slices end where the record's spectrum or the folded one does. Bins beyond Nyquist repeat the
        # record's periodic spectrum, as the sum of Eq. (12) does.
        while done < width:
            source, target = (start + done) % whole, (start + done) % length
            size = min(width - done, whole - source, length - target)
            folded[:, row, target : target + size] += fourier[:, source : source + size] * kernel[done : done + size]
            done += size
    return np.asarray(ifft(folded, axis=2, overwrite_x=True))


def _check_rows(signal: Signal, omega: RealArray, wavelet: Morlet) -> None:
    nyquist = np.pi / signal.step
    if omega.ndim != 1 or not omega.size:
        raise InputError(f"omega must be a vector of at least one angular frequency; got shape {omega.shape}")
    wrong = omega[~((omega > 0) & (omega < nyquist))]
    if wrong.size:
        raise InputError(
            f"{wrong.size} of {omega.size} angular frequencies, the first {wrong[0]:g} rad/s, do not lie between "
            f"0 and the Nyquist frequency {nyquist:g} rad/s of the record"
        )
    longest = float(np.max(wavelet.envelope(omega)))
    if longest > LONGEST * signal.duration:
        raise InputError(
            f"at omega = {np.min(omega):g} rad/s the wavelet's envelope lasts {longest:g} s, over {LONGEST:g} times "
            f"the record's {signal.duration:g} s; raise the lowest omega, or lower bandwidth or center"
        )


def _length(least: int) -> int:
    """Return a length that FFTs like and that can be halved often."""
    from scipy.fft import next_fast_len

    unit = 1 << max(0, least.bit_length() - 8)
    return int(next_fast_len(-(-least // unit))) * unit


def _twos(length: int) -> int:
    """Return how often the length can be halved."""
    return (length & -length).bit_length() - 1
