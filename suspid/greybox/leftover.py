"""Whether what is left of the outputs follows the causes: then the topology lacks something."""

from __future__ import annotations

import numpy as np

from suspid.greybox.measured_causes import Whitened
from suspid.units import Hertz, Ratio, RealArray

# Real numbers, at most, by which the transfers are varied: enough for each resonance, few beside the lines.
FREEDOM = 48
# Information on a variation, as a share of the largest, below which it is one of the parameters', or of the ends.
SEEN = 1e-9


def coherent_leftover(found: Whitened, hertz: RealArray) -> tuple[float, int, Ratio, Hertz]:
    """Return the statistic of the test, its degrees of freedom, and the error of the transfer where it shows most.

    Every transfer is varied by a continuous function of frequency, real and imaginary part, of which the physical
    parameters explain a part. What the residual gains by the rest is a chi-square if the topology is right (a score
    test). The error is relative to the transfer, root mean square over the outputs.
    """
    lines, stretches, causes = found.motion.shape
    outputs = found.factor.shape[1]
    nodes = max(2, FREEDOM // (2 * outputs * causes))
    at = np.linspace(hertz[0], hertz[-1], nodes)
    hats = np.maximum(0.0, 1 - np.abs(hertz[:, None] - at) / (at[1] - at[0]))
    # (stretch, line, row, output, cause, node)
    along = found.motion.swapaxes(0, 1)[:, :, :, None] * hats[:, None, :]
    moved = found.factor[None, :, :, :, None, None] * along[:, :, None, None]
    moved = moved.reshape(stretches, lines * outputs, -1)
    rows = np.concatenate(
        [np.concatenate([moved.real, -moved.imag], axis=2), np.concatenate([moved.imag, moved.real], axis=2)], axis=1
    )
    rows -= found.basis @ (found.basis.T @ rows)
    flat = rows.reshape(-1, rows.shape[2])
    slope, residual = found.slope.reshape(len(flat), -1), found.residual.ravel()
    # Sums of products: the rows are many, the columns few. What the parameters explain is taken out.
    norm, size = np.sqrt(np.einsum("rn,rn->n", flat, flat)), np.sqrt(np.einsum("rp,rp->p", slope, slope))
    size[size == 0] = 1.0  # A delay of another record is not seen in this one.
    cross = slope.T @ flat / np.outer(size, norm)
    taken = np.linalg.pinv(slope.T @ slope / np.outer(size, size), hermitian=True) @ cross
    values, directions = np.linalg.eigh(flat.T @ flat / np.outer(norm, norm) - cross.T @ taken)
    keep = values > SEEN * values[-1]
    score = flat.T @ residual / norm - taken.T @ (slope.T @ residual / size)
    amounts = directions[:, keep].T @ score / np.sqrt(values[keep])
    # The variation that explains the residual itself, which follows no parameter at the best fit; if their part were
    # taken out of it, it would be large where one is hardly told from another.
    change = (
        np.linalg.pinv(flat.T @ flat / np.outer(norm, norm), SEEN, hermitian=True) @ (flat.T @ residual / norm) / norm
    )
    change = (change[: len(change) // 2] + 1j * change[len(change) // 2 :]).reshape(outputs * causes, nodes)
    change = (change @ hats.T).T.reshape(lines, outputs, causes)
    error = np.sqrt(np.sum(np.abs(change) ** 2, axis=(1, 2)) / np.sum(np.abs(found.transfer.T) ** 2, axis=(1, 2)))
    # In standard deviations: at the ends of the band a large error may be within them.
    shown = found.factor @ change @ found.motion.transpose(0, 2, 1)
    worst = int(np.argmax(np.sum(np.abs(shown) ** 2, axis=(1, 2))))
    return float(amounts @ amounts), int(np.sum(keep)), float(error[worst]), float(hertz[worst])
