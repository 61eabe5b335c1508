"""Residuals of measured causes in standard deviations, with derivatives a few stretches at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from suspid.greybox.noise_levels import covariance_of
from suspid.greybox.problem import squeezed
from suspid.greybox.small_matrices import inverses, whitening
from suspid.greybox.transfers import Layout, Transfer
from suspid.units import ComplexArray, RealArray

DERIVED_ROWS = 8000  # of the residual, whose derivatives fit into a processor's cache


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Whitened:
    """Residual of one trial, in standard deviations, and what its derivatives follow from.

    Derivatives are many times as long as the record: they are made for some stretches at a time.
    """

    residual: RealArray  # (stretch, row)
    motion: ComplexArray  # (line, stretch, cause): best estimate of the causes
    ends: RealArray  # (stretch, column): amounts of what was projected out
    transfer: Transfer
    factor: ComplexArray  # (line, output, output): R^(-1/2)
    basis: RealArray  # (row, column): what was projected out
    columns: RealArray  # (parameter, unknown): how the parameters of the transfer follow from the unknowns
    outputs: RealArray  # (line, output): S_o
    causes: RealArray  # (cause,): S_g
    shown: tuple[int, ...]  # channels that show the causes

    def slope(self, part: slice) -> RealArray:
        """Return the derivatives of the residual of some stretches, (stretch, row, unknown)."""
        made, ends = self.transfer, self.ends[part]
        apart = self.motion[:, part] - _combined(ends, made.ends[:, list(self.shown)])
        amounts = apart @ turned(made.right) + _combined(ends, made.ends_right)
        own = self.factor @ made.left
        flat = _real(amounts[:, :, None, list(made.places)] * -own[:, None]) @ self.columns
        flat -= self.basis @ (self.basis.T @ flat)
        return flat

    def parts(self, rows: int = DERIVED_ROWS) -> Iterator[slice]:
        """Yield all stretches, at least one at a time and as many as have that many rows."""
        together = max(1, rows // self.residual.shape[1])
        for first in range(0, len(self.residual), together):
            yield slice(first, first + together)

    def rows(self) -> tuple[RealArray, RealArray]:
        """Return the residual and its derivatives as few rows of the same norms and inner products."""
        count = self.columns.shape[1]
        found = [squeezed(self.residual[p].ravel(), self.slope(p).reshape(-1, count)) for p in self.parts()]
        if len(found) == 1:
            return found[0]
        return squeezed(np.concatenate([r for r, _ in found]), np.concatenate([s for _, s in found]))

    @property
    def left(self) -> ComplexArray:
        """Residual in the units of the outputs, (line, stretch, output)."""
        return np.asarray(_complex(self.residual, self.factor) @ turned(inverses(self.factor)))

    @property
    def misfit(self) -> ComplexArray:
        """Outputs less what the best motion explains, (line, stretch, output)."""
        return np.asarray(self.left @ turned(precision(self.factor)) * self.outputs[:, None])

    @property
    def spurious(self) -> RealArray:
        """Part of the information that is due to noise of the best motion, (unknown, unknown).

        The covariance of the best motion, S_g - S_g T^H R^-1 T S_g, is seen by each pair of parameters.
        """
        made, own = self.transfer, self.factor @ self.transfer.left
        gain = precision(self.factor) @ made.T * self.causes
        blurred = np.diag(self.causes) - self.causes[:, None] * (turned(made.T).conj() @ gain)
        right = made.right[:, list(made.places)]
        seen = right.conj() @ turned(blurred) @ turned(right)
        pairs = np.sum((turned(own).conj() @ own) * seen, axis=0).real
        return np.asarray(len(self.residual) * self.columns.T @ pairs @ self.columns)


def whitened(
    values: ComplexArray, layout: Layout, made: Transfer, *, outputs: RealArray, causes: RealArray, columns: RealArray
) -> Whitened:
    """Return the residual of spectra (line, stretch, channel) at noise of ``outputs`` and ``causes``."""
    factor = whitening(covariance_of(made.T, outputs, causes)) * np.sqrt(2)
    y_o = values[:, :, list(layout.outputs)]
    y_g = values[:, :, list(layout.causes)]
    e = _real((y_o - y_g @ turned(made.T)) @ turned(factor))
    ends = _real((factor @ made.left_by_ends)[:, None])[0]
    norm = np.sqrt(np.einsum("rn,rn->n", ends, ends))
    q, upper = np.linalg.qr(ends / norm)
    found = q.T @ e
    amounts_of_ends = np.linalg.solve(upper, found)[:, :, 0] / norm
    e = (e - q @ found)[:, :, 0]
    motion = y_g + _complex(e, factor) @ turned(causes[:, None] * turned(factor @ made.T).conj() / 2)
    return Whitened(
        residual=e,
        motion=motion,
        ends=amounts_of_ends,
        transfer=made,
        factor=factor,
        basis=q,
        columns=columns,
        outputs=outputs,
        causes=causes,
        shown=layout.causes,
    )


def _complex(rows: RealArray, factor: ComplexArray) -> ComplexArray:
    """Return rows (stretch, row) as complex numbers (line, stretch, output)."""
    halves = rows.reshape(len(rows), 2, *factor.shape[:2])
    return np.asarray((halves[:, 0] + 1j * halves[:, 1]).swapaxes(0, 1))


def _combined(amounts: RealArray, columns: ComplexArray) -> ComplexArray:
    """Return sums of columns (line, row, column) times amounts (stretch, column), (line, stretch, row)."""
    # One product of all lines: a product for each line takes most of its time to call.
    lines, rows = columns.shape[:2]
    pairs = np.ascontiguousarray(columns.transpose(2, 0, 1)).view(float).reshape(columns.shape[2], -1)
    return np.asarray((amounts @ pairs).view(complex).reshape(len(amounts), lines, rows).swapaxes(0, 1))


def turned(matrices: ComplexArray) -> ComplexArray:
    """Return the transposes of a stack of matrices."""
    return np.asarray(matrices.swapaxes(-1, -2))


def precision(factor: ComplexArray) -> ComplexArray:
    """Return R^-1 from its factor, which is in standard deviations of real and imaginary part."""
    return np.asarray(factor.conj().transpose(0, 2, 1) @ factor / 2)


def _real(values: ComplexArray) -> RealArray:
    """Return values (line, stretch, output, …) as rows (stretch, row, …): real parts, then imaginary parts.

    The last axis may be missing; it then has length 1.
    """
    lines, stretches, outputs = values.shape[:3]
    flat = values.swapaxes(0, 1).reshape(stretches, lines * outputs, -1)
    return np.concatenate([flat.real, flat.imag], axis=1)
