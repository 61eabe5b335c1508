"""Class of a measured road after ISO 8608, with its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.levels import LEVEL, check_level, normal_reach
from suspid.results import Result
from suspid.simulation import ROUGHNESS, road_class
from suspid.text_tables import spread, text_table
from suspid.units import Metre, Ratio, RealArray
from suspid.values import FrozenMapping
from suspid.words import Verdict

# Upper limits of G_d(0.1 cycle/m) of the classes [m3], ISO 8608, table C.1 as publications quote it; H has none.
ROAD_LIMITS: Mapping[str, float] = FrozenMapping(
    {name: 2 * mean if name != "H" else np.inf for name, mean in ROUGHNESS.items()}
)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class RoadClass(Result):
    """Level and exponent of a road's spectrum, with their uncertainty, and its class.

    Parameters
    ----------
    roughness : float
        G_d(0.1 cycle/m) [m3].
    exponent : float
        Exponent w of ``G_d(n) = G_d(n_0) (n / n_0)^-w`` [1].
    covariance : ndarray (2, 2)
        Joint covariance of the logarithm of the roughness and of the exponent.
    wavelengths : tuple of float
        Shortest and longest wavelength that was used [m].
    verdict : Verdict
        The class and how sure it is.

    Examples
    --------
    >>> from suspid import classify_road, road
    >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
    >>> found = classify_road(heights, speed=20.0)
    >>> found.name, max(found.shares, key=found.shares.get)
    ('B', 'B')
    """

    roughness: float
    exponent: float
    covariance: RealArray
    wavelengths: tuple[Metre, Metre]
    verdict: Verdict

    @property
    def name(self) -> str:
        """Class ``"A"`` to ``"H"``.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import classify_road, road
        >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
        >>> found = classify_road(heights, speed=20.0)
        >>> found.name
        'B'
        """
        return road_class(self.roughness)

    @property
    def shares(self) -> dict[str, float]:
        """Probability of each class.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import classify_road, road
        >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
        >>> found = classify_road(heights, speed=20.0)
        >>> round(sum(found.shares.values()), 6)
        1.0
        """
        return class_shares(self.roughness, float(np.sqrt(self.covariance[0, 0])))

    def interval(self, level: Ratio = LEVEL) -> dict[str, tuple[float, float]]:
        """Return the ends between which roughness and exponent lie with probability ``level``.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import classify_road, road
        >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
        >>> found = classify_road(heights, speed=20.0)
        >>> low, high = found.interval(0.95)["roughness"]
        >>> bool(low < 64e-6 < high)
        True
        """
        check_level(level)
        reach = normal_reach(level) * np.sqrt(np.diag(self.covariance))
        factor = float(np.exp(reach[0]))
        return {
            "roughness": (self.roughness / factor, self.roughness * factor),
            "exponent": (self.exponent - float(reach[1]), self.exponent + float(reach[1])),
        }

    def _table(self) -> Mapping[str, Sequence[object]]:
        ends = self.interval()
        return {
            "name": ["roughness", "exponent"],
            "unit": ["m3", "1"],
            "value": [self.roughness, self.exponent],
            "lower": [ends["roughness"][0], ends["exponent"][0]],
            "upper": [ends["roughness"][1], ends["exponent"][1]],
        }

    def _brief(self) -> str:
        return str(self.verdict.headline)

    def __str__(self) -> str:
        stds = np.sqrt(np.diag(self.covariance)) * [1e6 * self.roughness, 1.0]
        rows = {
            "road": ["G_d(0.1 cycle/m)", "exponent"],
            "unit": ["1e-6 m3", "1"],
            "found": [f"{1e6 * self.roughness:.4g}", f"{self.exponent:.3f}"],
            "±": [spread(std) for std in stds.tolist()],
        }
        return f"{text_table(rows)}\n{self.verdict}"


def class_shares(roughness: float, std: float) -> dict[str, float]:
    """Return the probability of each class where the logarithm of the roughness has a standard deviation."""
    from scipy.special import ndtr

    with np.errstate(divide="ignore"):
        ends = ndtr((np.log(list(ROAD_LIMITS.values())) - np.log(roughness)) / max(std, 1e-300))
    return dict(zip(ROAD_LIMITS, np.diff(ends, prepend=0.0).tolist(), strict=True))
