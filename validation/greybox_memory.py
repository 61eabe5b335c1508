"""Memory that estimates of drives take beside the records."""

from __future__ import annotations

import tracemalloc

import numpy as np

from suspid import RecordTest, estimate
from suspid.greybox.wheel_problem import BELOW, STRETCH_PERIODS, band_of
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.text_tables import text_table
from suspid.units import Second
from validation.greybox_rows import given_row
from validation.motion import Drive

# Minutes, records that hold them, and seconds of a stretch; without these it is eight periods of the lowest mode.
CASES: tuple[tuple[int, int, Second | None], ...] = (
    (5, 1, None), (20, 1, None), (40, 1, None), (20, 4, None), (20, 40, None), (20, 1, 4.0), (20, 1, 12.0),
    (20, 1, 24.0), (20, 1, 150.0),
)  # fmt: skip
RATE = 200.0
FIRST: Second = 60.0  # of which longer drives are made, one after the other: memory does not depend on what is in them


def memory_table() -> str:
    """Return the peak of what `estimate` allocates, over the size of the record, by what the drive is divided into."""
    columns: dict[str, list[str]] = {
        name: [] for name in ("drive", "records", "stretches", "record [MB]", "peak [MB]", "peak / record")
    }
    for minutes, parts, stretch in CASES:
        record, peak, stretches = measured(minutes, parts, stretch)
        sizes = f"{record / 1e6:.1f}", f"{peak / 1e6:.0f}", f"{peak / record:.1f}"
        for column, cell in zip(columns.values(), (f"{minutes} min", str(parts), str(stretches), *sizes), strict=True):
            column.append(cell)
    return text_table(columns)


def measured(minutes: float, parts: int, stretch: Second | None) -> tuple[int, int, int]:
    """Return the bytes of all records, the peak of what their estimate allocates, and the number of stretches."""
    row = given_row("", Drive(duration=FIRST, rate=RATE))
    short = as_signal(row.record(np.random.default_rng(1)))
    values = np.tile(short.values, (1, round(60 * minutes / FIRST)))
    records = [
        RecordTest(record=as_response(np.arange(part.shape[1]) / RATE, part, short.channels), logger="one")
        for part in np.array_split(values, parts, axis=1)
    ]
    length = STRETCH_PERIODS * BELOW / band_of(row.nominal)[0] if stretch is None else stretch
    tracemalloc.start()
    estimate(records, row.nominal, given=row.given, fixed=row.fixed, stretch=stretch)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return values.nbytes, peak, parts * int(60 * minutes / parts / length)
