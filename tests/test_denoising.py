"""Denoising: what must survive, what must go, and the formulas of the thresholds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
import pywt
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import erf

from suspid import IdentificationError, InputError, ModalSet, RecordError, add_noise, free_decay
from suspid.records import as_response
from suspid.units import RealArray
from suspid.wavelets.denoise import TransformName, denoise
from suspid.wavelets.filter_bank import filter_bank, noise_std, stationary_details, stationary_inverse
from suspid.wavelets.thresholds import (
    RuleName,
    ThresholdName,
    bayes_threshold,
    minimax_threshold,
    shrink,
    sure_threshold,
    universal_threshold,
)
from validation import cars
from validation import denoising as denoising_report

if TYPE_CHECKING:
    import control

TRANSFORMS: tuple[TransformName, ...] = ("stationary", "decimated")
THRESHOLDS: tuple[ThresholdName, ...] = ("sure", "universal", "bayes", "minimax")
RULES: tuple[RuleName, ...] = ("garrote", "soft", "hard")


def record(*channels: RealArray, step: float = 0.01) -> control.TimeResponseData:
    time = np.asarray(step * np.arange(len(channels[0])), float)
    return as_response(time, np.array(channels), [f"y{i}" for i in range(len(channels))])


def samples_of(response: control.TimeResponseData) -> RealArray:
    return np.atleast_2d(np.asarray(response.y, float))


def noise(count: int, seed: int = 0) -> RealArray:
    return np.random.default_rng(seed).standard_normal(count)


def gain_db(clean: RealArray, noisy: RealArray, found: RealArray) -> float:
    return float(10 * np.log10(np.sum((noisy - clean) ** 2) / np.sum((found - clean) ** 2)))


def table_1_decay(count: int = 5000) -> control.TimeResponseData:
    car = cars.PAPER
    return free_decay(car, np.arange(count) / 500, initial_state={"v_tire": 1.0})


class TestEveryRecordKeepsItsFrame:
    @given(count=st.integers(30, 700), transform=st.sampled_from(TRANSFORMS), channels=st.integers(1, 3))
    @settings(max_examples=40, deadline=None)
    def test_length_stamps_and_channels(self, count: int, transform: TransformName, channels: int) -> None:
        noisy = record(*(noise(count, seed) for seed in range(channels)), step=0.003)
        found = denoise(noisy, transform=transform)
        np.testing.assert_array_equal(found.time, noisy.time)
        assert found.output_labels == noisy.output_labels
        assert found.y.shape == noisy.y.shape
        assert np.all(np.isfinite(found.y))

    @given(count=st.integers(2, 70), transform=st.sampled_from(TRANSFORMS))
    @settings(max_examples=40, deadline=None)
    def test_two_samples_are_enough_for_haar(self, count: int, transform: TransformName) -> None:
        assert samples_of(denoise(record(noise(count)), wavelet="haar", transform=transform)).shape == (1, count)

    @pytest.mark.parametrize("wavelet", ["haar", "db4", "sym8", "coif3", "bior2.2", "rbio3.3", "bior4.4", "dmey"])
    @pytest.mark.parametrize("threshold", THRESHOLDS)
    @pytest.mark.parametrize("rule", RULES)
    def test_every_choice_lowers_the_noise_of_a_smooth_record(
        self, wavelet: str, threshold: ThresholdName, rule: RuleName
    ) -> None:
        clean = np.sin(np.linspace(0, 6, 999)) + np.linspace(3, 4, 999)
        noisy = clean + 0.1 * noise(999)
        for transform in TRANSFORMS:
            found = denoise(record(noisy), wavelet=wavelet, threshold=threshold, rule=rule, transform=transform)
            # The plain transform of the truncated wavelet reconstructs to 0.5 % of an offset of 3.
            assert gain_db(clean, noisy, samples_of(found)[0]) > 2.0

    def test_argument_is_untouched_and_channels_are_independent(self) -> None:
        noisy = record(noise(400, 1), 5 + 3 * noise(400, 2))
        before = np.array(noisy.y)
        both = samples_of(denoise(noisy))
        np.testing.assert_array_equal(noisy.y, before)
        for i in range(2):
            np.testing.assert_array_equal(samples_of(denoise(record(before[i])))[0], both[i])

    def test_scale_of_the_record_does_not_matter(self) -> None:
        x = noise(300) + np.cos(np.arange(300) / 9)
        for scale in (1e-28, -1.0, 1e28):
            found = samples_of(denoise(record(scale * x))) / scale
            np.testing.assert_allclose(found, samples_of(denoise(record(x))), atol=1e-10)  # rounding, of order 1


class TestOffsetAndTrendSurvive:
    @given(
        count=st.integers(30, 500),
        offset=st.floats(-1e3, 1e3).map(lambda x: round(x, 6)),
        slope=st.floats(-10, 10).map(lambda x: round(x, 6)),
        transform=st.sampled_from(TRANSFORMS),
        wavelet=st.sampled_from(["haar", "sym4", "bior2.2"]),
    )
    @settings(max_examples=60, deadline=None)
    def test_a_line_comes_back(
        self, count: int, offset: float, slope: float, transform: TransformName, wavelet: str
    ) -> None:
        line = np.asarray(offset + slope * np.arange(count), float)
        found = samples_of(denoise(record(line), wavelet=wavelet, transform=transform))[0]
        np.testing.assert_allclose(found, line, rtol=0, atol=1e-12 * (1 + np.max(np.abs(line))))  # rounding

    @pytest.mark.parametrize("transform", TRANSFORMS)
    @pytest.mark.parametrize("threshold", THRESHOLDS)
    @pytest.mark.parametrize("wavelet", ["sym8", "bior4.4"])
    def test_a_line_added_is_a_line_added(
        self, transform: TransformName, threshold: ThresholdName, wavelet: str
    ) -> None:
        x, line = noise(501) + np.sin(np.arange(501) / 20), 40.0 - 0.3 * np.arange(501)
        alone = samples_of(denoise(record(x), transform=transform, threshold=threshold, wavelet=wavelet))[0]
        above = samples_of(denoise(record(x + line), transform=transform, threshold=threshold, wavelet=wavelet))[0]
        # Rounding of 1e-14, amplified where BayesShrink divides by what little exceeds the noise.
        np.testing.assert_allclose(above, alone + line, rtol=0, atol=1e-7)


class TestCleanRecordsAreUnchanged:
    @pytest.mark.parametrize("transform", TRANSFORMS)
    def test_steps_under_haar(self, transform: TransformName) -> None:
        steps = np.repeat([1.0, -2.0, 5.0, 5.5], 50)
        found = denoise(record(steps), wavelet="haar", transform=transform)
        np.testing.assert_array_equal(samples_of(found)[0], steps)

    @pytest.mark.parametrize("threshold", THRESHOLDS)
    def test_a_clean_decay(self, threshold: ThresholdName) -> None:
        clean = table_1_decay()
        # Eight vanishing moments at 13 Hz of 500 Hz: (2 pi 13 / 500)^8 = 2.6e-7 is all that looks like noise.
        np.testing.assert_allclose(denoise(clean, threshold=threshold).y, clean.y, rtol=0, atol=1e-6 * np.ptp(clean.y))


class TestStationaryTransform:
    @given(count=st.integers(30, 400))
    @settings(max_examples=30, deadline=None)
    def test_inverse_and_energy_for_any_length(self, count: int) -> None:
        """Energy: the levels of all shifts, each over its redundancy ``2^j``, add up to the record's."""
        filters, x = filter_bank("sym8", count), noise(2 * count)
        details, rough = stationary_details(x, filters, filters.depth)
        np.testing.assert_allclose(stationary_inverse(details, rough, filters), x, atol=1e-12)  # rounding
        shares = [np.sum(d**2) / 2 ** (j + 1) for j, d in enumerate(details)] + [np.sum(rough**2) / 2**filters.depth]
        np.testing.assert_allclose(sum(shares), np.sum(x**2), rtol=1e-12)  # rounding

    def test_shifts_commute(self) -> None:
        filters, x = filter_bank("db3", 101), noise(202)
        for shift in (1, 7, 100):
            for moved, there in zip(
                stationary_details(np.roll(x, shift), filters, 3)[0], stationary_details(x, filters, 3)[0], strict=True
            ):
                np.testing.assert_allclose(moved, np.roll(there, shift), atol=1e-12)  # rounding

    @pytest.mark.parametrize("wavelet", ["sym8", "bior2.4"])
    @pytest.mark.parametrize("rule", RULES)
    def test_equals_cycle_spinning(self, wavelet: str, rule: RuleName) -> None:
        """The mean over all shifts of the plain transform, shrunk and shifted back, by PyWavelets' periodic DWT."""
        n, level = 128, 2
        ramp = np.arange(n) - (n - 1) / 2
        x = noise(n) + 6 * (np.arange(n) > 50)
        x = x - x.mean() - ramp * (ramp @ x) / (ramp @ ramp)  # a record without a line to set aside
        period = np.concatenate([x, x[::-1]])
        plain = {
            shift: pywt.wavedec(np.roll(period, shift), wavelet, mode="periodization", level=level)
            for shift in range(2**level)
        }
        finest = np.concatenate([plain[0][-1], plain[1][-1]])  # even and odd shifts: all there are
        taps = np.array(pywt.Wavelet(wavelet).dec_hi)
        std = np.median(np.abs(finest)) / 0.67448975 / np.linalg.norm(taps)
        low = np.zeros(2 * len(taps) - 1)
        low[::2] = taps
        gains = [np.linalg.norm(np.convolve(low, pywt.Wavelet(wavelet).dec_lo)), np.linalg.norm(taps)]
        total = np.zeros(2 * n)
        for shift, (rough, *details) in plain.items():
            limits = [std * gain * np.sqrt(2 * np.log(n)) for gain in gains]
            shrunk = [pywt.threshold(d, t, mode=rule) for d, t in zip(details, limits, strict=True)]
            total += np.roll(pywt.waverec([rough, *shrunk], wavelet, mode="periodization"), -shift)
        found = denoise(record(x), wavelet=wavelet, level=level, threshold="universal", rule=rule)
        np.testing.assert_allclose(samples_of(found)[0], total[:n] / 2**level, atol=1e-10)  # rounding

    @pytest.mark.parametrize("wavelet", ["sym8", "haar", "bior3.1", "rbio3.3", "bior6.8"])
    def test_gain_is_the_norm_of_the_stretched_filters(self, wavelet: str) -> None:
        filters, taps = filter_bank(wavelet, 600), pywt.Wavelet(wavelet)
        path = np.array([1.0])
        for j in range(3):
            low, high = np.zeros((2, (taps.dec_len - 1) * 2**j + 1))
            low[:: 2**j], high[:: 2**j] = taps.dec_lo, taps.dec_hi
            np.testing.assert_allclose(filters.gains[j], np.linalg.norm(np.convolve(path, high)), rtol=1e-9)  # rounding
            path = np.convolve(path, low)

    def test_white_noise_has_one_deviation_at_all_levels(self) -> None:
        for wavelet in ("sym8", "bior2.2"):
            filters = filter_bank(wavelet, 2**15)
            details, _ = stationary_details(noise(2**16), filters, 4)
            # The median of 2^16 / 2^4 independent coefficients scatters by 1.17 / sqrt(4096) = 2 %; three times that.
            np.testing.assert_allclose(noise_std(details, filters), 1.0, atol=0.06)

    def test_plain_transform_of_noise_keeps_its_energy(self) -> None:
        """Orthogonality: what the plain periodic transform takes out is noise's energy, coefficient by coefficient."""
        x = noise(1024)
        coefficients = np.concatenate(pywt.wavedec(x, "sym8", mode="periodization", level=4))
        np.testing.assert_allclose(np.sum(coefficients**2), np.sum(x**2), rtol=1e-12)  # rounding


class TestThresholds:
    def test_universal_passes_pure_noise_as_often_as_the_normal_law_says(self) -> None:
        n, trials = 1000, 2000
        limit = universal_threshold(n)
        silent = sum(not np.any(shrink(x, limit, rule="soft")) for x in noise(n * trials).reshape(trials, n))
        expected = erf(limit / np.sqrt(2)) ** n
        # Four deviations of a binomial count: wrong by chance once in 16 000 seeds.
        assert abs(silent / trials - expected) < 4 * np.sqrt(expected * (1 - expected) / trials)

    def test_universal_takes_pure_noise_out_of_a_record(self) -> None:
        x = noise(4096)
        found = samples_of(denoise(record(x), threshold="universal", rule="soft"))[0]
        # Left is the approximation: 4096 / 2^8 = 16 coefficients, of variance 1 each, four deviations up.
        assert np.mean(found**2) < (16 + 4 * np.sqrt(2 * 16)) / 4096

    @pytest.mark.parametrize(
        ("count", "printed"),
        [(64, 1.474), (128, 1.669), (256, 1.859), (512, 2.045), (1024, 2.226), (2048, 2.403), (4096, 2.575)],
    )
    def test_minimax_is_the_table_of_donoho_and_johnstone(self, count: int, printed: float) -> None:
        assert minimax_threshold(count) == pytest.approx(printed, abs=6e-4)  # printed to three decimals

    def test_minimax_balances_risk_without_and_with_signal(self) -> None:
        """By quadrature of both risks: noise alone, and a mean so large that nothing is taken out."""
        z = np.linspace(-12, 12, 200_001)
        density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) * (z[1] - z[0])
        for count in (100, 5000):
            limit = minimax_threshold(count)
            silent = np.sum(shrink(z, limit, rule="soft") ** 2 * density)
            loud = np.sum((shrink(z + 50, limit, rule="soft") - 50) ** 2 * density)
            assert (count + 1) * silent == pytest.approx(loud, rel=1e-6)  # quadrature

    @pytest.mark.parametrize("rule", ["soft", "garrote"])
    @pytest.mark.parametrize("spread", [0.0, 1.0, 5.0])
    def test_sure_is_the_least_of_steins_formula(self, rule: RuleName, spread: float) -> None:
        """Stein: ``sum(1 + g^2 + 2 g')`` with ``g(x)`` = shrunk less x, its slope by differences, at each threshold."""

        def risk(limit: float) -> float:
            h = 1e-7
            slope = (shrink(x + h, limit, rule=rule) - shrink(x - h, limit, rule=rule)) / (2 * h) - 1
            return float(np.sum(1 + (shrink(x, limit, rule=rule) - x) ** 2 + 2 * slope))

        for seed in range(20):
            x = noise(200, seed) + spread * noise(200, 100 + seed) * (noise(200, 200 + seed) > 0.5)
            found = sure_threshold(x, rule=rule)
            assert 0 <= found <= universal_threshold(200)
            # Just above a coefficient, where both its sides are taken out; between them the risk only grows.
            least = min(risk(t) for t in [*(np.abs(x[np.abs(x) < universal_threshold(200)]) + 1e-6), 1e-6])
            grid = min(risk(t) for t in np.linspace(0, universal_threshold(200), 300))
            assert risk(found + 1e-6) <= min(least, grid) + 1e-3  # of differences with step 1e-7

    @pytest.mark.parametrize("rule", ["soft", "garrote"])
    @pytest.mark.parametrize("spread", [0.0, 1.0, 5.0])
    @pytest.mark.parametrize("digits", [None, 1])
    def test_sure_of_many_is_that_of_all_sorted(self, rule: RuleName, spread: float, digits: int | None) -> None:
        """The risk at every coefficient from sums over all smaller and all larger ones, without a histogram."""
        count = 25_000
        x = noise(count, 1) + spread * noise(count, 2) * (noise(count, 3) > 1.0)
        x = x if digits is None else np.round(x, digits)
        size = np.sort(np.abs(x))
        size = np.concatenate([[0.0], size])
        removed = np.cumsum(size**2 - 1) + 1
        kept = count - np.arange(count + 1)
        inverse = np.divide(1.0, size**2, out=np.zeros_like(size), where=size > 0)
        left = kept * size**2 if rule == "soft" else (size**4 + 2 * size**2) * (np.sum(inverse) - np.cumsum(inverse))
        risk = np.where(size <= universal_threshold(count), removed + kept + left, np.inf)
        assert sure_threshold(x, rule=rule) == size[np.argmin(risk)]

    @pytest.mark.parametrize("rule", ["soft", "garrote"])
    def test_sure_keeps_dense_signal_and_kills_pure_noise(self, rule: RuleName) -> None:
        """Where all is signal no threshold has a loss near the noise's; where none is, none has less than zero."""
        signal = 6 * np.sign(noise(2000, 1))
        dense = signal + noise(2000, 2)
        loss = np.mean((shrink(dense, sure_threshold(dense, rule=rule), rule=rule) - signal) ** 2)
        assert loss == pytest.approx(1.0, abs=0.15)  # 1 but for scatter: sqrt(2 / 2000) = 3 %, and the choice itself
        alone = noise(2000, 3)
        assert np.mean(shrink(alone, sure_threshold(alone, rule=rule), rule=rule) ** 2) < 0.05

    def test_bayes_is_noise_variance_over_signal_deviation(self) -> None:
        assert bayes_threshold(np.array([np.sqrt(5.0), -np.sqrt(5.0)])) == pytest.approx(
            0.5, rel=1e-12
        )  # 1 / sqrt(5 - 1)
        assert bayes_threshold(np.array([0.5, -0.9])) == 0.9


class TestRules:
    def test_formulas(self) -> None:
        x = np.array([-3.0, -2.0, -1.0, 0.0, 1.5, 2.0, 4.0])
        np.testing.assert_array_equal(shrink(x, 2.0, rule="hard"), [-3, 0, 0, 0, 0, 0, 4])
        np.testing.assert_array_equal(shrink(x, 2.0, rule="soft"), [-1, 0, 0, 0, 0, 0, 2])
        np.testing.assert_allclose(shrink(x, 2.0, rule="garrote"), [-3 + 4 / 3, 0, 0, 0, 0, 0, 3], rtol=1e-15)

    @pytest.mark.parametrize("rule", RULES)
    @given(limit=st.floats(0.01, 10))
    @settings(max_examples=25, deadline=None)
    def test_equals_pywavelets(self, rule: RuleName, limit: float) -> None:
        x = 5 * noise(200)
        np.testing.assert_allclose(shrink(x, limit, rule=rule), pywt.threshold(x, limit, mode=rule), atol=1e-12)

    def test_garrote_lies_between_soft_and_hard(self) -> None:
        x = np.linspace(0, 9, 1000)
        soft, garrote, hard = (shrink(x, 2.0, rule=rule) for rule in ("soft", "garrote", "hard"))
        assert np.all((soft <= garrote) & (garrote <= hard))


class TestLevel:
    def test_a_mode_that_rings_on_is_not_shrunk(self) -> None:
        """The universal threshold under the soft rule takes 4 deviations off every coefficient it meets."""
        sine = 3 * np.sin(2 * np.pi * np.arange(4096) / 60)
        noisy = sine + noise(4096)

        def amplitude(level: int | None) -> float:
            found = denoise(record(noisy), level=level, threshold="universal", rule="soft")
            return float(samples_of(found)[0] @ sine / (sine @ sine))

        assert amplitude(None) == pytest.approx(1.0, abs=0.02)  # least squares on 4096 samples: 0.7 % of scatter
        assert amplitude(8) < 0.9

    def test_noise_per_level_does_not_take_a_mode_for_noise(self) -> None:
        clean = table_1_decay()
        noisy = add_noise(clean, snr_db=20.0, rng=np.random.default_rng(0))
        found = samples_of(denoise(noisy, noise="per-level"))
        for i in range(3):
            assert gain_db(clean.y[i], noisy.y[i], found[i]) > 6.0

    def test_noise_per_level_meets_coloured_noise(self) -> None:
        """Noise 4 times stronger below the finest level's octave: it goes if each level has its own deviation."""
        spectrum = np.fft.rfft(noise(8192))
        spectrum[: len(spectrum) // 2] *= 4
        x = np.fft.irfft(spectrum)
        left = {
            name: np.mean(samples_of(denoise(record(x), level=8, threshold="universal", noise=name))[0] ** 2)
            for name in ("once", "per-level")
        }
        # What is left is the approximation: a share of 2^-8 of the band, of power 16.
        assert left["per-level"] < 2 * 16 / 256
        assert left["once"] > 0.5


class TestGain:
    @pytest.mark.parametrize("name", ["Blocks", "Bumps", "HeaviSine", "Doppler"])
    @pytest.mark.parametrize("seed", [0, 1])
    def test_beats_scikit_image_on_donoho_and_johnstones_signals(self, name: str, seed: int) -> None:
        restoration = pytest.importorskip("skimage.restoration")
        clean = np.asarray(pywt.data.demo_signal(name, 2048), float)
        noisy = clean + np.std(clean) / np.sqrt(10) * noise(2048, seed)
        theirs = max(
            gain_db(
                clean,
                noisy,
                restoration.denoise_wavelet(noisy, wavelet="sym8", method=method, mode=mode, rescale_sigma=True),
            )
            for method in ("BayesShrink", "VisuShrink")
            for mode in ("soft", "hard")
        )
        ours = gain_db(clean, noisy, samples_of(denoise(record(noisy)))[0])
        assert ours > theirs
        plain = denoise(record(noisy), threshold="bayes", rule="soft", transform="decimated")
        bayes = restoration.denoise_wavelet(noisy, wavelet="sym8", method="BayesShrink", mode="soft")
        # The same method but for the ends, the depth and their variance from the level alone.
        assert gain_db(clean, noisy, samples_of(plain)[0]) > gain_db(clean, noisy, bayes) - 0.5

    @pytest.mark.parametrize("snr_db", [20.0, 2.0])
    def test_all_channels_of_table_1(self, snr_db: float) -> None:
        clean = table_1_decay()
        noisy = add_noise(clean, snr_db=snr_db, rng=np.random.default_rng(0))
        found = samples_of(denoise(noisy))
        for i in range(3):
            # Modes fill the octaves below 15.6 Hz of 250 Hz: at least the 12 dB above could go, without loss.
            assert gain_db(clean.y[i], noisy.y[i], found[i]) > 9.0


class TestRefusals:
    def test_unknown_wavelet_names_the_nearest(self) -> None:
        with pytest.raises(InputError, match=r"'symm8' is no discrete wavelet; the nearest names are 'sym8'"):
            denoise(record(noise(100)), wavelet="symm8")
        with pytest.raises(InputError, match="'morl' is a continuous wavelet"):
            denoise(record(noise(100)), wavelet="morl")

    def test_short_record_says_how_short(self) -> None:
        with pytest.raises(RecordError, match=r"has 29 samples; 'sym8' with its 16 taps needs at least 30"):
            denoise(record(noise(29)))
        assert samples_of(denoise(record(noise(30)))).shape == (1, 30)

    def test_level_out_of_reach(self) -> None:
        for level in (0, 9, 2.5, True):
            with pytest.raises(InputError, match="a record of 5000 samples has levels 1 to 8"):
                denoise(record(noise(5000)), level=level)  # type: ignore[arg-type]

    def test_unknown_choices(self) -> None:
        with pytest.raises(InputError, match=r"threshold='shure' is unknown. Did you mean 'sure'"):
            denoise(record(noise(100)), threshold="shure")  # type: ignore[arg-type]
        with pytest.raises(InputError, match=r"rule='firm' is unknown"):
            denoise(record(noise(100)), rule="firm")  # type: ignore[arg-type]
        with pytest.raises(InputError, match=r"noise='mad' is unknown"):
            denoise(record(noise(100)), noise="mad")  # type: ignore[arg-type]
        with pytest.raises(InputError, match=r"transform='swt' is unknown"):
            denoise(record(noise(100)), transform="swt")  # type: ignore[arg-type]

    def test_gaps(self) -> None:
        x = noise(100)
        x[7] = np.nan
        with pytest.raises(RecordError, match="1 of 100 samples that are not finite"):
            denoise(record(x))


class TestReport:
    def test_gain_is_the_ratio_of_error_energies(self) -> None:
        clean = noise(50)[None]
        assert denoising_report.snr_gain(clean, clean + 0.1, clean - 0.01)[0] == pytest.approx(
            20.0, rel=1e-9
        )  # rounding

    @pytest.mark.parametrize(("snr_db", "published"), [(20.0, 0.038), (2.0, 0.303)])
    def test_bound_is_the_known_one(self, snr_db: float, published: float) -> None:
        """Expected MAE of an estimate at the bound from the seat alone, in %pt: known figures, to their digits."""
        decay = table_1_decay()
        seat = as_response(np.asarray(decay.time), samples_of(decay)[:1], ("seat",))
        bound = denoising_report.zeta_bound(denoising_report.Case(name="seat", clean=seat, snr_db=snr_db))
        assert np.sqrt(2 / np.pi) * np.mean(100 * bound) == pytest.approx(published, abs=6e-4)

    def test_an_exact_identification_has_no_error(self) -> None:
        truth = ModalSet.from_wn_zeta([21.2737, 50.1386, 83.8549], [0.00788554, 0.02533097, 0.01564827])
        text = denoising_report.zeta_part(lambda _: truth, seeds=1)
        assert "0 of 3" in text
        assert "1 of 3" not in text
        errors = [
            float(cell.split()[0])
            for line in text.splitlines()
            if "as measured" in line and "|" in line
            for cell in line.split("|")[3:6]
        ]
        np.testing.assert_allclose(errors, 0, atol=1e-4)  # to the digits given above and printed

    def test_a_failed_identification_is_counted(self) -> None:
        calls: list[int] = []

        def fails_on_noise(_: control.TimeResponseData) -> ModalSet:
            if calls:
                raise IdentificationError("no ridge stands out")
            calls.append(1)
            return ModalSet.from_wn_zeta([21.0, 50.0, 83.0], [0.01, 0.02, 0.01])

        assert "3 of 3" in denoising_report.zeta_part(fails_on_noise, seeds=1)
