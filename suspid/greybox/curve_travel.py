"""Fit of spring, damper curve and friction of a strut whose travel is measured.

Travel with white noise tells the motion but for a Gaussian error, whose spectrum follows from those of the travel and
of its noise (Wiener). The force that is expected under the travel is linear in the stiffness, the forces at the nodes
and the friction: its columns are those of the expected motion, averaged over the error of the velocity. That is
regression calibration (R. J. Carroll et al., Measurement Error in Nonlinear Models, ch. 4): kinks and friction are not
biased by noise that a derivative of the travel has.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.curve_fit import SCORE_BLOCK, CurveFit, Linearised, Noise, Shape, smoothed
from suspid.greybox.curve_noise import PROBES, SPECTRUM_STRETCH, Residual, averaged, by_bands, noise_of
from suspid.greybox.force_basis import node_slope, sign_between, smooth_weights
from suspid.greybox.latent_splines import CORNER_SHARE, FILTER_STEPS, FINE_POINTS, filtered
from suspid.greybox.strut_motion import StrutMotion
from suspid.units import RealArray, Second

# Left out at both ends of a record, where the motion between the samples is not known: time, and at most this share.
END: Second = 1.0
END_SHARE = 0.05
# Range of frequencies, as shares of the filter's corner, in which force and travel are mostly noise.
NOISY_LINES = (0.8, 1.0)
# A strut sticks where its velocity is within this many errors of rest over this many samples or more: a velocity that
# changes its sign in motion is through in less than one. Friction has no law there; samples beside it are left out too.
REST_ERRORS, REST_SAMPLES, REST_MARGIN = 2.0, 3, 2
# At a turn friction holds the strut until the other forces have changed by its double. Where that lasts for this number
# of samples or more, every sample near rest is left out, and more beside it: shorter sticks than those above are not
# seen, and friction would be found too small.
HELD_SAMPLES, HELD_MARGIN = 1.0, 4
# How often noise and curve are found in turn; the noise changes by less than a percent after three rounds.
TRAVEL_ROUNDS = 4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Expected:
    """The motion that is expected under a record's travel, at the fine points, and its errors."""

    travel: RealArray
    velocity: RealArray
    error: float  # of the velocity [m/s]
    moves: RealArray  # (sample that is used,): 1, or 0 where the strut sticks
    probes: tuple[tuple[RealArray, RealArray], ...]  # drawn errors of travel and velocity


def travel_fit(
    motions: Sequence[StrutMotion], shaped: Callable[[RealArray], Shape], rng: np.random.Generator
) -> tuple[CurveFit, Shape, Noise, Residual]:
    """Return the curve, its nodes, the noise of both signals, and what is left; ``shaped`` places nodes by velocity."""
    noise = Noise(force=_white(motions, "force"), motion=_white(motions, "motion"))
    most, shape, held = noise.motion, None, False
    for last in [*[False] * TRAVEL_ROUNDS, True]:
        moved = [_expected(one, noise.motion, rng, held=held) for one in motions]
        if shape is None:
            samples = [one.velocity[::FINE_POINTS][_inside(m)] for one, m in zip(moved, motions, strict=True)]
            shape = shaped(np.concatenate(samples))
        columns = [_columns(m, one, shape) for m, one in zip(motions, moved, strict=True)]
        fit = _fitted(motions, moved, columns, friction=shape.friction)
        left = _residual(motions, moved, columns, shape, fit, noise, rng)
        held = held or (shape.friction and _turn_samples(motions, float(fit.theta[-1])) >= HELD_SAMPLES)
        shown = noise_of(left, noise)
        noise = noise if last else Noise(force=shown.force, motion=min(shown.motion, most), velocity=left.velocity)
    assert shape is not None
    return fit, shape, noise, left


def _white(motions: Sequence[StrutMotion], signal: str) -> float:
    """Return the standard deviation of white noise with the power that a signal has near the corner of the filter."""
    powers = []
    for one in motions:
        f, density = _density(getattr(one, signal), one.step)
        low, high = (share * CORNER_SHARE / one.step for share in NOISY_LINES)
        powers.append(float(np.mean(density[(f >= low) & (f <= high)])) / (2 * one.step))
    return float(np.sqrt(np.mean(powers)))


def _density(signal: RealArray, step: Second) -> tuple[RealArray, RealArray]:
    from scipy.signal import welch

    f, density = welch(signal, fs=1 / step, nperseg=min(round(SPECTRUM_STRETCH / step), len(signal)))
    return f, density


def _inside(motion: StrutMotion) -> slice:
    """Return the samples of a record that are used."""
    count = len(motion.force)
    end = max(FILTER_STEPS, min(round(END / motion.step), int(END_SHARE * count)))
    return slice(end, count - end)


def _turn_samples(motions: Sequence[StrutMotion], friction: float) -> float:
    """Return for how many samples friction usually holds the strut at a turn."""
    changes = np.concatenate([np.diff(smoothed(one.force, one.step)[_inside(one)]) for one in motions])
    return 2 * friction / max(float(np.sqrt(np.mean(changes**2))), np.finfo(float).tiny)


def _expected(motion: StrutMotion, noise: float, rng: np.random.Generator, *, held: bool) -> _Expected:
    """Return the expected motion where the travel has white noise of a standard deviation."""
    from scipy.ndimage import binary_dilation, binary_opening, uniform_filter1d

    h, count = motion.step, len(motion.motion)
    end = min(round(END / h), count - 1)
    # Reflected about its ends, then to zero, so that none is a jump.
    ramp = np.sin(np.linspace(0, np.pi / 2, end)) ** 2
    whole = np.pad(motion.motion - np.mean(motion.motion), end, mode="reflect", reflect_type="odd")
    whole *= np.concatenate([ramp, np.ones(count), ramp[::-1]])
    f, density = _density(motion.motion, h)
    lines = np.fft.rfftfreq(len(whole), h)
    power = 2 * h * noise**2
    # Averaged over a hertz.
    shown = uniform_filter1d(density, round(SPECTRUM_STRETCH))
    motion_share = np.maximum(1 - power / np.interp(lines, f, shown), 0.0)
    turning = 2j * np.pi * lines
    if len(whole) % 2 == 0:
        motion_share[-1] = 0.0

    def fine(spectrum: RealArray) -> RealArray:
        made = np.fft.irfft(spectrum, FINE_POINTS * len(whole)) * FINE_POINTS
        return np.asarray(made[end * FINE_POINTS : (end + count - 1) * FINE_POINTS + 1])

    seen = motion_share * np.fft.rfft(whole)
    error = float(np.sqrt(np.sum(power * motion_share * np.abs(turning) ** 2) * (lines[1] - lines[0])))
    velocity = fine(turning * seen)
    rest = np.abs(velocity[::FINE_POINTS]) < REST_ERRORS * error
    stuck = rest if held else binary_opening(rest, np.ones(REST_SAMPLES, np.bool_))
    margin = HELD_MARGIN if held else REST_MARGIN
    drawn = noise * np.sqrt(motion_share) * np.fft.rfft(rng.standard_normal((PROBES, len(whole))), axis=1)
    return _Expected(
        travel=fine(seen),
        velocity=velocity,
        error=error,
        moves=np.asarray(~binary_dilation(stuck, iterations=margin)[_inside(motion)], float),
        probes=tuple((fine(one), fine(turning * one)) for one in drawn),
    )


def _columns(motion: StrutMotion, moved: _Expected, shape: Shape) -> RealArray:
    """Return the expected force per unknown, less its mean, (sample, unknown)."""
    weights = smooth_weights(moved.velocity, shape.nodes, moved.error)[:, shape.nodes != 0]
    parts = [moved.travel[:, None], weights]
    if shape.friction:
        parts.append(sign_between(moved.velocity, moved.error)[:, None])
    return _behind(np.hstack(parts), motion, moved)


def _behind(fine: RealArray, motion: StrutMotion, moved: _Expected) -> RealArray:
    """Return what is given at the fine points behind the filter, where it is used, less its mean, (sample, column)."""
    return _centred(filtered(fine, motion.step, CORNER_SHARE / motion.step)[_inside(motion)], moved)


def _centred(signals: RealArray, moved: _Expected) -> RealArray:
    """Return signals (sample, column) less their means while the strut moves; zero where it sticks."""
    mean = moved.moves @ signals / max(np.sum(moved.moves), 1.0)
    return np.asarray((signals - mean) * moved.moves[:, None])


def _late(motion: StrutMotion, moved: _Expected) -> RealArray:
    """Return what friction adds at turns that the travel does not tell, but for two factors, (sample, 2).

    Friction bends the velocity where it passes through zero: it is steeper before than after. The smooth velocity that
    the travel tells therefore passes late, by an error of velocity that is the same at every turn, and friction changes
    its sign late; and the damper's force lacks a pulse that is the same at every turn.
    """
    slope = np.gradient(moved.velocity)
    turning = moved.error * np.sign(slope)
    before, after = (sign_between(moved.velocity + side * turning, moved.error) for side in (1, -1))
    made = np.column_stack([before - after, (before - after) * np.abs(slope) / np.max(np.abs(slope))])
    return _behind(made, motion, moved)


def _fitted(
    motions: Sequence[StrutMotion], moved: Sequence[_Expected], columns: Sequence[RealArray], *, friction: bool
) -> CurveFit:
    forces = [
        _centred(smoothed(m.force, m.step)[_inside(m), None], one)[:, 0] for m, one in zip(motions, moved, strict=True)
    ]
    if friction:
        # Both factors are unknown in each record, and eliminated.
        late = [np.linalg.qr(_late(m, one))[0] for m, one in zip(motions, moved, strict=True)]
        forces = [f - q @ (q.T @ f) for f, q in zip(forces, late, strict=True)]
        columns = [c - q @ (q.T @ c) for c, q in zip(columns, late, strict=True)]
    inverse = np.linalg.inv(sum(one.T @ one for one in columns))
    theta = inverse @ sum(c.T @ f for c, f in zip(columns, forces, strict=True))
    records = []
    nothing = np.zeros(0)
    for m, one, c, force in zip(motions, moved, columns, forces, strict=True):
        block = max(1, round(SCORE_BLOCK / m.step))
        blocks, left = len(force) // block, force - c @ theta
        scores = (c * left[:, None])[: blocks * block].reshape(blocks, block, -1).sum(axis=1)
        records.append(
            Linearised(
                normal=c.T @ c, gradient=nothing, change=nothing, per_unknown=nothing, scores=scores,
                force_residual=left, velocity=one.velocity[::FINE_POINTS][_inside(m)],
            )
        )  # fmt: skip
    scores = np.concatenate([part.scores for part in records])
    spread = len(scores) / max(len(scores) - len(theta), 1)
    return CurveFit(
        theta=theta,
        covariance=inverse @ (scores.T @ scores) @ inverse * spread,
        splines=(),
        records=tuple(records),
        steps=1,
        settled=True,
    )


def _residual(
    motions: Sequence[StrutMotion],
    moved: Sequence[_Expected],
    columns: Sequence[RealArray],
    shape: Shape,
    fit: CurveFit,
    noise: Noise,
    rng: np.random.Generator,
) -> Residual:
    """Return the spectrum of the force that is left, and those that the noise of force and travel would leave."""
    power, expected, squares, weights = [], [], [], []
    forces, friction = shape.forces(fit.theta), float(fit.theta[-1]) if shape.friction else 0.0
    for motion, one, own_columns, part in zip(motions, moved, columns, fit.records, strict=True):
        drawn = rng.standard_normal((PROBES, len(motion.force)))
        own = noise.force * np.column_stack([smoothed(row, motion.step)[_inside(motion)] for row in drawn])
        mean = own_columns @ fit.theta
        others = []
        for travel, velocity in one.probes:
            v = one.velocity + velocity
            made = fit.theta[0] * (one.travel + travel) + _force(v, shape, forces) + friction * np.sign(v)
            others.append(_behind(made[:, None], motion, one)[:, 0] - mean)
        power.append(by_bands(part.force_residual[:, None], motion.step)[:, 0])
        both = by_bands(np.column_stack([_centred(own, one), *others]), motion.step)
        expected.append(both.reshape(-1, 2, PROBES).mean(axis=2))
        squares.append(one.error**2)
        weights.append(len(part.force_residual))
    whole = averaged(motions, power, expected, squares, weights)
    # What is left out tells nothing.
    told = float(np.mean(np.concatenate([one.moves for one in moved])))
    return replace(whole, independent=np.maximum(whole.independent * told, 1.0))


def _force(velocity: RealArray, shape: Shape, forces: RealArray) -> RealArray:
    """Return the force at velocities, beyond the last nodes with the slopes there."""
    nodes = shape.nodes
    inside = np.clip(velocity, nodes[0], nodes[-1])
    made = np.interp(inside, nodes, forces) + (velocity - inside) * node_slope(velocity, nodes, forces)
    return np.asarray(made)
