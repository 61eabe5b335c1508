"""A decay that no sum of modes explains has a doubtful mode where most of its motion follows one."""

import numpy as np
import pytest

from suspid import Identification, Level, identify
from suspid.records import as_response
from suspid.words import ModeCheck


def softened(*, duration: float, change: float, first: float, last: float) -> Identification:
    """What is found in a mode of 1 Hz whose frequency changes by a share and whose damping changes with time."""
    time = np.arange(0, duration, 0.02)
    share = time / duration
    wn = 2 * np.pi * (1 + change * share)
    zeta = first + (last - first) * share
    decay = np.exp(-np.cumsum(wn * zeta) * 0.02) * np.cos(np.cumsum(wn) * 0.02)
    noise = 0.003 * np.random.default_rng(0).standard_normal(len(time))
    return identify(as_response(time, (decay + noise)[None], ["y"]), band_hz=(0.3, 5.0))


@pytest.mark.parametrize(("duration", "change", "first", "last"), [(24, 0.3, 0.03, 0.06), (24, 0.5, 0.05, 0.05)])
def test_a_mode_that_changes_with_time_is_one_doubtful_mode(
    duration: float, change: float, first: float, last: float
) -> None:
    found = softened(duration=duration, change=change, first=first, last=last)
    assert len(found.modes) == 1
    assert 1.0 < found.modes.wn[0] / (2 * np.pi) < 1 + change
    assert found.verdict.level is Level.DOUBTFUL
    assert ModeCheck.FOLLOWED in {check.remark.code for check in found.verdict.checks}


@pytest.mark.slow
def test_a_random_walk_turns_by_no_mode_or_a_doubtful_one() -> None:
    turns = 0
    for seed in range(12):
        walk = np.cumsum(np.random.default_rng(seed).standard_normal(800))
        found = identify(as_response(np.arange(800) / 100, walk[None], ["y"]))
        turns += "pair" in found.modes.kinds
        assert not len(found.modes) or found.verdict.level is Level.DOUBTFUL
    assert turns <= 2
