"""One strut: a spring and a damper in parallel, the damper perhaps on a mount."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from suspid.errors import InputError
from suspid.model.checks import check_name, finite_number
from suspid.units import NewtonPerMetre, NewtonSecondPerMetre, Second
from suspid.values import FrozenMapping


@dataclass(frozen=True, kw_only=True, slots=True)
class Strut:
    """A linear spring and a viscous damper in parallel.

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

    Raises
    ------
    InputError
        If a rate is negative or not finite, a mount is not stiffer than zero, or all arms are zero.

    Examples
    --------
    >>> Strut(name="seat", stiffness=16e3, damping=500.0, arms={"seat": 1.0, "chassis": -1.0}).stiffness
    16000.0
    """

    name: str
    stiffness: NewtonPerMetre
    damping: NewtonSecondPerMetre
    arms: Mapping[str, float]
    mount_stiffness: NewtonPerMetre | None = None

    def __post_init__(self) -> None:
        check_name("a strut", self.name)
        for quantity, unit in (("stiffness", "N/m"), ("damping", "N s/m")):
            value = finite_number(f"strut {self.name!r}: {quantity}", getattr(self, quantity), unit)
            if value < 0:
                raise InputError(f"strut {self.name!r}: {quantity} = {value:g} {unit} is negative; it must be >= 0")
            object.__setattr__(self, quantity, value)
        if self.mount_stiffness is not None:
            mount = finite_number(f"strut {self.name!r}: mount_stiffness", self.mount_stiffness, "N/m")
            if mount <= 0:
                raise InputError(
                    f"strut {self.name!r}: mount_stiffness = {mount:g} N/m must be positive; leave it out for a "
                    f"damper without a mount"
                )
            object.__setattr__(self, "mount_stiffness", mount)
        if not isinstance(self.arms, Mapping):
            raise InputError(
                f"strut {self.name!r}: arms = {self.arms!r} must map coordinates to arms, as {{'seat': 1.0}}"
            )
        for coordinate, arm in self.arms.items():
            check_name(f"strut {self.name!r}: a coordinate", coordinate)
            finite_number(f"strut {self.name!r}: arm {coordinate!r}", arm, "1 or m")
        if not any(self.arms.values()):
            raise InputError(f"strut {self.name!r} has no nonzero arm; it connects nothing")
        object.__setattr__(self, "arms", FrozenMapping(self.arms))

    @property
    def relaxation(self) -> Second:
        """Time constant of damper and mount, ``damping / mount_stiffness`` [s]; 0 without a mount."""
        return 0.0 if self.mount_stiffness is None else self.damping / self.mount_stiffness
