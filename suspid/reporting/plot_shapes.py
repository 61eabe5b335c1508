"""Mode shapes as bars."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.reporting.axes import LAID_OUT, entitle, shown
from suspid.reporting.colours import Colour
from suspid.reporting.shape_groups import ShapeGroup, shape_groups
from suspid.results import check_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from suspid.model import ModalSet

# Length of the bar of the largest component [distance between modes]: two neighbours just do not meet.
FULL_BAR = 0.42
# Share of the largest component below which a bar is no wider than its outline.
UNSEEN = 0.02
# Width of a column that holds a frequency [inch]; in narrower ones the numbers stand upright.
COLUMN_OF_NUMBER = 0.48
# Height of a row whose name can be read [inch]; of lower ones, one in several is named.
ROW_OF_NAME = 0.12
# Quantities of channels without units, as they stand behind names.
SHORT_QUANTITIES = {"displacement": "disp.", "velocity": "vel.", "acceleration": "acc."}


@explained
def plot_shapes(modes: ModalSet, *, ax: Axes, units: Sequence[str] | None = None) -> Axes:
    """Draw mode shapes: a column for each mode, with a bar for each channel.

    Bars to the right are in phase with the largest component, bars to the left in antiphase. The dark bar is the
    real part, the light bar the amplitude. A phase that is neither 0 nor 180° to within 1° is written next to it.

    Where channels differ in what they measure, ``units`` or words in their names, such as "acc", say it. Displacements,
    velocities and accelerations with units are then shown as displacements. Channels that cannot be compared, such as
    lengths and angles, stand in groups with their unit, and 1 is the largest of each group.

    Parameters
    ----------
    modes : ModalSet
        Modes with shapes.
    ax : matplotlib.axes.Axes
        Where to draw.
    units : sequence of str, optional
        Unit of each channel, such as "mm" or "m/s2". Default: all alike.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Raises
    ------
    InputError
        If the modes have no shapes, or the number of units is not that of channels.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import eigenmodes, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> ax = plot_shapes(eigenmodes(car), ax=Figure().subplots())
    >>> [label.get_text() for label in ax.get_yticklabels()]
    ['chassis', 'tire']
    """
    check_kind(modes, {"ModalSet": "eigenmodes, or identify as .modes,"})
    if modes.shapes is None:
        raise InputError("these modes have no shapes to draw: poles alone were given")
    groups = shape_groups(modes, units)
    order = [k for group in groups for k in group.channels]
    shapes = np.concatenate([group.shapes for group in groups])
    rows = np.arange(len(shapes))
    # Among more bars phases could not be read.
    numbered = shapes.size <= 24
    for k, shape in enumerate(shapes.T, 1):
        amplitude = np.where(shape.real < 0, -1, 1) * np.abs(shape)
        ax.barh(
            rows, FULL_BAR * amplitude, left=k, height=0.5, color=Colour.PALE_BLUE, edgecolor=Colour.BLUE, linewidth=0.6
        )
        ax.barh(rows, FULL_BAR * shape.real, left=k, height=0.5, color=Colour.BLUE)
        ax.plot([k, k], [-0.5, len(shapes) - 0.5], color=Colour.BLACK, linewidth=0.8)
        for row, component in enumerate(shape):
            if numbered:
                _write_phase(ax, k, row, complex(component))
    count = len(modes)
    for k in range(1, count):
        ax.axvline(k + 0.5, color=Colour.SHADE, linewidth=0.8)
    ax.set(xlim=(0.5, count + 0.5), ylim=(len(shapes) - 0.5, -0.5))
    narrow = ax.get_window_extent().width < COLUMN_OF_NUMBER * ax.figure.dpi * count
    ax.set_xticks(range(1, count + 1), [f"{wn / (2 * np.pi):.4g}" for wn in modes.wn], rotation=90.0 if narrow else 0.0)
    names = [shown(modes.channels[k], most=16 if len(groups) < 2 else 8) for k in order]
    if len(groups) > 1:
        units_of = [
            shown(SHORT_QUANTITIES.get(group.unit, group.unit), most=5) or "?"
            for group in groups
            for _ in group.channels
        ]
        names = [f"{name} [{unit}]" for name, unit in zip(names, units_of, strict=True)]
        for end in np.cumsum([len(group.channels) for group in groups[:-1]]):
            ax.axhline(end - 0.5, color=Colour.GREY, linewidth=0.8)
    lower = ROW_OF_NAME * ax.figure.dpi * len(rows) / (LAID_OUT * ax.get_window_extent().height)
    every = max(1, int(np.ceil(lower)))
    ax.set_yticks(rows[::every], names[::every])
    ax.set_xlabel("natural frequency [Hz]")
    by = " by unit" if len(groups) > 1 else ", without units" if _unsaid(groups) else ""
    light = "; light: amplitude" if np.any(FULL_BAR * (np.abs(shapes) - np.abs(shapes.real)) > UNSEEN) else ""
    entitle(ax, f"shapes{_as_what(groups)} [1 = largest{by}]{light}")
    return ax


def _as_what(groups: Sequence[ShapeGroup]) -> str:
    """Return in words what channels are shown as, where some were measured as another quantity."""
    names = {"m": "displacement", "rad": "angle"}
    brought = [names[group.unit] for group in groups if group.brought]
    return f" as {' and '.join(brought)}" if brought else ""


def _unsaid(groups: Sequence[ShapeGroup]) -> bool:
    """Whether a channel without a unit is too small to be seen in every mode: it may measure something else."""
    (group, *_) = groups
    return not group.unit and bool(np.any(np.max(np.abs(group.shapes), axis=1) < UNSEEN))


def _write_phase(ax: Axes, column: int, row: int, component: complex) -> None:
    """Write the phase on the side of the axis where there is no bar; omit 0, 180° and that of tiny components."""
    degrees = float(np.degrees(np.angle(component)))
    if abs(component) <= 0.01 or not 1.0 < abs(degrees) < 179.0:
        return
    side = "right" if component.real >= 0 else "left"
    offset = -0.03 if side == "right" else 0.03
    ax.text(column + offset, row, f"{degrees:.0f}°".replace("-", "−"), ha=side, va="center", fontsize="small")
