"""Poles that meet on the real axis: steps that lead there, and what is held there."""

import numpy as np
import pytest

from suspid.identification.division import _matched
from suspid.identification.poles import Poles

COUNT = 500


def poles(pairs: list[complex], reals: tuple[float, ...] = ()) -> Poles:
    return Poles(pairs=np.array(pairs, complex), reals=np.array(reals), nuisances=np.zeros(1))


@pytest.mark.parametrize(("imag", "step"), [(0.01, 0.03), (0.01, -0.006), (0.2, 0.01), (0.2, -0.09)])
def test_a_step_moves_the_square_of_the_imaginary_part_along_its_tangent(imag: float, step: float) -> None:
    moved = poles([-0.1 + 1j * imag]).moved_within(np.array([0.0, step]), COUNT).pairs[0]
    small = abs(step) <= 0.5 * imag
    expected = imag + step if small else np.sqrt(max(imag**2 + 2 * imag * step, 0.0))
    assert moved.imag == pytest.approx(max(expected, 0.00125))
    assert moved.real == -0.1


def test_a_pair_that_would_part_stays_where_it_meets_the_axis() -> None:
    """There its real part may change by half without changing the bound: a fit at the bound has an optimum."""
    held = poles([-0.1 + 0.02j]).moved_within(np.array([0.0, -0.5]), COUNT)
    assert held.pairs[0] == -0.1 + 0.00125j
    away = np.array([1.0, -1.0])
    assert held.pinned(away, COUNT) is not None
    np.testing.assert_array_equal(held.pinned(away, COUNT), [False, True])
    assert held.pinned(-away, COUNT) is None
    for real in (-0.07, -0.12):
        assert held.moved_within(np.array([real + 0.1, 0.0]), COUNT).pairs[0].imag == 0.00125
    # The slowest turn by less than the record tells.
    slow = poles([-1e-6 + 1e-4j]).moved_within(np.array([0.0, -1.0]), COUNT)
    assert slow.pairs[0].imag == pytest.approx(1e-3 / COUNT)
    np.testing.assert_array_equal(slow.pinned(away, COUNT), [False, True])


def test_a_step_to_the_axis_does_not_shorten_those_of_other_poles() -> None:
    """From near the axis a step in the imaginary part alone would be a hundred times as long as the pole."""
    both = poles([-0.1 + 0.002j, -0.05 + 0.4j])
    moved = both.moved_within(np.array([0.0, -10.0, 0.003, 0.02]), COUNT)
    assert moved.pairs[1] == pytest.approx(-0.047 + 0.42j)
    assert moved.pairs[0] == -0.1 + 0.00125j


@pytest.mark.parametrize(
    ("reals", "met"), [((), False), ((-0.1,), False), ((-0.1, -0.104), True), ((-0.1, -0.3, -0.106), False)]
)
def test_real_poles_meet_where_their_rates_are_one(reals: tuple[float, ...], met: bool) -> None:
    assert poles([-0.1 + 0.3j], reals).meet is met


def test_pairs_are_found_again_wherever_they_stand() -> None:
    pairs = np.array([-0.1 + 0.2j, -0.01 + 0.3j, -0.2 + 0.5j])
    more = np.array([-0.19 + 0.52j, -0.011 + 0.301j, -0.12 + 0.21j, -0.1 + 0.33j])
    places, left = _matched(pairs, more)
    assert (places.tolist(), left) == ([2, 1, 0], 3)
    # Distances count in decay rates: of two places between, the sharp one takes the nearer.
    places, left = _matched(np.array([-0.2 + 0.3j, -0.01 + 0.34j]), np.array([-0.02 + 0.33j, -0.01 + 0.35j, -0.9 + 1j]))
    assert (places.tolist(), left) == ([0, 1], 2)
