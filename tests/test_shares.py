"""How much of a recording's motion a decay has: of many stretches of driven motion some look like a decay."""

import numpy as np
import pytest

from suspid import Decay, analyse
from suspid.decays import by_chance
from suspid.decays.shares import with_doubt_of_share
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


def share_said(decay: Decay) -> tuple[float, float] | None:
    said = [doubt for doubt in decay.doubts if doubt.code is DecayDoubt.SMALL_PART]
    return (float(said[0].numbers["share"]), float(said[0].numbers["together"])) if said else None  # type: ignore[arg-type]


def test_share_of_a_steady_tone_is_that_of_the_time() -> None:
    (decay,) = with_doubt_of_share(hum(), [stretch(20, 24, 4.0, DecayDoubt.TOO_SHORT)])
    assert share_said(decay) == pytest.approx((0.04, 0.04), abs=0.002)
    assert by_chance(decay)
    (decay,) = with_doubt_of_share(hum(), [stretch(20, 32, 4.0, DecayDoubt.TOO_SHORT)])
    assert share_said(decay) is None
    (decay,) = with_doubt_of_share(hum(), [stretch(20, 24, 4.0)])
    assert not decay.doubts


def test_decays_with_the_same_modes_count_together() -> None:
    twice = [stretch(20, 26, 4.0, DecayDoubt.TOO_SHORT), stretch(60, 66, 4.05)]
    assert share_said(with_doubt_of_share(hum(), twice)[0]) is None
    apart = [stretch(20, 26, 4.0, DecayDoubt.TOO_SHORT), stretch(60, 66, 4.3)]
    assert share_said(with_doubt_of_share(hum(), apart)[0]) == pytest.approx((0.06, 0.06), abs=0.002)


def test_others_do_not_speak_for_a_decay_that_no_fit_explains() -> None:
    twice = [stretch(20, 26, 4.0, DecayDoubt.NONLINEAR), stretch(60, 66, 4.05)]
    decay = with_doubt_of_share(hum(), twice)[0]
    assert share_said(decay) == pytest.approx((0.06, 0.12), abs=0.003)
    # It is doubted, but not by chance.
    assert not by_chance(decay)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["speech-like modulation", "braking", "Gaussian pulse"])
def test_first_command_on_records_without_a_decay(kind: str) -> None:
    from validation import no_decay

    for seed in (900, 901, 902, 903):
        time, values = no_decay.KINDS[kind](np.random.default_rng(seed))
        found = analyse(as_response(time, values, [f"y{k}" for k in range(len(values))]))
        assert not len(found.modes) or found.verdict.level is Level.DOUBTFUL, (seed, found.modes)
