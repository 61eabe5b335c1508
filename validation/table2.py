"""Table 2 of the paper as printed."""

from __future__ import annotations

from dataclasses import dataclass

from suspid.units import Decibel


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """One row of Table 2 as printed; the modes are counted as in the paper, the fastest first.

    Parameters
    ----------
    name : str
        Name of the row.
    snr_db : float or None
        Signal-to-noise ratio [dB]; None without noise.
    denoised : bool
        Whether the noisy record is denoised first.
    wn, zeta : tuple of float
        The paper's natural frequencies [rad/s] and damping ratios [%].
    mae : tuple of float
        The paper's mean absolute errors [rad/s], [%].
    """

    name: str
    snr_db: Decibel | None
    denoised: bool
    wn: tuple[float, float, float]
    zeta: tuple[float, float, float]
    mae: tuple[float, float]

    @property
    def slug(self) -> str:
        """The name as part of a file's name."""
        return self.name.lower().replace(" ", "_")


ACTUAL_WN, ACTUAL_ZETA = (83.67, 50.09, 21.26), (1.55, 2.52, 0.79)
CASES = (
    Case(
        name="original",
        snr_db=None,
        denoised=False,
        wn=(83.6732, 50.0925, 21.2686),
        zeta=(1.5568, 2.5293, 0.7905),
        mae=(4.77e-3, 5.53e-3),
    ),
    Case(
        name="noise 20 dB",
        snr_db=20.0,
        denoised=False,
        wn=(83.6701, 50.0912, 21.2700),
        zeta=(1.5602, 2.5188, 0.7797),
        mae=(3.77e-3, 1.03e-2),
    ),
    Case(
        name="noise 2 dB",
        snr_db=2.0,
        denoised=False,
        wn=(83.6697, 50.0752, 21.2698),
        zeta=(1.5749, 2.5129, 0.8013),
        mae=(8.30e-3, 1.40e-2),
    ),
    Case(
        name="denoised 20 dB",
        snr_db=20.0,
        denoised=True,
        wn=(83.6744, 50.0976, 21.2669),
        zeta=(1.5564, 2.5198, 0.7905),
        mae=(6.30e-3, 4.60e-3),
    ),
    Case(
        name="denoised 2 dB",
        snr_db=2.0,
        denoised=True,
        wn=(83.6762, 50.0981, 21.2688),
        zeta=(1.5568, 2.5287, 0.7919),
        mae=(7.70e-3, 5.87e-3),
    ),
)
