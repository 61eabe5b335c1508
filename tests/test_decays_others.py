"""What is beside a decay in a recording: of many stretches of driven motion some look like a decay."""

from dataclasses import replace

import numpy as np
import pytest

from suspid import Decay, analyse
from suspid.decays import by_chance
from suspid.decays.others import with_doubts_of_others
from suspid.records import as_response
from suspid.signals import Signal
from suspid.words import DecayDoubt, Level, Remark

STEP = 0.01


def hum() -> Signal:
    """Return a tone of one size, whose power is the same in each part: 100 s of 4 Hz."""
    values = np.sin(8 * np.pi * STEP * np.arange(10_000))[None]
    return Signal(start=0.0, step=STEP, values=values, channels=("seat",))


def stretch(start: float, stop: float, hertz: float, *codes: DecayDoubt) -> Decay:
    doubts = tuple(Remark(code, {"share": 0.1, "decibel": 7.0, "cycles": 2.0, "hertz": 4.0}) for code in codes)
    wn, zeta = np.array([2 * np.pi * hertz]), np.array([0.05])
    return Decay(
        start=start,
        stop=stop,
        rank=1,
        kind=None,
        level=40.0,
        cycles=9.0,
        strength=50.0,
        wn=wn,
        zeta=zeta,
        doubts=doubts,
    )


def share_said(decay: Decay) -> object:
    said = [doubt.numbers["share"] for doubt in decay.doubts if doubt.code is DecayDoubt.SMALL_PART]
    return said[0] if said else None


def test_share_of_a_steady_tone_is_that_of_the_time() -> None:
    (decay,) = with_doubts_of_others(hum(), [stretch(20, 24, 4.0, DecayDoubt.NONLINEAR)])
    assert share_said(decay) == pytest.approx(0.04, abs=0.002)
    assert "4 % of the motion" in str(decay.doubts[-1])
    (decay,) = with_doubts_of_others(hum(), [stretch(20, 32, 4.0, DecayDoubt.NONLINEAR)])
    assert share_said(decay) is None


def test_the_free_end_of_a_car_that_is_pushed_may_be_a_small_part() -> None:
    for doubts in ((), (DecayDoubt.TOO_SHORT,)):
        (decay,) = with_doubts_of_others(hum(), [stretch(20, 24, 4.0, *doubts)])
        assert tuple(doubt.code for doubt in decay.doubts) == doubts


def test_a_doubted_decay_among_many_with_other_modes_is_doubted_more() -> None:
    others = [stretch(first, first + 15, hertz) for first, hertz in ((0, 5.0), (20, 6.0), (40, 7.0), (60, 8.0))]
    *same, last = with_doubts_of_others(hum(), [*others, stretch(80, 95, 4.0, DecayDoubt.TOO_SHORT)])
    assert DecayDoubt.COMPANY in {doubt.code for doubt in last.doubts}
    assert by_chance(last)
    assert not any(decay.doubts for decay in same)
    # Three others may be chance.
    *_, last = with_doubts_of_others(hum(), [*others[:3], stretch(80, 95, 4.0, DecayDoubt.TOO_SHORT)])
    assert DecayDoubt.COMPANY not in {doubt.code for doubt in last.doubts}


@pytest.mark.parametrize(("level", "doubted"), [(40.0, True), (19.0, False)])
def test_what_moves_a_tenth_as_much_tells_nothing_of_a_decay(level: float, *, doubted: bool) -> None:
    """Between the plucks of a beam knocks of another kind look like decays, too."""
    others = [replace(stretch(first, first + 15, 5.0 + first / 20), level=level) for first in (0, 20, 40, 60)]
    *_, last = with_doubts_of_others(hum(), [*others, stretch(80, 95, 4.0, DecayDoubt.TOO_SHORT)])
    assert (DecayDoubt.COMPANY in {doubt.code for doubt in last.doubts}) == doubted


@pytest.mark.parametrize("seed", [901, pytest.param(911, marks=pytest.mark.slow)])
def test_a_pulse_that_never_swings_is_no_decay(seed: int) -> None:
    from validation import no_decay

    time, values = no_decay.KINDS["half-sine pulse"](np.random.default_rng(seed))
    found = analyse(as_response(time, values, [f"y{k}" for k in range(len(values))]))
    assert not len(found.modes)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["speech-like modulation", "braking", "Gaussian pulse"])
def test_first_command_on_records_without_a_decay(kind: str) -> None:
    from validation import no_decay

    for seed in (900, 901, 902, 903):
        time, values = no_decay.KINDS[kind](np.random.default_rng(seed))
        found = analyse(as_response(time, values, [f"y{k}" for k in range(len(values))]))
        assert not len(found.modes) or found.verdict.level is Level.DOUBTFUL, (seed, found.modes)
