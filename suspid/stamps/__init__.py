"""Time stamps as files hold them, and the uniform clock behind them.

Stamps may be rounded to any resolution, with rows missing. `grid_of` finds the clock with the fewest missing rows
that rounds to them; `multiples_of` the one of which they are exact samples; `nearest_grid` the regular clock that is
nearest to stamps that also jitter. `continued` undoes that a clock was set back. `rate_and_gaps` says what these mean
for a reader. The packages that hold channels and those that clean them use the same reading.
"""

from suspid.stamps.grids import MOST_PER_ROW, Grid, grid_of
from suspid.stamps.multiples import multiples_of
from suspid.stamps.rounding import FEW, HOLE, Indices, is_uniform, line, resolution
from suspid.stamps.set_backs import MOST_STEPS, are_even, continued
from suspid.stamps.tracking import SHORTEST, nearest_grid, rate_and_gaps

__all__ = [
    "FEW",
    "HOLE",
    "MOST_PER_ROW",
    "MOST_STEPS",
    "SHORTEST",
    "Grid",
    "Indices",
    "are_even",
    "continued",
    "grid_of",
    "is_uniform",
    "line",
    "multiples_of",
    "nearest_grid",
    "rate_and_gaps",
    "resolution",
]
