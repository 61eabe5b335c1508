"""Ridges of the scalogram, the skeletons along them and the lines through those: Eq. (18)-(21)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from suspid.errors import IdentificationError, InputError
from suspid.model import ModalSet, scaled_shapes
from suspid.signals import Signal
from suspid.units import ComplexArray, RadianPerSecond, RealArray, Second
from suspid.values import frozen_complex, frozen_real
from suspid.wavelets.scalogram import CUT, Morlet, Scalogram, transform

# A skeleton is trusted while its modulus stands this far above the noise in its row.
ABOVE_NOISE = 3.0
# Where the window starts the edge disturbs the skeleton this many times as much as the noise does: it then falls
# faster than any exponential, so its part in the whole window stays below that of the noise.
EDGE_SHARE = 3.0
# Distance in cones from both ends within which no ridge is looked for.
SEARCH_CONES = 1.2
# A ridge stands out by this factor in energy over its flanks if found unaided, by that if asked for; and in the trusted
# window by STANDS_OUT in modulus over the noise, where noise alone gets among a million samples with a chance of
# e^(-25 + 14).
PROMINENCE = 2.0
PROMINENCE_ASKED = 1.05
STANDS_OUT = 5.0
# A ridge is stronger by this than what the edge of the whole signal may leave where its window starts.
OVER_EDGE = 2.0
# A free decay does not grow by more than this many of its own standard deviations.
GROWTH = 5.0
# A ridge is one if its skeleton's own frequency lies this near in relative terms, and if the fitted lines leave less
# than this share of its energy in the trusted window.
FARTHEST = 0.1
INCOHERENT = 0.25


@dataclass(frozen=True, kw_only=True, slots=True)
class Window:
    """The part of a skeleton that can be trusted, and what bounds it.

    Parameters
    ----------
    onset_edge : float
        Before this time [s] the wavelet still feels the onset of the decay.
    record_end : float
        After this time [s] it feels the end of the record.
    noise_floor : float
        After this time [s] the skeleton meets the noise (infinite if it never does).
    """

    onset_edge: Second
    record_end: Second
    noise_floor: Second

    @property
    def start(self) -> Second:
        """First trusted time [s]."""
        return self.onset_edge

    @property
    def stop(self) -> Second:
        """Last trusted time [s]."""
        return min(self.record_end, self.noise_floor)

    @property
    def reason(self) -> str:
        """What ends the window: ``"record end"`` or ``"noise floor"``."""
        return "noise floor" if self.noise_floor < self.record_end else "record end"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Ridge:
    """One ridge: the scale of most energy, the skeleton along it, and where to trust it.

    Parameters
    ----------
    omega : float
        Angular frequency of the ridge [rad/s], refined between the rows of the scalogram.
    wavelet : Morlet
        The wavelet.
    timepts : ndarray (sample,)
        Times of the skeleton [s].
    skeleton : ndarray (channel, sample)
        Coefficients along the ridge (normalised as in the paper).
    trace : ndarray (sample,)
        Where the scalogram is largest at each time, near this ridge [rad/s].
    floor : ndarray (channel,)
        Standard deviation of the noise in the skeleton.
    window : Window
        Where the skeleton is trusted.
    onset : float
        Time from which the motion counts as free decay [s].
    channels : tuple of str
        Names of the channels.
    """

    omega: RadianPerSecond
    wavelet: Morlet
    timepts: RealArray
    skeleton: ComplexArray
    trace: RealArray
    floor: RealArray
    window: Window
    onset: Second
    channels: tuple[str, ...]

    @property
    def trusted(self) -> NDArray[np.bool_]:
        """Which samples lie in the window."""
        return np.asarray((self.timepts >= self.window.start) & (self.timepts <= self.window.stop))

    @property
    def strength(self) -> RealArray:
        """Modulus of the skeleton over its noise, root mean square over the channels [1], (sample,)."""
        return np.asarray(np.sqrt(np.mean((np.abs(self.skeleton) / self.floor[:, None]) ** 2, axis=0)))

    @property
    def scale(self) -> Second:
        """Scale of the ridge [s]."""
        return self.wavelet.center / self.omega


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class SkeletonFit:
    """The two lines of Eq. (21), through the log modulus and the phase of all channels at once.

    Parameters
    ----------
    pole : complex
        Slopes [rad/s]: of the log modulus in the real part, of the phase in the imaginary part.
    variance : float
        Variance of either slope [(rad/s)^2]; the two are independent.
    origin : ndarray (channel,)
        Logarithm of the skeleton at the onset, on the lines.
    onset : float
        Time of ``origin`` [s].
    timepts : ndarray (sample,)
        Trusted times [s].
    logarithm : ndarray (channel, sample)
        Log modulus (real) and unwrapped phase (imaginary) of the skeleton there.
    """

    pole: complex
    variance: float
    origin: ComplexArray
    onset: Second
    timepts: RealArray
    logarithm: ComplexArray

    @property
    def lines(self) -> ComplexArray:
        """The fitted lines at ``timepts``, (channel, sample)."""
        return np.asarray(self.origin[:, None] + self.pole * (self.timepts - self.onset))


def find_ridges(scalogram: Scalogram, *, count: int | None = None) -> tuple[Ridge, ...]:
    """Return the ridges of a scalogram in order of frequency, each refined between its rows.

    The energy of each row, all channels together and each in units of its noise, is looked at away
    from the record's ends; ridges are its maxima over scale. Each is then moved to the frequency of
    its own skeleton. The window of trust starts where the edge of the onset disturbs the skeleton
    less than the noise does, and stops where the skeleton meets the noise or the record's end.

    Parameters
    ----------
    scalogram : Scalogram
        The transform, with rows over the band of interest.
    count : int, optional
        How many ridges to return, the most energetic ones. Default: all that stand out.

    Returns
    -------
    tuple of Ridge
        In order of ascending frequency.

    Raises
    ------
    IdentificationError
        If fewer than ``count`` ridges stand out, or none; ``.found`` holds the modes of those found.

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
    if count is not None and count < 1:
        raise InputError(f"{count=}: ask for at least one ridge")
    if len(scalogram.omega) < 3:
        raise InputError(f"{len(scalogram.omega)} rows are too few to hold a maximum over scale; use at least 3")
    signal = scalogram.signal
    noise = sample_noise(signal)
    width = np.sqrt(2 / scalogram.wavelet.bandwidth) / scalogram.wavelet.center
    refined: list[Ridge] = []
    for omega in _peaks(scalogram, noise, PROMINENCE if count is None else PROMINENCE_ASKED):
        ridge = _refined(signal, omega, scalogram.wavelet, noise)
        if ridge is None or any(abs(np.log(ridge.omega / other.omega)) < width / 2 for other in refined):
            continue
        if not _stands_out(signal, ridge):
            continue
        refined.append(ridge)
        if len(refined) == count:
            break
    ridges = tuple(_traced(ridge, scalogram) for ridge in sorted(refined, key=lambda ridge: ridge.omega))
    if len(ridges) < (count or 1):
        asked = "no ridge stands out" if count is None else f"{count} ridges were asked for, {len(ridges)} stand out"
        where = ", ".join(f"{r.omega:.4g}" for r in ridges)
        raise IdentificationError(
            f"{asked} between {np.min(scalogram.omega):.4g} and {np.max(scalogram.omega):.4g} rad/s"
            + (f", at {where} rad/s" if where else "")
            + "; widen the band, change bandwidth, or ask for fewer (heavily damped or close modes leave no ridge)",
            found=fit_ridges(ridges) if ridges else None,
        )
    return ridges


def fit_ridges(ridges: Sequence[Ridge]) -> ModalSet:
    """Return the modes from the slopes along the ridges, Eq. (21).

    ``wn = sqrt(a_phi^2 + a_A^2)`` and ``zeta = -a_A / wn`` with a_phi the slope of the phase and a_A
    that of the log modulus, by weighted least squares over the trusted window, all channels with a
    common slope. The weights are the squared modulus over the squared noise: the inverse variance of
    both logarithm and phase.

    Parameters
    ----------
    ridges : sequence of Ridge
        As from `find_ridges`.

    Returns
    -------
    ModalSet
        With shapes at the channels, and the covariance of the poles: the noise of the skeletons, with
        its known correlation over time, through the weighted lines to first order.

    Raises
    ------
    InputError
        If there are no ridges.

    Examples
    --------
    >>> import numpy as np, control
    >>> from suspid import cwt
    >>> t = np.arange(0, 10, 0.01)
    >>> decay = control.TimeResponseData(t, np.exp(-t) * np.cos(40 * t), issiso=True, output_labels=["seat"])
    >>> modes = fit_ridges(find_ridges(cwt(decay, omega=np.geomspace(10, 100, 100), bandwidth=22.0)))
    >>> modes.zeta.round(6)
    array([0.024992])
    """
    if not ridges:
        raise InputError("no ridges to fit")
    fits = [fit_skeleton(ridge) for ridge in ridges]
    covariance = np.diag(np.repeat([fit.variance for fit in fits], 2))
    # A common factor exp(offset) keeps the shapes of strong and weak channels within range.
    shapes = np.stack([np.exp(fit.origin - np.max(fit.origin.real)) for fit in fits], axis=1)
    return ModalSet(
        poles=np.array([fit.pole for fit in fits]),
        shapes=scaled_shapes(shapes),
        channels=ridges[0].channels,
        covariance=covariance,
    )


def fit_skeleton(ridge: Ridge) -> SkeletonFit:
    """Return the weighted lines through log modulus and phase of one ridge, all channels together."""
    keep = ridge.trusted
    time, skeleton = ridge.timepts[keep], ridge.skeleton[:, keep]
    elapsed = time - ridge.onset
    # The phase turns by omega per second: unwrapping what is left of it cannot slip between samples.
    turned = skeleton * np.exp(-1j * ridge.omega * elapsed)
    # A silent channel has no logarithm: it gets the smallest there is, and no weight.
    silent = np.finfo(float).tiny
    logarithm = np.log(np.maximum(np.abs(turned), silent)) + 1j * np.unwrap(np.angle(turned), axis=1)
    weights = np.maximum((np.abs(skeleton) / ridge.floor[:, None]) ** 2, silent)
    mean_time = np.sum(weights * elapsed, axis=1, keepdims=True) / np.sum(weights, axis=1, keepdims=True)
    lever = weights * (elapsed - mean_time)
    inertia = float(np.sum(lever * (elapsed - mean_time)))
    slope = complex(np.sum(lever * logarithm) / inertia)
    origin = np.sum(weights * (logarithm - slope * elapsed), axis=1) / np.sum(weights, axis=1)
    model: ComplexArray = np.exp(origin[:, None] + slope * elapsed)
    variance = 0.0
    for channel, floor in enumerate(ridge.floor):
        if not np.any(skeleton[channel]):
            continue
        # Disturbances beyond the noise widen the result.
        residual = float(np.mean(np.abs(turned[channel] - model[channel]) ** 2))
        influence = np.asarray(lever[channel] / inertia / model[channel], complex)
        variance += 0.5 * max(floor**2, residual) * _correlated_power(influence, ridge, time)
    return SkeletonFit(
        pole=slope + 1j * ridge.omega,
        variance=variance,
        origin=origin,
        onset=ridge.onset,
        timepts=time,
        logarithm=logarithm + 1j * ridge.omega * elapsed,
    )


def sample_noise(signal: Signal) -> RealArray:
    """Return the standard deviation of white noise in each channel, by MAD of its finest wavelet details."""
    import pywt

    if signal.values.shape[1] < 16:
        return np.zeros(len(signal.values))
    _, details = pywt.dwt(signal.values, "sym8", mode="symmetric", axis=1)
    return np.asarray(np.median(np.abs(details), axis=1) / 0.6744897501960817)


def _correlated_power(influence: ComplexArray, ridge: Ridge, time: RealArray) -> float:
    """Return ``g^H R g`` with R the correlation of the noise along the row (a Gaussian of the time lag)."""
    from scipy.fft import fft, next_fast_len

    count = len(time)
    lag = (time - time[0]) / ridge.scale
    length = next_fast_len(2 * count)
    correlation = np.zeros(length)
    correlation[:count] = np.exp(-(lag**2) / (2 * ridge.wavelet.bandwidth))
    correlation[length - count + 1 :] = correlation[1:count][::-1]
    return float(np.sum(np.abs(fft(influence, length)) ** 2 * fft(correlation).real) / length)


def _peaks(scalogram: Scalogram, noise: RealArray, prominence: float) -> list[float]:
    """Return frequencies of local maxima of the energy over rows, the most energetic first."""
    from scipy.signal import find_peaks

    signal = scalogram.signal
    rms = np.sqrt(np.mean(signal.values**2, axis=1))
    weights = np.where(rms > 0, 1 / np.maximum(noise, 1e-9 * rms + (rms == 0)), 0.0) ** 2
    by_frequency = np.argsort(scalogram.omega)
    energy = np.zeros(len(scalogram.omega))
    for i, row in enumerate(scalogram.rows):
        inside = scalogram.inside(i, cones=SEARCH_CONES)
        time = scalogram.weights(i)[inside] * signal.step
        per_channel = np.abs(row[:, inside]) ** 2 @ time
        # Noise alone would give this much: a ridge is what stands above it.
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
    """Return the ridge moved to the frequency of its own skeleton, or None if that is no exponential near by."""
    ridge = _ridge_at(signal, omega, wavelet, noise)
    for _ in range(3):
        if np.sum(ridge.trusted) < 4:
            return None
        fit = fit_skeleton(ridge)
        if abs(np.log(max(fit.pole.imag, 1e-3 * omega) / omega)) > FARTHEST:
            return None
        ridge = _ridge_at(signal, fit.pole.imag, wavelet, noise, fit)
    if np.sum(ridge.trusted) < 4:
        return None
    skeleton = np.abs(ridge.skeleton[:, ridge.trusted]) / ridge.floor[:, None]
    fit = fit_skeleton(ridge)
    misfit = np.abs(np.exp(fit.logarithm) - np.exp(fit.lines)) / ridge.floor[:, None]
    return ridge if np.sum(misfit**2) < INCOHERENT * np.sum(skeleton**2) else None


def _stands_out(signal: Signal, ridge: Ridge) -> bool:
    """Return whether the ridge is more than noise or the flank or edge of another one.

    In the trusted window it must rise above the noise, have more energy than the rows beside it, and not grow.
    """
    if np.max(ridge.strength[ridge.trusted]) < STANDS_OUT:
        return False
    fit = fit_skeleton(ridge)
    if fit.pole.real > GROWTH * np.sqrt(fit.variance):
        return False
    # Where the record is short for the wavelet the window begins within the edge of the whole signal.
    cone = float(ridge.wavelet.envelope(ridge.omega))
    away = (ridge.window.start - ridge.onset) / cone - max(0.0, -fit.pole.real) * cone / 2
    gain = float(ridge.wavelet.gain(1j * ridge.omega, ridge.scale).real)
    whole = np.sqrt(np.mean((np.max(np.abs(signal.values), axis=1) * gain / ridge.floor) ** 2))
    edge = float(whole) * np.exp(-(max(away, 0.0) ** 2)) / (2 * np.sqrt(np.pi) * max(away, 0.3))
    if np.max(ridge.strength[ridge.trusted]) < OVER_EDGE * edge:
        return False
    # At this distance in the logarithm a lone mode has lost a factor e.
    aside = float(np.exp(np.sqrt(2 / ridge.wavelet.bandwidth) / ridge.wavelet.center))
    omega = np.array([ridge.omega / aside, ridge.omega, min(ridge.omega * aside, 0.999 * np.pi / signal.step)])
    beside = transform(signal, omega=omega, wavelet=ridge.wavelet, normalization="amplitude")
    energy = []
    for i, row in enumerate(beside.rows):
        time = beside.timepts(i)
        inside = (time >= ridge.window.start) & (time <= ridge.window.stop)
        energy.append(float(np.sum(np.mean((np.abs(row[:, inside]) / ridge.floor[:, None]) ** 2, axis=1))))
    return energy[1] > max(energy[0], energy[2])


def _ridge_at(signal: Signal, omega: float, wavelet: Morlet, noise: RealArray, fit: SkeletonFit | None = None) -> Ridge:
    row = transform(signal, omega=np.array([omega]), wavelet=wavelet)
    skeleton, time, cone = row.rows[0], row.timepts(0), float(row.cone[0])
    largest = np.max(np.abs(skeleton), axis=1)
    rounding = CUT * np.max(np.abs(signal.values), axis=1) * float(wavelet.gain(1j * omega, row.scale[0]).real)
    white = noise * np.sqrt(signal.step) * wavelet.noise_gain()
    floor = np.maximum(white, np.maximum(rounding, 1e-12 * np.max(largest)))
    floor = np.where(floor > 0, floor, 1.0)
    if fit is not None:
        floor = np.maximum(floor, _left_behind(skeleton, time, fit, signal.start + signal.duration - cone))
    strength = np.sqrt(np.sum((np.abs(skeleton) / floor[:, None]) ** 2, axis=0) / len(floor))
    peak = int(np.argmax(strength))
    onset = max(signal.start, float(time[peak]) - 1.5 * cone)
    decay = max(0.0, -fit.pole.real) if fit is not None else 0.0
    # A decay under the envelope moves its weight to earlier times: the edge reaches further.
    shift = decay * cone**2 / 2
    # The edge is that of the whole signal, not of this mode alone.
    loudest = np.max(np.abs(signal.values), axis=1) * float(wavelet.gain(1j * omega, row.scale[0]).real) / floor
    reach = cone * _edge_cones(EDGE_SHARE / max(1.0, float(np.max(loudest)))) + shift
    end = signal.start + signal.duration
    after = (time >= onset + reach) & (strength < ABOVE_NOISE)
    noise_floor = float(time[np.argmax(after)]) if np.any(after) else np.inf
    # Where the record is short for its wavelet, a quarter of it is kept at the cost of some edge. That edge then
    # counts as noise: what of it exceeds the share allowed for raises the floor.
    room = end - onset
    reach_on, reach_off = min(reach, 0.5 * room), min(reach, 0.25 * room)
    at_end = np.max(np.abs(signal.values[:, -max(1, int(cone / signal.step)) :]), axis=1)
    loudest_at_end = at_end * float(wavelet.gain(1j * omega, row.scale[0]).real) / floor
    excess = np.maximum(
        loudest * _edge((reach_on - shift) / cone) if reach_on < reach else 0.0,
        loudest_at_end * _edge(reach_off / cone) if reach_off < reach else 0.0,
    )
    floor = floor * np.maximum(1.0, excess / EDGE_SHARE)
    window = Window(onset_edge=onset + reach_on, record_end=end - reach_off, noise_floor=noise_floor)
    return Ridge(
        omega=float(omega),
        wavelet=wavelet,
        timepts=frozen_real(time),
        skeleton=frozen_complex(skeleton),
        trace=frozen_real(np.full(len(time), omega)),
        floor=frozen_real(floor),
        window=window,
        onset=onset,
        channels=signal.channels,
    )


def _left_behind(skeleton: ComplexArray, time: RealArray, fit: SkeletonFit, until: Second) -> RealArray:
    """Return what stands in the row when its own decay is long over, root mean square by channel.

    Noise that is not white (a denoised record's, a hum's skirt) shows only here.
    """
    own = np.exp(np.minimum((fit.origin[:, None] + fit.pole * (time - fit.onset)).real, 600.0))
    over = (own < np.abs(skeleton) / ABOVE_NOISE) & (time > fit.timepts[0]) & (time < until)
    power = np.sum(np.abs(skeleton) ** 2 * over, axis=1) / np.maximum(np.sum(over, axis=1), 1)
    return np.where(np.sum(over, axis=1) >= 4, np.sqrt(power), 0.0)


def _edge(cones: float) -> float:
    """Return how much an edge disturbs at a distance u in cones: ``exp(-u^2) / (2 sqrt(pi) u)``."""
    u = max(cones, 0.2)
    return float(np.exp(-(u**2)) / (2 * np.sqrt(np.pi) * u))


def _edge_cones(share: float) -> float:
    """Return the distance in cones at which an edge disturbs by ``share``."""
    u = 1.0
    for _ in range(30):
        u = np.sqrt(max(0.25, -np.log(share * 2 * np.sqrt(np.pi) * u)))
    return float(u)


def _traced(ridge: Ridge, scalogram: Scalogram) -> Ridge:
    """Return the ridge with the trace of largest modulus near it, at each of its times."""
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
