"""Tires, wheel masses and modes of the whole car from a drive, with a model of the road."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from click.testing import CliRunner
from jsonschema import validate

from suspid import (
    Estimate,
    InputError,
    Level,
    Suspension,
    eigenmodes,
    estimate,
    half_car,
    statespace,
    write_car,
    write_record,
)
from suspid.cli import main
from suspid.greybox.judgement import far_or_vague
from suspid.greybox.reach import Reach, reach
from suspid.greybox.road_model import RoadModel, road_model
from suspid.greybox.tire_fit import TireProblem, fit_tires, scatter
from suspid.greybox.transfers import Physics
from suspid.greybox.trials import Trial, trials_of
from suspid.greybox.wheel_power import TAPER_BANDWIDTH, TAPERS, Track, _kernel
from suspid.identification import to_json
from suspid.reconstruction import parameter_vector, unknowns_of
from suspid.records import as_response
from suspid.reporting import estimate_from_dict, estimate_to_dict, json_schema
from suspid.units import RealArray
from suspid.words import EstimateCheck
from validation.greybox_rows import NOISE, QUARTER
from validation.motion import RADIUS, Drive, driven, record_of

CHANNELS = ("chassis_acceleration", "tire_acceleration")
HALF = half_car(
    chassis_mass=600, pitch_inertia=900, front_tire_mass=40, rear_tire_mass=42, cg_to_front=1.25, cg_to_rear=1.35,
    front_stiffness=22e3, rear_stiffness=24e3, front_tire_stiffness=190e3, rear_tire_stiffness=200e3,
    front_damping=1350, rear_damping=1450, front_tire_damping=60, rear_tire_damping=70,
)  # fmt: skip
NOMINAL = QUARTER.with_parameters(
    stiffness={"chassis": 17e3, "tire": 160e3}, damping={"chassis": 1600}, masses={"tire": 60}
)


@cache
def drive(seed: int, *, order: float = 0.0, spread: float = 0.15) -> tuple[control.TimeResponseData, RealArray]:
    asked = Drive(duration=120.0, noise=NOISE, order=order, spread=spread)
    rng = np.random.default_rng(seed)
    clean, times = driven(QUARTER, asked, rng)
    return record_of(clean, times, CHANNELS, asked, rng), clean["speed"]


@cache
def found(seed: int = 5) -> Estimate:
    record, speed = drive(seed)
    return estimate(
        record, NOMINAL, given=("tire",), free_masses=("tire",), road="iso8608", speed=speed, wheel_radius=RADIUS
    )


def physics_of(car: Suspension, p: RealArray, relaxation: RealArray) -> Physics:
    struts = len(car.struts)
    return Physics(
        stiffness=p[:struts], damping=p[struts : 2 * struts], masses=p[2 * struts :], relaxation=relaxation,
        gains=np.ones(2), delays=np.zeros(2),
    )  # fmt: skip


def trial_of(car: Suspension, channels: tuple[str, ...], given: tuple[str, ...]) -> Trial:
    record = as_response(np.arange(9.0), np.ones((len(channels), 9)), channels)
    return trials_of(record, car, given)[0]


class TestReach:
    def test_roads_reach_a_channel_as_in_the_state_space(self) -> None:
        trial = trial_of(HALF, ("front_acceleration", "rear"), ("front", "rear"))
        s = 2j * np.pi * np.array([0.7, 3.0, 12.0])
        physics = physics_of(HALF, parameter_vector(HALF), np.zeros(len(HALF.struts)))
        outputs = ["front", "rear"]
        by_road = statespace(HALF, outputs=outputs, road_rate=False)
        by_force = statespace(HALF, outputs=outputs, forces=["front_force"])
        for channel in (0, 1):
            made = reach(HALF, trial, physics, s, channel=channel, wheel=2, rows=(), mounts=())
            for k, one in enumerate(s):
                twice = np.abs(one) ** (0 if channel else 4)  # an acceleration
                gains = twice * np.abs(np.asarray(by_road(one, squeeze=False))[channel]) ** 2
                assert made.road[k] == pytest.approx(np.sum(gains), rel=1e-9)
                (gain,) = twice * np.abs(np.asarray(by_force(one, squeeze=False))[channel]) ** 2
                assert made.force[k] == pytest.approx(gain, rel=1e-9)

    def test_slopes_are_those_of_finite_differences(self) -> None:
        trial = trial_of(HALF, ("front_acceleration", "rear"), ("front", "rear"))
        s = 2j * np.pi * np.array([0.7, 3.0, 12.0])
        values = np.append(parameter_vector(HALF), [2e-3, 1e-3, 0, 0])
        rows, mounts = list(range(12)), (0, 1)

        def made(at: RealArray) -> Reach:
            physics = physics_of(HALF, at[:-4], at[-4:])
            return reach(HALF, trial, physics, s, channel=0, wheel=2, rows=rows, mounts=mounts)

        centre = made(values)
        for i in range(14):
            move = np.zeros(len(values))
            move[i] = 1e-4 * values[i]
            above, below = made(values + move), made(values - move)
            for found, after, before in (
                (centre.by_road, above.road, below.road),
                (centre.by_force, above.force, below.force),
            ):
                slope = np.log(after / before) / (2 * move[i])
                np.testing.assert_allclose(found[:, i], slope, rtol=1e-3, atol=1e-3 * np.max(np.abs(slope)))


def track_of(*, stretches: int = 20, speeds: RealArray | None = None, samples: int = 1400) -> Track:
    """Return a track of 7 s stretches at 200 Hz, from 0.5 to 27 Hz."""
    from scipy.signal.windows import dpss

    wide, lines = np.arange(1, 196), np.arange(4, 190)
    tapers = dpss(samples, TAPER_BANDWIDTH, TAPERS)
    moments = ((np.arange(96) + 0.5) / 96 * samples).astype(int)
    weights = np.mean(tapers**2, axis=0)[moments]
    return Track(
        source=0, channel=1, wheel=1, records=np.zeros(stretches, int),
        times=np.asarray(7.0 * np.arange(stretches)), wide=wide / 7.0, kernel=_kernel(tapers, lines, wide),
        power=np.ones((stretches, len(lines))), noise=np.full(len(lines), 1e-4), samples=samples, speeds=speeds,
        weights=weights / np.sum(weights),
    )  # fmt: skip


class TestSpectrum:
    def test_an_order_is_where_tapers_show_it(self) -> None:
        from scipy.signal.windows import dpss

        samples = 1400
        t = np.arange(samples) / 200.0
        speed = 20 * (1 + 0.2 * np.sin(2 * np.pi * t / 30))
        track = track_of(stretches=1, speeds=speed[None, ((np.arange(96) + 0.5) / 96 * samples).astype(int)])
        model = road_model(track, radius=0.3)
        expected = model.rotations(1, 0.0, 0.0) @ track.kernel.T
        turned = np.cumsum(speed) / 200 / 0.3
        waves = np.sqrt(2) * np.sin(turned + np.linspace(0, 2 * np.pi, 8, endpoint=False)[:, None])
        tapers = dpss(samples, TAPER_BANDWIDTH, TAPERS)
        shown = np.mean(np.abs(np.fft.rfft(waves[:, None] * tapers, axis=2)) ** 2, axis=(0, 1))[4:190]
        near = slice(50, 110)
        assert np.sum(expected[0, near]) == pytest.approx(np.sum(shown[near]), rel=0.02)
        centre = np.sum(track.hertz[near] * expected[0, near]) / np.sum(expected[0, near])
        assert centre == pytest.approx(np.sum(track.hertz[near] * shown[near]) / np.sum(shown[near]), abs=0.02)
        assert np.sum(np.abs(expected[0, near] - shown[near])) < 0.25 * np.sum(shown[near])

    def test_slopes_are_those_of_finite_differences(self) -> None:
        rng = np.random.default_rng(1)
        model = road_model(track_of(stretches=2, speeds=rng.uniform(15, 25, (2, 96))), radius=0.3)
        moved = transfer_of(QUARTER, model)
        own, levels = model.prior.mean + 0.1, np.array([0.1, -0.3])
        found = model.expected(own, levels, moved)
        np.testing.assert_allclose(found.power, model.power(own, levels, moved))
        for i in range(model.count):
            move = np.zeros(model.count)
            move[i] = 1e-6
            slope = np.log(model.power(own + move, levels, moved) / found.power) / 1e-6
            np.testing.assert_allclose(found.by_road[:, :, i], slope, atol=2e-3 * np.max(np.abs(slope)) + 1e-4)
        slope = np.log(model.power(own, levels + 1e-6, moved) / found.power) / 1e-6
        np.testing.assert_allclose(found.share, slope, atol=1e-4)


def test_stretches_have_the_speed_that_their_tapers_see() -> None:
    """A speed that swings about as fast as stretches are long: its mean by the power of the tapers."""
    from scipy.signal.windows import dpss

    record, _ = drive(5)
    t = np.asarray(record.time) - record.time[0]
    logarithm = np.log(20.0) + 0.2 * np.sin(2 * np.pi * t / 9)
    (road,) = estimate(record, NOMINAL, given=("tire",), road="iso8608", speed=np.exp(logarithm)).road
    length = float(road.times[1] - road.times[0])
    samples, count = round(length / (t[1] - t[0])), len(road.times)
    np.testing.assert_allclose(road.times - record.time[0], (np.arange(count) + 0.5) * length, atol=1e-9)
    power = np.mean(dpss(samples, TAPER_BANDWIDTH, TAPERS) ** 2, axis=0)
    expected = logarithm[: count * samples].reshape(count, samples) @ power / np.sum(power)
    assert road.speeds is not None
    np.testing.assert_allclose(np.log(road.speeds), expected, atol=1e-3)


def test_the_scatter_of_scores_is_the_variance_of_their_sum() -> None:
    """Of white noise, whose tapered powers correlate as the tapers do: ``sum |sum_t w_j w_k e^(i 2 pi l t / n)|^2``.

    Pairs of unknowns keep their correlation.
    """
    from scipy.signal.windows import dpss

    samples, stretches, lines = 400, 1000, np.arange(10, 190)
    tapers = dpss(samples, TAPER_BANDWIDTH, TAPERS)
    signs = np.exp(2j * np.pi * np.arange(len(lines))[:, None] * np.arange(samples) / samples)
    together = np.sum(np.abs(np.einsum("jt,lt,kt->ljk", tapers, signs, tapers)) ** 2, axis=(1, 2)) / TAPERS**2
    variance = np.sum(together[np.abs(np.subtract.outer(lines, lines))])
    mixed, every = np.array([[2.0, 0.0], [1.0, 0.5]]), []
    for seed in (2, 3):
        white = np.random.default_rng(seed).standard_normal((stretches, samples))
        power = [np.abs(np.fft.rfft(white * taper, axis=1)[:, lines]) ** 2 for taper in tapers]
        every.append(np.mean(power, axis=0) - 1)
    found = scatter(np.stack(every, axis=2) @ mixed.T) / stretches
    # 1000 stretches of 180 lines are some 20 000 sums that are independent: 1 %.
    np.testing.assert_allclose(found, variance * mixed @ mixed.T, atol=0.03 * 4 * variance)


def transfer_of(car: Suspension, model: RoadModel) -> Reach:
    trial = trial_of(car, CHANNELS, ("tire",))
    s = np.asarray(2j * np.pi * model.track.wide, complex)
    return reach(
        car, trial, physics_of(car, parameter_vector(car), np.zeros(2)), s, channel=1, wheel=1, rows=(), mounts=()
    )


def exact_problem(*, chassis: float = 22e3) -> TireProblem:
    """Return spectra that are exactly those expected, of which tire and wheel are 20 % off at the start."""
    model = road_model(track_of(), radius=None)
    exact = model.power(model.prior.mean, np.linspace(-3, 3, 20), transfer_of(QUARTER, model))
    model = replace(model, track=replace(model.track, power=exact))
    car = QUARTER.with_parameters(stiffness={"chassis": chassis, "tire": 170e3}, masses={"tire": 60})
    unknowns = unknowns_of(car, rate=30.0, fixed=["chassis"], free_masses=["tire"], nominal_std={"tire.damping": 0.5})
    return TireProblem(
        models=(model,), trials=(trial_of(car, CHANNELS, ("tire",)),), unknowns=unknowns,
        physics=(physics_of(car, parameter_vector(car), np.zeros(2)),), mounts=(),
    )  # fmt: skip


class TestTires:
    def test_of_exact_spectra_tires_are_exact(self) -> None:
        problem = exact_problem()
        fit = fit_tires(problem, [0])
        p = problem.unknowns.parameters(fit.state.x)
        np.testing.assert_allclose(p[[1, 3, 5]], [210e3, 60, 50], rtol=1e-3)
        np.testing.assert_allclose(fit.state.levels[0], np.linspace(-3, 3, 20), atol=5e-3)

    def test_a_change_of_the_suspension_moves_them_as_stated(self) -> None:
        fit = fit_tires(exact_problem(), [0])
        after = fit_tires(exact_problem(chassis=22e3 * 1.01), [0])
        change = (after.state.x - fit.state.x) / (22e3 * 0.01)
        np.testing.assert_allclose(fit.by_suspension[: len(change), 0], change, rtol=0.1)

    def test_the_order_of_the_wheels_does_not_matter(self) -> None:
        """Both wheels roll over one road: what they say of tires is summed over both before it is squared."""
        rng = np.random.default_rng(3)
        problem = exact_problem()
        (exact,) = problem.models
        first, second = (
            replace(exact, track=replace(exact.track, power=exact.track.power * rng.exponential(size=(20, 186))))
            for _ in range(2)
        )
        one, other = (fit_tires(replace(problem, models=m), [0]) for m in ((first, second), (second, first)))
        count = len(problem.unknowns)
        np.testing.assert_allclose(one.covariance[:count, :count], other.covariance[:count, :count], rtol=1e-2)


class TestDrives:
    def test_springs_and_dampers_do_not_depend_on_the_road(self) -> None:
        record, _ = drive(5)
        without = estimate(record, NOMINAL, given=("tire",))
        values = dict(zip(found().parameters, found().values, strict=True))
        for name, value in zip(without.parameters, without.values, strict=True):
            assert values[name] == value
        own = [found().parameters.index(name) for name in without.parameters]
        np.testing.assert_array_equal(without.covariance, found().covariance[np.ix_(own, own)])

    def test_tires_wheels_and_modes_are_found(self) -> None:
        ends = found().interval(0.999)
        for name, value in (("tire.stiffness", 210e3), ("tire.mass", 50.0), ("tire.damping", 60.0)):
            assert ends[name][0] < value < ends[name][1] < 2.8 * value
        modes, true = found().modes, eigenmodes(QUARTER)
        assert modes.channels == true.channels
        assert modes.wn_std is not None
        assert modes.zeta_std is not None
        for values, std, exact in ((modes.wn, modes.wn_std, true.wn), (modes.zeta, modes.zeta_std, true.zeta)):
            assert np.all(np.abs(values - exact) < 3.3 * std)
            assert np.all(std < 0.12 * exact)

    def test_the_road_has_its_class(self) -> None:
        (road,) = found().road
        low, high = road.interval(0.999) or (0.0, 0.0)
        assert low < 64e-6 < high < 1.7 * low
        assert abs(road.exponent - 2) < 3.3 * road.exponent_std < 0.6
        assert road.road_class == "B"
        assert set(road.classes) == {"B"}
        assert "class B" in str(found())

    def test_it_is_read_back_from_json(self) -> None:
        content = json.loads(to_json(estimate_to_dict(found())))
        validate(content, json_schema("estimate"))
        (road,), (back,) = found().road, estimate_from_dict(content).road
        assert str(back) == str(road)
        assert (back.classes, back.records) == (road.classes, road.records)
        for name in ("times", "speeds", "roughness", "roughness_std"):
            np.testing.assert_array_equal(getattr(back, name), getattr(road, name))

    def test_the_verdict_says_what_the_road_decided(self) -> None:
        codes = {check.remark.code for check in found().verdict.checks}
        assert {EstimateCheck.ROAD, EstimateCheck.TIRE_DAMPING} <= codes
        assert not codes & {EstimateCheck.CANCELS, EstimateCheck.STILL, EstimateCheck.NO_SPEED}
        assert found().verdict.level is Level.SOUND

    def test_an_unbalanced_wheel_is_modelled(self) -> None:
        record, speed = drive(9, order=80.0)
        options: dict[str, Any] = {"given": ("tire",), "free_masses": ("tire",), "road": "iso8608", "speed": speed}
        modelled, left_out = (estimate(record, NOMINAL, **options, wheel_radius=r) for r in (RADIUS, None))
        low, high = modelled.interval(0.999)["tire.mass"]
        assert low < 50 < high
        with_orders, without = (dict(zip(e.parameters, e.values, strict=True)) for e in (modelled, left_out))
        # The line of the wheel's rotation, near its resonance, looks like less damping: more mass.
        assert without["tire.mass"] / with_orders["tire.mass"] > 1.08
        assert EstimateCheck.NO_RADIUS in {check.remark.code for check in left_out.verdict.checks}

    def test_without_a_speed_there_is_no_class(self) -> None:
        record, _ = drive(5)
        blind = estimate(record, NOMINAL, given=("tire",), road="iso8608")
        assert blind.road[0].road_class is None
        assert blind.road[0].classes == ()
        assert blind.verdict.level is Level.CARE
        assert "tire.mass" not in blind.parameters

    def test_a_speed_may_be_a_channel(self) -> None:
        record, speed = drive(5)
        whole = as_response(record.time, np.vstack([record.y, speed]), (*CHANNELS, "speed"))
        by_name = estimate(
            whole, NOMINAL, given=("tire",), free_masses=("tire",), road="iso8608", speed="speed", wheel_radius=RADIUS
        )
        np.testing.assert_array_equal(by_name.values, found().values)
        assert EstimateCheck.UNUSED not in {check.remark.code for check in by_name.verdict.checks}

    def test_on_the_command_line(self, tmp_path: Path) -> None:
        record, speed = drive(5)
        whole = as_response(record.time, np.vstack([record.y, speed]), (*CHANNELS, "speed"))
        write_record(whole, tmp_path / "drive.csv")
        write_car(NOMINAL, tmp_path / "car.toml")
        words = ["estimate", str(tmp_path / "drive.csv"), "--car", str(tmp_path / "car.toml"), "--given", "tire"]
        words += ["--free-mass", "tire", "--road", "iso8608", "--speed", "speed", "--wheel-radius", str(RADIUS)]
        said = CliRunner().invoke(main, words)
        assert said.exit_code == 0, said.output
        assert "class B" in said.output
        assert "tire.mass" in said.output

    @pytest.mark.parametrize(
        ("options", "said"),
        [
            ({"road": "iso"}, "is not a model of a road"),
            ({"speed": 20.0}, "give road='iso8608' too"),
            ({"road": "iso8608", "given": ()}, "motion of the wheels is measured"),
            ({"road": "iso8608", "speed": "sped"}, "no channel 'sped'"),
            ({"road": "iso8608", "speed": np.ones(5)}, "5 values for a record of"),
            ({"road": "iso8608", "speed": -1.0}, "must be finite, and positive"),
            ({"road": "iso8608", "wheel_radius": 0.0}, "must be a positive number"),
            ({"road": "iso8608", "fixed": ["tire"]}, "fixed contains all tires"),
            ({"road": "iso8608", "fixed": ["chassis"]}, "at least one must be free"),
        ],
    )
    def test_what_is_wrong_is_said(self, options: dict[str, Any], said: str) -> None:
        record, _ = drive(5)
        with pytest.raises(InputError, match=said):
            estimate(record, NOMINAL, **{"given": ("tire",), **options})


def test_what_was_known_beforehand_is_not_said_to_be_hardly_known() -> None:
    names, values, wide = ["tire.damping"], np.array([60.0]), np.array([50.0])
    told, known = (far_or_vague(QUARTER, names, values, wide, assumed=a) for a in ((), names))
    assert EstimateCheck.VAGUE in {one.remark.code for one in told}
    assert EstimateCheck.VAGUE not in {one.remark.code for one in known}
