"""The grip of wheels on a test bench: adhesion after EUSAMA, least phase after EGEA, with their uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from suspid.levels import LEVEL, check_level, normal_reach
from suspid.performance.reaches import reaches, spreads
from suspid.results import Result
from suspid.text_tables import TERMINAL, rounded, spread, text_table
from suspid.units import Ratio, RealArray
from suspid.values import numbers_in_words
from suspid.words import Verdict

# EUSAMA's classes: least adhesion of each [1], as publications quote its recommendation TS 02-76.
CLASSES = {"excellent": 0.6, "good": 0.4, "fair": 0.2, "poor": 0.0}

# EGEA SPECSUS2018, as publications quote it: a wheel whose least phase is below this fails [rad].
PHASE_LIMIT = float(np.radians(35.0))

Figure: TypeAlias = Literal["adhesion", "phase"]


def class_of_adhesion(least: float) -> str:
    """Return EUSAMA's class of a least contact force over the static one."""
    return next((name for name, limit in CLASSES.items() if least >= limit), "poor")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Grip(Result):
    """Adhesion and least phase of each wheel on a test bench, as figures and as curves.

    Parameters
    ----------
    wheels : tuple of str
        The wheels, by coordinate.
    load : ndarray (wheel,)
        Static contact force [N].
    least : ndarray (wheel,)
        Least over static contact force during the sweep [1]; negative where the linear force is, see `adhesion`.
    phase : ndarray (wheel,)
        Least phase of the contact force against the platform between the resonances of body and wheel [rad].
    adhesion_hertz, phase_hertz : ndarray (wheel,)
        Where these are met [Hz].
    hertz : ndarray (frequency,)
        Frequencies of the curves [Hz].
    adhesion_curve, phase_curve : ndarray (wheel, frequency)
        Least over static contact force, negative where the linear force would be, and phase [rad].
    adhesion_band, phase_band : ndarray (wheel, frequency)
        Standard deviations of the curves; 0 for a car that is known.
    resonances : ndarray (wheel, 2)
        Frequencies between which the least phase is looked for [Hz].
    amplitude : float
        Amplitude of the platform [m].
    parameters : tuple of str
        The uncertain parameters of the car.
    jacobian : ndarray (figure, parameter)
        Derivatives of `least` of every wheel, then of their phases; in SI units.
    bends : ndarray (figure, parameter, parameter)
        Second derivatives of the same by parameters whose interval reaches zero; 0 for others.
    parameter_values : ndarray (parameter,)
        Their values; none of them can be negative.
    covariance : ndarray (parameter, parameter)
        Joint covariance of the parameters.
    verdict : Verdict
        Each wheel against the limit, and what the figures rest on.

    Examples
    --------
    >>> from suspid import grip, quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=650, tire_damping=60)
    >>> found = grip(car)
    >>> found.wheels, found.adhesion.round(3), np.degrees(found.phase).round(1), found.classes
    (('tire',), array([0.296]), array([35.9]), ('fair',))
    """

    wheels: tuple[str, ...]
    load: RealArray
    least: RealArray
    phase: RealArray
    adhesion_hertz: RealArray
    phase_hertz: RealArray
    hertz: RealArray
    adhesion_curve: RealArray
    phase_curve: RealArray
    adhesion_band: RealArray
    phase_band: RealArray
    resonances: RealArray
    amplitude: float
    parameters: tuple[str, ...]
    jacobian: RealArray
    bends: RealArray
    parameter_values: RealArray
    covariance: RealArray
    verdict: Verdict

    @property
    def adhesion(self) -> RealArray:
        """EUSAMA's adhesion [1], (wheel,): `least`, or 0 where the wheel leaves the platform.

        Examples
        --------
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> grip(car).adhesion.round(2)
        array([0.71])
        """
        return np.maximum(self.least, 0.0)

    @property
    def adhesion_std(self) -> RealArray:
        """Standard deviations of `least` [1], (wheel,): half the width of its uncut 95 % interval over 1.96.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> found = grip(car, nominal_std=0.05)
        >>> bool(0 < found.adhesion_std[0] < found.adhesion[0])
        True
        """
        return self._std[: len(self.wheels)]

    @property
    def phase_std(self) -> RealArray:
        """Standard deviations of `phase` [rad], (wheel,), in the same way.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> found = grip(car, nominal_std=0.05)
        >>> np.degrees(found.phase_std).round(1)
        array([2.])
        """
        return self._std[len(self.wheels) :]

    @property
    def classes(self) -> tuple[str, ...]:
        """EUSAMA's class of each wheel: excellent from 60 %, good from 40 %, fair from 20 %, else poor.

        Examples
        --------
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> grip(car).classes
        ('excellent',)
        """
        return tuple(class_of_adhesion(one) for one in self.adhesion)

    @property
    def stiff(self) -> tuple[bool, ...]:
        """Whether the least phase of each wheel is met at its resonance: a damper so strong that a stronger has less.

        Where it is, the phase tells nothing of a loss of damping.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> found = grip(car, nominal_std=0.05)
        >>> found.stiff, grip(car.with_parameters(damping={"chassis": 6000})).stiff
        ((False,), (True,))
        """
        return tuple((self.phase_hertz == self.resonances[:, 1]).tolist())

    @property
    def _std(self) -> RealArray:
        return spreads(self.jacobian.T, self.covariance, self.parameter_values, self.bends)

    def interval(self, level: Ratio = LEVEL) -> dict[str, tuple[float, float]]:
        """Return the ends between which each figure lies with probability ``level``, as of ``"tire.adhesion"``.

        Cut at 0 and 1 and at 0 and pi. No car with a negative parameter counts.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> found = grip(car, nominal_std=0.05)
        >>> low, high = found.interval(0.95)["tire.phase"]
        >>> np.degrees([low, high]).round(0)
        array([32., 40.])
        """
        check_level(level)
        figures = np.append(self.least, self.phase)
        down, up = reaches(self.jacobian.T, self.covariance, self.parameter_values, normal_reach(level), self.bends)
        tops = np.repeat([1.0, np.pi], len(self.wheels))
        low, high = (np.clip(end, 0.0, tops).tolist() for end in (figures - down, figures + up))
        names = [f"{wheel}.{what}" for what in ("adhesion", "phase") for wheel in self.wheels]
        return dict(zip(names, zip(low, high, strict=True), strict=True))

    def _table(self) -> Mapping[str, Sequence[object]]:
        ends = self.interval()
        columns: dict[str, Sequence[object]] = {"wheel": self.wheels, "load_n": self.load.tolist()}
        for what, unit, values in (("adhesion", "", self.adhesion), ("phase", "_rad", self.phase)):
            pairs = [ends[f"{wheel}.{what}"] for wheel in self.wheels]
            columns |= {
                f"{what}{unit}": values.tolist(),
                f"{what}_lower{unit}": [low for low, _ in pairs],
                f"{what}_upper{unit}": [high for _, high in pairs],
            }
        return columns

    def _brief(self) -> str:
        return f"least adhesion {numbers_in_words(self.wheels, self.least.tolist())}"

    def __str__(self) -> str:
        certain, degrees = not np.any(self.covariance), float(np.degrees(1.0))
        adhesion = _beside("adhesion [%]", 100 * self.adhesion, 100 * self.adhesion_std, certain, 1)
        # Headings of a table differ, so the second of equal ones has a space.
        phase = _beside("least phase [deg]", degrees * self.phase, degrees * self.phase_std, certain, 2)
        columns = {
            "wheel": list(self.wheels),
            "load [N]": [f"{load:.0f}" for load in self.load],
            **adhesion,
            "class": list(self.classes),
            "at [Hz]": [f"{one:.1f}" for one in self.adhesion_hertz],
            **phase,
            "at [Hz] ": [f"{one:.2f}" for one in self.phase_hertz],
        }
        return f"{text_table(columns, widest=TERMINAL)}\n{self.verdict}"


def _beside(heading: str, values: RealArray, stds: RealArray, certain: bool, which: int) -> dict[str, list[str]]:
    """Return columns of figures and of their standard deviations, none for a car that is known."""
    if certain:
        return {heading: [f"{one:.1f}" for one in values]}
    return {
        heading: [
            rounded(np.array([one]), np.array([std]))[0] if std > 0 else f"{one:.1f}"
            for one, std in zip(values, stds, strict=True)
        ],
        "±" + " " * (which - 1): [spread(std) for std in stds],
    }
