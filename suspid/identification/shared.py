"""One shape per mode from several decays, and the joint covariance of poles and shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.identification.exponentials import Blocks
from suspid.identification.likelihood import DecayFit
from suspid.units import ComplexArray, RealArray

# Scales of the decays and shape of the mode are fitted to the amplitudes in so many Gauss-Newton steps.
STEPS = 8


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Shared:
    """Poles per sample with the shapes that several decays share.

    Parameters
    ----------
    exponents : ndarray (mode,)
        Exponents per sample.
    shapes : ndarray (channel, mode)
        Shapes; the strongest channel of each is 1.
    covariance : ndarray
        In the order of `ModalSet.covariance`, poles per sample.
    """

    exponents: ComplexArray
    shapes: ComplexArray
    covariance: RealArray


def shared_covariance(
    fits: list[DecayFit], blocks: list[Blocks], pairs: NDArray[np.intp], reals: NDArray[np.intp], inflation: RealArray
) -> Shared:
    """Return shared shapes of some poles and the joint covariance of those poles and shapes.

    The amplitudes of decay r in channel c are ``a_rc = q_r phi_c``, with the scale q of the decay and the shape phi,
    which is 1 in the strongest channel. The estimates of the amplitudes of all modes err by the noise, independently
    in every decay and channel, and are dragged along by the errors of the poles, which are common to all. With S
    that covariance, ``(q, phi)`` follows by generalised least squares, ``L = (J^T S^-1 J)^-1 J^T S^-1``; the shapes
    then have the covariance ``L S L^T``, and with the poles ``P D^T L^T`` (D the amplitudes' derivatives by the poles).

    Parameters
    ----------
    fits : list of DecayFit
        The decays, fitted with common poles.
    blocks : list of Blocks
        Their records.
    pairs, reals : ndarray of int
        Which of the pairs and of the real poles are wanted.
    inflation : ndarray (pole,)
        Factor by which the variance of each wanted pole is widened.
    """
    poles = fits[0].poles
    count, wanted, channels = len(poles.pairs), len(pairs) + len(reals), blocks[0].channels
    rows = np.concatenate([pairs, 2 * count + reals]).astype(int)
    twins = np.concatenate([pairs + count, 2 * count + reals]).astype(int)
    free = [b.count - len(f.poles) - f.poles.free / channels for f, b in zip(fits, blocks, strict=True)]
    corrected = [max(n, 1.0) / b.count for n, b in zip(free, blocks, strict=True)]
    of_poles = _inverse(np.sum([f.information * k for f, k in zip(fits, corrected, strict=True)], axis=0))
    # Real and imaginary parts of the wanted amplitudes, decay by decay and channel by channel.
    size = 2 * wanted
    noise = np.zeros((len(fits) * channels * size,) * 2)
    dragged = np.zeros((len(noise), poles.free))
    amplitudes = np.zeros((len(fits), channels, wanted), complex)
    for r, (fit, block, known) in enumerate(zip(fits, blocks, corrected, strict=True)):
        inverse = np.linalg.inv(fit.gram)
        parts = np.zeros((size, len(fit.poles)), complex)
        for k, (row, twin) in enumerate(zip(rows, twins, strict=True)):
            parts[2 * k, row] += 0.5
            parts[2 * k, twin] += 0.5
            parts[2 * k + 1, row] -= 0.5j
            parts[2 * k + 1, twin] += 0.5j
        chart = _exponents_by_parameters(len(poles.pairs), len(poles.reals), len(fit.poles))
        own = (parts @ inverse @ parts.conj().T).real
        for c in range(channels):
            at = slice((r * channels + c) * size, (r * channels + c + 1) * size)
            noise[at, at] = own * float(fit.squares[c]) / (block.count * known)
            by_exponents = -inverse @ fit.tilt @ (fit.amplitudes[:, c, None] * chart)
            dragged[at] = (parts @ by_exponents).real * block.count
            amplitudes[r, c] = fit.amplitudes[rows, c]
    covariance = noise + dragged @ of_poles @ dragged.T
    shapes, estimator = _one_shape(amplitudes, covariance)
    # An own real pole has no imaginary part: its row of the map stays empty.
    chosen = np.zeros((size, poles.free))
    for k, i in enumerate(pairs):
        chosen[2 * k, 2 * i] = chosen[2 * k + 1, 2 * i + 1] = 1
    for k, i in enumerate(reals, start=len(pairs)):
        chosen[2 * k, 2 * count + i] = 1
    across = chosen @ of_poles @ dragged.T @ estimator.T
    joint = np.block(
        [[chosen @ of_poles @ chosen.T, across], [across.T, estimator @ covariance @ estimator.T]],
    )
    widen = np.sqrt(np.concatenate([np.repeat(inflation, 2), np.repeat(inflation, 2 * channels)]))
    exponents = np.concatenate([poles.pairs[pairs], poles.reals[reals]]).astype(complex)
    return Shared(exponents=exponents, shapes=shapes, covariance=joint * np.outer(widen, widen))


def _one_shape(amplitudes: ComplexArray, covariance: RealArray) -> tuple[ComplexArray, RealArray]:
    """Return the shapes (channel, mode) and their derivatives by the amplitudes, (shape, amplitude), as real parts."""
    repeats, channels, wanted = amplitudes.shape
    data = np.stack([amplitudes.real, amplitudes.imag], axis=-1).ravel()
    scale = 1 / np.sqrt(np.maximum(covariance.diagonal(), 1e-300))
    # Exact records leave no covariance to speak of: then all amplitudes count alike, to rounding.
    weight = np.linalg.pinv(covariance * np.outer(scale, scale), rcond=1e-13, hermitian=True) * np.outer(scale, scale)
    strongest = np.argmax(np.sum(np.abs(amplitudes) ** 2, axis=0), axis=0)
    # Where to start: the shape that the strongest channel of each decay shows, over all decays by least squares.
    q = np.stack([amplitudes[:, strongest[k], k] for k in range(wanted)], axis=1)
    phi = np.stack(
        [q[:, k].conj() @ amplitudes[:, :, k] / np.vdot(q[:, k], q[:, k]).real for k in range(wanted)], axis=1
    )
    shape_columns = 2 * repeats * wanted
    estimator = np.zeros((2 * wanted * channels, data.size))
    for _ in range(STEPS):
        slopes = np.zeros((data.size, shape_columns + 2 * channels * wanted))
        model = q[:, None, :] * phi[None]
        for r in range(repeats):
            for c in range(channels):
                for k in range(wanted):
                    at = 2 * ((r * channels + c) * wanted + k)
                    of_q, of_phi = 2 * (r * wanted + k), shape_columns + 2 * (k * channels + c)
                    slopes[at : at + 2, of_q : of_q + 2] = _rotation(phi[c, k])
                    if c != strongest[k]:
                        slopes[at : at + 2, of_phi : of_phi + 2] = _rotation(q[r, k])
        used = np.flatnonzero(np.any(slopes != 0, axis=0))
        slopes = slopes[:, used]
        unit = 1 / np.linalg.norm(scale[:, None] * slopes, axis=0)
        normal = (slopes * unit).T @ weight @ (slopes * unit)
        solve = unit[:, None] * np.linalg.lstsq(normal, (slopes * unit).T @ weight, rcond=1e-14)[0]
        left = data - np.stack([model.real, model.imag], axis=-1).ravel()
        change = np.zeros(shape_columns + 2 * channels * wanted)
        change[used] = solve @ left
        q = q + change[:shape_columns].view(complex).reshape(repeats, wanted)
        phi = phi + change[shape_columns:].view(complex).reshape(wanted, channels).T
        full = np.zeros((len(change), data.size))
        full[used] = solve
        estimator = full[shape_columns:]
    return phi, estimator


def _exponents_by_parameters(pairs: int, reals: int, exponents: int) -> ComplexArray:
    """Return the derivatives of the exponents by Re and Im of each pair and by each real pole."""
    out = np.zeros((exponents, 2 * pairs + reals), complex)
    for i in range(pairs):
        out[i, 2 * i], out[i, 2 * i + 1] = 1, 1j
        out[pairs + i, 2 * i], out[pairs + i, 2 * i + 1] = 1, -1j
    for j in range(reals):
        out[2 * pairs + j, 2 * pairs + j] = 1
    return out


def _inverse(information: RealArray) -> RealArray:
    """Return the inverse of an information, scaled to a unit diagonal first."""
    scale = 1 / np.sqrt(np.maximum(information.diagonal(), 1e-300))
    return np.asarray(np.linalg.pinv(information * np.outer(scale, scale), hermitian=True) * np.outer(scale, scale))


def _rotation(factor: complex) -> RealArray:
    """Return multiplication by a complex number as a real matrix."""
    return np.array([[factor.real, -factor.imag], [factor.imag, factor.real]])
