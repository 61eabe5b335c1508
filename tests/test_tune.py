"""Tuning: a published optimum, fronts against a grid, constraints, robust choices."""

import re
from typing import ClassVar

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from suspid import InputError, quarter_car, ride, road, tune
from suspid.performance.figure_plan import plan_of
from suspid.performance.road_response import grid_of
from suspid.words import Level
from suspid.words.ride import TuningCheck
from validation.cars import TWO_AXLES

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
BOTH = ("chassis_acceleration.Wk", "tire.load")
STRUT = ("chassis.stiffness", "chassis.damping")


class TestPublished:
    @pytest.mark.parametrize("stiffness", [12e3, 22e3, 45e3])
    def test_damper_of_least_acceleration(self, stiffness: float) -> None:
        """Gobbi and Mastinu, J. Sound and Vibration 245 (2001) 457: c = k ((m_s + m_u) / k_t)^(1/2) on white slopes."""
        car = CAR.with_parameters(damping={"tire": 0.0}, stiffness={"chassis": stiffness})
        everywhere = road("C", speed=20.0, wavelengths=(1e-4, 1e6))
        found = tune(car, parameters=["chassis.damping"], objective="chassis_acceleration.rms", road=everywhere)
        assert found.choices[0, 0] == pytest.approx(stiffness * np.sqrt(400 / 210e3), rel=2e-3)

    def test_its_acceleration(self) -> None:
        """The variance there, from the same paper: S pi (k^2 (m_s + m_u) / c + k_t c) / m_s^2 with slope density S."""
        car = CAR.with_parameters(damping={"tire": 0.0})
        found = ride(car, road=road("C", speed=20.0, wavelengths=(1e-4, 1e6)))
        slope = (2 * np.pi * 0.1) ** 2 * 256e-6 * 20.0 / 2
        expected = slope / 2 * (22e3**2 * 400 / 1300 + 210e3 * 1300) / 350**2
        assert found["chassis_acceleration.rms"] ** 2 == pytest.approx(expected, rel=1e-3)


class TestFront:
    def test_no_car_of_a_grid_beats_it(self) -> None:
        bounds = {"chassis.stiffness": (10e3, 60e3), "chassis.damping": (400.0, 4000.0)}
        found = tune(CAR, parameters=STRUT, objective=BOTH, road="C", speed=20.0, bounds=bounds, points=9)
        assert found.verdict.level is Level.SOUND
        assert len(found.cars) == 9
        made = road("C", speed=20.0, under=CAR)
        plan = plan_of(CAR, made, duration=3600.0).only(BOTH)
        fine = grid_of(plan.signals, made, 64)
        grid = [
            plan.values(CAR.with_parameters(stiffness={"chassis": k}, damping={"chassis": c}), grid=fine)[0]
            for k in np.geomspace(10e3, 60e3, 16)
            for c in np.geomspace(400, 4000, 25)
        ]
        for one in found.values:
            beaten = np.all(np.array(grid) < one * (1 - 2e-4), axis=1)
            assert not np.any(beaten)
        # Between neighbours of a front that is complete there is no room for a better car of the grid.
        least = [min(f[1] for f in grid if f[0] <= top) for top in found.values[1:, 0]]
        assert np.all(found.values[1:, 1] <= np.array(least) * (1 + 1e-3))

    @pytest.mark.parametrize(("start", "tire_damping"), [(1300.0, 60.0), (20e3, 0.0)])
    def test_the_best_car_is_found_where_hardly_anything_damps(self, start: float, tire_damping: float) -> None:
        """Its resonance is sharper than that of the car the search begins at; beside exact spectra of each car."""
        car = CAR.with_parameters(stiffness={"chassis": 5e3}, damping={"chassis": start, "tire": tire_damping})

        def weighted_at(log_damping: float) -> float:
            other = car.with_parameters(damping={"chassis": float(np.exp(log_damping))})
            return ride(other, road="C", speed=20.0)["chassis_acceleration.Wk"]

        best = minimize_scalar(
            weighted_at, bounds=(np.log(50.0), np.log(500.0)), method="bounded", options={"xatol": 1e-4}
        )
        found = tune(
            car,
            parameters=["chassis.damping"],
            objective="chassis_acceleration.Wk",
            road="C",
            speed=20.0,
            bounds={"chassis.damping": (20.0, 25e3)},
        )
        assert found.values[0, 0] == pytest.approx(best.fun, rel=1e-5)
        assert found.choices[0, 0] == pytest.approx(np.exp(best.x), rel=0.01)

    def test_figures_are_those_of_the_cars(self) -> None:
        found = tune(CAR, parameters=STRUT, objective=BOTH, road="C", speed=20.0, points=3)
        for car, values in zip(found.cars, found.values, strict=True):
            again = ride(car, road="C", speed=20.0)
            np.testing.assert_allclose(values, [again[name] for name in BOTH], rtol=1e-6)
        assert 0 < found.knee < len(found.cars) - 1

    def test_constraints_hold(self) -> None:
        limits = {"chassis.travel": 0.012, "tire.load": 900.0}
        found = tune(CAR, parameters=STRUT, objective=BOTH, road="C", speed=20.0, points=4, constraints=limits)
        assert np.all(found.values[:, found.figures.index("chassis.travel")] <= 0.012 * (1 + 2e-4))
        assert np.all(found.values[:, 1] <= 900 * (1 + 2e-4))
        assert list(found.figures) == [*BOTH, "chassis.travel"]

    def test_one_objective(self) -> None:
        found = tune(CAR, parameters=STRUT, objective="tire.load", road="C", speed=20.0)
        assert len(found.cars) == 1
        assert found.values[0, 0] < found.present[0]

    def test_two_that_agree(self) -> None:
        found = tune(CAR, parameters=STRUT, objective=("tire.load", "tire.load_share"), road="C", speed=20.0)
        assert len(found.cars) == 1
        assert TuningCheck.ONE in [check.remark.code for check in found.verdict.checks]

    def test_groups_keep_their_ratio(self) -> None:
        found = tune(
            TWO_AXLES,
            parameters=[("front.damping", "rear.damping")],
            objective=("heave_acceleration.Wk", "front.load"),
            road="C",
            speed=20.0,
            points=3,
        )
        np.testing.assert_allclose(found.choices[:, 0] / found.choices[:, 1], 1350 / 1100)
        assert "front.damping" in found.to_pandas()


class TestRobust:
    REQUEST: ClassVar[dict[str, object]] = {
        "parameters": STRUT,
        "objective": BOTH,
        "road": "C",
        "speed": 20.0,
        "points": 3,
    }

    def test_nothing_uncertain_in_the_limit(self) -> None:
        plain = tune(CAR, **self.REQUEST)  # type: ignore[arg-type]
        sure = tune(CAR, robust=2.0, nominal_std={"chassis.mass": 1e-6}, **self.REQUEST)  # type: ignore[arg-type]
        np.testing.assert_allclose(sure.values, plain.values, rtol=1e-4)

    def test_the_margin_is_that_of_the_intervals(self) -> None:
        std = {"tire.stiffness": 0.02, "chassis.mass": 0.02}
        found = tune(CAR, robust=2.0, nominal_std=std, **self.REQUEST)  # type: ignore[arg-type]
        for car, values in zip(found.cars, found.values, strict=True):
            again = ride(car, road="C", speed=20.0, nominal_std=std)
            at = [again.figures.index(name) for name in BOTH]
            np.testing.assert_allclose(values, again.values[at] + 2 * again.std[at], rtol=2e-3)

    def test_the_best_damper_is_that_of_a_search_without_derivatives(self) -> None:
        """Mean and margin over cars one by one, each parameter at one standard deviation times the root of two."""
        tire, mass, reach = 0.2, 0.1, 3.0
        std = {"tire.stiffness": tire, "chassis.mass": mass}
        found = tune(
            CAR, parameters=["chassis.damping"], objective="tire.load", road="C", speed=20.0, robust=reach,
            nominal_std=std,
        )  # fmt: skip
        k, m = CAR.struts[[s.name for s in CAR.struts].index("tire")].stiffness, CAR.masses["chassis"]
        moves = np.sqrt(2) * np.array([1.0, -1.0])
        cars = [CAR.with_parameters(stiffness={"tire": k * factor}) for factor in np.exp(tire * moves)]
        cars += [CAR.with_parameters(masses={"chassis": m * factor}) for factor in np.exp(mass * moves)]

        def cost(logarithm: float) -> float:
            damping = {"chassis": float(np.exp(logarithm))}
            loads = [ride(car.with_parameters(damping=damping), road="C", speed=20.0)["tire.load"] for car in cars]
            return float(np.mean(loads) + reach * np.std(loads))

        best = minimize_scalar(
            cost, bounds=(float(np.log(400)), float(np.log(6000))), method="bounded", options={"xatol": 1e-4}
        )
        assert found.choices[0, 0] == pytest.approx(np.exp(best.x), rel=1e-3)
        assert found.values[0, 0] == pytest.approx(best.fun, rel=1e-6)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"parameters": "chassis.damping"}, "must be a sequence of names"),
        ({"parameters": ["chassis.mass"]}, "there is no spring or damper 'chassis.mass'"),
        ({"parameters": ["chassis.damping", ["chassis.damping"]]}, "is given twice"),
        ({"objective": ("tire.load",) * 2}, "two different ones"),
        ({"objective": "tire.laod"}, "there is no figure 'tire.laod'"),
        ({"constraints": {"chassis.travel": -1.0}}, "must be a positive number"),
        ({"constraints": {"chassis.travel": 1e-5}}, "no car within the bounds meets the constraints"),
        ({"bounds": {"tire.stiffness": (1.0, 2.0)}}, "is not chosen"),
        ({"bounds": {"chassis.damping": (2.0, 1.0)}}, "must be two numbers that ascend"),
        ({"bounds": {"chassis.damping": ("a", "b")}}, "must be two numbers that ascend"),
        ({"bounds": {"chassis.damping": (1.0,)}}, "must be two numbers that ascend"),
        ({"points": 1}, "two or more"),
        ({"points": 2.5}, "must be a whole number"),
        ({"objective": 5}, "must be one figure or two"),
        ({"parameters": [5]}, "must be a sequence of names"),
        ({"constraints": {"chassis.travel": True}}, "must be a positive number"),
        ({"robust": "x"}, "must be a number of standard deviations"),
        ({"robust": 1.0}, "nothing is uncertain"),
        ({"robust": -1.0}, "must be a number of standard deviations"),
    ],
)
def test_wrong_requests_are_refused(given: dict[str, object], message: str) -> None:
    request = {"parameters": STRUT, "objective": BOTH, "road": "C", "speed": 20.0, **given}
    with pytest.raises(InputError, match=re.escape(message)):
        tune(CAR, **request)  # type: ignore[arg-type]
