"""Spikes: single samples that the motion around them goes past are missing; blows and pulses are none."""

import numpy as np
import pytest

from suspid import identify
from suspid.cleaning.clean import clean
from suspid.cleaning.inspection import inspect
from suspid.cleaning.spikes import without_spikes
from suspid.recordings import RawChannel, Recording
from suspid.units import RealArray
from suspid.words import Defect

STEP = 0.005
T = np.arange(3000, dtype=np.float64) * STEP
MODES = np.array([-0.2 + 9.4j, -0.5 + 46.0j])
SOME = np.array([40, 200, 395, 700, 1111, 1500, 1501 + 300, 2222, 2990])


def motion(noise: float = 5e-3, *, seed: int = 0) -> RealArray:
    free = np.sum(np.exp(MODES[:, None] * (T - 2.0)), axis=0).imag
    return np.asarray(np.where(T < 2.0, 0.0, free) + noise * np.random.default_rng(seed).standard_normal(T.size))


def spikes(values: RealArray) -> list[int]:
    """Return where samples are taken away as spikes."""
    _, findings = without_spikes("a", T, values)
    return [round(time / STEP) for finding in findings for time in (finding.start, finding.stop)]


def cleared(values: RealArray) -> list[int]:
    return np.flatnonzero(np.isnan(without_spikes("a", T, values)[0])).tolist()


class TestTakenAway:
    @pytest.mark.parametrize("size", [0.5, 5.0, 500.0])
    def test_where_they_are_and_nowhere_else(self, size: float) -> None:
        values = motion()
        values[SOME] += size * np.random.default_rng(1).choice([-1, 1], SOME.size)
        assert cleared(values) == SOME.tolist()
        assert spikes(values) == [SOME[0], SOME[-1]]

    def test_the_modes_come_back(self) -> None:
        values = motion()
        values[SOME] += 5.0
        raw = RawChannel(name="a", unit="m", timepts=T, values=values, rate=None)
        cleaned = clean(Recording(title="test", channels=(raw,)))
        (finding,) = [one for one in cleaned.findings if one.kind is Defect.SPIKES]
        assert "9 single samples 4.9" in str(finding)
        part = np.asarray(cleaned.record.y)[:, T >= 2.0]
        found = identify(part, fs=1 / STEP)
        np.testing.assert_allclose(np.sort_complex(found.modes.poles), np.sort_complex(MODES), rtol=2e-3)

    def test_two_are_too_few_to_tell(self) -> None:
        values = motion()
        values[[700, 1100]] += 5.0
        assert cleared(values) == []


class TestLeftAlone:
    @pytest.mark.parametrize("seed", range(20))
    def test_noise_and_decays(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        for noise in (0.0, 1e-6, 1e-3, 0.1, 10.0):
            assert cleared(motion(noise, seed=seed)) == []
        heavy = rng.standard_t(3, T.size)
        assert cleared(heavy) == []
        assert cleared(np.cumsum(heavy)) == []

    def test_a_converter_with_few_steps(self) -> None:
        for step in (0.5, 0.1, 0.01):
            assert cleared(np.round(motion() / step) * step) == []

    def test_blows_of_one_sample_in_a_channel_of_force(self) -> None:
        force = 0.05 * np.random.default_rng(3).standard_normal(T.size)
        force[SOME] += 20.0
        assert cleared(force) == []

    def test_blows_of_one_sample_that_set_off_motion(self) -> None:
        values = 1e-3 * np.random.default_rng(4).standard_normal(T.size)
        for first in (300, 1200, 2100):
            since = T[: T.size - first]
            values[first:] += 0.5 * np.exp(-1.5 * since) * np.sin(30 * since)
            values[first] += 5.0
        assert cleared(values) == []

    def test_an_angle_that_wraps_round(self) -> None:
        assert cleared(np.degrees(20 * T) % 360) == []
        assert cleared(np.sign(np.sin(7 * T))) == []

    def test_pulses_of_a_wheel(self) -> None:
        assert cleared((np.arange(T.size) % 50 == 0).astype(float)) == []


def test_what_is_said_of_a_counter_that_wraps_round_is_its_limit() -> None:
    values = 1e-3 * np.random.default_rng(5).standard_normal(T.size)
    values[SOME] = 65535.0 - np.arange(SOME.size)
    (finding,) = [one for one in inspect("speed", T, values).findings if one.kind is Defect.SPIKES]
    assert "beyond 6.553e+04" in str(finding)
