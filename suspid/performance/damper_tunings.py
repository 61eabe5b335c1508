"""The result of tuning a damper: its curve, and the figures on each road."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.model import Strut, Suspension
from suspid.results import Result
from suspid.simulation import Road
from suspid.text_tables import TERMINAL, figures_of, text_table
from suspid.units import NewtonSecondPerMetre, RealArray
from suspid.words import Verdict


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class DamperTuning(Result):
    """A damper's curve for several roads.

    Parameters
    ----------
    strut : Strut
        The strut with its curve; its ``damping`` is the mean over the roads of the rates of equal work.
    car : Suspension
        The car as it was.
    roads : tuple of Road
        The roads.
    figures : tuple of str
        The objective, then the figures that were limited.
    units : tuple of str
        Their units.
    asked : ndarray (road,)
        The best damper rate for each road alone [N s/m].
    damping : ndarray (road,)
        The damper rate of equal work of the curve on each road [N s/m].
    velocity : ndarray (road,)
        Rms velocity of the damper on each road [m/s].
    values : ndarray (road, figure)
        Figures with the curve, by its damper rate of equal work.
    best : ndarray (road, figure)
        Figures with the best damper rate for each road alone.
    single : float or None
        The best single damper rate for all roads [N s/m]; None if no rate meets the limits on all of them.
    single_values : ndarray (road, figure)
        Figures with that; empty without one.
    verdict : Verdict
        How near the curve comes to what the roads ask for.

    Examples
    --------
    >>> from suspid import quarter_car, tune_damper
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune_damper(car, strut="chassis", roads=[("A", 30.0), ("D", 14.0)],
    ...                     objective="chassis_acceleration.Wk", constraints={"chassis.travel": 0.018})
    >>> found.strut.name, found.strut.linear, bool(found.asked[1] > found.asked[0])
    ('chassis', False, True)
    """

    strut: Strut
    car: Suspension
    roads: tuple[Road, ...]
    figures: tuple[str, ...]
    units: tuple[str, ...]
    asked: RealArray
    damping: RealArray
    velocity: RealArray
    values: RealArray
    best: RealArray
    single: NewtonSecondPerMetre | None
    single_values: RealArray
    verdict: Verdict

    @property
    def tuned(self) -> Suspension:
        """The car with the curve, to be simulated.

        Examples
        --------
        >>> from dataclasses import replace
        >>> import numpy as np
        >>> from suspid import Remark, Verdict, quarter_car, road
        >>> from suspid.performance import DamperTuning
        >>> from suspid.words.tuning import DamperTuningHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> one = np.array([1300.0])
        >>> found = DamperTuning(
        ...     strut=replace(car.struts[0], damping=0.0, curve=((-1.0, -900.0), (0.0, 0.0), (1.0, 1500.0))), car=car,
        ...     roads=(road("C", speed=20.0),), figures=("chassis_acceleration.Wk",), units=("m/s2",), asked=one,
        ...     damping=one, velocity=np.array([0.2]), values=np.array([[0.9]]), best=np.array([[0.85]]), single=1250.0,
        ...     single_values=np.array([[1.0]]), verdict=Verdict(Remark(DamperTuningHeadline.CURVE, {})))
        >>> found.tuned.struts[0].curve, found.car.struts[0].curve
        (((-1.0, -900.0), (0.0, 0.0), (1.0, 1500.0)), None)
        """
        struts = tuple(self.strut if one.name == self.strut.name else one for one in self.car.struts)
        return replace(self.car, struts=struts)

    def _table(self) -> Mapping[str, Sequence[object]]:
        columns: dict[str, Sequence[object]] = {
            "roughness_m3": [one.roughness for one in self.roads],
            "speed_m_per_s": [one.speed for one in self.roads],
            "asked_n_s_per_m": self.asked.tolist(),
            "damping_n_s_per_m": self.damping.tolist(),
            "velocity_m_per_s": self.velocity.tolist(),
        }
        return columns | dict(zip(self.figures, self.values.T.tolist(), strict=True))

    def _brief(self) -> str:
        return str(self.verdict.headline)

    def __str__(self) -> str:
        columns = {
            "road [1e-6 m3]": [figures_of(1e6 * one.roughness) for one in self.roads],
            "speed [m/s]": [figures_of(one.speed) for one in self.roads],
            "asked for [N s/m]": [figures_of(one) for one in self.asked.tolist()],
            "curve [N s/m]": [figures_of(one) for one in self.damping.tolist()],
        }
        for k, (name, unit) in enumerate(zip(self.figures, self.units, strict=True)):
            columns[f"{name} [{unit}]"] = [figures_of(one) for one in self.values[:, k].tolist()]
        if self.single is not None:
            heading = f"{self.figures[0]}, one rate, {figures_of(self.single)} N s/m [{self.units[0]}]"
            columns[heading] = [figures_of(one) for one in self.single_values[:, 0].tolist()]
        points = self.strut.curve or ()
        curve = {"velocity [m/s]": [f"{v:.3g}" for v, _ in points], "force [N]": [figures_of(f) for _, f in points]}
        return f"{text_table(columns, widest=TERMINAL)}\n\n{text_table(curve)}\n{self.verdict}"

    @property
    def gain(self) -> RealArray:
        """Share of the objective that the curve saves on each road over the best single rate; NaN without one.

        Examples
        --------
        >>> from dataclasses import replace
        >>> import numpy as np
        >>> from suspid import Remark, Verdict, quarter_car, road
        >>> from suspid.performance import DamperTuning
        >>> from suspid.words.tuning import DamperTuningHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> one = np.array([1300.0])
        >>> found = DamperTuning(
        ...     strut=replace(car.struts[0], damping=0.0, curve=((-1.0, -900.0), (0.0, 0.0), (1.0, 1500.0))), car=car,
        ...     roads=(road("C", speed=20.0),), figures=("chassis_acceleration.Wk",), units=("m/s2",), asked=one,
        ...     damping=one, velocity=np.array([0.2]), values=np.array([[0.9]]), best=np.array([[0.85]]), single=1250.0,
        ...     single_values=np.array([[1.0]]), verdict=Verdict(Remark(DamperTuningHeadline.CURVE, {})))
        >>> found.gain
        array([0.1])
        """
        if self.single is None:
            return np.full(len(self.roads), np.nan)
        return np.asarray(1 - self.values[:, 0] / self.single_values[:, 0])
