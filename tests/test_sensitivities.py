"""Sensitivities: exact derivatives against finite differences, and laws of scaling."""

import numpy as np
import pytest

from suspid import InputError, Suspension, eigenmodes, grip, quarter_car, ride, sensitivities
from suspid.reconstruction import parameter_names, parameter_values
from validation.cars import FOUR_WHEELS, TWO_AXLES

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
MOUNTED = TWO_AXLES.with_parameters(mount_stiffness={"front": 4e5})
OVERDAMPED = CAR.with_parameters(damping={"chassis": 9000.0})


def changed(car: Suspension, name: str, factor: float) -> Suspension:
    owner, _, quantity = name.rpartition(".")
    value = parameter_values(car)[name] * factor
    return car.with_parameters(**{"masses" if quantity == "mass" else quantity: {owner: value}})


@pytest.mark.parametrize(
    "car",
    [CAR, MOUNTED, pytest.param(FOUR_WHEELS, marks=pytest.mark.slow), OVERDAMPED],
    ids=["quarter", "mounts", "full", "overdamped"],
)
def test_equal_finite_differences(car: Suspension) -> None:
    names = [name for name in parameter_names(car) if parameter_values(car)[name]]
    found = sensitivities(car, parameters=names, road="C", speed=20.0)
    h = 1e-5
    for p, name in enumerate(names):
        ends = []
        for factor in (1 - h, 1 + h):
            other = changed(car, name, factor)
            modes = eigenmodes(other)
            # Modes that are symmetric in the car differ by their frequency alone.
            poles = [value for pair in zip(modes.wn, modes.zeta, strict=True) for value in pair]
            ends.append(np.log(np.abs([*poles, *ride(other, road="C", speed=20.0).values])))
        expected = (ends[1] - ends[0]) / np.log((1 + h) / (1 - h))
        np.testing.assert_allclose(found.elasticity[:, p], expected, atol=2e-5, err_msg=name)


def test_the_same_car_twice_as_large() -> None:
    """All masses, springs and dampers by one factor move no mode and no acceleration; loads by that factor."""
    names = [name for name in parameter_names(CAR) if parameter_values(CAR)[name]]
    found = sensitivities(CAR, parameters=names, road="B", speed=20.0, bench=True)
    total = dict(zip(found.names, found.elasticity.sum(axis=1), strict=True))
    for name, value in total.items():
        assert value == pytest.approx(1.0 if name == "tire.load" else 0.0, abs=1e-9), name


@pytest.mark.parametrize("car", [CAR, MOUNTED], ids=["quarter", "mounts"])
def test_wheels_on_a_bench(car: Suspension) -> None:
    names = [name for name in parameter_names(car) if parameter_values(car)[name]]
    found = sensitivities(car, parameters=names, bench=True)
    use = [i for i, name in enumerate(found.names) if name.endswith((".adhesion", ".phase"))]
    h = 1e-4
    for p, name in enumerate(names):
        ends = [grip(changed(car, name, factor)) for factor in (1 - h, 1 + h)]
        logs = [np.log([*one.adhesion, *one.phase]) for one in ends]
        expected = (logs[1] - logs[0]) / np.log((1 + h) / (1 - h))
        np.testing.assert_allclose(found.elasticity[use, p], expected, atol=1e-5, err_msg=name)


def test_a_wheel_that_leaves_the_bench_has_no_relative_change() -> None:
    found = sensitivities(CAR.with_parameters(damping={"chassis": 200.0}), bench=True)
    at = found.names.index("tire.adhesion")
    assert found.values[at] == 0
    assert np.all(np.isnan(found.elasticity[at]))


def test_time_scales() -> None:
    """Springs by the square of a factor and dampers by it: frequencies by it, damping ratios stay."""
    names = ["chassis.stiffness", "tire.stiffness", "chassis.damping", "tire.damping"]
    found = sensitivities(CAR, parameters=names)
    together = found.elasticity @ [2, 2, 1, 1]
    np.testing.assert_allclose(together[0::2], 1.0, atol=1e-12)
    np.testing.assert_allclose(together[1::2], 0.0, atol=1e-12)


def test_a_car_without_dampers_has_no_relative_change_of_damping() -> None:
    found = sensitivities(CAR.with_parameters(damping={"chassis": 0.0, "tire": 0.0}))
    assert np.all(np.isnan(found.elasticity[1::2]))
    np.testing.assert_allclose(found.elasticity[0::2].sum(axis=1), 0.5)


def test_table() -> None:
    found = sensitivities(CAR, parameters=["chassis.damping"], road="C", speed=20.0)
    assert found.to_pandas().set_index("name").loc["mode 1.zeta", "chassis.damping"] == pytest.approx(1.0, abs=0.05)
    assert "chassis_acceleration.Wk" in str(found)


def test_values_have_their_units() -> None:
    """A phase in rad is not taken for one in degrees."""
    found = sensitivities(CAR, road="C", speed=20.0, bench=True)
    units = dict(zip(found.names, found.units, strict=True))
    wanted = ("mode 1.wn", "mode 1.zeta", "tire.load", "chassis.travel", "tire.adhesion", "tire.phase")
    assert [units[name] for name in wanted] == ["rad/s", "1", "N", "m", "1", "rad"]
    assert any("tire.phase" in line and " rad " in line for line in str(found).splitlines())


@pytest.mark.parametrize(
    ("name", "message"), [("chasis.damping", "there is no parameter 'chasis.damping'"), ("tire.damping", "is zero")]
)
def test_wrong_parameters_are_refused(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        sensitivities(CAR.with_parameters(damping={"tire": 0.0}), parameters=[name])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"parameters": "chassis.damping"}, "must be a list of names"),
        ({"parameters": []}, "must be a list of names"),
        ({"parameters": ["chassis.damping"] * 2}, "is named twice"),
        ({"speed": 20.0}, "need a road"),
        ({"road": "C", "speed": 20.0, "duration": -1.0}, "must be positive"),
        ({"car": "x.toml"}, "read_car"),
    ],
)
def test_wrong_requests_say_what_to_write(given: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        sensitivities(**{"car": CAR, **given})  # type: ignore[arg-type]
