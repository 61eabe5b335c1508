"""The part of a residual that follows known roads and forces: no noise does, so the car lacks something."""

from __future__ import annotations

import numpy as np

from suspid.greybox.body_spectra import WORTH
from suspid.levels import EXACT
from suspid.units import RealArray

# Windows, at least, that a record is divided into, and for each cause: lines of twelve windows that half overlap and
# are tapered are known well enough to tell chance from a tenth of the motion.
FEWEST_WINDOWS, FOR_EACH_CAUSE = 12, 4


def caused_share(residual: RealArray, values: RealArray, causes: RealArray) -> RealArray:
    """Return the share of each channel's power that is left of it and follows the causes, (channel,).

    At each frequency the residual is explained by all causes together; chance explains one part in as many as there are
    independent windows, for each cause, and is taken away. Motion that lasts longer than a window is missed.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> road, noise = rng.standard_normal((2, 1, 6000))
    >>> values = 3.0 * road + noise
    >>> bool(abs(caused_share(noise, values, road)[0]) < 0.01)
    True
    >>> bool(abs(caused_share(noise + road, values, road)[0] - 0.1) < 0.01)
    True
    """
    if not len(causes):
        return np.zeros(len(residual))
    size = residual.shape[1] // max(FEWEST_WINDOWS, FOR_EACH_CAUSE * len(causes))
    if size < 2:
        return np.zeros(len(residual))
    left, moved, known = (_windows(rows, size) for rows in (residual, values, causes))
    own = np.einsum("kif,kjf->fij", known.conj(), known)
    norm = np.sqrt(np.einsum("fii->fi", own).real)
    norm[norm == 0] = 1.0
    cross = np.einsum("kif,kcf->fic", known.conj(), left) / norm[:, :, None]
    found = np.linalg.pinv(own / norm[:, :, None] / norm[:, None, :], EXACT, hermitian=True) @ cross
    explained = np.sum((cross.conj() * found).real, axis=(0, 1))
    power, whole = (np.sum(np.abs(one) ** 2, axis=(0, 2)) for one in (left, moved))
    chance = len(causes) / (WORTH * len(known))
    return np.asarray((explained - chance * power) / (1 - chance) / np.where(whole > 0, whole, 1.0))


def _windows(rows: RealArray, size: int) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    """Return the spectra of half-overlapping windows (window, row, line)."""
    window = np.hanning(size + 2)[1:-1]
    starts = range(0, rows.shape[1] - size + 1, size // 2)
    parts = np.array([rows[:, start : start + size] for start in starts])
    return np.asarray(np.fft.rfft((parts - np.mean(parts, axis=2, keepdims=True)) * window, axis=2))
