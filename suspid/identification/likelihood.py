"""The joint maximum-likelihood fit of damped modes to all channels, by variable projection.

Every channel is a sum of the same damped exponentials, with amplitudes of its own, and white noise of
its own variance. The amplitudes are linear and eliminated exactly; the poles are found by Gauss-Newton
steps with the noise variances concentrated out. All inner products come from `suspid.identification.exponentials`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from suspid.identification.exponentials import Blocks, power_sums
from suspid.identification.noise import WhiteNoise, degrees_of_freedom
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_complex, frozen_real

# Iterations end when the step is worth less than this in squared standard deviations.
NEGLIGIBLE = 1e-5
MOST_STEPS = 60
# Poles decay at most this much per sample, and grow at most this much over the record.
FASTEST = 3.0
GROWTH = 3.0
# A pair swings by at least this share of its decay: a slower one is two real poles that cannot be told apart.
SLOWEST = 1e-2
# Exponentials of which one has less than this of its own beside the others cannot be told apart.
ALIKE = 1e-5
# Rounding of inner products, as a share of their size.
ROUNDING = 4e-15
# Eigenvalues of an information of unit diagonal below this are rounding.
INDEFINITE = 1e-10


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Poles:
    """Exponents per sample, ``pole * step``: of pairs (upper half plane), of real poles, of nuisances held fixed."""

    pairs: ComplexArray
    reals: RealArray
    nuisances: RealArray

    @property
    def exponents(self) -> ComplexArray:
        """All exponents: pairs, their conjugates, reals, nuisances."""
        return np.concatenate([self.pairs, self.pairs.conj(), self.reals, self.nuisances])

    @property
    def free(self) -> int:
        """Number of real parameters."""
        return 2 * len(self.pairs) + len(self.reals)

    def __len__(self) -> int:
        return 2 * len(self.pairs) + len(self.reals) + len(self.nuisances)

    def moved(self, step: RealArray) -> Poles:
        """Return the poles after a step in (Re, Im of each pair; each real)."""
        pairs, reals = len(self.pairs), len(self.reals)
        change = step[: 2 * pairs].reshape(pairs, 2)
        return Poles(
            pairs=self.pairs + change[:, 0] + 1j * change[:, 1],
            reals=self.reals + step[2 * pairs : 2 * pairs + reals],
            nuisances=self.nuisances,
        )

    def with_pair(self, theta: complex) -> Poles:
        """Return the poles with one more pair."""
        return Poles(pairs=np.append(self.pairs, theta), reals=self.reals, nuisances=self.nuisances)

    def with_real(self, theta: float) -> Poles:
        """Return the poles with one more real pole."""
        return Poles(pairs=self.pairs, reals=np.append(self.reals, theta), nuisances=self.nuisances)

    def without(self, index: int) -> Poles:
        """Return the poles without one, counted over pairs then reals."""
        pairs = len(self.pairs)
        if index < pairs:
            return Poles(pairs=np.delete(self.pairs, index), reals=self.reals, nuisances=self.nuisances)
        return Poles(pairs=self.pairs, reals=np.delete(self.reals, index - pairs), nuisances=self.nuisances)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DecayFit:
    """Poles with the amplitudes and variances that fit a record best.

    Parameters
    ----------
    poles : Poles
        The exponents.
    amplitudes : ndarray (exponent, channel)
        Complex amplitudes at the first sample; conjugate for conjugate exponents.
    squares : ndarray (channel,)
        Residual sum of squares.
    rounding : ndarray (channel,)
        Least that it can be known to be.
    information : ndarray (parameter, parameter)
        ``J^T J / variance`` of the poles' real parameters (Re and Im per sample), amplitudes projected out.
    gradient : ndarray (parameter,)
        Of the log likelihood.
    gram : ndarray (exponent, exponent)
        Inner products of the exponentials.
    tilt : ndarray (exponent, exponent)
        Inner products of the exponentials with their derivatives.
    sharpness : ndarray (exponent, exponent)
        Inner products of the derivatives, what the exponentials explain of them projected out.
    """

    poles: Poles
    amplitudes: ComplexArray
    squares: RealArray
    rounding: RealArray
    information: RealArray
    gradient: RealArray
    gram: ComplexArray
    tilt: ComplexArray
    sharpness: ComplexArray


def evaluate(blocks: Blocks, poles: Poles, noise: WhiteNoise) -> DecayFit | None:
    """Return the fit at given poles, or None where their exponentials cannot be told apart.

    Parameters
    ----------
    blocks : Blocks
        The record.
    poles : Poles
        The exponents.
    noise : WhiteNoise
        The noise model.
    """
    from scipy.linalg.lapack import zpotrf, ztrtri

    theta, count, pairs = poles.exponents, blocks.count, len(poles.pairs)
    gram, tilt, bend = power_sums(theta.conj()[:, None] + theta, count)
    # With exponentials of unit norm the Gram matrix says by its pivots whether they can be told apart.
    norm = 1 / np.sqrt(gram.diagonal().real)
    lower, failed = zpotrf(gram * (norm[:, None] * norm), lower=1, clean=1)
    if failed:
        return None
    pivot = float(lower.diagonal().real.min())
    if not pivot >= ALIKE:
        return None
    inverse = ztrtri(lower, lower=1)[0] * norm
    inverse = inverse.conj().T @ inverse
    # Of a real record the products with the conjugates are conjugate.
    half = blocks.project(theta[_distinct(pairs, len(theta))]).transpose(0, 2, 1)
    zeroth, first = np.concatenate([half[:, :pairs], half[:, :pairs].conj(), half[:, pairs:]], axis=1)
    amplitudes = inverse @ zeroth
    explained = np.einsum("ic,ic->c", zeroth.conj(), amplitudes).real
    # What is explained is known to the rounding that the inverse magnifies: nothing below it is a residual.
    rounding = ROUNDING / pivot**2 * blocks.energy
    squares = np.maximum(blocks.energy - explained, rounding)
    variance = noise.variance(squares, count)
    if not 0 < variance.min() < np.inf:
        return None
    sharpness = bend - tilt @ inverse @ tilt
    weighted = amplitudes.conj() / variance
    slope = (weighted * (first - tilt @ amplitudes)).sum(axis=1)
    chart = _chart(pairs, len(poles.reals), len(theta))
    return DecayFit(
        poles=poles,
        amplitudes=amplitudes,
        squares=squares,
        rounding=rounding,
        information=_information(sharpness, amplitudes, variance, chart, count),
        gradient=(chart.conj().T @ slope).real * count,
        gram=gram,
        tilt=tilt,
        sharpness=sharpness,
    )


def reweighed(fit: DecayFit, blocks: Blocks, noise: WhiteNoise, squares: RealArray) -> DecayFit:
    """Return a fit whose residual sums of squares are known better than by subtraction from the energy."""
    squares = np.maximum(squares, fit.rounding)
    variance = noise.variance(squares, blocks.count)
    chart = _chart(len(fit.poles.pairs), len(fit.poles.reals), len(fit.poles))
    information = _information(fit.sharpness, fit.amplitudes, variance, chart, blocks.count)
    return replace(fit, squares=squares, information=information)


def _information(
    sharpness: ComplexArray, amplitudes: ComplexArray, variance: RealArray, chart: ComplexArray, count: int
) -> RealArray:
    curvature = sharpness * ((amplitudes.conj() / variance) @ amplitudes.T)
    return np.asarray((chart.conj().T @ curvature @ chart).real * count**2)


@lru_cache(maxsize=256)
def _distinct(pairs: int, exponents: int) -> NDArray[np.intp]:
    """Return which exponents are no conjugates of others before them."""
    return np.concatenate([np.arange(pairs), np.arange(2 * pairs, exponents)])


def maximize(
    blocks: Blocks,
    start: Poles | DecayFit,
    noise: WhiteNoise,
    *,
    steps: int = MOST_STEPS,
    negligible: float = NEGLIGIBLE,
) -> DecayFit | None:
    """Return the fit of greatest likelihood near given poles, by damped Gauss-Newton steps.

    Parameters
    ----------
    blocks : Blocks
        The record.
    start : Poles or DecayFit
        Where to start; a fit was evaluated with the same blocks and noise.
    noise : WhiteNoise
        The noise model.
    steps : int
        Most steps.
    negligible : float
        Steps worth less than this, in squared standard deviations, end the search.
    """
    from scipy.linalg.lapack import dposv

    fit = start if isinstance(start, DecayFit) else evaluate(blocks, start, noise)
    if fit is None or not fit.poles.free:
        return fit
    damping = 1e-3
    rounding = 1e-13 * blocks.count
    for _ in range(steps):
        diagonal = fit.information.diagonal()
        if not (math.isfinite(fit.information.sum()) and diagonal.min() > 0):
            return fit
        scale = np.sqrt(np.maximum(diagonal, 1e-12 * diagonal.max()))
        unit = fit.information / (scale[:, None] * scale)
        for _ in range(12):
            _, step, failed = dposv(unit + damping * _unit_matrix(len(unit)), fit.gradient / scale)
            # An information without damping may be indefinite, by rounding.
            if failed:
                step = np.linalg.solve(unit + damping * _unit_matrix(len(unit)), fit.gradient / scale)
            step = step / scale
            worth = float(step @ fit.gradient)
            if worth < negligible:
                return fit
            trial = evaluate(blocks, _bounded(fit.poles, step, blocks.count), noise)
            if trial is not None:
                # Two fits below what rounding leaves of either are equally good.
                coarse = noise.at_least(np.maximum(fit.rounding, trial.rounding) / blocks.count)
                worse = coarse.loss(trial.squares, blocks.count) - coarse.loss(fit.squares, blocks.count)
                if worse <= rounding:
                    break
            damping = max(10 * damping, 1e-4)
        else:
            return fit
        fit = trial
        damping = damping / 10 if damping > 1e-9 else 0.0
    return fit


def _bounded(poles: Poles, step: RealArray, count: int) -> Poles:
    """Return the poles after a step cut to what the quadratic model can mean, and kept in range."""
    pairs, slack = len(poles.pairs), 1.5 / count
    reach = np.abs(np.concatenate([poles.pairs.real.repeat(2), poles.reals])) + slack
    share = float((np.abs(step) / reach).max())
    moved = poles.moved(step / max(1.0, share))
    highest = GROWTH / count
    kept = moved.pairs
    if pairs:
        re = np.minimum(np.maximum(kept.real, -FASTEST), highest)
        slowest = np.maximum(1e-3 / count, SLOWEST * np.abs(re))
        kept = re + 1j * np.minimum(np.maximum(np.abs(kept.imag), slowest), np.pi)
    reals = np.minimum(np.maximum(moved.reals, -FASTEST), highest) if len(moved.reals) else moved.reals
    return Poles(pairs=kept, reals=reals, nuisances=poles.nuisances)


@lru_cache(maxsize=64)
def _unit_matrix(size: int) -> RealArray:
    return frozen_real(np.eye(size))


@lru_cache(maxsize=256)
def _chart(pairs: int, reals: int, exponents: int) -> ComplexArray:
    """Return d(exponent) / d(real parameter), (exponent, parameter)."""
    chart = np.zeros((exponents, 2 * pairs + reals), complex)
    i = np.arange(pairs)
    chart[i, 2 * i], chart[i, 2 * i + 1] = 1, 1j
    chart[pairs + i, 2 * i], chart[pairs + i, 2 * i + 1] = 1, -1j
    j = np.arange(reals)
    chart[2 * pairs + j, 2 * pairs + j] = 1
    return frozen_complex(chart)


def joint_covariance(
    fit: DecayFit, pairs: NDArray[np.intp], reals: NDArray[np.intp], count: int, inflation: RealArray
) -> tuple[ComplexArray, RealArray]:
    """Return the shapes of some poles and the joint covariance of those poles and shapes.

    The amplitudes at fixed poles and the poles themselves err independently; an error of the poles
    drags the amplitudes along. Both parts are mapped to first order to the shapes, which are the
    amplitudes over the one of the strongest channel.

    Parameters
    ----------
    fit : DecayFit
        The fit.
    pairs, reals : ndarray of int
        Which of its pairs and of its real poles are wanted.
    count : int
        Number of samples.
    inflation : ndarray (pole,)
        Factor by which the variance of each wanted pole is widened.

    Returns
    -------
    shapes : ndarray (channel, pole)
        The largest component of each is 1.
    covariance : ndarray
        In the order of `ModalSet.covariance`, poles per sample.
    """
    poles, channels = fit.poles, len(fit.squares)
    free = degrees_of_freedom(count, amplitudes=len(poles), poles=poles.free, channels=channels)
    variance = fit.squares / free
    # The information was weighed by the variances over all samples.
    of_poles = pole_covariance(fit) * (count / free)
    inverse = np.linalg.inv(fit.gram)
    rows = np.concatenate([pairs, 2 * len(poles.pairs) + reals]).astype(int)
    twins = np.concatenate([pairs + len(poles.pairs), 2 * len(poles.pairs) + reals]).astype(int)
    columns = [[2 * i, 2 * i + 1] for i in pairs] + [[2 * len(poles.pairs) + i, -1] for i in reals]
    wanted = len(rows)
    # Real and imaginary parts of the wanted amplitudes, from those of all exponents.
    parts = np.zeros((2 * wanted, len(poles)), complex)
    for k, (row, twin) in enumerate(zip(rows, twins, strict=True)):
        parts[2 * k, row] += 0.5
        parts[2 * k, twin] += 0.5
        parts[2 * k + 1, row] -= 0.5j
        parts[2 * k + 1, twin] += 0.5j
    by_noise = (parts @ inverse @ parts.conj().T).real
    turned, chart = -parts @ inverse @ fit.tilt, _chart(len(poles.pairs), len(poles.reals), len(poles))
    dragged = [((turned * amplitude) @ chart).real for amplitude in fit.amplitudes.T]
    strongest = np.argmax(np.abs(fit.amplitudes[rows]), axis=1)
    shapes = np.empty((channels, wanted), complex)
    pole_map = np.zeros((2 * wanted, poles.free))
    size = 2 * wanted * (1 + channels)
    by_pole = np.zeros((size, poles.free))
    by_channel = [np.zeros((size, 2 * wanted)) for _ in range(channels)]
    for k, row in enumerate(rows):
        for part, column in enumerate(columns[k]):
            if column >= 0:
                pole_map[2 * k + part, column] = 1
        reference = fit.amplitudes[row, strongest[k]]
        for c in range(channels):
            if c == strongest[k]:
                # One by definition: no rounding of a difference may stand for its variance.
                shapes[c, k] = 1.0
                continue
            shapes[c, k] = fit.amplitudes[row, c] / reference
            at = 2 * wanted + 2 * (k * channels + c)
            direct, across = _rotation(1 / reference), _rotation(-shapes[c, k] / reference)
            own = slice(2 * k, 2 * k + 2)
            by_channel[c][at : at + 2, own] += direct
            by_channel[strongest[k]][at : at + 2, own] += across
            by_pole[at : at + 2] = direct @ dragged[c][own] * count + across @ dragged[strongest[k]][own] * count
    by_pole[: 2 * wanted] = pole_map
    covariance = by_pole @ of_poles @ by_pole.T
    for matrix, noise in zip(by_channel, variance, strict=True):
        covariance += matrix @ (noise * by_noise) @ matrix.T
    widen = np.sqrt(np.concatenate([np.repeat(inflation, 2), np.repeat(inflation, 2 * channels)]))
    return shapes, covariance * np.outer(widen, widen)


def pole_covariance(fit: DecayFit) -> RealArray:
    """Return the inverse of the information of the poles, (parameter, parameter), never indefinite.

    Where poles can hardly be told apart, rounding leaves negative eigenvalues; they stand for the
    least information that can be told from none.
    """
    diagonal = np.abs(fit.information.diagonal())
    scale = 1 / np.sqrt(np.maximum(diagonal, 1e-300 + 1e-30 * np.max(diagonal, initial=0.0)))
    values, vectors = np.linalg.eigh(fit.information * np.outer(scale, scale))
    half = scale[:, None] * vectors / np.sqrt(np.maximum(values, INDEFINITE))
    return np.asarray(half @ half.T)


def _rotation(factor: complex) -> RealArray:
    """Return multiplication by a complex number as a real matrix."""
    return np.array([[factor.real, -factor.imag], [factor.imag, factor.real]])
