"""Whole records beside the best decay in them, and parts that are asked for and begin before the release."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import Settings, analyse, as_record, identify
from suspid.analysis.stretch import _surer
from suspid.units import RealArray
from suspid.words import Level, Note


def pendulum(zeta: float, *, rate: float = 200.0) -> tuple[RealArray, RealArray]:
    """Return 10 s of a pendulum on a spring that is not quite linear, .535 Hz at rest, with noise."""
    t, wn = np.arange(0, 10, 1 / rate), 2 * np.pi * 0.535
    swing = solve_ivp(
        lambda _, y: [
            y[1],
            -2 * zeta * wn * y[1] * (1 + abs(y[1]) / 30) - wn**2 * (y[0] - 0.03 * y[0] ** 2 - 0.05 * y[0] ** 3),
        ],
        (0, 10), [-0.8, -2.0], t_eval=t, rtol=1e-9, atol=1e-10,
    )  # fmt: skip
    return t, swing.y[0] + 2.2e-3 * np.random.default_rng(0).standard_normal(t.size)


def test_a_whole_record_with_the_same_mode_and_fewer_doubts_is_used() -> None:
    """The best decay in it lasts for a cycle, from where the noise is met to where the spring is."""
    t, values = pendulum(0.11)
    found = analyse(as_record(values, timepts=t))
    assert len(found.identification.response.time) == t.size
    assert found.verdict.level is Level.CARE
    assert found.modes.wn / (2 * np.pi) == pytest.approx([0.535], rel=0.01)
    assert found.modes.zeta == pytest.approx([0.115], rel=0.03)
    (note,) = [note for note in found.notes if note.code is Note.WHOLE_RECORD]
    assert str(note).startswith("the whole record is used: it shows the modes of the best decay in it (")


@pytest.mark.parametrize("start", [3.0, 8.0])
def test_a_decay_is_sought_within_a_part_that_begins_before_it(start: float) -> None:
    """A part that begins in the decay is used as it is."""
    t = np.arange(4000) / 100
    swing = np.where(t > 7, np.exp(-0.2 * (t - 7)) * np.sin(9 * (t - 7)), 0.0)
    found = analyse(
        as_record(swing + 2e-3 * np.random.default_rng(1).standard_normal(4000), timepts=t),
        settings=Settings(start=start),
    )
    assert found.modes.wn == pytest.approx([9.0], rel=1e-3)
    assert found.verdict.level is Level.SOUND
    assert (Note.SOUGHT_WITHIN in {note.code for note in found.notes}) is (start < 7)
    assert found.identification.response.time[0] == pytest.approx(max(start, 7.0), abs=0.1)


def test_a_part_without_a_decay_has_none() -> None:
    t = np.arange(2000) / 100
    found = analyse(
        as_record(np.random.default_rng(2).standard_normal(2000), timepts=t), settings=Settings(start=2.0, stop=15.0)
    )
    assert not len(found.modes)
    assert "--decay auto" not in str(found.verdict)


def test_what_stands_still_within_a_part_is_no_error() -> None:
    """A switch that is closed later: in a part of the stretch that is asked for, its channel is constant."""
    t = np.arange(1500) / 100
    values = np.array([np.random.default_rng(3).standard_normal(t.size), np.where(t > 8, 1.0, 0.0)])
    for stop in (7.9, 12.0):
        found = analyse(as_record(values, timepts=t), settings=Settings(start=3.0, stop=stop))
        assert not len(found.modes)


def test_a_surer_result_has_the_same_modes_and_is_not_doubtful() -> None:
    t = np.arange(2000) / 100
    swing = np.exp(-0.1 * t) * np.sin(6 * t) + 0.003 * np.random.default_rng(1).standard_normal(t.size)
    sound, doubtful = (identify(as_record(swing[:count], timepts=t[:count])) for count in (2000, 150))
    other = identify(as_record(swing + np.exp(-0.2 * t) * np.sin(31 * t), timepts=t))
    assert [one.verdict.level for one in (sound, doubtful, other)] == [Level.SOUND, Level.DOUBTFUL, Level.SOUND]
    assert _surer(sound, doubtful)
    assert not _surer(doubtful, doubtful)
    assert not _surer(sound, sound)
    assert not _surer(other, doubtful)
    assert not _surer(None, doubtful)
    assert not _surer(sound, None)


@pytest.mark.parametrize(("start", "level"), [(None, Level.SOUND), (0.0, Level.DOUBTFUL)])
def test_an_end_alone_does_not_say_where_the_decay_begins(start: float | None, level: Level) -> None:
    """A pendulum is pulled, let go at 5 s, and lost at last; from the first sample on, poles follow the pull too."""
    t = np.arange(5000) / 100
    pull = np.where(t < 2, 0.0, 0.5 - 0.5 * np.cos(np.pi * (t - 2) / 3))
    swing = np.where(t < 5, pull, np.exp(-0.02 * (t - 5)) * np.cos(3.3 * (t - 5)))
    values = np.where(t < 45, swing + 2e-3 * np.random.default_rng(1).standard_normal(t.size), -1.3)
    found = analyse(as_record(values, timepts=t), settings=Settings(start=start, stop=44.0))
    assert found.verdict.level is level
    assert (Note.SOUGHT_WITHIN in {note.code for note in found.notes}) is (start is None)
    if start is None:
        assert found.modes.wn == pytest.approx([3.3], rel=1e-3)
        assert found.modes.zeta == pytest.approx([0.02 / 3.3], rel=0.02)
