"""Swings that fall more later on than at first, or grow again, are not those of free motion."""

from pathlib import Path

import numpy as np
import pytest

from suspid import analyse
from suspid.analysis.late_falls import _falls_late
from suspid.units import RealArray
from suspid.words import Level, RecordCheck

T = np.arange(3000) / 100
SWINGS = np.sin(2 * np.pi * 1.3 * T)


@pytest.mark.parametrize(
    "envelope",
    [
        np.exp(-0.1 * T),
        1 - 0.9 * T / 30,
        # Friction that doubles as the speed falls to zero.
        np.interp(T, [0, 10, 20, 30], [1.0, 0.75, 0.46, 0.12]),
        1 / (1 + T / 3),
        # Hardly anything falls: drifts decide.
        1 - 0.3 * (T / 30) ** 3,
    ],
)
def test_of_free_motion_they_fall_most_at_first(envelope: RealArray) -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    assert not _falls_late(envelope * SWINGS + noise)


@pytest.mark.parametrize("envelope", [np.cos(np.pi / 2 * 0.98 * T / 30), 1 + 0.9 * np.cos(2 * np.pi * T / 60)])
def test_of_a_beat_and_of_what_is_driven_by_less_and_less_they_do_not(envelope: RealArray) -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    assert _falls_late(envelope * SWINGS + noise)


def test_those_that_grow_again_are_not_free() -> None:
    assert _falls_late((1.2 + np.cos(2 * np.pi * T / 40)) * SWINGS)


def test_few_swings_do_not_tell() -> None:
    assert not _falls_late(np.cos(np.pi / 2 * T / 30) * np.sin(2 * np.pi * 0.12 * T))


def test_a_modulated_tone_is_doubted(tmp_path: Path) -> None:
    """A fan of 2 Hz whose speed stays, and whose push wanes and comes back."""
    t = np.arange(5000) / 100
    pushed = (1 + 0.9 * np.cos(2 * np.pi * t / 60)) * np.sin(2 * np.pi * 2 * t)
    noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    path = tmp_path / "fan.csv"
    np.savetxt(
        path, np.column_stack([t, pushed + noise]), fmt="%.5f", delimiter=",", header="t [s],a [m/s2]", comments=""
    )
    verdict = analyse(path).verdict
    assert verdict.level <= Level.DOUBTFUL
    assert not len(verdict.checks) or RecordCheck.FALLS_LATE in {check.remark.code for check in verdict.checks}
