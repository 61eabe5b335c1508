"""Intervals beside bounds: ends are those of the profile of the likelihood, and hold the truth as often as stated."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.stats import chi2, norm

from suspid.greybox.within_bounds import ends_within, widened
from suspid.levels import NORMAL_95


class TestProfile:
    @pytest.mark.parametrize("seed", range(6))
    def test_ends_are_where_the_best_car_within_the_bounds_is_as_unlikely_as_asked(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        root = rng.standard_normal((4, 4))
        covariance, center = root @ root.T, rng.standard_normal(4)
        lower, upper = np.array([-np.inf, 0.0, -0.3, -np.inf]), np.array([np.inf, 2.5, np.inf, 0.5])
        whitened = np.linalg.inv(np.linalg.cholesky(covariance))

        def misfit(i: int, value: float) -> float:
            others = [k for k in range(4) if k != i]
            target = whitened @ center - whitened[:, i] * value
            found = lsq_linear(whitened[:, others], target, (lower[others], upper[others]), tol=1e-13)
            return float(2 * found.cost)

        least = 2 * lsq_linear(whitened, whitened @ center, (lower, upper), tol=1e-13).cost
        std = np.sqrt(np.diag(covariance))
        alike = np.abs(covariance / np.outer(std, std))[:, 1:] * (1 - np.eye(4)[:, 1:])
        allowed = widened(2.0, alike.max(axis=1)) ** 2
        for i, (low, high) in enumerate(zip(*ends_within(center, covariance, lower, upper, 2.0), strict=True)):
            for end, bound in ((low, lower[i]), (high, upper[i])):
                if abs(end - bound) > 1e-9:
                    assert misfit(i, end) - least == pytest.approx(allowed[i], abs=1e-5)
                else:
                    assert misfit(i, end) - least < allowed[i]

    def test_far_from_bounds_they_are_those_of_the_normal_distribution(self) -> None:
        low, high = ends_within(
            np.array([1.0, 5.0]), np.array([[4.0, 0.5], [0.5, 1.0]]), np.array([-np.inf, 0.0]), np.full(2, np.inf), 2.0
        )
        np.testing.assert_allclose(low, [-3.0, 3.0])
        np.testing.assert_allclose(high, [5.0, 7.0])

    def test_what_is_known_exactly_stays(self) -> None:
        low, high = ends_within(np.zeros(2), np.zeros((2, 2)), np.zeros(2), np.full(2, np.inf), 2.0)
        assert not low.any()
        assert not high.any()


@pytest.mark.parametrize("away", [0.0, 1.0, 3.0])
def test_they_hold_the_truth_beside_a_bound_and_off_it(away: float) -> None:
    # A damper and the relaxation of its mount: -0.97 is their correlation in a minute of driving.
    correlated = np.array([[1.0, -0.97], [-0.97, 1.0]])
    lower, upper, truth = np.array([-np.inf, 0.0]), np.full(2, np.inf), np.array([0.0, away])
    draws, held = 2000, 0
    for error in np.random.default_rng(1).multivariate_normal(np.zeros(2), correlated, draws):
        low, high = ends_within(truth + error, correlated, lower, upper, NORMAL_95)
        held += low[0] <= 0.0 <= high[0]
    # As often as stated at the bound, up to 0.98 at a third of a standard deviation. 2000 draws know that to 0.005.
    assert 0.935 < held / draws < 0.985


def test_they_are_wider_by_what_likelihood_ratios_are_beside_a_bound() -> None:
    # For a parameter that all but is the one at its bound: half of chi-square of one, a quarter of two degrees.
    for reach in (NORMAL_95, 2.5, 3.5):
        (q,) = widened(reach, np.array([1.0])) ** 2
        assert chi2.sf(q, 1) / 2 + chi2.sf(q, 2) / 4 == pytest.approx(2 * norm.sf(reach), rel=0.02)
        assert widened(reach, np.zeros(1)) == pytest.approx(reach, rel=1e-3)


def test_all_that_lies_beyond_a_bound_is_left_out() -> None:
    # One parameter is at its bound and the other follows it: the side that cars have is left.
    shared = np.array([[1.0, -0.97], [-0.97, 1.0]])
    lower = np.array([-np.inf, 0.0])
    low, high = ends_within(np.zeros(2), shared, lower, np.full(2, np.inf), 2.0)
    (reach,) = widened(2.0, np.array([0.97]))
    assert low[0] == pytest.approx(-reach)
    assert high[0] == pytest.approx(reach * np.sqrt(1 - 0.97**2))
    assert (low[1], high[1]) == pytest.approx((0.0, 2.0))
