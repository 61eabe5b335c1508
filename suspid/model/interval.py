"""Intervals of modes."""

from __future__ import annotations

from dataclasses import dataclass

from suspid.units import Ratio, RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Interval:
    """Bounds of natural frequency and damping ratio: (mode, 2) arrays of lower and upper ends.

    Parameters
    ----------
    level : float
        Probability that the true value lies between the ends [1].
    wn : ndarray (mode, 2)
        Natural frequency [rad/s].
    zeta : ndarray (mode, 2)
        Damping ratio [1].

    Examples
    --------
    >>> from suspid import ModalSet
    >>> modes = ModalSet.from_wn_zeta([10.0], [0.3], wn_std=[0.1], zeta_std=[0.01])
    >>> bounds = modes.interval(0.95)
    >>> bounds.level, bounds.wn.round(2), bounds.zeta.round(3)
    (0.95, array([[ 9.8, 10.2]]), array([[0.28, 0.32]]))
    """

    level: Ratio
    wn: RealArray
    zeta: RealArray
