"""A damper's curve: force over velocity with its band."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.reporting.axes import key_above
from suspid.reporting.colours import Colour
from suspid.results import check_kind
from suspid.units import Ratio

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from suspid.greybox import DamperCurve


@explained
def plot_damper_curve(found: DamperCurve, ax: Axes, *, level: Ratio = LEVEL) -> Axes:
    """Draw the force of a damper over its velocity with friction, its band, and the viscous damper of equal work.

    Parameters
    ----------
    found : DamperCurve
        What was found.
    ax : matplotlib.axes.Axes
        Where to draw.
    level : float
        Probability of the band at each velocity [1].

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import damper_curve, quarter_car, road_profile, simulate
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300, tire_damping=60)
    >>> t = np.arange(0, 12, 0.005)
    >>> road = road_profile(20 * t, roughness="B", rng=np.random.default_rng(1), wavelengths=(0.5, 100.0))
    >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
    ...                   interpolation="cubic")
    >>> found = damper_curve(record, car, strut="chassis", nodes=8)
    >>> plot_damper_curve(found, Figure().subplots()).get_ylabel()
    'force of the damper [N]'
    """
    check_kind(found, {"DamperCurve": "damper_curve"})
    check_level(level)
    reach = normal_reach(level)
    nodes = found.velocities
    for sign, first in ((-1.0, True), (1.0, False)):
        side = sign * nodes >= 0
        v = nodes[side]
        # With friction the force jumps at rest.
        force = found.forces[side] + sign * found.friction
        std = np.where(v == 0, found.friction_std, found.total_std[side])
        band = f"{100 * level:g} % band" if first else None
        ax.fill_between(
            v, force - reach * std, force + reach * std, color=Colour.BLUE, alpha=0.3, linewidth=0, label=band
        )
        label = "found, with friction" if found.friction_sought else "found"
        ax.plot(v, force, "-", color=Colour.BLUE, linewidth=1.2, label=label if first else None)
        moving = v != 0
        ax.plot(v[moving], force[moving], ".", color=Colour.BLUE, markersize=4)
    if found.friction_sought:
        ax.plot([0, 0], [-found.friction, found.friction], "-", color=Colour.BLUE, linewidth=1.2)
    damping = found.equivalent_damping()
    ends = nodes[[0, -1]]
    equal = f"{damping:.0f} N s/m, of equal work at {np.sqrt(2) * found.velocity_std:.2g} m/s"
    ax.plot(ends, damping * ends, "--", color=Colour.GREY, linewidth=0.8, label=equal)
    ax.axhline(0.0, color=Colour.PALE, linewidth=0.8, zorder=0)
    ax.axvline(0.0, color=Colour.PALE, linewidth=0.8, zorder=0)
    ax.set_xlabel("velocity [m/s], positive: rebound")
    ax.set_ylabel("force of the damper [N]")
    key_above(ax)
    return ax
