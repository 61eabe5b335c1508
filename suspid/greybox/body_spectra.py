"""The spectrum of a body on an unknown road: its mean over a drive, and resonances fitted to it.

The power of the acceleration of a body is ``f^e |1 + 2 k zeta s|^2 / |1 + 2 zeta s + s^2|^2`` with s = j f / f_n, times
a smooth function. The exponent e is that of the road, whose slope in a double logarithmic picture nobody knows; k is 1
where the damper acts between body and wheel; a bend, in the square of ln f, stands for roads without one slope, and for
the wheels' resonance further up. Levels of all windows are free, for speeds and roads change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.units import Hertz, Ratio, RealArray, Second

PERIODOGRAM: Second = 12.0  # of a periodogram: lines of 1/12 Hz are narrow compared with any damped body mode
# Tapered windows that overlap by half: how many independent windows each is worth, and over how many lines it spreads
# (F. J. Harris, Proc. IEEE 66 (1978) 51-83).
WORTH, LINE_WIDTH = 9 / 11, 1.5
MIDDLE: Hertz = 1.5  # about which the bend is
# Where parameters lie: exponent, bend, ln of the frequency, damping ratio, k. Roads have exponents of 1 to 4, so the
# accelerations that follow them have 3 to 0.
LOWER = np.array([0.0, -2.0, np.log(0.6), 0.05, 0.0])
UPPER = np.array([3.0, 2.0, np.log(4.0), 0.9, 1.5])
SCALE = np.array([0.5, 0.3, 0.1, 0.1, 0.3])
FIRST_HERTZ = (1.0, 1.4, 2.0)  # Hz


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Periodograms:
    """Periodograms of one channel over the windows of all stretches, each divided by its level."""

    hertz: RealArray
    power: RealArray  # (window, line)
    blocks: NDArray[np.intp]  # (window,): which windows are drawn together

    @property
    def mean(self) -> RealArray:
        """Mean over the windows, (line,)."""
        return np.asarray(np.mean(self.power, axis=0))


@dataclass(frozen=True, kw_only=True, slots=True)
class Shape:
    """A model of the spectrum: whether it is bent and has a free numerator, and the band in which it is fitted."""

    bent: bool
    numerator: bool
    band: tuple[Hertz, Hertz]

    @property
    def free(self) -> NDArray[np.intp]:
        """Which parameters are free."""
        return np.flatnonzero([True, self.bent, True, True, self.numerator])

    def inside(self, hertz: RealArray) -> NDArray[np.bool_]:
        """Return which lines are in the band."""
        return (hertz >= self.band[0]) & (hertz <= self.band[1])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Fitted:
    """A model with the parameters that fit the mean spectrum best, and its misfit."""

    shape: Shape
    parameters: RealArray
    misfit: float  # sum of squares of the logarithm

    @property
    def hertz(self) -> Hertz:
        """Natural frequency [Hz]."""
        return float(np.exp(self.parameters[2]))

    @property
    def zeta(self) -> Ratio:
        """Damping ratio [1], which depends on the model."""
        return float(self.parameters[3])


def periodograms(rows: Sequence[tuple[RealArray, Second]], *, order: int, band: tuple[Hertz, Hertz]) -> Periodograms:
    """Return the periodograms of stretches (samples, step) of the ``order``-th derivative of a displacement."""
    found, blocks, count = [], list[int](), 0
    lines = np.arange(1, int(band[1] * PERIODOGRAM) + 2)
    for values, step in rows:
        size = round(PERIODOGRAM / step)
        starts = range(0, len(values) - size + 1, size // 2)
        window = np.hanning(size + 2)[1:-1]
        for k, start in enumerate(starts):
            part = values[start : start + size]
            spectrum = np.fft.rfft((part - np.mean(part)) * window)[lines]
            found.append(np.abs(spectrum) ** 2)
            # Windows, half overlapping, that are drawn together: 36 s, over which a road is much the same.
            blocks.append(count + k // 5)
        count = blocks[-1] + 1 if blocks else 0
    hertz = lines / PERIODOGRAM
    power = np.array(found).reshape(len(found), len(lines)) * (2 * np.pi * hertz) ** (2 * (2 - order))
    inside = (hertz >= band[0]) & (hertz <= band[1])
    level = np.mean(power[:, inside], axis=1, keepdims=True)
    return Periodograms(hertz=hertz, power=power / np.where(level > 0, level, 1.0), blocks=np.array(blocks, int))


def log_spectrum(parameters: RealArray, hertz: RealArray) -> RealArray:
    """Return the logarithm of the spectrum, up to a constant."""
    exponent, bend, log_f, zeta, share = parameters
    r, x = hertz / np.exp(log_f), np.log(hertz / MIDDLE)
    top = np.log1p((2 * share * zeta * r) ** 2)
    return np.asarray(exponent * x + bend * x**2 + top - np.log((1 - r**2) ** 2 + (2 * zeta * r) ** 2))


def fitted(shape: Shape, hertz: RealArray, mean: RealArray, starts: Sequence[RealArray] = ()) -> Fitted:
    """Return the best fit of a model to the logarithm of a mean spectrum."""
    from scipy.optimize import least_squares

    inside, free = shape.inside(hertz), shape.free
    f, target = hertz[inside], np.log(mean[inside])
    base = np.array([2.0, 0.0, 0.0, 0.25, 1.0])

    def residual(x: RealArray) -> RealArray:
        p = base.copy()
        p[free] = x
        left = log_spectrum(p, f) - target
        return np.asarray(left - np.mean(left))

    margin = 1e-3
    best, at = np.inf, base
    for start in starts or [np.array([2.0, 0.0, np.log(hz), 0.25, 0.9]) for hz in FIRST_HERTZ]:
        found = least_squares(
            residual,
            np.clip(start, LOWER + margin, UPPER - margin)[free],
            bounds=(LOWER[free], UPPER[free]),
            x_scale=SCALE[free],
            xtol=1e-5,
        )
        if 2 * found.cost < best:
            best, at = 2 * float(found.cost), base.copy()
            at[free] = found.x
    return Fitted(shape=shape, parameters=at, misfit=best)


def scattered(found: Fitted, hertz: RealArray, mean: RealArray, others: RealArray, *, worth: float) -> RealArray:
    """Return the natural frequencies [Hz] of mean spectra (draw, line) near the fitted one, to first order.

    ``worth`` is the number of independent periodograms of each line. Parameters on a bound stay there, and between
    bounds they are taken as known to a twelfth of the squared distance; the frequency is free.
    """
    inside, p = found.shape.inside(hertz), found.parameters
    span = UPPER - LOWER
    free = [i for i in found.shape.free if 1e-3 * span[i] < p[i] - LOWER[i] < (1 - 1e-3) * span[i]]
    steps = 1e-4 * SCALE
    slope = np.column_stack(
        [
            (log_spectrum(p + e, hertz[inside]) - log_spectrum(p - e, hertz[inside])) / (2 * steps[i])
            for i, e in ((i, steps[i] * np.eye(len(p))[i]) for i in free)
        ]
    )
    slope -= np.mean(slope, axis=0)
    change = np.log(others[:, inside]) - np.log(mean[inside])
    change -= np.mean(change, axis=1, keepdims=True)
    known = np.where(np.array(free) == 2, 0.0, 12 / span[free] ** 2)
    moved = change @ (worth * slope) @ np.linalg.inv(worth * slope.T @ slope + np.diag(known))
    return np.asarray(found.hertz * np.exp(moved[:, free.index(2)]))


def misfit_without(hertz: RealArray, mean: RealArray, band: tuple[Hertz, Hertz]) -> float:
    """Return the misfit of a smooth spectrum without a resonance: a parabola in the double logarithmic picture."""
    inside = (hertz >= band[0]) & (hertz <= band[1])
    x, y = np.log(hertz[inside] / MIDDLE), np.log(mean[inside])
    return float(np.sum((y - np.polyval(np.polyfit(x, y, 2), x)) ** 2))
