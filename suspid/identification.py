"""From a record to its modes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from tabulate import tabulate

from suspid.errors import IdentificationError, InputError
from suspid.modes import ModalSet
from suspid.ridges import Ridge, SkeletonFit, find_ridges, fit_ridges, fit_skeleton, sample_noise
from suspid.scalogram import BandwidthSearch, Scalogram, best_bandwidth, cwt
from suspid.signals import Signal, as_response, as_signal
from suspid.units import ComplexArray, RadianPerSecond, RealArray
from suspid.values import frozen_real

if TYPE_CHECKING:
    import control

# Rows of the scalogram per octave: a third of the width of the narrowest row in use.
PER_OCTAVE = 24
# The band unless one is given: from this many cycles in the record to this share of the Nyquist frequency.
LEAST_CYCLES = 4.0
HIGHEST = 0.9
# Each ridge may use the wavelet of least entropy or one shorter by these factors.
SHORTER = (1.0, 0.5, 0.25, 0.125)
FEWEST_SAMPLES = 64

Method = Literal["ridge"]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Identification:
    """What `identify` found, and all that is needed to judge it.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    method : str
        How it was identified.
    modes : ModalSet
        The modes, with their uncertainty.
    ridge_modes : ModalSet
        The modes from the ridges alone.
    scalogram : Scalogram
        The transform of the record less its mean, with the wavelet of least entropy.
    ridges : tuple of Ridge
        One per ridge mode, each with its own wavelet, skeleton and window.
    bandwidth_search : BandwidthSearch or None
        Entropy against bandwidth; None if the bandwidth was given.
    fitted : control.TimeResponseData
        The free decay of `modes`, best fitted to the record; zero before the onset.
    residual : control.TimeResponseData
        The record less `fitted`.
    noise_std : ndarray (channel,)
        Standard deviation of the noise, in the unit of each channel.
    """

    response: control.TimeResponseData
    method: Method
    modes: ModalSet
    ridge_modes: ModalSet
    scalogram: Scalogram
    ridges: tuple[Ridge, ...]
    bandwidth_search: BandwidthSearch | None
    fitted: control.TimeResponseData
    residual: control.TimeResponseData
    noise_std: RealArray

    @property
    def lines(self) -> tuple[SkeletonFit, ...]:
        """The lines through log modulus and phase of each ridge."""
        return tuple(fit_skeleton(ridge) for ridge in self.ridges)

    @property
    def explained(self) -> RealArray:
        """Share of each channel's energy about its mean that the fit explains, from the onset on [1], (channel,)."""
        signal, residual = as_signal(self.response), as_signal(self.residual)
        since = signal.timepts >= min(ridge.onset for ridge in self.ridges) if self.ridges else slice(None)
        record = signal.values[:, since] - signal.values[:, since].mean(axis=1, keepdims=True)
        energy = np.sum(record**2, axis=1)
        left = np.sum(residual.values[:, since] ** 2, axis=1)
        return np.asarray(1 - left / np.where(energy > 0, energy, 1.0))

    def __str__(self) -> str:
        signal = as_signal(self.response)
        channels = {
            "channel": signal.channels,
            "explained": [f"{100 * share:.2f} %" for share in self.explained],
            "noise std": [f"{std:.3g}" for std in self.noise_std],
        }
        windows = {
            "ridge [rad/s]": [f"{ridge.omega:.5g}" for ridge in self.ridges],
            "N": [f"{ridge.wavelet.bandwidth:.3g}" for ridge in self.ridges],
            "from [s]": [f"{ridge.window.start:.3g}" for ridge in self.ridges],
            "to [s]": [f"{ridge.window.stop:.3g}" for ridge in self.ridges],
            "ends at": [ridge.window.reason for ridge in self.ridges],
        }
        parts = [str(self.modes)] + [
            tabulate(columns, headers="keys", disable_numparse=True, stralign="right")
            for columns in (windows, channels)
        ]
        return "\n\n".join(parts)


def identify(
    response: control.TimeResponseData,
    *,
    modes: int | None = None,
    method: Method = "ridge",
    band: tuple[RadianPerSecond, RadianPerSecond] | None = None,
    bandwidth: float | None = None,
    candidates: Iterable[float] = range(1, 51),
) -> Identification:
    """Return the modes of a free decay.

    The paper's four steps: the bandwidth N of least wavelet entropy; the transform with it; ridges
    and skeletons; lines through them. Where a wavelet of that N is so long that the edges eat the
    skeleton, N / 2, N / 4 and N / 8 are tried, and each ridge keeps the one that leaves its pole
    the smallest standard deviation. The mean of each channel is taken off first.

    Parameters
    ----------
    response : control.TimeResponseData
        A free decay, uniformly sampled; all channels are used together.
    modes : int, optional
        How many modes. Default: all that stand out.
    method : {"ridge"}
        "ridge": the paper's method, for light damping.
    band : (float, float), optional
        Angular frequencies between which to look [rad/s]. Default: from four cycles in the record
        to 0.9 of the Nyquist frequency.
    bandwidth : float, optional
        N of the wavelet. Default: that of least entropy among ``candidates``.
    candidates : iterable of float
        Bandwidths among which to choose.

    Returns
    -------
    Identification
        Modes with uncertainty, and the ridges, lines, fit and residual behind them.

    Raises
    ------
    IdentificationError
        If fewer modes than asked for stand out; ``.found`` holds those found.
    RecordError, InputError
        If the record or a setting cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> car = quarter_car(seat_mass=200, chassis_mass=200, tire_mass=200,
    ...                   seat_stiffness=200e3, chassis_stiffness=400e3, tire_stiffness=800e3,
    ...                   seat_damping=300, chassis_damping=200, tire_damping=100)
    >>> record = free_decay(car, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})
    >>> identify(record, modes=3).modes.wn.round(4)
    array([21.2737, 50.1386, 83.8549])
    """
    if method != "ridge":
        raise InputError(f"{method=} is unknown; the methods are 'ridge'")
    signal = as_signal(response, least=FEWEST_SAMPLES)
    centred = signal.values - signal.values.mean(axis=1, keepdims=True)
    if not np.any(np.abs(centred) > 1e-12 * np.max(np.abs(signal.values))):
        raise IdentificationError(f"every channel is constant ({', '.join(signal.channels)}): there is no decay in it")
    about_mean = as_response(signal.timepts, centred, signal.channels)
    omega = _rows(signal, band)
    search = None
    if bandwidth is None:
        search = best_bandwidth(about_mean, omega=omega, candidates=candidates)
        bandwidth = search.best
    scalogram = cwt(about_mean, omega=omega, bandwidth=bandwidth)
    ridges = _steadiest_ridges(about_mean, scalogram, modes)
    found = fit_ridges(ridges)
    fitted = _decay_of(found, signal, min(ridge.onset for ridge in ridges))
    return Identification(
        response=response,
        method=method,
        modes=found,
        ridge_modes=found,
        scalogram=scalogram,
        ridges=ridges,
        bandwidth_search=search,
        fitted=as_response(signal.timepts, fitted, signal.channels, title="Fitted decay"),
        residual=as_response(signal.timepts, signal.values - fitted, signal.channels, title="Residual"),
        noise_std=frozen_real(sample_noise(signal)),
    )


def _rows(signal: Signal, band: tuple[RadianPerSecond, RadianPerSecond] | None) -> RealArray:
    """Return the angular frequencies of the rows: the band, evenly spaced in its logarithm."""
    nyquist = np.pi / signal.step
    low, high = band or (2 * np.pi * LEAST_CYCLES / signal.duration, HIGHEST * nyquist)
    if not 0 < low < high <= nyquist:
        raise InputError(
            f"the band {low:g} … {high:g} rad/s must be two increasing angular frequencies between 0 and "
            f"the Nyquist frequency {nyquist:g} rad/s"
        )
    return np.geomspace(low, min(high, 0.999 * nyquist), max(8, int(np.ceil(PER_OCTAVE * np.log2(high / low)))))


def _steadiest_ridges(response: control.TimeResponseData, scalogram: Scalogram, count: int | None) -> tuple[Ridge, ...]:
    """Return each ridge with the wavelet, of the given one and shorter ones, that leaves its pole least uncertain."""
    attempts: list[tuple[Ridge, ...]] = []
    failure: IdentificationError | None = None
    for factor in SHORTER:
        wider = scalogram
        if factor != 1.0:
            wider = cwt(response, omega=scalogram.omega, bandwidth=scalogram.wavelet.bandwidth * factor)
        try:
            attempts.append(find_ridges(wider, count=count))
        except IdentificationError as error:
            failure = failure or error
    if not attempts:
        assert failure is not None
        raise failure
    steady = []
    for ridge in attempts[0]:
        same = [r for other in attempts for r in other if abs(np.log(r.omega / ridge.omega)) < 0.02]
        steady.append(min(same, key=lambda r: fit_skeleton(r).variance))
    return tuple(steady)


def _decay_of(modes: ModalSet, signal: Signal, onset: float) -> RealArray:
    """Return the sum of the modes' decays and a constant nearest to the record from the onset on, (channel, sample)."""
    elapsed = signal.timepts - onset
    since = elapsed >= -0.5 * signal.step
    powers: ComplexArray = np.exp(modes.poles * elapsed[since, None])
    basis = np.column_stack([powers.real, powers.imag[:, modes.poles.imag > 0], np.ones(len(powers))])
    amplitudes, *_ = np.linalg.lstsq(basis, signal.values[:, since].T, rcond=None)
    fitted = np.zeros_like(signal.values)
    fitted[:, since] = (basis @ amplitudes).T
    return fitted
