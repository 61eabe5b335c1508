"""Poles at sums and differences of modes: motion that is not quite linear, and modes that lie there by chance."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from suspid import Identification, ModalSet, identify
from suspid.identification.considered import considered_of
from suspid.identification.harmonics import _in_step, combination_of, multiple_of
from suspid.identification.poles import Poles
from suspid.records import as_response
from suspid.words import Level, ModeCheck, Number, Reason


def found(hertz: list[float], sizes: list[float], rates: list[float], *, size: float = 1e-4) -> Identification:
    time = np.arange(2000) / 200
    motions = zip(hertz, sizes, rates, strict=True)
    values = sum(s * np.exp(-r * time) * np.cos(2 * np.pi * f * time) for f, s, r in motions)
    noise = size * np.random.default_rng(3).standard_normal((1, time.size))
    return identify(as_response(time, values + noise, ["body"]))


def reasons(one: Identification) -> dict[int, str]:
    return {round(abs(c.pole) / (2 * np.pi)): c.reason for c in one.considered if c.removed}


class TestFarMultiples:
    """Beyond the seventh one lies near every frequency: it must be known far better than that, beside a nearer one."""

    def test_one_that_is_known_well_is_none(self) -> None:
        one = found([3.0, 15.0, 36.0], [1.0, 0.02, 0.02], [0.2, 0.5, 0.5])
        assert np.round(one.modes.wn / (2 * np.pi), 1).tolist() == [3.0]
        assert reasons(one)[36].startswith("12 times mode 1")

    def test_beside_it_is_a_mode(self) -> None:
        one = found([3.0, 15.0, 36.4], [1.0, 0.02, 0.02], [0.2, 0.5, 0.5])
        assert np.round(one.modes.wn / (2 * np.pi), 1).tolist() == [3.0, 36.4]

    def test_without_a_nearer_one_it_is_a_mode(self) -> None:
        one = found([3.0, 36.0], [1.0, 0.02], [0.2, 0.5])
        assert np.round(one.modes.wn / (2 * np.pi), 1).tolist() == [3.0, 36.0]

    def test_one_that_is_hardly_known_is_a_mode(self) -> None:
        """Its interval is as wide as a twentieth of the way from one multiple to the next."""
        one = found([3.0, 15.0, 36.0], [1.0, 0.02, 2e-4], [0.2, 0.5, 2.0])
        assert np.round(one.modes.wn / (2 * np.pi)).tolist() == [3.0, 36.0]

    def test_a_near_multiple_is_named_before_a_far_one(self) -> None:
        """Of a slow mode any frequency is nearly a multiple."""
        modes = found([0.5, 3.001], [1.0, 1.0], [0.1, 0.2]).modes
        assert multiple_of(modes, complex(-0.4, 12 * modes.poles[0].imag)) == (2, 2)
        assert multiple_of(modes, complex(-0.4, 8 * modes.poles[0].imag)) == (1, 8)


class TestStrongHarmonics:
    """A sensor that bends, ``y = x + b x^2``, adds twice the frequency and twice the rate: a share of ``b / 2``."""

    @pytest.mark.parametrize("share", [0.3, 0.45])
    @pytest.mark.parametrize("multiple", [2, 3])
    def test_what_lies_exactly_there_is_none(self, share: float, multiple: int) -> None:
        one = found([3.0, 3.0 * multiple], [1.0, share], [0.2, 0.2 * multiple])
        assert np.round(one.modes.wn / (2 * np.pi), 1).tolist() == [3.0]
        assert reasons(one)[3 * multiple].startswith(f"{multiple} times mode 1")

    @pytest.mark.parametrize("hertz", [6.04, 12.0])
    def test_what_lies_beside_it_is_a_mode(self, hertz: float) -> None:
        """So is one at four times the frequency: of higher orders one is near sooner."""
        one = found([3.0, hertz], [1.0, 0.3], [0.2, 0.5])
        assert np.round(one.modes.wn / (2 * np.pi), 2).tolist() == [3.0, hertz]

    def test_one_whose_frequency_is_hardly_known_is_a_mode(self) -> None:
        """Its interval reaches the multiple, and is as wide as a seventh of the way from one to the next."""
        one = found([3.0, 6.02], [1.0, 0.3], [0.2, 0.6], size=0.2)
        assert np.round(one.modes.wn / (2 * np.pi)).tolist() == [3.0, 6.0]
        assert one.modes.wn_std is not None
        assert 0.01 < one.modes.wn_std[1] / (2 * np.pi) < 0.06

    @pytest.mark.parametrize("size", [0.6, 2.0])
    def test_one_that_is_stronger_is_a_mode(self, size: float) -> None:
        one = found([3.0, 6.0], [1.0, size], [0.2, 0.3])
        assert np.round(one.modes.wn / (2 * np.pi), 1).tolist() == [3.0, 6.0]


class TestCombinations:
    def test_the_difference_of_modes_beside_a_harmonic_is_none(self) -> None:
        one = found([3.0, 7.3, 6.0, 4.3], [1.0, 0.5, 0.02, 0.01], [0.2, 0.5, 0.4, 0.7])
        assert np.round(one.modes.wn / (2 * np.pi), 1).tolist() == [3.0, 7.3]
        assert reasons(one)[4] == "the difference of modes 1 and 2: their motion is nonlinear"
        assert reasons(one)[6].startswith("2 times mode 1")

    def test_without_a_harmonic_it_is_a_mode(self) -> None:
        one = found([3.0, 7.3, 4.3], [1.0, 0.5, 0.01], [0.2, 0.5, 0.7])
        assert np.round(one.modes.wn / (2 * np.pi), 1).tolist() == [3.0, 4.3, 7.3]

    def test_one_that_decays_faster_than_both_is_a_mode(self) -> None:
        one = found([3.0, 7.3, 6.0, 4.3], [1.0, 0.5, 0.02, 0.03], [0.2, 0.5, 0.4, 1.4])
        assert 4.3 in np.round(one.modes.wn / (2 * np.pi), 1).tolist()

    def test_the_nearest_is_named(self) -> None:
        modes = found([3.0, 7.3], [1.0, 0.5], [0.2, 0.5]).modes
        assert combination_of(modes, complex(-0.7, 2 * np.pi * 10.31)) == (1, 2, "sum")
        assert combination_of(modes, complex(-0.7, 2 * np.pi * 4.32)) == (1, 2, "difference")


def test_a_multiple_of_no_mode_is_said_to_be_one() -> None:
    """The mode itself is not determined: none is left to name."""
    modes = found([3.0, 6.0], [1.0, 0.02], [0.2, 0.4]).modes
    poles = Poles(pairs=np.array([-0.01 + 0.3j]), reals=np.zeros(0), nuisances=np.zeros(1))
    fit = SimpleNamespace(poles=poles, information=np.eye(2), count=100)
    for reason in (Reason.HARMONIC, Reason.COMBINATION):
        selection: Any = SimpleNamespace(fit=fit, reasons=(reason,), loudness=np.ones(1), rejected=())
        (one,) = considered_of(selection, modes[:0], 0.01)
        assert (one.remark.code, one.removed) == (Reason.OF_NO_MODE, True)


def test_a_short_burst_has_no_mode_of_unknown_frequency_and_damping() -> None:
    # Six poles fit the 86 samples of a phone that falls; four have neither.
    time = np.arange(60) / 100
    noise = 0.15 * np.random.default_rng(5).standard_normal((1, time.size))
    values = np.exp(-3 * time) * np.cos(2 * np.pi * 6 * time) + noise
    one = identify(as_response(time, values, ["body"]))
    for mode in range(len(one.modes)):
        assert one.modes.wn_std is not None
        assert one.modes.zeta_std is not None
        known = 1.96 * one.modes.wn_std[mode] < 0.05 * one.modes.wn[mode]
        assert known or one.modes.zeta[mode] > 1.96 * one.modes.zeta_std[mode]
    assert all(c.remark.code is not Reason.UNKNOWN or c.removed for c in one.considered)


class TestFlashes:
    """A switch rings for nine samples beside a decay of 200 time constants; what lasts or swings longer is known."""

    @staticmethod
    def doubted(*, rate: float = 210.0, cycles: float = 1.5, every: float = 1.0) -> list[Number]:
        """Return the modes that may be a flash, beside two of 17 and 19 Hz that decay at .9 and .8 per second."""
        time = np.arange(round(8000 * every)) / (2000 * every)
        motion = sum(np.exp(-r * time) * np.cos(2 * np.pi * f * time + 0.3 * f) for f, r in ((17.0, 0.9), (19.0, 0.8)))
        flash = np.exp(-rate * time) * np.cos(2 * np.pi * cycles * rate * time)
        noise = 2e-3 * np.random.default_rng(8).standard_normal((1, time.size))
        one = identify(as_response(time, motion + flash + noise, ["body"]))
        assert len(one.modes) == 3
        checks = [check for check in one.verdict.checks if check.remark.code is ModeCheck.FLASH]
        assert all(check.level is Level.DOUBTFUL for check in checks)
        return [check.remark.numbers["modes"] for check in checks]

    def test_one_is_doubtful(self) -> None:
        assert self.doubted() == [(3,)]

    @pytest.mark.parametrize("changed", [{"rate": 60.0}, {"cycles": 4.0}, {"every": 3}])
    def test_what_lasts_for_more_time_cycles_or_samples_is_not(self, changed: dict[str, float]) -> None:
        assert self.doubted(**changed) == []


class TestAcrossASwing:
    """A camera sees a pendulum go up and down twice in a cycle: the square of its swing, in another channel."""

    @staticmethod
    def seen(*, turned: float = 0.0, fades: float = 1.0) -> Identification:
        """The rod is 400 long, the camera shakes sideways."""
        time = np.arange(2000) / 60
        swing, other = (
            280 * np.exp(-0.05 * k * time) * np.cos(4.2 * time + 0.3 + turn) for k, turn in ((1, 0), (fades, turned))
        )
        values = np.stack([swing, 400 - np.sqrt(400**2 - other**2)])
        noise = np.random.default_rng(1).standard_normal(values.shape) * [[2.0], [0.3]]
        return identify(as_response(time, values + noise, ["x", "y"]))

    def test_its_height_is_no_mode_and_neither_is_the_middle_of_that(self) -> None:
        one = self.seen()
        assert one.modes.wn == pytest.approx([4.2], rel=1e-3)
        assert reasons(one)[1].startswith("2 times mode 1")

    @pytest.mark.parametrize("other", [{"turned": 0.5}, {"fades": 0.5}])
    def test_what_is_out_of_step_or_damped_otherwise_is_a_mode(self, other: dict[str, float]) -> None:
        assert np.any(np.abs(self.seen(**other).modes.wn / 8.4 - 1) < 0.01)

    @pytest.mark.parametrize(("part", "share"), [(2, 0.3), (3, 0.005)], ids=["rate", "frequency"])
    def test_it_must_be_known_to_be_twice_the_swing(self, part: int, share: float) -> None:
        """Else a mode of its own lies there as well."""
        poles = np.array([-0.05 + 4.2j, -0.1 + 8.4j])
        size = abs(poles[1].real if part == 2 else poles[1].imag)
        fit: Any = SimpleNamespace(amplitudes=np.array([[1.0, 0.0], [0.0, 0.5]], complex), squares=np.ones(2))
        for factor, known in ((0.9, True), (1.1, False)):
            spread = np.full(4, 1e-6)
            spread[part] = factor * share * size
            modes = ModalSet(poles=poles, channels=("x", "y"), covariance=np.diag(spread**2))
            assert _in_step(fit, modes, np.arange(2), 0, 1) is known
