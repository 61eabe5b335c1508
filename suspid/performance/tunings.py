"""The result of a tuning: the best compromises between two figures, and the cars that make them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.model import Suspension
from suspid.performance.larger_better import kind_of, small
from suspid.results import Result
from suspid.text_tables import TERMINAL, figures_of, text_table
from suspid.units import Ratio, RealArray
from suspid.values import numbers_in_words
from suspid.words import Verdict


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Tuning(Result):
    """Cars of which none is better in one objective without being worse in the other.

    Parameters
    ----------
    objectives : tuple of str
        The one or two figures that were minimised; adhesion and phase were maximised.
    figures : tuple of str
        These and the figures that were limited.
    units : tuple of str
        Their units.
    values : ndarray (point, figure)
        Figures of each car, the best in the first objective first; means with a margin where the tuning is robust.
    present : ndarray (figure,)
        Figures of the car as it was.
    parameters : tuple of str
        The parameters that were chosen.
    choices : ndarray (point, parameter)
        Their values for each car.
    described : ndarray (parameter,)
        Their values for the car as it was.
    cars : tuple of Suspension
        The cars.
    robust : float
        Standard deviations over what is uncertain that each figure has above its mean; 0: the car is taken as known.
    verdict : Verdict
        How far they can be trusted to be best.

    Examples
    --------
    >>> from suspid import quarter_car, tune
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune(car, parameters=["chassis.damping"], objective=["chassis_acceleration.Wk"], road="C", speed=20.0)
    >>> found.parameters, found.choices.round(-1).tolist()
    (('chassis.damping',), [[580.0]])
    """

    objectives: tuple[str, ...]
    figures: tuple[str, ...]
    units: tuple[str, ...]
    values: RealArray
    present: RealArray
    parameters: tuple[str, ...]
    choices: RealArray
    described: RealArray
    cars: tuple[Suspension, ...]
    robust: Ratio
    verdict: Verdict

    @property
    def knee(self) -> int:
        """Number of the point where the front bends most: farthest below the line between its ends, in logarithms.

        Examples
        --------
        >>> from suspid import quarter_car, tune
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = tune(car, parameters=["chassis.damping"], road="C", speed=20.0, points=5)
        >>> bool(found.cars[found.knee].struts[0].damping == found.choices[found.knee, 0])
        True
        """
        logs = np.log(small(self.objectives, self.values[:, : len(self.objectives)])[0])
        span = np.ptp(logs, axis=0)
        if len(self.objectives) < 2 or not np.all(span > 0):
            return 0
        return int(np.argmin(np.sum((logs - logs.min(axis=0)) / span, axis=1)))

    @property
    def distinct(self) -> tuple[int, ...]:
        """Numbers of `parameters` of which none has the values of an earlier one, as left and right springs have.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Remark, Tuning, Verdict
        >>> from suspid.words.tuning import TuningHeadline
        >>> found = Tuning(
        ...     objectives=("chassis.travel",), figures=("chassis.travel",), units=("m",), values=np.array([[0.02]]),
        ...     present=np.array([0.03]), parameters=("front_left.damping", "front_right.damping", "rear.damping"),
        ...     choices=np.array([[1500.0, 1500.0, 1700.0]]), described=np.array([1300.0, 1300.0, 1400.0]), cars=(),
        ...     robust=0.0, verdict=Verdict(Remark(TuningHeadline.FRONT, {})))
        >>> found.distinct
        (0, 2)
        """
        columns = np.vstack([self.choices, self.described]).T.tolist()
        return tuple(i for i, column in enumerate(columns) if column not in columns[:i])

    def heading(self, figure: int) -> str:
        """Return what a figure is with its unit, such as ``"tire.load [N]"``; of a robust tuning with its margin.

        Examples
        --------
        >>> from suspid import quarter_car, tune
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = tune(car, parameters=["chassis.damping"], road="C", speed=20.0, points=5)
        >>> found.heading(0)
        'chassis_acceleration.Wk [m/s2]'
        """
        sign = "-" if kind_of(self.figures[figure]) else "+"
        margin = f", mean {sign} {self.robust:.3g} sd" if self.robust else ""
        return f"{short(self.figures[figure])}{margin} [{self.units[figure]}]"

    def _table(self) -> Mapping[str, Sequence[object]]:
        chosen = zip(self.parameters, self.choices.T.tolist(), strict=True)
        return {**dict(chosen), **dict(zip(self.figures, self.values.T.tolist(), strict=True))}

    def _brief(self) -> str:
        if not self.cars:
            return str(self.verdict.headline)
        best = self.knee or 0
        return f"{self.verdict.headline}: {numbers_in_words(self.figures, self.values[best].tolist(), self.units)}"

    def __str__(self) -> str:
        knee = self.knee
        labels = [f"{i + 1}{' (knee)' if i == knee and len(self.cars) > 2 else ''}" for i in range(len(self.cars))]
        columns = {"car": [*labels, "now"]}
        for i in self.distinct:
            values = (*self.choices[:, i].tolist(), float(self.described[i]))
            columns[self.parameters[i]] = [figures_of(value) for value in values]
        for k, (column, now) in enumerate(zip(self.values.T.tolist(), self.present.tolist(), strict=True)):
            columns[self.heading(k)] = [figures_of(value) for value in (*column, now)]
        return f"{text_table(columns, widest=TERMINAL)}\n{self._same()}{self.verdict}"

    def _same(self) -> str:
        """Return the line that names the parameters whose values are those of a column."""
        rows = np.vstack([self.choices, self.described]).T.tolist()
        firsts = [rows.index(row) for row in rows]
        pairs = [(name, self.parameters[i]) for k, (name, i) in enumerate(zip(self.parameters, firsts, strict=True))
                 if i < k]  # fmt: skip
        same = ", ".join(f"{name} as {first}" for name, first in pairs)
        return f"The same values: {same}\n" if same else ""


def short(name: str) -> str:
    """Return the name of a figure for a heading: of many that are joined the first and the last.

    Examples
    --------
    >>> short("a.load + b.load + c.load")
    'a.load + … + c.load'
    """
    parts = name.split(" + ")
    return name if len(parts) < 3 else f"{parts[0]} + … + {parts[-1]}"
