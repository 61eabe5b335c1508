"""Result of `tune_active`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from suspid.performance.figure_plan import ANGLES
from suspid.results import Result
from suspid.text_tables import TERMINAL, figures_of, text_table
from suspid.units import RealArray
from suspid.values import numbers_in_words
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
        return {
            "output": list(self.rms),
            "unit": [_unit_of(name) for name in self.rms],
            "passive": [self.passive[name] for name in self.rms],
            "active": list(self.rms.values()),
        }

    def _brief(self) -> str:
        return f"rms {numbers_in_words(list(self.rms), self.rms.values())}"

    def __str__(self) -> str:
        names = list(self.rms)
        table = {
            "rms of": names,
            "unit": [_unit_of(name) for name in names],
            "passive": [figures_of(self.passive[name]) for name in names],
            "active": [figures_of(self.rms[name]) for name in names],
        }
        gains = {
            "state": list(self.states),
            "unit": [_unit_of_gain(name) for name in self.states],
            "gain": [figures_of(value, 6) for value in self.gain.tolist()],
        }
        return f"{text_table(table, widest=TERMINAL)}\n\n{text_table(gains, widest=TERMINAL)}\n{self.verdict}"


def _unit_of(output: str) -> str:
    """Return the unit of an output by its name; nothing for that of a sensor whose name does not tell.

    Examples
    --------
    >>> _unit_of("pitch_acceleration"), _unit_of("chassis_travel"), _unit_of("force"), _unit_of("sensor 1")
    ('rad/s2', 'm', 'N', '')
    """
    part, _, what = output.rpartition("_")
    turn = "rad" if part in ANGLES else "m"
    return {"acceleration": f"{turn}/s2", "velocity": f"{turn}/s", "travel": "m"}.get(what, "N" * (output == "force"))


def _unit_of_gain(state: str) -> str:
    """Return the unit of the gain of a state: force by displacement or velocity.

    Examples
    --------
    >>> _unit_of_gain("z_chassis"), _unit_of_gain("v_pitch")
    ('N/m', 'N s/rad')
    """
    kind, _, coordinate = state.partition("_")
    turn = "rad" if coordinate in ANGLES else "m"
    return {"z": f"N/{turn}", "v": f"N s/{turn}"}.get(kind, "")
