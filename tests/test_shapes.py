"""Two close poles: one motion of one shape, or two modes. Against the definition, and the level of the test."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import bdtrc

from suspid import identify
from suspid.identification.ascent import maximize
from suspid.identification.division import apart
from suspid.identification.exponentials import blocks_of
from suspid.identification.fitting import Problem
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.identification.shapes import SHAPE_LEVEL, same_shape, within_shapes
from suspid.records import as_response

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

COUNT = 400
# Damping ratios .25 and .3, 8 % apart in frequency: a quarter of a linewidth.
CLOSE: Complex = np.array([0.1 * (-0.25 + 0.968j), 0.108 * (-0.3 + 0.954j)])
SHAPE: Complex = np.array([1.0, 0.7 - 0.2j, -0.4 + 0.1j, 0.5j])


def decays(poles: Complex, amplitudes: Complex, count: int = COUNT) -> Real:
    """Samples (channel, sample) from amplitudes (channel, pole)."""
    return np.asarray((amplitudes @ np.exp(poles[:, None] * np.arange(count))).real, float)


def white(seed: int, std: float, channels: int) -> Real:
    return std * np.random.default_rng(seed).standard_normal((channels, COUNT))


def together(values: Real) -> bool:
    """Whether the test takes the two fitted poles for one motion."""
    blocks = blocks_of(values - values.mean(axis=1, keepdims=True))
    start = Poles(pairs=CLOSE, reals=np.zeros(0), nuisances=np.zeros(1))
    fit = maximize(blocks, start, WhiteNoise(least=np.full(len(values), 1e-20)))
    assert fit is not None
    return same_shape(fit, 0, 1, colour=1.0)


class TestSameShape:
    @pytest.mark.parametrize("channels", [2, 4])
    def test_level(self, channels: int) -> None:
        """One shape and any f(t): called two modes with the probability of the level, or less."""
        records = 200
        parallel = np.outer(SHAPE[:channels], [1.0, 0.8 - 0.5j])
        wrong = sum(not together(decays(CLOSE, parallel) + white(seed, 2e-4, channels)) for seed in range(records))
        # More than this by chance once in 1000 times.
        assert bdtrc(wrong - 1, records, SHAPE_LEVEL) > 1e-3 or wrong == 0

    @pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
    def test_two_shapes_are_two_modes_in_any_unit(self, scale: float) -> None:
        apart = np.stack([SHAPE, [0.2, -0.8, 0.9, 0.3]], axis=1) * np.array([[scale], [1], [1], [1]])
        noise = white(3, 1e-3, 4) * np.array([[scale], [1], [1], [1]])
        assert not together(decays(CLOSE, apart) + noise)

    def test_one_channel_has_no_shape(self) -> None:
        assert together(decays(CLOSE, np.array([[1.0, -2.0]])) + white(4, 1e-3, 1))


class TestApart:
    def test_a_second_pole_is_where_the_bend_says(self) -> None:
        """Two poles so close that the series in t is exact: the start is near both, though the fit has one."""
        poles: Complex = CLOSE[0] * np.array([1.0, 1.02])
        values = decays(poles, np.stack([SHAPE, [0.2, -0.8, 0.9, 0.3]], axis=1)) + white(5, 1e-7, 4)
        centred = values - values.mean(axis=1, keepdims=True)
        problem = Problem(values=centred, blocks=blocks_of(centred), noise=WhiteNoise(least=np.full(4, 1e-20)))
        one = problem.fitted(Poles(pairs=CLOSE[:1], reals=np.zeros(0), nuisances=np.zeros(1)))
        assert one is not None
        promised = apart(one)
        start = promised.two(0)
        two = problem.fitted(one.poles.without(0).with_pair(start[0]).with_pair(start[1]))
        assert two is not None
        assert promised.gains[0] > problem.penalty(real=False)
        np.testing.assert_allclose(np.sort_complex(two.poles.pairs), np.sort_complex(poles), rtol=1e-3)


class TestHeavilyDampedModes:
    @pytest.mark.parametrize("seed", range(6))
    def test_three_percent_apart(self, seed: int) -> None:
        """Merged by any rule of distance: a tenth of a linewidth."""
        rng = np.random.default_rng(seed)
        zeta = rng.uniform(0.2, 0.4, 2)
        wn = np.array([20.0, 20.6])
        poles = wn * (-zeta + 1j * np.sqrt(1 - zeta**2))
        shapes = np.array([[1.0, 0.9], [0.8, -1.0], [0.3, 0.6]]) * np.exp(2j * np.pi * rng.uniform(size=2))
        time = np.arange(COUNT) * 0.01
        values = decays(poles * 0.01, shapes)
        noise = 0.003 * rng.standard_normal(values.shape)
        found = identify(as_response(np.asarray(time, float), values + noise, ["front", "middle", "rear"])).modes
        assert len(found) == 2
        assert found.wn_std is not None
        assert found.zeta_std is not None
        assert np.all(np.abs(np.sort(found.wn) - wn) < 4 * found.wn_std)


# A third mode a linewidth beside two that are a tenth of one apart.
THREE: Complex = np.array([-0.012 + 0.24j, -0.0125 + 0.26j, -0.0128 + 0.2612j])
SHAPES: Complex = np.array(
    [[1.0, -0.6, 0.3, 0.5, 0.1], [0.4, 0.9, -0.7, 0.2, 0.6], [-0.8, 0.1, 0.5, 0.7, 0.9]], complex
)


class TestWithinShapes:
    @staticmethod
    def within(amplitudes: Complex, *, seed: int, std: float = 1e-3) -> bool:
        values = decays(THREE, amplitudes.T) + white(seed, std, amplitudes.shape[1])
        blocks = blocks_of(values - values.mean(axis=1, keepdims=True))
        start = Poles(pairs=THREE, reals=np.zeros(0), nuisances=np.zeros(1))
        fit = maximize(blocks, start, WhiteNoise(least=np.full(len(values), 1e-20)))
        assert fit is not None
        return within_shapes(fit, 0, (1, 2), colour=1.0)

    def test_level(self) -> None:
        """A sum of the shapes of the others is called another mode with the probability of the level, or less."""
        records, summed = 200, np.array([0.7 * SHAPES[1] - (0.4 + 0.2j) * SHAPES[2], *SHAPES[1:]])
        wrong = sum(not self.within(summed, seed=seed) for seed in range(records))
        assert bdtrc(wrong - 1, records, SHAPE_LEVEL) > 1e-3 or wrong == 0

    @pytest.mark.parametrize("seed", range(5))
    def test_a_third_shape_is_another_mode(self, seed: int) -> None:
        assert not self.within(SHAPES, seed=seed)

    def test_two_channels_do_not_tell(self) -> None:
        assert self.within(SHAPES[:, :2], seed=1)


@pytest.mark.parametrize("seed", range(6))
def test_two_modes_far_within_a_linewidth_beside_a_third_are_three(seed: int) -> None:
    """Alone, each of the shapes of the two is hardly known, and could be that of the third."""
    values: Real = decays(THREE, SHAPES.T) + white(seed, 3e-3, 5)
    found = identify(as_response(np.arange(COUNT, dtype=np.float64) / 100, values, list("abcde")))
    np.testing.assert_allclose(np.sort(found.modes.wn), np.sort(np.abs(THREE)) / 0.01, rtol=2e-3)
