"""The result of an estimate: springs, dampers and masses with their uncertainty, and what they leave of the records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from suspid.greybox.roads import RoadEstimate
from suspid.greybox.within_bounds import ends_within
from suspid.levels import LEVEL, beyond_chance, check_level, normal_reach
from suspid.model import ModalSet, Suspension
from suspid.results import Result
from suspid.signals import as_signal
from suspid.units import UNITS, Flags, Hertz, Ratio, RealArray
from suspid.values import numbers_in_words, rounded, spread, text_table
from suspid.words import Verdict

if TYPE_CHECKING:
    import control

# Parameters that are positive and have intervals of a ratio; the others may be zero.
POSITIVE = ("stiffness", "mass", "gain")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Estimate(Result):
    """The suspension that explains the records best, with all that is needed to check it.

    Parameters
    ----------
    suspension : Suspension
        Springs, dampers and masses found.
    nominal : Suspension
        The suspension that was given: the start, and the values of fixed parameters.
    parameters : tuple of str
        The parameters found, such as ``"tire.stiffness"``; gains, delays and relaxations follow those of the car.
    values : ndarray (parameter,)
        Their values, in SI units.
    covariance : ndarray (parameter, parameter)
        Their joint covariance, in their units squared, to first order.
    unbounded : ndarray (parameter,)
        Their values of least misfit if there were no bounds, to first order: `values` where none is at a bound.
    ranges : ndarray (parameter, 2)
        Their bounds.
    held : tuple of str
        The strut parameters fixed at their nominal values.
    modes : ModalSet
        Modes of `suspension` with the covariance of the parameters carried through; where the motion of wheels was
        given, those with these wheels fixed in place, unless a model of the road was used.
    fitted : tuple of control.TimeResponseData
        Motion of each record as the suspension explains it, with known roads and forces as inputs.
    residual : tuple of control.TimeResponseData
        Each record less `fitted`.
    noise_std : tuple of ndarray (channel,)
        Standard deviation of the noise of each record, in the units of its channels.
    chi_square : float
        Statistic of the test that the residual is noise.
    freedom : int
        Its degrees of freedom; 0 where nothing was tested, because the residual is rounding.
    explains : bool
        Whether chi-square is not improbably large.
    alternatives : tuple of Suspension
        Other suspensions found that explain the records as well.
    verdict : Verdict
        How far the result can be trusted, and why.
    road : tuple of RoadEstimate
        The road under each wheel, by logger, where a model of it was used.
    causes : tuple of tuple of str
        What moved the car in each record: inputs of `fitted`, or its channels that show given motion alone; empty for
        a free decay.
    band_hz : tuple of float or None
        Frequencies that `fitted` and `residual` contain, where motion was given [Hz]; None: all.

    Examples
    --------
    >>> from suspid import add_noise, estimate, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 2, 0.01), initial_state={"v_tire": 1.0})
    >>> found = estimate(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
    >>> found.parameters, found.explains
    (('chassis.stiffness', 'tire.stiffness', 'chassis.damping'), True)
    >>> low, high = found.interval(0.99)["chassis.damping"]
    >>> bool(low < 1500 < high), len(found.modes)
    (True, 2)
    """

    suspension: Suspension
    nominal: Suspension
    parameters: tuple[str, ...]
    values: RealArray
    covariance: RealArray
    unbounded: RealArray
    ranges: RealArray
    held: tuple[str, ...]
    modes: ModalSet
    fitted: tuple[control.TimeResponseData, ...]
    residual: tuple[control.TimeResponseData, ...]
    noise_std: tuple[RealArray, ...]
    chi_square: float
    freedom: int
    explains: bool
    alternatives: tuple[Suspension, ...]
    verdict: Verdict
    road: tuple[RoadEstimate, ...] = ()
    causes: tuple[tuple[str, ...], ...] = ()
    band_hz: tuple[Hertz, Hertz] | None = None

    @property
    def std(self) -> RealArray:
        """Standard deviations of `values`, (parameter,).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import add_noise, estimate, free_decay, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> record = free_decay(car, np.arange(0, 3, 0.01), initial_state={"v_tire": 1.0})
        >>> found = estimate(add_noise(record, snr_db=40.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
        >>> found.std.shape == (len(found.parameters),), bool(np.all(found.std > 0))
        (True, True)
        """
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def whiteness(self) -> tuple[RealArray, ...]:
        """Correlation of the residual of each channel of each record with itself one sample later [1]; 0 for white.

        Residuals of records with given wheels contain one band only, so they are not white; `explains` judges them.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import add_noise, estimate, free_decay, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> record = free_decay(car, np.arange(0, 2, 0.01), initial_state={"v_tire": 1.0})
        >>> found = estimate(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
        >>> bool(np.all(abs(found.whiteness[0]) < 0.3))
        True
        """
        return tuple(_lag_one(as_signal(response).values) for response in self.residual)

    def interval(self, level: Ratio = LEVEL) -> dict[str, tuple[float, float]]:
        """Return the ends between which each of `parameters` lies with probability ``level``, within all bounds.

        Those of stiffnesses, masses and gains are symmetric in the logarithm, except where any parameter is near a
        bound: what lies beyond it, such as a mount stiffer than a rigid one, is no car.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import add_noise, estimate, free_decay, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> record = free_decay(car, np.arange(0, 3, 0.01), initial_state={"v_tire": 1.0})
        >>> found = estimate(add_noise(record, snr_db=40.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
        >>> low, high = found.interval(0.99)["tire.stiffness"]
        >>> low < 200e3 < high
        True
        """
        check_level(level)
        low, high = _ends(self._spread, level)
        return {name: (float(a), float(b)) for name, a, b in zip(self.parameters, low, high, strict=True)}

    def beyond_chance(self, level: Ratio = LEVEL) -> frozenset[str]:
        """Return which parameters differ from nominal: none of them by chance, with probability ``level``.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import add_noise, estimate, free_decay, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> record = free_decay(car, np.arange(0, 3, 0.01), initial_state={"v_tire": 1.0})
        >>> found = estimate(add_noise(record, snr_db=40.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
        >>> sorted(found.beyond_chance())
        []
        """
        return changed(self.nominal, self._spread, level)

    @property
    def _spread(self) -> Spread:
        return Spread(self.parameters, self.values, self.covariance, self.unbounded, self.ranges, self.explains)

    def _table(self) -> Mapping[str, Sequence[object]]:
        ends = self.interval()
        return {
            "parameter": self.parameters,
            "value": self.values.tolist(),
            "std": self.std.tolist(),
            "lower": [ends[name][0] for name in self.parameters],
            "upper": [ends[name][1] for name in self.parameters],
            "nominal": [nominal_value(self.nominal, name) for name in self.parameters],
            "unit": [parameter_unit(name) for name in self.parameters],
        }

    def _brief(self) -> str:
        units = [parameter_unit(name) for name in self.parameters]
        return numbers_in_words(self.parameters, self.values.tolist(), units)

    def __str__(self) -> str:
        return "\n".join([parameter_table(self), *(str(part) for part in (self.modes, *self.road, self.verdict))])

    def details(self) -> str:
        """Return everything as text: the tables of `str`, and one of the channels of every record.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import add_noise, estimate, free_decay, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> record = free_decay(car, np.arange(0, 2, 0.01), initial_state={"v_tire": 1.0})
        >>> found = estimate(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
        >>> len(found.details()) > len(str(found))
        True
        """
        return f"{self}\n{channel_table(self)}"


def ends_of(parameters: Sequence[str], values: RealArray, std: RealArray, level: Ratio) -> tuple[RealArray, RealArray]:
    """Return the ends of the intervals of parameters, before any bounds."""
    reach = normal_reach(level) * std
    ratio = _of_ratio(parameters, values)
    with np.errstate(divide="ignore", over="ignore"):
        factor = np.exp(np.where(ratio, reach / np.where(values > 0, values, 1.0), 0.0))
    return np.where(ratio, values / factor, values - reach), np.where(ratio, values * factor, values + reach)


def _of_ratio(parameters: Sequence[str], values: RealArray) -> Flags:
    """Return which parameters have intervals of a ratio."""
    return np.array([name.rpartition(".")[2] in POSITIVE for name in parameters], bool) & (values > 0)


class Spread(NamedTuple):
    """Parameters and how far they are known."""

    parameters: Sequence[str]
    values: RealArray
    covariance: RealArray
    unbounded: RealArray  # values of least misfit without bounds
    ranges: RealArray  # (parameter, 2)
    explained: bool  # else the covariance is of what the car lacks, and no likelihood tells what bounds exclude


def _ends(found: Spread, level: Ratio) -> list[RealArray]:
    """Return the lower and upper ends of the intervals of parameters within their bounds."""
    values, reach = found.values, normal_reach(level)
    if not found.explained:
        plain = ends_of(found.parameters, values, np.sqrt(np.diag(found.covariance)), level)
        return [np.clip(end, found.ranges[:, 0], found.ranges[:, 1]) for end in plain]
    ratio = _of_ratio(found.parameters, values)
    size = np.where(ratio, values, 1.0)
    with np.errstate(divide="ignore", over="ignore"):
        bounds = [np.where(ratio, np.log(np.maximum(end, 0.0) / size), end - values) for end in found.ranges.T]
        ends = ends_within(
            (found.unbounded - values) / size, found.covariance / np.outer(size, size), bounds[0], bounds[1], reach
        )
        whole = [np.where(ratio, values * np.exp(np.where(ratio, end, 0.0)), values + end) for end in ends]
    return [np.clip(end, found.ranges[:, 0], found.ranges[:, 1]) for end in whole]


def changed(nominal: Suspension, found: Spread, level: Ratio = LEVEL) -> frozenset[str]:
    """Return which parameters differ from nominal: none of them by chance, with probability ``level``."""
    every = {name: nominal_value(nominal, name) for name in found.parameters}
    count = sum(value is not None for value in every.values())

    def outside(level: Ratio) -> list[str]:
        low, high = _ends(found, level)
        rows = zip(every.items(), low, high, strict=True)
        return [name for (name, old), a, b in rows if old is not None and not a <= old <= b]

    return beyond_chance(outside, count, level)


# What quantities are that no table of springs and dampers has.
EXPLAINED = {
    "relaxation": "damping over stiffness of the mount, 0 of a rigid one",
    "gain": "of a sensor over what it should show",
    "delay": "of a sensor behind the others",
}


def parameter_unit(name: str) -> str:
    """Return the unit of a parameter, such as N/m of ``"tire.stiffness"``."""
    return UNITS[name.rpartition(".")[2]]


def nominal_value(car: Suspension, name: str) -> float | None:
    """Return the nominal value of a parameter of the car; None for one of a channel."""
    owner, _, quantity = name.rpartition(".")
    if quantity == "mass":
        return car.masses[owner]
    return next((float(getattr(s, quantity)) for s in car.struts if s.name == owner and hasattr(s, quantity)), None)


def parameter_table(found: Estimate) -> str:
    """Return the table of all parameters, beside nominal."""
    nominal = [nominal_value(found.nominal, name) for name in found.parameters]
    apart = found.beyond_chance()
    rows: dict[str, list[str]] = {
        "parameter": list(found.parameters),
        "unit": [parameter_unit(name) for name in found.parameters],
        "found": rounded(found.values, found.std),
        "±": [spread(std) for std in found.std],
        "nominal": ["" if value is None else f"{value:.6g}" for value in nominal],
        "change": [
            "" if not old else f"{100 * (new / old - 1):+.1f} %" for new, old in zip(found.values, nominal, strict=True)
        ],
        "significant": [
            "" if old is None else "yes" if name in apart else "no"
            for name, old in zip(found.parameters, nominal, strict=True)
        ],
    }
    held = f"\nheld: {', '.join(found.held)}" if found.held else ""
    meant = quantities_in(found.parameters)
    return text_table(rows) + held + (f"\n{meant}" if meant else "")


def quantities_in(parameters: Sequence[str]) -> str:
    """Return what the quantities are among parameters that are no spring, damper or mass; empty if there is none.

    Examples
    --------
    >>> quantities_in(["chassis.stiffness", "chassis.relaxation", "tire_acceleration.delay"])
    'relaxation: damping over stiffness of the mount, 0 of a rigid one; delay: of a sensor behind the others.'
    >>> quantities_in(["chassis.stiffness"])
    ''
    """
    there = {name.rpartition(".")[2] for name in parameters}
    said = "; ".join(f"{quantity}: {meant}" for quantity, meant in EXPLAINED.items() if quantity in there)
    return f"{said}." if said else ""


def channel_table(found: Estimate) -> str:
    """Return the table of the channels of all records: noise and whiteness."""
    rows: dict[str, list[str]] = {"record": [], "channel": [], "noise std": [], "lag-1 correlation": []}
    for i, (response, noise, white) in enumerate(zip(found.residual, found.noise_std, found.whiteness, strict=True)):
        for channel, std, correlation in zip(as_signal(response).channels, noise, white, strict=True):
            for column, cell in zip(
                rows.values(), (str(i + 1), channel, f"{std:.3g}", f"{correlation:+.2f}"), strict=True
            ):
                column.append(cell)
    return text_table(rows)


def _lag_one(residual: RealArray) -> RealArray:
    power = np.einsum("ck,ck->c", residual, residual)
    products = np.einsum("ck,ck->c", residual[:, 1:], residual[:, :-1])
    return np.asarray(products / np.where(power > 0, power, 1.0))
