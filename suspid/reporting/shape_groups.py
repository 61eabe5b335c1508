"""Mode shapes of channels that measure different quantities: brought to displacements, else grouped by quantity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import MOTION_OF_UNIT, named_quantities, to_si
from suspid.errors import InputError
from suspid.model import scaled_shapes
from suspid.units import ComplexArray

if TYPE_CHECKING:
    from suspid.model import ModalSet


@dataclass(frozen=True, kw_only=True, slots=True)
class ShapeGroup:
    """Channels whose components can be compared.

    Parameters
    ----------
    unit : str
        Unit of the components; empty if it is not known.
    channels : tuple of int
        Their numbers.
    brought : bool
        Whether some were measured as velocity or acceleration and are shown as displacement.
    shapes : (channel, mode) array
        Components, 1 the largest of the group; phases against the largest component of the first group.
    """

    unit: str
    channels: tuple[int, ...]
    brought: bool
    shapes: ComplexArray


def shape_groups(modes: ModalSet, units: Sequence[str] | None) -> tuple[ShapeGroup, ...]:
    """Return the shapes in groups that can be compared; one group where the units are alike or not known.

    In a mode of pole s a velocity is s times the displacement, an acceleration s^2 times. Where channels of one
    motion have different units, their components are divided by that and are then those of displacements. A pole at
    zero does not allow this; then every unit is a group of its own. A channel without a unit is one of the quantity
    that its name says.

    Raises
    ------
    InputError
        If the number of units is not that of channels.

    Examples
    --------
    >>> from suspid import ModalSet
    >>> s = -1.0 + 20.0j
    >>> modes = ModalSet(poles=np.array([s]), shapes=np.array([[0.5], [s**2]]), channels=["tire", "seat"])
    >>> (group,) = shape_groups(modes, ["m", "m/s^2"])
    >>> np.round(group.shapes.real.ravel(), 9).tolist(), group.unit
    ([0.5, 1.0], 'm')
    """
    shapes = np.asarray(modes.shapes)
    known = [unit.strip() for unit in units or [""] * len(shapes)]
    if len(modes.channels) == len(known):
        # Without a unit the scale is not known: such channels are kept apart by what their names say.
        known = [unit or quantity for unit, quantity in zip(known, named_quantities(modes.channels), strict=True)]
    if len(known) != len(shapes):
        raise InputError(f"{len(known)} units for {len(shapes)} channels: give one for each")
    if len(set(known)) == 1:
        return (ShapeGroup(unit=known[0], channels=tuple(range(len(shapes))), brought=False,
                           shapes=scaled_shapes(shapes)),)  # fmt: skip
    allowed, members = bool(np.all(modes.poles != 0)), dict[str, list[int]]()
    orders, converted = np.zeros(len(shapes), int), shapes.astype(complex)
    for k, unit in enumerate(known):
        factor, si = _in_si(unit)
        motion, orders[k] = MOTION_OF_UNIT.get(si, (si, 0)) if allowed else (si, 0)
        converted[k] *= factor / modes.poles ** orders[k]
        members.setdefault(motion, []).append(k)
    first = next(iter(members.values()))
    turned = _phase(converted[first])
    return tuple(
        ShapeGroup(
            unit=motion,
            channels=tuple(rows),
            brought=bool(np.any(orders[rows])),
            shapes=converted[rows] / _largest(converted[rows]) / turned,
        )
        for motion, rows in members.items()
    )


def _in_si(unit: str) -> tuple[float, str]:
    """Return the factor to the SI unit and this unit; of a unit that is not known 1 and itself."""
    try:
        factor, si = to_si(1.0, unit)
    except InputError:
        return 1.0, unit
    return float(factor), si


def _largest(shapes: ComplexArray) -> ComplexArray:
    largest = np.max(np.abs(shapes), axis=0)
    return np.asarray(np.where(largest == 0, 1.0, largest), complex)


def _phase(shapes: ComplexArray) -> ComplexArray:
    """Return the direction of the largest component of each mode in the complex plane."""
    largest = np.take_along_axis(shapes, np.argmax(np.abs(shapes), axis=0)[None, :], axis=0)[0]
    return np.asarray(np.where(largest == 0, 1.0, largest / np.where(largest == 0, 1.0, np.abs(largest))))
