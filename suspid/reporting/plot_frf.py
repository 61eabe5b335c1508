"""Frequency responses of a record and of its fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.levels import LEVEL, normal_reach
from suspid.reporting.axes import checked_grid, entitle, frequency_ticks, shown
from suspid.reporting.colours import Colour
from suspid.reporting.frf import Frf, responses
from suspid.results import check_kind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from suspid.greybox import Estimate


@explained
def plot_frf(
    found: Estimate,
    *,
    axes: Sequence[Sequence[Axes]] | NDArray[np.object_],
    record: int = 0,
    cause: str | None = None,
    channels: Sequence[str] | None = None,
) -> None:
    """Draw frequency responses of a record from what moved the car and those of the fit: gain above phase.

    Both are cross spectrum over spectrum of the cause (H1), by Welch's method with Hann windows over an eighth of the
    record, so that leakage is the same in both. The band around the gain of the record is its 95 % interval by the
    coherence. Where a channel is the cause, the noise that was found in it is taken off its spectrum, and the band is
    wider by what the scatter of that noise leaves. Where several causes move the car, as front and rear wheels do, it
    is the response with all of them moving, of record and fit alike.

    Parameters
    ----------
    found : Estimate
        What was found.
    axes : (2, channel) of matplotlib.axes.Axes
        Where to draw: gains in the first row, phases in the second.
    record : int
        Which of the records, from 0 on.
    cause : str, optional
        A name in ``found.causes``. Default: the first.
    channels : sequence of str, optional
        The channels to draw. Default: all that are no cause.

    Raises
    ------
    InputError
        If the record is a free decay, there is no such record, cause or channel, or the shape of the Axes differs.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import add_noise, estimate, quarter_car, road_profile, simulate
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> time, rng = np.arange(0, 20, 0.01), np.random.default_rng(1)
    >>> driven = simulate(car, time, {"road": road_profile(10 * time, roughness="C", rng=rng)})
    >>> found = estimate(add_noise(driven, snr_db=30.0, rng=rng), car, given=["road"], fixed=["tire.damping"])
    >>> axes = Figure().subplots(2, 2)
    >>> plot_frf(found, axes=axes)
    >>> axes[0, 1].get_title(loc="left"), found.causes
    ('tire', (('road',),))
    """
    check_kind(found, {"Estimate": "estimate"})
    one = responses(found, record=record, cause=cause, channels=channels)
    drawn = checked_grid(axes, (2, len(one)))
    for (above, below), (name, frf) in zip(drawn.T, one.items(), strict=True):
        draw_gain(above, frf)
        draw_phase(below, frf)
        entitle(above, shown(name))
        below.set_xlabel("frequency [Hz]")
    drawn[1, 0].legend(fontsize="small", frameon=False)


def draw_gain(ax: Axes, frf: Frf) -> None:
    """Draw the gain of the record with its band, and that of the fit."""
    gain, reach = np.abs(frf.record), normal_reach(LEVEL) * frf.std
    ax.fill_between(frf.hertz, gain * np.exp(-reach), gain * np.exp(reach), color=Colour.PALE, alpha=0.4, linewidth=0)
    ax.loglog(frf.hertz, gain, color=Colour.PALE, linewidth=2.0, label="record")
    ax.loglog(frf.hertz, np.abs(frf.fit), color=Colour.BLUE, linewidth=1.0, label="fit")
    seen = np.concatenate([gain, np.abs(frf.fit)])
    seen = seen[seen > 0]
    if seen.size:
        ax.set_ylim(0.7 * float(seen.min()), 1.4 * float(seen.max()))
    frequency_ticks(ax.xaxis, float(frf.hertz[-1] / frf.hertz[0]))
    ax.set_ylabel(f"gain [{frf.unit}]")


def draw_phase(ax: Axes, frf: Frf) -> None:
    """Draw the phase of the record as points, where it is known, and that of the fit."""
    known = normal_reach(LEVEL) * frf.std < 1
    ax.semilogx(
        frf.hertz[known], np.degrees(np.angle(frf.record[known])), ".", color=Colour.PALE, markersize=4, label="record"
    )
    turned = np.degrees(np.angle(frf.fit))
    turned[1:][np.abs(np.diff(turned)) > 180] = np.nan
    ax.semilogx(frf.hertz, turned, color=Colour.BLUE, linewidth=1.0, label="fit")
    ax.set(ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180), ylabel="phase [deg]")
    frequency_ticks(ax.xaxis, float(frf.hertz[-1] / frf.hertz[0]))
