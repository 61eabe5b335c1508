"""Lines of a comb that wane within a record are driven; modes beside them, and at its teeth, stay modes."""

import numpy as np
import pytest

from suspid import identify
from suspid.identification.combs import repeated_in, shared_frequency
from suspid.records import as_response
from suspid.words import Level, ModeCheck, Reason

TIME = np.arange(4000) / 1000
TEETH = {3: 1.0, 5: 0.8, 6: 0.5, 8: 0.6, 12: 0.4}


def comb(seed: int, base: float = 10.3) -> np.ndarray:
    """Return steady tones at multiples of a frequency, and one that falls by a third, in two channels with noise."""
    rng = np.random.default_rng(seed)
    phases = rng.uniform(0, 2 * np.pi, (2, 20))
    out = 0.01 * rng.standard_normal((2, TIME.size))
    for tooth, size in TEETH.items():
        out += size * np.cos(2 * np.pi * base * tooth * TIME + phases[:, [tooth]])
    return out + 0.7 * np.exp(-0.1 * TIME) * np.cos(2 * np.pi * 15 * base * TIME + phases[:, [15]])


@pytest.mark.parametrize("seed", range(3))
def test_a_line_that_wanes_is_no_mode(seed: int) -> None:
    found = identify(as_response(TIME, comb(seed), ["force", "body"]))
    assert len(found.modes) == 0
    assert Reason.COMB in {one.remark.code for one in found.considered}


@pytest.mark.parametrize("hertz", [23.0, 72.1])
def test_a_mode_beside_them_or_at_a_tooth_is_one(hertz: float) -> None:
    """72.1 Hz is the seventh tooth; the mode decays there as nothing driven does."""
    mode = np.array([[1.0], [-0.6]]) * np.exp(-0.02 * 2 * np.pi * hertz * TIME) * np.sin(2 * np.pi * hertz * TIME)
    found = identify(as_response(TIME, comb(1) + mode, ["force", "body"]))
    assert found.modes.wn / (2 * np.pi) == pytest.approx([hertz], rel=1e-3)
    assert found.modes.zeta == pytest.approx([0.02], rel=0.1)


def test_three_tones_are_no_comb() -> None:
    assert shared_frequency(np.array([10.0, 20.0, 30.0]), 0.01) is None
    assert shared_frequency(np.array([10.0, 20.0, 30.0, 50.0]), 0.01) == pytest.approx(10.0)


def test_what_is_near_a_tooth_by_chance_is_no_comb() -> None:
    """Of a short record every frequency is near a multiple."""
    assert shared_frequency(np.array([10.0, 20.0, 30.0, 50.0]), 1.0) is None


class TestOvertones:
    """A tone of 3 Hz that does not decay, and beside it a motion that hardly does: .7 nepers in 20 s."""

    @staticmethod
    def removed(*, hertz: float = 6.0, size: float = 0.1, rate: float = 0.035) -> bool:
        """Return whether the other motion is a harmonic of the tone; if not, it is a mode."""
        time = np.arange(1200) / 60
        motion = np.cos(2 * np.pi * 3.0 * time) + size * np.exp(-rate * time) * np.cos(2 * np.pi * hertz * time + 1)
        noise = 1e-3 * np.random.default_rng(2).standard_normal((1, time.size))
        found = identify(as_response(time, motion + noise, ["side"]))
        named = [one for one in found.considered if one.remark.code is Reason.OF_TONE]
        assert len(found.modes) + len(named) == 1
        return bool(named)

    @pytest.mark.parametrize("hertz", [6.0, 9.0])
    def test_at_twice_or_three_times_its_frequency_it_is_a_harmonic(self, hertz: float) -> None:
        assert self.removed(hertz=hertz)

    @pytest.mark.parametrize("changed", [{"hertz": 6.03}, {"hertz": 12.0}, {"size": 1.5}, {"rate": 0.2}])
    def test_beside_it_or_larger_or_decaying_it_is_a_mode(self, changed: dict[str, float]) -> None:
        assert not self.removed(**changed)

    @pytest.mark.parametrize(
        ("low", "rate", "is_harmonic"), [(0.05, 0.0175, True), (0.0, 0.0, False), (0.05, 0.0, False)]
    )
    def test_a_channel_in_which_the_tone_is_the_larger_tells(self, low: float, rate: float, is_harmonic: bool) -> None:
        """A camera beside a pendulum: one channel is the way along, the other the height, which is twice as fast.

        A hum that does not decay at all is no part of what does.
        """
        time, rng = np.arange(1200) / 60, np.random.default_rng(4)
        height = np.exp(-0.035 * time) * np.cos(2 * np.pi * 6.0 * time + 1)
        along = low * np.exp(-rate * time) * np.cos(2 * np.pi * 3.0 * time) + 0.01 * height
        noise = (6e-2 if rate else 1e-3) * rng.standard_normal((2, 1200))
        found = identify(as_response(time, np.array([along, height]) + noise, ["along", "height"]))
        named = [one for one in found.considered if one.remark.code is Reason.OF_TONE]
        assert (len(found.modes), len(named)) == ((0, 1) if is_harmonic else (1, 0))


def echoes(seed: int, *, every: float = 0.006) -> np.ndarray:
    """Return pulses of .4 ms, each .9 times as high as the one before, every 6 ms over .12 s at 2.5 kHz, with noise."""
    time = np.arange(309) / 2500
    pulses = sum(0.9**k * np.exp(-0.5 * ((time - every * (k + 0.6)) / 4e-4) ** 2) for k in range(20))
    return np.asarray(12 * pulses + 0.02 * np.random.default_rng(seed).standard_normal(time.size))


@pytest.mark.parametrize("seed", range(3))
def test_pulses_that_fall_are_doubted_as_modes(seed: int) -> None:
    found = identify(as_response(np.arange(309) / 2500, echoes(seed)[None], ["coil"]))
    check = next(check for check in found.verdict.checks if check.remark.code is ModeCheck.PULSE_TRAIN)
    assert check.level is Level.DOUBTFUL
    assert check.remark.numbers["seconds"] == pytest.approx(0.006, rel=0.01)


def test_harmonics_of_one_mode_are_no_train_of_pulses() -> None:
    """A spring with clearance makes harmonics that decay as the mode does: they are weak, and none is a mode."""
    poles = np.asarray(-1.0 + 100j * np.arange(1, 8), np.complex128)
    assert repeated_in(poles[:1], poles[1:], 5.0) is None
    assert repeated_in(poles[:2], poles[2:], 5.0) == pytest.approx(100.0)


@pytest.mark.parametrize("seed", range(3))
def test_partials_of_a_string_are_modes(seed: int) -> None:
    """Losses in the air and at the ends grow with the frequency: the eighth partial decays five times as fast."""
    rng = np.random.default_rng(seed)
    partials = sum(
        np.exp(-(1.5 + 0.1 * k * k) * TIME) * np.sin(2 * np.pi * 41 * k * TIME + rng.uniform(0, 6)) for k in range(1, 9)
    )
    found = identify(as_response(TIME, (partials + 1e-3 * rng.standard_normal(TIME.size))[None], ["string"]))
    assert found.modes.wn / (2 * np.pi) == pytest.approx(41 * np.arange(1, 9), rel=1e-3)
    assert ModeCheck.PULSE_TRAIN not in {check.remark.code for check in found.verdict.checks}
