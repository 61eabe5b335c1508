"""Table 2 of the paper as printed."""

from __future__ import annotations

from dataclasses import dataclass

from suspid.units import Decibel


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """One row of Table 2 as printed; the modes are numbered as in the paper, the fastest first."""

    name: str
    snr_db: Decibel | None  # None without noise
    denoised: bool  # whether the noisy record is denoised first
    wn: tuple[float, float, float]  # the paper's natural frequencies [rad/s]
    zeta: tuple[float, float, float]  # the paper's damping ratios [%]
    mae: tuple[float, float]  # the paper's mean absolute errors [rad/s], [%]

    @property
    def slug(self) -> str:
        """The name as part of a file's name."""
        return self.name.lower().replace(" ", "_")


ACTUAL_WN, ACTUAL_ZETA = (83.67, 50.09, 21.26), (1.55, 2.52, 0.79)
CASES = tuple(
    Case(name=name, snr_db=snr_db, denoised=name.startswith("denoised"), wn=wn, zeta=zeta, mae=mae)
    for name, snr_db, wn, zeta, mae in (
        ("original", None, (83.6732, 50.0925, 21.2686), (1.5568, 2.5293, 0.7905), (4.77e-3, 5.53e-3)),
        ("noise 20 dB", 20.0, (83.6701, 50.0912, 21.2700), (1.5602, 2.5188, 0.7797), (3.77e-3, 1.03e-2)),
        ("noise 2 dB", 2.0, (83.6697, 50.0752, 21.2698), (1.5749, 2.5129, 0.8013), (8.30e-3, 1.40e-2)),
        ("denoised 20 dB", 20.0, (83.6744, 50.0976, 21.2669), (1.5564, 2.5198, 0.7905), (6.30e-3, 4.60e-3)),
        ("denoised 2 dB", 2.0, (83.6762, 50.0981, 21.2688), (1.5568, 2.5287, 0.7919), (7.70e-3, 5.87e-3)),
    )
)
