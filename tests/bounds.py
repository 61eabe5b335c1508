"""The Cramér-Rao bound of natural frequencies and damping ratios, by differences of the sampled decay itself."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]


def shapes_in_time(wn: Real, zeta: Real, t: Real) -> Real:
    """Return ``e^(-zeta wn t)`` times cosine and sine of ``wn sqrt(1 - zeta^2) t``, (sample, 2 mode)."""
    envelope, angle = np.exp(-np.outer(t, zeta * wn)), np.outer(t, wn * np.sqrt(1 - zeta**2))
    return np.hstack([envelope * np.cos(angle), envelope * np.sin(angle)])


def modal_bound(wn: Real, zeta: Real, clean: Real, t: Real, noise_std: Real) -> tuple[Real, Real]:
    """Return the least standard deviations of wn and zeta that any unbiased estimator can have.

    ``sigma^2 (J^T J)^-1`` with J over wn, zeta and each channel's amplitudes; clean and noise_std are (channel, sample)
    and (channel,). J in wn and zeta by central differences, so that no algebra of poles is trusted.
    """
    modes = len(wn)
    basis = shapes_in_time(wn, zeta, t)
    rows: list[list[Any]] = []
    for channel, std in zip(clean, noise_std, strict=True):
        amplitude = np.linalg.lstsq(basis, channel, rcond=None)[0]
        columns = []
        for which in range(2 * modes):
            change = np.zeros(2 * modes)
            change[which] = 1e-6 * (wn[which] if which < modes else 1.0)
            up, down = (
                shapes_in_time(wn + sign * change[:modes], zeta + sign * change[modes:], t) @ amplitude
                for sign in (1, -1)
            )
            columns.append((up - down) / (2 * change[which]))
        # The amplitudes of the channel are its own: take out what they can follow.
        nonlinear = np.stack(columns, axis=1)
        nonlinear -= basis @ np.linalg.lstsq(basis, nonlinear, rcond=None)[0]
        rows.append([nonlinear / std])
    J = np.vstack([block for (block,) in rows])
    scale = np.linalg.norm(J, axis=0)
    std = np.sqrt(np.diag(np.linalg.inv((J / scale).T @ (J / scale)))) / scale
    return std[:modes], std[modes:]
