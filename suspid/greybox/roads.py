"""The road under a wheel, as a drive shows it: exponent, roughness of each stretch, class."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.road_model import REFERENCE_HERTZ, RoadModel
from suspid.greybox.tire_fit import Scores
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.simulation import REFERENCE, road_class
from suspid.units import Ratio, RealArray, Second
from suspid.values import frozen_real
from suspid.words import percent


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RoadEstimate:
    """The road under one wheel in the records of one logger.

    By ISO 8608 its spectral density is ``G_d(n) = G_d(n_0) (n / n_0)^-w`` with ``n_0 = 0.1`` cycle/m.

    Parameters
    ----------
    wheel : str
        Coordinate of the wheel.
    records : tuple of int (stretch,)
        Number of the record that each stretch is of, from 0.
    times : ndarray (stretch,)
        Middle of each stretch [s].
    exponent, exponent_std : float
        w and its standard deviation [1], for departures from the power law of 30 %, correlated over a factor of two in
        wave number.
    speeds : ndarray (stretch,), optional
        Speed [m/s]; None where it was not known, as `roughness`.
    roughness : ndarray (stretch,), optional
        G_d(n_0) [m3].
    roughness_std : ndarray (stretch,), optional
        Standard deviation of its natural logarithm.
    mean_roughness, mean_roughness_std : float, optional
        Geometric mean over the stretches [m3], and the standard deviation of its logarithm.

    Examples
    --------
    >>> road = RoadEstimate(wheel="tire", records=(0,), times=np.array([30.0]), exponent=2.0, exponent_std=0.1,
    ...                     mean_roughness=16e-6, mean_roughness_std=0.2)
    >>> road.road_class
    'A'
    """

    wheel: str
    records: tuple[int, ...]
    times: RealArray
    exponent: Ratio
    exponent_std: Ratio
    speeds: RealArray | None = None
    roughness: RealArray | None = None
    roughness_std: RealArray | None = None
    mean_roughness: float | None = None
    mean_roughness_std: Ratio | None = None

    @property
    def road_class(self) -> str | None:
        """Class of ISO 8608, ``"A"`` to ``"H"``, of the mean roughness; None where the speed was not known.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RoadEstimate
        >>> road = RoadEstimate(wheel="tire", records=(0, 0), times=np.array([5.0, 15.0]), exponent=2.0,
        ...                     exponent_std=0.1, mean_roughness=64e-6, mean_roughness_std=0.2)
        >>> road.road_class
        'B'
        """
        return None if self.mean_roughness is None else road_class(self.mean_roughness)

    @property
    def classes(self) -> tuple[str, ...]:
        """Class of each stretch; empty where the speed was not known.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RoadEstimate
        >>> road = RoadEstimate(wheel="tire", records=(0, 0), times=np.array([5.0, 15.0]), exponent=2.0,
        ...                     exponent_std=0.1, roughness=np.array([16e-6, 256e-6]))
        >>> road.classes
        ('A', 'C')
        """
        return () if self.roughness is None else tuple(road_class(value) for value in self.roughness.tolist())

    def interval(self, level: Ratio = LEVEL) -> tuple[float, float] | None:
        """Return the ends between which the mean roughness lies with probability ``level`` [m3].

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RoadEstimate
        >>> road = RoadEstimate(wheel="tire", records=(0, 0), times=np.array([5.0, 15.0]), exponent=2.0,
        ...                     exponent_std=0.1, mean_roughness=16e-6, mean_roughness_std=0.2)
        >>> low, high = road.interval(0.95)
        >>> round(low * high / 16e-6**2, 6), round(float(np.log(high / 16e-6)) / 0.2, 2)
        (1.0, 1.96)
        """
        check_level(level)
        if self.mean_roughness is None or self.mean_roughness_std is None:
            return None
        factor = float(np.exp(normal_reach(level) * self.mean_roughness_std))
        return self.mean_roughness / factor, self.mean_roughness * factor

    def __str__(self) -> str:
        text = f"road under {self.wheel}: exponent {self.exponent:.2f} ± {self.exponent_std:.2f}"
        if self.mean_roughness is None or self.mean_roughness_std is None:
            return f"{text}; roughness unknown without the speed"
        share = percent(self.mean_roughness_std)
        return f"{text}, G_d(0.1/m) {self.mean_roughness:.3g} m3 ± {share}, class {self.road_class}"


def road_estimate(
    model: RoadModel,
    own: RealArray,
    levels: RealArray,
    scores: Scores,
    covariance: RealArray,
    *,
    wheel: str,
    step: Second,
) -> RoadEstimate:
    """Return the road of one track; ``covariance`` is that of the car's and of the road's unknowns, as stepped."""
    track, cars = model.track, len(covariance) - model.count
    parts = model.functions.shape[1]
    found = RoadEstimate(
        wheel=wheel,
        records=tuple(track.records.tolist()),
        times=frozen_real(track.times),
        exponent=float(own[0]),
        exponent_std=float(np.sqrt(covariance[cars, cars])),
    )
    if track.speeds is None:
        return found
    # In time the density is ``G(f) = G_d(f / v) / v``, one-sided; the power at a line is ``G / (2 step)``.
    speeds: RealArray = np.exp(track.log_speed)
    ratio, components = np.log(REFERENCE * speeds / REFERENCE_HERTZ), model.departure(np.log([REFERENCE]))[0]
    logarithm = np.log(2 * step * speeds) + levels - own[0] * ratio + components @ own[1 : 1 + parts]
    slope = scores.level_slope.copy()
    slope[:, cars] -= ratio
    slope[:, cars + 1 : cars + 1 + parts] += components
    mean = slope.mean(axis=0)
    of_levels = 1 / scores.level_weight
    return replace(
        found,
        speeds=frozen_real(speeds),
        roughness=frozen_real(np.exp(logarithm)),
        roughness_std=frozen_real(np.sqrt(np.sum((slope @ covariance) * slope, axis=1) + of_levels)),
        mean_roughness=float(np.exp(np.mean(logarithm))),
        mean_roughness_std=float(np.sqrt(mean @ covariance @ mean + np.sum(of_levels) / len(levels) ** 2)),
    )
