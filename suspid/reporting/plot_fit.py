"""Record, fitted decay and residual."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.arguments import explained
from suspid.reporting.axes import (
    checked_grid,
    entitle,
    key_above,
    label_below,
    plot_residual,
    position,
    shown,
    unit_ticks,
)
from suspid.results import check_kind
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import RealArray, Second

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from suspid.identification import Identification


@explained
def plot_fit(
    identification: Identification,
    *,
    axes: Sequence[Axes] | NDArray[np.object_],
    channels: Sequence[str] | None = None,
    span: tuple[Second, Second] | None = None,
    units: Sequence[str] | None = None,
) -> None:
    """Draw the record of each channel with the fitted decay and the residual, all in the unit of the record.

    A channel whose mean is larger than its motion is drawn less that mean, which the title says.

    Parameters
    ----------
    identification : Identification
        What was found.
    axes : (channel,) of matplotlib.axes.Axes
        Where to draw.
    channels : sequence of str, optional
        Which channels. Default: all.
    span : (float, float), optional
        Times between which to draw [s]. Default: the whole record.
    units : sequence of str, optional
        The unit of each drawn channel. Default: ``"unit"``.

    Raises
    ------
    InputError
        If there is no such channel, or the numbers of Axes and channels differ.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> record = free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0})
    >>> axes = Figure().subplots(2)
    >>> plot_fit(identify(record, modes=1), axes=axes)
    >>> axes[1].get_xlabel()
    'time [s]'
    """
    check_kind(identification, {"Identification": "identify"})
    record, fitted, residual = (as_signal(held(identification, name)) for name in ("response", "fitted", "residual"))
    names = record.channels if channels is None else tuple(channels)
    drawn = checked_grid(axes, (len(names),))
    low, high = span or (record.start, record.start + record.duration)
    kept = (record.timepts >= low) & (record.timepts <= high)
    time, share = record.timepts[kept], identification.explained
    for i, (ax, name) in enumerate(zip(drawn, names, strict=True)):
        at = position(name, record.channels)
        level = _offset(record.values[at])
        lines = (record.values[at, kept] - level, fitted.values[at, kept] - level, residual.values[at, kept])
        plot_residual(ax, time, *lines)
        less = f", less {level:.4g}" if level else ""
        entitle(ax, f"{shown(name)}: {100 * share[at]:.4g} % explained{less}")
        ax.set_xlim(low, high)
        unit_ticks(ax, (shown(units[i], most=8) if units else "") or "unit")
    if len(names):
        label_below(drawn, "time [s]")
        key_above(drawn[0])


def _offset(values: RealArray) -> float:
    """Return the mean of a channel where it is larger than the motion, beside which the residual could not be seen.

    Examples
    --------
    >>> _offset(np.array([9.0, 10.0, 11.0])), _offset(np.array([0.0, 1.0, 2.0]))
    (10.0, 0.0)
    """
    level = float(np.mean(values))
    return level if abs(level) > np.ptp(values) > 0 else 0.0
