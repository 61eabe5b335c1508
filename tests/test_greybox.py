"""Estimates in the time domain: laws of motion by an independent integrator, intervals that hold, honest refusals."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import binom

from suspid import (
    EstimationError,
    InputError,
    Level,
    RecordError,
    RecordTest,
    Strut,
    Suspension,
    add_noise,
    eigenmodes,
    estimate,
    free_decay,
    half_car,
    quarter_car,
    simulate,
)
from suspid.greybox.dynamics import plant_of, transition
from suspid.greybox.judgement import gains_off
from suspid.greybox.modal import modes_of
from suspid.greybox.whiteness import portmanteau, score_power
from suspid.reconstruction import parameter_names, parameter_vector
from suspid.units import ComplexArray, RealArray
from suspid.words import EstimateCheck

TIMES: RealArray = np.arange(0, 5, 0.005)
RIZOIT = Path("/work/shared/data/rizoit_seat3dof_sim")

# Two pairs of close modes: 1.26 and 1.33 Hz, 11.4 and 11.7 Hz, zeta 0.24 to 0.25.
HALF = half_car(
    chassis_mass=600, pitch_inertia=900, front_tire_mass=40, rear_tire_mass=40, cg_to_front=1.25, cg_to_rear=1.25,
    front_stiffness=20e3, rear_stiffness=22e3, front_tire_stiffness=190e3, rear_tire_stiffness=200e3,
    front_damping=1350, rear_damping=1450,
)  # fmt: skip
QUARTER = quarter_car(
    chassis_mass=350, tire_mass=45, chassis_stiffness=22e3, tire_stiffness=200e3, chassis_damping=1300, tire_damping=60
)
PAPER = quarter_car(
    seat_mass=200, chassis_mass=200, tire_mass=200,
    seat_stiffness=200e3, chassis_stiffness=400e3, tire_stiffness=800e3,
    seat_damping=300, chassis_damping=200, tire_damping=100,
)  # fmt: skip
KNOCK = {"v_front": 1.0, "v_rear": -0.5, "z_heave": 0.02, "v_pitch": 0.2}
TIRES = ("front_tire.damping", "rear_tire.damping")


def off(car: Suspension, factors: Sequence[float] = (0.7, 1.3)) -> Suspension:
    """Return the car with its k and c off, in turn."""
    names, count = [s.name for s in car.struts], len(car.struts)
    p = parameter_vector(car)[: 2 * count] * np.resize(factors, 2 * count)
    return car.with_parameters(
        stiffness=dict(zip(names, p[:count].tolist(), strict=True)),
        damping=dict(zip(names, p[count:].tolist(), strict=True)),
    )


def integrated(
    car: Suspension,
    times: RealArray,
    road: Callable[[float], tuple[float, float]],
    start: RealArray,
    force: Callable[[float], float] = lambda _: 0.0,
) -> tuple[RealArray, RealArray]:
    """Return displacements and accelerations (coordinate, sample) by SciPy; the force acts on the first coordinate."""
    M, C, K, Cr, Kr, n = car.M, car.C, car.K, car.C_road, car.K_road, len(car.coordinates)

    def acceleration(t: float, x: RealArray) -> RealArray:
        r, rate = road(t)
        pushed = np.zeros(n)
        pushed[0] = force(t)
        push = Kr[:, 0] * r + Cr[:, 0] * rate - K @ x[:n] - C @ x[n:] + pushed
        return np.asarray(push / np.diag(M))

    found = solve_ivp(
        lambda t, x: np.concatenate([x[n:], acceleration(t, x)]), (times[0], times[-1]), start, t_eval=times,
        method="DOP853", rtol=1e-12, atol=1e-14,
    )  # fmt: skip
    return found.y[:n], np.array([acceleration(t, x) for t, x in zip(times, found.y.T, strict=True)]).T


def still(_: float) -> tuple[float, float]:
    return 0.0, 0.0


def record_of(
    outputs: dict[str, RealArray], inputs: dict[str, RealArray] | None = None, times: RealArray = TIMES
) -> control.TimeResponseData:
    inputs = inputs or {}
    return control.TimeResponseData(
        time=times, outputs=np.array(list(outputs.values())), output_labels=list(outputs), issiso=False,
        inputs=np.array(list(inputs.values())) if inputs else None, input_labels=list(inputs) or None,
    )  # fmt: skip


def relative_errors(found: Suspension, car: Suspension) -> RealArray:
    p, q = parameter_vector(found), parameter_vector(car)
    return np.asarray(np.abs(p - q)[q > 0] / q[q > 0])


class TestDynamics:
    @pytest.mark.parametrize("mounts", [(), (1,), (2, 0)])
    def test_slopes_of_a_step_are_those_of_finite_differences(self, mounts: tuple[int, ...]) -> None:
        car, rows = PAPER.with_parameters(mount_stiffness={"seat": 4e5}), list(range(9 + len(mounts)))
        p = np.append(parameter_vector(car), np.full(len(mounts), 2e-3))
        forces = np.array([[1.0, 0.0, -1.0]])

        def step(q: RealArray) -> RealArray:
            made = transition(plant_of(car, q, rows, roads=[0], forces=forces, mounts=mounts), 0.01)
            return np.hstack([made.E, made.G])

        exact = transition(plant_of(car, p, rows, roads=[0], forces=forces, mounts=mounts), 0.01)
        for i in rows:
            move = np.zeros(len(p))
            move[i] = 1e-4 * p[i]
            slope = (step(p + move) - step(p - move)) / (2 * move[i])
            expected = np.hstack([exact.by_state[i], exact.by_input[i]])
            np.testing.assert_allclose(slope, expected, atol=1e-6 * np.abs(expected).max())

    @pytest.mark.parametrize("mounts", [(), (0,)])
    def test_modes_have_the_covariance_of_finite_differences(self, mounts: tuple[int, ...]) -> None:
        car, count = HALF, len(parameter_names(HALF))
        rows = [0, 1, 4, *range(count, count + len(mounts))]
        p = np.append(parameter_vector(car), np.full(len(mounts), 3e-3))

        def made(q: RealArray) -> Suspension:
            # A change of c at the same relaxation c / k_mount changes the mount.
            names = [s.name for s in car.struts]
            return car.with_parameters(
                stiffness=dict(zip(names, q[:4].tolist(), strict=True)),
                damping=dict(zip(names, q[4:8].tolist(), strict=True)),
                mount_stiffness={names[i]: q[4 + i] / q[count + j] for j, i in enumerate(mounts)},
            )

        covariance = np.diag((0.01 * p[rows]) ** 2)
        found, exact = modes_of(made(p), rows, covariance, mounts=mounts), eigenmodes(made(p))
        np.testing.assert_allclose(found.poles, exact.poles, rtol=1e-9)
        moved: list[ComplexArray] = []
        for row in rows:
            ends = []
            for sign in (1, -1):
                modes = eigenmodes(made(p * (1 + 1e-5 * sign * (np.arange(len(p)) == row))))
                assert modes.shapes is not None
                ends.append(np.concatenate([modes.poles, modes.shapes.T.ravel()]))
            moved.append((ends[0] - ends[1]) / 2e-5 * 0.01)
        parts = np.stack([np.stack([m.real, m.imag], axis=1).ravel() for m in moved])
        assert found.covariance is not None
        np.testing.assert_allclose(
            found.covariance, parts.T @ parts, rtol=1e-3, atol=1e-6 * float(np.max(np.abs(parts.T @ parts)))
        )


class TestFreeDecay:
    def test_an_exact_decay_of_close_modes_gives_the_car_exactly(self) -> None:
        start = np.array([0.02, 0.0, 0.0, 0.0, 0.0, 0.2, 1.0, -0.5])
        z, _ = integrated(HALF, TIMES, still, start)
        record = record_of(dict(zip(HALF.coordinates, z, strict=True)))
        found = estimate(record, off(HALF), fixed=TIRES)
        assert relative_errors(found.suspension, HALF).max() < 1e-8

    @pytest.mark.parametrize("factors", [(0.5, 1.5), (1.5, 0.5)])
    def test_light_damping_and_a_start_half_off(self, factors: Sequence[float]) -> None:
        record = free_decay(PAPER, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})
        found = estimate(record, off(PAPER, factors))
        assert relative_errors(found.suspension, PAPER).max() < 1e-7
        assert found.verdict.level is Level.SOUND

    def test_accelerations_and_travels_with_offsets(self) -> None:
        z, a = integrated(QUARTER, TIMES, still, np.array([0.02, 0.0, 0.0, 0.5]))
        record = record_of({"chassis_acceleration": a[0] + 0.3, "chassis_travel": z[0] - z[1] - 0.01})
        found = estimate(record, off(QUARTER))
        assert relative_errors(found.suspension, QUARTER).max() < 1e-7

    def test_close_modes_in_noise_are_never_lost_and_intervals_hold(self) -> None:
        record, seeds = free_decay(HALF, TIMES, initial_state=KNOCK), 12
        truth, holds = dict(zip(parameter_names(HALF), parameter_vector(HALF).tolist(), strict=True)), 0
        for seed in range(seeds):
            noisy = add_noise(record, snr_db=20.0, rng=np.random.default_rng(seed))
            found = estimate(noisy, off(HALF), fixed=TIRES)
            assert found.explains
            ends = found.interval(0.95)
            holds += sum(low <= truth[name] <= high for name, (low, high) in sorted(ends.items()))
        assert binom.ppf(1e-4, 6 * seeds, 0.95) <= holds

    def test_a_mount_is_found_and_would_do_harm(self) -> None:
        # A damper on a mount is a mass of next to nothing between them; SciPy integrates the equation of the damper.
        mount, k, c, kt, ct = 3e5, 22e3, 1300.0, 200e3, 60.0

        def slope(_: float, x: RealArray) -> RealArray:
            body, wheel, v_body, v_wheel, damper = x
            force = k * (body - wheel) + mount * (body - wheel - damper)
            return np.array([
                v_body, v_wheel, -force / 350, (force - kt * wheel - ct * v_wheel) / 45,
                mount / c * (body - wheel - damper),
            ])  # fmt: skip

        x = solve_ivp(
            slope, (0, TIMES[-1]), [0.02, 0.0, 0.0, 1.0, 0.02], t_eval=TIMES, method="DOP853", rtol=1e-12, atol=1e-14
        ).y  # fmt: skip
        record = record_of({"chassis": x[0], "tire": x[1]})
        found = estimate(record, off(QUARTER), mounts=["chassis"])
        assert found.parameters[-1] == "chassis.relaxation"
        assert found.values[-1] == pytest.approx(c / mount, rel=1e-5)
        assert relative_errors(found.suspension, QUARTER).max() < 1e-5
        assert found.suspension.struts[0].mount_stiffness == pytest.approx(mount, rel=1e-5)
        np.testing.assert_allclose(found.modes.poles, eigenmodes(found.suspension).poles, rtol=1e-9)
        noisy = add_noise(record, snr_db=40.0, rng=np.random.default_rng(1))
        assert not estimate(noisy, off(QUARTER), mounts=(), gains=(), delays=()).explains
        # Where nothing is asked the records need it.
        assert estimate(noisy, off(QUARTER)).parameters[-1] == "chassis.relaxation"
        ends = estimate(noisy, off(QUARTER), mounts=["chassis"]).interval(0.999)
        assert ends["chassis.relaxation"][0] < c / mount < ends["chassis.relaxation"][1] < 2 * c / mount
        # Known, it is held.
        known = estimate(noisy, off(QUARTER).with_parameters(mount_stiffness={"chassis": mount}))
        assert known.explains

    def test_gain_and_delay_of_channels_of_two_loggers(self) -> None:
        # Steps of 1 ms, of which the loggers take every fifth: the second one 4 ms late, and 5 % high at the rear.
        start = np.array([0.02, 0.0, 0.0, 0.0, 0.0, 0.2, 1.0, -0.5])
        z, a = integrated(HALF, np.arange(0, 4, 0.001), still, start)
        early, late = slice(10, None, 5), slice(6, -4, 5)
        outputs = {
            "heave": z[0, early], "pitch": z[1, early], "front_acceleration": a[2, late], "rear": 1.05 * z[3, late]
        }  # fmt: skip
        record = record_of(outputs, times=TIMES[: len(outputs["heave"])])
        sensors = {"gains": ["rear"], "delays": ["front_acceleration", "rear"]}
        found = estimate(record, off(HALF), fixed=TIRES, **sensors)  # type: ignore[arg-type]
        assert found.parameters[-3:] == ("rear.gain", "front_acceleration.delay", "rear.delay")
        np.testing.assert_allclose(found.values[-3:], [1.05, 0.004, 0.004], rtol=1e-5)
        assert relative_errors(found.suspension, HALF).max() < 1e-6
        noisy = add_noise(record, snr_db=30.0, rng=np.random.default_rng(1))
        assert not estimate(noisy, off(HALF), fixed=TIRES, gains=(), delays=(), mounts=()).explains
        needed = estimate(noisy, off(HALF), fixed=TIRES)
        assert needed.explains
        # Which sensors it is is a guess: 8 % of one do nearly as well as 5 % and 4 ms of two.
        assert needed.verdict.level is Level.CARE
        assert EstimateCheck.NEEDED in {check.remark.code for check in needed.verdict.checks}
        one = estimate(noisy, off(HALF), fixed=TIRES, **sensors)  # type: ignore[arg-type]
        assert one.explains
        ends, truth = one.interval(0.999), parameter_vector(HALF)
        for name, value in zip(parameter_names(HALF), truth, strict=True):
            assert name not in ends or ends[name][0] < value < ends[name][1]
        with pytest.raises(InputError, match="gains: of all channels together only ratios can be found"):
            estimate(noisy, off(HALF), fixed=TIRES, gains=list(outputs))

    def test_a_rigid_mount_is_none(self) -> None:
        noisy = add_noise(TestOptions.RECORD, snr_db=30.0, rng=np.random.default_rng(2))
        found = estimate(noisy, off(QUARTER), mounts=["chassis"])
        assert found.suspension.struts[0].mount_stiffness is None
        assert found.explains
        low, high = found.interval(0.999)["chassis.stiffness"]
        assert low < 22e3 < high < 1.1 * low
        with pytest.raises(InputError, match="mounts: 'chasis'.*Did you mean 'chassis'"):
            estimate(noisy, QUARTER, mounts=["chasis"])

    def test_tests_with_an_added_mass_give_the_masses(self) -> None:
        loaded = QUARTER.with_parameters(masses={"chassis": 425})
        records = [
            RecordTest(record=free_decay(QUARTER, TIMES, initial_state={"v_tire": 1.0})),
            RecordTest(record=free_decay(loaded, TIMES, initial_state={"v_tire": 1.0}), added_masses={"chassis": 75.0}),
        ]
        nominal = off(QUARTER).with_parameters(masses={"chassis": 300, "tire": 50})
        found = estimate(records, nominal, free_masses=["chassis", "tire"])
        assert relative_errors(found.suspension, QUARTER).max() < 1e-6

    def test_one_channel_lists_the_other_car_with_the_same_modes(self) -> None:
        record = free_decay(PAPER, np.arange(0, 10, 0.005), initial_state={"v_tire": 1.0})
        seat = record_of({"seat": np.asarray(record.y)[0]}, times=np.arange(0, 10, 0.005))
        found = estimate(add_noise(seat, snr_db=20.0, rng=np.random.default_rng(1)), off(PAPER, (0.9, 1.1)))
        assert found.alternatives
        assert EstimateCheck.ALTERNATIVES in {check.remark.code for check in found.verdict.checks}


class TestGivenRoad:
    def test_a_swept_road(self) -> None:
        times = np.arange(0, 6, 0.004)

        def road(t: float) -> tuple[float, float]:
            phase = 2 * np.pi * (0.5 * t + 1.2 * t**2)
            return 0.01 * np.sin(phase), 0.01 * np.cos(phase) * 2 * np.pi * (0.5 + 2.4 * t)

        z, _ = integrated(QUARTER, times, road, np.array([0.01, 0.02, 0.0, 0.1]))
        heights = np.array([road(t)[0] for t in times])
        record = record_of({"chassis": z[0], "tire": z[1]}, {"road": heights}, times)
        high = record_of({"chassis": z[0], "tire": 1.1 * z[1]}, {"road": heights}, times)
        assert estimate(high, off(QUARTER), given=("road",), gains=["tire"]).values[-1] == pytest.approx(1.1, rel=1e-4)
        found = estimate(record, off(QUARTER), given=("road",))
        # A cubic spline follows 30 Hz at 250 Hz to 1e-3, and 15 Hz to 5e-5.
        assert relative_errors(found.suspension, QUARTER).max() < 1e-3
        assert relative_errors(found.suspension, QUARTER)[:2].max() < 1e-4

    def test_a_stepped_road_is_held(self) -> None:
        # A step of the road is a start with all displacements less, and its knock through the tire's damper.
        step, n = 0.03, 400
        knock = QUARTER.struts[1].damping * step / QUARTER.masses["tire"]
        z, _ = integrated(QUARTER, TIMES[: len(TIMES) - n], still, np.array([-step, -step, 0.0, knock]))
        whole = np.hstack([np.zeros((2, n)), z + step])
        road = np.where(np.arange(len(TIMES)) < n, 0.0, step)
        record = record_of({"chassis": whole[0], "tire": whole[1]}, {"road": road})
        found = estimate(record, off(QUARTER), given=("road",))
        assert relative_errors(found.suspension, QUARTER).max() < 1e-7

    def test_a_given_force_gives_the_masses_too(self) -> None:
        def force(t: float) -> float:
            return float(500 * np.sin(2 * np.pi * (0.4 * t + 0.6 * t**2)))

        z, _ = integrated(QUARTER, TIMES, still, np.zeros(4), force)
        record = record_of({"chassis": z[0], "tire": z[1]}, {"chassis_force": np.array([force(t) for t in TIMES])})
        nominal = off(QUARTER).with_parameters(masses={"chassis": 300, "tire": 55})
        found = estimate(record, nominal, given=("chassis_force",), free_masses=["chassis", "tire"])
        assert relative_errors(found.suspension, QUARTER).max() < 1e-4
        assert EstimateCheck.SCALE in {check.remark.code for check in found.verdict.checks}

    def test_units_behind_names_are_obeyed(self) -> None:
        def force(t: float) -> float:
            return float(500 * np.sin(2 * np.pi * (0.4 * t + 0.6 * t**2)))

        z, _ = integrated(QUARTER, TIMES, still, np.zeros(4), force)
        kilonewtons = 1e-3 * np.array([force(t) for t in TIMES])
        record = record_of({"chassis_force [kN]": kilonewtons, "chassis [mm]": 1e3 * z[0], "tire (cm)": 1e2 * z[1]})
        found = estimate(record, off(QUARTER), given=("chassis_force",))
        assert relative_errors(found.suspension, QUARTER).max() < 1e-4

    def test_a_fit_under_another_motion_between_samples_is_no_other_car(self) -> None:
        """The force moves on straight lines; fits by a cubic spline lie a hundredth and more away, in one place."""
        times, knots = np.arange(0, 10, 0.005), np.arange(0, 11, 0.06)
        push = 300 * np.interp(times, knots, np.random.default_rng(5).standard_normal(len(knots)))
        outputs, given = ["chassis_acceleration", "tire_acceleration"], ("chassis_force",)
        record = simulate(QUARTER, times, {"chassis_force": push}, outputs=outputs, interpolation="linear")
        for seed in (24, 25, 26, 27):
            noisy = add_noise(record, snr_db=20, rng=np.random.default_rng(seed))
            assert not estimate(noisy, off(QUARTER), given=given).alternatives

    @pytest.mark.skipif(not RIZOIT.exists(), reason="the records of an independent simulator are not here")
    def test_chirp_step_and_release_of_an_independent_simulator(self) -> None:
        car = quarter_car(
            seat_mass=88, chassis_mass=270, tire_mass=60, seat_stiffness=16e3, chassis_stiffness=27e3,
            tire_stiffness=200e3, seat_damping=500, chassis_damping=2000, tire_damping=0,
        )  # fmt: skip
        records = []
        for name in ("chirp", "step50mm", "release"):
            table = np.genfromtxt(RIZOIT / f"{name}.csv", delimiter=",", names=True)[::2]
            motions = {"seat": table["z_seat_m"], "chassis": table["z_body_m"], "tire": table["z_wheel_m"]}
            records.append(record_of(motions, {"road": table["z_road_m"]}, table["t_s"]))
        found = estimate(records, off(car), given=("road",), fixed=["tire.damping"])
        errors = relative_errors(found.suspension, car)
        assert errors[:3].max() < 1e-4
        assert errors[3:5].max() < 1e-3


class TestOptions:
    RECORD = free_decay(QUARTER, TIMES, initial_state={"v_tire": 1.0, "z_chassis": 0.02})

    def test_what_is_held_tied_and_bounded(self) -> None:
        nominal = off(QUARTER, (1.0, 1.0, 0.8))
        held = estimate(self.RECORD, nominal, fixed=["tire.damping", "tire.stiffness"])
        assert held.held == ("tire.stiffness", "tire.damping")
        assert held.suspension.struts[1] == nominal.struts[1]
        bounded = estimate(self.RECORD, nominal, bounds={"tire.stiffness": (None, 190e3)})
        assert bounded.suspension.struts[1].stiffness == pytest.approx(190e3)
        assert EstimateCheck.AT_BOUND in {check.remark.code for check in bounded.verdict.checks}
        tied = estimate(
            free_decay(HALF, TIMES, initial_state=KNOCK), off(HALF), fixed=TIRES,
            ties=[("front.stiffness", "rear.stiffness")],
        ).suspension  # fmt: skip
        assert tied.struts[0].stiffness == tied.struts[1].stiffness

    def test_a_mass_known_to_a_share_widens_in_proportion(self) -> None:
        # One common error of both masses is an error of all springs and dampers by the same share.
        noisy = add_noise(self.RECORD, snr_db=60.0, rng=np.random.default_rng(2))
        found = estimate(noisy, off(QUARTER), nominal_std={"chassis.mass": 0.02, "tire.mass": 0.5})
        spread = dict(zip(found.parameters, found.std / found.values, strict=True))
        assert spread["chassis.stiffness"] == pytest.approx(0.02, rel=0.05)
        assert spread["chassis.damping"] == pytest.approx(0.02, rel=0.05)

    @pytest.mark.parametrize("setting", [{"band_hz": (1.0, 5.0)}, {"stretch": 2.0}])
    def test_what_belongs_to_measured_motion_is_refused_for_decays(self, setting: dict[str, Any]) -> None:
        with pytest.raises(InputError, match=f"{next(iter(setting))} does not apply here"):
            estimate(self.RECORD, QUARTER, **setting)

    def test_masses_alone_cannot_be_found(self) -> None:
        with pytest.raises(EstimationError, match=r"ratios to a known mass") as refused:
            estimate(self.RECORD, off(QUARTER), free_masses=["chassis", "tire"])
        assert isinstance(refused.value.best, Suspension)
        for name in ("chassis.stiffness", "tire.mass"):
            assert name in str(refused.value)
        # All forces and masses times one factor move nothing.
        shares = re.findall(r"(?:stiffness|damping|mass) ([+-]\d+) %", str(refused.value))
        assert len(shares) >= 5
        assert {abs(int(share) - 100) <= 1 for share in shares} == {True}

    def test_channels_that_do_not_see_a_damper_say_so(self) -> None:
        legs = [
            Strut(name=side, stiffness=1e4, damping=100.0, arms={side: 1.0, "ground": -1.0})
            for side in ("left", "right")
        ]
        twin = Suspension(masses={"left": 100.0, "right": 100.0}, struts=legs)
        record = free_decay(twin, TIMES, initial_state={"v_left": 1.0, "v_right": 1.0})
        with pytest.raises(EstimationError, match=r"do not determine right\.stiffness, right\.damping") as refused:
            estimate(record_of({"left": np.asarray(record.y)[0]}), twin)
        assert "left.stiffness" not in str(refused.value)

    def test_names_that_mean_nothing(self) -> None:
        with pytest.raises(InputError, match="Did you mean 'road'"):
            estimate(self.RECORD, QUARTER, given=("raod",))
        with pytest.raises(InputError, match="no input or channel 'road'"):
            estimate(self.RECORD, QUARTER, given=("road",))
        with pytest.raises(RecordError, match="measures the suspension"):
            estimate(record_of({"x": np.ones(1000)}), QUARTER)
        with pytest.raises(InputError, match="delays: of all channels together only differences"):
            estimate(self.RECORD, QUARTER, delays=["chassis", "tire"])
        with pytest.raises(InputError, match="gains: 'tyre' is not one of those.*Did you mean 'tire'"):
            estimate(self.RECORD, QUARTER, gains=["tyre"])
        with pytest.raises(InputError, match="needs a Suspension"):
            estimate(self.RECORD, eigenmodes(QUARTER))  # type: ignore[arg-type]


class TestJudgement:
    def test_a_topology_that_lacks_a_mass_is_told(self) -> None:
        record = free_decay(PAPER, np.arange(0, 5, 0.005), initial_state={"v_tire": 1.0})
        two = quarter_car(
            chassis_mass=400, tire_mass=200, chassis_stiffness=400e3, tire_stiffness=800e3, chassis_damping=200,
        )  # fmt: skip
        part = record_of({"chassis": np.asarray(record.y)[1], "tire": np.asarray(record.y)[2]})
        found = estimate(add_noise(part, snr_db=30.0, rng=np.random.default_rng(1)), two)
        assert not found.explains
        assert found.verdict.level is Level.DOUBTFUL

    @pytest.mark.parametrize(
        ("factor", "level"), [(1.0, Level.SOUND), (1.003, Level.CARE), (1.01, Level.CARE), (1.1, Level.DOUBTFUL)]
    )
    def test_records_of_two_cars_are_told(self, factor: float, level: Level) -> None:
        """Springs that differ by 0.3 % are three standard deviations apart; the joint residual is white there."""
        other = QUARTER.with_parameters(stiffness={"chassis": 22e3 * factor})
        decays = [free_decay(car, TIMES, initial_state={"v_tire": 1.0}) for car in (QUARTER, other)]
        records = [add_noise(one, snr_db=40.0, rng=np.random.default_rng(i)) for i, one in enumerate(decays)]
        found = estimate(records, QUARTER.with_parameters(damping={"chassis": 1100}))
        said = [one for one in found.verdict.checks if one.remark.code is EstimateCheck.NOT_ONE_CAR]
        assert found.verdict.level is level
        assert [one.level for one in said] == [level] * (factor > 1)
        assert all(one.remark.numbers["name"] == "chassis.stiffness" for one in said)

    def test_records_of_one_simulated_car_are_of_one_car_however_exact(self) -> None:
        """At 160 dB 1e-6 of a spring, as steps of simulations make it, is told and no other car."""
        other = QUARTER.with_parameters(stiffness={"chassis": 22e3 * (1 + 1e-6)})
        decays = [free_decay(car, TIMES, initial_state={"v_tire": 1.0}) for car in (QUARTER, other)]
        records = [add_noise(one, snr_db=160.0, rng=np.random.default_rng(i)) for i, one in enumerate(decays)]
        found = estimate(records, QUARTER.with_parameters(damping={"chassis": 1100}))
        assert EstimateCheck.NOT_ONE_CAR not in [one.remark.code for one in found.verdict.checks]
        assert found.verdict.level is Level.SOUND

    def test_a_gain_that_no_calibrated_sensor_has_calls_for_care(self) -> None:
        """1.12 ± 0.003 is one, 1.12 ± 0.03 may be 1.05."""
        names, values = ("a.damping", "a.gain", "b.gain"), np.array([9.0, 1.12, 1.05])
        for std, odd in ((0.003, True), (0.03, False)):
            checks = list(gains_off(names, values, np.full(3, std)))
            assert [(one.remark.code, one.level) for one in checks] == [(EstimateCheck.MISCALIBRATED, Level.CARE)] * odd
            assert all(one.remark.numbers["names"] == ("a.gain = 1.12",) for one in checks)

    @pytest.mark.parametrize(
        ("lacking", "level"),
        [pytest.param(True, Level.DOUBTFUL, marks=pytest.mark.slow), (False, Level.CARE)],
    )
    def test_a_residual_that_follows_the_road_is_no_noise(self, lacking: bool, level: Level) -> None:
        """A load that swings on the body is missing from the car; or there is noise as loud, as coloured."""
        load = Strut(name="load", stiffness=100 * 14.0**2, damping=300.0, arms={"load": 1.0, "chassis": -1.0})
        true = Suspension(masses={**QUARTER.masses, "load": 100.0}, struts=[*QUARTER.struts, load])
        rng, times = np.random.default_rng(5), np.arange(0, 40, 0.005)
        road, other = (
            np.sum(amount * np.sin(2 * np.pi * f * times[:, None] + rng.uniform(0, 6, f.size)), axis=1)
            for amount, f in ((0.002, np.arange(0.5, 6.0, 0.025)), (0.0004, np.arange(0.51, 6.0, 0.025)))
        )
        made = simulate(true if lacking else QUARTER, times, {"road": road}, outputs=["chassis", "tire"])
        rows = np.asarray(made.outputs) + 1e-4 * rng.standard_normal(made.outputs.shape)
        rows[0] += 0.0 if lacking else np.squeeze(simulate(QUARTER, times, {"road": other}, outputs=["chassis"]).y)
        record = record_of(dict(zip(["chassis", "tire"], rows, strict=True)), {"road": road}, times)
        found = estimate(record, QUARTER.with_parameters(damping={"chassis": 1100}), given=("road",))
        left = np.std(np.asarray(found.residual[0].outputs), axis=1) / np.std(rows, axis=1)
        assert 0.1 < np.max(left) < 0.316
        (check,) = [one for one in found.verdict.checks if one.remark.code is EstimateCheck.UNEXPLAINED]
        assert check.level is level
        assert ("is correlated with the input" in str(check)) is lacking

    def test_white_noise_passes_and_a_decay_in_it_fails(self) -> None:
        rng = np.random.default_rng(3)
        noise = rng.standard_normal((200, 1000))
        statistics, freedom = portmanteau(noise)
        assert statistics.mean() == pytest.approx(freedom, abs=4 * np.sqrt(2 * freedom / 200))
        left = noise[:1] + np.exp(-0.002 * np.arange(1000)) * np.sin(0.1 * np.arange(1000))
        assert portmanteau(left)[0][0] > 100

    def test_coloured_noise_has_the_scores_that_its_spectrum_gives(self) -> None:
        # The sum of n samples of an AR(1) process of innovation 1 has the variance n / (1 - a)^2.
        rng, a, n = np.random.default_rng(4), 0.8, 20000
        noise = rng.standard_normal(n)
        for k in range(1, n):
            noise[k] += a * noise[k - 1]
        power = score_power(np.ones((n, 1)), noise)
        assert power[0, 0] / n == pytest.approx(1 / (1 - a) ** 2, rel=0.3)

    def test_the_table_names_the_masses_and_the_change(self) -> None:
        found = estimate(
            add_noise(TestOptions.RECORD, snr_db=40.0, rng=np.random.default_rng(1)),
            QUARTER.with_parameters(damping={"chassis": 1625}),
        )
        text = str(found)
        assert "-20" in text or "-19.9" in text
        assert "The mass of chassis and the mass of tire are taken as known" in text
        changed = next(c.remark for c in found.verdict.checks if c.remark.code is EstimateCheck.CHANGED)
        assert changed.numbers["names"] == ("chassis.damping",)

    @pytest.mark.parametrize("bounds", [None, {"chassis.damping": (1100.0, 1350.0)}])
    @pytest.mark.parametrize("mounts", [(), ("chassis",)])
    def test_table_and_verdict_name_the_same_changes(
        self, bounds: dict[str, tuple[float, float]] | None, mounts: Sequence[str]
    ) -> None:
        record = add_noise(TestOptions.RECORD, snr_db=25.0, rng=np.random.default_rng(1))
        found = estimate(record, QUARTER.with_parameters(damping={"chassis": 1400}), bounds=bounds, mounts=mounts)
        said = [c.remark for c in found.verdict.checks if c.remark.code is EstimateCheck.CHANGED]
        apart = found.beyond_chance()
        assert [c.numbers["names"] for c in said] == [tuple(n for n in found.parameters if n in apart)][: len(apart)]
        # No value within these bounds is the nominal one.
        assert bounds is None or "chassis.damping" in apart
