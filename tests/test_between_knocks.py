"""What lies between knocks: a sensor that is handled, swings and is caught."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from suspid import Settings, analyse, identify
from suspid.analysis.between_knocks import between_knocks, smoothest
from suspid.analysis.largest import _motions, of_largest
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.signals import Signal
from suspid.units import RealArray
from suspid.words import Level

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


def test_the_smoothest_channel_moves_most_beside_its_roughness() -> None:
    values = np.array([SWING, 0.1 * SWING + 0.1 * RNG.standard_normal(TIME.size), np.zeros(TIME.size)])
    signal = Signal(start=0.0, step=0.01, values=values, channels=("a", "b", "still"))
    assert smoothest(signal, (2.0, 10.0)) == "a"
    swapped = Signal(start=0.0, step=0.01, values=values[::-1].copy(), channels=("still", "b", "a"))
    assert smoothest(swapped, (2.0, 10.0)) == "a"


def test_what_lies_between_is_tried_where_nothing_is_found() -> None:
    record = as_response(TIME, knocked((0, 3), (17, 20), size=2.0)[None], ["a"])
    (*_, last) = _motions(record, largest=True, beside=False)
    assert (last.first, last.last) == pytest.approx((3.0, 16.99), abs=0.6)
    assert last not in list(_motions(record, largest=True, beside=True))
    none = identify(as_response(TIME, RNG.standard_normal((1, TIME.size)), ["a"]))
    used = of_largest(record, Used(record=record, decays=(), used=(), notes=()), none, Settings())
    assert used is not None
    assert used.identification is not None
    assert used.identification.modes.wn == pytest.approx([6.0], rel=1e-3)
    assert used.identification.modes.zeta == pytest.approx([0.1 / 6.0], rel=0.05)


def test_a_motion_beyond_doubt_is_used_before_one_that_is_doubtful(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first is all of the record, hands and all; what is tried next lies between them."""
    record = as_response(TIME, knocked((0, 3), (17, 20), size=2.0)[None], ["a"])
    free, whole = identify(as_response(TIME, SWING[None], ["a"])), used_in(record, 0.0, 19.0)
    poor = identify(cut(as_response(TIME, SWING[None], ["a"]), stop=1.5))
    assert (free.verdict.level, poor.verdict.level) == (Level.SOUND, Level.DOUBTFUL)
    each = iter([replace(whole, identification=poor), replace(used_in(record, 4.0, 16.0), identification=free)])
    monkeypatch.setattr("suspid.analysis.largest._motions", lambda *_, **__: [None, None])
    monkeypatch.setattr("suspid.analysis.largest._far_longer", lambda *_: False)
    monkeypatch.setattr("suspid.analysis.largest._agreed", lambda *_, **__: next(each))
    none = identify(as_response(TIME, RNG.standard_normal((1, TIME.size)), ["a"]))
    used = of_largest(record, whole, none, Settings())
    assert used is not None
    assert used.identification is free


def used_in(record: Any, start: float, stop: float) -> Used:
    return Used(record=cut(record, start=start, stop=stop), decays=(), used=(), notes=())


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
