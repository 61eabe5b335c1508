from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from suspid.identification.candidates import _layout as layout
from suspid.identification.likelihood import bic_penalty
from suspid.identification.noise import WhiteNoise
from suspid.identification.selection import Selection, select
from suspid.words import Reason

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

COUNT = 3000
K = np.arange(COUNT)
# Two modes per sample and their amplitudes in two channels.
POLES: Complex = np.array([-0.004 + 0.08j, -0.008 + 0.3j])
AMPLITUDES: Complex = np.array([[1.0 - 0.4j, 0.6j], [-0.5 + 0.3j, 0.9 + 0.1j]])
STD = 0.02


def decays(poles: Complex = POLES, amplitudes: Complex = AMPLITUDES, count: int = COUNT) -> Real:
    return np.asarray((amplitudes.T @ np.exp(poles[:, None] * np.arange(count))).real, float)


def noise(seed: int, channels: int = 2, count: int = COUNT) -> Real:
    return STD * np.random.default_rng(seed).standard_normal((channels, count))


def selected(values: Real, *, modes: int | None = None, band: tuple[float, float] = (0.0, np.pi)) -> Selection:
    centred = values - values.mean(axis=1, keepdims=True)
    return select(centred, noise=WhiteNoise(least=1e-22 * np.max(np.abs(centred), axis=1) ** 2), modes=modes, band=band)


def modes_of(found: Selection) -> Complex:
    every = np.concatenate([found.fit.poles.pairs, found.fit.poles.reals])
    return np.sort_complex(every[[reason is None for reason in found.reasons]])


def assert_two_modes(found: Selection, *, atol: float = 1e-3) -> None:
    kept = modes_of(found)
    assert len(kept) == 2, (kept, found.reasons)
    np.testing.assert_allclose(kept, np.sort_complex(POLES), rtol=0, atol=atol)


class TestGridOfDecayRates:
    """The energy of exp(-a k) is the sum of exp(-2 a k); exp(-b k) shows the share <a, b>^2 / (<a, a> <b, b>) of it."""

    def test_squared_norms(self) -> None:
        for rate, used, length, norm in layout(COUNT):
            assert norm == pytest.approx(float(np.sum(np.exp(-2 * rate * np.arange(used)))), rel=1e-12)
            # What is left out after the samples in use is rounding, or there is nothing after them.
            assert used == COUNT or np.exp(-rate * used) < 2e-4
            assert length >= used

    def test_a_pole_of_any_rate_shows_eight_ninths_of_its_energy_at_one_of_them(self) -> None:
        rates = np.array([row[0] for row in layout(COUNT)])
        # Two rates a factor of 2 apart share 8/9 of their energies; a pole that does not decay shows 92 %.
        for own in (0.0, *np.geomspace(1 / COUNT, 0.5, 40)):
            pole, lines = np.exp(-own * K), np.exp(-rates[:, None] * K)
            shares = (lines @ pole) ** 2 / (pole @ pole) / np.sum(lines**2, axis=1)
            assert np.max(shares) > (0.92 if own == 0 else 0.885), own


class TestPrice:
    def test_is_bic_of_each_parameter(self) -> None:
        # A pair has a decay rate and a frequency, and two amplitudes in each channel; a real pole half of that.
        for channels in (1, 2, 5):
            for samples in (100, 10_000):
                assert bic_penalty(channels, samples) == pytest.approx((2 + 2 * channels) * np.log(samples))
                assert bic_penalty(channels, samples, real=True) == pytest.approx((1 + channels) * np.log(samples))

    def test_noise_rarely_pays_it(self) -> None:
        # 60 records: BIC of four parameters or more against a maximum over some thousand frequencies.
        found = [len(selected(noise(100 + seed, 1 + seed % 3)).reasons) for seed in range(60)]
        assert sum(found) <= 1


class TestVerdicts:
    """Each foreign motion is named; the two modes beside it stay what they are."""

    @pytest.mark.parametrize(
        ("reason", "motion"),
        [
            (Reason.TONE, lambda: 0.3 * np.cos(0.2 * K + 0.4)),
            (Reason.TONE, lambda: 0.1 * np.cos(0.0823 * K)),
            (Reason.TONE, lambda: 0.2 * np.cos(2 * np.pi * 50 / 500 * K + 1.0)),
            (Reason.DRIFT, lambda: 0.5 * np.exp(-2.0 * K / COUNT)),
            (Reason.GROWING, lambda: 0.02 * np.exp(2.5 * K / COUNT) * np.cos(0.17 * K)),
        ],
    )
    def test_is_no_mode(self, reason: Reason, motion: Callable[[], Real]) -> None:
        for seed in range(4):
            found = selected(decays() + noise(seed) + motion())
            assert_two_modes(found)
            assert reason in found.reasons

    @pytest.mark.parametrize(
        "motion",
        [
            lambda: np.full(COUNT, 7.0),
            lambda: K / COUNT,
            lambda: (K / COUNT - 0.3) ** 2,
            lambda: 0.3 * np.sin(2 * np.pi * 0.4 * K / COUNT),
        ],
        ids=["offset", "straight drift", "bent drift", "half a swing"],
    )
    @pytest.mark.parametrize("std", [0.01, 1.0])
    def test_what_creeps_is_no_mode(self, motion: Callable[[], Real], std: float) -> None:
        for seed in range(4):
            assert_two_modes(selected(decays() + std * noise(seed) + motion()))

    def test_what_is_gone_at_once_is_no_mode(self) -> None:
        for seed in range(4):
            found = selected(decays() + noise(seed) + 0.8 * np.exp(-0.6 * K) * np.cos(1.1 * K))
            assert_two_modes(found)

    def test_a_band(self) -> None:
        found = selected(decays() + noise(1), band=(0.2, 0.5))
        np.testing.assert_allclose(modes_of(found), POLES[1:], rtol=0, atol=1e-3)
        assert found.reasons.count(Reason.OUTSIDE_THE_BAND) == 1

    @pytest.mark.parametrize("channels", [1, 2])
    def test_an_overdamped_pole_is_real(self, channels: int) -> None:
        for seed in range(4):
            values = 0.1 * noise(seed, channels) + decays()[:channels] + 0.8 * np.exp(-0.02 * K)
            found = modes_of(selected(values))
            assert np.count_nonzero(found.imag == 0) == 1
            np.testing.assert_allclose(found, np.sort_complex(np.append(POLES, -0.02)), rtol=0, atol=1e-3)

    @pytest.mark.parametrize("seed", range(6))
    def test_two_overdamped_poles_are_no_slow_pair(self, seed: int) -> None:
        # Real poles that a pair with hardly any swing could also stand for.
        values = noise(seed) + decays() + np.array([[1.0], [0.4]]) * np.exp(-0.01 * K)
        values += np.array([[-0.8], [0.9]]) * np.exp(-0.15 * K)
        found = modes_of(selected(values))
        truth = np.concatenate([POLES, [-0.01, -0.15]])
        # Whatever is returned is there; a pair in their place would lie 0.05 away.
        for pole in found:
            assert np.min(np.abs(truth - pole) / np.abs(truth)) < 0.1, found


class TestAskedFor:
    def test_the_strongest_so_many(self) -> None:
        weak = decays(amplitudes=AMPLITUDES * np.array([[1.0], [0.2]])) + noise(3)
        one = selected(weak, modes=1)
        np.testing.assert_allclose(modes_of(one), POLES[:1], rtol=0, atol=1e-3)
        assert one.reasons.count(Reason.BEYOND) == 1
        assert_two_modes(selected(weak, modes=2), atol=2e-3)

    def test_more_than_there_are_changes_nothing(self) -> None:
        assert_two_modes(selected(decays() + noise(4), modes=5))


class TestSplits:
    """One motion that is not quite a damped exponential is one mode."""

    @pytest.mark.parametrize("std", [1e-3, 0.1, 1.0])
    @pytest.mark.parametrize("friction", [0.5, 1.0, 2.0])
    def test_a_mass_on_a_spring_with_friction(self, friction: float, std: float) -> None:
        # m = 1, k = 400, c = 0.4, coming to rest within or after the record.
        from scipy.integrate import solve_ivp

        t = np.arange(2000) / 250

        def motion(_: float, s: Real) -> list[float]:
            return [s[1], -0.4 * s[1] - 400 * s[0] - 4 * friction * np.tanh(s[1] / 0.02)]

        x = solve_ivp(motion, (0, t[-1]), [1.0, 0.0], t_eval=t, rtol=1e-7, atol=1e-9, max_step=4e-3).y
        # Energy balance: in a cycle friction F takes 4 F A, a damper 2 pi zeta k A^2. Over amplitudes A from 1 down to
        # 0.1 the two together are zeta = 0.01 to 0.01 + (2 / pi) F / (k A) = 0.01 + 0.064 friction.
        found = modes_of(selected(x + std * noise(5, 1, 2000))) * 250
        assert len(found) == 1
        assert abs(abs(found[0]) - 20.0) < 0.1
        assert 0.0099 < -found[0].real / abs(found[0]) < 0.01 + 0.064 * friction

    def test_two_close_modes_that_move_apart_are_two(self) -> None:
        # 5 % apart, five linewidths; another at one linewidth and a half, of another shape.
        for apart, seed in ((0.05, 0), (0.05, 1), (0.015, 0), (0.015, 1)):
            poles: Complex = np.array([-0.002 + 0.2j, -0.002 + 0.2j * (1 + apart)])
            found = selected(decays(poles, np.array([[1.0, 0.8], [0.7, -1.0]])) + 0.2 * noise(seed))
            np.testing.assert_allclose(sorted(modes_of(found), key=np.imag), poles, rtol=0, atol=2e-4)


class TestColouredNoise:
    @pytest.mark.parametrize("memory", [0.5, -0.7])
    def test_has_no_modes(self, memory: float) -> None:
        invented = 0
        for seed in range(4):
            values = lfilter([1.0], [1.0, -memory], noise(seed, 1 + seed % 3, COUNT + 500), axis=1)[:, 500:]
            invented += len(modes_of(selected(values)))
        assert invented <= 1


class TestReasons:
    def test_what_was_not_kept_says_why(self) -> None:
        values = decays() + noise(6) + 0.0012 * np.cos(0.5 * K)
        found = selected(values)
        assert_two_modes(found)
        assert all(str(remark) for _, remark in found.rejected)

    def test_gains_are_what_leaving_out_costs(self) -> None:
        values = decays() + noise(7)
        found = selected(values)
        centred = values - values.mean(axis=1, keepdims=True)
        # The weakest bound there is: all energy that a mode has, over the noise, in twice the log likelihood.
        total = COUNT * float(np.sum(np.log(np.var(centred, axis=1) / STD**2)))
        assert np.all(found.gains > bic_penalty(2, 2 * COUNT))
        assert np.all(found.gains < 1.01 * total)
        np.testing.assert_array_equal(found.loudness, 1.0)
