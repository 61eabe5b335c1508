"""Estimates from measured motion of the wheels: the road cancels, and what is not in the model is told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import control
import numpy as np
import pytest
from scipy.stats import binom, chi2

from suspid import (
    EstimationError,
    InputError,
    Level,
    RecordError,
    RecordTest,
    Suspension,
    cut,
    estimate,
    full_car,
    half_car,
    quarter_car,
)
from suspid.greybox.frequency_domain import _sandwich
from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.noise_levels import Levels, Shared, covariance_of, levels_of, node_basis, shared_of
from suspid.greybox.one_car import not_one_car_in_drives
from suspid.greybox.transfers import Layout, Physics, layout_of, transfer
from suspid.greybox.trials import Trial, trials_of
from suspid.greybox.wheel_power import tracks_of
from suspid.greybox.wheel_problem import wheel_problem
from suspid.levels import NORMAL_95
from suspid.reconstruction import parameter_names, parameter_vector, unknowns_of
from suspid.records import as_response
from suspid.units import ComplexArray, RealArray
from suspid.words import EstimateCheck

QUARTER = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
)
HALF = half_car(
    chassis_mass=600, pitch_inertia=600 * 1.25 * 1.35 * 0.87, front_tire_mass=40, rear_tire_mass=42,
    cg_to_front=1.25, cg_to_rear=1.35, front_stiffness=22e3, rear_stiffness=24e3, front_tire_stiffness=190e3,
    rear_tire_stiffness=200e3, front_damping=1350, rear_damping=1450,
)  # fmt: skip
FULL = full_car(
    chassis_mass=1200, pitch_inertia=1800, roll_inertia=500, front_tire_mass=40, rear_tire_mass=42,
    cg_to_front=1.2, cg_to_rear=1.5, front_track=1.5, rear_track=1.48,
    front_stiffness=20e3, rear_stiffness=18e3, front_antiroll_stiffness=8e3,
    front_tire_stiffness=200e3, rear_tire_stiffness=205e3, front_damping=1500, rear_damping=1400,
)  # fmt: skip
RATE = 200.0


def off(car: Suspension) -> Suspension:
    """Return the car with its k and c 30 % off, in turn."""
    names, count = [s.name for s in car.struts], len(car.struts)
    p = parameter_vector(car)[: 2 * count] * np.resize([0.7, 1.3, 0.7], 2 * count)
    return car.with_parameters(
        stiffness=dict(zip(names, p[:count].tolist(), strict=True)),
        damping=dict(zip(names, p[count:].tolist(), strict=True)),
    )


def driven(
    car: Suspension,
    seed: int,
    *,
    duration: float = 60.0,
    noise: Mapping[str, float] | None = None,
    delay: Mapping[str, float] | None = None,
    mount: float | None = None,
    lag: float = 0.13,
    channels: Sequence[str] | None = None,
) -> tuple[dict[str, RealArray], RealArray]:
    """Return motions on a random road, by default all accelerations: a cut from a period of four times the length.

    Exact, frequency by frequency: ``(M s^2 + C s + K) q = (C_road s + K_road) r``. The slope of the road is white, as
    on class B at 20 m/s; the second axle follows by ``lag``. With a ``mount`` [N/m], in series with each damper of a
    spring, ``c s`` is ``c s / (1 + c s / mount)``.
    """
    rng = np.random.default_rng(seed)
    count = round(4 * duration * RATE)
    hertz = np.fft.rfftfreq(count, 1 / RATE)[1:]
    s = 2j * np.pi * hertz
    # One-sided G(f) = G_d(n_0) n_0^2 v / f^2, G_d(0.1 / m) = 64e-6 m^3.
    size = np.sqrt(64e-6 * 0.01 * 20.0 / hertz**2 * RATE / 2 * count) * (hertz < 90) * (hertz > 0.1)
    road = size * (rng.standard_normal(len(s)) + 1j * rng.standard_normal(len(s))) / np.sqrt(2)
    roads = np.stack([road * np.exp(-s * lag * i) for i in range(len(car.roads))], axis=1)
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    k, c = np.array([x.stiffness for x in car.struts]), np.array([x.damping for x in car.struts])
    rate = c * s[:, None]
    rates = rate if mount is None else rate / (1 + rate / mount)
    dynamic = np.einsum("lj,ja,jb->lab", k + rates, arms, arms) + car.M * s[:, None, None] ** 2
    push = -np.einsum("lj,ja,jb,lb->la", k + rates, arms, road_arms, roads)
    motion = np.linalg.solve(dynamic, push[:, :, None])[:, :, 0] * s[:, None] ** 2
    kept, made = round(duration * RATE), {}
    every = {name: motion[:, i] * np.exp(-s * (delay or {}).get(name, 0.0)) for i, name in enumerate(car.coordinates)}
    shown = {f"{name}_acceleration": values for name, values in every.items()}
    shown |= {f"{name}_velocity": values / s for name, values in every.items()}
    shown |= {name: values / s**2 for name, values in every.items()}
    if channels is not None:
        shown["chassis_travel"] = (every["chassis"] - every["tire"]) / s**2
    for name in channels or [f"{c}_acceleration" for c in car.coordinates]:
        whole = np.fft.irfft(np.concatenate([[0], shown[name]]), count)[:kept]
        level = (noise or {}).get(name.removesuffix("_acceleration"), 0.0)
        made[name] = whole + level * rng.standard_normal(kept)
    return made, np.arange(kept) / RATE


def record_of(motions: Mapping[str, RealArray], times: RealArray) -> control.TimeResponseData:
    return control.TimeResponseData(
        time=times, outputs=np.array(list(motions.values())), output_labels=list(motions), issiso=False
    )


NOISE = {"chassis": 0.03, "tire": 0.1}


class TestTransfer:
    def layout(self) -> Layout:
        record = record_of(dict.fromkeys(("heave_acceleration", "pitch_velocity", "rear", "front_travel"), np.ones(9)),
                           np.arange(9.0))  # fmt: skip
        return layout_of(HALF, trials_of(record, HALF, ("front", "rear"))[0])

    def physics(self, values: RealArray) -> Physics:
        struts = len(HALF.struts)
        return Physics(
            stiffness=values[:struts], damping=values[struts : 2 * struts],
            masses=values[2 * struts : 2 * struts + 4], relaxation=values[-12:-8], gains=values[-8:-4],
            delays=values[-4:],
        )  # fmt: skip

    @pytest.mark.parametrize(("gains", "delays"), [([2, 3], [2, 3]), ([0, 2], [1, 3])])
    def test_slopes_are_those_of_finite_differences(self, gains: list[int], delays: list[int]) -> None:
        layout, s = self.layout(), 2j * np.pi * np.array([0.7, 1.4, 9.0])
        assert [layout.causes, layout.outputs] == [(2, 3), (0, 1)]
        values = np.concatenate([parameter_vector(HALF), [2e-3, 1e-3, 0, 0], [1, 1, 1.1, 0.9], [0, 0, 2e-3, -1e-3]])
        rows = [0, 1, 4, 5, 8, 9]
        where = [*rows, 12, 13, 18, 19, 22, 23]

        where[-4:] = [16 + gains[0], 16 + gains[1], 20 + delays[0], 20 + delays[1]]

        def made(at: RealArray) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
            found = transfer(layout, s, self.physics(at), rows, mounts=[0, 1], gains=gains, delays=delays)
            return found.T, found.left_by_ends, found.left, found.right[:, list(found.places)]

        _, _, left, right = made(values)
        for i, place in enumerate(where):
            move = np.zeros(len(values))
            move[place] = 1e-5 * (abs(values[place]) + 1e-4)
            slope = (made(values + move)[0] - made(values - move)[0]) / (2 * move[place])
            expected = left[:, :, i, None] * right[:, None, i]
            np.testing.assert_allclose(slope, expected, atol=1e-5 * np.abs(expected).max())

    def test_what_is_given_must_be_enough(self) -> None:
        record = record_of(dict.fromkeys(("heave_acceleration", "front_acceleration"), np.ones(9)), np.arange(9.0))
        for given, words in (
            (("front",), "'rear_tire' connects 'rear' to a road"),
            (("front", "rear"), "no channel measures the motion of 'rear'"),
            (("heave", "pitch", "front", "rear"), "nothing is left"),
        ):
            with pytest.raises(InputError, match=words):
                layout_of(HALF, trials_of(record, HALF, given)[0])


class TestNoiseLevels:
    def test_levels_of_their_own_moments_are_found(self) -> None:
        hertz = np.linspace(0.5, 25, 200)
        rng = np.random.default_rng(1)
        T = rng.standard_normal((200, 2, 2)) + 1j * rng.standard_normal((200, 2, 2))
        basis = node_basis(hertz)
        true = Levels(outputs=np.log(rng.uniform(0.5, 2.0, (basis.shape[1], 2))), causes=np.log(np.array([0.3, 3.0])))
        moments = covariance_of(T, *true.spectra(basis))
        start = Levels(outputs=np.zeros_like(true.outputs), causes=np.zeros(2))
        nothing = Shared(A=np.zeros((2, 2)), b=np.zeros(2))
        found = levels_of(T, moments, basis, start, anchor=start, count=10_000, shared=nothing)
        np.testing.assert_allclose(found.outputs, true.outputs, atol=1e-3)
        np.testing.assert_allclose(found.causes, true.causes, atol=1e-3)

    def test_where_the_causes_hide_it_noise_is_as_beside(self) -> None:
        """A resonance: what the noise of a wheel makes of the body hides the body's own noise, which is white."""
        hertz = np.linspace(0.5, 25, 200)
        T = np.where(hertz < 3, 1e3, 0.1)[:, None, None].astype(complex)
        basis = node_basis(hertz)
        true = Levels(outputs=np.full((basis.shape[1], 1), -7.0), causes=np.array([-4.6]))
        start = Levels(outputs=np.zeros_like(true.outputs), causes=np.zeros(1))
        found = levels_of(
            T, covariance_of(T, *true.spectra(basis)), basis, start, anchor=start, count=8,
            shared=Shared(A=np.zeros((1, 1)), b=np.zeros(1)),
        )  # fmt: skip
        # The first guess is a thousand times the truth.
        np.testing.assert_allclose(found.outputs, true.outputs, atol=1.0)

    def test_smooth_transfers_are_told_from_noise_by_what_residual_and_causes_share(self) -> None:
        # Two causes that move together, and a transfer that is the same at all lines: r alone holds only the sum.
        rng, lines, stretches = np.random.default_rng(2), 200, 400
        shape = (lines, stretches, 2)
        T = np.broadcast_to(np.array([[1.0 + 0.5j, -0.3], [0.2j, 0.8]]), (lines, 2, 2)).astype(complex)
        out, cause = np.array([0.5, 2.0]), np.array([0.4, 1.5])

        def noise(power: RealArray) -> ComplexArray:
            return np.asarray(np.sqrt(power / 2) * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)))

        motion = noise(np.array([1.0, 1.0])) @ np.array([[1.0, 0.9], [0.0, 0.4]])
        errors = noise(cause)
        left = noise(out) - errors @ T[0].T
        basis = node_basis(np.linspace(0.5, 25, lines))
        start = Levels(outputs=np.zeros((basis.shape[1], 2)), causes=np.zeros(2))
        moments = left.swapaxes(1, 2) @ left.conj() / stretches
        precision = np.asarray(np.linalg.inv(covariance_of(T, np.tile(out, (lines, 1)), cause)), complex)
        shared = shared_of(T, precision, left, motion + errors)
        found = levels_of(T, moments, basis, start, anchor=start, count=stretches, shared=shared)
        np.testing.assert_allclose(np.exp(found.causes), cause, rtol=0.05)
        np.testing.assert_allclose(np.exp(found.outputs), np.tile(out, (basis.shape[1], 1)), rtol=0.15)


def at_rest(
    body: float, wheel: float, *, stretch: float | None = None
) -> tuple[WheelProblem, RealArray, Levels, tuple[Trial, ...]]:
    """Return the problem of a car that stands, its true unknowns, and the true levels of the noise of its sensors."""
    rng, times = np.random.default_rng(1), np.arange(60_000) / 100.0
    noise, channels = np.array([body, wheel]), ("chassis_acceleration", "tire_acceleration")
    record = as_response(times, noise[:, None] * rng.standard_normal((2, len(times))), channels)
    trials = trials_of(record, QUARTER, ("tire",))
    unknowns = unknowns_of(QUARTER, rate=30.0, fixed=["tire.stiffness", "tire.damping"])
    problem = wheel_problem(
        QUARTER, trials, unknowns, gains=None, delays=None, mounts=(), band=(0.7, 30.0), stretch=stretch
    )
    power = 2 * np.log(noise)
    levels = Levels(outputs=np.full((problem.sources[0].basis.shape[1], 1), power[0]), causes=power[1:])
    return problem, np.concatenate([unknowns.nominal, problem.extras.start]), levels, trials


class TestCarAtRest:
    """All that is seen is noise, so every statistic is that of noise."""

    def test_the_power_of_the_wheel_is_that_of_its_noise(self) -> None:
        problem, z, levels, trials = at_rest(0.02, 0.3)
        (track,) = tracks_of(problem, z, 0, levels, trials, speeds=None, band=(2.0, 25.0))
        # 91 stretches of some 150 lines, of which tapers make about a half independent.
        assert np.mean(track.power / track.noise) == pytest.approx(1.0, abs=0.04)
        assert np.all(track.noise > 0)

    def test_all_information_is_that_of_noise(self) -> None:
        problem, z, levels, _ = at_rest(0.02, 0.3)
        found = problem.whitened(z, 0, levels)
        slope = found.slope(slice(None)).reshape(-1, len(z))
        np.testing.assert_allclose(np.sum(slope**2, axis=0), np.diag(found.spurious), rtol=0.1)

    def test_levels_of_short_stretches_are_those_of_the_noise(self) -> None:
        """The ends of a stretch take up to four fifths of a line of low frequency, which is no sign of less noise."""
        problem, z, levels, _ = at_rest(0.3, 0.03, stretch=1.5)
        (found,) = problem.levels(problem.every(z, [levels]), [levels])
        # A level is told by few lines each, so single ones scatter; what took energy away would lower all of them.
        np.testing.assert_allclose(np.median(found.outputs - levels.outputs), 0.0, atol=0.15)


class TestIntervals:
    def test_they_hold_what_was_fitted_to_few_lines(self) -> None:
        # White noise; the ends take up much of the first lines, where the derivatives are largest.
        rng, lines, stretches, draws = np.random.default_rng(3), 30, 4, 3000
        decay = np.tile(np.exp(-np.arange(lines) / 3.0), 2)[:, None]
        basis, _ = np.linalg.qr(decay * rng.standard_normal((2 * lines, 4)))
        slope = np.sqrt(decay) * rng.standard_normal((stretches, 2 * lines, 2))
        slope -= basis @ (basis.T @ slope)
        flat = slope.reshape(-1, 2)
        solve = np.linalg.inv(flat.T @ flat) @ flat.T
        held = np.zeros(2)
        for _ in range(draws):
            noise = rng.standard_normal((stretches, 2 * lines, 1))
            left = (noise - basis @ (basis.T @ noise)).ravel()
            error = solve @ left
            left -= flat @ error
            covariance, _ = _sandwich([SimpleNamespace(
                slope=slope.__getitem__, residual=left.reshape(stretches, -1), basis=basis, spurious=np.zeros((2, 2)),
                rows=lambda: (None, flat), parts=lambda: [slice(0, 3), slice(3, None)], factor=np.zeros((lines, 1, 1)),
            )], np.zeros((0, 2)))  # type: ignore[list-item]  # fmt: skip
            held += np.abs(error) < NORMAL_95 * np.sqrt(np.diag(covariance))
        # 3000 draws know a share of 0.95 to 0.004.
        np.testing.assert_allclose(held / draws, 0.95, atol=0.015)

    def test_beside_a_rigid_mount_they_hold_for_cars_with_mounts_alone(self) -> None:
        ends, known = [], []
        for seed in range(6):
            motions, times = driven(QUARTER, seed, duration=10.0, noise=NOISE)
            found = estimate(record_of(motions, times), off(QUARTER), given=("tire",))
            at = found.parameters.index("chassis.relaxation")
            rigid = found.values[at] < 1e-9
            # Without a bound the mount would be stiffer than a rigid one.
            assert (found.unbounded[at] < -1e-6) == rigid
            c, std = found.values[1], found.std[1]
            low, high = found.interval()["chassis.damping"]
            ends.append([(low - c) / std, (high - c) / std])
            known.append(rigid)
        assert 0 < sum(known) < 6
        # What is above a rigid mount's damper is left out: there the interval is as if no mount were unknown.
        assert np.max(np.array(ends)[known, 1]) < 1.0
        assert np.min(ends) > -1.06 * NORMAL_95


def corner_of_half(index: float) -> tuple[control.TimeResponseData, Suspension]:
    """Return motions above and at the front axle of a half car, and a quarter car with the mass it shows there."""
    whole = HALF.with_parameters(masses={"pitch": 600 * 1.25 * 1.35 * index})
    motions, times = driven(whole, 5, noise={"heave": 0.02, "front": 0.05})
    above = motions["heave_acceleration"] - 1.25 * motions["pitch_acceleration"]
    corner = quarter_car(
        chassis_mass=1 / (1 / 600 + 1.25**2 / whole.masses["pitch"]), tire_mass=40, chassis_stiffness=22e3,
        tire_stiffness=190e3, chassis_damping=1350,
    )  # fmt: skip
    return record_of({"chassis_acceleration": above, "tire_acceleration": motions["front_acceleration"]}, times), corner


class TestDriving:
    def test_without_noise_the_strut_is_exact(self) -> None:
        motions, times = driven(QUARTER, 1)
        found = estimate(record_of(motions, times), off(QUARTER), given=("tire",), gains=(), delays=(), mounts=())
        # What the ends of the stretches leave is known to the fourth power of frequency.
        assert found.suspension.struts[0].stiffness == pytest.approx(22e3, rel=2e-6)
        assert found.suspension.struts[0].damping == pytest.approx(1300, rel=2e-6)
        assert found.suspension.struts[1] == off(QUARTER).struts[1]

    @pytest.mark.parametrize("mount", [None, 4e5])
    def test_a_record_without_noise_is_explained(self, mount: float | None) -> None:
        motions, times = driven(QUARTER, 1, mount=mount)
        found = estimate(record_of(motions, times), off(QUARTER), given=("tire",))
        assert found.suspension.struts[0].stiffness == pytest.approx(22e3, rel=2e-4)
        assert found.explains
        assert found.verdict.level is Level.SOUND

    @pytest.mark.parametrize("name", ["road", "tire_travel"])
    def test_a_road_that_was_recorded_is_no_channel_of_the_car(self, name: str) -> None:
        motions, times = driven(QUARTER, 1, noise=NOISE)
        road = np.cumsum(motions["tire_acceleration"]) * 1e-4
        alone = estimate(record_of(motions, times), off(QUARTER), given=("tire",))
        found = estimate(record_of({**motions, name: road}, times), off(QUARTER), given=("tire",))
        assert found.values == pytest.approx(alone.values, rel=1e-9)
        assert found.residual[0].output_labels == list(motions)
        remarks = [check.remark for check in found.verdict.checks]
        assert (EstimateCheck.UNUSED, (name,)) in [(r.code, r.numbers.get("names")) for r in remarks]
        assert found.verdict.level is alone.verdict.level
        with pytest.raises(RecordError, match="no channel of the record measures"):
            estimate(record_of({name: road}, times), QUARTER, given=("tire",))

    def test_an_antiroll_bar_without_a_damper_has_no_mount(self) -> None:
        noise = {**dict.fromkeys(("heave", "pitch", "roll"), 0.02), **dict.fromkeys(FULL.coordinates[3:], 0.05)}
        motions, times = driven(FULL, 2, duration=30.0, noise=noise)
        found = estimate(record_of(motions, times), FULL, given=FULL.coordinates[3:])
        assert "front_left.relaxation" in found.parameters
        assert "front_antiroll.relaxation" not in found.parameters
        assert found.explains

    def test_intervals_hold_and_errors_are_as_stated(self) -> None:
        seeds, holds, z = 16, 0, []
        for seed in range(seeds):
            motions, times = driven(QUARTER, seed, noise=NOISE)
            found = estimate(record_of(motions, times), off(QUARTER), given=("tire",), gains=(), delays=(), mounts=())
            ends = found.interval(0.95)
            truth = {"chassis.stiffness": 22e3, "chassis.damping": 1300.0}
            holds += sum(ends[name][0] <= value <= ends[name][1] for name, value in truth.items())
            z += [(v - truth[n]) / sd for n, v, sd in zip(found.parameters, found.values, found.std, strict=True)]
            assert found.std[0] / found.values[0] < 0.002
        assert binom.ppf(1e-4, 2 * seeds, 0.95) <= holds
        assert np.sum(np.square(z)) < chi2.ppf(1 - 1e-4, 2 * seeds)

    @pytest.mark.parametrize(
        "sensors",
        [
            {"tire_velocity": 0.003},
            {"tire": 0.0003},
            {"chassis_travel": 0.0003},
            {"tire_acceleration": 0.1, "chassis_travel": 0.0003},
        ],
    )
    def test_any_sensors_of_the_wheel(self, sensors: Mapping[str, float]) -> None:
        noise = {"chassis": 0.03, **{name.removesuffix("_acceleration"): std for name, std in sensors.items()}}
        noisy, times = driven(QUARTER, 7, channels=["chassis_acceleration", *sensors], noise=noise)
        found = estimate(record_of(noisy, times), off(QUARTER), given=("tire",))
        truth = {"chassis.stiffness": 22e3, "chassis.damping": 1300.0}
        for name, value, std in zip(found.parameters, found.values, found.std, strict=True):
            assert name not in truth or abs(value - truth[name]) < 4 * std < 0.05 * value
        assert found.explains

    @pytest.mark.parametrize(("sensor", "seed"), [("tire", 3010), ("tire", 3032), ("chassis_travel", 3002)])
    def test_noise_of_a_displacement_is_told_from_that_of_the_body(self, sensor: str, seed: int) -> None:
        # Above 15 Hz the wheel's displacement is less than its noise, and what that does to the body is smooth.
        noise = {"chassis": 0.03, sensor: 0.0003}
        noisy, times = driven(QUARTER, seed, channels=["chassis_acceleration", sensor], noise=noise)
        found = estimate(record_of(noisy, times), off(QUARTER), given=("tire",), band_hz=(0.5, 21.0))
        assert found.explains
        body, cause = found.noise_std[0]
        assert cause == pytest.approx(0.0003, rel=0.2)
        # That of the body is a tenth of what the other's does to the residual at 20 Hz.
        assert body == pytest.approx(0.03, rel=0.6)
        ends = found.interval(0.999)
        assert ends["chassis.stiffness"][0] < 22e3 < ends["chassis.stiffness"][1]
        assert ends["chassis.damping"][0] < 1300 < ends["chassis.damping"][1]

    @pytest.mark.parametrize("late", [-300, 70])
    def test_a_wheel_on_a_clock_of_its_own(self, late: int) -> None:
        motions, times = driven(QUARTER, 12, noise=NOISE)
        count = len(times) - abs(late)
        body, wheel = (row[max(0, shift) :][:count] for row, shift in zip(motions.values(), (late, -late), strict=True))
        rows = dict(zip(motions, (body, wheel), strict=True))
        found = estimate(record_of(rows, times[:count]), off(QUARTER), given=("tire",))
        values = dict(zip(found.parameters, found.values.tolist(), strict=True))
        std = dict(zip(found.parameters, found.std.tolist(), strict=True))
        name = "tire_acceleration.delay"
        assert abs(values[name] - late / 200) < 4 * std[name] < 0.01
        assert values["chassis.stiffness"] == pytest.approx(22e3, rel=0.02)
        assert found.explains

    def test_a_wheel_in_millimetres(self) -> None:
        motions, times = driven(QUARTER, 13, noise=NOISE)
        rows = dict(zip(motions, np.array(list(motions.values())) * [[1.0], [1000.0]], strict=True))
        found = estimate(record_of(rows, times), off(QUARTER), given=("tire",))
        values = dict(zip(found.parameters, found.values.tolist(), strict=True))
        assert values["tire_acceleration.gain"] == pytest.approx(1000, rel=0.03)
        assert values["chassis.stiffness"] == pytest.approx(22e3, rel=0.02)
        assert "units" in str(found)

    def test_records_of_two_loggers_are_used_jointly(self) -> None:
        records = [record_of(*driven(QUARTER, seed, noise=NOISE, delay={"tire": 0.001 * seed})) for seed in (1, 2)]
        both = estimate(records, off(QUARTER), given=("tire",), gains=(), mounts=())
        alone = estimate(records[1], off(QUARTER), given=("tire",), gains=(), mounts=())
        delays = dict(zip(both.parameters, both.values, strict=True))
        assert delays["tire_acceleration[1].delay"] == pytest.approx(0.001, abs=1e-4)
        assert delays["tire_acceleration[2].delay"] == pytest.approx(0.002, abs=1e-4)
        assert both.std[0] < 0.85 * alone.std[0]

    def test_parts_of_a_record_by_one_logger_are_the_record(self) -> None:
        """Cut between two stretches, and with the parts out of order."""
        record = record_of(*driven(QUARTER, 21, noise={"tire_acceleration": 0.1, "chassis_acceleration": 0.03}))
        options: dict[str, Any] = {"given": ["tire"], "stretch": 6.0}
        whole = estimate(record, off(QUARTER), **options)
        cuts = [cut(record, start=24.0), cut(record, stop=24.0 - 1 / RATE)]
        parts = estimate([RecordTest(record=part, logger="a") for part in cuts], off(QUARTER), **options)
        assert parts.parameters == whole.parameters
        assert parts.values == pytest.approx(whole.values, rel=1e-6, abs=1e-9)
        assert parts.std == pytest.approx(whole.std, rel=1e-4)
        assert [len(one.time) for one in parts.residual] == [36 * 200, 24 * 200]
        np.testing.assert_allclose(parts.residual[1].y, whole.residual[0].y[:, : 24 * 200], atol=1e-6)
        apart = estimate([RecordTest(record=part) for part in cuts], off(QUARTER), **options)
        assert len(apart.parameters) == len(whole.parameters) + 2

    def test_a_late_sensor_and_a_mount_are_found_and_would_do_harm(self) -> None:
        motions, times = driven(QUARTER, 3, noise=NOISE, delay={"tire": 0.002}, mount=1e6)
        record = record_of(motions, times)
        found = estimate(record, off(QUARTER), given=("tire",))
        ends = found.interval(0.999)
        for name, value in (
            ("chassis.stiffness", 22e3), ("chassis.damping", 1300.0), ("chassis.relaxation", 1.3e-3),
            ("tire_acceleration.gain", 1.0), ("tire_acceleration.delay", 0.002),
        ):  # fmt: skip
            assert ends[name][0] < value < ends[name][1]
        assert found.suspension.struts[0].mount_stiffness == pytest.approx(1e6, rel=0.5)
        # Each alone, left out: k is far too small with a delay, far too large with a mount, and the verdict says so.
        for delay, mount, sign in ((0.002, None, -1), (0.0, 1e6, 1)):
            motions, times = driven(QUARTER, 3, noise=NOISE, delay={"tire": delay}, mount=mount)
            rigid = estimate(record_of(motions, times), QUARTER, given=("tire",), gains=(), delays=(), mounts=())
            assert sign * (rigid.suspension.struts[0].stiffness / 22e3 - 1) > 0.1
            assert rigid.verdict.level is Level.DOUBTFUL

    def test_a_half_car_by_both_wheels_gives_its_inertia(self) -> None:
        noise = {"heave": 0.02, "pitch": 0.02, "front": 0.1, "rear": 0.1}
        motions, times = driven(HALF, 4, noise=noise)
        nominal = off(HALF).with_parameters(masses={"pitch": 700})
        found = estimate(
            record_of(motions, times), nominal, given=("front", "rear"), free_masses=["pitch"], gains=(), delays=(),
            mounts=(),
        )  # fmt: skip
        truth = dict(zip(parameter_names(HALF), parameter_vector(HALF), strict=True))
        for name, value, std in zip(found.parameters, found.values, found.std, strict=True):
            assert abs(value - truth[name]) < 4 * std
            assert std < 0.01 * value
        assert found.explains
        assert found.modes.channels == ("heave", "pitch")

    @pytest.mark.slow
    def test_gain_and_delay_of_a_sensor_on_the_body(self) -> None:
        noise = {"heave": 0.02, "pitch": 0.02, "front": 0.1, "rear": 0.1}
        motions, times = driven(HALF, 8, noise=noise, delay={"pitch": 0.003})
        record = record_of({**motions, "heave_acceleration": 1.03 * motions["heave_acceleration"]}, times)
        channels = {"gains": ["heave_acceleration"], "delays": ["pitch_acceleration"], "mounts": ()}
        found = estimate(record, off(HALF), given=("front", "rear"), **channels)  # type: ignore[arg-type]
        ends = found.interval(0.999)
        assert ends["heave_acceleration.gain"][0] < 1.03 < ends["heave_acceleration.gain"][1] < 1.04
        assert ends["pitch_acceleration.delay"][0] < 0.003 < ends["pitch_acceleration.delay"][1] < 0.0035
        assert ends["front.stiffness"][0] < 22e3 < ends["front.stiffness"][1]
        assert found.explains
        every = list(motions)
        with pytest.raises(EstimationError, match="do not determine") as refused:
            estimate(record, off(HALF), given=("front", "rear"), gains=every, delays=(), mounts=())
        assert "pitch_acceleration.gain" in str(refused.value)
        with pytest.raises(InputError, match="delays: .* only differences"):
            estimate(record, off(HALF), given=("front", "rear"), delays=every)
        with pytest.raises(
            InputError, match=r"gains: 'heave_aceleration' is not one of .* Did you mean 'heave_acceleration'"
        ):
            estimate(record, off(HALF), given=("front", "rear"), gains=["heave_aceleration"])

    @pytest.mark.parametrize(
        "index", [0.71, *(pytest.param(more, marks=pytest.mark.slow) for more in (0.6, 0.87, 0.95, 1.2))]
    )
    def test_a_quarter_car_on_a_corner_of_a_half_car_is_told(self, index: float) -> None:
        record, corner = corner_of_half(index)
        found = estimate(record, corner, given=("tire",))
        assert not found.explains
        assert found.verdict.level is Level.DOUBTFUL
        # The stated error is not that of what the parameters can do themselves, which the record hardly holds.
        (said,) = [c.remark.numbers for c in found.verdict.checks if c.remark.code is EstimateCheck.FOLLOWS]
        error = said["error"]
        assert isinstance(error, float)
        assert 0.02 < error < 1.0
        # What the car lacks is in the intervals, which hold the truth.
        ends = found.interval()
        for name, true in (("chassis.stiffness", 22e3), ("chassis.damping", 1350)):
            assert ends[name][0] < true < ends[name][1]

    def test_fitted_and_residual_add_up_to_the_band_of_the_record(self) -> None:
        motions, times = driven(QUARTER, 6, noise=NOISE, duration=20.0)
        found = estimate(record_of(motions, times), QUARTER, given=("tire",), band_hz=(0.5, 25.0), stretch=20.0)
        whole = np.asarray(found.fitted[0].y) + np.asarray(found.residual[0].y)
        record = np.array(list(motions.values()))
        lines = np.fft.rfft(record, axis=1)
        hertz = np.fft.rfftfreq(record.shape[1], 1 / RATE)
        lines[:, (hertz < 0.5) | (hertz > 25.0)] = 0.0
        np.testing.assert_allclose(whole, np.fft.irfft(lines, record.shape[1]), atol=1e-9)


@pytest.mark.parametrize(("factor", "level"), [(1.0, Level.SOUND), (1.05, Level.CARE), (1.5, Level.DOUBTFUL)])
def test_drives_of_two_cars_are_told(factor: float, level: Level) -> None:
    """A sensor of another gain explains most of a damper that changed between two drives, and nobody may think so."""
    other = QUARTER.with_parameters(damping={"chassis": 1300 * factor})
    records = [record_of(*driven(car, seed, noise=NOISE)) for seed, car in ((1, QUARTER), (2, other))]
    found = estimate(records, QUARTER, given=("tire",))
    said = [check for check in found.verdict.checks if check.remark.code is EstimateCheck.NOT_ONE_CAR]
    assert found.verdict.level is level
    assert [check.level for check in said] == [level] * (factor > 1)
    assert all(check.remark.numbers["name"] == "chassis.damping" for check in said)


def test_a_damper_that_is_zero_in_the_joint_fit_changes_by_no_percent() -> None:
    """Of two loggers the second has records from the third on, and says so."""
    fits = [SimpleNamespace(x=np.array([1.0, c]), covariance=1e-4 * np.eye(2), explains=True) for c in (0.0, 0.5)]
    joint: Any = SimpleNamespace(x=np.array([1.0, 0.0]))
    alone: Any = {0: fits[0], 2: fits[1]}
    (check,) = not_one_car_in_drives(joint, alone, ("chassis.stiffness", "tire.damping"))
    assert check.level is Level.DOUBTFUL
    assert "record 3 has tire.damping that is not zero as above" in str(check)
    assert check.remark.numbers["chi_square"] == pytest.approx(0.5**2 / 2e-4)
