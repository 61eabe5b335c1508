"""Driven responses against exact solutions and independent integrators, and roads against ISO 8608."""

import re
from itertools import pairwise
from typing import Literal

import control
import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import InputError, RecordError, Suspension, add_noise, cut, quarter_car, road_profile, simulate, statespace
from suspid.records import inputs_of
from suspid.simulation import ROUGHNESS, recursion
from suspid.units import RealArray

# What is asked of an exact response, relative to its peak.
EXACT = 1e-9


def car(mount: float | None = None) -> Suspension:
    plain = quarter_car(
        chassis_mass=350,
        tire_mass=50,
        chassis_stiffness=22e3,
        tire_stiffness=210e3,
        chassis_damping=1300,
        tire_damping=80,
    )
    return plain if mount is None else plain.with_parameters(mount_stiffness={"chassis": mount})


OUTPUTS = ["chassis_acceleration", "tire_acceleration", "chassis_travel", "tire"]


def closeness(found: object, expected: object) -> float:
    a, b = np.asarray(found, float), np.asarray(expected, float)
    return float(np.max(np.abs(a - b) / np.max(np.abs(b), axis=1, keepdims=True)))


class TestExact:
    def test_straight_inputs_as_python_control(self) -> None:
        rng, t = np.random.default_rng(1), 0.005 * np.arange(3001)
        system = statespace(car(4e5), outputs=OUTPUTS, forces=["chassis", "chassis_travel"], roads=["road"])
        given = dict(zip(system.input_labels, rng.standard_normal((4, len(t))), strict=True))
        start = rng.standard_normal(system.nstates)
        expected = control.forced_response(system, t, np.array(list(given.values())), start).y
        assert closeness(simulate(system, t, given, initial_state=start, interpolation="linear").y, expected) < EXACT

    @pytest.mark.parametrize("mount", [None, 4e5])
    def test_the_end_of_a_long_record_on_a_ramp_to_fifty_digits(self, mount: float | None) -> None:
        count, step, rate = 200_001, 0.005, 0.03
        found = simulate(car(mount), step * np.arange(count), {"road": rate * step * np.arange(count)}).y
        for k in (1, 446, 447, 448, 100_000, count - 1):
            system = statespace(car(mount))
            n = system.nstates
            with mpmath.workdps(50):
                whole = mpmath.zeros(n + 2)
                whole[:n, :n] = mpmath.matrix(system.A.tolist())
                whole[:n, n], whole[:n, n + 1] = mpmath.matrix(system.B[:, 0]), mpmath.matrix(system.B[:, 1])
                whole[n, n + 1] = 1
                start = mpmath.matrix([0] * (n + 1) + [rate])
                end = mpmath.expm(whole * (mpmath.mpf(step) * k)) * start
            expected = np.array([float(x) for x in end])[:2]
            assert np.max(np.abs(found[:, k] - expected)) < EXACT * np.max(np.abs(expected)), k

    def test_random_roads_as_an_integrator_with_the_same_road(self) -> None:
        t = 0.005 * np.arange(400)
        road = road_profile(20 * t, roughness="B", rng=np.random.default_rng(2))
        found = simulate(car(4e5), t, {"road": road}, outputs=["chassis", "tire"], interpolation="linear").y
        system = statespace(car(4e5))
        state, states = np.zeros(5), [np.zeros(5)]
        for k in range(len(t) - 1):
            slope = (road[k + 1] - road[k]) / 0.005

            def motion(s: float, x: RealArray, k: int = k, slope: float = slope) -> RealArray:
                return np.asarray(system.A @ x + system.B @ [road[k] + slope * s, slope])

            state = solve_ivp(motion, (0, 0.005), state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
            states.append(state)
        assert closeness(found, np.transpose(states)[:2]) < EXACT

    @pytest.mark.parametrize(("interpolation", "order"), [("linear", 2), ("cubic", 4)])
    def test_smooth_roads_by_the_order_of_the_interpolation(self, interpolation: str, order: int) -> None:
        w, s = 2 * np.pi * 3.0, 2j * np.pi * 3.0
        system = statespace(car(), outputs=OUTPUTS)
        # Started in its steady state, the response is that of the frequency response from the first sample on.
        steady = np.linalg.solve(s * np.eye(4) - system.A, system.B @ [1, s])
        errors = []
        for count in (101, 201):
            t = np.linspace(0, 1, count)
            expected = np.real(np.asarray(system(s, squeeze=False)) @ [1, s] * np.exp(s * t)[:, None]).T
            found = simulate(
                system,
                t,
                {"road": np.cos(w * t)},
                initial_state=steady.real,
                interpolation=interpolation,  # type: ignore[arg-type]
            )
            errors.append(np.max(np.abs(found.y - expected)[[0, 2, 3]]))
        # The ends of the spline err more and fall faster.
        assert np.log2(errors[0] / errors[1]) > order - 0.1

    def test_cubic_motions_are_exact_on_cubics(self) -> None:
        t = 0.01 * np.arange(200)
        road = 0.02 * t**3 - 0.03 * t**2 + 0.01 * t
        found = simulate(car(), t, {"road": road}, outputs=OUTPUTS, interpolation="cubic").y
        system = statespace(car(), outputs=OUTPUTS)

        def motion(s: float, x: RealArray) -> RealArray:
            height, rate = 0.02 * s**3 - 0.03 * s**2 + 0.01 * s, 0.06 * s**2 - 0.06 * s + 0.01
            return np.asarray(system.A @ x + system.B @ [height, rate])

        states = solve_ivp(motion, (0, t[-1]), np.zeros(4), t_eval=t, method="DOP853", rtol=1e-12, atol=1e-15).y
        rates = 0.06 * t**2 - 0.06 * t + 0.01
        assert closeness(found, system.C @ states + system.D @ [road, rates]) < EXACT

    def test_a_sampled_road_moves_body_and_wheel_as_the_car_does(self) -> None:
        # 20 Hz at 200 Hz: what straight lines have at 180 and 220 Hz folds onto 20 Hz in step with the motion.
        w, t = 2 * np.pi * 20.0, 0.005 * np.arange(4000)
        shown = ["chassis_acceleration", "tire_acceleration"]
        body, wheel = statespace(car(), outputs=shown)(1j * w, squeeze=False) @ [1, 1j * w]

        def off(interpolation: Literal["linear", "cubic"] | None) -> float:
            made = simulate(car(), t, {"road": np.sin(w * t)}, outputs=shown, interpolation=interpolation)
            lines = np.squeeze(made.outputs)[:, 2000:] @ np.exp(-1j * w * t[2000:])
            return float(abs(lines[0] / lines[1] / (body / wheel) - 1))

        assert off(None) == off("cubic") < 5e-4
        assert off("linear") > 5e-3

    def test_steps_stay_straight(self) -> None:
        t = 0.01 * np.arange(300)
        how: tuple[Literal["linear"] | None, ...] = (None, "linear")
        for heights in (0.05 * (t > 1), 0.05 * ((t > 1) & (t < 1.02))):
            found = [simulate(car(), t, {"road": heights}, interpolation=one).y for one in how]
            assert np.array_equal(*found)


class TestUse:
    def test_work_of_a_force_is_the_energy_of_the_car(self) -> None:
        t = 0.001 * np.arange(2000)
        force = 500 * np.sin(7 * t) ** 2
        one = car().with_parameters(damping={"chassis": 0, "tire": 0})
        names = ["chassis", "tire", "chassis_velocity", "tire_velocity"]
        y = simulate(one, t, {"chassis_force": force}, outputs=names, interpolation="cubic").y
        energy = np.sum(np.diag(one.M)[:, None] * y[2:] ** 2, axis=0) / 2
        energy += np.einsum("it,ij,jt->t", y[:2], one.K, y[:2]) / 2
        power = force * y[2]
        work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * 0.001)])
        # The trapezium rule is off by the square of the step times the highest frequency.
        np.testing.assert_allclose(energy, work, atol=1e-4 * energy.max())

    def test_inputs_stay_with_the_record(self) -> None:
        t = 0.01 * np.arange(300)
        record = simulate(car(), t, {"road": np.sin(t), "tire_force": t}, outputs=["chassis"])
        assert record.input_labels == ["road", "tire_force"]
        part = add_noise(cut(record, start=1.0), snr_db=20, rng=np.random.default_rng(1))
        np.testing.assert_array_equal(inputs_of(part)["tire_force"], t[100:])

    def test_a_given_rate_is_an_input_of_its_own(self) -> None:
        t = 0.01 * np.arange(300)
        still = simulate(car(), t, {"road": 0 * t, "road_rate": np.ones(300)})
        assert np.max(np.abs(still.y)) > 1e-4

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"inputs": {"rod": np.zeros(10)}}, "there is no input 'rod'. Did you mean 'road'"),
            ({"inputs": {"road": np.zeros(9)}}, "input 'road' has shape (9,); there are 10 times"),
            ({"inputs": {"road": np.full(10, np.nan)}}, "input 'road' has 10 samples that are not finite"),
            ({"inputs": {"road_rate": np.zeros(10)}}, "input 'road_rate' needs 'road'"),
            ({"inputs": np.zeros(10)}, "inputs must map names of inputs to samples"),
            ({"interpolation": "spline"}, "it is 'linear' or 'cubic'"),
            ({"system": "car"}, "simulate needs a control.StateSpace or a Suspension, not str"),
            ({"system": statespace(car()), "outputs": ["tire"]}, "outputs are chosen for a suspension"),
            ({"initial_state": {"v_tyre": 1}}, "there is no state 'v_tyre'. Did you mean 'v_tire'"),
        ],
    )
    def test_wrong_requests_are_refused(self, given: dict[str, object], message: str) -> None:
        request = {"system": car(), "timepts": 0.01 * np.arange(10), "inputs": {"road": np.zeros(10)}, **given}
        with pytest.raises(InputError, match=re.escape(message)):
            simulate(**request)  # type: ignore[arg-type]

    @pytest.mark.parametrize("times", [[0.0], [0, 1, 2.5], [[0, 1]]])
    def test_irregular_times_are_refused(self, times: list[float]) -> None:
        with pytest.raises(RecordError):
            simulate(car(), times, {"road": np.zeros(len(times))})

    def test_an_unstable_response_beyond_all_floats_is_refused(self) -> None:
        system = control.ss([[50.0]], [[1.0]], [[1.0]], 0, inputs=["u"], outputs=["y"])
        with pytest.raises(InputError, match="the system is unstable: its response exceeds the largest float"):
            simulate(system, np.arange(0, 20, 0.01), {"u": np.ones(2000)})


class TestRoads:
    @pytest.mark.parametrize("exponent", [1.5, 2.0, 2.5])
    def test_variance_is_the_integral_of_the_density(self, exponent: float) -> None:
        low, high, rng = 0.05, 2.0, np.random.default_rng(4)
        roads = [
            road_profile(
                np.arange(0, 200, 0.1), roughness="C", exponent=exponent, wavelengths=(1 / high, 1 / low), rng=rng
            )
            for _ in range(100)
        ]
        w = exponent - 1
        expected = 256e-6 * 0.1**exponent * (low**-w - high**-w) / w
        # 100 roads of 200 m hold some 1000 periods of the longest wave: 5 % standard deviation.
        np.testing.assert_allclose(np.mean(np.square(roads)), expected, rtol=0.15)

    def test_each_class_is_twice_as_high_as_the_one_before(self) -> None:
        heights = [road_profile(np.arange(100.0), roughness=name, rng=np.random.default_rng(5)) for name in ROUGHNESS]
        for one, next_one in pairwise(heights):
            np.testing.assert_allclose(next_one, 2 * one, rtol=1e-9)
        assert ROUGHNESS["A"] == 16e-6

    def test_the_density_in_time_is_that_of_the_speed(self) -> None:
        from scipy.signal import welch

        speed, t = 20.0, 0.005 * np.arange(400_000)
        road = road_profile(speed * t, roughness=64e-6, wavelengths=(0.25, 100.0), rng=np.random.default_rng(6))
        f, density = welch(road, 200, nperseg=4096)
        use = (f > 1) & (f < 50)
        expected = 64e-6 * 0.1**2 * speed * f[use] ** -2.0
        ratio = density[use] / expected
        assert abs(np.mean(ratio) - 1) < 0.01
        slope = np.polyfit(np.log(f[use]), np.log(ratio), 1)[0]
        assert abs(slope) < 0.01

    def test_axles_follow_each_other_on_one_track(self) -> None:
        t = 0.01 * np.arange(2000)
        front, rear = road_profile(np.stack([10 * t, 10 * t - 2.5]), roughness="B", rng=np.random.default_rng(7))
        np.testing.assert_allclose(rear[25:], front[:-25], atol=1e-12)

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"roughness": "J"}, "is not a class of ISO 8608; give one of A, B, C"),
            ({"roughness": -1.0}, "must be G_d(n_0) in m3, 0 or a positive number"),
            ({"wavelengths": (10.0, 1.0)}, "the wavelengths ascend from 0"),
            ({"rng": 1}, "is not a random generator"),
            ({"distance": [np.nan]}, "distance must contain finite distances"),
            ({"distance": [0.0, 1e9]}, "at most 67108864 are made"),
        ],
    )
    def test_wrong_roads_are_refused(self, given: dict[str, object], message: str) -> None:
        request = {"distance": [0.0, 1.0], "roughness": "A", "rng": np.random.default_rng(1), **given}
        with pytest.raises(InputError, match=re.escape(message)):
            road_profile(**request)  # type: ignore[arg-type]


class TestRecursion:
    @pytest.mark.parametrize("count", [1, 2, 10, 17])
    def test_blocks_give_what_a_loop_gives(self, count: int) -> None:
        rng = np.random.default_rng(1)
        E, start = 0.5 * rng.standard_normal((3, 3)), rng.standard_normal((3, 2))
        forcing = rng.standard_normal((3, count, 2))
        states = [start]
        for k in range(count - 1):
            states.append(E @ states[-1] + forcing[:, k])
        np.testing.assert_allclose(recursion(E, forcing, start, count), np.stack(states, axis=1), atol=1e-12)
