"""One mass of two that stops before the other: with it, the modes of both end."""

from __future__ import annotations

from pathlib import Path

import control
import numpy as np
import pytest

from suspid import Decay, Decays, Settings, analyse, identify
from suspid.analysis import first_rest
from suspid.analysis.first_rest import until_one_rests
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.units import RealArray

TIME = np.arange(0, 6, 0.005)
STOP = 3.0


def held_one(*, holds: bool, rest: float = 1.0) -> control.TimeResponseData:
    """Return two masses; the first is held after a time, and the other swings on at a frequency of its own."""

    def both(time: RealArray) -> RealArray:
        slow, fast = (np.exp(-z * w * time) * np.cos(w * time) for z, w in ((0.03, 8.0), (0.02, 21.0)))
        return np.stack([slow + 0.4 * fast, 1.4 * slow - 0.3 * fast])

    values = both(TIME)
    if holds:
        after = TIME > STOP
        values[0, after] = both(np.array([STOP]))[0, 0]
        values[1, after] *= np.cos(6 * (TIME[after] - STOP))
    values += 1e-4 * np.random.default_rng(1).standard_normal(values.shape) * (TIME < STOP)
    return cut(as_response(TIME, values, ["one", "other"]), stop=STOP + rest)


def used(record: control.TimeResponseData) -> Used:
    decay = Decay(
        start=0.0,
        stop=float(record.time[-1]),
        rank=1,
        kind=None,
        level=40.0,
        cycles=5.0,
        strength=60.0,
        wn=np.array([8.0, 21.0]),
        zeta=np.array([0.03, 0.02]),
        doubts=(),
    )
    return Used(record=record, decays=Decays((decay,), ()), used=(decay,), notes=(), identification=identify(record))


def test_the_stretch_ends_where_the_first_mass_rests() -> None:
    record = held_one(holds=True)
    left = until_one_rests(record, used(record), Settings())
    assert left.used[0].stop == pytest.approx(STOP, abs=0.02)
    assert left.identification is not None
    np.testing.assert_allclose(left.identification.modes.wn, [8.0, 21.0], rtol=1e-3)
    np.testing.assert_allclose(left.identification.modes.zeta, [0.03, 0.02], rtol=0.02)


@pytest.mark.parametrize(("holds", "rest"), [(False, 1.0), (True, 0.011), (True, -0.1)])
def test_nothing_is_tried_where_all_move_to_the_end(
    rest: float, monkeypatch: pytest.MonkeyPatch, *, holds: bool
) -> None:
    """Nor where a few samples at the end are alike."""
    record = held_one(holds=holds, rest=rest)
    before = used(record)
    monkeypatch.setattr(first_rest, "settled", lambda _: False)
    monkeypatch.setattr(first_rest, "tried", lambda *_: pytest.fail("a shorter stretch was tried"))
    assert until_one_rests(record, before, Settings()) is before


@pytest.mark.slow
@pytest.mark.parametrize("seed", [6600033, 6600035])
def test_both_modes_of_a_rig_of_which_one_mass_stops_first(seed: int, tmp_path: Path) -> None:
    """The first showed one mode, care, 2 % and 25 % off."""
    from validation.rigs import judged, release, write

    made = release("friction", 2, seed=seed)
    write(made, tmp_path / "rig.csv")
    assert judged(made, analyse(tmp_path / "rig.csv")).right
