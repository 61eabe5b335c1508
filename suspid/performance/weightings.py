"""Frequency weightings of human vibration: ISO 8041-1, as ISO 2631-1 uses them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.units import ComplexArray, Hertz, Ratio, RealArray, Second
from suspid.values import LARGEST_SIZE, nearest_names
from suspid.wording import Argument


class Weighting(NamedTuple):
    """A weighting by the corners of its filters, ISO 8041-1:2017, Table 3; ``inf`` leaves a step out.

    Taken from publications that quote the standard; they give its table of bands (Annex B) to all digits.
    """

    f1: Hertz  # band limiting, Butterworth of second order: high pass
    f2: Hertz  # and low pass
    f3: Hertz  # acceleration to velocity: from here on the response falls with 1 / f
    f4: Hertz
    q4: Ratio
    f5: Hertz  # upward step
    q5: Ratio
    f6: Hertz
    q6: Ratio
    gain: Ratio = 1.0


INF = float("inf")
# Wk: vertical, seat and floor. Wd: horizontal. Wf: motion sickness. Wc: backrest. We: rotation. Wj: lying head.
# Wb: vertical in rail vehicles. Wm: buildings.
WEIGHTINGS: Mapping[str, Weighting] = MappingProxyType(
    {
        "Wb": Weighting(0.4, 100.0, 16.0, 16.0, 0.55, 2.5, 0.9, 4.0, 0.95, 1.024),
        "Wc": Weighting(0.4, 100.0, 8.0, 8.0, 0.63, INF, 1.0, INF, 1.0),
        "Wd": Weighting(0.4, 100.0, 2.0, 2.0, 0.63, INF, 1.0, INF, 1.0),
        "We": Weighting(0.4, 100.0, 1.0, 1.0, 0.63, INF, 1.0, INF, 1.0),
        "Wf": Weighting(0.08, 0.63, INF, 0.25, 0.86, 0.0625, 0.80, 0.10, 0.80),
        "Wj": Weighting(0.4, 100.0, INF, INF, 1.0, 3.75, 0.91, 5.32, 0.91),
        "Wk": Weighting(0.4, 100.0, 12.5, 12.5, 0.63, 2.37, 0.91, 3.35, 0.91),
        "Wm": Weighting(10**-0.1, 100.0, 1 / (0.028 * 2 * np.pi), 1 / (0.028 * 2 * np.pi), 0.5, INF, 1.0, INF, 1.0),
    }
)
BUTTERWORTH = 2**0.5
# Samples that are transformed at once, 32 MB of them; longer records are weighted at a lower rate: up to this multiple
# of the upper corner, where a weighting is below 1e-3.
MOST_AT_ONCE, ENOUGH = 2**22, 40.0


@explained
def weighting(name: str, hertz: ArrayLike) -> ComplexArray:
    """Return the frequency response of a weighting of ISO 2631-1 at frequencies [1], in the shape of ``hertz``.

    Parameters
    ----------
    name : str
        ``"Wk"`` for vertical vibration of a seat or floor, ``"Wd"`` horizontal, ``"Wf"`` motion sickness, ``"Wc"``
        backrest, ``"We"`` rotation, ``"Wj"`` the head of someone lying, ``"Wb"`` vertical in rail vehicles, ``"Wm"``
        buildings.
    hertz : array_like
        Frequencies [Hz].

    Raises
    ------
    InputError
        If there is no such weighting, or frequencies are no real numbers of usual size.

    Examples
    --------
    ISO 8041-1, Table 1: 0.7718 at 100 rad/s.

    >>> float(abs(weighting("Wk", 100 / (2 * np.pi))).round(4))
    0.7718
    """
    w = weighting_named(name)
    s = 2j * np.pi * _frequencies(hertz)
    w1, w2, w3, w4, w5, w6 = (2 * np.pi * f for f in (w.f1, w.f2, w.f3, w.f4, w.f5, w.f6))
    response = w.gain * s**2 / (s**2 + BUTTERWORTH * w1 * s + w1**2) / (1 + BUTTERWORTH * s / w2 + (s / w2) ** 2)
    response *= (1 + s / w3) / (1 + s / (w.q4 * w4) + (s / w4) ** 2)
    if np.isfinite(w5):
        rise = (1 + s / (w.q5 * w5) + (s / w5) ** 2) / (1 + s / (w.q6 * w6) + (s / w6) ** 2)
        response *= rise * (w5 / w6) ** 2
    return np.asarray(response)


def _frequencies(hertz: ArrayLike) -> RealArray:
    """Return frequencies as an array of numbers [Hz]."""
    with suppress(ValueError):  # Rows of different lengths are no array.
        given = np.asarray(hertz)
        if given.dtype.kind in "iuf" and np.all(np.abs(given) <= LARGEST_SIZE):
            return np.asarray(given, float)
    raise InputError(
        Argument("hertz", f"{hertz!r:.40}"),
        f" must be real and finite, at most {LARGEST_SIZE:g}: write a frequency in Hz such as 4.0, or an array of them",
    )


def weighted(values: RealArray, step: Second, name: str) -> RealArray:
    """Return samples (…, sample) after a weighting, at rest before the first.

    The response is that of the standard at every frequency that the samples hold: it is applied to the spectrum of
    the record, which zeros follow until the filter has died away. Very long or fast records come back at a lower rate
    that holds all that the weighting leaves.

    Examples
    --------
    A vibration of 1 m/s2 at 6.3 Hz counts as 1.054 m/s2:

    >>> t = np.arange(0, 20, 0.002)
    >>> felt = weighted(np.sin(2 * np.pi * 10**0.8 * t), 0.002, "Wk")
    >>> float(np.std(felt[5000:]) * np.sqrt(2)).__round__(2)
    1.05
    """
    from scipy.fft import next_fast_len

    count = values.shape[-1]
    w = weighting_named(name)
    # Slower than any of the filter's decays: after 10 / f1 seconds e^-40 is left.
    size = count + int(np.ceil(10 / (w.f1 * step)))
    top = ENOUGH * w.f2
    if size > MOST_AT_ONCE and 2 * top * step < 1:
        return _weighted_below(values, step, name, top, size)
    size = next_fast_len(size, real=True)
    response = weighting(name, np.fft.rfftfreq(size, step))
    return np.asarray(np.fft.irfft(np.fft.rfft(values, size) * response, size)[..., :count])


def _weighted_below(values: RealArray, step: Second, name: str, top: Hertz, size: int) -> RealArray:
    """Return samples after a weighting at twice the rate of ``top``, beyond which nothing is left of them.

    The spectrum of the samples, which ``size`` counts with the zeros behind them, is computed up to there alone.
    """
    from scipy.signal import czt

    count, last = values.shape[-1], int(top * step * size)
    spectrum = czt(values, m=last + 1, w=np.exp(-2j * np.pi / size), axis=-1)
    response = weighting(name, np.arange(last + 1) / (size * step))
    made = np.fft.irfft(spectrum * response, 2 * last) * (2 * last / size)
    return np.asarray(made[..., : max(count * 2 * last // size, 1)])


def weighting_named(name: str) -> Weighting:
    """Return a weighting by its name."""
    if name not in WEIGHTINGS:
        raise InputError(f"there is no weighting {name!r}.{nearest_names(name, WEIGHTINGS)}")
    return WEIGHTINGS[name]
