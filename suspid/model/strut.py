"""One strut: a spring and a damper in parallel, the damper perhaps on a mount, with friction, or with a curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from suspid.errors import InputError
from suspid.model.checks import check_name, finite_number, positive_number
from suspid.model.force_curves import Curve, checked_curve, equal_work
from suspid.units import MetrePerSecond, Newton, NewtonPerMetre, NewtonSecondPerMetre, Second
from suspid.values import FrozenMapping


@dataclass(frozen=True, kw_only=True, slots=True)
class Strut:
    """A linear spring and a damper in parallel; the damper is viscous, or has friction or a curve of its own.

    The elongation is ``sum(arm * coordinate)``. A strut between two masses that move along one
    line has arms 1 and -1. The arm of a pitch or roll angle is a lever arm in metres.

    Parameters
    ----------
    name : str
        Name of the strut.
    stiffness : float
        Spring rate [N/m], not negative.
    damping : float
        Damper rate [N s/m], not negative.
    arms : mapping of str to float
        Elongation per unit of each coordinate, by coordinate [1 or m/rad].
    mount_stiffness : float, optional
        Stiffness of a rubber mount in series with the damper [N/m], positive: the strut is then
        ``k + c s / (1 + (c / mount_stiffness) s)``. Default: the damper is fixed rigidly.
    friction : float
        Coulomb friction of the damper [N], not negative: a force against the velocity, and any force up to that at
        rest.
    curve : sequence of (float, float), optional
        Force of the damper [N] over its velocity [m/s], both positive in extension: points of a piecewise linear curve
        that rises and passes through zero; beyond the points it continues with the slopes of its ends. ``damping`` is
        then the damper rate as stated, and only `linearised` uses it. Default: ``damping`` times the velocity.

    Raises
    ------
    InputError
        If a rate is negative or not finite, a mount is not stiffer than zero, all arms are zero, a curve does not rise
        through zero, or a damper with friction on a mount has neither damping nor a curve.

    Notes
    -----
    `free_decay` and `simulate` compute the motion with friction and curves. Where only linear struts are meant, as in
    `statespace` and `eigenmodes`, such a strut is refused; `linearised` returns one that is accepted.

    Examples
    --------
    >>> Strut(name="seat", stiffness=16e3, damping=500.0, arms={"seat": 1.0, "chassis": -1.0}).stiffness
    16000.0
    >>> digressive = Strut(name="front", stiffness=20e3, damping=1500.0, arms={"body": 1.0, "wheel": -1.0},
    ...                    friction=30.0,
    ...                    curve=((-1.0, -700.0), (-0.1, -130.0), (0.0, 0.0), (0.1, 300.0), (1.0, 1700.0)))
    >>> round(digressive.linearised(amplitude=0.1).damping)
    2532
    """

    name: str
    stiffness: NewtonPerMetre
    damping: NewtonSecondPerMetre
    arms: Mapping[str, float]
    mount_stiffness: NewtonPerMetre | None = None
    friction: Newton = 0.0
    curve: Curve | None = None

    def __post_init__(self) -> None:
        check_name("a strut", self.name)
        for quantity, unit in (("stiffness", "N/m"), ("damping", "N s/m"), ("friction", "N")):
            value = finite_number(f"strut {self.name!r}: {quantity}", getattr(self, quantity), unit)
            if value < 0:
                raise InputError(f"strut {self.name!r}: {quantity} = {value:g} {unit} is negative; it must be >= 0")
            object.__setattr__(self, quantity, value)
        if self.mount_stiffness is not None:
            what = f"strut {self.name!r}: mount_stiffness"
            mount = positive_number(what, self.mount_stiffness, "N/m")
            object.__setattr__(self, "mount_stiffness", mount)
        if self.curve is not None:
            points = checked_curve(f"strut {self.name!r}", self.curve, strictly=self.mount_stiffness is not None)
            object.__setattr__(self, "curve", points)
        elif self.mount_stiffness is not None and self.friction and not self.damping:
            raise InputError(
                f"strut {self.name!r}: friction = {self.friction:g} N on a mount needs damping > 0 or a curve beside it"
            )
        if not isinstance(self.arms, Mapping):
            raise InputError(
                f"strut {self.name!r}: arms = {self.arms!r} must map coordinates to arms, such as {{'seat': 1.0}}"
            )
        for coordinate, arm in self.arms.items():
            check_name(f"strut {self.name!r}: a coordinate", coordinate)
            finite_number(f"strut {self.name!r}: arm {coordinate!r}", arm, "1 or m")
        if not any(self.arms.values()):
            raise InputError(f"strut {self.name!r} has no nonzero arm; it connects nothing")
        object.__setattr__(self, "arms", FrozenMapping(self.arms))

    @property
    def linear(self) -> bool:
        """Whether the strut has neither friction nor a curve.

        Examples
        --------
        >>> from suspid import Strut
        >>> damper = Strut(name="chassis", arms={"chassis": 1, "tire": -1}, stiffness=20e3, damping=1500,
        ...                friction=50.0, mount_stiffness=1e6)
        >>> damper.linear, damper.linearised().linear
        (False, True)
        """
        return self.curve is None and not self.friction

    def equivalent_damping(self, amplitude: MetrePerSecond) -> NewtonSecondPerMetre:
        """Return the viscous damping that takes as much work per cycle of a harmonic motion [N s/m].

        Parameters
        ----------
        amplitude : float
            Amplitude of the damper's velocity [m/s], positive.

        Raises
        ------
        InputError
            If the amplitude is not positive.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Strut
        >>> damper = Strut(name="chassis", arms={"chassis": 1, "tire": -1}, stiffness=20e3, damping=1500,
        ...                friction=50.0, mount_stiffness=1e6)
        >>> round(damper.equivalent_damping(0.1)), round(1500 + 4 * 50 / (np.pi * 0.1))
        (2137, 2137)
        """
        value = finite_number("amplitude", amplitude, "m/s")
        if value <= 0:
            raise InputError(f"{amplitude=} m/s must be positive: it is the amplitude of the damper's velocity")
        points = ((0.0, 0.0), (1.0, self.damping)) if self.curve is None else self.curve
        return equal_work(points, self.friction, value)

    def linearised(self, amplitude: MetrePerSecond | None = None) -> Strut:
        """Return the strut without friction and curve, for what needs linear struts.

        Parameters
        ----------
        amplitude : float, optional
            Amplitude of the damper's velocity [m/s] at which the viscous damper takes as much work per cycle. Default:
            ``damping`` as stated.

        Examples
        --------
        >>> from suspid import Strut
        >>> damper = Strut(name="chassis", arms={"chassis": 1, "tire": -1}, stiffness=20e3, damping=1500,
        ...                friction=50.0, mount_stiffness=1e6)
        >>> damper.linearised(0.1).friction, round(damper.linearised(0.1).damping)
        (0.0, 2137)
        """
        if self.linear:
            return self
        damping = self.damping if amplitude is None else self.equivalent_damping(amplitude)
        return replace(self, damping=damping, friction=0.0, curve=None)

    @property
    def relaxation(self) -> Second:
        """Time constant of damper and mount, ``damping / mount_stiffness`` [s]; 0 without a mount.

        Examples
        --------
        >>> from suspid import Strut
        >>> damper = Strut(name="chassis", arms={"chassis": 1, "tire": -1}, stiffness=20e3, damping=1500,
        ...                friction=50.0, mount_stiffness=1e6)
        >>> damper.relaxation
        0.0015
        """
        return 0.0 if self.mount_stiffness is None else self.damping / self.mount_stiffness
