"""A later part of a decay, where its first part makes the result doubtful."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import Settings, find_decays, identify
from suspid.analysis.later import _ring_on, from_later
from suspid.analysis.used import used_of
from suspid.decays import Decays
from suspid.records import as_response, cut
from suspid.units import RealArray
from suspid.words import DecayDoubt, Level, Remark

RATE, HERTZ, FALL = 2000, 88.0, 0.25
TIME = np.arange(10 * RATE) / RATE


def test_what_rings_on_alone_is_used_from_when_another_mode_has_died() -> None:
    """A fork rings for a thousand cycles; its foot, on a spring that hardens, with drag, is still within a second."""
    turn = 2 * np.pi * 18

    def pushed(_: float, y: RealArray) -> RealArray:
        drag = (0.04 * turn + 0.02 * abs(y[1])) * y[1]
        return np.array([y[1], -drag - turn**2 * (y[0] + 0.5 * y[0] ** 3)])

    foot = solve_ivp(pushed, (0.0, TIME[-1]), [0.0, turn], t_eval=TIME, rtol=1e-8, atol=1e-9).y[0]
    fork = 0.2 * np.exp(-FALL * TIME) * np.sin(2 * np.pi * HERTZ * TIME)
    noise = 1e-3 * np.random.default_rng(2).standard_normal(len(TIME))
    record = as_response(TIME, (foot + fork + noise)[None], ["fork"])
    doubt = Remark(DecayDoubt.DRIVEN, {"share": 0.05, "channel": "fork"})
    decay = replace(find_decays(record)[0], start=0.0, stop=float(TIME[-1]), rank=1, doubts=(doubt,))
    stretch = used_of(record, Decays((decay,), ()), decay)
    found = identify(stretch.record)
    assert found.verdict.level is Level.DOUBTFUL
    later = from_later(record, stretch, found, Settings())
    assert later is not None
    again = later.identification
    assert again is not None
    assert later.record.time[0] > 0.4
    assert again.modes.wn / (2 * np.pi) == pytest.approx([HERTZ], rel=1e-5)
    assert again.modes.zeta * again.modes.wn == pytest.approx([FALL], rel=0.02)
    assert _ring_on(again, found)
    # Another mode is none that rings on.
    assert not _ring_on(identify(cut(as_response(TIME, (foot + noise)[None], ["fork"]), stop=0.5), modes=1), found)


@pytest.mark.parametrize(("start", "said"), [(4.0, [4.0]), (2.0, [2.0]), (1.0, []), (0.5, [])])
def test_a_decay_that_is_used_from_before_says_so(start: float, said: list[float]) -> None:
    """A longer one, found after the doubt, refutes it for what lies between."""
    record = as_response(TIME, np.exp(-TIME)[None] * np.cos(20 * TIME), ["seat"])
    doubt = Remark(DecayDoubt.LATER, {"first": 1.0, "start": 4.0})
    decay = replace(find_decays(record)[0], start=start, doubts=(doubt,))
    (used,) = used_of(record, (decay,), decay).used
    assert [doubt.numbers["start"] for doubt in used.doubts] == said
