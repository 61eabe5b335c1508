"""Parts of a record that are tried with a few samples less at their ends."""

from dataclasses import replace

import numpy as np
import pytest

from suspid import Settings, identify
from suspid.analysis.explained_parts import explains_swings, shortened, used_instead
from suspid.analysis.used import Used
from suspid.decays import STARTS_AFTER_REST
from suspid.levels import FEWEST_SAMPLES
from suspid.records import as_response
from suspid.words import Note

TIME = np.arange(300) / 100
RECORD = as_response(TIME, (np.exp(-TIME) * np.cos(20 * TIME))[None], ["seat"])


@pytest.mark.parametrize("stop", [None, 2.5])
def test_each_has_fewer_samples_at_its_start_and_at_its_end_if_that_is_not_the_records(stop: float | None) -> None:
    parts = [part.time for part, _ in shortened(RECORD, 0.5, stop, Settings())]
    assert [time[0] for time in parts] == pytest.approx([0.5 + less / 100 for less in STARTS_AFTER_REST])
    ends = [TIME[-1] if stop is None else stop - less / 100 for less in STARTS_AFTER_REST]
    assert [time[-1] for time in parts] == pytest.approx(ends)


@pytest.mark.parametrize(("fewer", "tried"), [(0, 3), (1, 0)])
def test_none_is_tried_where_too_few_would_be_left(fewer: int, tried: int) -> None:
    count = FEWEST_SAMPLES + 2 * STARTS_AFTER_REST[-1] - fewer
    assert len(list(shortened(RECORD, 0.5, 0.5 + (count - 1) / 100, Settings()))) == tried


def test_what_leaves_more_than_noise_or_never_swings_is_not_explained() -> None:
    found = identify(RECORD)
    assert explains_swings(found)
    assert not explains_swings(replace(found, loudness=np.array([20.0])))
    assert not explains_swings(identify(as_response(TIME, np.exp(-3 * TIME)[None], ["seat"])))


def test_the_note_says_from_when_to_when() -> None:
    before = Used(record=RECORD, decays=(), used=(), notes=())
    (part, found), *_ = shortened(RECORD, 0.5, 2.5, Settings())
    assert found is not None
    used = used_instead(before, part, found, Note.UNTIL_LOCKED)
    assert (used.record, used.identification) == (part, found)
    assert [str(note).split(" is used")[0] for note in used.notes] == ["the motion from 0.5 to 2.5 s"]
