"""Events: the background of a band, the levels above it, and where an event begins and ends."""

import tracemalloc

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid.decays.bursts import AFTERWARDS, OVER, RISE, find_bursts
from suspid.decays.envelopes import Envelopes, background, envelopes, finest
from suspid.signals import Signal

Real = NDArray[np.float64]
FS = 100.0


def signal(values: Real) -> Signal:
    values = np.atleast_2d(values)
    return Signal(start=0.0, step=1 / FS, values=values, channels=tuple(f"y{i}" for i in range(len(values))))


def noise(seed: int, samples: int = 20000, channels: int = 1) -> Real:
    return np.random.default_rng(seed).standard_normal((channels, samples))


def test_more_channels_take_no_more_memory() -> None:
    """They are taken one by one, so that a long record needs a few copies of one channel."""

    def peak(channels: int) -> int:
        values = noise(0, samples=100_000, channels=channels)
        tracemalloc.start()
        try:
            envelopes(signal(values), np.zeros(channels))
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak(1)
    assert peak(6) < peak(1) + 100_000


class TestBackground:
    """The power of noise in a band is exponentially distributed; its mean is read from a low quantile."""

    def test_is_the_mean_power_of_noise(self) -> None:
        # A quantile q of n values scatters by sqrt(q / (1 - q) / n) / -log(1 - q) of the mean: 0.6 % at q = 0.25.
        power = np.random.default_rng(1).exponential(3.0, 100_000)
        assert background(power) == pytest.approx(3.0, rel=4 * 0.0063)

    def test_decays_in_half_of_the_record_raise_it_by_less_than_4_db(self) -> None:
        # With half of the values loud, the quantile q of all is the quantile 2 q of the noise: q = 0.25 gives
        # log(1 - 0.5) / log(1 - 0.25) = 3.8 dB, q = 0.3 gives 4.1 dB, and q = 0.5 the decays themselves.
        power = np.random.default_rng(2).exponential(1.0, 100_000)
        power[::2] = 1e4
        assert 0 < 10 * np.log10(background(power)) < 4.0

    def test_scatters_by_a_tenth_when_known_from_400_values(self) -> None:
        # The same law: 10 % at q = 0.25, 11 % at 0.2, 16 % at 0.1. The standard deviation of 400 records scatters by
        # 3.5 % of itself.
        power = np.random.default_rng(3).exponential(1.0, (400, 400))
        assert np.std([background(each) for each in power]) < 0.12

    def test_no_sensor_is_quieter_than_70_db_below_the_peak(self) -> None:
        power = np.full(1000, 1e-12)
        power[500] = 1.0
        assert background(power) == pytest.approx(1e-7)


# Of the longer record, samples of the envelopes of the higher bands are left out between the points.
@pytest.mark.parametrize("samples", [20_000, 900_000])
class TestLevels:
    def test_of_white_noise_are_0_db_on_average_in_every_band(self, samples: int) -> None:
        # Below that by what few cycles take off, 10 log10(1 + 24 / cycles). A band of 0.4 octaves of T f cycles holds
        # about 0.7 T f independent values; the mean and the quantile scatter by 1 and 2 over the root of that.
        found = envelopes(signal(noise(4, samples)))
        for centre, levels in zip(found.centres[:6], found.levels, strict=False):
            cycles = float(centre) * samples / FS
            mean = float(np.mean(10 ** (levels / 10))) * (1 + 24 / cycles)
            assert mean == pytest.approx(1.0, abs=3 * np.sqrt(5 / (0.7 * cycles)))

    def test_a_tone_burst_rises_by_its_power_over_the_noise_in_its_band(self, samples: int) -> None:
        values = noise(5, samples)
        centre, time = FS / 16, np.arange(samples) / FS
        window = np.exp(-(((time - 100.0) / 2) ** 2))
        values[0] += 20.0 * window * np.cos(2 * np.pi * centre * time)
        found = envelopes(signal(values))
        band = int(np.argmin(np.abs(found.centres - centre)))
        # The band is a Gaussian over log2 f of 0.4 octaves: its square passes 0.4 log(2) sqrt(pi) f of the density
        # 1 / fs of white noise, and a tone of amplitude A with power A^2 / 4, at positive frequencies alone.
        passed = 0.4 * np.log(2) * np.sqrt(np.pi) * centre / FS
        expected = 10 * np.log10(20.0**2 / 4 / passed) - 10 * np.log10(1 + 24 / (centre * samples / FS))
        # Noise beside the tone: 5 % in amplitude; the background is known to a tenth.
        assert float(np.max(found.levels[band])) == pytest.approx(expected, abs=1.2)
        assert found.timepts[np.argmax(found.levels[band])] == pytest.approx(100.0, abs=0.5)


class TestThreshold:
    def test_the_threshold_grows_with_the_logarithm_of_the_number_of_samples(self) -> None:
        # Exponential power of mean 1 exceeds p with probability exp(-p): a chance of 1e-3 in n samples is log(1000 n).
        found = envelopes(signal(noise(6, samples=5000, channels=2)))
        assert found.threshold == pytest.approx(10 * np.log10(4 * np.log(1e4 * 1000)))

    @pytest.mark.parametrize("step", [0.125, float(np.exp(1.0))])
    def test_a_resampled_quantised_sensor_has_the_deviation_of_its_steps(self, step: float) -> None:
        held = np.repeat(step * np.round(3 * noise(7, samples=500)[0]), 4)
        between = np.repeat(held, 2)
        between[4::8] = between[3:-1:8] / np.pi + (1 - 1 / np.pi) * between[5::8]
        # Rounding to a step d leaves an error uniform over d, of standard deviation d / sqrt(12).
        assert finest(between[None])[0] == pytest.approx(step / np.sqrt(12), rel=1e-9)


def bands(*levels: Real, threshold: float = 20.0, step: float = 0.1, period: int = 1) -> Envelopes:
    """Levels by hand: the highest band has a period of this many points."""
    count = len(levels[0])
    centres = np.asarray(1 / (period * step) / 2.0 ** np.arange(len(levels)), float)
    time = np.asarray(step * np.arange(count), float)
    return Envelopes(timepts=time, centres=centres, levels=np.array(levels), threshold=threshold)


class TestEvents:
    """A level that rises at once and falls by 1 dB a point: everything is known."""

    def test_begins_at_the_rise_and_ends_half_its_length_after_it_is_over(self) -> None:
        level = np.full(400, 0.0)
        level[100:150] = 50.0 - np.arange(50)
        (burst,) = find_bursts(bands(level))
        assert (burst.onset, burst.peak, burst.level) == pytest.approx((10.0, 10.0, 50.0))
        # Below the threshold less OVER after 50 - (20 - 8) + 1 = 39 points, and half of that again.
        over = 50 - (20 - OVER) + 1
        assert burst.stop == pytest.approx(10.0 + 0.1 * int(over * (1 + AFTERWARDS)), abs=1e-9)
        assert burst.width == pytest.approx(0.1)
        assert not burst.cut

    @pytest.mark.parametrize(("rise", "events"), [(RISE - 0.5, 1), (RISE + 0.5, 2)])
    def test_a_second_one_begins_where_the_level_rises_enough(self, rise: float, events: int) -> None:
        level = np.full(400, 0.0)
        level[100:150] = 60.0 - 0.5 * np.arange(50)
        level[125:225] = level[124] + rise - 0.5 * np.arange(100)
        found = find_bursts(bands(level))
        assert len(found) == events
        assert found[0].cut == (events == 2)
        if events == 2:
            assert found[0].stop == pytest.approx(12.4)
            assert found[1].onset == pytest.approx(12.5)

    def test_ends_where_a_slow_band_shows_the_next_event(self) -> None:
        """A filter of a slow band sees an event before it begins; the fastest band tells when it does."""
        fast, slow = np.full(400, 0.0), np.full(400, 0.0)
        fast[100:150] = slow[100:150] = 60.0 - 0.5 * np.arange(50)
        fast[150:200], slow[145:200] = 70.0 - 0.5 * np.arange(50), 55.0 + 0.1 * np.arange(55)
        first, second = find_bursts(bands(fast, slow))
        assert first.stop == pytest.approx(14.4)
        assert first.again == ()
        assert second.onset == pytest.approx(15.0)

    def test_below_the_threshold_there_is_none(self) -> None:
        level = np.full(400, 0.0)
        level[100:150] = 19.9 - 0.1 * np.arange(50)
        assert find_bursts(bands(level)) == ()

    def test_the_highest_band_that_rings_is_told(self) -> None:
        # The highest band passes the threshold for one period only; the one below it rings on.
        high, low = np.full(400, 0.0), np.full(400, 0.0)
        high[100:102] = 60.0
        low[100:160] = 60.0 - 0.5 * np.arange(60)
        (burst,) = find_bursts(bands(high, low))
        assert burst.top == pytest.approx(5.0)
        assert burst.width == pytest.approx(0.1)

    @pytest.mark.parametrize(("periods", "rings"), [(2.0, False), (3.5, True)])
    def test_a_band_rings_if_it_passes_the_threshold_for_half_of_1_5_to_4_periods(
        self, periods: float, rings: bool
    ) -> None:
        high, low = np.full(800, 0.0), np.full(800, 0.0)
        high[200 : 200 + int(10 * periods)] = 60.0
        low[200:360] = 60.0 - 0.25 * np.arange(160)
        (burst,) = find_bursts(bands(high, low, period=10))
        assert burst.top == pytest.approx(1.0 if rings else 0.5)
