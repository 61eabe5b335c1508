"""A damper's curve for several roads: equal work by quadrature, limits, better than one rate, beside a simulation."""

import re

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from suspid import DamperTuning, InputError, quarter_car, ride, road, simulate, tune_damper
from suspid.words import Level
from suspid.words.tuning import DamperTuningCheck

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
ROADS = [("A", 30.0), ("C", 20.0), ("D", 14.0)]
LIMITS = {"chassis.travel": 0.018}


@pytest.fixture(scope="module")
def found() -> DamperTuning:
    return tune_damper(CAR, strut="chassis", roads=ROADS, objective="chassis_acceleration.Wk", constraints=LIMITS)


def test_the_rates_are_those_of_equal_work(found: DamperTuning) -> None:
    """The work of the curve's force over that of the velocity squared, by quadrature over a Gaussian velocity."""
    points = np.array(found.strut.curve)
    for rate, speed in zip(found.damping, found.velocity, strict=True):
        edges = points[np.abs(points[:, 0]) < 8 * speed, 0]
        work, _ = quad(
            lambda v, s=speed: np.interp(v, points[:, 0], points[:, 1]) * v * norm.pdf(v, scale=s),
            -8 * speed, 8 * speed, points=edges, limit=200,
        )  # fmt: skip
        # Beyond its last points a curve goes on straight, the interpolation does not.
        assert work / speed**2 == pytest.approx(rate, rel=2e-3)


def test_the_velocity_is_that_of_the_strut_and_has_no_weighting(found: DamperTuning) -> None:
    """By a sum over the spectrum of the road: density G (n / n0)^-2, n0 = .1 1/m."""
    hertz = np.geomspace(0.02, 300, 20_000)
    s = 2j * np.pi * hertz
    arms, road_arms = CAR.arms(CAR.coordinates), CAR.arms(CAR.roads)
    for (kind, speed), rate, velocity in zip(ROADS, found.damping.tolist(), found.velocity.tolist(), strict=True):
        car = CAR.with_parameters(damping={"chassis": rate})
        b = np.array([[one.stiffness] for one in car.struts]) + np.array([[one.damping] for one in car.struts]) * s
        D = np.einsum("ji,jf,jk->fik", arms, b, arms) + (s**2)[:, None, None] * car.M
        q = -np.linalg.solve(D, np.einsum("ji,jf,jr->fir", arms, b, road_arms))[:, :, 0]
        moved = arms[[one.name for one in car.struts].index("chassis")]
        density = {"A": 16e-6, "B": 64e-6, "C": 256e-6, "D": 1024e-6}[kind] * (hertz / speed / 0.1) ** -2 / speed
        power = np.abs(s * (q @ moved)) ** 2 * density
        assert velocity == pytest.approx(np.sqrt(np.trapezoid(power, hertz)), rel=5e-3)


def test_figures_are_those_of_these_rates(found: DamperTuning) -> None:
    for (kind, speed), rate, row in zip(ROADS, found.damping.tolist(), found.values, strict=True):
        car = CAR.with_parameters(damping={"chassis": rate})
        again = ride(car, road=kind, speed=speed)
        np.testing.assert_allclose(row, [again[name] for name in found.figures], rtol=1e-5)


def test_neighbouring_slopes_differ_by_no_more_than_a_factor_of_two(found: DamperTuning) -> None:
    slopes = np.divide(*np.diff(np.array(found.strut.curve), axis=0).T[::-1])
    assert np.exp(np.max(np.abs(np.diff(np.log(slopes))))) == pytest.approx(2.0, rel=1e-3)


def test_limits_hold_and_no_single_rate_is_as_good(found: DamperTuning) -> None:
    assert np.all(found.values[:, 1] <= 0.018 * 1.001)
    assert found.verdict.level is Level.SOUND
    # One rate for all roads must be as strong as the roughest asks for, which the smooth ones pay.
    assert found.single == pytest.approx(found.asked[2], rel=2e-3)
    assert found.gain[0] > 0.15
    assert np.all(found.values[:, 0] >= found.best[:, 0] * (1 - 1e-3))
    assert "one rate" in str(found)


@pytest.mark.slow
def test_beside_a_simulation_of_the_curve(found: DamperTuning) -> None:
    """Weighted acceleration and travel of the car with its curve, integrated exactly between its points."""
    t = np.arange(0, 20, 0.005)
    kind, speed = ROADS[1]
    heights = road(kind, speed=speed, under=CAR).heights(t, rng=np.random.default_rng(3))
    outputs = ["chassis_acceleration", "chassis_travel"]
    curved = ride(simulate(found.tuned, t, heights, outputs=outputs))
    equal = CAR.with_parameters(damping={"chassis": float(found.damping[1])})
    linear = ride(simulate(equal, t, heights, outputs=outputs))
    for name in ("chassis_acceleration.Wk", "chassis.travel"):
        assert curved[name] == pytest.approx(linear[name], rel=0.06)


def test_directions_share_the_work() -> None:
    one = tune_damper(CAR, strut="chassis", roads=ROADS[:1], objective="chassis_acceleration.Wk", rebound=3.0)
    forces = np.array(one.strut.curve)[:, 1]
    np.testing.assert_allclose(forces[::-1][: len(forces) // 2], -3 * forces[: len(forces) // 2])
    assert one.damping[0] == pytest.approx(one.asked[0], rel=0.02)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"strut": "chasis"}, "there is no strut 'chasis'"),
        ({"strut": "tire"}, "strut 'tire' is on the road"),
        ({"rebound": 1e9}, "from 0.1 to 10"),
        ({"roads": "C"}, "must be a list of pairs"),
        ({"roads": []}, "roads is empty"),
        ({"roads": ["C"]}, "must be a pair of class and speed"),
        ({"rebound": 0.0}, "positive ratio"),
        ({"rebound": "x"}, "positive ratio"),
        ({"bounds": (5.0, 2.0)}, "must be two numbers that ascend"),
        ({"bounds": (1e-300, 1e300)}, "must be two numbers that ascend"),
        ({"roads": [("C", "fast")]}, "speed = 'fast' is not a number"),
        ({"roads": [(1e300, 20.0)]}, "roughness=1e+300"),
        ({"duration": None}, "duration = None is not a number"),
        ({"objective": 5}, "must be the name of a figure"),
        ({"constraints": "chassis.travel"}, "must map figures"),
        ({"constraints": {"chassis.travel": 1e-4}}, "no damper rate within"),
        ({"objective": "chassis_acceleration.Wx"}, "there is no figure"),
    ],
)
def test_wrong_requests_are_refused(given: dict[str, object], message: str) -> None:
    request = {"strut": "chassis", "roads": ROADS[:1], "objective": "chassis_acceleration.Wk", **given}
    with pytest.raises(InputError, match=re.escape(message)):
        tune_damper(CAR, **request)  # type: ignore[arg-type]


@pytest.mark.parametrize(("bounds", "level"), [((2000.0, 4000.0), Level.NOTE), (None, Level.CARE)])
def test_a_bound_that_decides_is_said(bounds: tuple[float, float] | None, level: Level) -> None:
    """The least acceleration has a rate below both; a bound that nobody stated is a doubt."""
    car = CAR.with_parameters(damping={"chassis": 8000.0})
    found = tune_damper(car, strut="chassis", roads=ROADS[:1], objective="chassis_acceleration.Wk", bounds=bounds)
    assert (DamperTuningCheck.AT_BOUND, level) in [(one.remark.code, one.level) for one in found.verdict.checks]
