"""Memory that estimates of drives take beside the records."""

from __future__ import annotations

import tracemalloc

import numpy as np

from suspid import estimate
from suspid.greybox.wheel_problem import BELOW, STRETCH_PERIODS, band_of
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.text_tables import text_table
from validation.greybox_rows import given_row
from validation.motion import Drive

MINUTES = (5, 20, 40)
RATE = 200.0
FIRST = 60.0  # s of which longer drives are made, one after the other: memory does not depend on what is in them


def memory_table() -> str:
    """Return the peak of what `estimate` allocates, over the size of the record, by the length of the drive."""
    columns: dict[str, list[str]] = {
        "drive": [],
        "stretches": [],
        "record [MB]": [],
        "peak [MB]": [],
        "peak / record": [],
    }
    for minutes in MINUTES:
        record, peak, stretches = measured(minutes)
        cells = (f"{minutes} min", str(stretches), f"{record / 1e6:.1f}", f"{peak / 1e6:.0f}", f"{peak / record:.1f}")
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(cell)
    return text_table(columns)


def measured(minutes: float) -> tuple[int, int, int]:
    """Return the bytes of a record, the peak of what its estimate allocates, and the number of stretches."""
    row = given_row("", Drive(duration=FIRST, rate=RATE))
    short = as_signal(row.record(np.random.default_rng(1)))
    values = np.tile(short.values, (1, round(60 * minutes / FIRST)))
    record = as_response(np.arange(values.shape[1]) / RATE, values, short.channels)
    stretch = STRETCH_PERIODS * BELOW / band_of(row.nominal)[0]
    tracemalloc.start()
    estimate(record, row.nominal, given=row.given, fixed=row.fixed)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return values.nbytes, peak, int(60 * minutes / stretch)
