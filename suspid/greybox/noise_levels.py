"""Noise of outputs and causes, from the moments of the residual.

The residual ``r = Y_o - T Y_g`` of true parameters has the covariance ``R = diag(S_o) + T diag(S_g) T^H``: S_o is a
smooth function of frequency by output, S_g a level by cause. They maximise the likelihood of r with T as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.units import ComplexArray, RealArray

NODES = 6  # of the spectrum of an output, evenly spaced in the logarithm of frequency
LEVEL_STEPS = 30  # Newton steps at most
LOOSE = 4.0  # standard deviation of the logarithm of a level about its first value; holds what is not seen


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Levels:
    """Logarithms of noise levels."""

    outputs: RealArray  # (node, output)
    causes: RealArray  # (cause,)

    def spectra(self, basis: RealArray) -> tuple[RealArray, RealArray]:
        """Return S_o (line, output) and S_g (cause,)."""
        return np.exp(basis @ self.outputs), np.exp(self.causes)


def node_basis(hertz: RealArray) -> RealArray:
    """Return hat functions of the logarithm of frequency, (line, node)."""
    at = np.log(hertz)
    nodes = np.linspace(at[0], at[-1], NODES)
    return np.asarray(np.maximum(0.0, 1 - np.abs(at[:, None] - nodes) / (nodes[1] - nodes[0])))


def covariance_of(T: ComplexArray, outputs: RealArray, causes: RealArray) -> ComplexArray:
    """Return R, (line, output, output)."""
    R = (T * causes) @ T.conj().transpose(0, 2, 1)
    own = np.arange(T.shape[1])
    R[:, own, own] += outputs
    return R


def levels_of(
    T: ComplexArray, moments: ComplexArray, basis: RealArray, start: Levels, *, anchor: Levels, count: int
) -> Levels:
    """Return the most likely noise levels given ``moments``, the mean of ``r r^H`` (line, output, output)."""
    nodes, outputs = start.outputs.shape
    causes = len(start.causes)
    z = np.concatenate([start.outputs.ravel(), start.causes])
    about, damping = np.concatenate([anchor.outputs.ravel(), anchor.causes]), 1e-3
    value = np.inf
    step = np.zeros_like(z)
    for _ in range(LEVEL_STEPS):
        trial = z + step
        out, cause = np.exp(basis @ trial[: nodes * outputs].reshape(nodes, outputs)), np.exp(trial[nodes * outputs :])
        R = covariance_of(T, out, cause)
        inverse = np.linalg.inv(R)
        _, logdet = np.linalg.slogdet(R)
        fit = np.sum(inverse * moments.swapaxes(1, 2), axis=(1, 2)).real
        new = count * float(np.sum(logdet + fit)) + float(np.sum(((trial - about) / LOOSE) ** 2))
        if new > value:
            damping *= 10
        else:
            done = value - new < 1e-3
            z, value, damping = trial, new, max(damping / 10, 1e-9)
            if done:
                break
            weigh = inverse @ (moments - R) @ inverse
            per_output = out * np.einsum("laa->la", weigh).real
            per_cause = cause * np.sum(T.conj() * (weigh @ T), axis=1).real
            gradient = np.concatenate([(basis.T @ per_output).ravel(), per_cause.sum(axis=0)]) * count
            between = inverse @ T
            square = np.abs(inverse) ** 2 * out[:, :, None] * out[:, None, :]
            cross = np.abs(between) ** 2 * out[:, :, None] * cause
            both = np.abs(T.conj().transpose(0, 2, 1) @ between) ** 2 * cause[:, None] * cause
            spread = (basis[:, :, None] * basis[:, None, :]).reshape(len(basis), -1)
            oo = (spread.T @ square.reshape(len(basis), -1)).reshape(nodes, nodes, outputs, outputs)
            oo = oo.swapaxes(1, 2).reshape(nodes * outputs, -1)
            oc = (basis.T @ cross.reshape(len(basis), -1)).reshape(nodes * outputs, causes)
            information = count * np.block([[oo, oc], [oc.T, both.sum(axis=0)]])
            gradient -= (z - about) / LOOSE**2
            information[np.diag_indices_from(information)] += 1 / LOOSE**2
        scaled = information + damping * np.diag(np.diag(information))
        step = np.clip(np.linalg.solve(scaled, gradient), -2.0, 2.0)
        if damping > 1e6:
            break
    return Levels(outputs=z[: nodes * outputs].reshape(nodes, outputs), causes=z[nodes * outputs :])
