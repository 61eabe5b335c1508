"""Memory of estimates of drives: it follows the length of the record, not how many stretches or records hold it."""

import tracemalloc

import control
import numpy as np
import pytest
from test_greybox_wheels import NOISE, QUARTER, RATE, driven

from suspid import RecordTest, estimate
from suspid.records import as_response
from suspid.units import Second

LENGTH: Second = 120.0
motions, _ = driven(QUARTER, 1, duration=LENGTH / 4, noise=NOISE)
VALUES = np.tile(np.array(list(motions.values())), (1, 4))


def peak(parts: int = 1, stretch: Second | None = None) -> float:
    """Return the most that an estimate allocates, over the size of the record."""

    def record(values: np.ndarray) -> control.TimeResponseData:
        return as_response(np.arange(values.shape[1]) / RATE, values, list(motions))

    records = [RecordTest(record=record(part), logger="one") for part in np.array_split(VALUES, parts, axis=1)]
    tracemalloc.start()
    estimate(records, QUARTER, given=("tire",), mounts=(), stretch=stretch)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most / VALUES.nbytes


def test_it_does_not_grow_with_the_number_of_stretches() -> None:
    few, many = peak(stretch=8.0), peak(stretch=4.0)
    assert many < 1.1 * few


@pytest.mark.slow
def test_it_does_not_grow_with_the_number_of_records() -> None:
    assert peak(parts=16) < 1.1 * peak()


@pytest.mark.slow
def test_derivatives_are_made_for_some_rows_at_a_time_however_long_stretches_are() -> None:
    """Stretches of 15 s have some 800 rows: 24 of them at a time, as of short ones, would be all of the record."""
    assert peak(stretch=15.0) < 1.1 * peak(stretch=8.0)


def test_few_long_stretches_take_little_more() -> None:
    """A transfer has a value at every line, which is as many bytes as the record where stretches are few."""
    assert peak(stretch=LENGTH / 4) < 1.5 * peak(stretch=8.0)
