from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid.identification.ascent import maximize
from suspid.identification.covariance import joint_covariance
from suspid.identification.exponentials import blocks_of, synthesize
from suspid.identification.likelihood import DecayFit, evaluate, evaluate_samples, reweighed
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

# Exponents per sample: two pairs and a real pole beside an offset; lightly and heavily damped.
LIGHT: Complex = np.array([-0.01 + 0.25j, -0.02 + 0.6j])
HEAVY: Complex = np.array([-0.03 + 0.09j, -0.15 + 0.5j])
REAL = np.array([-0.04])
PAIR_AMPLITUDES: Complex = np.array([[1.0 - 0.5j, 0.4 + 0.3j, -0.2 + 0.8j], [-0.6 + 0.2j, 0.9j, 0.7 + 0.1j]])
REAL_AMPLITUDES = np.array([[0.5, -0.3, 0.2]])
STD = np.array([0.02, 0.05, 0.01])
COUNT = 400
NO_FLOOR = WhiteNoise(least=np.zeros(3))


def poles_of(pairs: Complex, reals: Real) -> Poles:
    return Poles(pairs=pairs, reals=reals, nuisances=np.zeros(1))


def clean(pairs: Complex, count: int = COUNT) -> Real:
    """The record from its definition: Re sum of amplitude times exponential, and an offset."""
    k = np.arange(count)
    motion = (PAIR_AMPLITUDES.T @ np.exp(pairs[:, None] * k)).real + REAL_AMPLITUDES.T @ np.exp(REAL[:, None] * k)
    return np.asarray(motion + np.array([[0.3], [-0.1], [0.0]]), float)


def record(pairs: Complex, seed: int, count: int = COUNT) -> Real:
    noise = np.random.default_rng(seed).standard_normal((3, count))
    return clean(pairs, count) + STD[:, None] * noise


def dense_basis(poles: Poles, count: int) -> Real:
    k = np.arange(count)[:, None]
    powers = np.exp(poles.pairs * k)
    return np.hstack([powers.real, powers.imag, np.exp(poles.reals * k), np.exp(poles.nuisances * k)])


def dense_squares(values: Real, poles: Poles) -> Real:
    basis = dense_basis(poles, values.shape[1])
    return np.array([np.sum((y - basis @ np.linalg.lstsq(basis, y, rcond=None)[0]) ** 2) for y in values])


def dense_loss(values: Real, poles: Poles) -> float:
    return float(values.shape[1] * np.sum(np.log(dense_squares(values, poles) / values.shape[1])))


def fitted(values: Real, poles: Poles) -> DecayFit:
    fit = evaluate(blocks_of(values), poles, WhiteNoise(least=np.zeros(len(values))))
    assert fit is not None
    return fit


def best(values: Real, poles: Poles) -> DecayFit:
    fit = maximize(blocks_of(values), poles, WhiteNoise(least=1e-15 * np.mean(values**2, axis=1)))
    assert fit is not None
    return fit


BOTH = pytest.mark.parametrize("pairs", [LIGHT, HEAVY], ids=["light", "heavy"])


@BOTH
class TestEvaluation:
    """At poles a little off the best, where nothing vanishes by chance."""

    def poles(self, pairs: Complex) -> Poles:
        return poles_of(pairs * np.array([1.01, 0.98 + 0.01j]), REAL * 1.1)

    def test_residual_is_that_of_dense_least_squares(self, pairs: Complex) -> None:
        values = record(pairs, 1)
        found = fitted(values, self.poles(pairs)).squares
        np.testing.assert_allclose(found, dense_squares(values, self.poles(pairs)), rtol=1e-8)

    def test_amplitudes_leave_that_residual(self, pairs: Complex) -> None:
        values = record(pairs, 1)
        fit = fitted(values, self.poles(pairs))
        left = values - synthesize(fit.poles.exponents, fit.amplitudes, COUNT)
        np.testing.assert_allclose(np.sum(left**2, axis=1), fit.squares, rtol=1e-8)

    def test_amplitudes_of_conjugates_are_conjugate(self, pairs: Complex) -> None:
        amplitudes = fitted(record(pairs, 1), self.poles(pairs)).amplitudes
        np.testing.assert_allclose(amplitudes[2:4], amplitudes[:2].conj(), rtol=0, atol=1e-11)
        np.testing.assert_allclose(amplitudes[4:].imag, 0.0, atol=1e-11)

    def test_gradient_is_the_slope_of_the_dense_log_likelihood(self, pairs: Complex) -> None:
        values, poles = record(pairs, 1), self.poles(pairs)
        fit, h = fitted(values, poles), 1e-7
        for i, step in enumerate(np.eye(poles.free) * h):
            # The loss is minus twice the log likelihood. Differences: rounding 1e-12 / h, curvature h.
            slope = (dense_loss(values, poles.moved(-step)) - dense_loss(values, poles.moved(step))) / (4 * h)
            assert fit.gradient[i] == pytest.approx(slope, rel=1e-5, abs=1e-5 * np.max(np.abs(fit.gradient)))

    def test_information_is_the_projected_dense_jacobian(self, pairs: Complex) -> None:
        values, poles = record(pairs, 1), self.poles(pairs)
        fit, k = fitted(values, poles), np.arange(COUNT)
        orthogonal, _ = np.linalg.qr(dense_basis(poles, COUNT))
        variance = dense_squares(values, poles) / COUNT
        expected = np.zeros((poles.free, poles.free))
        for channel in range(3):
            slopes = []
            for i, theta in enumerate(poles.pairs):
                motion = 2 * fit.amplitudes[i, channel] * k * np.exp(theta * k)
                slopes += [motion.real, -motion.imag]
            slopes += [
                fit.amplitudes[4 + i, channel].real * k * np.exp(theta * k) for i, theta in enumerate(poles.reals)
            ]
            jacobian = np.stack(slopes, axis=1)
            jacobian -= orthogonal @ (orthogonal.T @ jacobian)
            expected += jacobian.T @ jacobian / variance[channel]
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(fit.information / scale, expected / scale, rtol=0, atol=1e-8)

    def test_loss_is_the_dense_one(self, pairs: Complex) -> None:
        values, poles = record(pairs, 1), self.poles(pairs)
        found = NO_FLOOR.loss(fitted(values, poles).squares, COUNT)
        assert found == pytest.approx(dense_loss(values, poles), rel=1e-9)

    def test_the_floor_is_the_least_variance(self, pairs: Complex) -> None:
        # Information is per variance: a floor of 4 times the largest variance scales it down.
        values, poles = record(pairs, 1), self.poles(pairs)
        floor = np.full(3, 4 * np.max(dense_squares(values, poles)) / COUNT)
        one = evaluate(blocks_of(values), poles, WhiteNoise(least=floor))
        four = evaluate(blocks_of(values), poles, WhiteNoise(least=4 * floor))
        assert one is not None
        assert four is not None
        np.testing.assert_allclose(four.information, one.information / 4, rtol=1e-12)
        assert WhiteNoise(least=floor).loss(one.squares, COUNT) == pytest.approx(
            COUNT * np.sum(np.log(floor)), rel=1e-12
        )


class TestIndistinguishable:
    def test_the_same_pole_twice_is_no_fit(self) -> None:
        pairs = np.array([LIGHT[0], LIGHT[0]])
        assert evaluate(blocks_of(record(LIGHT, 1)), poles_of(pairs, REAL), NO_FLOOR) is None

    def test_a_real_pole_at_the_offset_is_no_fit(self) -> None:
        assert evaluate(blocks_of(record(LIGHT, 1)), poles_of(LIGHT, np.zeros(1)), NO_FLOOR) is None

    @pytest.mark.parametrize("apart", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
    def test_a_real_pole_near_the_offset_invents_no_precision(self, apart: float) -> None:
        # The residual cannot be smaller than the noise, however alike the exponentials are.
        values, poles = record(LIGHT, 1), poles_of(LIGHT, np.array([REAL[0], -apart / COUNT]))
        fit = evaluate(blocks_of(values), poles, NO_FLOOR)
        if fit is not None:
            ratio = fit.squares / dense_squares(values, poles)
            assert np.all(ratio > 0.99)
            if apart > 1e-5:
                assert np.all(ratio < 1.01)


@BOTH
class TestMaximization:
    def test_reaches_the_best_of_dense_least_squares(self, pairs: Complex) -> None:
        """scipy's Levenberg-Marquardt over poles and amplitudes, weights repeated until they settle."""
        from scipy.optimize import least_squares

        values = record(pairs, 2)
        found = best(values, poles_of(pairs * (1.02 - 0.01j), REAL * 1.3))
        k, std = np.arange(COUNT), np.sqrt(dense_squares(values, found.poles) / COUNT)

        def motion(x: Real) -> Real:
            theta, real = x[0:4:2] + 1j * x[1:4:2], x[4:5]
            rest = x[5:].reshape(3, 6)
            basis = np.vstack([np.exp(theta[:, None] * k).real, np.exp(theta[:, None] * k).imag])
            basis = np.vstack([basis, np.exp(real[:, None] * k), np.ones((1, COUNT))])
            return np.asarray(rest @ basis, float)

        x = np.concatenate(
            [
                [pairs[0].real, pairs[0].imag, pairs[1].real, pairs[1].imag, REAL[0]],
                np.concatenate(
                    [PAIR_AMPLITUDES.T.real, -PAIR_AMPLITUDES.T.imag, REAL_AMPLITUDES.T, np.zeros((3, 1))], axis=1
                ).ravel(),
            ]
        )

        def misfit(x: Real, weights: Real) -> Real:
            return np.asarray((values - motion(x)) / weights[:, None], float).ravel()

        for _ in range(6):
            solution = least_squares(misfit, x, args=(std,), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
            x = solution.x
            std = np.sqrt(np.mean((values - motion(x)) ** 2, axis=1))
        ours = np.concatenate([found.poles.pairs.view(float), found.poles.reals])
        # Both stop within a small share of a standard deviation.
        spread = np.sqrt(np.diag(np.linalg.inv(found.information)))
        np.testing.assert_array_less(np.abs(ours - x[:5]), 2e-3 * spread)

    @pytest.mark.parametrize("seed", range(5))
    def test_the_gradient_vanishes_there(self, pairs: Complex, seed: int) -> None:
        fit = best(record(pairs, seed), poles_of(pairs * (1.02 - 0.01j), REAL * 0.8))
        worth = fit.gradient @ np.linalg.solve(fit.information, fit.gradient)
        assert worth < 1e-5

    def test_without_noise_the_poles_are_exact(self, pairs: Complex) -> None:
        fit = best(clean(pairs), poles_of(pairs * (1.02 - 0.01j), REAL * 1.2))
        np.testing.assert_allclose(fit.poles.pairs, pairs, rtol=1e-8)
        np.testing.assert_allclose(fit.poles.reals, REAL, rtol=1e-8)

    def test_poles_held_by_few_steps_never_lose(self, pairs: Complex) -> None:
        values, start = record(pairs, 3), poles_of(pairs * (1.05 - 0.02j), REAL * 1.5)
        losses = []
        for steps in range(6):
            fit = maximize(blocks_of(values), start, NO_FLOOR, steps=steps)
            assert fit is not None
            losses.append(NO_FLOOR.loss(fit.squares, COUNT))
        assert np.all(np.diff(losses) <= 1e-9 * abs(losses[0]))
        assert losses[-1] < losses[0]

    @pytest.mark.parametrize("factor", [1.5, 0.7, 0.85 + 0.1j])
    def test_steps_from_afar_never_lose_and_end_at_an_optimum(self, pairs: Complex, factor: complex) -> None:
        values, start = record(pairs, 3), poles_of(pairs * factor, REAL * 3.0)
        fits = [maximize(blocks_of(values), start, NO_FLOOR, steps=steps) for steps in (*range(8), 60)]
        losses = [NO_FLOOR.loss(fit.squares, COUNT) for fit in fits if fit is not None]
        assert np.all(np.diff(losses) <= 1e-9 * abs(losses[0]))
        fit = fits[-1]
        assert fit is not None
        assert fit.gradient @ np.linalg.solve(fit.information, fit.gradient) < 1e-5

    def test_the_unit_of_a_channel_does_not_matter(self, pairs: Complex) -> None:
        values, start = record(pairs, 4), poles_of(pairs * (1.02 - 0.01j), REAL * 1.2)
        one, other = best(values, start), best(values * np.array([[1e-9], [1.0], [1e6]]), start)
        np.testing.assert_allclose(other.poles.exponents, one.poles.exponents, rtol=1e-7)
        np.testing.assert_allclose(other.information, one.information, rtol=1e-4, atol=1e-4 * one.information.max())


def nearly_one(apart: float) -> Poles:
    """Two pairs whose frequencies differ by a share; the part of one beside the other is a tenth of the share."""
    return Poles(pairs=np.array([-0.01 + 0.25j, -0.01 + 0.25j * (1 + apart)]), reals=np.zeros(0), nuisances=np.zeros(0))


class TestClosePoles:
    def values(self, poles: Poles) -> Real:
        motion = dense_basis(poles, COUNT) @ np.array([1.0, 0.5, -0.7, 0.3])
        return np.asarray(motion + 1e-3 * np.random.default_rng(1).standard_normal((1, COUNT)), float)

    @pytest.mark.parametrize("apart", [1e-2, 1e-3, 1e-4, 1e-5])
    def test_the_residual_is_known_to_its_rounding(self, apart: float) -> None:
        poles = nearly_one(apart)
        values = self.values(poles)
        fit = fitted(values, poles)
        assert np.all(np.abs(fit.squares - dense_squares(values, poles)) <= fit.rounding)
        assert np.all(fit.rounding < 0.1 * fit.squares)

    @pytest.mark.parametrize("apart", [0.0, 1e-8])
    def test_one_pole_given_twice_is_not_fitted(self, apart: float) -> None:
        values = self.values(nearly_one(1e-3))
        assert evaluate(blocks_of(values), nearly_one(apart), WhiteNoise(least=np.zeros(1))) is None

    def test_a_record_without_noise_or_motion_is_not_fitted(self) -> None:
        silent = blocks_of(np.zeros((1, COUNT)))
        assert evaluate(silent, nearly_one(0.5), WhiteNoise(least=np.zeros(1))) is None
        assert evaluate(silent, nearly_one(0.5), WhiteNoise(least=np.ones(1))) is not None


class TestReweighing:
    """Information is per variance; a residual below its rounding is not known."""

    def test_twice_the_residual_halves_the_information(self) -> None:
        fit = fitted(record(LIGHT, 1), poles_of(LIGHT, REAL))
        other = reweighed(fit, NO_FLOOR, 2 * fit.squares)
        np.testing.assert_allclose(other.information, fit.information / 2, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(other.squares, 2 * fit.squares)

    def test_no_residual_is_smaller_than_its_rounding(self) -> None:
        fit = fitted(record(LIGHT, 1), poles_of(LIGHT, REAL))
        np.testing.assert_array_equal(reweighed(fit, NO_FLOOR, np.zeros(3)).squares, fit.rounding)


def dense_covariance(pairs: Complex, std: Real) -> Real:
    """Inverse Fisher information of all parameters, mapped to (Re, Im of poles; Re, Im of shapes).

    Derivatives of the samples by central differences: nothing is projected, nothing eliminated.
    """

    def samples(x: Real) -> Real:
        theta, real, amplitudes = x[0:4:2] + 1j * x[1:4:2], x[4], x[5:23].reshape(3, 6)
        k = np.arange(COUNT)
        powers, level = np.exp(theta[:, None] * k), np.exp(real * k)
        rows = [
            (a[0] + 1j * a[1]) * powers[0] + (a[2] + 1j * a[3]) * powers[1] + a[4] * level + a[5] for a in amplitudes
        ]
        return np.asarray(np.array(rows).real / std[:, None], float).ravel()

    def shapes(x: Real) -> Real:
        amplitudes = x[5:23].reshape(3, 6)
        columns = [amplitudes[:, 0] + 1j * amplitudes[:, 1], amplitudes[:, 2] + 1j * amplitudes[:, 3]]
        columns.append(amplitudes[:, 4] + 0j)
        parts = [c / c[strongest] for c, strongest in zip(columns, strongest_channel(), strict=True)]
        return np.concatenate([np.array([pairs_part(p) for p in part]).ravel() for part in parts])

    def outputs(x: Real) -> Real:
        return np.concatenate([x[:5], [0.0], shapes(x)])

    x = np.empty(23)
    x[0:4:2], x[1:4:2], x[4] = pairs.real, pairs.imag, REAL[0]
    rest = np.zeros((3, 6))
    rest[:, 0:4:2], rest[:, 1:4:2], rest[:, 4] = PAIR_AMPLITUDES.T.real, PAIR_AMPLITUDES.T.imag, REAL_AMPLITUDES[0]
    x[5:] = rest.ravel()
    J, G = (np.stack([(f(x + h) - f(x - h)) / 2e-6 for h in np.eye(23) * 1e-6], axis=1) for f in (samples, outputs))
    return np.asarray(G @ np.linalg.inv(J.T @ J) @ G.T, float)


def strongest_channel() -> list[int]:
    every = np.vstack([PAIR_AMPLITUDES, REAL_AMPLITUDES])
    return [int(i) for i in np.argmax(np.abs(every), axis=1)]


def pairs_part(value: complex) -> list[float]:
    return [value.real, value.imag]


def covariance_of(fit: DecayFit, values: Real, inflation: Real) -> tuple[Complex, Real]:
    assert fit.count == values.shape[1]
    joint = joint_covariance([fit], np.array([0, 1, 2]), inflation)
    return joint.shapes, joint.covariance


@BOTH
@pytest.mark.parametrize("by_samples", [False, True])
def test_inverses_are_those_of_the_products_and_of_the_information(pairs: Complex, by_samples: bool) -> None:
    values, poles, noise = clean(pairs), poles_of(pairs, REAL), WhiteNoise(least=STD**2)
    fit = evaluate_samples(values, poles, noise) if by_samples else evaluate(blocks_of(values), poles, noise)
    assert fit is not None
    np.testing.assert_allclose(fit.inverse_gram @ fit.gram, np.eye(len(poles)), atol=1e-8)
    unbiased = fit.information * fit.freedom / fit.count
    np.testing.assert_allclose(fit.of_poles @ unbiased, np.eye(poles.free), atol=1e-8)


@BOTH
class TestJointCovariance:
    def test_is_the_inverse_of_the_whole_fisher_information(self, pairs: Complex) -> None:
        values, poles = clean(pairs), poles_of(pairs, REAL)
        fit = evaluate(blocks_of(values), poles, WhiteNoise(least=STD**2))
        assert fit is not None
        # A residual that is exactly what the noise would leave on average.
        free = COUNT - len(poles) - poles.free / 3
        fit = replace(fit, squares=STD**2 * free, weighted=fit.weighted * COUNT / free)
        _, found = covariance_of(fit, values, np.ones(3))
        expected = dense_covariance(pairs, STD)
        scale = np.sqrt(np.maximum(np.diag(expected), 1e-300))
        # The components that are 1 by definition have no variance.
        scale[np.diag(expected) < 1e-18] = 1.0
        np.testing.assert_allclose(found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=1e-5)

    def test_is_the_scatter_of_200_fits(self, pairs: Complex) -> None:
        draws, inside = [], []
        poles = poles_of(pairs, REAL)
        for seed in range(200):
            values = record(pairs, 1000 + seed)
            fit = best(values, poles)
            shapes, covariance = covariance_of(fit, values, np.ones(3))
            vector = np.concatenate(
                [fit.poles.pairs.view(float), fit.poles.reals, [0.0], shapes.T.copy().view(float).ravel()]
            )
            draws.append(vector)
            inside.append(np.diag(covariance))
        scatter, claimed = np.var(np.array(draws), axis=0, ddof=1), np.mean(inside, axis=0)
        moves = scatter > 1e-20
        # 5 real numbers of poles; 2 of 3 components of two complex shapes, the real one being real.
        assert np.count_nonzero(moves) >= 5 + 8 + 2
        # A variance from 200 draws scatters by a tenth: four of those.
        np.testing.assert_allclose(claimed[moves] / scatter[moves], 1.0, atol=0.4)
        np.testing.assert_allclose(np.mean(claimed[moves] / scatter[moves]), 1.0, atol=0.12)

    def test_shapes_are_amplitudes_over_the_largest(self, pairs: Complex) -> None:
        values = clean(pairs)
        shapes, _ = covariance_of(best(values, poles_of(pairs, REAL)), values, np.ones(3))
        for shape, row in zip(shapes.T, np.vstack([PAIR_AMPLITUDES, REAL_AMPLITUDES]), strict=True):
            np.testing.assert_allclose(shape, row / row[np.argmax(np.abs(row))], atol=1e-6)

    def test_inflation_widens_one_mode(self, pairs: Complex) -> None:
        values = record(pairs, 5)
        fit = best(values, poles_of(pairs, REAL))
        (_, plain), (_, wide) = (covariance_of(fit, values, np.array(f)) for f in ([1.0, 1.0, 1.0], [9.0, 1.0, 1.0]))
        ratio = np.sqrt(np.diag(wide) / np.where(np.diag(plain) > 0, np.diag(plain), 1.0))
        own = np.zeros(24, bool)
        own[[0, 1]], own[6:12] = True, True
        moves = np.diag(plain) > 0
        np.testing.assert_allclose(ratio[own & moves], 3.0, rtol=1e-12)
        np.testing.assert_allclose(ratio[~own & moves], 1.0, rtol=1e-12)

    def test_is_positive_semidefinite(self, pairs: Complex) -> None:
        values = record(pairs, 6)
        _, found = covariance_of(best(values, poles_of(pairs, REAL)), values, np.ones(3))
        np.testing.assert_allclose(found, found.T, rtol=1e-9, atol=1e-20)
        assert np.all(np.diag(found) >= 0)
        scale = np.sqrt(np.where(np.diag(found) > 0, np.diag(found), 1.0))
        assert np.linalg.eigvalsh(found / np.outer(scale, scale)).min() > -1e-9


class TestPoorlyToldApart:
    """Two real poles that creep towards the offset, as for a straight drift."""

    @pytest.mark.parametrize("apart", [3e-2, 1e-3, 1e-4, 1e-5])
    def test_the_covariance_stays_one(self, apart: float) -> None:
        values = record(LIGHT, 1) + np.arange(COUNT) / COUNT
        poles = poles_of(LIGHT, np.array([-apart, 2 * apart]) / COUNT)
        fit = evaluate(blocks_of(values), poles, WhiteNoise(least=STD**2))
        if fit is not None:
            covariance = joint_covariance([fit], np.array([0, 1, 2]), np.ones(3)).covariance
            assert np.all(np.diag(covariance) >= 0)
            # The pairs know nothing of it: they keep the precision they have without the drift.
            plain = np.sqrt(np.diag(np.linalg.inv(fitted(record(LIGHT, 1), poles_of(LIGHT, REAL)).information)))[:4]
            assert np.all(np.sqrt(np.diag(covariance)[:4]) > 0.3 * plain)


class TestPoles:
    def test_a_step_moves_what_it_says(self) -> None:
        poles = poles_of(LIGHT, REAL).moved(np.array([1.0, 2.0, 3.0, 4.0, 5.0]))
        np.testing.assert_allclose(poles.pairs, LIGHT + np.array([1 + 2j, 3 + 4j]))
        np.testing.assert_allclose(poles.reals, REAL + 5)
        np.testing.assert_array_equal(poles.nuisances, [0.0])

    def test_adding_and_leaving_out(self) -> None:
        poles = poles_of(LIGHT, REAL)
        assert len(poles) == 6
        assert poles.free == 5
        grown = poles.with_pair(-0.5 + 1j).with_real(-0.7)
        assert grown.free == 8
        np.testing.assert_array_equal(grown.without(2).without(3).exponents, poles.exponents)
        np.testing.assert_array_equal(grown.without(0).pairs, [LIGHT[1], -0.5 + 1j])

    def test_no_free_pole_is_fitted_at_once(self) -> None:
        values = np.random.default_rng(0).standard_normal((1, 50)) + 3.0
        fit = maximize(blocks_of(values), poles_of(np.zeros(0, complex), np.zeros(0)), WhiteNoise(least=np.zeros(1)))
        assert fit is not None
        assert fit.amplitudes[0, 0] == pytest.approx(values.mean(), rel=1e-12)
        assert fit.squares[0] == pytest.approx(49 * np.var(values, ddof=1), rel=1e-12)
