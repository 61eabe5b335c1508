import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

from suspid.errors import IdentificationError
from suspid.identification.exponentials import blocks_of
from suspid.identification.joint_fit import Agreement, agreement, maximize_jointly
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles

PAIR, REAL, LENGTHS = -0.02 + 0.3j, -0.006, (400, 700, 500)
STD = 0.02


def agreed(seed: int, pairs: NDArray[np.complex128], index: int) -> Agreement:
    """Return the agreement of three decays whose pairs may differ."""
    rng = np.random.default_rng(seed)
    blocks = []
    for pair, count in zip(pairs, LENGTHS, strict=True):
        k = np.arange(count)
        values = np.real(np.exp(pair * k)) + 0.8 * np.exp(REAL * k) + STD * rng.standard_normal(count)
        blocks.append(blocks_of(values[None]))
    noises = [WhiteNoise(least=np.full(1, 1e-12))] * 3
    start = Poles(pairs=np.array([PAIR]), reals=np.array([REAL]), nuisances=np.zeros(1))
    return agreement(blocks, maximize_jointly(blocks, [start] * 3, noises), noises, index)


def test_a_pair_does_not_cross_the_real_axis() -> None:
    """One that meets it would go on as its own conjugate, which is no pole of a set of modes."""
    rng = np.random.default_rng(3)
    fading = [np.exp(-0.01 * np.arange(count)) + 1e-3 * rng.standard_normal(count) for count in LENGTHS]
    blocks = [blocks_of(values[None]) for values in fading]
    noises = [WhiteNoise(least=np.full(1, 1e-12))] * 3
    start = Poles(pairs=np.array([-0.012 + 0.004j]), reals=np.zeros(0), nuisances=np.zeros(1))
    fits = maximize_jointly(blocks, [start] * 3, noises)
    assert all(np.all(fit.poles.pairs.imag > 0) for fit in fits)
    below = Poles(pairs=np.array([-0.012 - 0.004j]), reals=np.zeros(0), nuisances=np.zeros(1))
    with pytest.raises(IdentificationError):
        maximize_jointly(blocks, [below] * 3, noises)
    beside = Poles(pairs=np.array([PAIR, -0.012 - 0.004j]), reals=np.zeros(0), nuisances=np.zeros(1))
    with pytest.raises(IdentificationError):
        maximize_jointly(blocks, [beside] * 3, noises)


class TestAgreement:
    @pytest.mark.parametrize(("index", "freedom"), [(0, 4), (1, 2)])
    def test_of_equal_decays_is_a_chi_square(self, index: int, freedom: int) -> None:
        # Two numbers of a pair or one of a real pole in each of three decays, less the common ones.
        found = [agreed(seed, np.full(3, PAIR), index) for seed in range(60)]
        held = [one.chi_square for one in found if one.freedom == freedom]
        assert len(held) > 50
        assert np.mean(held) == pytest.approx(freedom, abs=4 * np.sqrt(2 * freedom / len(held)))
        for one in found:
            if one.freedom:
                assert one.probability == pytest.approx(chi2(one.freedom).sf(one.chi_square), rel=1e-9)
                assert one.widening == (1.0 if one.probability >= 0.01 else one.chi_square / one.freedom)

    def test_grows_with_the_square_of_the_difference(self) -> None:
        off = np.array([0.0, 1.0, 0.0])
        one, two = (agreed(1, PAIR + size * 1j * off, 0).chi_square for size in (2e-3, 4e-3))
        assert two / one == pytest.approx(4.0, rel=0.3)

    def test_widens_where_decays_differ(self) -> None:
        found = agreed(2, PAIR + np.array([0.0, 4e-3j, -4e-3j]), 0)
        assert found.probability < 0.01
        assert found.widening == pytest.approx(found.chi_square / 4)
