"""The ride of a car or of a record: its figures with their uncertainty, and the spectra behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import InputError
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.performance.density_bands import density_bands
from suspid.performance.reaches import reaches, spreads
from suspid.performance.uncertain import Uncertain
from suspid.results import Result
from suspid.simulation import Road
from suspid.text_tables import TERMINAL, text_table, value_columns
from suspid.units import Ratio, RealArray, Second
from suspid.values import nearest_names, numbers_in_words
from suspid.words import Verdict


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Ride(Result):
    """Comfort, travel and wheel load of a car on a road, or of a record.

    Parameters
    ----------
    figures : tuple of str
        Names, such as ``"chassis_acceleration.rms"``, ``"….Wk"`` (weighted rms), ``"….VDV"``, ``"….MSDV"``,
        ``"….crest"``, ``"chassis.travel"`` (rms), ``"chassis.peak_travel"``, ``"tire.load"`` (rms of the dynamic load),
        ``"tire.load_share"`` (of the static one) and ``"tire.lifts"`` (probability of loss of contact).
    values : ndarray (figure,)
        Their values.
    units : tuple of str
        Their units.
    duration : float
        Time over which doses are taken and peaks expected [s].
    parameters : tuple of str
        The uncertain parameters of the car.
    jacobian : ndarray (figure, parameter)
        Exact derivatives of the figures by these, in SI units.
    bends : ndarray (figure, parameter, parameter)
        Second derivatives by parameters whose interval reaches zero; 0 for others.
    parameter_values : ndarray (parameter,)
        Their values; none of them can be negative.
    covariance : ndarray (parameter, parameter)
        Joint covariance of the parameters.
    scatter : ndarray (figure,)
        Standard deviation over other records of the same length, of the figures of a record, widened by what the record
        leaves open of it; NaN where unknown, and 0 for those of a car, which are exact expected values.
    hertz : ndarray (frequency,)
        Frequencies of the spectra [Hz].
    channels : tuple of str
        The accelerations.
    density : ndarray (channel, frequency)
        Spectral density of each, not weighted [m2/s4/Hz or rad2/s4/Hz].
    density_band : ndarray (channel, frequency)
        Standard deviations of these: of the car's parameters to first order, and of a record those of Welch's method by
        the number of its segments; 0 for a car that is known. `density_interval` has the ends of intervals.
    weightings : mapping of str to tuple of str
        Weightings of each channel, the first that of comfort.
    road : Road or None
        The road under a car; None of a record.
    about : Uncertain or None
        The car with what is not known of it; None of a record.
    verdict : Verdict
        What the figures mean and how far they can be trusted.

    Examples
    --------
    >>> from suspid import quarter_car, ride
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300, tire_damping=60)
    >>> found = ride(car, road="C", speed=20.0)
    >>> round(found["chassis_acceleration.Wk"], 3), found.duration, found.channels
    (1.066, 3600.0, ('chassis_acceleration',))
    """

    figures: tuple[str, ...]
    values: RealArray
    units: tuple[str, ...]
    duration: Second
    parameters: tuple[str, ...]
    jacobian: RealArray
    bends: RealArray
    parameter_values: RealArray
    covariance: RealArray
    scatter: RealArray
    hertz: RealArray
    channels: tuple[str, ...]
    density: RealArray
    density_band: RealArray
    weightings: Mapping[str, tuple[str, ...]]
    road: Road | None
    about: Uncertain | None
    verdict: Verdict

    def __getitem__(self, figure: str) -> float:
        """Return the value of a figure."""
        if figure not in self.figures:
            raise InputError(f"there is no figure {figure!r}.{nearest_names(str(figure), self.figures)}")
        return float(self.values[self.figures.index(figure)])

    @property
    def std(self) -> RealArray:
        """Standard deviations of `values`, (figure,): of the car's parameters and of the scatter of a record.

        Those of the parameters are half the width of the 95 % interval over 1.96.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import quarter_car, ride
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300, tire_damping=60)
        >>> found = ride(car, road="C", speed=20.0, nominal_std=0.05)
        >>> rms = found.figures.index("chassis_acceleration.rms")
        >>> bool(0 < found.std[rms] < 0.1 * found.values[rms])
        True
        """
        by_car = spreads(self.jacobian.T, self.covariance, self.parameter_values, self.bends)
        return np.asarray(np.hypot(by_car, self.scatter))

    def interval(self, level: Ratio = LEVEL) -> dict[str, tuple[float, float]]:
        """Return the ends between which each figure lies with probability ``level``.

        Those of a car are by the logarithm, and no car with a negative spring, damper or relaxation of a mount counts;
        those of a record are by the chi-square of a mean square.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import quarter_car, ride
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300, tire_damping=60)
        >>> found = ride(car, road="C", speed=20.0, nominal_std=0.05)
        >>> low, high = found.interval(0.95)["chassis_acceleration.Wk"]
        >>> bool(low < found["chassis_acceleration.Wk"] < high)
        True
        """
        check_level(level)
        reach = normal_reach(level)
        reached = reaches(self.jacobian.T, self.covariance, self.parameter_values, reach, self.bends)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            down, up = (np.exp(np.where(self.values > 0, by_car / self.values, 0.0)) for by_car in reached)
            by_chance = _roots_of_chi_square(np.where(self.values > 0, self.scatter / self.values, 0.0), level)
        down, up = down / by_chance[0], up * by_chance[1]
        top = np.where([name.endswith(".lifts") for name in self.figures], 1.0, np.inf)
        low, high = self.values / down, np.minimum(self.values * up, top)
        return {name: (float(a), float(b)) for name, a, b in zip(self.figures, low, high, strict=True)}

    def density_interval(self, level: Ratio = LEVEL) -> tuple[RealArray, RealArray]:
        """Return the ends between which `density` lies with probability ``level`` at each frequency.

        Those of a car are by the spectra of cars that may be the true one, `suspid.performance.density_bands`; those of
        a record are by chi-square.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import quarter_car, ride
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300, tire_damping=60)
        >>> found = ride(car, road="C", speed=20.0, nominal_std=0.05)
        >>> low, high = found.density_interval(0.95)
        >>> bool(np.all((low <= found.density) & (found.density <= high)))
        True
        """
        check_level(level)
        if self.about is None or self.road is None:
            return power_ends(self.density, self.density_band, level)
        low, high = density_bands(self.about, self.channels, self.road, self.hertz, level)
        return self.density * low, self.density * high

    def _table(self) -> Mapping[str, Sequence[object]]:
        ends = self.interval()
        return {
            "figure": self.figures,
            "unit": self.units,
            "value": self.values.tolist(),
            "std": self.std.tolist(),
            "lower": [ends[name][0] for name in self.figures],
            "upper": [ends[name][1] for name in self.figures],
        }

    def _brief(self) -> str:
        return numbers_in_words(self.figures, self.values.tolist(), self.units)

    def __str__(self) -> str:
        rows = {"figure": list(self.figures), "unit": list(self.units), **value_columns(self.values, self.std)}
        return f"{text_table(rows, widest=TERMINAL)}\n{self.verdict}"


def power_ends(power: RealArray, std: RealArray, level: Ratio) -> tuple[RealArray, RealArray]:
    """Return the ends of mean squares that vary as chi-square does, with given standard deviations.

    Examples
    --------
    One line of a periodogram varies by its expected value, and 95 % lie between 0.0253 and 3.69 times that:

    >>> low, high = power_ends(np.array([1.0]), np.array([1.0]), 0.95)
    >>> (1 / high).round(4).tolist(), (1 / low).round(2).tolist()
    ([0.0253], [3.69])
    """
    low, high = _roots_of_chi_square(np.divide(std, 2 * power, out=np.zeros_like(power), where=power > 0), level)
    return power * low**2, power * high**2


def _roots_of_chi_square(spread: RealArray, level: Ratio) -> tuple[RealArray, RealArray]:
    """Return the ends of roots of mean squares over their values, by the relative standard deviations of the roots.

    A root of a chi-square over its degrees of freedom n varies by ``(2 n)^(-1/2)``.
    """
    from scipy.special import chdtri

    found = spread > 0
    freedom = np.where(found, 0.5 / np.where(found, spread, 1.0) ** 2, 1.0)
    low, high = (np.sqrt(freedom / chdtri(freedom, (1 + side * level) / 2)) for side in (-1, 1))
    # A figure without scatter is a known one; that of an unknown scatter is not known.
    known = np.where(np.isnan(spread), np.nan, 1.0)
    return np.where(found, low, known), np.where(found, high, known)
