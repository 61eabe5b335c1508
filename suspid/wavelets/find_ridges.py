"""Find the ridges of a scalogram: Eq. (18)-(20)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.errors import IdentificationError, InputError
from suspid.levels import CERTAIN
from suspid.samples import as_samples
from suspid.signals import Signal, as_signal
from suspid.units import Hertz, RealArray
from suspid.values import check_count, frozen_real
from suspid.wavelets.cwt import cwt
from suspid.wavelets.filter_bank import sample_noise
from suspid.wavelets.fit_ridges import fit_ridges, fit_skeleton
from suspid.wavelets.morlet import Morlet
from suspid.wavelets.ridge import Ridge
from suspid.wavelets.ridge_at import ridge_at
from suspid.wavelets.scalogram import Scalogram
from suspid.wavelets.transform import transform

# Largest distance, in the logarithm, of the frequency of the skeleton from that of the maximum, and largest share of
# the energy that the fitted lines may leave in the trusted window. Larger limits accept noise as modes.
RIDGE_FARTHEST, MISFIT = 0.1, 0.25


@explained
def find_ridges(
    scalogram: Scalogram | RecordLike, *, count: int | None = None, fs: Hertz | None = None
) -> tuple[Ridge, ...]:
    """Return the ridges of a scalogram in order of frequency, each refined between its rows.

    Ridges are the maxima over scale of the energy of each row away from the ends of the record, summed over the
    channels, each in units of its noise. Each ridge is then moved to the frequency of its own skeleton. The trusted
    window starts where the onset of the decay disturbs the skeleton less than the noise does, and stops where the
    skeleton meets the noise or the end of the record.

    Parameters
    ----------
    scalogram : Scalogram
        The transform, with rows over the band of interest. Of a record (anything that `as_record` takes) the transform
        of its deviation from the mean with the defaults of `cwt` is used.
    count : int, optional
        Number of ridges to return, those of most energy. Default: all that are significant.
    fs : float, optional
        Sampling rate [Hz] of a record's samples that come without a time.

    Returns
    -------
    tuple of Ridge
        In order of ascending frequency.

    Raises
    ------
    IdentificationError
        If fewer than ``count`` ridges are significant, or none; ``.found`` holds the modes of those found.

    Examples
    --------
    >>> import numpy as np, control
    >>> from suspid import cwt
    >>> t = np.arange(0, 10, 0.01)
    >>> x = np.exp(-0.5 * t) * np.cos(20 * t) + np.exp(-t) * np.sin(60 * t)
    >>> decay = control.TimeResponseData(t, x, issiso=True, output_labels=["seat"])
    >>> ridges = find_ridges(cwt(decay, omega=np.geomspace(10, 100, 100), bandwidth=22.0))
    >>> [round(ridge.omega, 2) for ridge in ridges]
    [20.0, 60.0]
    """
    check_count("count", count)
    if not isinstance(scalogram, Scalogram):
        whole = as_signal(as_record(scalogram, fs=fs))
        about = whole.values - whole.values.mean(axis=1, keepdims=True)
        scalogram = cwt(as_samples(whole.timepts, about, whole.channels))
    if len(scalogram.omega) < 3:
        raise InputError(f"the scalogram has {len(scalogram.omega)} rows; a maximum over scale needs at least 3")
    signal = scalogram.signal
    noise = sample_noise(signal)
    width = np.sqrt(2 / scalogram.wavelet.bandwidth) / scalogram.wavelet.center
    refined: list[Ridge] = []
    # Ratio of the energy of a ridge to that of its flanks, for ridges found unaided and for a number asked for. A
    # smaller ratio finds ridges of noise, a larger one misses weak modes near strong ones.
    for omega in _peaks(scalogram, noise, 2.0 if count is None else 1.05):
        ridge = _refined(signal, omega, scalogram.wavelet, noise)
        if ridge is None or any(abs(np.log(ridge.omega / other.omega)) < width / 2 for other in refined):
            continue
        if not _is_significant(signal, ridge):
            continue
        refined.append(ridge)
        if len(refined) == count:
            break
    ridges = tuple(_traced(ridge, scalogram) for ridge in sorted(refined, key=lambda ridge: ridge.omega))
    if len(ridges) < (count or 1):
        asked = "no ridge found" if count is None else f"{len(ridges)} of {count} ridges found"
        where = ", ".join(f"{r.omega:.4g}" for r in ridges)
        raise IdentificationError(
            f"{asked} between {np.min(scalogram.omega):.4g} and {np.max(scalogram.omega):.4g} rad/s"
            + (f", at {where} rad/s" if where else "")
            + "; widen the band, change bandwidth, or request fewer (heavily damped or close modes have no ridge)",
            found=fit_ridges(ridges) if ridges else None,
        )
    return ridges


def _peaks(scalogram: Scalogram, noise: RealArray, prominence: float) -> list[float]:
    """Return frequencies of local maxima of the energy over rows, the most energetic first."""
    from scipy.signal import find_peaks

    signal = scalogram.signal
    rms = np.sqrt(np.mean(signal.values**2, axis=1))
    weights = np.where(rms > 0, 1 / np.maximum(noise, 1e-9 * rms + (rms == 0)), 0.0) ** 2
    by_frequency = np.argsort(scalogram.omega)
    energy = np.zeros(len(scalogram.omega))
    for i, row in enumerate(scalogram.rows):
        # Nearer to the ends [cones] the edge effect makes ridges.
        inside = scalogram.inside(i, cones=1.2)
        time = scalogram.weights(i)[inside] * signal.step
        per_channel = np.abs(row[:, inside]) ** 2 @ time
        # The energy of the noise alone is subtracted.
        spread = (np.maximum(noise, 1e-9 * rms) * scalogram.wavelet.noise_gain()) ** 2 * signal.step
        expected = np.sum(time) * spread
        factor = 1.0 if scalogram.normalization == "paper" else np.pi * scalogram.wavelet.bandwidth / 4
        factor *= scalogram.scale[i] if scalogram.normalization == "amplitude" else 1.0
        energy[i] = np.sum(weights * np.maximum(per_channel * factor - expected, 0.0))
    energy = energy[by_frequency]
    omega = np.asarray(scalogram.omega)[by_frequency]
    level = np.log(np.maximum(energy, np.max(energy, initial=0.0) * 1e-24) + np.finfo(float).tiny)
    found, _ = find_peaks(level, prominence=np.log(prominence))
    found = found[np.argsort(-energy[found])]
    return [_parabola(np.log(omega[k - 1 : k + 2]), level[k - 1 : k + 2]) for k in found]


def _parabola(x: RealArray, y: RealArray) -> float:
    """Return exp of where the parabola through three points is largest."""
    (x0, x1, x2), (y0, y1, y2) = x, y
    upper, lower = (y2 - y1) / (x2 - x1), (y1 - y0) / (x1 - x0)
    curvature = (upper - lower) / (x2 - x0)
    return float(np.exp(0.5 * (x0 + x1 - lower / curvature)) if curvature < 0 else np.exp(x1))


def _refined(signal: Signal, omega: float, wavelet: Morlet, noise: RealArray) -> Ridge | None:
    """Return the ridge moved to the frequency of its own skeleton, or None if that is not an exponential nearby."""
    ridge = ridge_at(signal, omega, wavelet, noise)
    for _ in range(3):
        if np.sum(ridge.trusted) < 4:
            return None
        fit = fit_skeleton(ridge)
        if abs(np.log(max(fit.pole.imag, 1e-3 * omega) / omega)) > RIDGE_FARTHEST:
            return None
        ridge = ridge_at(signal, fit.pole.imag, wavelet, noise, fit)
    if np.sum(ridge.trusted) < 4:
        return None
    skeleton = np.abs(ridge.skeleton[:, ridge.trusted]) / ridge.floor[:, None]
    fit = fit_skeleton(ridge)
    misfit = np.abs(np.exp(fit.logarithm) - np.exp(fit.lines)) / ridge.floor[:, None]
    return ridge if np.sum(misfit**2) < MISFIT * np.sum(skeleton**2) else None


def _is_significant(signal: Signal, ridge: Ridge) -> bool:
    """Return whether the ridge is neither noise nor the flank or edge of another one.

    In the trusted window it must rise above the noise, have more energy than the rows beside it, and not grow.
    """
    # Noise exceeds five times its level among a million samples with probability e^(-25 + 14) = 2e-5.
    if np.max(ridge.strength[ridge.trusted]) < 5.0:
        return False
    fit = fit_skeleton(ridge)
    if fit.pole.real > CERTAIN * np.sqrt(fit.variance):
        return False
    # In a record that is short for the wavelet the window begins within the edge effect.
    cone = float(ridge.wavelet.envelope(ridge.omega))
    away = (ridge.window.start - ridge.onset) / cone - max(0.0, -fit.pole.real) * cone / 2
    gain = float(ridge.wavelet.gain(1j * ridge.omega, ridge.scale).real)
    whole = np.sqrt(np.mean((np.max(np.abs(signal.values), axis=1) * gain / ridge.floor) ** 2))
    edge = float(whole) * np.exp(-(max(away, 0.0) ** 2)) / (2 * np.sqrt(np.pi) * max(away, 0.3))
    # A smaller ratio to the edge effect accepts clicks.
    if np.max(ridge.strength[ridge.trusted]) < 2.0 * edge:
        return False
    # At these frequencies the energy of a single mode has fallen by a factor e.
    aside = float(np.exp(np.sqrt(2 / ridge.wavelet.bandwidth) / ridge.wavelet.center))
    omega = np.array([ridge.omega / aside, ridge.omega, min(ridge.omega * aside, 0.999 * np.pi / signal.step)])
    beside = transform(signal, omega=omega, wavelet=ridge.wavelet, normalization="amplitude")
    energy = []
    for i, row in enumerate(beside.rows):
        time = beside.timepts(i)
        inside = (time >= ridge.window.start) & (time <= ridge.window.stop)
        energy.append(float(np.sum(np.mean((np.abs(row[:, inside]) / ridge.floor[:, None]) ** 2, axis=1))))
    return energy[1] > max(energy[0], energy[2])


def _traced(ridge: Ridge, scalogram: Scalogram) -> Ridge:
    """Return the ridge with the frequency of the largest modulus near it at each time."""
    near = np.flatnonzero(np.abs(np.log(np.asarray(scalogram.omega) / ridge.omega)) < 0.5)
    if len(near) < 3:
        return ridge
    part = replace(
        scalogram,
        omega=frozen_real(np.asarray(scalogram.omega)[near]),
        rows=tuple(scalogram.rows[i] for i in near),
        strides=tuple(scalogram.strides[i] for i in near),
    )
    height = np.sum((part.modulus(ridge.timepts) / ridge.floor[:, None, None]) ** 2, axis=0)
    return replace(ridge, trace=frozen_real(part.omega[np.argmax(height, axis=0)]))
