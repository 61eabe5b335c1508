"""The vertical motion of a tilted accelerometer of three axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from suspid.arguments import explained
from suspid.cleaning.verticals import Vertical
from suspid.errors import InputError, RecordError
from suspid.levels import PIECES_OF_RECORD
from suspid.records import like
from suspid.signals import Signal, as_signal
from suspid.units import STANDARD_GRAVITY, RealArray
from suspid.values import frozen_real, nearest_names

if TYPE_CHECKING:
    import control

# Relative difference from standard gravity up to which the mean of three axes is gravity: more than sensors' errors of
# scale, and far less than the factor between units.
GRAVITY = 0.15


@explained
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
        If there are not three axes, nothing moves, or gravity is requested but not measured.

    Examples
    --------
    >>> t = np.arange(2000) / 200
    >>> bounce = np.exp(-t) * np.sin(10 * t)
    >>> tilt = np.radians(20)
    >>> three = np.array([0 * t, np.sin(tilt) * (9.81 + bounce), np.cos(tilt) * (9.81 + bounce)])
    >>> from suspid.records import as_response
    >>> up, found = vertical(as_response(t, three, ["x", "y", "z"]))
    >>> round(found.tilt_deg, 2), found.nearest_axis, found.gravity_unit, found.agree
    (20.0, 'z', 'm/s2', True)
    >>> bool(np.std(up.y[0] - bounce) < 1e-9)
    True
    """
    signal = as_signal(response, least=2 * PIECES_OF_RECORD)
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
            f"gravity is not measured: the mean of {', '.join(map(repr, names))} is {length:.4g}, neither 9.81 (m/s2) "
            f"nor 1 (g) to within {100 * GRAVITY:.0f} %; convert the unit, or take by='motion'"
        )
    principal = directions[:, -1]
    towards = float(mean @ principal) if unit else float(principal[np.argmax(np.abs(principal))])
    principal = principal * (1.0 if towards >= 0 else -1.0)
    # An eigenvector turns by what is shared with the others over how far their eigenvalues lie below.
    below = float(shares[-1] - np.mean(shares[:2])) * values.shape[1]
    spread = _std_deg(principal @ motion, motion, principal, power=below) if below > 0 else 90.0
    used = by or ("gravity" if unit else "motion")
    up = mean / length if used == "gravity" else principal
    found = Vertical(
        axes=names,
        by=used,
        up=frozen_real(up),
        std_deg=_std_deg(np.full(values.shape[1], length), motion, up, power=length**2 * values.shape[1])
        if used == "gravity"
        else spread,
        gravity=length,
        gravity_unit=unit,
        principal=frozen_real(principal),
        principal_std_deg=spread,
        explained=float(up @ power @ up / np.trace(power)),
        principal_explained=float(shares[-1] / np.sum(shares)),
    )
    along = up @ (motion if unit else values)
    return like(
        response, np.asarray(response.time), along[None], [name], title=getattr(response, "title", None) or ""
    ), found


def _three(signal: Signal, axes: Sequence[str] | None) -> tuple[RealArray, tuple[str, ...]]:
    names = tuple(signal.channels if axes is None else axes)
    for name in names:
        if name not in signal.channels:
            raise RecordError(f"there is no channel {name!r}.{nearest_names(name, signal.channels)}")
    if len(names) != 3 or len(set(names)) != 3:
        raise RecordError(f"an accelerometer of three axes is needed, not {len(names)} channels: name the three (axes)")
    return signal.values[[signal.channels.index(name) for name in names]], names


def _std_deg(along: RealArray, motion: RealArray, axis: RealArray, *, power: float) -> float:
    """Return the std of the direction of ``sum(along * motion) / power``, per plane through it [deg].

    The samples of a block may be correlated; the sums over blocks of equal weight count as independent.
    """
    across = motion - np.outer(axis, axis @ motion)
    weight = np.cumsum(along**2)
    edges = np.searchsorted(weight, weight[-1] * np.arange(1, PIECES_OF_RECORD) / PIECES_OF_RECORD)
    sums = np.array([part.sum(axis=1) for part in np.split(along * across, edges, axis=1)])
    # One direction was taken from the sums themselves.
    variance = float(np.sum(sums**2)) / 2 * PIECES_OF_RECORD / (PIECES_OF_RECORD - 1)
    return float(np.degrees(np.sqrt(variance) / power))
