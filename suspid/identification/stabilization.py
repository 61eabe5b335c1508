"""Poles of a record at every model order, and which of them are stable: the field's stabilisation diagram."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.errors import InputError
from suspid.results import Result
from suspid.signals import PASSED, as_signal
from suspid.threads import in_one_thread
from suspid.units import ComplexArray, Hertz, RealArray
from suspid.values import frozen_complex, frozen_real, is_count

# Relative changes from one order to the next up to which a pole counts as stable: the custom of the field.
STABLE_WN, STABLE_ZETA = 0.01, 0.05
# Rows of the matrix of shifted samples, all channels together: more see slower modes, and take more time.
SHIFTED_ROWS = 360
# Samples that are kept in a cycle of the highest frequency in view.
SAMPLES_A_CYCLE = 2.5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Stabilization(Result):
    """Result of `stabilization`.

    Parameters
    ----------
    orders : tuple of int
        Numbers of poles that were fitted.
    poles : tuple of ndarray
        The decaying oscillating poles of each order, one of each conjugate pair [rad/s].
    stable_wn, stable_zeta : tuple of ndarray of bool
        Whether the order before has a pole of nearly the same natural frequency, and of nearly the same damping ratio
        as well.
    hertz : ndarray
        Frequencies of the spectrum, up to the highest in view [Hz].
    decibel : ndarray
        Spectrum of the record, all channels together, each of unit power [dB of its peak].

    Examples
    --------
    >>> from suspid import as_record, stabilization
    >>> t = np.arange(300) / 100
    >>> found = stabilization(as_record(np.exp(-t) * np.cos(20 * t), fs=100), most=6)
    >>> found.orders
    (2, 4, 6)
    """

    orders: tuple[int, ...]
    poles: tuple[ComplexArray, ...]
    stable_wn: tuple[NDArray[np.bool_], ...]
    stable_zeta: tuple[NDArray[np.bool_], ...]
    hertz: RealArray = field(default_factory=lambda: frozen_real([]))
    decibel: RealArray = field(default_factory=lambda: frozen_real([]))

    def _table(self) -> Mapping[str, Sequence[object]]:
        rows = [
            (order, abs(pole) / (2 * np.pi), abs(pole), -pole.real / abs(pole), bool(in_wn), bool(in_zeta))
            for order, poles, wn, zeta in zip(self.orders, self.poles, self.stable_wn, self.stable_zeta, strict=True)
            for pole, in_wn, in_zeta in zip(poles.tolist(), wn, zeta, strict=True)
        ]
        names = ("order", "f_hz", "wn_rad_per_s", "zeta", "stable_in_frequency", "stable_in_damping")
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}

    def __str__(self) -> str:
        stable = sum(int(np.sum(zeta)) for zeta in self.stable_zeta)
        every = sum(len(poles) for poles in self.poles)
        return (
            f"{every} poles at {len(self.orders)} orders from {self.orders[0]} to {self.orders[-1]}, {stable} of them "
            f"stable in frequency (to {STABLE_WN:.0%}) and damping (to {STABLE_ZETA:.0%})"
        )


@explained
@in_one_thread
def stabilization(
    record: RecordLike, *, fs: Hertz | None = None, most: int = 40, highest_hz: Hertz | None = None
) -> Stabilization:
    """Fit a free decay with 2, 4, 6, … poles, and find those that are stable from one order to the next.

    The poles of every order come from the shift of the signal subspace (ESPRIT) of one matrix of shifted samples of
    all channels. It is a second way to modes, apart from `identify`: stable poles are modes of the record or lines in
    it, unstable poles fit noise.

    Parameters
    ----------
    record : control.TimeResponseData, or what `as_record` takes
        A free decay from its first sample on.
    fs : float, optional
        Sampling rate [Hz] of samples that come without a time.
    most : int
        Highest order: number of poles.
    highest_hz : float, optional
        Highest frequency in view [Hz]; the record is thinned to it. Default: 0.4 of the sampling rate.

    Returns
    -------
    Stabilization
        Poles by order with what is stable.

    Raises
    ------
    InputError, RecordError
        If the record is too short for two orders, or cannot be used.

    Examples
    --------
    >>> from suspid import add_noise, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> found = stabilization(add_noise(record, snr_db=40.0, rng=np.random.default_rng(1)), most=10)
    >>> found.orders
    (2, 4, 6, 8, 10)
    >>> (abs(found.poles[-1][found.stable_zeta[-1]]) / (2 * np.pi)).round(1)
    array([ 1.1, 11.7])
    """
    if not is_count(most):
        raise InputError(f"most={most!r:.40} must be a whole number")
    if highest_hz is not None and not (isinstance(highest_hz, int | float | np.number) and highest_hz > 0):
        raise InputError(f"highest_hz={highest_hz!r:.40} must be a positive number in Hz")
    signal = as_signal(as_record(record, fs=fs), least=16)
    values, step = _thinned(signal.values, signal.step, highest_hz)
    vectors, channels = _subspace(values), len(values)
    highest = min(most, vectors.shape[1] - channels) // 2 * 2
    if highest < 4:
        raise InputError(f"{signal.values.shape[1]} samples at most={most} give no two orders; take a longer record")
    orders = tuple(range(2, highest + 1, 2))
    poles = [_poles(vectors[:, :order], channels, step) for order in orders]
    judged = [_stable(now, before) for before, now in zip([np.empty(0, complex), *poles[:-1]], poles, strict=True)]
    view = PASSED / signal.step if highest_hz is None else highest_hz
    hertz, decibel = _spectrum(signal.values, signal.step, view)
    return Stabilization(
        orders=orders,
        poles=tuple(frozen_complex(one) for one in poles),
        stable_wn=tuple(wn for wn, _ in judged),
        stable_zeta=tuple(zeta for _, zeta in judged),
        hertz=hertz,
        decibel=decibel,
    )


def _thinned(values: RealArray, step: float, highest: Hertz | None) -> tuple[RealArray, float]:
    """Return samples about their mean, each channel of unit power, and their step [s]."""
    from scipy.signal import decimate

    stride = 1 if highest is None else max(1, int(1 / (SAMPLES_A_CYCLE * highest * step)))
    stride = min(stride, max(1, values.shape[1] // 64))
    if stride > 1:
        values = decimate(values, stride, ftype="fir", axis=1)
    values = values - values.mean(axis=1, keepdims=True)
    power = np.sqrt(np.mean(values**2, axis=1, keepdims=True))
    return values / np.where(power > 0, power, 1.0), step * stride


def _spectrum(values: RealArray, step: float, highest: Hertz) -> tuple[RealArray, RealArray]:
    """Return frequencies, and the power of all channels at them, each of unit power [dB of the peak]."""
    values = values - values.mean(axis=1, keepdims=True)
    power = np.mean(values**2, axis=1, keepdims=True)
    spectrum = np.sum(np.abs(np.fft.rfft(values)) ** 2 / np.where(power > 0, power, 1.0), axis=0)
    frequency = np.fft.rfftfreq(values.shape[1], step)
    shown = (frequency > 0) & (frequency <= highest)
    peak = max(float(spectrum[shown].max(initial=0.0)), 1e-300)
    return frozen_real(frequency[shown]), frozen_real(10 * np.log10(np.maximum(spectrum[shown], 1e-300) / peak))


def _subspace(values: RealArray) -> RealArray:
    """Return the directions of all channels over a window, (sample · channel, direction), the strongest first."""
    channels, count = values.shape
    window = max(2, min(count // 2, SHIFTED_ROWS // channels))
    shifted = np.lib.stride_tricks.sliding_window_view(values, count - window + 1, axis=1)
    rows = np.asarray(shifted.transpose(1, 0, 2).reshape(window * channels, -1), float)
    _, vectors = np.linalg.eigh(rows @ rows.T)
    return np.asarray(vectors[:, ::-1])


def _poles(vectors: RealArray, channels: int, step: float) -> ComplexArray:
    """Return the decaying oscillating poles of a subspace [rad/s], by natural frequency."""
    shift = np.linalg.lstsq(vectors[:-channels], vectors[channels:], rcond=None)[0]
    roots = np.asarray(np.linalg.eigvals(shift), complex)
    poles = np.log(roots[np.abs(roots) > 0]) / step
    kept = poles[(poles.imag > 0) & (poles.real < 0) & (poles.imag < 0.999 * np.pi / step)]
    return np.asarray(kept[np.argsort(np.abs(kept))])


def _stable(now: ComplexArray, before: ComplexArray) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which poles were there before: by natural frequency, and by damping ratio too."""
    if not len(before):
        return np.zeros(len(now), bool), np.zeros(len(now), bool)
    apart = np.abs(np.abs(now)[:, None] / np.abs(before) - 1)
    nearest = np.argmin(apart, axis=1)
    zeta, earlier = -now.real / np.abs(now), -before.real / np.abs(before)
    in_wn = apart[np.arange(len(now)), nearest] < STABLE_WN
    return in_wn, in_wn & (np.abs(zeta / earlier[nearest] - 1) < STABLE_ZETA)
