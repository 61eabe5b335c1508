"""Tuning for adhesion and least phase: derivatives against differences, fronts against a grid of cars by `grip`."""

import re

import numpy as np
import pytest

from suspid import InputError, Suspension, grip, quarter_car, road, tune
from suspid.performance.figure_plan import plan_of
from suspid.performance.joined import joined
from suspid.performance.larger_better import small
from suspid.performance.road_response import exact_grid, grid_of
from validation.cars import FOUR_WHEELS, TWO_AXLES

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
BOUNDS = {"chassis.stiffness": (10e3, 60e3), "chassis.damping": (400.0, 4000.0)}
COMFORT = "chassis_acceleration.Wk"


def gripped(car: Suspension) -> dict[str, float]:
    found = grip(car)
    return {"tire.adhesion": float(found.adhesion[0]), "tire.phase": float(found.phase[0])}


def changed(k: float, c: float) -> Suspension:
    return CAR.with_parameters(stiffness={"chassis": k}, damping={"chassis": c})


class TestDerivatives:
    @pytest.mark.parametrize(
        ("car", "names", "owner"),
        [
            (CAR, ("tire.adhesion", "chassis_acceleration.Wk", "tire.phase"), "chassis"),
            (changed(22e3, 9000.0), ("tire.phase",), "chassis"),  # met at the resonance of the wheel
            (TWO_AXLES, ("front.adhesion", "rear.phase"), "front"),
            (FOUR_WHEELS, ("front_left.adhesion", "front_left.phase"), "front_left"),
        ],
        ids=["quarter car", "strong damper", "two axles", "four wheels"],
    )
    def test_equal_differences(self, car: Suspension, names: tuple[str, ...], owner: str) -> None:
        asked = joined(plan_of(car, road("C", speed=20.0, under=car), duration=3600.0), names)
        parameters = [f"{owner}.stiffness", f"{owner}.damping"]
        strut = next(s for s in car.struts if s.name == owner)

        def at(one: Suspension, by: list[str]) -> tuple[np.ndarray, np.ndarray]:
            return asked.values(one, by, lambda other: exact_grid(other, asked.plan.signals, asked.plan.road))

        slopes = at(car, parameters)[1]
        for column, quantity in enumerate(("stiffness", "damping")):
            step = 1e-4 * getattr(strut, quantity)
            ends = [
                at(car.with_parameters(**{quantity: {owner: getattr(strut, quantity) + side * step}}), [])[0]
                for side in (-1, 1)
            ]
            np.testing.assert_allclose(slopes[:, column], (ends[1] - ends[0]) / (2 * step), rtol=2e-5)

    def test_of_what_is_small(self) -> None:
        names, at = ("tire.adhesion", "tire.phase", "tire.load"), np.array([0.6, 0.5, 900.0])
        for i in range(3):
            step = np.eye(3)[i] * 1e-6
            difference = (small(names, at + step)[0] - small(names, at - step)[0])[i] / 2e-6
            assert small(names, at)[1][i] == pytest.approx(difference, rel=1e-6)


class TestFronts:
    @pytest.mark.parametrize("figure", ["tire.adhesion", pytest.param("tire.phase", marks=pytest.mark.slow)])
    def test_no_car_of_a_grid_beats_it(self, figure: str) -> None:
        found = tune(CAR, objective=(COMFORT, figure), road="C", speed=20.0, bounds=BOUNDS, points=5)
        assert np.all(np.diff(found.values, axis=0) > 0)  # what is more grip costs comfort
        for car, values in zip(found.cars, found.values, strict=True):
            assert values[1] == pytest.approx(gripped(car)[figure], rel=1e-6)
        made = road("C", speed=20.0, under=CAR)
        plan = plan_of(CAR, made, duration=3600.0).only([COMFORT])
        fine = grid_of(plan.signals, made, 2)
        cars = [changed(k, c) for k in np.geomspace(10e3, 60e3, 6) for c in np.geomspace(400, 4000, 9)]
        pairs = np.array([(plan.values(car, grid=fine)[0][0], gripped(car)[figure]) for car in cars])
        for comfort, level in found.values:
            assert np.all(pairs[pairs[:, 1] > level * (1 + 1e-3), 0] > comfort * (1 - 1e-3))

    def test_the_largest_of_one(self) -> None:
        found = tune(CAR, objective="tire.phase", road="C", speed=20.0, bounds=BOUNDS)
        # Of soft springs it is largest, and the grid has the softest.
        grid = [gripped(changed(1e4, c))["tire.phase"] for c in np.geomspace(700, 1300, 15)]
        assert found.choices[0, 0] == pytest.approx(1e4)
        assert max(grid) <= found.values[0, 0] * (1 + 1e-6)
        assert max(grid) == pytest.approx(found.values[0, 0], rel=5e-3)  # at a kink between two dampers

    def test_least_values_hold_and_bind(self) -> None:
        """The most comfortable car is soft; EGEA's 35 deg on a stiff spring ask for a damper."""
        request = {"parameters": ["chassis.damping"], "objective": COMFORT, "road": "C", "speed": 20.0}
        free = tune(CAR, **request)  # type: ignore[arg-type]
        limit = float(np.radians(35))
        held = tune(CAR, constraints={"tire.phase": limit, "tire.adhesion": 0.1}, **request)  # type: ignore[arg-type]
        assert gripped(free.cars[0])["tire.phase"] < limit
        assert gripped(held.cars[0])["tire.phase"] == pytest.approx(limit, rel=3e-4)
        assert held.values[0, 0] > free.values[0, 0]

    def test_a_margin_lies_below_what_is_to_be_large(self) -> None:
        request = {"parameters": ["chassis.damping"], "objective": "tire.adhesion", "road": "C", "speed": 20.0}
        request |= {"bounds": {"chassis.damping": (1300.0, 1300.1)}, "nominal_std": {"tire.stiffness": 0.05}}
        plain, robust = tune(CAR, **request), tune(CAR, robust=2.0, **request)  # type: ignore[arg-type]
        band = grip(CAR, nominal_std={"tire.stiffness": 0.05})
        low, high = band.interval()["tire.adhesion"]
        assert plain.values[0, 0] - robust.values[0, 0] == pytest.approx((high - low) / 1.96, rel=0.05)
        assert "mean - 2 sd" in robust.heading(0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"objective": "tyre.adhesion"}, "there is no figure 'tyre.adhesion'"),
        ({"objective": "tire.phase + tire.adhesion"}, "ask for one wheel, and limit the others"),
        ({"constraints": {"tire.phase": 35.0}}, "35 deg are 0.611"),
        ({"constraints": {"tire.adhesion": 60.0}}, "60 % are 0.6"),
        ({"constraints": {"tire.adhesion": 0.99}}, "meets the constraints tire.adhesion >= 0.99"),
    ],
)  # fmt: skip
def test_wrong_requests_say_what_to_write(given: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        tune(CAR, **{"road": "C", "speed": 20.0, "objective": COMFORT, **given})  # type: ignore[arg-type]
