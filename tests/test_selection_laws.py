"""What selection says, against least squares written out, the Cramér-Rao bound of one mode, and the definitions."""

from collections.abc import Callable

import control
import numpy as np
import pytest
from bounds import modal_bound
from numpy.typing import NDArray
from scipy.signal import lfilter

from suspid import Identification, identify
from suspid.identification import identify_linear
from suspid.identification.ascent import maximize
from suspid.identification.candidates import ranked, searched
from suspid.identification.exponentials import blocks_of
from suspid.identification.fitting import Problem
from suspid.identification.likelihood import bic_penalty, evaluate
from suspid.identification.noise import WhiteNoise, noise_colour
from suspid.identification.poles import Poles
from suspid.identification.refinement import about_the_axis
from suspid.identification.selection import MOST_PAIRS, Selection, select
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.words import Level, ModeCheck, Reason

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

COUNT = 3000
K = np.arange(COUNT)
MODES: Complex = np.array([-0.004 + 0.08j, -0.008 + 0.3j])


def decays(poles: Complex, amplitudes: Complex, count: int = COUNT) -> Real:
    """Samples (channel, sample) from amplitudes (channel, pole)."""
    return np.asarray((amplitudes @ np.exp(poles[:, None] * np.arange(count))).real, float)


def white(seed: int, std: float, channels: int = 1, count: int = COUNT) -> Real:
    return std * np.random.default_rng(seed).standard_normal((channels, count))


def selected(values: Real) -> Selection:
    centred = values - values.mean(axis=1, keepdims=True)
    return select(centred, noise=WhiteNoise(least=1e-22 * np.max(np.abs(centred), axis=1) ** 2))


def columns(exponents: Complex | Real, count: int = COUNT) -> Real:
    """Real and imaginary parts of exponentials, (sample, column)."""
    powers = np.exp(np.asarray(exponents, complex)[:, None] * np.arange(count))
    parts = np.vstack([powers.real, powers.imag[np.abs(exponents.imag) > 0]])
    return np.asarray(parts.T, float)


def left_over(values: Real, exponents: Complex | Real) -> Real:
    """Sums of squares (channel,) that least squares leaves; exponents of pairs stand once."""
    q, _ = np.linalg.qr(columns(exponents, values.shape[1]))
    return np.asarray(np.sum((values - (values @ q) @ q.T) ** 2, axis=1))


def with_offset(poles: Poles) -> Complex:
    return np.concatenate([poles.pairs, poles.reals, poles.nuisances])


class TestVerdictsOfOneMotion:
    """One motion of amplitude 1 whose decay over the record is a given number of standard deviations.

    A slow decay exp(-D k / n) cos(...) in white noise s is known to sd(D) = s sqrt(24 / n) for D << 1 (Cramér-Rao of
    one exponential); at D = 0.35 the bound is a sixth higher.
    """

    @pytest.mark.parametrize(
        ("decay", "sds", "reason"),
        [
            (0.15, 6.5, Reason.TONE),
            (0.35, 6.5, None),
            (0.15, 25.0, None),
            (0.8, 2.2, Reason.TONE),
            (-0.15, 10.0, Reason.GROWING),
        ],
    )
    def test_is_a_tone_where_its_decay_is_little_and_not_sure(
        self, decay: float, sds: float, reason: Reason | None
    ) -> None:
        slope = columns(np.array([-decay / COUNT + 0.2j]))
        # The bound itself: what the derivative by D has beside cosine and sine.
        by_decay = slope[:, 0] * K / COUNT
        q, _ = np.linalg.qr(slope)
        std = abs(decay) * float(np.linalg.norm(by_decay - q @ (q.T @ by_decay))) / sds
        for seed in range(3):
            found = selected(slope[:, :1].T + white(seed, std))
            # The estimate of the decay scatters by one of its standard deviations: so do the numbers that decide.
            assert found.reasons == (reason,), (seed, found.reasons, found.fit.poles)


class TestVerdictsBesideModes:
    AMPLITUDES: Complex = np.array([[1.0 - 0.4j, -0.5 + 0.3j], [0.6j, 0.9 + 0.1j]])

    @pytest.mark.parametrize(
        ("pole", "reason"),
        [
            (-4.5 / COUNT, None),
            ((-3.0 + 4.7j) / COUNT, Reason.UNDER_A_CYCLE),
            ((-3.0 + 8.0j) / COUNT, None),
            (-0.01 + 0.99j * np.pi, Reason.NEAR_NYQUIST),
            (-0.01 + 0.96j * np.pi, None),
            (-0.4 + 0.9j, None),
            (-0.6 + 0.9j, Reason.A_FEW_SAMPLES),
        ],
    )
    def test_one_more_motion(self, pole: complex, reason: Reason | None) -> None:
        poles = np.append(MODES, pole)
        amplitudes = np.column_stack([self.AMPLITUDES, [1.0, -0.6]])
        found = selected(decays(poles, amplitudes) + white(1, 1e-3, 2))
        every = np.concatenate([found.fit.poles.pairs, found.fit.poles.reals])
        assert len(every) == 3
        assert found.reasons[int(np.argmin(np.abs(every - pole)))] == reason
        assert found.reasons.count(None) == 2 + (reason is None)

    @pytest.mark.parametrize(
        "drift",
        [lambda x: x, lambda x: x**2, lambda x: 1 - 3 * (x - 0.4) ** 2],
        ids=["straight", "bent", "there and back"],
    )
    @pytest.mark.parametrize("std", [1e-3, 2e-2])
    def test_a_drift_is_no_mode_and_leaves_the_noise(self, drift: Callable[[Real], Real], std: float) -> None:
        values = decays(MODES, self.AMPLITUDES) + white(2, std, 2) + drift(K / COUNT)
        found = selected(values)
        assert found.reasons.count(None) == 2
        if std > 0.01:
            assert found.reasons == (None, None)
            # Slope, bend and offset are nuisances.
            assert len(found.fit.poles.nuisances) == 3
        # Some 20 parameters of 6000 samples do not show.
        np.testing.assert_allclose(np.std(found.residual, axis=1), std, rtol=0.04)

    @pytest.mark.parametrize("seed", [11, 12, 19])
    def test_a_pair_that_hardly_swings_is_a_pair_where_the_record_tells(self, seed: int) -> None:
        # The real pole nearest to it leaves a chi-square some 40 greater, for three parameters less.
        pole = -0.02 + 0.008j
        amplitudes = np.column_stack([self.AMPLITUDES, [1.0, -0.6]])
        values = decays(np.append(MODES, pole), amplitudes) + white(seed, 0.03, 2)
        centred = values - values.mean(axis=1, keepdims=True)
        rates = -np.geomspace(0.01, 0.05, 60)
        known = np.append(MODES, 0.0)
        losses = [COUNT * np.sum(np.log(left_over(centred, np.append(known, rate)))) for rate in rates]
        gain = min(losses) - COUNT * np.sum(np.log(left_over(centred, np.append(known, pole))))
        assert 15 < gain < 60
        found = selected(values)
        assert found.reasons == (None,) * 3
        assert np.min(np.abs(found.fit.poles.pairs - pole)) < 0.003

    def test_without_drift_there_is_one_constant(self) -> None:
        found = selected(decays(MODES, self.AMPLITUDES) + white(3, 1e-3, 2) + 5.0)
        assert len(found.fit.poles.nuisances) == 1


class TestGains:
    def test_of_strong_poles_are_what_leaving_out_costs_at_fixed_others(self) -> None:
        # Heavy damping: the exponential is far from orthogonal to its conjugate.
        poles: Complex = np.array([-0.02 + 0.02j, -0.03 + 0.15j])
        values = decays(poles, np.array([[1.0 + 0.8j, 0.7], [-0.6, 0.5 - 0.9j]])) + white(4, 0.02, 2)
        centred = values - values.mean(axis=1, keepdims=True)
        found = selected(values)
        pairs = found.fit.poles.pairs
        assert len(pairs) == 2
        assert not len(found.fit.poles.reals)
        full = left_over(centred, with_offset(found.fit.poles))
        for which in range(2):
            less = left_over(centred, with_offset(found.fit.poles.without(which)))
            assert found.gains[which] > 3 * bic_penalty(2, 2 * COUNT)
            assert found.gains[which] == pytest.approx(COUNT * np.sum(np.log(less / full)), rel=1e-5)

    def test_of_weak_poles_let_the_others_follow(self) -> None:
        # The strong neighbour takes over a part of the weak mode, once its pole may move.
        poles: Complex = np.array([-0.004 + 0.1j, -0.004 + 0.105j])
        values = decays(poles, np.array([[0.3, 0.045], [0.24, -0.0585]])) + white(5, 0.05, 2)
        centred = values - values.mean(axis=1, keepdims=True)
        found = selected(values)
        assert len(found.fit.poles.pairs) == 2
        weak = int(np.argmin(found.gains))
        assert found.gains[weak] < 3 * bic_penalty(2, 2 * COUNT)
        short = found.fit.poles.without(weak)
        full = COUNT * np.sum(np.log(left_over(centred, with_offset(found.fit.poles))))
        # By Nelder and Mead on the sum of squares itself, from where the search left the pole.
        from scipy.optimize import minimize

        def loss(x: Real) -> float:
            moved = Poles(
                pairs=short.pairs + np.array([x[0] + 1j * x[1]]) * 1e-3, reals=short.reals, nuisances=short.nuisances
            )
            return float(COUNT * np.sum(np.log(left_over(centred, with_offset(moved)))) - full)

        best = minimize(
            loss,
            np.zeros(2),
            method="Nelder-Mead",
            options={"initial_simplex": np.array([[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]]), "fatol": 1e-3},
        )
        assert loss(np.zeros(2)) > 1.05 * best.fun
        assert found.gains[weak] == pytest.approx(best.fun, rel=5e-3)

    def test_of_candidates_are_those_of_least_squares(self) -> None:
        # Slow and heavy: here the conjugate and what is fitted already decide what a candidate gains.
        poles: Complex = np.array([-0.01 + 0.006j, -0.02 + 0.03j])
        values = decays(poles, np.array([[1.0 + 0.8j, 0.7], [-0.6, 0.5 - 0.9j]])) + white(6, 0.01, 2)
        blocks = blocks_of(values)
        fit = evaluate(
            blocks,
            Poles(pairs=poles[1:], reals=np.zeros(0), nuisances=np.zeros(1)),
            WhiteNoise(least=np.full(2, 1e-12)),
        )
        assert fit is not None
        known = with_offset(fit.poles)
        q, _ = np.linalg.qr(columns(known))
        residual = values - (values @ q) @ q.T
        variance = np.mean(residual**2, axis=1)
        found = ranked(fit, variance, searched(fit, residual, variance))
        assert len(found) >= 3
        assert {one.real for one in found[:4]} == {True, False}
        for one in found:
            with_it = left_over(values, np.append(known, one.theta))
            assert one.gain == pytest.approx(-COUNT * np.sum(np.log(with_it / COUNT / variance)), rel=1e-3, abs=0.01)


class TestCandidates:
    @pytest.mark.parametrize("channels", [1, 2, 3, 4, 7])
    def test_inner_products_are_sums_over_the_residual(self, channels: int) -> None:
        """Whatever the number of rows that are transformed at once; in single precision, up to 9 e-foldings."""
        values = white(12, 1.0, channels)
        none = Poles(pairs=np.zeros(0, complex), reals=np.zeros(0), nuisances=np.zeros(1))
        fit = evaluate(blocks_of(values), none, WhiteNoise(least=np.full(channels, 1e-12)))
        assert fit is not None
        points = searched(fit, values, np.mean(values**2, axis=1))
        dense = np.exp(np.outer(points.theta, np.arange(values.shape[1]))).conj()
        reach = np.sqrt(np.sum(np.abs(dense) ** 2, axis=1))
        assert np.max(np.abs(points.inner - values @ dense.T) / reach) < 1e-3  # exp(-9) of some samples

    def test_no_two_lie_within_a_linewidth(self) -> None:
        values = decays(np.array([-0.05 + 0.4j, -0.002 + 1.2j]), np.array([[1.0, 0.2]])) + white(11, 0.01)
        none = Poles(pairs=np.zeros(0, complex), reals=np.zeros(0), nuisances=np.zeros(1))
        fit = evaluate(blocks_of(values), none, WhiteNoise(least=np.full(1, 1e-12)))
        assert fit is not None
        variance = np.mean(values**2, axis=1)
        found = ranked(fit, variance, searched(fit, values, variance))
        theta = np.array([one.theta for one in found if not one.real])
        assert len(theta) > 3
        one, other = np.triu_indices(len(theta), 1)
        # Full width at half power of the broader of the two: twice its decay rate.
        width = 2 * np.maximum(-theta.real[one], -theta.real[other])
        assert np.all(np.abs(theta.imag[one] - theta.imag[other]) > width)

    def test_a_record_of_more_modes_than_the_most_is_fitted_with_the_strongest(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("suspid.identification.selection.MOST_PAIRS", 16)
        # Modes far apart, each 20 % weaker than the one before it.
        poles: Complex = np.asarray(-0.003 + 1j * np.linspace(0.1, 2.9, 20), complex)
        sizes = 0.8 ** np.random.default_rng(12).permutation(20)
        found = selected(decays(poles, sizes[None].astype(complex)) + white(12, 1e-4))
        strongest = np.sort(poles.imag[np.argsort(-sizes)[:16]])
        np.testing.assert_allclose(np.sort(found.fit.poles.pairs.imag), strongest, atol=1e-3)


class TestColour:
    @pytest.mark.parametrize("memory", [0.5, 0.9, -0.7])
    def test_density_of_a_noise_with_memory(self, memory: float) -> None:
        # x_k = a x_(k-1) + e_k: density over variance (1 - a^2) / |1 - a exp(-j omega)|^2.
        count = 200_000
        noise = lfilter([1.0], [1.0, -memory], white(7, 1.0, 2, count), axis=1)
        omega = np.array([0.02, 0.3, 1.0, 2.0, 3.0])
        expected = (1 - memory**2) / np.abs(1 - memory * np.exp(-1j * omega)) ** 2
        np.testing.assert_allclose(noise_colour(noise, omega), np.tile(expected, (2, 1)), rtol=0.08)

    @pytest.mark.parametrize("memory", [0.6, 0.9])
    def test_loudness_is_the_density_of_the_noise_at_the_mode(self, memory: float) -> None:
        noise = lfilter([1.0], [1.0, -memory], white(8, 0.02, 2, 2 * COUNT), axis=1)[:, COUNT:]
        amplitudes: Complex = np.array([[1.0, 0.6], [0.7, -1.0]])
        found = selected(decays(MODES, amplitudes) + noise)
        expected = (1 - memory**2) / np.abs(1 - memory * np.exp(-1j * MODES.imag)) ** 2
        kept = [int(np.argmin(np.abs(found.fit.poles.pairs - pole))) for pole in MODES]
        np.testing.assert_allclose(found.loudness[kept], expected, rtol=0.5)

    def test_a_bent_decay_widens_at_least_by_the_louder_of_halves_and_residual(self) -> None:
        # A frequency that rises by 1 % within the decay: no exponential is right, and both halves know theirs well.
        k = np.arange(2000)
        values = (np.exp(-0.003 * k) * np.cos(0.2 * k + 1.2e-6 * k**2))[None] + white(9, 2e-3, 1, 2000)
        t = k / 100.0
        found = identify_linear(as_response(t, values, ["y"]))
        assert len(found.modes) == 1
        assert found.loudness[0] > 2.5
        assert found.halves[0] > 2
        std = found.modes.wn_std
        assert std is not None
        fitted = as_signal(found.fitted).values
        bound, _ = modal_bound(found.modes.wn, found.modes.zeta, fitted - values.mean(), t, found.noise_std)
        # It might be two modes as well: then the interval reaches the nearer one.
        assert [c.remark.code for c in found.considered].count(Reason.UNRESOLVED) == 1
        assert (std[0] / bound[0]) ** 2 > 0.95 * max(found.loudness[0], found.halves[0] ** 2)

    @pytest.mark.parametrize(
        ("third", "seed", "reason"),
        [(0.27, 0, Reason.UNRESOLVED), (0.27, 3, Reason.UNRESOLVED), (0.285, 4, Reason.TOO_WEAK)],
    )
    def test_where_one_more_mode_is_open_no_interval_is_narrower_than_with_it(
        self, third: float, seed: int, reason: Reason
    ) -> None:
        # A third mode 1.5 or 2.25 linewidths beside the second, too weak to be one: it moves both others.
        k, std = np.arange(400), np.full(4, 0.02)
        poles: Complex = np.array([-0.02 + 0.2j, -0.02 + 0.24j, -0.02 + 1j * third])
        shapes: Complex = np.array([[1, 1, 0.03], [1, -1, -0.03], [0.5, 0.8, 0.03], [0.7, -0.3, 0.03]], complex)
        clean, t = decays(poles, shapes, 400), k / 100.0
        found = identify(as_response(t, clean + white(seed, 0.02, 4, 400), ["a", "b", "c", "d"]))
        assert len(found.modes) == 2
        assert reason in [c.remark.code for c in found.considered]
        wn, zeta = 100 * np.abs(poles), -poles.real / np.abs(poles)
        of_three = modal_bound(wn, zeta, clean, t, std)
        for own, bound in zip((found.modes.wn_std, found.modes.zeta_std), of_three, strict=True):
            assert own is not None
            assert np.all(own > 0.9 * bound[:2])


class TestLikelihood:
    def test_a_fit_ends_at_the_greatest_likelihood(self) -> None:
        # Started off by some standard deviations it comes to within a hundredth of one of where it ends from the truth.
        amplitudes: Complex = np.array([[1.0, 0.6], [0.7, -1.0]])
        values = decays(MODES, amplitudes) + white(10, 0.05, 2)
        blocks, noise = blocks_of(values), WhiteNoise(least=np.full(2, 1e-12))
        ends = []
        for off in (1.0, 1.02):
            fit = maximize(blocks, Poles(pairs=MODES * off, reals=np.zeros(0), nuisances=np.zeros(1)), noise)
            assert fit is not None
            ends.append(fit)
        apart = (ends[1].poles.pairs - ends[0].poles.pairs).view(float)
        assert float(apart @ ends[0].information @ apart) < 1e-4


class TestHarmonics:
    """A weak pole at a multiple of a mode is named; one beside it is a mode."""

    @staticmethod
    def found(ratio: float, rate: float, share: float) -> Identification:
        time = np.arange(0, 6, 0.005)
        first = np.exp(-0.4 * time) * np.cos(20 * time)
        second = share * np.exp(-rate * time) * np.cos(ratio * 20 * time + 0.7)
        noise = np.random.default_rng(5).normal(scale=1e-3, size=time.size)
        return identify(control.TimeResponseData(time, first + second + noise, issiso=True))

    @pytest.mark.parametrize(("ratio", "rate"), [(2.0, 0.4), (2.0, 0.8), (3.0, 0.9)])
    def test_a_multiple_that_decays_as_a_harmonic_is_one(self, ratio: float, rate: float) -> None:
        found = self.found(ratio, rate, 0.05)
        assert len(found.modes) == 1
        assert found.modes.wn[0] == pytest.approx(np.hypot(20, 0.4), rel=1e-3)
        (named,) = [c.remark for c in found.considered if c.remark.code is Reason.HARMONIC]
        assert named.numbers == {"mode": 1, "multiple": round(ratio)}

    @pytest.mark.parametrize(("rate", "moves"), [(0.6, True), (0.75, True), (2.5, False)])
    def test_a_middle_that_moves_with_its_swings_is_named(self, rate: float, moves: bool) -> None:
        found = self.found(0.0, rate, 0.08)
        named = [c.remark.numbers for c in found.considered if c.remark.code is Reason.HARMONIC]
        assert named == ([{"mode": 1, "multiple": 0}] if moves else [])
        assert (found.verdict.level is Level.CARE) or not moves

    @pytest.mark.parametrize(("ratio", "rate", "share"), [(2.03, 0.4, 0.05), (2.0, 2.5, 0.05), (2.0, 0.6, 0.6)])
    def test_a_mode_near_a_multiple_is_a_mode(self, ratio: float, rate: float, share: float) -> None:
        """Beside the multiple, decaying faster than a harmonic, or too strong for one."""
        assert len(self.found(ratio, rate, share).modes) == 2


def many_modes(
    count: int, channels: int, *, noise: float, damped: tuple[float, float], seed: int = 2
) -> tuple[control.TimeResponseData, Real]:
    """Return a record of many modes, each in its share of the band, and their wn."""
    rng = np.random.default_rng(seed)
    time, places = np.arange(4000) / 500, (np.arange(count) + rng.uniform(0.3, 0.7, count)) / count
    wn, zeta = 2 * np.pi * (5.0 + 207.5 * places), rng.uniform(*damped, count)
    poles = wn * (-zeta + 1j * np.sqrt(1 - zeta**2))
    residues = rng.standard_normal((channels, count)).astype(complex)
    # Of real shapes, or of any.
    residues += 1j * rng.standard_normal((channels, count)) if rng.random() < 0.5 else 0.0
    values = (residues @ np.exp(poles[:, None] * time)).real
    noisy = values + noise * np.std(values, axis=1, keepdims=True) * rng.standard_normal(values.shape)
    return as_response(time, noisy, [f"c{k}" for k in range(channels)]), wn


class TestManyModes:
    @pytest.mark.parametrize(("count", "channels"), [(17, 3), (24, 12)])
    def test_all_are_found_that_are_ever_farther_apart(self, count: int, channels: int) -> None:
        rng = np.random.default_rng(count)
        time, wn, zeta = np.arange(6000) / 500, 2 * np.pi * np.geomspace(3.0, 200.0, count), 0.005
        poles = wn * (-zeta + 1j * np.sqrt(1 - zeta**2))
        residues = rng.standard_normal((channels, count)) + 1j * rng.standard_normal((channels, count))
        values = (residues @ np.exp(poles[:, None] * time)).real
        noisy = values + 1e-3 * np.std(values) * rng.standard_normal(values.shape)
        found = identify(as_response(time, noisy, [f"c{k}" for k in range(channels)])).modes
        assert len(found) == count
        ends = found.interval(1 - 1e-6).wn
        assert np.all((ends[:, 0] < wn) & (wn < ends[:, 1]))

    @pytest.mark.parametrize(
        ("count", "channels", "noise", "damped"),
        [(17, 3, 1e-3, (5e-3, 5e-3)), (24, 12, 0.1, (2e-3, 1e-2)), (33, 12, 0.3, (2e-3, 1e-2))],
    )
    def test_all_are_found(self, count: int, channels: int, noise: float, damped: tuple[float, float]) -> None:
        """In the noise of a sensor too, which soon is most of what has not been fitted yet."""
        record, wn = many_modes(count, channels, noise=noise, damped=damped)
        found = identify(record).modes
        assert len(found) == count
        ends = found.interval(1 - 1e-6).wn
        assert np.all((ends[:, 0] < wn) & (wn < ends[:, 1]))

    def test_broad_poles_that_stand_for_several_do_not_end_the_search(self) -> None:
        """What is next to one of them looks like a part of it, and is the best candidate."""
        record, wn = many_modes(40, 12, noise=10**-0.5, damped=(2e-3, 1e-2), seed=50)
        assert len(identify(record).modes) >= len(wn) - 1

    def test_more_than_are_looked_for_is_said(self) -> None:
        record, wn = many_modes(MOST_PAIRS + 4, 6, noise=0.01, damped=(2e-3, 4e-3))
        found = identify(record)
        assert len(found.modes) < len(wn)
        assert found.verdict.level is Level.DOUBTFUL
        (said,) = [check.remark for check in found.verdict.checks if check.remark.code is ModeCheck.TOO_MANY]
        assert said.numbers["most"] == MOST_PAIRS

    @pytest.mark.parametrize("seed", range(3))
    def test_driven_motion_is_not_followed_without_end(self, seed: int) -> None:
        """Lines of a plate that turbulence drives: pairs follow its swelling and sinking."""
        rng = np.random.default_rng(seed)
        values = np.zeros((3, 4000))
        for turn in np.linspace(0.2, 2.6, 24):
            pole = np.exp(-0.004 + 1j * turn)
            state = lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], rng.standard_normal(6000))[2000:]
            values += rng.standard_normal((3, 1)) * state
        record = values - values.mean(axis=1, keepdims=True)
        assert len(select(record, noise=WhiteNoise(least=np.full(3, 1e-22))).fit.poles.pairs) < 3


class TestNearTheRealAxis:
    """The poles of an overdamped car: a pair between two real poles, of which a search first meets one pair."""

    POLES: Complex = np.array([-0.03034 + 0.03254j, -0.00979, -0.2696], complex)

    def values(self, seed: int, std: float) -> Real:
        amplitudes = np.array([[0.4 - 0.3j, -0.5, 0.12], [-0.8 + 0.5j, 0.1, 0.7]], complex)
        return decays(self.POLES, amplitudes) + white(seed, std, 2)

    @pytest.mark.parametrize("std", [1e-3, 1e-5])
    def test_both_real_poles_are_found(self, std: float) -> None:
        for seed in range(4):
            values = self.values(seed, std)
            found = selected(values)
            assert found.reasons == (None, None, None)
            # No poles fit better than the best near the true ones, and those fit better than the true ones.
            assert np.all(np.sum(found.residual**2, axis=1) < 1.001 * left_over(values, np.append(self.POLES, 0.0)))

    def test_a_pair_at_the_axis_parts(self) -> None:
        values = self.values(0, 1e-4)
        centred = values - values.mean(axis=1, keepdims=True)
        problem = Problem(values=centred, blocks=blocks_of(centred), noise=WhiteNoise(least=np.full(2, 1e-22)))
        meeting = problem.fitted(
            Poles(pairs=np.array([self.POLES[0], -0.06 + 0.001j]), reals=np.zeros(0), nuisances=np.zeros(1))
        )
        assert meeting is not None
        assert len(meeting.poles.pairs) == 2
        assert about_the_axis(problem, meeting, 1e9) is meeting
        apart = about_the_axis(problem, meeting, 3.0)
        assert len(apart.poles.reals) == 2
        np.testing.assert_allclose(np.sort(apart.poles.reals), np.sort(self.POLES[1:].real), rtol=0.02)
        assert apart.loss < meeting.loss - 1000
