from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import gamma, norm

from suspid import add_noise, estimate, free_decay, identify, quarter_car
from suspid.identification import halves
from suspid.identification.ascent import maximize
from suspid.identification.classification import is_tone, reasons_of
from suspid.identification.exponentials import blocks_of
from suspid.identification.fitting import COLOUR_BEGINS
from suspid.identification.halves import disagreement, halfway
from suspid.identification.identify_repeats import identify_repeats
from suspid.identification.likelihood import DecayFit, evaluate
from suspid.identification.noise import (
    LOUD,
    WhiteNoise,
    correlated,
    degrees_of_freedom,
    lag_one,
    loss_growth,
    loudness,
    most_shared,
    noise_of,
    power_near,
    resolution,
    shared_noise,
)
from suspid.identification.poles import Poles
from suspid.levels import normal_reach
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.words import Reason

Real = NDArray[np.float64]
ANY = WhiteNoise(least=np.full(1, 1e-30))


def white(seed: int, channels: int, count: int) -> Real:
    return np.random.default_rng(seed).standard_normal((channels, count))


def poles(*pairs: complex) -> Poles:
    return Poles(pairs=np.array(pairs), reals=np.zeros(0), nuisances=np.zeros(1))


class TestResolution:
    @pytest.mark.parametrize("step", [0.01 * np.pi, 1 / 7, 2.0**-9])
    def test_of_a_converter_is_the_scatter_of_its_error(self, step: float) -> None:
        exact = 40 * step * white(1, 1, 20_000)
        coarse = step * np.round(exact / step)
        # The error of the variance of 20000 uniform errors is 0.6 %.
        assert resolution(coarse)[0] == pytest.approx(np.std(coarse - exact), rel=0.02)

    @pytest.mark.parametrize("digits", [3, 5, 9])
    def test_of_printed_samples_is_one_unit_of_the_last_digit_at_the_peak(self, digits: int) -> None:
        samples = np.array([[float(f"{value:.{digits - 1}e}") for value in 1.5 * white(2, 1, 500)[0]]])
        samples[0, 0] = 9.5
        assert resolution(samples)[0] == pytest.approx(10.0 ** (1 - digits))

    def test_of_single_precision_is_that_of_its_mantissa(self) -> None:
        single = white(3, 1, 500).astype(np.float32).astype(float)
        peak = np.max(np.abs(single))
        assert 2.0**-24 * peak < resolution(single)[0] < 2.0**-20 * peak

    def test_of_exact_samples_is_their_rounding(self) -> None:
        exact = white(4, 1, 500)
        assert resolution(exact)[0] == pytest.approx(1e-11 * np.max(np.abs(exact)))

    @pytest.mark.parametrize("factor", [1e-9, 2.0**-7, 1e5])
    def test_goes_with_the_unit(self, factor: float) -> None:
        coarse = 0.25 * np.round(80 * white(5, 1, 500))
        assert resolution(factor * coarse)[0] == pytest.approx(factor * resolution(coarse)[0], rel=1e-9)

    def test_is_the_least_standard_deviation_of_the_noise(self) -> None:
        coarse = 0.25 * np.round(80 * white(6, 2, 500))
        np.testing.assert_allclose(noise_of(coarse).variance(np.zeros(2), 500), resolution(coarse) ** 2)


class TestLikelihoodOfWhiteNoise:
    def test_loss_is_minus_twice_the_log_likelihood(self) -> None:
        residual = np.array([[0.3], [2.0]]) * white(7, 2, 400)
        noise = WhiteNoise(least=np.zeros(2))
        squares = np.sum(residual**2, axis=1)
        std = np.std(residual - 0, axis=1, ddof=0, mean=np.zeros((2, 1)))
        dense = -2 * float(np.sum(norm.logpdf(residual, scale=std[:, None])))
        constant = 2 * 400 * (1 + np.log(2 * np.pi))
        assert noise.loss(squares, 400) == pytest.approx(dense - constant, rel=1e-12)

    def test_no_variance_is_likelier(self) -> None:
        residual = white(8, 1, 300)
        best = WhiteNoise(least=np.zeros(1)).variance(np.sum(residual**2, axis=1), 300)[0]

        def log_likelihood(variance: float) -> float:
            return float(np.sum(norm.logpdf(residual, scale=np.sqrt(variance))))

        assert log_likelihood(best) > max(log_likelihood(1.01 * best), log_likelihood(0.99 * best))

    @pytest.mark.parametrize("more", [-0.3, 0.0, 0.7])
    def test_growth_is_the_difference_of_two_losses(self, more: float) -> None:
        noise, squares = WhiteNoise(least=np.zeros(2)), np.array([3.0, 0.2])
        grown = noise.loss(squares * (1 + more), 50) - noise.loss(squares, 50)
        assert loss_growth(np.full(2, more), 50) == pytest.approx(grown)

    def test_rounding_is_the_least(self) -> None:
        energy = np.array([4.0, 9.0])
        exact = WhiteNoise(least=np.array([1.0, 0.0]))
        np.testing.assert_allclose(exact.rounded(energy, 100).least, [1.0, 9e-30])
        np.testing.assert_allclose(exact.rounded(energy, 100, of_energies=True).least, [1.0, 9e-17])


class TestDegreesOfFreedom:
    """The variance over degrees of freedom is unbiased; over samples it is 1 - parameters / samples of that."""

    def test_of_one_channel_at_known_poles(self) -> None:
        # 40 samples, amplitudes of two pairs and an offset.
        known = poles(-0.03 + 0.4j, -0.05 + 1.1j)
        squares = []
        for seed in range(400):
            fit = evaluate(blocks_of(white(seed, 1, 40)), known, ANY)
            assert fit is not None
            squares.append(fit.squares[0])
        free = degrees_of_freedom(40, amplitudes=5, poles=0, channels=1)
        # A mean of 400 chi-squares of 35 degrees scatters by 1.2 %.
        assert np.mean(squares) / free == pytest.approx(1.0, abs=0.04)

    @pytest.mark.parametrize("channels", [1, 3])
    def test_of_fitted_poles_are_shared_by_the_channels(self, channels: int) -> None:
        known, k = poles(-0.03 + 0.4j, -0.05 + 1.1j), np.arange(40)
        clean = 200 * np.real(np.exp(np.outer(known.pairs, k))).sum(axis=0)
        variances = []
        for seed in range(400 // channels):
            noise = WhiteNoise(least=np.full(channels, 1e-12))
            fit = maximize(blocks_of(clean + white(seed, channels, 40)), known, noise)
            assert fit is not None
            assert fit.freedom == pytest.approx(40 - 5 - 4 / channels)
            variances.append(np.mean(fit.squares / fit.freedom))
        assert np.mean(variances) == pytest.approx(1.0, abs=0.04)

    def test_noise_std_of_an_identification_leaves_out_what_was_fitted(self) -> None:
        k = np.arange(48)
        clean = 100 * np.real(np.exp((-0.03 + 0.4j) * k) + np.exp((-0.05 + 1.3j) * k))
        found = identify(as_response(k / 100, clean + white(1, 1, 48), ["y"]), modes=2)
        left = as_signal(found.residual).values
        # An offset, and four amplitudes and four parameters of poles of two pairs.
        np.testing.assert_allclose(found.noise_std**2 * (48 - 9), np.sum(left**2, axis=1), rtol=1e-9)

    @pytest.mark.slow
    def test_noise_std_of_an_identification_is_unbiased(self) -> None:
        k = np.arange(48)
        clean = 100 * np.real(np.exp((-0.03 + 0.4j) * k) + np.exp((-0.05 + 1.3j) * k))
        found = [identify(as_response(k / 100, clean + white(seed, 1, 48), ["y"]), modes=2) for seed in range(60)]
        assert {len(one.modes) for one in found} == {2}
        # 9 of 48 samples are spent: over all samples the mean would be 0.81.
        assert np.mean([one.noise_std[0] ** 2 for one in found]) == pytest.approx(1.0, abs=0.09)

    @pytest.mark.slow
    def test_noise_std_of_repeats_is_unbiased(self) -> None:
        k = np.arange(40)
        clean = 100 * np.real(np.exp((-0.04 + 0.5j) * k) + np.exp((-0.06 + 1.4j) * k))
        variances = []
        for seed in range(30):
            values = np.hstack([clean, clean]) + white(seed, 1, 80)
            found = identify_repeats(as_response(np.arange(80) / 100, values, ["y"]), [(0, 0.39), (0.4, 0.79)])
            if len(found.modes) == 2:
                variances.append(np.mean(found.noise_std**2))
        assert len(variances) > 20
        assert np.mean(variances) == pytest.approx(1.0, abs=0.15)

    def test_is_at_least_one(self) -> None:
        assert degrees_of_freedom(10, amplitudes=9, poles=8, channels=1) == 1


class TestExplained:
    def test_does_not_depend_on_the_mean(self) -> None:
        k = np.arange(500)
        values = np.exp(-0.01 * k) * np.cos(0.3 * k) + 0.2 * white(9, 1, 500)
        shares = [identify(as_response(k / 100, values + mean, ["y"])).explained[0] for mean in (0.0, 50.0)]
        assert shares[1] == pytest.approx(shares[0], abs=1e-6)
        # Signal energy 25 of 25 + 500 * 0.04.
        assert shares[1] == pytest.approx(25 / 45, abs=0.05)


class TestCorrelation:
    @pytest.mark.parametrize("level", [0.1, 0.01])
    def test_white_noise_is_called_correlated_as_often_as_the_level_says(self, level: float) -> None:
        found = correlated(lag_one(white(10, 4000, 300)), 300, sigmas=normal_reach(1 - level))
        assert np.mean(found) == pytest.approx(level, abs=4 * np.sqrt(level / 4000) + 0.1 * level)

    @pytest.mark.parametrize("memory", [-0.5, 0.3, 0.8])
    def test_lag_one_of_a_memory_is_the_memory(self, memory: float) -> None:
        noise = white(11, 2, 40_000)
        for k in range(1, noise.shape[1]):
            noise[:, k] += memory * noise[:, k - 1]
        np.testing.assert_allclose(lag_one(noise), memory, atol=0.02)

    def test_without_power_there_is_none(self) -> None:
        np.testing.assert_array_equal(lag_one(np.zeros((2, 10))), 0.0)


class TestPowerBesideAPole:
    @pytest.mark.parametrize("decay", [1e-4, 0.01, 0.1])
    def test_is_one_on_average_in_white_noise_of_any_variance(self, decay: float) -> None:
        count, theta = 400, np.full(1, -decay + 1.2j)
        std = np.array([[0.1], [5.0]] * 200)
        found = power_near(std * white(12, 400, count), std[:, 0] ** 2, theta)
        # A mean of 8 exponential variables scatters by 0.35; neighbours are not quite independent.
        assert np.mean(found) == pytest.approx(1.0, abs=0.06)

    def test_limits_are_levels_of_eight_exponential_variables(self) -> None:
        assert 5e-4 < gamma(8).sf(8 * LOUD) < 1e-3
        assert 0.08 < gamma(8).sf(8 * COLOUR_BEGINS) < 0.1

    def test_sees_power_beside_the_pole_but_not_at_it(self) -> None:
        count, k = 4000, np.arange(4000)
        theta = np.full(1, -0.01 + 1.0j)
        at, beside = np.cos(1.0 * k)[None], np.cos((1.0 + 4 * 0.01) * k)[None]
        power = [power_near(tone, np.full(1, 0.5), theta)[0, 0] for tone in (at, beside)]
        assert count / 50 > power[1] > 2 * power[0]


class TestLoudness:
    """A residual of exact lag-one correlation, so that the test of colour is on one side or the other of its level."""

    COUNT = 10_000
    THETA = np.array([-0.01 + 0.05j, -0.01 + 2.9j])

    def residual(self, sds: float) -> Real:
        noise = white(13, 1, self.COUNT)
        memory = sds / np.sqrt(self.COUNT) - float(lag_one(noise)[0])
        noise[:, 1:] += memory * noise[:, :-1]
        return noise

    def found(self, sds: float, beside: float) -> Real:
        residual = self.residual(sds)
        given = np.full((1, 2), beside)
        return loudness(residual, np.var(residual, axis=1), self.THETA, beside=given, weights=np.ones((1, 2)))

    def test_of_a_white_residual_is_what_exceeds_chance(self) -> None:
        np.testing.assert_array_equal(self.found(0.0, 0.9 * LOUD), 1.0)
        np.testing.assert_allclose(self.found(0.0, 1.1 * LOUD), 1.1 * LOUD)

    def test_a_residual_is_coloured_from_four_standard_deviations_on(self) -> None:
        np.testing.assert_array_equal(self.found(3.5, 2.0), 1.0)
        np.testing.assert_allclose(self.found(4.5, 2.0), 2.0)
        np.testing.assert_allclose(self.found(-4.5, 2.0), 2.0)

    def test_of_a_coloured_residual_is_its_density_at_the_pole(self) -> None:
        # x_k = e_k + a e_(k-1): density over variance |1 + a exp(-j omega)|^2 / (1 + a^2).
        memory = 0.5
        expected = np.abs(1 + memory * np.exp(-1j * self.THETA.imag)) ** 2 / (1 + memory**2)
        assert expected[1] < 1
        found = self.found(memory * np.sqrt(self.COUNT), 0.0)
        np.testing.assert_allclose(found, [expected[0], 1.0], rtol=0.1)

    def test_channels_count_by_their_weight(self) -> None:
        given, residual = np.array([[4.0], [8.0]]), white(14, 2, 1000)
        found = loudness(residual, np.ones(2), self.THETA[:1], beside=given, weights=np.array([[3.0], [1.0]]))
        assert found[0] == pytest.approx((3 * 4 + 8) / 4)


class TestSharedNoise:
    @pytest.mark.parametrize("share", [0.5, 0.9])
    def test_is_the_largest_variance_of_any_combination(self, share: float) -> None:
        # Two channels of correlation r: the sum of both has variance (1 + r) times that of independent noise.
        common, own = white(15, 1, 20_000), white(16, 2, 20_000)
        noise = np.sqrt(share) * common + np.sqrt(1 - share) * own
        assert shared_noise(noise * np.array([[1.0], [1e3]])) == pytest.approx(1 + share, abs=0.02)

    def test_most_shared_are_the_two_channels_of_one_source(self) -> None:
        noise = white(23, 4, 5000)
        noise[3] = -0.6 * noise[1] + 0.8 * noise[3]
        one, other, correlation = most_shared(noise)
        assert (one, other) == (1, 3)
        assert correlation == pytest.approx(0.6, abs=0.05)

    def test_little_correlation_does_not_count(self) -> None:
        common, own = white(17, 1, 40_000), white(18, 2, 40_000)
        assert shared_noise(np.sqrt(0.15) * common + np.sqrt(0.85) * own) == 1.0
        assert shared_noise(np.sqrt(0.25) * common + np.sqrt(0.75) * own) > 1.2

    def test_chance_does_not_count(self) -> None:
        # Over 50 samples a correlation of 0.6 is 4 standard deviations of chance.
        one, other = white(19, 2, 50)
        one = one / np.linalg.norm(one)
        other = other - (other @ one) * one
        other = 0.8 * other / np.linalg.norm(other)
        assert shared_noise(np.array([one, other + 0.6 * one])) == 1.0
        assert shared_noise(np.array([one, other + 1.6 * one])) > 1.0

    @pytest.mark.parametrize("sds", [5.95, 6.05])
    def test_channels_share_from_six_standard_deviations_of_chance_on(self, sds: float) -> None:
        # Two channels of exact correlation r over n samples: chance scatters r by 1 / sqrt(n).
        count = 400
        one, other = np.linalg.qr(white(24, 2, count).T)[0].T
        correlation = sds / np.sqrt(count)
        found = shared_noise(np.array([one, correlation * one + np.sqrt(1 - correlation**2) * other]))
        assert found == pytest.approx(1 + correlation if sds > 6 else 1.0)

    @pytest.mark.parametrize("level", [1.0, 0.3])
    def test_a_channel_given_twice_says_no_more_than_once(self, level: float) -> None:
        # The second decay has noise of its own level: what channels share counts decay by decay.
        k = np.arange(300)
        decay = np.exp(-0.02 * k) * np.cos(0.4 * k)
        noise = 0.02 * np.hstack([white(21, 1, 300), level * white(22, 1, 300)])
        values, time = np.hstack([decay, 0.7 * decay]) + noise, np.arange(600) / 100
        once, twice = (
            identify_repeats(as_response(time, np.repeat(values, n, axis=0), list("ab")[:n]), [(0, 2.99), (3, 5.99)])
            for n in (1, 2)
        )
        one, two = once.modes.wn_std, twice.modes.wn_std
        assert one is not None
        assert two is not None
        np.testing.assert_allclose(two, one, rtol=0.03)


class TestHalves:
    @pytest.mark.parametrize("decay", [0.002, 0.02])
    def test_part_where_half_of_the_information_is_in(self, decay: float) -> None:
        # Information on the pole goes as k^2 exp(-2 decay k): the density of a gamma variable of shape 3.
        assert halfway(decay, 20_000) == pytest.approx(gamma(3).median() / (2 * decay), rel=0.02)
        assert halfway(0.0, 1000) == pytest.approx(1000 * 0.5 ** (1 / 3), rel=0.01)

    @pytest.mark.parametrize("decay", [0.002, 0.02])
    def test_a_linear_decay_disagrees_by_one_standard_deviation(self, decay: float) -> None:
        # Both halves know the pole about equally well; the mean square over many draws is 1.
        count, k = 1200, np.arange(1200)
        clean = np.exp(-decay * k) * np.cos(0.4 * k)
        found = [
            disagreement(clean + 0.01 * white(seed, 1, count), poles(-decay + 0.4j), 0, np.full(1, 0.01))
            for seed in range(60)
        ]
        assert np.sum(np.isnan(found)) < 6
        assert np.sqrt(np.nanmean(np.square(found))) == pytest.approx(1.0, abs=0.25)

    def test_a_mode_that_has_died_costs_nothing_and_moves_nothing(self, monkeypatch: pytest.MonkeyPatch) -> None:
        # The second half holds the slow mode alone, so the two halves disagree as they do without the other one.
        fits = 0

        def counted(*given: Any, **options: Any) -> DecayFit | None:
            nonlocal fits
            fits += 1
            return evaluate(*given, **options)

        monkeypatch.setattr(halves, "evaluate", counted)
        k, both = np.arange(1200), poles(-0.004 + 0.4j, -0.03 + 1.1j)
        slow, fast = np.exp(-0.004 * k) * np.cos(0.4 * k), np.exp(-0.03 * k) * np.cos(1.1 * k)
        noises = [0.01 * white(seed, 1, 1200) for seed in range(40)]
        found = [disagreement(slow + fast + noise, both, 0, np.full(1, 0.01)) for noise in noises]
        assert fits < 40 * 2 * 8
        alone = [disagreement(slow + noise, poles(-0.004 + 0.4j), 0, np.full(1, 0.01)) for noise in noises]
        assert np.corrcoef(found, alone)[0, 1] > 0.98
        assert np.sqrt(np.mean(np.square(found))) == pytest.approx(1.0, abs=0.25)

    def test_a_mode_that_is_seen_takes_its_own_change(self) -> None:
        # Of two close modes one changes half way: it disagrees by itself, and leaves the other one alone.
        k, pair = np.arange(1200), poles(-0.004 + 0.4j, -0.004 + 0.42j)
        steady, cut = np.exp(-0.004 * k) * np.cos(0.4 * k), halfway(0.004, 1200)
        phase = np.where(k < cut, 0.42 * k, 0.42 * cut + 0.4205 * (k - cut))
        values = steady + np.exp(-0.004 * k) * np.cos(phase)
        found = [
            [disagreement(values + 1e-3 * white(seed, 1, 1200), pair, mode, np.full(1, 1e-3)) for seed in range(10)]
            for mode in range(2)
        ]
        assert np.mean(found[0]) < 2
        assert np.mean(found[1]) > 5

    def test_a_frequency_that_changes_half_way_disagrees(self) -> None:
        k = np.arange(1200)
        values = np.exp(-0.004 * k) * np.cos(0.4 * k + 2e-6 * k**2) + 0.003 * white(1, 1, 1200)
        assert disagreement(values, poles(-0.004 + 0.4j), 0, np.full(1, 0.003)) > 5

    def switched(self, shift: float, count: int = 1200, decay: float = 0.004) -> Real:
        """Return a decay without noise whose frequency changes where half of the information has passed."""
        k, cut = np.arange(count), halfway(decay, count)
        phase = np.where(k < cut, 0.4 * k, 0.4 * cut + (0.4 + shift) * (k - cut))
        return np.asarray((np.exp(-decay * k) * np.cos(phase))[None])

    def stds(self, count: int, decay: float, noise: float) -> list[Real]:
        """Return the bounds of decay rate and frequency in the two halves."""
        values, cut = self.switched(0.0, count, decay), halfway(decay, count)
        stds = []
        for part in (values[:, :cut], values[:, cut:]):
            fit = evaluate(blocks_of(part), poles(-decay + 0.4j), WhiteNoise(least=np.full(1, noise**2)))
            assert fit is not None
            stds.append(np.sqrt(np.linalg.inv(fit.information).diagonal()))
        return stds

    def test_a_known_change_is_told_in_its_standard_deviations(self) -> None:
        shift, noise = 0.002, np.full(1, 0.01)
        first, second = self.stds(1200, 0.004, 0.01)
        expected = shift / np.sqrt(2 * (first[1] ** 2 + second[1] ** 2))
        # The mean of each half, which is taken off, moves its pole a little.
        assert disagreement(self.switched(shift), poles(-0.004 + 0.4j), 0, noise) == pytest.approx(expected, rel=0.03)

    def test_an_offset_does_not_matter(self) -> None:
        values, noise = self.switched(0.001), np.full(1, 0.01)
        one, other = (disagreement(values + by, poles(-0.004 + 0.4j), 0, noise) for by in (0.0, 3.0))
        assert other == pytest.approx(one, rel=1e-6)

    @pytest.mark.parametrize(("shift", "known"), [(0.7, True), (1.3, False)])
    def test_a_pole_farther_off_than_its_decay_rate_is_another(self, shift: float, known: bool) -> None:
        found = disagreement(self.switched(0.004 * shift), poles(-0.004 + 0.4j), 0, np.full(1, 0.001))
        assert np.isfinite(found) == known

    @pytest.mark.parametrize(("share", "known"), [(0.3, True), (0.37, False)])
    def test_a_half_that_hardly_knows_the_decay_rate_says_nothing(self, share: float, known: bool) -> None:
        unit = max(float(std.max()) for std in self.stds(1200, 0.004, 1.0))
        noise = np.full(1, share * 0.004 / unit)
        assert np.isfinite(disagreement(self.switched(0.0), poles(-0.004 + 0.4j), 0, noise)) == known

    @pytest.mark.parametrize(("count", "known"), [(90, False), (180, True)])
    def test_a_half_of_less_than_32_samples_says_nothing(self, count: int, known: bool) -> None:
        assert (count - halfway(0.002, count) >= 32) == known
        found = disagreement(self.switched(0.0, count, 0.002), poles(-0.002 + 0.4j), 0, np.full(1, 1e-6))
        assert np.isfinite(found) == known


class TestReasons:
    COUNT = 1000

    @pytest.mark.parametrize(("decay", "reason"), [(2.9, Reason.DRIFT), (3.1, None), (0.4, Reason.DRIFT)])
    def test_a_real_pole_is_a_drift_below_three_e_foldings(self, decay: float, reason: Reason | None) -> None:
        slow = Poles(pairs=np.zeros(0, complex), reals=np.full(1, -decay / self.COUNT), nuisances=np.zeros(1))
        values = 5 * np.exp(-decay * np.arange(self.COUNT) / self.COUNT) + 0.01 * white(20, 1, self.COUNT)
        fit = evaluate(blocks_of(values), slow, ANY)
        assert fit is not None
        assert reasons_of(fit, (0.0, np.pi), np.ones(1), 1.0) == (reason,)

    def test_what_falls_by_a_millionth_over_the_record_is_a_tone_however_well_it_is_known(self) -> None:
        """A simulation without noise knows a decay rate to 1e-11."""
        assert is_tone(0.9e-6 / 1000, 1e-15, 1000)
        assert not is_tone(1.1e-6 / 1000, 1e-15, 1000)

    @pytest.mark.parametrize(("sds", "reason"), [(9.8, Reason.TONE), (10.2, None)])
    def test_a_pair_of_a_fifth_of_an_e_folding_is_a_tone_below_ten_standard_deviations(
        self, sds: float, reason: Reason | None
    ) -> None:
        # Cramér-Rao bound of the decay rate, amplitude and phase unknown: 2 sigma^2 over the spread of k, weighted.
        k, decay = np.arange(self.COUNT), 0.2 / self.COUNT
        weight = np.exp(-2 * decay * k)
        spread = np.sum(weight * k**2) - np.sum(weight * k) ** 2 / np.sum(weight)
        std = decay / sds * np.sqrt(spread / 2)
        values = (np.exp(-decay * k) * np.cos(0.4 * k))[None]
        fit = evaluate(blocks_of(values), poles(-decay + 0.4j), WhiteNoise(least=np.full(1, std**2)))
        assert fit is not None
        assert reasons_of(fit, (0.0, np.pi), np.ones(1), 1.0) == (reason,)


class TestRoundingIsNotShared:
    """Channels in which nothing but rounding is left share no noise, and one of zeros has no correlation."""

    def test_the_same_rounding_counts_once_it_is_above_the_resolution(self) -> None:
        same = 1e-3 * white(31, 1, 1000)[[0, 0]]
        assert shared_noise(same, 1e-3) == 1.0
        assert shared_noise(same, 1e-5) == pytest.approx(2.0)

    def test_a_channel_of_zeros_shares_nothing(self) -> None:
        noise = np.vstack([white(32, 1, 1000), np.zeros((1, 1000))])
        assert shared_noise(noise) == 1.0
        assert np.isfinite(most_shared(noise)[2])


def test_one_noise_serves_all_fits_of_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the noise says that variances are four times as large, so are those of modes, springs and dampers."""
    car = quarter_car(
        chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
    )
    exact = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    record = add_noise(exact, snr_db=30, rng=np.random.default_rng(1))

    def variances() -> Real:
        modes, springs = identify(record).modes, estimate(record, car)
        assert modes.covariance is not None
        return np.concatenate([np.diag(modes.covariance)[: 2 * len(modes)], np.diag(springs.covariance)])

    before, variance = variances(), WhiteNoise.variance
    monkeypatch.setattr(WhiteNoise, "variance", lambda noise, *given: 4 * variance(noise, *given))
    np.testing.assert_allclose(variances(), 4 * before, rtol=1e-3)
