"""The vertical in a tilted accelerometer of three axes, and how well it is known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from suspid.units import Ratio, RealArray
from suspid.words import Note, Number, Remark


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Vertical:
    """Direction of the vertical in a sensor of three axes, and its uncertainty.

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

    Examples
    --------
    >>> from suspid import as_record, vertical
    >>> t = np.arange(1000) / 200
    >>> up = 9.81 + np.exp(-t) * np.sin(10 * t)
    >>> _, found = vertical(as_record([0 * t, 0.6 * up, 0.8 * up], timepts=t, channels=["x", "y", "z"]))
    >>> found.by, found.up.round(6), round(found.tilt_deg, 2)
    ('gravity', array([0. , 0.6, 0.8]), 36.87)
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
        """The channel that is nearest to the vertical.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, vertical
        >>> t = np.arange(1000) / 200
        >>> up = 9.81 + np.exp(-t) * np.sin(10 * t)
        >>> _, found = vertical(as_record([0 * t, 0.6 * up, 0.8 * up], timepts=t, channels=["x", "y", "z"]))
        >>> found.nearest_axis
        'z'
        """
        return self.axes[int(np.argmax(np.abs(self.up)))]

    @property
    def tilt_deg(self) -> float:
        """Angle between the vertical and that axis [deg].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, vertical
        >>> t = np.arange(1000) / 200
        >>> up = 9.81 + np.exp(-t) * np.sin(10 * t)
        >>> _, found = vertical(as_record([0 * t, 0.6 * up, 0.8 * up], timepts=t, channels=["x", "y", "z"]))
        >>> round(found.tilt_deg, 2)
        36.87
        """
        return _angle(self.up, np.eye(3)[int(np.argmax(np.abs(self.up)))])

    @property
    def apart_deg(self) -> float:
        """Angle between the vertical and the axis of the largest motion [deg].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, vertical
        >>> t = np.arange(1000) / 200
        >>> up = 9.81 + np.exp(-t) * np.sin(10 * t)
        >>> _, found = vertical(as_record([0 * t, 0.6 * up, 0.8 * up], timepts=t, channels=["x", "y", "z"]))
        >>> round(found.apart_deg, 3)
        0.0
        """
        return _angle(self.up, self.principal)

    @property
    def agree(self) -> bool:
        """Whether gravity and the motion point the same way, to 10 degrees or three standard deviations.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, vertical
        >>> t = np.arange(1000) / 200
        >>> up = 9.81 + np.exp(-t) * np.sin(10 * t)
        >>> _, found = vertical(as_record([0 * t, 0.6 * up, 0.8 * up], timepts=t, channels=["x", "y", "z"]))
        >>> found.agree
        True
        """
        # Angle between gravity and motion up to which they agree, if it is more than three standard deviations [deg].
        return self.apart_deg <= max(10.0, 3 * float(np.hypot(self.std_deg, self.principal_std_deg)))

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Direction, gravity and largest motion, as codes with their numbers; ``str()`` is their sentences.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, vertical
        >>> t = np.arange(1000) / 200
        >>> up = 9.81 + np.exp(-t) * np.sin(10 * t)
        >>> _, found = vertical(as_record([0 * t, 0.6 * up, 0.8 * up], timepts=t, channels=["x", "y", "z"]))
        >>> [str(remark.code) for remark in found.remarks]
        ['vertical', 'gravity', 'largest motion']
        """
        up: dict[str, Number] = {
            "axes": ", ".join(f"{u:+.4f} {name}" for u, name in zip(self.up, self.axes, strict=True)),
            "by": self.by,
            "tilt_deg": self.tilt_deg,
            "std_deg": self.std_deg,
            "nearest": self.nearest_axis,
            "explained": self.explained,
        }
        motion: dict[str, Number] = {
            "explained": self.principal_explained,
            "apart_deg": self.apart_deg,
            "agree": self.agree,
        }
        return (
            Remark(Note.VERTICAL, up),
            Remark(
                Note.GRAVITY if self.gravity_unit else Note.NO_GRAVITY,
                {"gravity": self.gravity, "unit": self.gravity_unit},
            ),
            Remark(Note.LARGEST_MOTION, motion),
        )

    def __str__(self) -> str:
        return "\n".join(map(str, self.remarks))


def _angle(one: RealArray, other: RealArray) -> float:
    """Return the angle between two axes [deg]."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(one, other)), abs(one @ other))))
