"""The report on estimates: its motion and its bounds obey laws, and agree with other ways to compute them."""

from dataclasses import replace

import numpy as np
import pytest

from suspid import Suspension, eigenmodes, simulate, statespace
from suspid.units import RealArray
from validation.greybox_bounds import given_bound, time_bound, transfer_of
from validation.greybox_rows import FULL, MOUNTED, QUARTER, parameters
from validation.motion import STEP, Drive, driven, integrated, road_heights
from validation.springs import physical_bound
from validation.tyre_bounds import Asked, modes_of, responses, tire_bound


@pytest.mark.parametrize("car", [QUARTER, MOUNTED], ids=["plain", "mounted"])
def test_its_motion_is_that_of_simulate(car: Suspension) -> None:
    t = STEP / 2 * np.arange(8001)
    inputs = np.zeros((4, len(t)))
    inputs[0], inputs[1] = 0.01 * np.sin(30 * t), 0.3 * np.cos(30 * t)
    found = integrated(car, inputs, np.zeros(4 + (car is MOUNTED)), keep=1)[1]
    expected = simulate(
        car, t[::2], {"road": inputs[0, ::2]}, outputs=["chassis_acceleration", "tire_acceleration"],
        interpolation="cubic",
    ).y  # fmt: skip
    # A method of fourth order in steps of 0.5 ms, of motions up to 770 rad/s.
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_its_transfer_function_is_that_of_the_state_space() -> None:
    names = list(FULL.masses)
    s = 2j * np.pi * np.array([1.0, 8.0])
    T = transfer_of(np.eye(3).tolist(), [0, 1, 2], [3, 4, 5, 6])(FULL, s)
    for k, one in enumerate(s):
        by_road = np.asarray(statespace(FULL, road_rate=False)(one, squeeze=False))
        np.testing.assert_allclose(T[k] @ by_road[3:], by_road[:3], rtol=1e-9)
    assert names[:3] == ["heave", "pitch", "roll"]


def test_the_bound_of_a_decay_is_that_of_exact_sensitivities() -> None:
    still, first, std = np.zeros((4, 20001)), np.array([0.0, 0.0, 0.0, 1.0]), np.array([2e-4, 5e-4])

    def outputs(car: Suspension) -> RealArray:
        return integrated(car, still, first, keep=10)[0]

    units = np.array([integrated(QUARTER, still, unit, keep=10)[0] for unit in np.eye(4)])
    found = time_bound(outputs, QUARTER, parameters(QUARTER), std=std, nuisance=units)
    exact = physical_bound(QUARTER, np.linspace(0, 5, 1001), initial_state={"v_tire": 1.0}, noise_std=std)
    # There no offset is unknown: it costs a few percent of a decay to rest.
    np.testing.assert_allclose(found, exact, rtol=0.05)
    assert np.all(found > 0.999 * exact)


def test_the_bound_falls_with_the_root_of_the_time() -> None:
    rng = np.random.default_rng(2)
    wheels = rng.standard_normal((1, 24000))

    def bound(count: int, unknown: tuple[str, ...] = ()) -> RealArray:
        return given_bound(
            transfer_of([[1.0]], [0], [1]),
            QUARTER,
            ["chassis.stiffness", "chassis.damping"],
            wheels=wheels[:, :count],
            rate=200.0,
            std_body=np.array([0.03]),
            std_wheels=np.array([0.1]),
            unknown=unknown,
        )

    np.testing.assert_allclose(bound(6000) / bound(24000), 2.0, rtol=0.1)
    # Delay and mount are nearly one thing: what tells them apart scatters more between stretches of noise.
    np.testing.assert_allclose(
        bound(6000, ("gains", "delays", "mounts")) / bound(24000, ("gains", "delays", "mounts")), 2.0, rtol=0.2
    )
    assert np.all(bound(6000, ("gains", "delays", "mounts")) > bound(6000))


def test_roads_have_the_density_of_their_class() -> None:
    from scipy.signal import welch

    distance = np.linspace(0, 10_000, 200_001)[:-1]
    n, density = welch(road_heights(distance, 64e-6, np.random.default_rng(3)), 20, nperseg=4096)
    use = (n > 0.1) & (n < 2)
    assert np.mean(density[use] / (64e-6 * (n[use] / 0.1) ** -2.0)) == pytest.approx(1, abs=0.05)


def test_a_late_sensor_is_late_and_a_rear_axle_follows() -> None:
    drive = Drive(duration=10.0, spread=0.0, delay={"tire_acceleration": 0.01})
    late, _ = driven(QUARTER, drive, np.random.default_rng(4))
    true, _ = driven(QUARTER, Drive(duration=10.0, spread=0.0), np.random.default_rng(4))
    np.testing.assert_allclose(late["tire_acceleration"][2:], true["tire_acceleration"][:-2], atol=1e-9)
    np.testing.assert_array_equal(late["chassis_acceleration"], true["chassis_acceleration"])


def test_the_transfers_of_the_bound_of_tires_are_those_of_the_state_space() -> None:
    f = np.array([1.0, 4.0, 11.0])
    found = responses(f, np.array([1.0, 1, 1, 1, 1, 1, 0, 0]))
    for row, s in zip(found, 2j * np.pi * f, strict=True):
        by_road = np.asarray(statespace(QUARTER, road_rate=False)(s, squeeze=False))[:2, 0]
        np.testing.assert_allclose(row, s**2 * by_road, rtol=1e-9)


def test_the_modes_of_the_bound_of_tires_are_those_of_the_state_space() -> None:
    modes = eigenmodes(QUARTER)
    expected = np.column_stack([modes.wn, modes.zeta]).ravel()
    np.testing.assert_allclose(np.exp(modes_of(np.array([1.0, 1, 1, 1, 1, 1, 0, 0]))), expected, rtol=1e-9)


def test_the_bound_of_tires_obeys_laws() -> None:
    exact = Asked(departure=1e-6, tire_damper_std=0.0, spread=0.0)
    one, four = tire_bound(exact), tire_bound(replace(exact, duration=4 * exact.duration))
    # Nothing is known of tire and wheel beforehand, so four times the drive halves the error.
    for name in ("kt/mu", "kt", "mu"):
        assert one[name] / four[name] == pytest.approx(2.0, rel=0.01)
    wheel = tire_bound(replace(exact, wheel_known=True))
    assert wheel["mu"] < 1e-4
    assert wheel["kt"] == pytest.approx(wheel["kt/mu"], rel=1e-3)
    # kt/mu and mu share what is known: whoever knows one of them knows the other better.
    assert wheel["kt"] < one["kt/mu"]
    assert tire_bound(replace(exact, departure=0.3))["kt"] > one["kt"]
