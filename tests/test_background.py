"""Intervals of modes that a background excites during their decay, against the scatter of many records."""

import numpy as np
import pytest
from scipy.signal import lfilter

from suspid import as_record, find_decays, identify
from suspid.analysis.background import with_background
from suspid.analysis.used import used_of
from suspid.units import RealArray
from suspid.words import DecayDoubt, Note, Remark

FS, START, LENGTH = 50.0, 60.0, 12.0
WN, ZETA = 2 * np.pi * 1.3, 0.06
POLE = WN * complex(-ZETA, np.sqrt(1 - ZETA**2))


def driven(seed: int, level: float) -> tuple[RealArray, RealArray]:
    """Return a mass that a rough road shakes all the time, and that a bump at `START` sets moving besides."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, 150, 1 / FS)
    ahead = np.exp(POLE / FS)
    shaken = np.real(lfilter([1.0], [1.0, -ahead], rng.standard_normal(time.size) + 0j))
    shaken *= level / np.std(shaken)
    since = time - START
    decay = np.where(since >= 0, np.real(np.exp(POLE * np.maximum(since, 0))), 0.0)
    return time, decay + shaken + 2e-3 * rng.standard_normal(time.size)


def errors(seed: int, level: float) -> tuple[RealArray, RealArray, tuple[Note, ...]]:
    """Return the errors of wn and zeta in standard deviations, before and after, and what is said."""
    time, values = driven(seed, level)
    record = as_record(values, timepts=time)
    decays = find_decays(record, given=[(START, START + LENGTH)])
    stretch = used_of(record, decays, decays[0])
    before = identify(stretch.record)
    after, used = with_background(before, stretch, record)
    out = []
    for modes in (before.modes, after.modes):
        k = int(np.argmin(np.abs(modes.poles - POLE)))
        assert modes.wn_std is not None
        assert modes.zeta_std is not None
        out.append([(modes.wn[k] - WN) / modes.wn_std[k], (modes.zeta[k] - ZETA) / modes.zeta_std[k]])
    return np.array(out[0]), np.array(out[1]), tuple(note.code for note in used.notes)  # type: ignore[misc]


@pytest.mark.slow
def test_intervals_hold_what_a_background_does() -> None:
    """95 % of them, give or take what the estimate of the background scatters; of white noise alone, they do not."""
    found = [errors(seed, 0.03) for seed in range(24)]
    before, after = np.array([each[0] for each in found]), np.array([each[1] for each in found])
    assert np.mean(np.abs(before) < 1.96) < 0.8
    assert np.mean(np.abs(after) < 1.96) > 0.88
    assert np.mean([Note.WIDENED in notes for *_, notes in found]) > 0.5
    # They are no wider than that takes.
    assert np.sqrt(np.mean(after**2)) > 0.6


def test_intervals_of_a_calm_recording_stay() -> None:
    before, after, notes = errors(1, 1e-6)
    np.testing.assert_array_equal(before, after)
    assert Note.WIDENED not in notes


def test_the_note_says_which_and_how_much() -> None:
    both = Remark(Note.WIDENED, {"modes": (1, 3), "times": (3.14, 2.0)})
    assert "the intervals of modes 1 and 3 are 3.1 and 2 times as wide" in str(both)
    assert "of mode 2 are 12 times" in str(Remark(Note.WIDENED, {"modes": (2,), "times": (12.3,)}))


def test_the_doubt_is_the_reason() -> None:
    time, values = driven(2, 0.03)
    record = as_record(values, timepts=time)
    doubts = {doubt.code for doubt in find_decays(record, given=[(START, START + LENGTH)])[0].doubts}
    assert DecayDoubt.BACKGROUND in doubts
