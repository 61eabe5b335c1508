"""Fit damped exponentials to a stretch and test whether they explain it from its first sample on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.decays.envelopes import QUIET_QUANTILE
from suspid.identification import (
    Selection,
    WhiteNoise,
    correlated,
    degrees_of_freedom,
    lag_one,
    select,
    synthesize,
)
from suspid.levels import CERTAIN, FEWEST_SAMPLES
from suspid.units import Hertz, RealArray, Second
from suspid.words import Reason

# Blocks per cycle of the highest band that rings: samples are averaged in blocks of that length. Fewer blocks damp the
# highest mode; more cost time.
BLOCKS_A_CYCLE = 8.0
# Means over blocks lose at most this share of the energy of smooth motion: what is within a block is smooth if its
# lag-1 correlation is above the second number; noise has none. One mode loses 5 % in eight blocks a cycle.
MOST_LOST, WITHIN_SMOOTH = 0.2, 0.5
# Blocks that a trial uses at most, the first ones: more cost time for what lies in the noise. Fewer than a record needs
# samples are not fitted.
MOST_BLOCKS = 600
# Pairs that a trial seeks at most. A decay has fewer poles when those that are not needed are gone; a search for more
# takes most of the time of records that ring in many modes, which are refused.
MOST_SOUGHT = 16
# The residual of the first of this many parts is compared with the others, of at least this many blocks each. Longer
# parts dilute a forced beginning; shorter ones scatter.
TRIAL_PARTS, FEWEST_EARLY = 24, 6
# A residual below this share of the motion is not compared: the fit is exact to rounding.
EXACT_RESIDUAL = 1e-4
# The noise has at least this share of the variance of a quiet stretch, if there are this many stretches. Without it the
# fit spends poles on the background.
QUIET_SHARE, FEWEST_STRETCHES = 0.5, 4
# Quantile of the power over the stretches that counts as background. The median is too high where decays fill half of
# the recording.
CALM = 0.2
# Stretches that are looked at for it, at most, evenly over the recording: more tell no more, and take as long for each
# decay as the recording is long.
MOST_CALM = 256
# Share of a mode's own course that is left beside the free motion of all, below which a background is not told.
LEAST_BESIDE_FREE = 1e-9
# Order of the polynomial that a drift is within a stretch as long as a decay.
DRIFT_ORDER = 1


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trial:
    """Fit of damped exponentials to a stretch from its first sample on."""

    step: Second  # length of a block [s]; the means over blocks are fitted
    selection: Selection  # the poles, per block
    motion: RealArray  # (channel, block): motion explained by the modes among them
    growing: RealArray  # (channel, block): motion explained by growing poles
    residual: RealArray  # (channel, block): motion explained by neither
    noise_std: RealArray  # (channel,): standard deviation of the residual

    @property
    def modes(self) -> NDArray[np.intp]:
        """Indices of the fitted pairs that are modes."""
        pairs = len(self.selection.fit.poles.pairs)
        return np.array([i for i, v in enumerate(self.selection.reasons[:pairs]) if v is None], np.intp)

    @property
    def poles(self) -> int:
        """Number of pairs and real poles of the fit."""
        return len(self.selection.reasons)

    @property
    def parts(self) -> RealArray:
        """Mean square of the residual in each part over the median of the parts, (channel, part)."""
        size = max(FEWEST_EARLY, self.residual.shape[1] // TRIAL_PARTS)
        count = max(1, self.residual.shape[1] // size)
        power = np.mean(self.residual[:, : count * size].reshape(len(self.residual), count, size) ** 2, axis=2)
        least = np.maximum(np.median(power[:, 1:] if count > 1 else power, axis=1), 1e-12 * self.noise_std**2 + 1e-300)
        return np.asarray(power / least[:, None])

    @property
    def excess(self) -> float:
        """Residual power of the first part over the median of the parts, relative to the limit of chance [1]."""
        size = max(FEWEST_EARLY, self.residual.shape[1] // TRIAL_PARTS)
        early = np.sum(self.residual[:, :size] ** 2, axis=1)
        matters = early > EXACT_RESIDUAL**2 * np.sum(self.motion[:, :size] ** 2, axis=1)
        return float(np.max(self.parts[:, 0] * matters) / (1 + CERTAIN * np.sqrt(2 / size)))

    @property
    def early(self) -> float:
        """Residual over motion in the first part, root mean square, largest over the channels [1]."""
        size = max(FEWEST_EARLY, self.residual.shape[1] // TRIAL_PARTS)
        motion = np.sum(self.motion[:, :size] ** 2, axis=1)
        return float(np.sqrt(np.max(np.sum(self.residual[:, :size] ** 2, axis=1) / np.maximum(motion, 1e-300))))

    @property
    def left(self) -> RealArray:
        """Residual over motion in the first third, root mean square, or 0 where the residual is white, (channel,)."""
        return unexplained(self.motion, self.residual)

    @property
    def strengths(self) -> RealArray:
        """Energy of each mode over the variance of the noise, summed over channels [1], (mode,)."""
        fit, rows = self.selection.fit, self.modes
        power = np.sum(np.abs(2 * fit.amplitudes[rows]) ** 2 / self.noise_std**2, axis=1)
        return np.asarray(power / (4 * -fit.poles.pairs[rows].real))

    @property
    def rate_std(self) -> RealArray:
        """Relative standard deviation of the decay rate of each mode at the Cramér-Rao bound [1], (mode,).

        It is ``2 / sqrt(E)`` with E the strength of the mode, for many cycles in the time of decay.
        """
        return np.asarray(2 / np.sqrt(self.strengths))

    @property
    def cycles(self) -> RealArray:
        """Cycles of each mode until its amplitude over one cycle meets the noise, or the stretch ends [1], (mode,)."""
        fit, rows = self.selection.fit, self.modes
        theta = fit.poles.pairs[rows]
        power = np.sum(np.abs(2 * fit.amplitudes[rows]) ** 2 / self.noise_std**2, axis=1)
        per_cycle = 2 * np.pi / theta.imag
        seen = 0.5 * np.log(np.maximum(power * per_cycle / 2, 1.0)) / -theta.real
        return np.asarray(np.minimum(seen, self.residual.shape[1]) / per_cycle)


def unexplained(motion: RealArray, residual: RealArray) -> RealArray:
    """Return residual over motion (rms) in the first third, or 0 where the residual is white, (channel,)."""
    early = max(1, residual.shape[1] // 3)
    coloured = correlated(lag_one(residual), residual.shape[1], sigmas=CERTAIN)
    moved = np.sum(motion[:, :early] ** 2, axis=1)
    left = np.sum(residual[:, :early] ** 2, axis=1)
    share = np.divide(left, moved, out=np.full_like(left, np.inf), where=moved > 1e-200 * left)
    return np.where(coloured, np.sqrt(share), 0.0)


def block_size(step: Second, top: Hertz) -> int:
    """Return the number of samples per block where no band above a frequency rings."""
    return max(1, int(1 / (BLOCKS_A_CYCLE * top * step)))


def with_all_motion(values: RealArray, size: int) -> int:
    """Return a number of samples per block, at most a given one, whose means keep the motion of a stretch.

    Where one motion fills a recording, no band rings above the others, whatever its frequency.
    """
    while size > 1:
        count = min(values.shape[1] // size, MOST_BLOCKS)
        blocks = values[:, : count * size].reshape(len(values), count, size)
        means = blocks.mean(axis=2, keepdims=True)
        lost = np.sum((blocks - means) ** 2, axis=(1, 2))
        along = np.sum((blocks - means)[:, :, 1:] * (blocks - means)[:, :, :-1], axis=(1, 2))
        every = np.sum((blocks - means.mean(axis=1, keepdims=True)) ** 2, axis=(1, 2))
        if not np.any((lost > MOST_LOST * every) & (along > WITHIN_SMOOTH * lost)):
            break
        size //= 2
    return size


def blocks_of(length: int, size: int) -> int:
    """Return how many blocks of ``size`` samples of a stretch tell how quiet the recording is."""
    return max(min(length // size, MOST_BLOCKS), FEWEST_SAMPLES)


def quiet_variance(means: RealArray, *, size: int, blocks: int, finest: RealArray) -> RealArray:
    """Return a lower bound of the variance of the noise in the means over blocks of ``size`` samples, (channel,).

    The means are those of the recording, (channel, block), from `block_means`. The bound is `QUIET_SHARE` of a low
    quantile over stretches of the recording of a number of ``blocks``, beside a parabola: a fit takes drifts as one. It
    is at least the variance of the rounding and quantisation error, whose standard deviation is ``finest``.
    """
    stretches = means.shape[1] // blocks
    least = finest**2 / size
    if stretches < FEWEST_STRETCHES:
        return np.asarray(least)
    parts = means[:, : stretches * blocks].reshape(len(means), stretches, blocks)
    drifts = np.linalg.qr(np.vander(np.linspace(-1, 1, blocks), 3))[0]
    # Channel by channel: of a long record each copy counts. Levels far from zero would round the rest away.
    centred = (channel - channel.mean(axis=1, keepdims=True) for channel in parts)
    power = [np.sum(each**2, axis=1) - np.sum((each @ drifts) ** 2, axis=1) for each in centred]
    quiet = np.quantile(np.maximum(power, 0.0), QUIET_QUANTILE, axis=1) / (blocks - 3)
    return np.asarray(np.maximum(least, QUIET_SHARE * quiet))


def background_ratio(means: RealArray, trial: Trial, *, size: int, length: int) -> RealArray:
    """Return the background power of the recording at each mode over that of white noise like the fit's, (mode,).

    It is a low quantile of the power at the frequency of the mode (Hann window) in stretches as long as the decay, in
    the channel where the mode is strongest, and 1 in recordings too short for that, or where the free motion of the
    modes could be all of any stretch. The means over blocks of ``size`` samples are those of the recording.
    """
    blocks = trial.residual.shape[1]
    stretches = means.shape[1] // max(length // size, blocks)
    if stretches < FEWEST_STRETCHES:
        return np.ones(len(trial.modes))
    window = np.hanning(blocks)
    fit, rows = trial.selection.fit, trial.modes
    turns = np.exp(-1j * np.arange(blocks)[:, None] * fit.poles.pairs[rows].imag) * window[:, None]
    # What rings on from an earlier release is free motion, too, and no force: it falls as the decay does.
    courses = np.exp(fit.poles.pairs[rows][:, None] * np.arange(blocks))
    # The poles are those of this decay: of others they may be off by a little.
    courses = np.concatenate([courses, courses * np.linspace(0.0, 1.0, blocks)])
    # Nor does a sensor's drift excite anything.
    drift = np.linspace(-1.0, 1.0, blocks) ** np.arange(1 + DRIFT_ORDER)[:, None]
    free = np.linalg.qr(np.stack([*courses.real, *courses.imag, *drift], axis=1))[0]
    forced = turns - free @ (free.T @ turns)
    left = np.sum(np.abs(forced) ** 2, axis=0)
    told = left > LEAST_BESIDE_FREE * np.sum(np.abs(turns) ** 2, axis=0)
    ratio, strongest = np.ones(len(rows)), np.argmax(np.abs(fit.amplitudes[rows]).T / trial.noise_std[:, None], axis=0)
    for channel in np.unique(strongest[told]):
        seen = np.flatnonzero(told & (strongest == channel))
        # Real products: the samples are not copied as complex numbers.
        both = np.concatenate([forced.real[:, seen], forced.imag[:, seen]], axis=1)
        # Stretches overlap by half, so that some lie between two releases.
        laps = [means[channel, first:] for first in (0, blocks // 2)]
        parts = [_evenly(lap[: len(lap) // blocks * blocks].reshape(-1, blocks)) @ both for lap in laps]
        power = np.concatenate(parts) ** 2
        power = power[:, : len(seen)] + power[:, len(seen) :]
        # The power of noise is exponentially distributed.
        quiet = np.quantile(power, CALM, axis=0) / -np.log1p(-CALM)
        ratio[seen] = quiet / (trial.noise_std[channel] ** 2 * left[seen])
    return ratio


def _evenly(stretches: RealArray) -> RealArray:
    """Return some of many stretches, (stretch, block), evenly over the recording."""
    return stretches[:: -(-len(stretches) // MOST_CALM)]


def tried(
    values: RealArray,
    *,
    step: Second,
    size: int,
    least: RealArray,
    most: int = MOST_BLOCKS,
    sought: int = MOST_SOUGHT,
) -> Trial | None:
    """Return the fit to a stretch, or None if it is too short or a channel is constant.

    Means over blocks of ``size`` samples, the first ``most`` of them, keep the poles of exponentials and the whiteness
    of noise. Unlike a filter they do not mix in samples from before the stretch. ``least`` is from `quiet_variance`.
    At most ``sought`` pairs of poles are fitted.
    """
    count = min(values.shape[1] // size, most)
    if count < FEWEST_SAMPLES:
        return None
    means = values[:, : count * size].reshape(len(values), count, size).mean(axis=2)
    about = means - means.mean(axis=1, keepdims=True)
    if not np.all(np.any(np.abs(about) > 1e-12 * np.max(np.abs(means), axis=1, keepdims=True), axis=1)):
        return None
    noise = WhiteNoise(least=least).rounded(np.sum(about**2, axis=1), count)
    selection = select(about, noise=noise, most=sought, intervals=False)
    fit = selection.fit
    pairs = len(fit.poles.pairs)
    residual = about - synthesize(fit.poles.exponents, fit.amplitudes, count)

    def part(wanted: Reason | None) -> RealArray:
        rows = [i for i, reason in enumerate(selection.reasons) if reason is wanted]
        both = [*[i for i in rows if i < pairs], *[pairs + i for i in rows]]
        if not both:
            return np.zeros_like(about)
        return synthesize(fit.poles.exponents[both], fit.amplitudes[both], count)

    free = degrees_of_freedom(count, amplitudes=len(fit.poles), poles=fit.poles.free, channels=len(about))
    return Trial(
        step=step * size,
        selection=selection,
        motion=part(None),
        growing=part(Reason.GROWING),
        residual=residual,
        noise_std=np.sqrt(noise.variance(np.sum(residual**2, axis=1), free)),
    )
