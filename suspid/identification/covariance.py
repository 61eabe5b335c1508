"""Joint covariance of poles and mode shapes, from one decay or several."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from suspid.identification.information import inverse_information
from suspid.identification.likelihood import DecayFit
from suspid.identification.poles import Poles
from suspid.model import ModalSet
from suspid.units import ComplexArray, RealArray, Second

# Least eigenvalue of a covariance matrix of unit diagonal, of the amplitudes of several decays.
LEAST_VARIANCE = 1e-13
# Damped over undamped frequency down to which a pole and another are told by natural frequency and damping ratio.
LEAST_TURN = 0.3


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class JointEstimate:
    """Poles per sample and shapes with their joint covariance."""

    exponents: ComplexArray  # (mode,): exponents per sample
    shapes: ComplexArray  # (channel, mode): amplitudes over the amplitude of the strongest channel
    covariance: RealArray  # in the order of `ModalSet.covariance`, poles per sample

    def modes(self, *, step: Second, channels: tuple[str, ...]) -> ModalSet:
        """Return the modes in SI units."""
        if not len(self.exponents):
            return ModalSet(poles=self.exponents, shapes=self.shapes, channels=channels)
        scale = np.ones(len(self.covariance))
        scale[: 2 * len(self.exponents)] = 1 / step
        return ModalSet(
            poles=self.exponents / step,
            shapes=self.shapes,
            channels=channels,
            covariance=self.covariance * np.outer(scale, scale),
        )


def joint_covariance(fits: Sequence[DecayFit], kept: NDArray[np.intp], inflation: RealArray) -> JointEstimate:
    """Return the shapes of some poles and the joint covariance of those poles and shapes.

    The amplitudes at fixed poles and the poles themselves have independent errors. An error of the poles also
    changes the amplitudes, with derivatives D. The amplitudes of decay r in channel c are ``a_rc = q_r phi_c``, with
    the scale q of the decay and the shape phi, which is 1 in the strongest channel. With P the covariance of the
    poles, N that of the amplitudes at fixed poles, and L the derivatives of the shapes by the amplitudes, the
    covariance of (poles, shapes) is ``[I; L D] P [I; L D]^T + [0; L] N [0; L]^T``. For one decay the shapes are
    ratios of amplitudes; for several, generalised least squares with the covariance ``N + D P D^T``.

    The fits have common poles. ``kept`` are the wanted among the free poles (pairs, then reals); the variance of each
    is widened by ``inflation``, (mode,).
    """
    poles, channels, size = fits[0].poles, len(fits[0].squares), 2 * len(kept)
    if not len(kept):
        nothing = np.zeros((channels, 0), complex)
        return JointEstimate(exponents=nothing[0], shapes=nothing, covariance=np.zeros((0, 0)))
    # The fits weigh with the variance over all samples, not over the degrees of freedom.
    of_poles = inverse_information(np.sum([fit.information * (fit.freedom / fit.count) for fit in fits], axis=0))
    noise = np.zeros((len(fits) * channels * size,) * 2)
    dragged = np.zeros((len(noise), poles.free))
    for r, fit in enumerate(fits):
        at = slice(r * channels * size, (r + 1) * channels * size)
        noise[at, at], dragged[at] = amplitude_errors(fit, kept)
    amplitudes = np.stack([fit.amplitudes[fit.poles.rows[kept]].T for fit in fits])
    if len(fits) == 1:
        shapes, estimator = ratios(amplitudes[0], _strongest(amplitudes[0]))
    else:
        shapes, estimator = _common_shapes(amplitudes, noise + dragged @ of_poles @ dragged.T)
    covariance = _carried(
        _chosen(poles, kept), of_poles, estimator @ dragged, estimator @ noise @ estimator.T, inflation
    )
    return JointEstimate(exponents=poles.every[kept].astype(complex), shapes=shapes, covariance=covariance)


def estimate_of(
    exponents: ComplexArray,
    amplitudes: ComplexArray,
    *,
    chosen: RealArray,
    of_parameters: RealArray,
    dragged: RealArray,
    noise: RealArray,
    inflation: RealArray,
) -> JointEstimate:
    """Return poles and shapes of one decay with their joint covariance, for any model of its parameters.

    Parameters
    ----------
    exponents : ndarray (mode,)
        Poles per sample.
    amplitudes : ndarray (channel, mode)
        Complex amplitudes.
    chosen : ndarray (2 mode, parameter)
        Derivatives of Re and Im of the poles by the parameters.
    of_parameters : ndarray (parameter, parameter)
        Covariance of the parameters.
    dragged : ndarray (2 channel mode, parameter)
        Derivatives of Re and Im of the amplitudes, mode by mode within a channel, by the parameters.
    noise : ndarray (2 channel mode, 2 channel mode)
        Covariance of the amplitudes at given parameters.
    inflation : ndarray (mode,)
        Factor by which the variances of each mode are widened.
    """
    shapes, estimator = ratios(amplitudes, _strongest(amplitudes))
    covariance = _carried(chosen, of_parameters, estimator @ dragged, estimator @ noise @ estimator.T, inflation)
    return JointEstimate(exponents=exponents, shapes=shapes, covariance=covariance)


def _carried(
    chosen: RealArray, of_parameters: RealArray, dragged: RealArray, noise: RealArray, inflation: RealArray
) -> RealArray:
    """Return the covariance of poles and shapes: what the parameters carry into both, and the noise of the shapes."""
    by_parameter = np.vstack([chosen, dragged])
    covariance = by_parameter @ of_parameters @ by_parameter.T
    covariance[len(chosen) :, len(chosen) :] += noise
    widen = np.sqrt(np.concatenate([np.repeat(inflation, 2), np.repeat(inflation, len(dragged) // len(inflation))]))
    return np.asarray(covariance * np.outer(widen, widen))


def amplitude_errors(fit: DecayFit, kept: NDArray[np.intp]) -> tuple[RealArray, RealArray]:
    """Return the covariance N of amplitudes at fixed poles, and their derivatives D by the poles.

    Amplitudes are Re and Im of each wanted pole, channel by channel.
    """
    channels, size = len(fit.squares), 2 * len(kept)
    parts, inverse = _parts(fit.poles, kept), fit.inverse_gram
    own, turned = (parts @ inverse @ parts.conj().T).real, -parts @ inverse @ fit.tilt * fit.count
    each = np.arange(channels)
    noise = np.zeros((channels, size, channels, size))
    noise[each, :, each] = (fit.squares / fit.freedom)[:, None, None] * own
    dragged = ((turned * fit.amplitudes.T[:, None]) @ fit.poles.chart).real
    return noise.reshape(channels * size, -1), dragged.reshape(channels * size, -1)


def widened(fit: DecayFit, larger: DecayFit, places: NDArray[np.intp]) -> RealArray:
    """Return how many times the variances of each pair hold what a fit with more poles says of it, (pair,).

    With P the covariance of a pair, Q that of its place among the pairs of the larger fit, and d the distance between
    the two estimates, it is the least factor f with ``f P >= Q + d d^T``.
    """
    of_poles, of_more = fit.of_poles, larger.of_poles
    factors = np.zeros(len(places))
    for k, place in enumerate(places.tolist()):
        own, more = slice(2 * k, 2 * k + 2), slice(2 * place, 2 * place + 2)
        away = larger.poles.pairs[place] - fit.poles.pairs[k]
        d = np.array([away.real, away.imag])
        both = of_more[more, more] + np.outer(d, d)
        factors[k] = np.max(np.linalg.eigvals(np.linalg.solve(of_poles[own, own], both)).real)
    return factors


def with_changes(modes: ModalSet, changes: Iterable[ComplexArray]) -> ModalSet:
    """Return modes with changes of their poles, each (mode,), in the covariance: what other choices make of them.

    Natural frequency and damping ratio get the changes of both: damping that changes by much leaves the frequency what
    it is, though the poles lie on a circle and not on its tangent.
    """
    assert modes.covariance is not None
    covariance = modes.covariance.copy()
    for change in changes:
        along = _along(modes.poles, modes.poles + change)
        for mode, parts in enumerate(np.stack([along.real, along.imag], axis=1)):
            at = slice(2 * mode, 2 * mode + 2)
            covariance[at, at] += np.outer(parts, parts)
    return replace(modes, covariance=covariance)


def _along(poles: ComplexArray, others: ComplexArray) -> ComplexArray:
    """Return changes of poles to others that have the same effect on wn and zeta to first order, (mode,).

    Where one of both hardly turns they are the differences.
    """
    turns = np.minimum(poles.imag / np.abs(poles), others.imag / np.abs(others)) > LEAST_TURN
    zeta = np.where(turns, -poles.real / np.abs(poles), 0.0)
    further = np.where(turns, -others.real / np.abs(others), 0.0) - zeta
    by_zeta = -np.abs(poles) * (1 + 1j * zeta / np.sqrt(1 - zeta**2))
    both = poles * (np.abs(others) / np.abs(poles) - 1) + by_zeta * further
    return np.asarray(np.where(turns, both, others - poles))


def _parts(poles: Poles, kept: NDArray[np.intp]) -> ComplexArray:
    """Return the map from all amplitudes to real and imaginary parts of the wanted, (2 wanted, exponent)."""
    rows, pairs = poles.rows[kept], len(poles.pairs)
    twins = np.where(kept < pairs, rows + pairs, rows)
    parts = np.zeros((2 * len(kept), len(poles)), complex)
    for k, (row, twin) in enumerate(zip(rows, twins, strict=True)):
        parts[2 * k, row] += 0.5
        parts[2 * k, twin] += 0.5
        parts[2 * k + 1, row] -= 0.5j
        parts[2 * k + 1, twin] += 0.5j
    return parts


def _chosen(poles: Poles, kept: NDArray[np.intp]) -> RealArray:
    """Return the map from the real parameters of all poles to Re and Im of the wanted, (2 wanted, parameter)."""
    chart = poles.chart[poles.rows[kept]]
    return np.stack([chart.real, chart.imag], axis=1).reshape(2 * len(kept), -1)


def ratios(amplitudes: ComplexArray, units: NDArray[np.intp]) -> tuple[ComplexArray, RealArray]:
    """Return shapes (channel, mode), each 1 in the channel of its unit, and their derivatives by the amplitudes.

    Examples
    --------
    >>> shapes, slopes = ratios(np.array([[2.0], [1j]]), np.array([0]))
    >>> shapes[:, 0].tolist(), (slopes[2:, 2:] * 2).tolist()
    ([(1+0j), 0.5j], [[1.0, -0.0], [0.0, 1.0]])
    """
    channels, wanted = amplitudes.shape
    shapes = np.ones((channels, wanted), complex)
    estimator = np.zeros((2 * wanted * channels, 2 * wanted * channels))
    for k, unit in enumerate(units):
        reference = amplitudes[unit, k]
        for c in range(channels):
            # The channel of the unit is 1 by definition: no rounding of a difference becomes its variance.
            if c != unit:
                shapes[c, k] = amplitudes[c, k] / reference
                at, own, other = (2 * i for i in (k * channels + c, c * wanted + k, unit * wanted + k))
                estimator[at : at + 2, own : own + 2] = _rotation(1 / reference)
                estimator[at : at + 2, other : other + 2] = _rotation(-shapes[c, k] / reference)
    return shapes, estimator


def _strongest(amplitudes: ComplexArray) -> NDArray[np.intp]:
    """Return the strongest channel of each mode, (mode,)."""
    return np.asarray(np.argmax(np.abs(amplitudes), axis=0))


def _common_shapes(amplitudes: ComplexArray, covariance: RealArray) -> tuple[ComplexArray, RealArray]:
    """Return the shapes (channel, mode) that decays share, and their derivatives by the amplitudes (decay, …)."""
    decays, channels, wanted = amplitudes.shape
    data = np.stack([amplitudes.real, amplitudes.imag], axis=-1).ravel()
    whiten = _whitening(covariance)
    strongest = np.argmax(np.sum(np.abs(amplitudes) ** 2, axis=0), axis=0)
    # Start from the scale that the strongest channel of each decay shows, and least squares of the rest on it.
    q = np.stack([amplitudes[:, strongest[k], k] for k in range(wanted)], axis=1)
    phi = np.einsum("rk,rck->ck", q.conj(), amplitudes) / np.sum(np.abs(q) ** 2, axis=0)
    scales = 2 * decays * wanted
    # Gauss-Newton converges quadratically from there: 8 steps reach rounding. Decays that share no mode may lead away.
    left = data - _products(q, phi)
    cost = np.linalg.norm(whiten @ left)
    for _ in range(8):
        slopes = _slopes(q, phi, strongest)
        white = whiten @ slopes
        used = np.flatnonzero(np.any(white != 0, axis=0))
        white = white[:, used]
        unit = 1 / np.linalg.norm(white, axis=0)
        solve = np.zeros((slopes.shape[1], data.size))
        solve[used] = unit[:, None] * np.linalg.pinv(white * unit) @ whiten
        change = solve @ left
        trial_q = q + change[:scales].view(complex).reshape(decays, wanted)
        trial_phi = phi + change[scales:].view(complex).reshape(wanted, channels).T
        trial_left = data - _products(trial_q, trial_phi)
        trial_cost = np.linalg.norm(whiten @ trial_left)
        if not trial_cost <= cost:
            break
        q, phi, left, cost = trial_q, trial_phi, trial_left, trial_cost
    return phi, solve[scales:]


def _products(q: ComplexArray, phi: ComplexArray) -> RealArray:
    """Return the amplitudes of scales q (decay, mode) and shapes phi (channel, mode), real and imaginary parts."""
    model = q[:, None, :] * phi
    return np.stack([model.real, model.imag], axis=-1).ravel()


def _slopes(q: ComplexArray, phi: ComplexArray, strongest: NDArray[np.intp]) -> RealArray:
    """Return the derivatives of ``q_r phi_c`` by the scales q (decay, mode) and the free shapes phi (channel, mode)."""
    (decays, wanted), channels = q.shape, len(phi)
    scales = 2 * decays * wanted
    slopes = np.zeros((scales * channels, scales + 2 * channels * wanted))
    for r, c, k in np.ndindex(decays, channels, wanted):
        at = 2 * ((r * channels + c) * wanted + k)
        of_q, of_phi = 2 * (r * wanted + k), scales + 2 * (k * channels + c)
        slopes[at : at + 2, of_q : of_q + 2] = _rotation(complex(phi[c, k]))
        if c != strongest[k]:
            slopes[at : at + 2, of_phi : of_phi + 2] = _rotation(complex(q[r, k]))
    return slopes


def _whitening(covariance: RealArray) -> RealArray:
    """Return W with ``W^T W`` the inverse of a covariance, eigenvalues raised to `LEAST_VARIANCE` of the largest.

    What has no variance, as the imaginary part of the amplitude of a real pole, is left out.
    """
    variances = covariance.diagonal()
    scale = np.where(variances > 0, 1 / np.sqrt(np.where(variances > 0, variances, 1.0)), 0.0)
    values, vectors = np.linalg.eigh(covariance * np.outer(scale, scale))
    return np.asarray((vectors * scale[:, None] / np.sqrt(np.maximum(values, LEAST_VARIANCE * values[-1]))).T)


def _rotation(factor: complex) -> RealArray:
    """Return multiplication by a complex number as a real matrix."""
    return np.array([[factor.real, -factor.imag], [factor.imag, factor.real]])
