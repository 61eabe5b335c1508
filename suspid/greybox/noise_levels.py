"""Noise of outputs and causes, from the moments of the residual.

The residual ``r = Y_o - T Y_g`` of true parameters has the covariance ``R = diag(S_o) + T diag(S_g) T^H``: S_o is a
smooth function of frequency by output, S_g a level by cause. They maximise the likelihood of r with T as it is. Where
``T diag(S_g) T^H`` is as smooth as S_o can be, r alone does not tell them apart, but ``r Y_g^H`` has the mean
``-T diag(S_g)`` whatever the true motion: it counts as a measurement of S_g.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.greybox.small_matrices import inverses, log_determinants
from suspid.units import ComplexArray, RealArray

LOOSE = 4.0  # standard deviation of the logarithm of a level about its first value; holds what is not seen
# That of its change from node to node: where the noise of the causes hides that of an output, the output's is as at the
# neighbouring nodes. Where it is seen, 100 lines and more know it to 0.1 and a step of any size costs next to nothing.
STEP_OF_LEVELS = 1.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Levels:
    """Logarithms of noise levels."""

    outputs: RealArray  # (node, output)
    causes: RealArray  # (cause,)

    def spectra(self, basis: RealArray) -> tuple[RealArray, RealArray]:
        """Return S_o (line, output) and S_g (cause,)."""
        return np.exp(basis @ self.outputs), np.exp(self.causes)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Shared:
    """What the residual has in common with the causes: minus log likelihood ``S^T A S + 2 b^T S`` of S = S_g."""

    A: RealArray  # (cause, cause)
    b: RealArray  # (cause,)


def shared_of(T: ComplexArray, precision: ComplexArray, left: ComplexArray, causes: ComplexArray) -> Shared:
    """Return what residuals ``left`` (line, stretch, output) have in common with causes (line, stretch, cause).

    The variance of ``r Y_g^H`` is that of r, whose inverse is ``precision`` (line, output, output), times the power of
    the causes, taken together over some lines.
    """
    from scipy.ndimage import uniform_filter1d

    stretches = left.shape[1]
    # Lines and stretches over which the power of the causes is taken together, at least.
    width = 2 * -(-32 // (2 * stretches)) + 1
    power = causes.swapaxes(1, 2) @ causes.conj() / stretches
    power = uniform_filter1d(power.real, width, axis=0) + 1j * uniform_filter1d(power.imag, width, axis=0)
    inverse = inverses(power.conj())
    weighed = T.conj().swapaxes(1, 2) @ precision
    common = left.swapaxes(1, 2) @ causes.conj()
    return Shared(
        A=stretches * np.sum(((weighed @ T) * inverse).real, axis=0),
        b=np.sum(((weighed @ common) * inverse).real, axis=(0, 2)),
    )


def node_basis(hertz: RealArray, stretches: int = 1) -> RealArray:
    """Return hat functions of frequency, (line, node): the more, the more lines of all stretches there are."""
    # Nodes are evenly spaced up to about 4 times the lowest frequency, and in the logarithm of frequency above.
    at = np.arcsinh(hertz / (4 * hertz[0]))
    # With fewer than 100 lines and stretches a node, a level would follow chance. A force on the body may end at some
    # frequency; with few nodes, lines beyond it weigh too little.
    nodes = np.linspace(at[0], at[-1], int(np.clip(len(hertz) * stretches // 100, 6, 24)))
    return np.asarray(np.maximum(0.0, 1 - np.abs(at[:, None] - nodes) / (nodes[1] - nodes[0])))


def covariance_of(T: ComplexArray, outputs: RealArray, causes: RealArray) -> ComplexArray:
    """Return R, (line, output, output)."""
    R = (T * causes) @ T.conj().transpose(0, 2, 1)
    own = np.arange(T.shape[1])
    R[:, own, own] += outputs
    return R


def levels_of(
    T: ComplexArray,
    moments: ComplexArray,
    basis: RealArray,
    start: Levels,
    *,
    anchor: Levels,
    count: int,
    shared: Shared,
) -> Levels:
    """Return the most likely noise levels given ``moments``, the mean of ``r r^H`` (line, output, output)."""
    nodes, outputs = start.outputs.shape
    causes = len(start.causes)
    z = np.concatenate([start.outputs.ravel(), start.causes])
    about, damping = np.concatenate([anchor.outputs.ravel(), anchor.causes]), 1e-3
    held = _held(nodes, outputs, causes)
    value = np.inf
    step = np.zeros_like(z)
    # Newton steps at most; a few are needed.
    for _ in range(30):
        trial = z + step
        out, cause = np.exp(basis @ trial[: nodes * outputs].reshape(nodes, outputs)), np.exp(trial[nodes * outputs :])
        R = covariance_of(T, out, cause)
        inverse, logdet = inverses(R), log_determinants(R)
        fit = np.sum(inverse * moments.swapaxes(1, 2), axis=(1, 2)).real
        new = count * float(np.sum(logdet + fit)) + float((trial - about) @ held @ (trial - about))
        new += float(cause @ (shared.A @ cause + 2 * shared.b))
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
            by_causes = count * per_cause.sum(axis=0) - 2 * cause * (shared.A @ cause + shared.b)
            gradient = np.concatenate([count * (basis.T @ per_output).ravel(), by_causes])
            between = inverse @ T
            square = np.abs(inverse) ** 2 * out[:, :, None] * out[:, None, :]
            cross = np.abs(between) ** 2 * out[:, :, None] * cause
            both = np.abs(T.conj().transpose(0, 2, 1) @ between) ** 2 * cause[:, None] * cause
            oo = np.empty((nodes, outputs, nodes, outputs))
            # One pair of outputs at a time: products of all nodes for each line take many times the record.
            for i, j in np.ndindex(outputs, outputs):
                oo[:, i, :, j] = (basis * square[:, i, j, None]).T @ basis
            oc = (basis.T @ cross.reshape(len(basis), -1)).reshape(nodes * outputs, causes)
            gg = both.sum(axis=0) + 2 * cause[:, None] * cause * shared.A / count
            information = count * np.block([[oo.reshape(nodes * outputs, -1), oc], [oc.T, gg]])
            gradient -= held @ (z - about)
            information += held
        scaled = information + damping * np.diag(np.diag(information))
        step = np.clip(np.linalg.solve(scaled, gradient), -2.0, 2.0)
        if damping > 1e6:
            break
    return Levels(outputs=z[: nodes * outputs].reshape(nodes, outputs), causes=z[nodes * outputs :])


def _held(nodes: int, outputs: int, causes: int) -> RealArray:
    """Return the matrix of what is known of levels beforehand: they are near the first ones, and smooth."""
    steps = np.diff(np.eye(nodes), axis=0) / STEP_OF_LEVELS
    known = np.eye(nodes * outputs + causes) / LOOSE**2
    known[: nodes * outputs, : nodes * outputs] += np.kron(steps.T @ steps, np.eye(outputs))
    return known
