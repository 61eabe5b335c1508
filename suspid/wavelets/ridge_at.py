"""The skeleton at one frequency and its trusted window."""

from __future__ import annotations

import numpy as np

from suspid.signals import Signal
from suspid.units import ComplexArray, RealArray, Second
from suspid.values import frozen_complex, frozen_real
from suspid.wavelets.fit_ridges import SkeletonFit
from suspid.wavelets.morlet import Morlet
from suspid.wavelets.ridge import Ridge, Window
from suspid.wavelets.transform import CUT, transform

# A skeleton is trusted while its modulus is this many times the noise in its row. A lower limit biases the damping by
# the noise; a higher one shortens the window.
ABOVE_NOISE = 3.0
# Ratio of edge effect to noise at the start of the window. The edge effect then falls faster than any exponential, so
# over the whole window it stays below the noise.
EDGE_SHARE = 3.0


def ridge_at(signal: Signal, omega: float, wavelet: Morlet, noise: RealArray, fit: SkeletonFit | None = None) -> Ridge:
    """Return the skeleton at an angular frequency [rad/s] with its noise and its trusted window.

    ``noise`` is the standard deviation of white noise in the samples of each channel. The lines through an earlier
    skeleton near by, ``fit``, tell how far the onset reaches and what else is in the row.
    """
    row = transform(signal, omega=np.array([omega]), wavelet=wavelet)
    skeleton, time, cone = row.rows[0], row.timepts(0), float(row.cone[0])
    largest = np.max(np.abs(skeleton), axis=1)
    gain = float(wavelet.gain(1j * omega, row.scale[0]).real)
    rounding = CUT * np.max(np.abs(signal.values), axis=1) * gain
    white = noise * np.sqrt(signal.step) * wavelet.noise_gain()
    floor = np.maximum(white, np.maximum(rounding, 1e-12 * np.max(largest)))
    floor = np.where(floor > 0, floor, 1.0)
    if fit is not None:
        floor = np.maximum(floor, _left_behind(skeleton, time, fit, signal.start + signal.duration - cone))
    strength = np.sqrt(np.sum((np.abs(skeleton) / floor[:, None]) ** 2, axis=0) / len(floor))
    peak = int(np.argmax(strength))
    onset = max(signal.start, float(time[peak]) - 1.5 * cone)
    decay = max(0.0, -fit.pole.real) if fit is not None else 0.0
    # Decay within the envelope shifts its weight to earlier times, so the edge effect reaches further.
    shift = decay * cone**2 / 2
    # The edge effect is that of the whole signal, not of this mode alone.
    largest_over_noise = np.max(np.abs(signal.values), axis=1) * gain / floor
    reach = cone * edge_cones(EDGE_SHARE / max(1.0, float(np.max(largest_over_noise)))) + shift
    end = signal.start + signal.duration
    after = (time >= onset + reach) & (strength < ABOVE_NOISE)
    noise_floor = float(time[np.argmax(after)]) if np.any(after) else np.inf
    # In a record that is short for its wavelet a quarter of it is kept. The edge effect there counts as noise: what
    # exceeds the permitted share raises the floor.
    room = end - onset
    reach_on, reach_off = min(reach, 0.5 * room), min(reach, 0.25 * room)
    at_end = np.max(np.abs(signal.values[:, -max(1, int(cone / signal.step)) :]), axis=1)
    excess = np.maximum(
        largest_over_noise * edge_effect((reach_on - shift) / cone) if reach_on < reach else 0.0,
        at_end * gain / floor * edge_effect(reach_off / cone) if reach_off < reach else 0.0,
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
    """Return the root mean square of the row after its own decay has ended, (channel,).

    Noise that is not white (that of a denoised record, the flank of a hum) shows only there.
    """
    own = np.exp(np.minimum((fit.origin[:, None] + fit.pole * (time - fit.onset)).real, 600.0))
    over = (own < np.abs(skeleton) / ABOVE_NOISE) & (time > fit.timepts[0]) & (time < until)
    power = np.sum(np.abs(skeleton) ** 2 * over, axis=1) / np.maximum(np.sum(over, axis=1), 1)
    return np.where(np.sum(over, axis=1) >= 4, np.sqrt(power), 0.0)


def edge_effect(cones: float) -> float:
    """Return the edge effect at a distance u in cones, over the modulus: about ``exp(-u^2) / (2 sqrt(pi) u)``."""
    u = max(cones, 0.2)
    return float(np.exp(-(u**2)) / (2 * np.sqrt(np.pi) * u))


def edge_cones(share: float) -> float:
    """Return the distance in cones at which the edge effect falls to ``share``."""
    u = 1.0
    for _ in range(30):
        u = np.sqrt(max(0.25, -np.log(share * 2 * np.sqrt(np.pi) * u)))
    return float(u)
