"""Angles and counts that wrap round: the motion comes back, and other jumps stay as they are."""

from pathlib import Path

import numpy as np
import pytest

from suspid import analyse
from suspid.cleaning.wraps import unwrapped
from suspid.units import RealArray
from suspid.words import Defect

T = np.arange(3000, dtype=np.float64) / 100
SWING: RealArray = 0.35 * np.exp(-0.04 * T) * np.cos(4.0 * T)


def jumps(values: RealArray) -> int:
    _, findings = unwrapped("angle", T, values)
    return sum(finding.samples for finding in findings)


class TestContinued:
    @pytest.mark.parametrize(
        ("turn", "digits"), [(2 * np.pi, 9), (2 * np.pi, 4), (360.0, 3), (4096.0, 0), (65536.0, 0)]
    )
    @pytest.mark.parametrize("start", [0.0, 0.3, -0.2])
    def test_the_motion_comes_back(self, turn: float, digits: int, start: float) -> None:
        """In parts of a turn, from a rest that is not where the range ends, too."""
        motion = np.round(turn * (SWING / (2 * np.pi) + start / (2 * np.pi)), digits)
        written = np.round(motion % turn, digits)
        values, findings = unwrapped("angle", T, written)
        np.testing.assert_allclose(values - values[0], motion - motion[0], atol=1.1 * 10.0**-digits)
        assert [finding.kind for finding in findings] == [Defect.WRAPPED]

    def test_half_a_turn_to_either_side(self) -> None:
        motion = 180 + np.degrees(SWING)
        values, _ = unwrapped("angle", T, (motion + 180) % 360 - 180)
        np.testing.assert_allclose(values - values[0], motion - motion[0], atol=1e-9)

    def test_what_turns_on_goes_on(self) -> None:
        values, _ = unwrapped("angle", T, (30 * T) % 360)
        np.testing.assert_allclose(values, 30 * T, atol=1e-9)

    def test_gaps_are_left(self) -> None:
        motion = np.degrees(SWING) % 360
        motion[700:720] = np.nan
        values, _ = unwrapped("angle", T, motion)
        assert np.isnan(values).sum() == 20
        np.testing.assert_allclose(values[800] - values[0], np.degrees(SWING[800] - SWING[0]))


class TestLeftAlone:
    def test_a_range_that_is_no_turn(self) -> None:
        assert jumps(np.degrees(SWING) % 300) == 0
        assert jumps(100 * np.sign(SWING)) == 0
        assert jumps(4096.5 * (SWING % 1)) == 0

    def test_a_count_that_jumps_once(self) -> None:
        """A camera that takes something else for the mass, 1023 pixels away."""
        place = np.arange(T.size)
        assert jumps(np.where(place < 2000, 1022.0, 0.0) + place % 2) == 0

    def test_steps_of_all_sizes(self) -> None:
        rng = np.random.default_rng(1)
        assert jumps(360 * rng.uniform(size=T.size)) == 0
        assert jumps(np.clip(180 + 100 * rng.standard_normal(T.size), 0, 359.9)) == 0

    def test_a_full_swing_without_a_jump(self) -> None:
        assert jumps(180 + 179 * np.cos(4 * T)) == 0

    def test_a_switch_between_levels_within_a_turn(self) -> None:
        assert jumps(np.where(SWING > 0, 300.0, 10.0) + 0.1 * np.sin(T)) == 0


def test_the_first_command_finds_the_mode(tmp_path: Path) -> None:
    since = np.maximum(T - 3.0, 0.0)
    angle = np.degrees(0.2 * np.exp(-0.04 * since) * np.cos(4.0 * since)) % 360
    path = tmp_path / "pendulum.csv"
    np.savetxt(
        path, np.stack([T, np.round(angle, 2)], axis=1), delimiter=",", header="time [s],angle [deg]", comments=""
    )
    found = analyse(path)
    assert any(finding.kind is Defect.WRAPPED for finding in found.cleaned.findings)
    assert found.modes.wn == pytest.approx([np.hypot(4.0, 0.04)], rel=1e-3)
