"""The simulators of close modes and of records without a decay, by the laws of what they simulate."""

import numpy as np
import pytest

from suspid import identify
from suspid.records import as_response
from suspid.words import Level
from validation import close_modes, no_decay, repeats, rigs, steadiness


class TestCars:
    @pytest.mark.parametrize(("source", "modes"), [(close_modes.half, 4), (close_modes.full, 7)])
    @pytest.mark.parametrize("seed", range(5))
    def test_body_and_wheels_are_where_cars_have_them(self, source: object, modes: int, seed: int) -> None:
        assert callable(source)
        decay = source(np.random.default_rng(seed))
        hertz = np.abs(decay.poles) / (2 * np.pi)
        assert len(hertz) == modes
        body = hertz[: (modes - 1) // 2 + (modes == 4)]
        assert np.all((body > 0.7) & (body < 3.5))
        assert np.all((hertz[len(body) :] > 7) & (hertz[len(body) :] < 18))

    def test_one_channel_of_a_pair_is_the_sum_of_two_oscillators(self) -> None:
        decay = close_modes.pair(np.random.default_rng(1), 1)
        time, values, std = close_modes.record(decay, np.random.default_rng(2))
        # Linear prediction from four samples: each pole is a root, so the clean record obeys it.
        roots = np.exp(np.concatenate([decay.poles, decay.poles.conj()]) * time[1])
        predicted = np.convolve(values[0], np.poly(roots).real, "valid")
        assert np.std(predicted) < 1.5 * std[0] * np.linalg.norm(np.poly(roots))
        assert decay.poles[1] != decay.poles[0]
        assert abs(decay.poles[1]) / abs(decay.poles[0]) == pytest.approx(1.03)

    def test_a_required_mode_is_beyond_once_if_its_frequency_or_its_damping_is(self) -> None:
        # Two required modes, each with a row for its frequency and one for its damping: [over the bound, over its sd].
        ratios = np.array([[1.0, -5.0], [1.0, 6.0], [1.0, 1.0], [1.0, -3.9]])
        outcome = close_modes.Outcome(missed=0, extra=1, returned=3, far=2, ratios=ratios, sound=True)
        assert close_modes._row([outcome])[3:] == ["2 of 3", "1 of 2", "1, 1"]


class TestRecordsWithoutADecay:
    @pytest.mark.parametrize("memory", [0.5, 0.9])
    def test_autoregression_has_its_memory(self, memory: float) -> None:
        source = no_decay.autoregression(memory)
        lags = []
        for seed in range(20):
            _, values = source(np.random.default_rng(seed))
            lags += [float(row[1:] @ row[:-1] / (row @ row)) for row in values]
        assert np.mean(lags) == pytest.approx(memory, abs=0.02)

    def test_pink_noise_falls_by_three_decibels_an_octave(self) -> None:
        slopes = []
        for seed in range(20):
            time, values = no_decay.pink(np.random.default_rng(seed))
            power = np.abs(np.fft.rfft(values * np.hanning(len(time)), axis=1)) ** 2
            bins = np.arange(4, power.shape[1])
            slopes.append(np.polyfit(np.log(bins), np.log(power[:, 4:]).mean(axis=0), 1)[0])
        assert np.mean(slopes) == pytest.approx(-1.0, abs=0.1)

    @pytest.mark.parametrize("kind", list(no_decay.KINDS))
    def test_every_kind_is_finite_and_moves(self, kind: str) -> None:
        time, values = no_decay.KINDS[kind](np.random.default_rng(3))
        assert values.shape[1] == len(time)
        assert np.all(np.isfinite(values))
        assert np.all(np.std(values, axis=1) > 0)


class TestSteadiness:
    @pytest.mark.parametrize("world", steadiness.WORLDS)
    def test_a_world_has_samples_of_its_own(self, world: str) -> None:
        (times, values), (_, others) = (steadiness.WORLDS[world](np.random.default_rng(seed)) for seed in (1, 2))
        assert values.shape[1] == len(times) > 100
        assert np.all(np.std(values, axis=1) > 0)
        assert values.shape != others.shape or not np.allclose(values, others)

    def test_what_is_kept_is_told(self) -> None:
        times, values = steadiness.WORLDS["quarter car of the paper"](np.random.default_rng(1))
        one, other = (identify(as_response(times, part, ["a", "b", "c"])) for part in (values, values * (1 + 1e-14)))
        moved = identify(as_response(times, values + 1e-5 * np.std(values) * np.sin(7.0 * times), ["a", "b", "c"]))
        fewer = identify(as_response(times, values, ["a", "b", "c"]), modes=2)
        assert steadiness._same_modes(one, other, values) == (True, True)
        assert steadiness._same_modes(one, moved, values)[0] is False
        assert steadiness._same_modes(one, fewer, values) == (False, False)

    def test_a_record_of_one_world_keeps_everything(self) -> None:
        assert steadiness.kept("quarter car of the paper", 3) == steadiness.Kept(
            modes=True, intervals=True, verdict=True, decays=True
        )


class TestRepeats:
    def test_tests_are_of_one_rig_by_one_clock(self) -> None:
        first = rigs.release("friction", 1, seed=4)
        other = rigs.release("friction", 1, seed=4, first=first, test=1, damping=2.0)
        assert other.pace == first.pace
        np.testing.assert_allclose(other.rig.stiffness, first.rig.stiffness)
        np.testing.assert_allclose(other.rig.friction, 2 * first.rig.friction)
        assert 0.5 < abs(other.motion.position[0, 0] / first.motion.position[0, 0]) < 1

    def test_the_truth_is_that_of_the_exact_motion(self) -> None:
        """Of a bilinear damper both are the same at each amplitude."""
        first = rigs.release("bilinear", 1, seed=4)
        sizes, wn, zeta = rigs.equivalent(first, first.start, first.stop)
        assert repeats._at(first, float(np.median(sizes))) == pytest.approx((wn[0], zeta[0]), rel=1e-4)

    def test_shares_count_each_what_it_is_of(self) -> None:
        off = repeats.Joint(right=True, common=True, wn=0.02, zeta=-0.2, sds=(5.0, 1.0), level=Level.SOUND, told=True)
        alone = repeats.Joint(right=True, disagrees=True, same=True, told=False)
        shares = repeats._shares([off, alone, repeats.Joint()])
        assert shares == ["67 %", "50 %", "0 %", "0 %", "0 %", "100 %", "50 %", "100 %", "50 %", "33 %"]

    @pytest.mark.slow
    def test_one_rig(self) -> None:
        found = repeats.joint("bilinear", 0)
        assert found.right
        assert found.common
        assert found.same
        assert found.told
        assert abs(found.zeta) < 0.01
