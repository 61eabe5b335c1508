"""Trials of a stretch: what the fit says of its first part, its modes, the noise; refusals, kinds and the start."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import identify
from suspid.decays.bursts import Burst
from suspid.decays.doubts import clipped_samples, doubts_of, doubts_of_background, doubts_of_company
from suspid.decays.kinds import kind_of
from suspid.decays.refusals import fits, refused
from suspid.decays.starts import find_start
from suspid.decays.trials import Trial, background_ratio, block_size, blocks_of, quiet_variance, tried, with_all_motion
from suspid.decays.verification import verified
from suspid.records import as_response
from suspid.signals import Signal, block_means
from suspid.words import DecayDoubt, DecayKind, DecayRemark
from validation.bounds import cramer_rao

Real = NDArray[np.float64]
STEP = 0.01
# A mode of 1.5 Hz with 10 % of damping.
WN, ZETA = 2 * np.pi * 1.5, 0.1
POLE = WN * complex(-ZETA, np.sqrt(1 - ZETA**2))


def decay(count: int = 600, since: int = 0, size: tuple[float, ...] = (1.0, -0.5)) -> Real:
    time = STEP * np.arange(count - since)
    out = np.zeros((len(size), count))
    out[:, since:] = np.outer(size, np.exp(POLE * time).real)
    return out


def noise(seed: int, count: int = 600, channels: int = 2) -> Real:
    return np.random.default_rng(seed).standard_normal((channels, count))


def trial(values: Real, size: int = 2) -> Trial:
    found = tried(values, step=STEP, size=size, least=np.zeros(len(values)))
    assert found is not None
    return found


def signal(values: Real) -> Signal:
    return Signal(start=0.0, step=STEP, values=values, channels=tuple(f"y{i}" for i in range(len(values))))


def burst(onset: float = 0.0, stop: float = 6.0, *, cut: bool = False) -> Burst:
    return Burst(onset=onset, peak=onset, stop=stop, level=40.0, top=6.0, width=0.1, cut=cut)


class TestTrial:
    def test_blocks_are_an_eighth_of_a_period(self) -> None:
        assert block_size(0.001, 10.0) == 12
        assert block_size(0.1, 10.0) == 1

    def test_too_short_or_constant(self) -> None:
        assert tried(decay(63), step=STEP, size=2, least=np.zeros(2)) is None
        assert tried(decay(64), step=STEP, size=2, least=np.zeros(2)) is not None
        assert tried(np.stack([decay()[0], np.ones(600)]), step=STEP, size=2, least=np.zeros(2)) is None

    def test_finds_the_mode_and_the_noise(self) -> None:
        found = trial(decay() + 0.01 * noise(1))
        theta = found.selection.fit.poles.pairs[found.modes] / found.step
        # Means over blocks keep the pole; the noise of a mean over two samples is 1 / sqrt(2) of theirs.
        assert theta[0] == pytest.approx(POLE, rel=0.01)
        assert found.noise_std == pytest.approx(0.01 / np.sqrt(2), rel=4 / np.sqrt(2 * 300))

    def test_energy_over_noise_bounds_the_decay_rate(self) -> None:
        """The least relative standard deviation of the decay rate is 2 / sqrt(E), by the Cramér-Rao bound."""
        found, time = trial(decay() + 0.01 * noise(1)), np.asarray(STEP * np.arange(600), float)
        bound = cramer_rao(np.array([POLE]), np.array([[1.0], [-0.5]]), time, noise_std=np.full(2, 0.01))
        # To order zeta the relative deviation of zeta is that of the decay rate.
        assert found.rate_std[0] == pytest.approx(float(bound.zeta_std[0]) / ZETA, rel=ZETA)

    def test_cycles_end_where_the_amplitude_over_one_cycle_meets_the_noise(self) -> None:
        found = trial(decay() + 0.01 * noise(1))
        # Energy of a cycle at amplitude a in n = 33.5 blocks: a^2 n / 2 over the noise variance of a block, summed.
        per_cycle = 2 * np.pi / POLE.imag / (2 * STEP)
        energy = (1 + 0.25) / (0.01**2 / 2) * per_cycle / 2
        expected = 0.5 * np.log(energy) / -POLE.real * POLE.imag / (2 * np.pi)
        assert found.cycles[0] == pytest.approx(min(expected, 6.0 * POLE.imag / (2 * np.pi)), rel=0.03)

    def test_first_part_of_a_decay_is_like_the_others(self) -> None:
        assert max(trial(decay() + 0.01 * noise(seed)).excess for seed in range(5)) < 1
        assert fits(trial(decay() + 0.01 * noise(1)))

    def test_excess_is_the_power_of_the_first_part_over_what_chance_allows(self) -> None:
        # A residual of +-1 has power 1; 12 of 300 blocks make the first part, and 5 standard deviations of a variance
        # from 12 values are 5 sqrt(2 / 12).
        residual = np.sign(noise(2, 300))
        residual *= np.array([[1.0], [0.1]])
        residual[0, :12] *= 2
        found = replace(trial(decay() + 0.01 * noise(1)), residual=residual)
        assert found.excess == pytest.approx(4 / (1 + 5 * np.sqrt(2 / 12)))
        assert found.early == pytest.approx(2 / np.sqrt(np.mean(found.motion[0, :12] ** 2)))

    def test_what_is_left_counts_where_it_is_coloured(self) -> None:
        # White noise of a tenth of the motion is nothing left; a random walk of that size is.
        assert np.all(trial(decay() + 0.1 * noise(2)).left == 0)
        walk = np.cumsum(noise(3), axis=1)
        walk -= walk.mean(axis=1, keepdims=True)
        assert np.max(trial(decay() + 0.1 * walk / walk.std()).left) > 0.01

    def test_nothing_but_noise_leaves_everything_without_a_warning(self) -> None:
        found = trial(1e6 * np.cumsum(noise(4), axis=1))
        assert not fits(found) or not len(found.modes)


class TestNoiseOfARecording:
    def test_quiet_variance_is_below_that_of_white_noise(self) -> None:
        # Half of a low quantile over the stretches of the variance of means over 4 samples, 1 / 4.
        found = quiet_variance(block_means(noise(1, 20000), 4), size=4, blocks=blocks_of(400, 4), finest=np.zeros(2))
        assert np.all((found > 0.4 / 4) & (found < 0.5 / 4))

    def test_quiet_variance_is_that_beside_a_drift(self) -> None:
        """A fit takes a drift as a parabola: a sensor that warms up is no reason to leave motion to the noise."""
        drift = 30 * np.sin(2 * np.pi * np.arange(20000) / 40000)
        # Nor is a level far from zero.
        found = quiet_variance(
            block_means(1e8 + noise(1, 20000) + drift, 4), size=4, blocks=blocks_of(400, 4), finest=np.zeros(2)
        )
        assert np.all((found > 0.4 / 4) & (found < 0.5 / 4))

    def test_quiet_variance_of_a_long_stretch_is_that_of_as_many_blocks_as_a_trial_has(self) -> None:
        """A stretch of minutes holds other events; the trial sees its first blocks alone."""
        values = noise(1, 60000)
        values[:, ::6000] += 300.0
        found = quiet_variance(block_means(values, 4), size=4, blocks=blocks_of(12000, 4), finest=np.zeros(2))
        assert np.all((found > 0.4 / 4) & (found < 0.5 / 4))

    def test_quiet_variance_of_a_short_recording_is_that_of_rounding(self) -> None:
        found = quiet_variance(
            block_means(noise(1, 600), 4), size=4, blocks=blocks_of(400, 4), finest=np.array([0.2, 0.4])
        )
        np.testing.assert_allclose(found, [0.01, 0.04])

    def test_white_background_has_the_power_of_white_noise(self) -> None:
        values = 0.01 * noise(5, 60000)
        values[:, -600:] += decay()
        found = trial(values[:, -600:])
        # The quantile 0.2 of 100 exponential values scatters by sqrt(0.2 / 0.8 / 100) / -log(0.8) = 22 %.
        ratio = background_ratio(block_means(values, 2), found, size=2, length=600)
        assert ratio[0] == pytest.approx(1.0, abs=3 * 0.25)
        assert doubts_of_background(block_means(values, 2), found, size=2, length=600) == ()

    def test_a_resonant_background_has_the_power_of_its_spectrum(self) -> None:
        from scipy.signal import lfilter

        values = 0.01 * noise(6, 60000)
        hum = 0.004 * lfilter([1.0], [1.0, -2 * 0.99 * np.cos(POLE.imag * STEP), 0.99**2], noise(7, 60000), axis=1)
        values += hum
        values[:, -600:] = decay() + 0.01 * noise(8)
        found = trial(values[:, -600:])
        turn = np.exp(-1j * found.selection.fit.poles.pairs[found.modes][0].imag / 2 * np.arange(3))
        response = 1 / abs(np.array([1.0, -2 * 0.99 * np.cos(POLE.imag * STEP), 0.99**2]) @ turn) ** 2
        expected = 1 + (0.004 / 0.01) ** 2 * response
        # The window is 300 blocks of 2 samples, 0.33 Hz wide at its half, and the resonance 0.32 Hz: some 2 dB.
        ratio = background_ratio(block_means(values, 2), found, size=2, length=600)
        assert abs(10 * np.log10(ratio[0] / expected)) < 4
        (doubt,) = doubts_of_background(block_means(values, 2), found, size=2, length=600)
        assert doubt.code is DecayDoubt.BACKGROUND

    @pytest.mark.parametrize("quiet", [slice(0, 30_000), slice(170_000, 200_000)])
    def test_a_long_recording_is_looked_at_evenly(self, quiet: slice) -> None:
        """Of five hundred stretches some are: a road that is rough for most of the drive is so at either end."""
        values = noise(6, 200_000)
        values[:, quiet] *= 0.1
        values[:, -400:] = 40 * decay(400) + 0.1 * noise(8, 400)
        found = trial(values[:, -400:])
        (ratio,) = background_ratio(block_means(values, 2), found, size=2, length=400)
        assert ratio > 10

    def test_what_rings_on_from_earlier_releases_is_no_background(self) -> None:
        """Three releases, the later ones before the motion has met the noise: it moves at the mode most of the time."""
        from scipy.signal import lfilter

        pole = np.exp(complex(POLE.real / 3, POLE.imag) * STEP)
        struck = np.zeros(2400)
        struck[[500, 1200, 1900]] = 1.0
        rings = lfilter([1.0, -pole.real], [1.0, -2 * pole.real, abs(pole) ** 2], struck)
        values = np.outer([1.0, -0.5], rings) + 1e-3 * noise(9, 2400)
        found = trial(values[:, 1900:])
        ratio = background_ratio(block_means(values, 2), found, size=2, length=500)
        assert 10 * np.log10(ratio[0]) < 6
        assert doubts_of_background(block_means(values, 2), found, size=2, length=500) == ()

    def test_a_drift_is_no_background(self) -> None:
        """Beside the free motion, what is left of a mode's course saw the drift of quiet sensors."""
        values = 1e-3 * noise(9, 60000) + np.outer([0.8, -0.3], np.sin(2 * np.pi * np.arange(60000) / 40000))
        values[:, -600:] += decay()
        found = trial(values[:, -600:])
        assert doubts_of_background(block_means(values, 2), found, size=2, length=600) == ()

    def test_is_that_of_white_noise_where_the_free_motion_of_the_modes_is_all_of_any_stretch(self) -> None:
        """Nine samples and two modes, each with a part that falls as it does and one that falls on: nine unknowns."""
        pairs = np.array([complex(-0.02, 0.6), complex(-0.03, 1.1)])
        poles = SimpleNamespace(pairs=pairs)
        fit = SimpleNamespace(poles=poles, amplitudes=np.ones((4, 2), complex))
        made = SimpleNamespace(
            residual=np.zeros((2, 9)),
            selection=SimpleNamespace(fit=fit),
            modes=np.array([0, 1]),
            noise_std=np.ones(2),
        )
        ratio = background_ratio(noise(4, 900), cast("Trial", made), size=1, length=9)
        np.testing.assert_array_equal(ratio, [1.0, 1.0])


class TestRefusals:
    def test_a_decay_is_not_refused(self) -> None:
        assert refused(trial(decay() + 0.01 * noise(1))) is None

    def test_noise_has_no_mode(self) -> None:
        assert refused(trial(noise(1))) == (DecayRemark.NO_MODE, {"others": ()})

    def test_a_growing_motion_is_refused(self) -> None:
        found = refused(trial(decay()[:, ::-1] + 0.3 * decay() + 0.001 * noise(1)))
        assert found is not None
        assert found[0] in (DecayRemark.GROWING, DecayRemark.NO_MODE)

    def test_a_weak_decay_is_refused_with_the_deviation_of_its_rate(self) -> None:
        # 2 / sqrt(E) with E = 1.25 / (4 zeta wn step sigma^2): above 0.14 from sigma = 0.4 on.
        for std, weak in ((0.2, False), (0.6, True)):
            found = refused(trial(decay() + std * noise(2)))
            assert (found is not None) == weak
            if weak:
                assert found is not None
                assert found[0] in (DecayRemark.WEAK, DecayRemark.NO_MODE)

    def test_half_of_the_events_refused_doubts_the_others_from_4_on(self) -> None:
        assert doubts_of_company(3, 4) == ()
        assert doubts_of_company(4, 8) == ()
        (doubt,) = doubts_of_company(5, 9)
        assert doubt.numbers == {"refused": 5, "examined": 9}


class TestDoubts:
    def of(self, values: Real, *, begin: int = 100, cycles: float = 5.0, cut: bool = False) -> list[object]:
        clipped = np.zeros(values.shape[1], bool)
        return [d.code for d in doubts_of(signal(values), trial(values), burst(cut=cut), cycles, begin, clipped)]

    def test_none_of_a_clean_decay(self) -> None:
        assert self.of(decay() + 0.01 * noise(1)) == []

    def test_few_cycles(self) -> None:
        values = decay() + 0.01 * noise(1)
        assert self.of(values, cycles=1.9) == [DecayDoubt.FEW_CYCLES]
        assert self.of(values, cycles=2.1) == []

    def test_a_record_that_begins_with_it_and_an_event_that_cuts_it_off(self) -> None:
        values = decay() + 0.01 * noise(1)
        assert self.of(values, begin=0) == [DecayDoubt.AT_START]
        assert self.of(values, cut=True) == [DecayDoubt.CUT_OFF]

    def test_too_short_for_the_mode(self) -> None:
        # 1.49 Hz makes two cycles in 134 samples, and 40 blocks of two samples are needed.
        assert self.of(decay(150) + 1e-3 * noise(1, 150)) == []
        assert DecayDoubt.TOO_SHORT in self.of(decay(120) + 1e-3 * noise(1, 120))
        assert DecayDoubt.FEW_SAMPLES in self.of(decay(76) + 1e-4 * noise(1, 76))

    def test_clipped_samples_are_runs_at_the_limit(self) -> None:
        values = np.clip(decay(size=(1.0,)), -0.4, None)
        clipped = clipped_samples(values)
        np.testing.assert_array_equal(clipped, values[0] == -0.4)
        assert np.sum(clipped) > 10


class TestKind:
    """The rest positions before and after, and the size of the motion between them."""

    def of(self, before: tuple[float, float], forced: float = 0.0) -> DecayKind | None:
        values = 1e-3 * noise(1, 800)
        values[:, 200:] += decay()
        values[:, :190] += np.array(before)[:, None]
        values[:, 190:200] += forced
        return kind_of(signal(values), trial(values[:, 200:]), 190, 200)

    def test_alike_shifts_are_a_step_and_others_a_release(self) -> None:
        assert self.of((0.5, 0.48)) is DecayKind.STEP
        assert self.of((0.5, 0.4)) is DecayKind.RELEASE
        assert self.of((-0.5, 0.5)) is DecayKind.RELEASE

    def test_one_channel_alone_does_not_tell(self) -> None:
        assert self.of((0.5, 0.0)) is DecayKind.STEP_OR_RELEASE

    def test_a_shift_counts_from_15_percent_of_the_motion_on(self) -> None:
        # The motion has swings of 1 and 0.5.
        assert self.of((0.13, 0.06)) is None
        assert self.of((0.18, 0.18)) is DecayKind.STEP

    def test_a_spike_twice_the_motion_is_an_impulse(self) -> None:
        assert self.of((0.0, 0.0), forced=2.2) is DecayKind.IMPULSE
        assert self.of((0.0, 0.0), forced=0.4) is None


class TestStart:
    def of(self, values: Real, *, first: int = 300) -> int:
        start = find_start(
            signal(values),
            np.zeros(2),
            burst(3.0),
            first,
            values.shape[1],
            1,
            np.zeros(values.shape[1], bool),
            np.zeros(2),
        )
        assert start.trial is not None
        return start.begin

    def test_is_the_end_of_the_excitation(self) -> None:
        values = 1e-3 * noise(1, 1000)
        values[:, 300:] += decay(700, since=40)
        values[:, 300:340] += 0.8 * np.hanning(40) * np.array([[1.0], [0.7]])
        # The halved interval between two starts is a tenth of the delay, 4 samples.
        assert 336 <= self.of(values) <= 348

    def test_is_the_onset_without_excitation(self) -> None:
        values = 1e-3 * noise(2, 1000)
        values[:, 300:] += decay(700)
        assert 300 <= self.of(values) <= 302

    def test_driven_motion_has_none(self) -> None:
        from scipy.signal import lfilter

        rolling = np.asarray(lfilter([1.0], [1.0, -1.85, 0.94], noise(3, 1000), axis=1))
        start = find_start(signal(rolling), np.zeros(2), burst(3.0), 300, 1000, 1, np.zeros(1000, bool), np.zeros(2))
        assert start.driven
        assert start.trial is None

    def test_forced_samples_are_left_out_by_less_than_a_block(self) -> None:
        values = decay(700) + 1e-3 * noise(4, 700)
        found = trial(values, size=8)
        values[:, :3] += np.array([[0.7, -1.2, 0.4], [-0.9, 0.5, 1.1]])
        begin, doubt = verified(signal(values), found, 0, 700, 8, moved=True)
        assert 3 <= begin < 8
        assert doubt is None

    def test_a_harmonic_that_was_named_is_not_missing(self) -> None:
        """Twice the frequency of a strong mode, twice its rate: it is found, as a part of that mode."""
        powers = np.exp(np.outer([-0.004 + 0.2j, -0.008 + 0.4j], np.arange(700)))
        values = (np.array([[1.0, 0.45], [0.8, 0.36]]) @ powers).real + 1e-4 * noise(4, 700)
        found = trial(values, size=2)
        assert len(found.modes) == 2
        assert len(identify(as_response(np.arange(700) / 100, values, ["a", "b"])).modes) == 1
        assert verified(signal(values), found, 0, 700, 2, moved=False) == (0, None)

    def test_identify_verifies_the_modes_of_a_trial(self) -> None:
        values = decay(700) + 1e-3 * noise(4, 700)
        assert verified(signal(values), trial(values), 0, 700, 2, moved=True) == (0, None)
        begin, doubt = verified(signal(1e-3 * noise(5, 700)), trial(values), 0, 700, 2, moved=False)
        assert begin == 0
        assert doubt is not None
        assert doubt.code is DecayDoubt.MODES_MISSING
        assert doubt.numbers["hertz"] == pytest.approx((1.5,), rel=0.01)


@pytest.mark.parametrize(
    ("hertz", "noise", "size"),
    [
        (8.2, 0.0, 4),
        (8.2, 0.2, 4),
        (0.8, 0.0, 19),
        # Most of what is within a block is noise: it does not go on from sample to sample.
        (0.8, 2.0, 19),
    ],
)
def test_blocks_keep_the_motion_of_a_stretch_whatever_its_frequency(hertz: float, noise: float, size: int) -> None:
    """At 200 Hz, 19 samples are a cycle of 10.5 Hz: their means lose two thirds of the energy of 8.2 Hz."""
    time = np.arange(5000) / 200
    values = np.cos(2 * np.pi * hertz * time) + noise * np.random.default_rng(1).standard_normal(time.size)
    assert with_all_motion(values[None], 19) == size
    assert with_all_motion(np.stack([0 * time, values]), 19) == size
