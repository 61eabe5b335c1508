"""A damper's curve: force over velocity with its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.damper_curve_tables import curve_table, summary
from suspid.greybox.line_test import LineTest
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.model import Strut, Suspension, equal_work
from suspid.results import Result
from suspid.units import MetrePerSecond, Newton, NewtonPerMetre, NewtonSecondPerMetre, Ratio, RealArray
from suspid.words import Verdict


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class DamperCurve(Result):
    """Force of a damper over its velocity, found from records; ``str()`` is the table.

    Parameters
    ----------
    name : str
        Name of the strut.
    suspension : Suspension
        The car that was given.
    velocities : ndarray (node,)
        Velocities of the nodes, ascending, with rest among them [m/s]; positive in extension (rebound).
    forces : ndarray (node,)
        Forces at the nodes without friction [N]; straight between them.
    friction : float
        Coulomb friction [N].
    stiffness : float
        Stiffness of the spring parallel to the damper [N/m].
    covariance : ndarray (value, value)
        Joint covariance of stiffness, forces at all nodes and friction, in this order.
    friction_sought : bool
        Whether friction was an unknown.
    linear : LineTest
        The test whether the damper is viscous; true where a line is not rejected.
    velocity_std : float
        Root mean square of the damper's velocity in the records [m/s].
    noise_std : tuple of float
        Noise of the strut's force [N], and of its motion [m/s2, or m where travel was measured].
    chi_square : float
        Statistic of the test that the residual is noise, with ``freedom`` degrees of freedom.
    freedom : int
        See `chi_square`.
    following : float
        How much the residual follows the motion of the strut: F, about 1 where it does not; NaN where travel was
        measured.
    explains : bool
        Whether the residual is noise, or other forces on the body: it, or what cannot be predicted of it, does not
        follow the motion. With a sensor of travel: whether chi-square is not improbably large.
    verdict : Verdict
        How far the result can be trusted, and why.
    followed : float
        Share of the damper's force by which the residual follows the motion [1], by chance about half a percent; NaN
        where travel was measured.

    Examples
    --------
    >>> from suspid import damper_curve, quarter_car, road_profile, simulate
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> t, rng = np.arange(0, 12, 0.005), np.random.default_rng(1)
    >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
    >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
    ...                   interpolation="cubic")
    >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
    >>> found = damper_curve(record, car, strut="chassis", nodes=8)
    >>> found.linear.accepted, found.velocities.size, round(found.equivalent_damping(0.2), -2)
    (True, 9, 1300.0)
    """

    name: str
    suspension: Suspension
    velocities: RealArray
    forces: RealArray
    friction: Newton
    stiffness: NewtonPerMetre
    covariance: RealArray
    friction_sought: bool
    linear: LineTest
    velocity_std: MetrePerSecond
    noise_std: tuple[float, float]
    chi_square: float
    freedom: int
    following: float
    explains: bool
    verdict: Verdict
    followed: Ratio = float("nan")

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {
            "velocity_m_per_s": self.velocities.tolist(),
            "force_n": self.totals.tolist(),
            "force_std_n": self.total_std.tolist(),
        }

    @property
    def std(self) -> RealArray:
        """Standard deviations of `forces` [N], (node,); that at rest is 0.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import damper_curve, quarter_car, road_profile, simulate
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> t, rng = np.arange(0, 6, 0.005), np.random.default_rng(1)
        >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
        >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
        ...                   interpolation="cubic")
        >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
        >>> found = damper_curve(record, car, strut="chassis", nodes=8)
        >>> found.std.shape == found.velocities.shape
        True
        """
        return np.asarray(np.sqrt(np.diag(self.covariance)[1:-1]))

    @property
    def stiffness_std(self) -> NewtonPerMetre:
        """Standard deviation of `stiffness` [N/m].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DamperCurve, LineTest, Remark, Verdict, quarter_car
        >>> from suspid.words.dampers import CurveHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = DamperCurve(
        ...     name="chassis", suspension=car, velocities=np.array([-1.0, 0.0, 1.0]), velocity_std=0.2, friction=30.0,
        ...     forces=np.array([-900.0, 0.0, 1500.0]), stiffness=22e3, friction_sought=True, noise_std=(1.0, 0.03),
        ...     covariance=np.diag([200.0, 20.0, 0.0, 40.0, 5.0]) ** 2, chi_square=500.0, freedom=500, following=1.0,
        ...     linear=LineTest(statistic=9.0, freedom=2, residual_freedom=500, p_value=0.0, level=0.05), explains=True,
        ...     verdict=Verdict(Remark(CurveHeadline.CURVE, {"strut": "chassis"})))
        >>> found.stiffness_std
        200.0
        """
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def friction_std(self) -> Newton:
        """Standard deviation of `friction` [N].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DamperCurve, LineTest, Remark, Verdict, quarter_car
        >>> from suspid.words.dampers import CurveHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = DamperCurve(
        ...     name="chassis", suspension=car, velocities=np.array([-1.0, 0.0, 1.0]), velocity_std=0.2, friction=30.0,
        ...     forces=np.array([-900.0, 0.0, 1500.0]), stiffness=22e3, friction_sought=True, noise_std=(1.0, 0.03),
        ...     covariance=np.diag([200.0, 20.0, 0.0, 40.0, 5.0]) ** 2, chi_square=500.0, freedom=500, following=1.0,
        ...     linear=LineTest(statistic=9.0, freedom=2, residual_freedom=500, p_value=0.0, level=0.05), explains=True,
        ...     verdict=Verdict(Remark(CurveHeadline.CURVE, {"strut": "chassis"})))
        >>> found.friction_std
        5.0
        """
        return float(np.sqrt(self.covariance[-1, -1]))

    @property
    def totals(self) -> RealArray:
        """Forces at the nodes with friction [N], (node,).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DamperCurve, LineTest, Remark, Verdict, quarter_car
        >>> from suspid.words.dampers import CurveHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = DamperCurve(
        ...     name="chassis", suspension=car, velocities=np.array([-1.0, 0.0, 1.0]), velocity_std=0.2, friction=30.0,
        ...     forces=np.array([-900.0, 0.0, 1500.0]), stiffness=22e3, friction_sought=True, noise_std=(1.0, 0.03),
        ...     covariance=np.diag([200.0, 20.0, 0.0, 40.0, 5.0]) ** 2, chi_square=500.0, freedom=500, following=1.0,
        ...     linear=LineTest(statistic=9.0, freedom=2, residual_freedom=500, p_value=0.0, level=0.05), explains=True,
        ...     verdict=Verdict(Remark(CurveHeadline.CURVE, {"strut": "chassis"})))
        >>> found.totals
        array([-930.,    0., 1530.])
        """
        return np.asarray(self.forces + self.friction * np.sign(self.velocities))

    @property
    def total_std(self) -> RealArray:
        """Standard deviations of `totals` [N], (node,).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DamperCurve, LineTest, Remark, Verdict, quarter_car
        >>> from suspid.words.dampers import CurveHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = DamperCurve(
        ...     name="chassis", suspension=car, velocities=np.array([-1.0, 0.0, 1.0]), velocity_std=0.2, friction=30.0,
        ...     forces=np.array([-900.0, 0.0, 1500.0]), stiffness=22e3, friction_sought=True, noise_std=(1.0, 0.03),
        ...     covariance=np.diag([200.0, 20.0, 0.0, 40.0, 5.0]) ** 2, chi_square=500.0, freedom=500, following=1.0,
        ...     linear=LineTest(statistic=9.0, freedom=2, residual_freedom=500, p_value=0.0, level=0.05), explains=True,
        ...     verdict=Verdict(Remark(CurveHeadline.CURVE, {"strut": "chassis"})))
        >>> (found.total_std**2).round()
        array([ 425.,    0., 1625.])
        """
        turned = np.hstack([np.eye(len(self.forces)), np.sign(self.velocities)[:, None]])
        return np.asarray(np.sqrt(np.einsum("ij,jk,ik->i", turned, self.covariance[1:, 1:], turned)))

    def interval(self, level: Ratio = LEVEL) -> tuple[RealArray, RealArray]:
        """Return the ends between which each of `forces` lies with probability ``level`` [N], (node,) each.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import damper_curve, quarter_car, road_profile, simulate
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> t, rng = np.arange(0, 6, 0.005), np.random.default_rng(1)
        >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
        >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
        ...                   interpolation="cubic")
        >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
        >>> found = damper_curve(record, car, strut="chassis", nodes=8)
        >>> low, high = found.interval(0.95)
        >>> bool(np.all((low <= found.forces) & (found.forces <= high)))
        True
        """
        check_level(level)
        reach = normal_reach(level) * self.std
        return self.forces - reach, self.forces + reach

    def equivalent_damping(self, amplitude: MetrePerSecond | None = None) -> NewtonSecondPerMetre:
        """Return the viscous damping that takes as much work per cycle of a harmonic motion [N s/m].

        Parameters
        ----------
        amplitude : float, optional
            Amplitude of the velocity [m/s]. Default: that of the root mean square in the records.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import damper_curve, quarter_car, road_profile, simulate
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> t, rng = np.arange(0, 6, 0.005), np.random.default_rng(1)
        >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
        >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
        ...                   interpolation="cubic")
        >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
        >>> found = damper_curve(record, car, strut="chassis", nodes=8)
        >>> round(found.equivalent_damping(0.2), -2)
        1300.0
        """
        return float(self.work_of(amplitude) @ np.append(self.forces, self.friction))

    def equivalent_damping_std(self, amplitude: MetrePerSecond | None = None) -> NewtonSecondPerMetre:
        """Return the standard deviation of `equivalent_damping` [N s/m].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import damper_curve, quarter_car, road_profile, simulate
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> t, rng = np.arange(0, 6, 0.005), np.random.default_rng(1)
        >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
        >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
        ...                   interpolation="cubic")
        >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
        >>> found = damper_curve(record, car, strut="chassis", nodes=8)
        >>> bool(found.equivalent_damping_std(0.2) < 0.1 * found.equivalent_damping(0.2))
        True
        """
        work = self.work_of(amplitude)
        return float(np.sqrt(work @ self.covariance[1:, 1:] @ work))

    def work_of(self, amplitude: MetrePerSecond | None = None) -> RealArray:
        """Return the equivalent damping per force at each node and per friction [s/m].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DamperCurve, LineTest, Remark, Verdict, quarter_car
        >>> from suspid.words.dampers import CurveHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = DamperCurve(
        ...     name="chassis", suspension=car, velocities=np.array([-1.0, 0.0, 1.0]), velocity_std=0.2, friction=30.0,
        ...     forces=np.array([-900.0, 0.0, 1500.0]), stiffness=22e3, friction_sought=True, noise_std=(1.0, 0.03),
        ...     covariance=np.diag([200.0, 20.0, 0.0, 40.0, 5.0]) ** 2, chi_square=500.0, freedom=500, following=1.0,
        ...     linear=LineTest(statistic=9.0, freedom=2, residual_freedom=500, p_value=0.0, level=0.05), explains=True,
        ...     verdict=Verdict(Remark(CurveHeadline.CURVE, {"strut": "chassis"})))
        >>> equivalent = found.work_of(0.5) @ np.append(found.forces, found.friction)
        >>> bool(np.isclose(equivalent, (900 + 1500) / 2 + 4 * 30 / (np.pi * 0.5)))
        True
        """
        speed = np.sqrt(2) * self.velocity_std if amplitude is None else amplitude
        nodes = self.velocities.tolist()
        units = [equal_work(list(zip(nodes, row, strict=True)), 0.0, speed) for row in np.eye(len(nodes)).tolist()]
        return np.array([*units, equal_work(((0.0, 0.0), (1.0, 0.0)), 1.0, speed)])

    @property
    def curve(self) -> tuple[tuple[float, float], ...]:
        """The points of the nearest curve that rises through zero, for a `Strut`.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DamperCurve, LineTest, Remark, Verdict, quarter_car
        >>> from suspid.words.dampers import CurveHeadline
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> found = DamperCurve(
        ...     name="chassis", suspension=car, velocities=np.array([-1.0, 0.0, 1.0]), velocity_std=0.2, friction=30.0,
        ...     forces=np.array([-900.0, 0.0, 1500.0]), stiffness=22e3, friction_sought=True, noise_std=(1.0, 0.03),
        ...     covariance=np.diag([200.0, 20.0, 0.0, 40.0, 5.0]) ** 2, chi_square=500.0, freedom=500, following=1.0,
        ...     linear=LineTest(statistic=9.0, freedom=2, residual_freedom=500, p_value=0.0, level=0.05), explains=True,
        ...     verdict=Verdict(Remark(CurveHeadline.CURVE, {"strut": "chassis"})))
        >>> found.curve
        ((-1.0, -900.0), (0.0, 0.0), (1.0, 1500.0))
        """
        return tuple(zip(self.velocities.tolist(), rising(self).tolist(), strict=True))

    @property
    def strut(self) -> Strut:
        """The strut with what was found, for `free_decay` and `simulate`.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import damper_curve, quarter_car, road_profile, simulate
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> t, rng = np.arange(0, 6, 0.005), np.random.default_rng(1)
        >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
        >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
        ...                   interpolation="cubic")
        >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
        >>> found = damper_curve(record, car, strut="chassis", nodes=8)
        >>> found.strut.name, found.strut.linear
        ('chassis', False)
        """
        nominal = next(s for s in self.suspension.struts if s.name == self.name)
        return replace(
            nominal,
            stiffness=max(self.stiffness, 0.0),
            damping=max(self.equivalent_damping(), 0.0),
            friction=max(self.friction, 0.0),
            curve=self.curve,
        )

    @property
    def car(self) -> Suspension:
        """The suspension with `strut` in place of the one given.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import damper_curve, quarter_car, road_profile, simulate
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=1300)
        >>> t, rng = np.arange(0, 6, 0.005), np.random.default_rng(1)
        >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
        >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
        ...                   interpolation="cubic")
        >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
        >>> found = damper_curve(record, car, strut="chassis", nodes=8)
        >>> found.car.struts[0] == found.strut
        True
        """
        struts = [self.strut if s.name == self.name else s for s in self.suspension.struts]
        return replace(self.suspension, struts=struts)

    def _brief(self) -> str:
        return (
            f"{self.name}, {len(self.velocities)} speeds from {self.velocities[0]:.3g} to {self.velocities[-1]:.3g} m/s"
        )

    def __str__(self) -> str:
        return "\n".join([curve_table(self), summary(self), str(self.verdict)])


def rising(found: DamperCurve) -> RealArray:
    """Return the forces nearest to those found, in standard deviations, that rise through zero."""
    from scipy.optimize import isotonic_regression

    out = np.zeros(len(found.forces))
    for sign in (1.0, -1.0):
        side = np.flatnonzero(sign * found.velocities > 0)[:: int(sign)]
        weights = 1 / np.maximum(found.std[side], 1e-12) ** 2
        made = isotonic_regression(sign * found.forces[side], weights=weights).x
        out[side] = sign * np.maximum(made, 0.0)
    return out
