"""What lies between knocks: a sensor that is handled, swings and is caught."""

import numpy as np
import pytest

from suspid import Identification, Settings, analyse, identify
from suspid.analysis.between_knocks import between_knocks, without_knocks
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.signals import Signal
from suspid.units import RealArray
from suspid.words import Level, Note

TIME = np.arange(2000) / 100
RNG = np.random.default_rng(1)
SWING = np.exp(-0.1 * TIME) * np.sin(6 * TIME) + 0.003 * RNG.standard_normal(TIME.size)


def knocked(*times: tuple[float, float], size: float = 0.5) -> RealArray:
    """Return the swing with a rough hand between these times."""
    hand = size * np.random.default_rng(2).standard_normal(TIME.size)
    return np.asarray(SWING + sum(np.where((start <= TIME) & (stop > TIME), hand, 0.0) for start, stop in times))


def span(values: RealArray) -> tuple[float, float] | None:
    return between_knocks(
        Signal(start=2.0, step=0.01, values=np.atleast_2d(values), channels=("a", "b")[: values.ndim])
    )


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (knocked((0, 3), (17, 20)), (5.0, 19.0)),
        (knocked((15, 20)), (2.0, 17.0)),
        (knocked((4, 5)), (7.0, 21.99)),
        (np.array([SWING, knocked((0, 8))]), (10.0, 21.99)),
    ],
)
def test_the_longest_time_without_a_knock_in_any_channel(values: RealArray, expected: tuple[float, float]) -> None:
    assert span(values) == pytest.approx(expected, abs=0.6)
    found = span(values)
    assert found is not None
    assert expected[0] - 1e-9 <= found[0] < found[1] <= expected[1] + 1e-9


def test_none_where_none_is_knocked_or_never_for_long() -> None:
    assert span(SWING) is None
    assert span(np.exp(-0.4 * TIME) * np.sin(6 * TIME)) is not None
    assert span(knocked(*((k, k + 0.5) for k in range(0, 20, 4)))) is None
    assert span(SWING[:60]) is None


def used_of(start: float, stop: float, values: RealArray) -> Used:
    part = cut(as_response(TIME, values[None], ["phone"]), start=start, stop=stop)
    return Used(record=part, decays=(), used=(), notes=())


class TestWithoutKnocks:
    values = knocked((0, 3), (17, 20))
    record = as_response(TIME, values[None], ["phone"])

    def tried(self, found: Identification, stretch: Used, settings: Settings | None = None) -> Used | None:
        """Return what is used instead, where what lies between is sound."""
        free = identify(as_response(TIME, SWING[None], ["phone"]))
        between = used_of(3.5, 16.5, self.values)
        again = without_knocks(self.record, found, stretch, settings or Settings(), lambda _: (free, None, between))
        return None if again is None else again[1]

    def test_nothing_or_what_is_doubtful_gives_way_to_what_is_beyond_doubt(self) -> None:
        none = identify(as_response(TIME, RNG.standard_normal((1, TIME.size)), ["phone"]))
        assert not len(none.modes)
        used = self.tried(none, used_of(0.0, 2.5, self.values))
        assert used is not None
        assert [note.code for note in used.notes] == [Note.BETWEEN_KNOCKS]
        assert self.tried(none, used_of(0.0, 2.5, self.values), Settings(start=1.0)) is None

    def test_what_is_beyond_doubt_stays_unless_it_is_of_a_knock_beside_as_much(self) -> None:
        sound = identify(as_response(TIME, SWING[None], ["phone"]))
        assert sound.verdict.level > Level.DOUBTFUL
        assert self.tried(sound, used_of(5.0, 19.0, self.values)) is None
        assert self.tried(sound, used_of(17.5, 19.5, self.values)) is not None
        # A blow on what hangs still: between blows hardly anything moves.
        assert self.tried(sound, used_of(17.5, 19.5, 100 * self.values)) is None

    def test_what_is_doubtful_itself_is_no_better(self) -> None:
        none = identify(as_response(TIME, RNG.standard_normal((1, TIME.size)), ["phone"]))
        stretch = used_of(0.0, 2.5, self.values)
        assert without_knocks(self.record, none, stretch, Settings(), lambda _: (none, None, stretch)) is None


@pytest.mark.slow
def test_a_phone_that_is_handled_swings_and_is_caught() -> None:
    """.73 Hz for 18 cycles in two of three channels; hands shake all three before and after."""
    rng = np.random.default_rng(36)
    hertz, zeta, cycles = rng.uniform(0.5, 1.8), rng.uniform(0.005, 0.03), rng.uniform(7, 20)
    begin, after = rng.uniform(0.5, 2), rng.uniform(0.5, 1.5)
    end = begin + cycles / hertz
    t = np.arange(0, end + after, 0.01)
    since = np.clip(t - begin, 0, None)
    free = np.where((t > begin) & (t < end), np.exp(-zeta * 2 * np.pi * hertz * since), 0.0)
    swing = free * np.cos(2 * np.pi * hertz * since)

    def hand(size: float) -> RealArray:
        return np.asarray(size * np.convolve(rng.standard_normal(t.size), np.hanning(9), "same"))

    held, caught = np.where(t < begin, 1.0, np.exp(-8 * since)), np.where(t > end, 1.0, 0.0)
    values = np.array(
        [
            swing + hand(0.4) * held + hand(1.0) * caught,
            0.15 * swing + hand(0.3) * held + hand(0.8) * caught,
            hand(0.2) * held + hand(0.5) * caught,
        ]
    )
    found = analyse(as_response(t, values + 0.01 * rng.standard_normal(values.shape), ["x", "y", "z"]))
    assert found.modes.wn / (2 * np.pi) == pytest.approx([hertz], rel=1e-3)
    assert found.modes.zeta == pytest.approx([zeta], rel=0.03)
    assert found.verdict.level is Level.CARE
