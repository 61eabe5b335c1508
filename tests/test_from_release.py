"""A mass that is let go and recorded for a few large cycles, without a background after them."""

import numpy as np
import pytest

from suspid import Identification, Settings, identify
from suspid.analysis.from_release import from_release
from suspid.analysis.used import Used
from suspid.records import as_response
from suspid.units import RealArray
from validation import rigs
from validation.no_decay import KINDS

TIME = np.arange(230) / 115.0
NONE = identify(as_response(TIME, np.random.default_rng(3).standard_normal((1, TIME.size)), ["x"]))


def let_go(zeta: float = 0.05) -> RealArray:
    since = np.maximum(TIME - 0.8, 0.0)
    return np.asarray(np.exp(-zeta * 16.2 * since) * np.cos(16.2 * np.sqrt(1 - zeta**2) * since))


def used(values: RealArray, found: Identification = NONE) -> Used | None:
    record = as_response(TIME, values[None], ["x"])
    return from_release(record, Used(record=record, decays=(), used=(), notes=()), found, Settings())


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_all_of_the_motion_is_used_from_its_release_on(noise: float) -> None:
    """Held in steps of an encoder, and within noise."""
    values = np.round(let_go() / 2e-3) * 2e-3 + noise * np.random.default_rng(1).standard_normal(TIME.size)
    part = used(values)
    assert part is not None
    assert part.identification is not None
    assert part.record.time[0] == pytest.approx(0.8, abs=0.03)
    assert part.record.time[-1] == TIME[-1]
    assert part.identification.modes.wn == pytest.approx([16.2], rel=0.01)
    assert part.identification.modes.zeta == pytest.approx([0.05], rel=0.1)


def test_nothing_is_sought_where_modes_are_found() -> None:
    swing = as_response(TIME, (np.exp(-TIME) * np.cos(20 * TIME))[None], ["x"])
    assert used(let_go(), identify(swing)) is None


def test_what_moves_from_the_start_was_not_let_go() -> None:
    assert used(np.exp(-0.8 * TIME) * np.cos(16.2 * TIME)) is None


def test_what_is_driven_after_a_rest_has_no_modes() -> None:
    rng = np.random.default_rng(5)
    road = np.convolve(rng.standard_normal(TIME.size), np.hanning(9), "same")
    assert used(np.where(TIME > 0.8, road, 0.0) + 0.01 * rng.standard_normal(TIME.size)) is None


@pytest.mark.parametrize("seed", [761_001, 761_011])
def test_what_brakes_has_no_modes(seed: int) -> None:
    """Doubtful modes follow any motion after a rest."""
    time, values = KINDS["braking"](np.random.default_rng(seed))
    record = as_response(time, values, [f"y{k}" for k in range(len(values))])
    assert from_release(record, Used(record=record, decays=(), used=(), notes=()), NONE, Settings()) is None


def test_the_first_command_uses_it() -> None:
    """Three cycles at 116 Hz, of which the first alone rises above a background."""
    one = rigs.outcome("friction", 1, 910_032)
    assert one.right
    assert abs(one.wn) < 0.01
