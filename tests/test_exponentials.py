from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid.identification.exponentials import blocks_of, cross_sums, power_sums, project, synthesize

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
EXPONENTS = {
    "zero": 0.0 + 0.0j,
    "tiny": -1e-9 + 1e-10j,
    "subnormal": 1e-310 + 0j,
    "tone": 0.5j,
    "slow tone": 1e-4j,
    "tone at Nyquist": 1j * np.pi,
    "decaying": -0.01 + 0.3j,
    "decaying fast": -2.5 + 1j,
    "real": -0.003 + 0j,
    "growing": 1e-6 + 0.2j,
}


def direct(phi: complex, count: int) -> Complex:
    """The three sums, term by term, with numpy's pairwise summation."""
    k = np.arange(count)
    powers = np.exp(phi * k)
    return np.array([np.sum((k / count) ** j * powers) for j in range(3)])


class TestPowerSums:
    @pytest.mark.parametrize(
        ("which", "count"),
        [(which, count) for which in EXPONENTS for count in (8, 100, 4096, 4097, 50_000)]
        + [(which, 1_000_000) for which in ("zero", "tiny", "slow tone", "decaying")],
    )
    def test_are_the_sums(self, which: str, count: int) -> None:
        phi = EXPONENTS[which]
        found = np.concatenate(power_sums(np.array([phi], complex), count))
        # Against the largest that the sum could be; exp(phi k) itself is known to k |phi| units of rounding.
        scale = direct(complex(phi.real), count).real
        np.testing.assert_array_less(np.abs(found - direct(phi, count)), (1e-12 + 4e-16 * abs(phi) * count) * scale)

    @pytest.mark.parametrize("count", [8, 64, 4096, 4097, 100_000])
    @pytest.mark.parametrize("angle", [0.0, 1.0, np.pi / 2, 2.5, np.pi, -2.0])
    def test_series_and_closed_form_meet(self, count: int, angle: float) -> None:
        # On both sides of where one takes over from the other.
        for size in (0.1, 1.0, 1.999, 2.001, 3.0, 6.0):
            phi = size / count * np.exp(1j * angle)
            found = np.concatenate(power_sums(np.array([phi]), count))
            scale = direct(complex(phi.real), count).real
            np.testing.assert_array_less(np.abs(found - direct(phi, count)) / scale, 1e-12)

    @pytest.mark.parametrize("count", [1, 2, 5, 9, 5000])
    def test_of_one_are_sums_of_powers(self, count: int) -> None:
        n = count
        zeroth, first, second = (float(s[0].real) for s in power_sums(np.zeros(1, complex), count))
        assert zeroth == n
        assert first == pytest.approx((n - 1) / 2, rel=1e-13)
        assert second == pytest.approx((n - 1) * (2 * n - 1) / (6 * n), rel=1e-13)

    def test_of_the_conjugate_are_conjugate(self) -> None:
        phi = np.array(list(EXPONENTS.values()))
        for straight, mirrored in zip(power_sums(phi, 777), power_sums(phi.conj(), 777), strict=True):
            np.testing.assert_array_equal(straight.conj(), mirrored)

    def test_any_shape(self) -> None:
        phi = np.array([[-0.1 + 1j, 0.0, 1e-5], [-1e-3, 2j, -0.5]])
        for whole, flat in zip(power_sums(phi, 300), power_sums(phi.ravel(), 300), strict=True):
            np.testing.assert_array_equal(whole.ravel(), flat)

    def test_the_next_is_the_slope_of_the_one_before(self) -> None:
        # d/dphi of sum (k/n)^j exp(phi k) is n times the next sum; central differences err by their step squared.
        count, h = 500, 1e-6
        phi: Complex = np.array([-0.01 + 0.2j, -1e-3 + 1e-3j, 0.4j])
        up, down, here = (power_sums(np.asarray(phi + d, complex), count) for d in (h, -h, 0.0))
        for before, after in pairwise(range(3)):
            slope = (up[before] - down[before]) / (2 * h)
            np.testing.assert_allclose(here[after] * count, slope, rtol=1e-5, atol=1e-4)


class TestCrossSums:
    @pytest.mark.parametrize("count", [8, 300, 20_000])
    def test_are_the_sums(self, count: int) -> None:
        left: Complex = np.array([0.0, -2 / count + 0.3j, -2 / count - 0.3j, -0.05 + 1j, -0.4 / count])
        right: Complex = np.array([-1 / count, -0.9 + 2.9j, -0.01 + 0.31j, 0.3j, -0.3j, 1e-9 + 0j])
        found = cross_sums(left, right, count)
        assert found.shape == (5, 6)
        for i, a in enumerate(left):
            for j, b in enumerate(right):
                scale = direct(complex((a + b).real), count)[0].real
                # The documented loss, 4 / (n |phi|), and what exp(phi k) itself loses.
                assert abs(found[i, j] - direct(a + b, count)[0]) < 1e-11 * scale


@pytest.fixture
def theta() -> Complex:
    return np.array([-0.02 + 0.4j, -0.3 + 1.2j, 0.0, -1e-3, 0.7j, -2.0, 1e-4 + 0.1j])


class TestBlocks:
    @pytest.mark.parametrize("count", [8, 9, 63, 64, 65, 100, 5000, 12_345, 70_000])
    @pytest.mark.parametrize("channels", [1, 3])
    def test_projections_are_dense_sums(self, theta: Complex, count: int, channels: int) -> None:
        values = np.random.default_rng(count).standard_normal((channels, count))
        k = np.arange(count)
        dense = np.exp(theta[:, None] * k).conj()
        expected = np.stack([dense @ values.T, dense @ (values * (k / count)).T])
        scale = np.stack([np.abs(dense) @ np.abs(values).T] * 2)
        np.testing.assert_array_less(np.abs(blocks_of(values).project(theta) - expected), 1e-12 * scale)

    @pytest.mark.parametrize("count", [3, 63, 64, 65, 5000, 70_000])
    def test_a_record_used_once_has_the_same(self, theta: Complex, count: int) -> None:
        values = np.random.default_rng(count).standard_normal((2, count))
        time = np.arange(count) / count
        dense = np.exp(theta[:, None] * np.arange(count)).conj()
        expected = np.stack([dense @ (values * time**j).T for j in range(3)])
        scale = np.stack([np.abs(dense) @ np.abs(values).T] * 3)
        np.testing.assert_array_less(np.abs(project(values, theta, orders=3) - expected), 1e-12 * scale)

    @pytest.mark.parametrize("count", [9, 5000, 70_000])
    def test_a_constant_alone(self, count: int) -> None:
        values = np.random.default_rng(count).standard_normal((2, count)) + 0.5
        zeroth, first = blocks_of(values).project(np.zeros(1, complex))
        np.testing.assert_allclose(zeroth[0], [np.sum(row) for row in values], rtol=1e-12)
        np.testing.assert_allclose(first[0], [np.sum(row * np.arange(count)) / count for row in values], rtol=1e-12)

    def test_energy_and_channels(self) -> None:
        values = np.random.default_rng(1).standard_normal((2, 77))
        blocks = blocks_of(values)
        assert blocks.channels == 2
        np.testing.assert_allclose(blocks.energy, np.sum(values**2, axis=1), rtol=1e-14)

    def test_the_record_is_not_touched(self) -> None:
        values = np.random.default_rng(2).standard_normal((2, 50))
        before = values.copy()
        blocks_of(values).folded[:] = 0.0
        np.testing.assert_array_equal(values, before)


class TestSynthesis:
    @pytest.mark.parametrize("count", [8, 63, 64, 65, 5000])
    def test_is_the_dense_sum(self, theta: Complex, count: int) -> None:
        rng = np.random.default_rng(3)
        amplitudes = rng.standard_normal((len(theta), 2)) + 1j * rng.standard_normal((len(theta), 2))
        dense = np.exp(theta[:, None] * np.arange(count))
        found = synthesize(theta, amplitudes, count)
        assert found.shape == (2, count)
        np.testing.assert_allclose(found, (amplitudes.T @ dense).real, rtol=0, atol=1e-11)

    def test_is_the_adjoint_of_the_projection(self, theta: Complex) -> None:
        # <y, Re sum a e> = Re sum a <y, e>^*: both sides by different code.
        rng = np.random.default_rng(4)
        values = rng.standard_normal((1, 999))
        amplitudes = rng.standard_normal((len(theta), 1)) + 1j * rng.standard_normal((len(theta), 1))
        left = float(np.sum(values * synthesize(theta, amplitudes, 999)))
        right = float(np.sum(amplitudes[:, 0] * blocks_of(values).project(theta)[0, :, 0].conj()).real)
        assert left == pytest.approx(right, rel=1e-11)

    def test_of_nothing_is_zero(self) -> None:
        assert not synthesize(np.zeros(0, complex), np.zeros((0, 2), complex), 40).any()
