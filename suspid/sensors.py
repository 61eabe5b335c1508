"""Sensors: units, signs and scales, and the vertical in a tilted accelerometer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from suspid.errors import InputError, RecordError
from suspid.files import printable
from suspid.signals import Signal, as_response, as_signal
from suspid.units import Ratio, RealArray
from suspid.values import frozen_real, nearest_names

if TYPE_CHECKING:
    import control

STANDARD_GRAVITY = 9.80665
# What is measured at rest is gravity if it is that of the earth to within this share.
GRAVITY = 0.15
# Parts of the record over which the spread of a direction is counted.
BLOCKS = 20
# Gravity and the motion agree if they are no further apart than this, or than three standard deviations [deg].
AGREE = 10.0

INCH, POUND_FORCE, KNOT = 0.0254, 4.4482216152605, 1852 / 3600
# Units by name: factor and the SI unit it leads to.
UNITS: dict[str, tuple[float, str]] = {
    "m": (1.0, "m"), "dm": (0.1, "m"), "cm": (1e-2, "m"), "mm": (1e-3, "m"), "um": (1e-6, "m"), "nm": (1e-9, "m"),
    "in": (INCH, "m"), "inch": (INCH, "m"), "mil": (1e-3 * INCH, "m"), "ft": (12 * INCH, "m"),
    "m/s": (1.0, "m/s"), "cm/s": (1e-2, "m/s"), "mm/s": (1e-3, "m/s"), "in/s": (INCH, "m/s"), "ips": (INCH, "m/s"),
    "ft/s": (12 * INCH, "m/s"), "km/h": (1 / 3.6, "m/s"), "kph": (1 / 3.6, "m/s"), "mph": (0.44704, "m/s"),
    "kn": (KNOT, "m/s"),
    "m/s2": (1.0, "m/s2"), "cm/s2": (1e-2, "m/s2"), "gal": (1e-2, "m/s2"), "mm/s2": (1e-3, "m/s2"),
    "in/s2": (INCH, "m/s2"), "ft/s2": (12 * INCH, "m/s2"),
    "g": (STANDARD_GRAVITY, "m/s2"), "gn": (STANDARD_GRAVITY, "m/s2"), "g0": (STANDARD_GRAVITY, "m/s2"),
    "mg": (1e-3 * STANDARD_GRAVITY, "m/s2"), "ug": (1e-6 * STANDARD_GRAVITY, "m/s2"),
    "n": (1.0, "N"), "kn_force": (1e3, "N"), "lbf": (POUND_FORCE, "N"), "kgf": (STANDARD_GRAVITY, "N"),
    "rad": (1.0, "rad"), "mrad": (1e-3, "rad"), "deg": (np.pi / 180, "rad"), "°": (np.pi / 180, "rad"),
    "rad/s": (1.0, "rad/s"), "deg/s": (np.pi / 180, "rad/s"), "°/s": (np.pi / 180, "rad/s"),
    "dps": (np.pi / 180, "rad/s"), "rpm": (np.pi / 30, "rad/s"),
    "strain": (1.0, "strain"), "ε": (1.0, "strain"), "m/m": (1.0, "strain"), "mm/m": (1e-3, "strain"),
    "uε": (1e-6, "strain"), "ue": (1e-6, "strain"), "ustrain": (1e-6, "strain"), "microstrain": (1e-6, "strain"),
    "um/m": (1e-6, "strain"),
    "pa": (1.0, "Pa"), "kpa": (1e3, "Pa"), "mpa": (1e6, "Pa"), "bar": (1e5, "Pa"), "psi": (6894.757293168, "Pa"),
    "v": (1.0, "V"), "mv": (1e-3, "V"),
}  # fmt: skip


def to_si(values: ArrayLike, unit: str) -> tuple[RealArray, str]:
    """Return values in SI units, and that unit.

    Parameters
    ----------
    values : array_like
        In the unit given.
    unit : str
        Such as "mm", "in", "g" (of gravity), "m/s^2", "deg/s", "km/h", "µε" (strain stays strain, a ratio).

    Raises
    ------
    InputError
        If the unit is not known.

    Examples
    --------
    >>> to_si([1.0, -2.0], "mm")
    (array([ 0.001, -0.002]), 'm')
    >>> to_si(1.0, "g"), to_si(250.0, "µε")
    ((array(9.80665), 'm/s2'), (array(0.00025), 'strain'))
    """
    plain = unit.strip().strip("[]()").strip()
    for old, new in (
        ("²", "2"),
        ("^", ""),
        ("**", ""),
        ("µ", "u"),
        ("μ", "u"),
        ("·", ""),
        (" ", ""),
        ("s-2", "/s2"),
        ("//", "/"),
    ):
        plain = plain.replace(old, new)
    plain = plain.replace("/sec", "/s").replace("/s/s", "/s2")
    # kN and kn (knot), N and n: the only units that differ in case alone.
    key = "kn_force" if plain == "kN" else plain if plain in UNITS else plain.lower()
    if key not in UNITS:
        known = ["kN" if name == "kn_force" else name for name in UNITS]
        raise InputError(f"the unit {printable(unit)!r} is not known.{nearest_names(plain, known)}")
    factor, si = UNITS[key]
    return np.asarray(values, float) * factor, si


def scaled(response: control.TimeResponseData, factors: Mapping[str, float]) -> control.TimeResponseData:
    """Return a record with some channels multiplied: a sign, a sensitivity, a unit.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    factors : mapping of str to float
        Factor by channel; the other channels stay as they are.

    Raises
    ------
    InputError
        If a channel is not there, or a factor is zero or not finite.

    Examples
    --------
    >>> record = as_response(np.arange(3) / 10, np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), ["seat", "tire"])
    >>> scaled(record, {"tire": -0.5}).y
    array([[ 1. ,  2. ,  3. ],
           [-2. , -2.5, -3. ]])
    """
    signal = as_signal(response)
    for name, factor in factors.items():
        if name not in signal.channels:
            raise InputError(f"there is no channel {name!r}.{nearest_names(name, signal.channels)}")
        if not np.isfinite(factor) or factor == 0:
            raise InputError(f"the factor of channel {name!r}, {factor}, must be finite and not zero")
    by = np.array([factors.get(name, 1.0) for name in signal.channels])
    title = getattr(response, "title", None) or ""
    return as_response(np.asarray(response.time), signal.values * by[:, None], signal.channels, title=title)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Vertical:
    """Where up is in a sensor of three axes, and how well that is known.

    Parameters
    ----------
    axes : tuple of str
        The three channels.
    by : {"gravity", "motion"}
        What was taken as the vertical.
    up : ndarray (axis,)
        Unit vector along which the record was taken.
    std_deg : float
        Standard deviation of its direction, per plane [deg].
    gravity : float
        Length of the mean of the three channels, in their unit: of gravity where that is measured.
    gravity_unit : str
        "m/s2" or "g" where the length is that of gravity, else empty.
    principal : ndarray (axis,)
        Unit vector of the largest motion, pointing up where gravity tells.
    principal_std_deg : float
        Standard deviation of its direction, per plane [deg].
    explained, principal_explained : float
        Share of the variance of the motion along ``up`` and along ``principal``.
    """

    axes: tuple[str, ...]
    by: Literal["gravity", "motion"]
    up: RealArray
    std_deg: float
    gravity: float
    gravity_unit: str
    principal: RealArray
    principal_std_deg: float
    explained: Ratio
    principal_explained: Ratio

    @property
    def nearest_axis(self) -> str:
        """The channel that is nearest to the vertical."""
        return self.axes[int(np.argmax(np.abs(self.up)))]

    @property
    def tilt_deg(self) -> float:
        """Angle between the vertical and that axis [deg]."""
        return _angle(self.up, np.eye(3)[int(np.argmax(np.abs(self.up)))])

    @property
    def apart_deg(self) -> float:
        """Angle between the vertical and the axis of the largest motion [deg]."""
        return _angle(self.up, self.principal)

    @property
    def agree(self) -> bool:
        """Whether gravity and the motion point the same way, to 10 degrees or three standard deviations."""
        return self.apart_deg <= max(AGREE, 3 * float(np.hypot(self.std_deg, self.principal_std_deg)))

    def __str__(self) -> str:
        parts = ", ".join(f"{u:+.4f} {printable(name)}" for u, name in zip(self.up, self.axes, strict=True))
        lines = [
            f"up: {parts}, by {self.by}; {self.tilt_deg:.2f} ± {self.std_deg:.2g} deg off {printable(self.nearest_axis)}; "
            f"{100 * self.explained:.1f} % of the motion is along it"
        ]
        if self.gravity_unit:
            lines.append(f"gravity: {self.gravity:.4g} {self.gravity_unit}, taken away")
        else:
            lines.append(
                f"gravity: not measured (the mean of the three channels is {self.gravity:.4g}); up may be down"
            )
        lines.append(
            f"largest motion: {100 * self.principal_explained:.1f} % along an axis {self.apart_deg:.2f} deg from up: "
            f"{'they agree' if self.agree else 'they do not agree: the motion is not mainly vertical'}"
        )
        return "\n".join(lines)


def vertical(
    response: control.TimeResponseData,
    axes: Sequence[str] | None = None,
    *,
    name: str = "vertical",
    by: Literal["gravity", "motion"] | None = None,
) -> tuple[control.TimeResponseData, Vertical]:
    """Return the vertical motion that a tilted accelerometer of three axes has measured.

    At rest an accelerometer shows gravity, pointing up. Where the mean of the three channels is as long as
    gravity, in m/s2 or in g, its direction is the vertical, it is taken away, and up is positive. Else the
    vertical is the axis of the largest motion (the first eigenvector of the covariance), positive where
    its largest component is.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    axes : sequence of str, optional
        Three channels at right angles, in one unit. Default: the channels, if they are three.
    name : str
        Name of the new channel.
    by : {"gravity", "motion"}, optional
        What to take as the vertical. Default: gravity where it is measured.

    Returns
    -------
    control.TimeResponseData
        One channel.
    Vertical
        Direction, tilt, what it explains, and how far gravity and motion agree.

    Raises
    ------
    RecordError
        If there are not three axes, nothing moves, or gravity is asked for but not measured.

    Examples
    --------
    >>> t = np.arange(2000) / 200
    >>> bounce = np.exp(-t) * np.sin(10 * t)
    >>> tilt = np.radians(20)
    >>> three = np.array([0 * t, np.sin(tilt) * (9.81 + bounce), np.cos(tilt) * (9.81 + bounce)])
    >>> up, found = vertical(as_response(t, three, ["x", "y", "z"]))
    >>> round(found.tilt_deg, 2), found.nearest_axis, found.gravity_unit, found.agree
    (20.0, 'z', 'm/s2', True)
    >>> bool(np.std(up.y[0] - bounce) < 1e-9)
    True
    """
    signal = as_signal(response, least=2 * BLOCKS)
    values, names = _three(signal, axes)
    if by not in (None, "gravity", "motion"):
        raise InputError(f"{by=} is unknown; it is 'gravity' or 'motion'")
    mean = values.mean(axis=1)
    motion = values - mean[:, None]
    power = motion @ motion.T / values.shape[1]
    if np.trace(power) <= 1e-24 * float(mean @ mean):
        raise RecordError(f"nothing moves in {', '.join(map(repr, names))}")
    shares, directions = np.linalg.eigh(power)
    length = float(np.linalg.norm(mean))
    unit = next((u for u, g in (("m/s2", STANDARD_GRAVITY), ("g", 1.0)) if abs(length / g - 1) <= GRAVITY), "")
    if by == "gravity" and not unit:
        raise RecordError(
            f"gravity is not measured: the mean of {', '.join(map(repr, names))} is {length:.4g}, neither 9.81 (m/s2) nor "
            f"1 (g) to within {100 * GRAVITY:.0f} %; convert the unit, or take by='motion'"
        )
    principal = directions[:, -1]
    towards = float(mean @ principal) if unit else float(principal[np.argmax(np.abs(principal))])
    principal = principal * (1.0 if towards >= 0 else -1.0)
    spread = _std_deg(principal @ motion, motion, principal)
    used = by or ("gravity" if unit else "motion")
    up = mean / length if used == "gravity" else principal
    found = Vertical(
        axes=names,
        by=used,
        up=frozen_real(up),
        std_deg=_std_deg(np.full(values.shape[1], length), motion, up) if used == "gravity" else spread,
        gravity=length,
        gravity_unit=unit,
        principal=frozen_real(principal),
        principal_std_deg=spread,
        explained=float(up @ power @ up / np.trace(power)),
        principal_explained=float(shares[-1] / np.sum(shares)),
    )
    along = up @ (motion if unit else values)
    return as_response(
        np.asarray(response.time), along[None], [name], title=getattr(response, "title", None) or ""
    ), found


def _three(signal: Signal, axes: Sequence[str] | None) -> tuple[RealArray, tuple[str, ...]]:
    names = tuple(signal.channels if axes is None else axes)
    for name in names:
        if name not in signal.channels:
            raise RecordError(f"there is no channel {name!r}.{nearest_names(name, signal.channels)}")
    if len(names) != 3 or len(set(names)) != 3:
        raise RecordError(f"an accelerometer of three axes is needed, not {len(names)} channels: name the three (axes)")
    return signal.values[[signal.channels.index(name) for name in names]], names


def _std_deg(along: RealArray, motion: RealArray, axis: RealArray) -> float:
    """Return the std of the direction of ``sum(along * motion)``, per plane through it [deg].

    The samples of a block may be correlated; the sums over blocks count as independent.
    """
    across = motion - np.outer(axis, axis @ motion)
    products = along * across
    sums = np.array([part.sum(axis=1) for part in np.array_split(products, BLOCKS, axis=1)])
    variance = float(np.sum(sums**2)) / 2
    return float(np.degrees(np.sqrt(variance) / np.sum(along**2)))


def _angle(one: RealArray, other: RealArray) -> float:
    """Return the angle between two axes [deg]."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(one, other)), abs(one @ other))))
