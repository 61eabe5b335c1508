"""Is a stretch a free decay from its first sample on? A fit that answers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.identification import Selection, WhiteNoise, correlated, degrees_of_freedom, lag_one, select, synthesize
from suspid.units import Hertz, RealArray, Second
from suspid.words import Reason

# Samples are averaged in blocks to about so many per cycle of the highest band that rings; a trial sees so many blocks.
PER_CYCLE = 8.0
MOST_BLOCKS = 600
FEWEST_BLOCKS = 32
# The residual of the first 24th of a stretch is compared with the rest; at least so many blocks.
PARTS, FEWEST_EARLY = 24, 6
# It may exceed the rest by so many standard deviations of chance.
SURE = 5.0
# A residual below this share of the motion is as good as none.
NEGLIGIBLE = 1e-4
# The noise is at least this share of what the channel does in its quiet stretches: no fit needs to follow the rest.
QUIET_SHARE, QUIET_QUANTILE, FEWEST_STRETCHES = 0.5, 0.25, 4
# Probability with which a white residual is called coloured by its correlation over one block (5 standard deviations).
# Trials are many: a stretch is tried from many starts.
COLOUR_LEVEL = 5.733e-7
# The background is what this share of the stretches of a recording stay below.
CALM = 0.2


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trial:
    """The fit of damped exponentials to a stretch from its first sample on.

    Parameters
    ----------
    step : float
        Length of a block, whose means were fitted [s].
    selection : Selection
        The poles, per block.
    motion : ndarray (channel, block)
        What the modes among them explain.
    growing : ndarray (channel, block)
        What poles explain that grow.
    residual : ndarray (channel, block)
        What nothing explains.
    noise_std : ndarray (channel,)
        Its standard deviation.
    """

    step: Second
    selection: Selection
    motion: RealArray
    growing: RealArray
    residual: RealArray
    noise_std: RealArray

    @property
    def modes(self) -> NDArray[np.intp]:
        """Which of the fitted pairs are modes."""
        pairs = len(self.selection.fit.poles.pairs)
        return np.array([i for i, v in enumerate(self.selection.reasons[:pairs]) if v is None], np.intp)

    @property
    def poles(self) -> int:
        """How many pairs and real poles the fit needs."""
        return len(self.selection.reasons)

    @property
    def parts(self) -> RealArray:
        """Mean square of the residual over that of the middling part, by channel and part, (channel, part)."""
        size = max(FEWEST_EARLY, self.residual.shape[1] // PARTS)
        count = max(1, self.residual.shape[1] // size)
        power = np.mean(self.residual[:, : count * size].reshape(len(self.residual), count, size) ** 2, axis=2)
        least = np.maximum(np.median(power[:, 1:] if count > 1 else power, axis=1), 1e-12 * self.noise_std**2 + 1e-300)
        return np.asarray(power / least[:, None])

    @property
    def excess(self) -> float:
        """How far the residual of the first part exceeds the others', over what chance allows [1]: 1 is the limit."""
        size = max(FEWEST_EARLY, self.residual.shape[1] // PARTS)
        early = np.sum(self.residual[:, :size] ** 2, axis=1)
        matters = early > NEGLIGIBLE**2 * np.sum(self.motion[:, :size] ** 2, axis=1)
        return float(np.max(self.parts[:, 0] * matters) / (1 + SURE * np.sqrt(2 / size)))

    @property
    def early(self) -> float:
        """Residual over motion in the first part, root mean square, of the channel where it is largest [1]."""
        size = max(FEWEST_EARLY, self.residual.shape[1] // PARTS)
        motion = np.sum(self.motion[:, :size] ** 2, axis=1)
        return float(np.sqrt(np.max(np.sum(self.residual[:, :size] ** 2, axis=1) / np.maximum(motion, 1e-300))))

    @property
    def left(self) -> RealArray:
        """Residual over motion, root mean square in the first third, where the residual is not white; else 0."""
        early = max(1, self.residual.shape[1] // 3)
        coloured = correlated(lag_one(self.residual), self.residual.shape[1], level=COLOUR_LEVEL)
        motion = np.sum(self.motion[:, :early] ** 2, axis=1)
        share = np.sqrt(np.sum(self.residual[:, :early] ** 2, axis=1) / np.maximum(motion, 1e-300))
        return np.where(coloured, share, 0.0)

    @property
    def strengths(self) -> RealArray:
        """Energy of each mode over the variance of the noise, summed over channels [1], (mode,)."""
        fit, rows = self.selection.fit, self.modes
        power = np.sum(np.abs(2 * fit.amplitudes[rows]) ** 2 / self.noise_std**2, axis=1)
        return np.asarray(power / (4 * -fit.poles.pairs[rows].real))

    @property
    def cycles(self) -> RealArray:
        """Cycles of each mode until one no longer stands out of the noise, or the stretch ends [1], (mode,)."""
        fit, rows = self.selection.fit, self.modes
        theta = fit.poles.pairs[rows]
        power = np.sum(np.abs(2 * fit.amplitudes[rows]) ** 2 / self.noise_std**2, axis=1)
        per_cycle = 2 * np.pi / theta.imag
        seen = 0.5 * np.log(np.maximum(power * per_cycle / 2, 1.0)) / -theta.real
        return np.asarray(np.minimum(seen, self.residual.shape[1]) / per_cycle)


def block_size(step: Second, top: Hertz) -> int:
    """Return how many samples may be averaged where nothing above a band rings."""
    return max(1, int(1 / (PER_CYCLE * top * step)))


def quiet_variance(values: RealArray, *, size: int, length: int, finest: RealArray) -> RealArray:
    """Return the least variance that the means over blocks of a stretch can have as noise, (channel,).

    Parameters
    ----------
    values : ndarray (channel, sample)
        The recording.
    size : int
        Samples per block.
    length : int
        Samples of the stretch.
    finest : ndarray (channel,)
        Standard deviation of rounding and quantisation.
    """
    blocks = max(length // size, FEWEST_BLOCKS)
    stretches = values.shape[1] // (blocks * size)
    least = finest**2 / size
    if stretches < FEWEST_STRETCHES:
        return np.asarray(least)
    means = values[:, : stretches * blocks * size].reshape(len(values), stretches, blocks, size).mean(axis=3)
    quiet = np.quantile(np.var(means, axis=2), QUIET_QUANTILE, axis=1)
    return np.asarray(np.maximum(least, QUIET_SHARE * quiet))


def background_loudness(values: RealArray, trial: Trial, *, size: int, length: int) -> RealArray:
    """Return how loud the recording's background is at each mode, over white noise like the fit's, (mode,).

    The power at the frequency of the mode (Hann window) in stretches as long as the decay, a low quantile over the
    recording, in the channel where the mode is strongest; 1 where it cannot be told.
    """
    blocks = trial.residual.shape[1]
    stretches = values.shape[1] // (max(length // size, blocks) * size)
    if stretches < FEWEST_STRETCHES:
        return np.ones(len(trial.modes))
    means = values[:, : stretches * blocks * size].reshape(len(values), stretches, blocks, size).mean(axis=3)
    window = np.hanning(blocks)
    fit, rows = trial.selection.fit, trial.modes
    turns = np.exp(-1j * np.arange(blocks)[:, None] * fit.poles.pairs[rows].imag) * window[:, None]
    # Without the part of the window that a constant would leak.
    power = np.abs((means - means.mean(axis=2, keepdims=True)) @ turns) ** 2
    white = trial.noise_std[:, None] ** 2 * float(window @ window)
    # The quiet part of it: where decays fill half of a recording, the median is theirs. Power of noise is exponential.
    loud = np.quantile(power, CALM, axis=1) / -np.log1p(-CALM) / white
    strongest = np.argmax(np.abs(fit.amplitudes[rows]).T / trial.noise_std[:, None], axis=0)
    return np.asarray(loud[strongest, np.arange(len(rows))])


def tried(values: RealArray, *, step: Second, size: int, least: RealArray, most: int = MOST_BLOCKS) -> Trial | None:
    """Return the fit to a stretch, or None if it is too short or does not move.

    Means over blocks keep the poles of exponentials and the whiteness of noise, and look at no sample before the
    first: no filter smears what came before into the stretch.

    Parameters
    ----------
    values : ndarray (channel, sample)
        The stretch.
    step : float
        Sampling step [s].
    size : int
        Samples per block.
    least : ndarray (channel,)
        Least variance of the noise of a block, see `quiet_variance`.
    most : int
        How many blocks to use; the first ones.
    """
    count = min(values.shape[1] // size, most)
    if count < FEWEST_BLOCKS:
        return None
    means = values[:, : count * size].reshape(len(values), count, size).mean(axis=2)
    about = means - means.mean(axis=1, keepdims=True)
    if not np.all(np.any(np.abs(about) > 1e-12 * np.max(np.abs(means), axis=1, keepdims=True), axis=1)):
        return None
    noise = WhiteNoise(least=least).rounded(np.sum(about**2, axis=1), count)
    selection = select(about, noise=noise)
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
