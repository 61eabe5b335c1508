"""The part of a page on sensitivities of modes and figures to springs and dampers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError
from suspid.files import printable
from suspid.performance import Sensitivities, per_cent, sensitivities
from suspid.reporting.numerals import signed
from suspid.reporting.pictures import NARROW, WIDE, Picture, picture
from suspid.reporting.plot_sensitivities import plot_sensitivities
from suspid.reporting.svg import page_style
from suspid.text_tables import figures_of
from suspid.units import UNITS, in_print
from suspid.values import frozen_real

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from suspid.greybox import Estimate
    from suspid.performance import Ride
    from suspid.reconstruction import Reconstruction

# Figures that repeat what others say: a dose follows its weighted rms, a peak its rms, a share of the load the load.
REPEATED = (".rms", ".VDV", ".MSDV", ".crest", ".peak_travel", ".load_share", ".lifts", ".lift_rate", ".stops")
# Parameters that a row of the table names, and the least change that is worth it [% for each %].
MOST_MOVERS, LEAST_MOVE = 3, 0.05
# Columns of a picture next to each other, of the width of a phone and of the page.
MOST_ABREAST = {NARROW: 5, WIDE: 12}
# Heights of a row of a picture and of what stands around each part of it [inch].
ROW_HEIGHT, PART_HEIGHT = 0.24, 0.75
# Units of figures on a test bench, as test benches show them, in SI units; those of a ride come with it.
OF_BENCH = {"adhesion": ("%", 0.01), "phase": ("deg", float(np.radians(1.0)))}
# Room next to the names of rows, which a browser may set wider than matplotlib does [inch].
ROOM_BESIDE_ROWS = 0.1


@dataclass(frozen=True, kw_only=True, slots=True)
class MoverRow:
    """A mode or figure with its value, and what moves it most."""

    name: str
    value: str
    unit: str
    movers: str


def sensitivities_of(found: Estimate | Reconstruction | None, ride: Ride | None) -> Sensitivities | None:
    """Return what moves the modes and figures of a car that was found; None without one, or of one that has none.

    Examples
    --------
    >>> sensitivities_of(None, None) is None
    True
    """
    if found is None:
        return None
    try:
        if ride is None:
            return sensitivities(found, bench=True)
        return sensitivities(
            found, road=ride.road, duration=ride.duration, weightings=dict(ride.weightings), bench=True
        )
    except InputError:
        return None


def sensitivity_fields(found: Sensitivities | None, ride: Ride | None) -> dict[str, object]:
    """Return what the templates show of sensitivities; nothing where there are none."""
    if found is None or not found.parameters:
        return {"movers": [], "mover_picture": None}
    told = _told(found)
    with page_style():
        return {"movers": _rows(told, ride), "mover_picture": _picture(told)}


def _told(found: Sensitivities) -> Sensitivities:
    """Return the rows that do not repeat others."""
    use = [i for i, name in enumerate(found.names) if not name.endswith(REPEATED)]
    return replace(
        found,
        names=tuple(found.names[i] for i in use),
        values=frozen_real(found.values[use]),
        units=tuple(found.units[i] for i in use),
        elasticity=frozen_real(found.elasticity[use]),
    )


def _rows(found: Sensitivities, ride: Ride | None) -> list[MoverRow]:
    units = {} if ride is None else dict(zip(ride.figures, ride.units, strict=True))
    rows = []
    for name, value, row in zip(found.names, found.values.tolist(), found.elasticity, strict=True):
        figure = name.rpartition(".")[2]
        unit, size = OF_BENCH.get(figure, (units.get(name, UNITS.get(figure, "")), 1.0))
        order = [i for i in np.argsort(-np.abs(row)) if abs(row[i]) >= LEAST_MOVE]
        rows.append(
            MoverRow(
                name=printable(name),
                value=signed(figures_of(value / size)),
                unit=in_print(unit),
                movers=", ".join(
                    f"{printable(found.parameters[i])} {signed(per_cent(float(row[i])))}" for i in order[:MOST_MOVERS]
                ),
            )
        )
    return rows


def _picture(found: Sensitivities) -> Picture:
    described = "Change of each mode and figure by each spring and damper, in per cent for each per cent"
    narrow, wide = (_parts(found, width) * (PART_HEIGHT + ROW_HEIGHT * len(found.names)) for width in MOST_ABREAST)
    return picture(partial(_draw, found), name="movers", described=described, height=narrow, wide_height=wide)


def _parts(found: Sensitivities, width: float) -> int:
    return -(-len(found.parameters) // MOST_ABREAST[width])


def _draw(found: Sensitivities, figure: Figure) -> None:
    figure.set_layout_engine("constrained", w_pad=ROOM_BESIDE_ROWS)
    parts = _parts(found, float(figure.get_size_inches()[0]))
    axes = figure.subplots(parts, 1, squeeze=False)[:, 0]
    for ax, part in zip(axes, np.array_split(np.arange(len(found.parameters)), parts), strict=True):
        some = replace(
            found,
            parameters=tuple(found.parameters[i] for i in part),
            elasticity=frozen_real(found.elasticity[:, part]),
        )
        plot_sensitivities(some, ax)
        ax.set_xlabel("")
