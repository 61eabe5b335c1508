"""Mean squares of records: their variance by law, and intervals that hold."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter
from scipy.special import chdtri

from suspid import ride
from suspid.performance.mean_squares import _of_squares, _share, _vibration, power_mean
from suspid.performance.tones import steady_tones
from suspid.records import as_response
from suspid.units import RealArray

STEP = 0.02
ZETA, HERTZ = 0.05, 1.2  # of a body on a weak damper


def white(count: int, seed: int) -> RealArray:
    return np.random.default_rng([53, seed]).standard_normal(count)


def resonance(seconds: float, seed: int) -> RealArray:
    """Return the motion of an oscillator under white noise, settled for 40 s, from its exact difference equation."""
    wn = 2 * np.pi * HERTZ
    pole = np.exp((-ZETA + 1j * np.sqrt(1 - ZETA**2)) * wn * STEP)
    count, lead = round(seconds / STEP), round(40 / STEP)
    return np.asarray(lfilter([1.0], [1, -2 * pole.real, abs(pole) ** 2], white(count + lead, seed))[lead:])


def tone(seconds: float, seed: int) -> RealArray:
    t = np.arange(0, seconds, 0.005)
    return np.asarray(white(len(t), seed) + np.sqrt(2) * np.sin(2 * np.pi * 13.7 * t + seed))


class TestVarianceOfAMeanSquare:
    """Bendat and Piersol: variance = (2 / T) int R^2."""

    @pytest.mark.parametrize("power", [2, 4])
    def test_of_white_noise(self, power: int) -> None:
        """Samples are independent: ``std(x^2) = 2^(1/2)`` and ``std(x^4) = 96^(1/2)`` of each, over p mean."""
        count = 5000
        expected = {2: 2**0.5 / 2, 4: 96**0.5 / (4 * 3)}[power] / count**0.5
        found = [power_mean(white(count, seed), power) for seed in range(10)]
        assert np.mean([std / root for root, std in found]) == pytest.approx(expected, rel=0.02)

    def test_of_a_resonance(self) -> None:
        """``R = exp(-a tau) cos`` has ``2 a T`` degrees of freedom, with ``a = zeta wn``.

        Student's factor, and what the lines scatter, take a tenth of them.
        """
        seconds = 300.0
        freedom = [0.5 / (std / root) ** 2 for root, std in (power_mean(resonance(seconds, s), 2) for s in range(20))]
        assert np.median(freedom) == pytest.approx(2 * ZETA * 2 * np.pi * HERTZ * seconds, rel=0.2)

    def test_how_well_it_is_known(self) -> None:
        """``4 w + 4 u - 8 t`` is the relative variance of its share, and widens the interval as Student's."""
        records = [_vibration(resonance(40.0, seed)) for seed in range(100)]
        shares, variances = np.array([_share(one) for one in records]).T
        assert np.median(variances) ** 0.5 == pytest.approx(np.std(np.log(shares)), rel=0.3)
        wider = [2 * _of_squares(one) / share**0.5 for one, share in zip(records, shares, strict=True)]
        np.testing.assert_allclose(wider, stats.t.isf(0.025, 2 / variances) / stats.norm.isf(0.025))

    @pytest.mark.parametrize("power", [2, 4])
    def test_a_steady_tone_does_not_widen_it(self, power: int) -> None:
        """``var(m) = 2 s^4 / N + 4 p s^2 / N``; a tone has no more of a fourth power than what it mixes with."""
        found = np.array([power_mean(tone(20.0, seed), power) for seed in range(60)])
        assert np.median(found[:, 1]) == pytest.approx(np.std(found[:, 0]), rel=0.25)
        if power == 2:
            expected = (2 + 4) ** 0.5 / len(tone(20.0, 0)) ** 0.5 / (2 * 2)
            # Not by the scatter of pieces, which tells the same less well.
            steady = [_of_squares(_vibration(tone(20.0, seed))) for seed in range(60)]
            assert np.median(steady) == pytest.approx(expected, rel=0.05)

    def test_pieces_tell_what_is_not_steady(self) -> None:
        """Of a level that is a half and one and a half in turns, twenty pieces vary by more than noise does."""
        level = np.repeat(np.where(np.random.default_rng(3).random(20) < 0.5, 0.5, 1.5), 250)
        root, std = power_mean(level * white(5000, 1), 2)
        squares = level[::250] ** 2
        expected = np.std(squares, ddof=1) / 20**0.5 / (2 * np.mean(squares))
        assert std / root == pytest.approx(expected, rel=0.15)


def test_a_tone_is_taken_off_to_the_noise() -> None:
    t = np.arange(0, 20, 0.005)
    faint = 1e-4 * white(len(t), 2)
    rest, squares, _ = steady_tones(faint + 3 * np.sin(2 * np.pi * 13.713 * t) + np.cos(2 * np.pi * 27.426 * t + 1))
    np.testing.assert_allclose(squares, [4.5, 0.5], rtol=1e-4)
    assert np.std(rest) == pytest.approx(1e-4, rel=0.02)


def test_a_sharp_resonance_is_no_tone() -> None:
    assert not any(len(steady_tones(resonance(60.0, seed))[1]) for seed in range(40))


@pytest.mark.parametrize(
    ("record", "true"),
    [
        (lambda seed: resonance(20.0, seed), None),
        (lambda seed: resonance(60.0, seed), None),
        (lambda seed: tone(20.0, seed), 2**0.5),
    ],
    ids=["resonance, 20 s", "resonance, 60 s", "tone in noise"],
)
def test_intervals_hold_95_per_cent(record: Callable[[int], RealArray], true: float | None) -> None:
    """Of 200 intervals 93 to 97 % hold, to three standard deviations of so few."""
    samples = [record(seed) for seed in range(200)]
    truth = true or float(np.mean([np.mean(one**2) for one in samples])) ** 0.5
    held = 0
    for one in samples:
        root, std = power_mean(one, 2)
        freedom = 0.5 / (std / root) ** 2
        low, high = (root * np.sqrt(freedom / chdtri(freedom, p)) for p in (0.025, 0.975))
        held += bool(low < truth < high)
    assert 0.9 <= held / len(samples) <= 0.995


def test_the_interval_of_a_figure_is_that_of_a_chi_square() -> None:
    t = np.arange(0, 30, STEP)
    found = ride(as_response(t, resonance(30.0, 1)[None], ["seat_acceleration"]))
    at = found.figures.index("seat_acceleration.rms")
    freedom = 0.5 / (found.scatter[at] / found.values[at]) ** 2
    low, high = found.interval()["seat_acceleration.rms"]
    assert (low / found.values[at], high / found.values[at]) == pytest.approx(
        tuple(np.sqrt(freedom / chdtri(freedom, [0.025, 0.975])))
    )
    assert high * low > found.values[at] ** 2  # it is skewed upwards
