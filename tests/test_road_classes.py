"""Classes of measured roads: intervals, limits of what is a road, and the test of a bend."""

import numpy as np
import pytest
from scipy.stats import norm

from suspid import InputError, classify_road, road
from suspid.performance.road_lines import UNFOLDED, _fitted
from suspid.simulation import ROUGHNESS
from suspid.words.ride import RoadCheck

TIME = np.arange(0, 30, 0.005)


def test_ends_of_an_interval_are_quantiles_of_a_normal_law() -> None:
    """Of the exponent, and of the logarithm of the roughness."""
    found = classify_road(road("B", speed=20.0).record(TIME, rng=np.random.default_rng(1)), speed=20.0)
    ends = found.interval(0.9)
    std = np.sqrt(np.diag(found.covariance))
    assert norm.cdf((ends["exponent"][1] - found.exponent) / std[1]) == pytest.approx(0.95)
    assert norm.cdf(np.log(ends["roughness"][0] / found.roughness) / std[0]) == pytest.approx(0.05)


def test_classes_on_both_sides_of_a_limit_are_named() -> None:
    found = classify_road(road(32e-6, speed=20.0).record(TIME[:2000], rng=np.random.default_rng(2)), speed=20.0)
    below = norm.cdf(np.log(32e-6 / found.roughness) / np.sqrt(found.covariance[0, 0]))
    assert found.shares["A"] == pytest.approx(below)
    (check,) = [check for check in found.verdict.checks if check.remark.code is RoadCheck.BETWEEN]
    assert check.remark.numbers["names"] == ("A", "B")


@pytest.mark.parametrize(("factor", "doubted"), [(1.4, False), (3.0, True)])
def test_more_than_twice_the_roughest_class_is_no_road(factor: float, doubted: bool) -> None:
    made = road(factor * ROUGHNESS["H"], speed=20.0)
    found = classify_road(made.record(TIME, rng=np.random.default_rng(1)), speed=20.0)
    assert (RoadCheck.NO_ROAD in [doubt.code for doubt in found.verdict.doubts]) is doubted


@pytest.mark.parametrize(("exponent", "doubted"), [(1.5, False), (3.0, False), (5.0, True)])
def test_exponents_that_no_road_has_are_doubted(exponent: float, doubted: bool) -> None:
    made = road("B", speed=20.0, exponent=exponent)
    found = classify_road(made.record(TIME, rng=np.random.default_rng(1)), speed=20.0)
    assert (RoadCheck.NO_POWER_LAW in [doubt.code for doubt in found.verdict.doubts]) is doubted


WAVES = {
    "sine": 0.02 * np.sin(2 * np.pi * 1.5 * TIME),
    "sine in noise": 0.02 * np.sin(2 * np.pi * 1.5 * TIME) + 1e-4 * np.random.default_rng(1).normal(size=TIME.size),
    "sweep": 0.02 * np.sin(2 * np.pi * (0.5 * TIME + 0.1 * TIME**2)),
    "bump": 0.05 * np.exp(-(((TIME - 3) / 0.1) ** 2)),
}


@pytest.mark.parametrize("name", WAVES)
def test_heights_that_are_no_road_get_no_class(name: str) -> None:
    with pytest.raises(InputError, match="not .* a road.*(give|check)"):
        classify_road((TIME, WAVES[name]), speed=20.0)


@pytest.mark.parametrize("omega", [1.5, 5.0, 20.0, 130.3])
def test_no_length_of_a_sine_gets_a_class(omega: float) -> None:
    """One that ends within a period leaks into all lines of a record without a window."""
    with pytest.raises(InputError, match="waves of one length"):
        classify_road((TIME, np.sin(omega * TIME)), speed=20.0)


def test_the_length_of_a_sine_is_named() -> None:
    with pytest.raises(InputError, match=r"13\.3 m"):
        classify_road((TIME, WAVES["sine"]), speed=20.0)


def test_a_single_kerb_is_no_random_road() -> None:
    """A step has the mean spectrum of a road with the exponent 2, whose lines do not scatter as random ones do."""
    found = classify_road((TIME, np.where(TIME > 3, 0.05, 0.0)), speed=20.0)
    assert found.exponent == pytest.approx(2.0, abs=0.05)
    assert RoadCheck.ONE_EVENT in [doubt.code for doubt in found.verdict.doubts]


def test_scatter_of_random_roads_is_not_doubted() -> None:
    """On the shortest records, too, where the departure of 20 exponential lines varies most."""
    made = road("B", speed=20.0)
    for seed in range(40):
        record = made.record(np.arange(0, 14, 0.005), rng=np.random.default_rng(seed))
        found = classify_road(record, speed=20.0, wavelengths=(10.0, 100.0))
        assert RoadCheck.ONE_EVENT not in [doubt.code for doubt in found.verdict.doubts]


@pytest.mark.parametrize(("metres", "enough"), [(170, False), (280, True)])
def test_twenty_spectral_lines_are_needed(metres: float, enough: bool) -> None:
    """Between wavelengths of 10 and 100 m there are 0.09 lines for each metre of a road."""
    record = road("B", speed=20.0).record(np.arange(0, metres / 20.0, 0.005), rng=np.random.default_rng(1))
    if enough:
        assert classify_road(record, speed=20.0, wavelengths=(10.0, 100.0)).wavelengths[0] >= 10
    else:
        with pytest.raises(InputError, match=r"too short.*15 spectral lines"):
            classify_road(record, speed=20.0, wavelengths=(10.0, 100.0))


def test_at_a_changing_speed_waves_are_those_that_the_widest_spacing_holds() -> None:
    """Shorter ones would fold where the car is fastest."""
    pace = 15 + 10 * np.sin(2 * np.pi * TIME / 30)
    record = road("B", speed=20.0).record(TIME, rng=np.random.default_rng(3), speed=pace)
    # Of the shares of half the sampling rate that are tried, one is that of the fastest stretch.
    share = 2 * np.max(pace) * 0.005 / classify_road(record, speed=pace).wavelengths[0]
    assert np.min(np.abs(share / np.array(UNFOLDED) - 1)) < 0.01


def test_the_test_of_a_bend_has_two_degrees_of_freedom_less_than_pieces() -> None:
    """Lines of a straight spectrum are exponential: the mean of chi-square is its degrees of freedom."""
    rng, n = np.random.default_rng(1), np.arange(1, 161) / 100.0
    tests = [_fitted(n, rng.exponential(n**-2.0), np.ones(len(n)))[3] for _ in range(400)]
    freedom = tests[0][1]
    # Three standard errors and a half.
    assert np.mean([chi_square for chi_square, _ in tests]) == pytest.approx(
        freedom, abs=3.5 * np.sqrt(2 * freedom / 400)
    )
