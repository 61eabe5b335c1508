"""The result of an estimate: springs, dampers and masses with their uncertainty, and the residual."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.greybox.estimate_tables import channel_table, parameter_table, parameter_unit
from suspid.greybox.parameter_ends import Spread, bounded_ends, changed
from suspid.greybox.roads import RoadEstimate
from suspid.identification import lag_one
from suspid.levels import LEVEL, check_level
from suspid.model import ModalSet, Suspension, value_in
from suspid.results import Result
from suspid.signals import as_signal
from suspid.units import Hertz, Ratio, RealArray
from suspid.values import numbers_in_words
from suspid.words import Verdict

if TYPE_CHECKING:
    import control


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
        return tuple(lag_one(as_signal(response).values) for response in self.residual)

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
        low, high = bounded_ends(self._spread, level)
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
            "nominal": [value_in(self.nominal, name) for name in self.parameters],
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
