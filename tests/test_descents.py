"""Descents along curved valleys, and the stacks of small matrices they rest on."""

from __future__ import annotations

import numpy as np
import pytest

from suspid.greybox.small_matrices import inverses, log_determinants, whitening
from suspid.reconstruction import descend
from suspid.units import RealArray


def _calls(curvature: float, *, secant: bool) -> tuple[float, int]:
    """Return where a descent ends, and after how many evaluations.

    The minimum is 0, and steps of Gauss-Newton leave the share ``-curvature`` of the distance (K. Madsen, H. B. Nielsen
    and O. Tingleff, Methods for Non-Linear Least Squares Problems, 2004, example 3.4).
    """
    calls = []

    def equations(x: RealArray) -> tuple[RealArray, RealArray]:
        calls.append(x)
        return np.array([x[0] + 1, curvature * x[0] ** 2 + x[0] - 1]), np.array([[1.0], [2 * curvature * x[0] + 1]])

    far, end = np.array([np.inf]), np.array([0.3])
    end = descend(equations, end, positive=np.array([False]), lower=-far, upper=far, secant=secant)
    return float(end[0]), len(calls)


@pytest.mark.parametrize("curvature", [-0.9, -0.8])
def test_secants_see_the_curvature_that_gauss_newton_does_not(curvature: float) -> None:
    end, few = _calls(curvature, secant=True)
    _, many = _calls(curvature, secant=False)
    assert end == pytest.approx(0, abs=1e-6)
    assert few < many / 2


@pytest.mark.parametrize("size", [1, 2, 3])
def test_small_matrices(size: int) -> None:
    rng = np.random.default_rng(size)
    root = rng.standard_normal((5, size, size)) + 1j * rng.standard_normal((5, size, size))
    R = root @ root.conj().swapaxes(1, 2)
    one = np.broadcast_to(np.eye(size), R.shape)
    np.testing.assert_allclose(inverses(root) @ root, one, atol=1e-10)
    white = whitening(R)
    np.testing.assert_allclose(white @ R @ white.conj().swapaxes(1, 2), one, atol=1e-10)
    np.testing.assert_allclose(log_determinants(R), np.log(np.linalg.eigvalsh(R)).sum(axis=1), atol=1e-10)
