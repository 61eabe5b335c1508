"""Test whether the residual of the outputs follows the causes, which indicates a wrong topology."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from suspid.greybox.whitened import Whitened, turned
from suspid.levels import EXACT
from suspid.units import Hertz, Ratio, RealArray


class Leftover(NamedTuple):
    """The part of the residual of one record that follows the given motion."""

    chi_square: float
    freedom: int
    directions: float  # over which it is spread: all of them, or fewer if it is larger in some than chance has it
    error: Ratio  # of the transfer, where it shows most
    hertz: Hertz  # where that is


def coherent_leftover(found: Whitened, hertz: RealArray) -> Leftover:
    """Return the statistic of the test, and the error of the transfer where it shows most.

    Every transfer is varied by a continuous function of frequency, real and imaginary part, of which the physical
    parameters explain a part. What the residual gains by the rest is a chi-square if the topology is right (a score
    test). The error is relative to the transfer, root mean square over the outputs.
    """
    lines, _, causes = found.motion.shape
    outputs = found.factor.shape[1]
    # Real numbers, at most, by which the transfers are varied: enough for each resonance, few beside the lines.
    nodes = max(2, 48 // (2 * outputs * causes))
    at = np.linspace(hertz[0], hertz[-1], nodes)
    hats = np.maximum(0.0, 1 - np.abs(hertz[:, None] - at) / (at[1] - at[0]))
    own, cross, score = _products(found, hats)
    residual, slope = found.rows()
    # What the parameters explain is taken out.
    norm, size = np.sqrt(np.diag(own)), np.sqrt(np.einsum("rp,rp->p", slope, slope))
    size[size == 0] = 1.0  # A delay of another record is not seen in this one.
    own, cross, score = own / np.outer(norm, norm), cross / np.outer(size, norm), score / norm
    taken = np.linalg.pinv(slope.T @ slope / np.outer(size, size), hermitian=True) @ cross
    values, directions = np.linalg.eigh(own - cross.T @ taken)
    # What carries less information is a variation of the parameters, or of the ends.
    keep = values > EXACT * values[-1]
    score_left = score - taken.T @ (slope.T @ residual / size)
    amounts = directions[:, keep].T @ score_left / np.sqrt(values[keep])
    # The variation that explains the residual itself, which follows no parameter at the best fit; if their part were
    # taken out of it, it would be large where one is hardly told from another.
    change = np.linalg.pinv(own, EXACT, hermitian=True) @ score / norm
    change = (change[: len(change) // 2] + 1j * change[len(change) // 2 :]).reshape(outputs * causes, nodes)
    change = (change @ hats.T).T.reshape(lines, outputs, causes)
    error = np.sqrt(np.sum(np.abs(change) ** 2, axis=(1, 2)) / np.sum(np.abs(found.transfer.T) ** 2, axis=(1, 2)))
    # In standard deviations: at the ends of the band a large error may be within them.
    shown = found.factor @ change @ found.motion.transpose(0, 2, 1)
    worst = int(np.argmax(np.sum(np.abs(shown) ** 2, axis=(1, 2))))
    chi_square, freedom = float(amounts @ amounts), int(np.sum(keep))
    return Leftover(
        chi_square=chi_square,
        freedom=freedom,
        # A Gaussian amount has a fourth moment of three times its squared second.
        directions=min(float(freedom), 3 * chi_square**2 / float(np.sum(amounts**4))),
        error=float(error[worst]),
        hertz=float(hertz[worst]),
    )


def _products(found: Whitened, hats: RealArray) -> tuple[RealArray, RealArray, RealArray]:
    """Return sums of products over all rows: of variations, of derivatives with them, and of them with the residual.

    A variation at a node moves lines near it by ``factor motion``. The variations are never written out: they are
    multiplied for each line over all stretches, and summed over lines with the hats. What was projected out of them is
    subtracted; residual and derivatives have no part of it.
    """
    factor, motion = found.factor, found.motion
    lines, outputs = factor.shape[:2]
    stretches, causes = motion.shape[1:]
    weights, power = turned(factor).conj() @ factor, turned(motion).conj() @ motion
    pairs = np.einsum("lab,lcd->lacbd", weights, power).reshape(lines, outputs * causes, -1)
    own = np.einsum("lij,ln,lm->injm", pairs, hats, hats, optimize=True)
    own = own.reshape(outputs * causes * hats.shape[1], -1)
    own = np.block([[own.real, -own.imag], [own.imag, own.real]])
    halves = found.basis.reshape(2, lines, outputs, -1)
    onto = turned(halves[0] - 1j * halves[1]) @ factor  # (line, column, output)
    for column in range(onto.shape[1]):
        near = (onto[:, column, :, None] * hats[:, None, :]).reshape(lines, -1)
        amounts = motion.reshape(lines, -1).T @ near  # (stretch and cause, output and node)
        amounts = amounts.reshape(stretches, causes, outputs, -1).swapaxes(1, 2).reshape(stretches, -1)
        projected = np.hstack([amounts.real, -amounts.imag])
        own -= projected.T @ projected
    columns = found.columns.shape[1]
    sums = np.zeros((lines, outputs, causes, columns + 1), complex)
    for part in found.parts():
        shown = np.concatenate([found.slope(part), found.residual[part][:, :, None]], axis=2)
        shown = shown.reshape(len(shown), 2, lines, outputs, -1)
        back = turned(factor).conj() @ (shown[:, 0] + 1j * shown[:, 1])  # (stretch, line, output, column)
        sums += np.einsum("lsc,slop->locp", motion[:, part].conj(), back)
    with_rows = np.einsum("locp,ln->pocn", sums, hats, optimize=True).reshape(columns + 1, -1)
    with_rows = np.hstack([with_rows.real, with_rows.imag])
    return own, with_rows[:-1], with_rows[-1]
