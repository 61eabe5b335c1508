"""A decay beside which the record moves far more: it is said."""

import numpy as np
import pytest

from suspid import Settings, analyse
from suspid.analysis.far_larger import larger_elsewhere
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.units import RealArray
from suspid.words import Note

TIME = np.arange(3000) / 100
KNOCK = np.where(TIME >= 20, np.exp(-1.5 * (TIME - 20)) * np.sin(30 * (TIME - 20)), 0.0)
SWING = np.exp(-0.4 * TIME) * np.sin(9 * TIME)


def notes(values: RealArray, *, start: float = 20.0, stop: float = 24.0) -> list[float]:
    record = as_response(TIME, np.atleast_2d(values), [f"y{k}" for k in range(len(np.atleast_2d(values)))])
    stretch = Used(record=cut(record, start=start, stop=stop), decays=(), used=(), notes=())
    return [float(str(note.numbers["times"])) for note in larger_elsewhere(record, stretch)]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_by_the_root_of_the_mean_square_of_a_part_as_long(scale: float) -> None:
    """Of the swing the first four seconds are the largest part, and 401 samples long as the knock's."""
    size = 0.02
    expected = np.std(SWING[:401]) / np.std(size * KNOCK[2000:2401])
    assert notes(scale * (SWING + size * KNOCK)) == [pytest.approx(expected, rel=0.05)]


def test_not_what_is_as_large_or_is_held_aside() -> None:
    assert notes(SWING + 0.5 * KNOCK) == []
    assert notes(0.5 * KNOCK + np.where(TIME < 10, 100.0, 0.0), start=20, stop=24) != []  # the step is motion
    held = np.where(TIME < 20, 100.0, 0.0)
    assert notes(held + KNOCK) == []


def test_every_channel_moves_more() -> None:
    assert notes(np.stack([SWING + 0.02 * KNOCK, KNOCK])) == []
    assert len(notes(np.stack([SWING + 0.02 * KNOCK, 2 * SWING + 0.02 * KNOCK]))) == 1


def test_a_tenth_of_the_amplitude_is_where_it_begins() -> None:
    ratio = np.std(SWING[:401]) / np.std(KNOCK[2000:2401])
    sizes = [ratio / 10 * share for share in (0.8, 1.2)]
    assert [len(notes(SWING + size * KNOCK)) for size in sizes] == [1, 0]


def test_it_is_said_unless_the_part_was_chosen() -> None:
    noise = 1e-5 * np.random.default_rng(1).standard_normal(TIME.size)
    # Driven at first by what no decay explains, and knocked at later.
    record = as_response(
        TIME, (np.where(TIME < 12, np.sin(7 * TIME + 3 * np.sin(TIME)), 0) + 0.02 * KNOCK + noise)[None], ["y"]
    )
    found = analyse(record)
    assert [note.code for note in found.notes].count(Note.LARGER_ELSEWHERE) == 1
    chosen = analyse(record, settings=Settings(start=20.0))
    assert Note.LARGER_ELSEWHERE not in {note.code for note in chosen.notes}
