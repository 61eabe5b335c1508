"""Test whether the residual of a damper fit follows the motion of the strut, or is noise and other forces.

An engine, the other axle or a passenger push the body as they like: that costs precision. What is missing in the
strut, or wrong in a sensor (gain, delay, a mount, a spring that is not linear), leaves a force that follows the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.greybox.curve_fit import CurveFit, Shape
from suspid.greybox.curve_noise import PROBES, SPECTRUM_BANDS, Drawn, lines_of
from suspid.greybox.latent_splines import at_samples
from suspid.greybox.strut_motion import StrutMotion
from suspid.units import ComplexArray, Flags, Ratio, RealArray

# Neighbouring lines of a Hann window, and stretches that overlap by half, are not independent: this share of them is,
# one over the sum of the squares of all correlations, 4/9, 1/36 … of lines and 1/36, 0.02 … of stretches.
INDEPENDENT_LINES = 0.474
# Level of the tests whether a damper is viscous, and whether a residual follows the motion: one false alarm in a
# hundred curves.
CURVE_LEVEL = 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class Following:
    """Test that the residual of a curve follows the strut's velocity, or the cube of its travel."""

    statistic: float  # mean over the bands of F, which is 1 where nothing follows
    p_value: float
    share: Ratio  # of the damper's force that the residual follows it by, by chance about half a percent
    pushed: bool = False  # whether a force of its own pushes the body where that moves the strut, or everywhere

    def __bool__(self) -> bool:
        return self.p_value < CURVE_LEVEL


def following_of(motions: Sequence[StrutMotion], shape: Shape, fit: CurveFit, drawn: Sequence[Drawn]) -> Following:
    """Return the test for a fit whose splines are the travel.

    The residual follows the errors of the velocity that was found: as far as drawn noises do, it is taken off.

    In each band of the spectrum the residual is compared with velocity and cubed travel. Each line counts alike, so
    that a steady vibration does not hide the others; the least probability counts once for each band.
    """
    from scipy.stats import f

    # Steps that were found from stamps differ by rounding: the lines are the same for all.
    length, use = lines_of(min(len(m.force) for m in motions), motions[0].step)
    left, velocity, cube = [], [], []
    noisy, errors = [], []
    for motion, spline, part, noises in zip(motions, fit.splines, fit.records, drawn, strict=True):
        travel = at_samples(spline, 0, motion.step)
        left.append(_spectra(part.force_residual, length, use))
        velocity.append(_spectra(part.velocity, length, use))
        cube.append(_spectra((travel - np.mean(travel)) ** 3, length, use))
        made, off = (one[:, :PROBES] + one[:, PROBES:] for one in (noises.left, noises.errors))
        noisy += [_spectra(one, length, use) for one in made.T]
        errors += [_spectra(at_samples(one, 1, motion.step), length, use) for one in off.T]
    rest, causes = np.vstack(left), [np.vstack(velocity), np.vstack(cube)]
    through, wrong = np.vstack(noisy), np.vstack(errors)
    lines = np.sqrt(np.mean(np.abs(rest) ** 2, axis=0))
    lines[lines == 0] = 1.0
    ratios, chances, followed = [], [], 0.0
    for band in np.array_split(np.arange(len(lines)), SPECTRUM_BANDS):
        # The drawn noises are `PROBES` times as many as the record's.
        common = np.vdot(wrong[:, band], through[:, band]) / PROBES
        by_errors = common / max(float(np.vdot(causes[0][:, band], causes[0][:, band]).real), np.finfo(float).tiny)
        y = ((rest[:, band] - by_errors * causes[0][:, band]) / lines[band]).ravel()
        columns = np.stack([(one[:, band] / lines[band]).ravel() for one in causes], axis=1)
        explained = columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
        followed += float(np.sum(np.abs(explained.reshape(len(rest), -1) * lines[band]) ** 2))
        size, count = columns.shape[1], max(INDEPENDENT_LINES * len(y), columns.shape[1] + 1.0)
        square, part_square = float(np.vdot(y, y).real), float(np.vdot(explained, explained).real)
        # What is left is known to the rounding of the whole.
        over = max(square - part_square, np.finfo(float).eps * square, np.finfo(float).tiny) / (count - size)
        ratio = part_square / size / over
        ratios.append(ratio)
        chances.append(float(f.sf(ratio, 2 * size, 2 * (count - size))))
    forces = shape.forces(fit.theta)
    damping = float(forces @ shape.nodes / (shape.nodes @ shape.nodes))
    whole = max(damping**2 * float(np.vdot(causes[0], causes[0]).real), np.finfo(float).tiny)
    return Following(
        statistic=float(np.mean(ratios)),
        p_value=min(1.0, SPECTRUM_BANDS * min(chances)),
        share=float(np.sqrt(followed / whole)),
    )


def _spectra(signal: RealArray, length: int, use: Flags) -> ComplexArray:
    """Return the lines that count of all stretches of a signal, (stretch, line)."""
    stretches = np.lib.stride_tricks.sliding_window_view(signal, length)[:: max(length // 2, 1)]
    window = np.hanning(length)
    return np.asarray(np.fft.rfft((stretches - stretches.mean(axis=1, keepdims=True)) * window, axis=1)[:, use])
