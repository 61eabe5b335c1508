"""What `tune_active` found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from suspid.results import Result
from suspid.units import RealArray
from suspid.values import numbers_in_words, text_table
from suspid.words import Verdict

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class ActiveTuning(Result):
    """A state feedback and what it does on the road.

    Parameters
    ----------
    gain : ndarray (state,)
        The force is ``-gain @ state`` [N]; states are those of `statespace`, displacements above the road.
    states : tuple of str
        Their names.
    rms : mapping of str to float
        Root mean square of each output that was asked for, in its unit, and of the force [N].
    passive : mapping of str to float
        The same without the force.
    cost : float
        Sum of squares of the objectives over their scales.
    bound : float
        What no state feedback can fall below, by the convex program.
    closed : control.StateSpace
        The car with its feedback, from the road's slope in time [m/s] to the outputs and the force.
    verdict : Verdict
        How near the cost is to its bound, and whether an actuator can do it.

    Examples
    --------
    >>> from suspid import quarter_car, tune_active
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune_active(car, actuator="chassis_travel", road="C", speed=20.0,
    ...                     objective={"chassis_acceleration": 1.0, "tire_travel": 0.004})
    >>> found.states, found.gain.shape
    (('z_chassis', 'z_tire', 'v_chassis', 'v_tire'), (4,))
    """

    gain: RealArray
    states: tuple[str, ...]
    rms: Mapping[str, float]
    passive: Mapping[str, float]
    cost: float
    bound: float
    closed: control.StateSpace
    verdict: Verdict

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {"output": list(self.rms), "passive": list(self.passive.values()), "active": list(self.rms.values())}

    def _brief(self) -> str:
        return f"rms {numbers_in_words(list(self.rms), self.rms.values())}"

    def __str__(self) -> str:
        names = list(self.rms)
        table = {
            "rms of": names,
            "passive": [f"{self.passive[name]:.4g}" for name in names],
            "active": [f"{self.rms[name]:.4g}" for name in names],
        }
        gains = {"state": list(self.states), "gain": [f"{value:.6g}" for value in self.gain.tolist()]}
        return f"{text_table(table)}\n{text_table(gains)}\n{self.verdict}"
