"""Curves of dampers found in drives, against the damper of a simulator that shares no equation with the library."""

import contextlib
import json
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.signal import lfilter
from scipy.stats import norm

from suspid import (
    DamperCurve,
    EstimationError,
    InputError,
    RecordError,
    Strut,
    Suspension,
    damper_curve,
    damper_curve_to_dict,
    half_car,
    quarter_car,
    simulate,
)  # fmt: skip
from suspid.greybox import curve_travel
from suspid.greybox.curve_fit import CurveFit, Linearised, Noise, Shape
from suspid.greybox.curve_following import INDEPENDENT_LINES
from suspid.greybox.curve_noise import Residual
from suspid.greybox.curve_settling import too_loud
from suspid.greybox.curve_travel import _expected, _turn_samples
from suspid.greybox.force_basis import bend_covariance, node_weights, placed_nodes, sign_between, smooth_weights
from suspid.greybox.latent_splines import (
    FINE_POINTS,
    at_samples,
    between_samples,
    filtered,
    filtered_samples,
    spline_through,
    stencils,
)  # fmt: skip
from suspid.greybox.line_test import line_test
from suspid.greybox.strut_motion import StrutMotion, strut_motion
from suspid.records import as_response
from suspid.reporting import json_schema, plot_damper_curve
from suspid.units import RealArray
from suspid.words.dampers import CurveCheck
from validation.dampers import LAWS, NOISE

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=16e3, tire_stiffness=210e3, chassis_damping=1800, tire_damping=60
)
DRIVES = Path(__file__).parent / "damper_drives.npz"
CHANNELS = ["chassis_acceleration", "tire_acceleration"]


@cache
def motion(law: str, friction: float = 0.0) -> dict[str, RealArray]:
    """Return one drive of 20 s on a road of class B, from a file of `validation.dampers.write_test_drives`."""
    with np.load(DRIVES) as file:
        return {name: np.asarray(file[f"{law}_{friction:g}_{name}"], float) for name in NOISE}


@cache
def found(law: str, friction: float = 0.0) -> DamperCurve:
    return damper_curve(record(law, friction), CAR, strut="chassis")


def record(law: str, friction: float = 0.0, names: Any = CHANNELS, *, share: float = 1.0) -> Any:
    rng, clean = np.random.default_rng(11), motion(law, friction)
    rows = [clean[name] + share * NOISE[name] * rng.standard_normal(len(clean[name])) for name in names]
    return as_response(0.005 * np.arange(len(rows[0]), dtype=float), np.array(rows, float), list(names))


class TestCurves:
    @pytest.mark.parametrize(("law", "friction"), [("bilinear", 0.0), ("digressive", 30.0)])
    def test_the_damper_of_the_simulator_is_found(self, law: str, friction: float) -> None:
        curve = found(law, friction)
        true = LAWS[law].force(curve.velocities)
        # Four standard deviations, of 20 s: all nodes of two curves in 99 % of runs.
        np.testing.assert_array_less(np.abs(curve.forces - true), np.maximum(4 * curve.std, 1e-9))
        assert np.max(curve.std) < 8.0
        assert abs(curve.stiffness - 22e3) < min(4 * curve.stiffness_std, 0.01 * 22e3)
        assert abs(curve.friction - friction) < min(4 * curve.friction_std, 8.0)
        assert not curve.linear
        assert "is not a straight line" in str(curve.verdict.headline)

    def test_steps_that_differ_by_rounding_are_one_rate(self) -> None:
        """Two stretches of a drive, each with the step of its own stamps: of their spectra the same lines count."""
        whole = record("linear")
        halves = [
            as_response(step * np.arange(2000, dtype=float), whole.outputs[:, use], CHANNELS)
            for step, use in ((0.005, slice(0, 2000)), (0.005 * (1 + 8e-11), slice(2000, 4000)))
        ]
        assert abs(damper_curve(halves, CAR, strut="chassis").stiffness - 22e3) < 0.02 * 22e3

    def test_a_viscous_damper_is_a_line(self) -> None:
        curve = found("linear")
        assert curve.linear
        assert curve.linear.level == 0.01
        assert curve.equivalent_damping() == pytest.approx(1300, abs=4 * curve.equivalent_damping_std())
        assert curve.equivalent_damping_std() < 13
        assert "is consistent with a straight line" in str(curve.verdict.headline)

    def test_the_equivalent_damping_is_that_of_the_true_curve(self) -> None:
        curve = found("bilinear")
        for amplitude in (0.05, 0.2):
            std = curve.equivalent_damping_std(amplitude)
            # Bilinear: the mean of both rates at any amplitude.
            assert curve.equivalent_damping(amplitude) == pytest.approx(1300, abs=4 * std + 1)
            assert std < 30

    def test_noise_is_told_apart(self) -> None:
        force, motion = found("bilinear").noise_std
        assert force == pytest.approx(350 * 0.03, rel=0.1)
        assert motion == pytest.approx(0.1, rel=0.3)
        assert found("bilinear").explains

    @pytest.mark.parametrize(("law", "friction"), [("bilinear", 0.0), ("digressive", 30.0)])
    def test_travel_instead_of_the_wheel(self, law: str, friction: float) -> None:
        names = ["chassis_acceleration", "chassis_travel"]
        curve = damper_curve(record(law, friction, names), CAR, strut="chassis")
        error = curve.forces - LAWS[law].force(curve.velocities)
        np.testing.assert_array_less(np.abs(error), np.maximum(4 * curve.std, 1e-9))
        assert np.max(curve.std) < 10
        assert abs(curve.stiffness - 22e3) < min(4 * curve.stiffness_std, 0.01 * 22e3)
        assert abs(curve.friction - friction) < min(4 * curve.friction_std, 10.0)
        assert curve.noise_std == pytest.approx((350 * 0.03, 2e-5), rel=0.2)
        assert curve.explains
        assert not curve.linear

    def test_friction_that_turns_late_does_not_soften_the_spring(self) -> None:
        """Friction bends the velocity where it turns; smooth velocities turn late, and k would be 0.1 % too small."""
        names = ["chassis_acceleration", "chassis_travel"]
        curve = damper_curve(record("digressive", 30.0, names, share=0.1), CAR, strut="chassis")
        assert abs(curve.stiffness - 22e3) < 3 * curve.stiffness_std
        assert curve.stiffness_std < 0.0005 * 22e3

    def test_a_viscous_damper_is_a_line_by_travel_too(self) -> None:
        curve = damper_curve(record("linear", names=["chassis_acceleration", "chassis_travel"]), CAR, strut="chassis")
        assert curve.linear
        assert curve.equivalent_damping() == pytest.approx(1300, abs=4 * curve.equivalent_damping_std())

    def test_two_records_are_one_of_both(self) -> None:
        one = record("bilinear")
        halves = [
            as_response(one.time[part], one.outputs[:, part], CHANNELS) for part in (slice(2000), slice(2000, None))
        ]
        curve = damper_curve(halves, CAR, strut="chassis")
        assert curve.stiffness == pytest.approx(found("bilinear").stiffness, abs=2 * curve.stiffness_std)

    def test_a_corner_of_a_half_car_by_statics(self) -> None:
        """Two struts and two body coordinates: forces follow from heave and pitch."""
        car = half_car(
            chassis_mass=700, pitch_inertia=800, front_tire_mass=45, rear_tire_mass=45, cg_to_front=1.2, cg_to_rear=1.4,
            front_stiffness=22e3, rear_stiffness=24e3, front_tire_stiffness=200e3, rear_tire_stiffness=200e3,
            front_damping=1300, rear_damping=1500, front_tire_damping=60, rear_tire_damping=60,
        )  # fmt: skip
        rng, t = np.random.default_rng(2), np.arange(0, 15, 0.005)
        roads = {name: np.cumsum(rng.standard_normal(len(t))) * 1e-3 for name in car.roads}
        smooth = {name: np.convolve(row, np.hanning(15) / 7, mode="same") for name, row in roads.items()}
        true = car.with_parameters(curve={"front": ((-1, -700.0), (0, 0), (1, 1900.0))})
        names = [f"{c}_acceleration" for c in car.coordinates]
        made = simulate(true, t, smooth, outputs=names, interpolation="cubic")
        made.outputs[:] += 0.02 * rng.standard_normal(made.outputs.shape)
        made = as_response(t, made.outputs, names)
        curve = damper_curve(made, car, strut="front", nodes=12)
        assert curve.stiffness == pytest.approx(22e3, rel=0.01)
        expected = np.where(curve.velocities > 0, 1900.0, 700.0) * curve.velocities
        np.testing.assert_allclose(curve.forces, expected, atol=15)


class TestStatistics:
    @pytest.mark.parametrize("level", [0.05, 0.2])
    def test_the_line_test_rejects_its_share_of_viscous_dampers(self, level: float) -> None:
        """Means of normal draws and their covariance, from few draws: the law of Hotelling's test, exactly."""
        nodes = np.array([-0.4, -0.25, -0.1, -0.05, 0.0, 0.05, 0.1, 0.25, 0.4])
        shape, rng, count = Shape(nodes=nodes, friction=True), np.random.default_rng(5), 26
        true = np.concatenate([[22e3], 1300 * shape.moving, [0.0]])
        mixed = np.diag([200.0, *np.full(8, 10.0), 3.0]) @ (np.eye(10) + 0.3 * rng.standard_normal((10, 10)))
        blocks, nothing = np.zeros((count - 1 + len(true), 0)), np.zeros(0)
        part = Linearised(
            normal=nothing, gradient=nothing, change=nothing, per_unknown=nothing, scores=blocks,
            force_residual=nothing, velocity=nothing,
        )  # fmt: skip

        def rejected() -> bool:
            drawn = true + rng.standard_normal((count, 10)) @ mixed.T
            fit = CurveFit(
                theta=drawn.mean(axis=0), covariance=np.cov(drawn.T) / count, splines=(), records=(part,), steps=1,
                settled=True,
            )  # fmt: skip
            return not line_test(shape, fit, level)

        # 2000 draws tell 5 % to 0.5 %, 20 % to 0.9 %.
        assert np.mean([rejected() for _ in range(2000)]) == pytest.approx(level, abs=0.018 if level < 0.1 else 0.03)

    @pytest.mark.slow
    def test_stated_errors_and_misfit_are_those_of_repeated_noise(self) -> None:
        """The same drive with eight draws of noise; each has twelve nodes."""
        clean, law = motion("bilinear"), LAWS["bilinear"]
        squares, misfits = [], []
        for seed in range(8):
            rng = np.random.default_rng([31, seed])
            rows = [clean[name] + NOISE[name] * rng.standard_normal(len(clean[name])) for name in CHANNELS]
            made = as_response(0.005 * np.arange(len(rows[0]), dtype=float), np.array(rows), CHANNELS)
            curve = damper_curve(made, CAR, strut="chassis", nodes=12)
            moves = curve.velocities != 0
            error = curve.forces - law.force(curve.velocities)
            squares.append(np.mean((error[moves] / curve.std[moves]) ** 2))
            misfits.append(curve.chi_square / curve.freedom)
        assert 0.4 < np.mean(squares) < 1.1
        # Eight draws tell the mean of chi-square over its freedom, one, to 13 %.
        assert np.mean(misfits) == pytest.approx(1.0, abs=0.45)


class TestResidual:
    """A force of its own on the body costs precision; what follows the motion of the strut is missing in it."""

    @staticmethod
    def changed(body: RealArray | float = 0.0, wheel: float = 1.0, delay: float = 0.0) -> DamperCurve:
        one = record("bilinear")
        f = np.fft.rfftfreq(len(one.time), 0.005)
        late = np.fft.irfft(np.fft.rfft(one.outputs[1]) * np.exp(-2j * np.pi * f * delay), len(one.time))
        rows = np.array([one.outputs[0] + body, wheel * late])
        return damper_curve(as_response(one.time, rows, CHANNELS), CAR, strut="chassis")

    @pytest.mark.parametrize("kind", ["engine", "engine whose speed changes"])
    def test_forces_on_the_body_are_no_fault_of_the_curve(self, kind: str) -> None:
        t = 0.005 * np.arange(len(record("bilinear").time))
        hertz = 27 + 4 * np.sin(2 * np.pi * t / 20) * (kind != "engine")
        force = np.sqrt(2) * np.sin(2 * np.pi * np.cumsum(hertz) * 0.005)
        curve, quiet = self.changed(30.0 / 350 * force), found("bilinear")
        assert curve.explains
        assert CurveCheck.ADDED in {check.code for check in curve.verdict.notes}
        assert curve.stiffness_std > quiet.stiffness_std
        assert abs(curve.stiffness - quiet.stiffness) < 3 * curve.stiffness_std
        apart = (curve.forces - np.interp(curve.velocities, quiet.velocities, quiet.forces))[curve.velocities != 0]
        inside = np.abs(apart) < 1.96 * np.hypot(curve.std, 2.0)[curve.velocities != 0]
        assert np.mean(inside) > 0.85

    @pytest.mark.parametrize("seed", [3, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (4, 5))])
    def test_gusts_are_doubted_or_within_the_intervals(self, seed: int) -> None:
        """Forces of a tenth of a second: the strut moves with them, which looks like another stiffness."""
        noise = np.random.default_rng(seed).standard_normal(len(record("bilinear").time))
        gusts = lfilter([np.sqrt(1 - 0.95**2)], [1, -0.95], noise)
        curve, quiet = self.changed(30.0 / 350 * gusts), found("bilinear")
        assert not curve.explains or abs(curve.stiffness - quiet.stiffness) < 2 * curve.stiffness_std

    @pytest.mark.parametrize(
        ("loud", "doubted"), [([0], True), ([7], False), ([3, 9, 12], False), (range(8, 16), True)]
    )
    def test_where_the_residual_may_be_loud(self, loud: Sequence[int], doubted: bool) -> None:
        """The strut moves with a force in the first band, of up to 3.5 Hz; half of the bands are no engine."""
        expected = np.stack([np.full(16, 0.5), 0.5 / (1 + np.arange(16)) ** 2], axis=1)
        power = np.where(np.isin(np.arange(16), loud), 9.0, 1.0) * expected.sum(axis=1)
        left = Residual(power=power, expected=expected, independent=np.full(16, 200.0), velocity=0.001)
        one = strut_motion(record("bilinear"), CAR, "chassis", None)
        fit = CurveFit(theta=np.array([22e3]), covariance=np.eye(1), splines=(), records=(), steps=1, settled=True)
        assert too_loud([one], fit, Noise(force=10.0, motion=0.1), left) is doubted

    def test_noise_does_not_follow(self) -> None:
        """F of a hundred degrees of freedom in each of sixteen bands: its mean is one to a sixth or so."""
        for law in ("linear", "bilinear"):
            assert found(law).following == pytest.approx(1.0, abs=0.5)

    def test_lines_and_stretches_that_are_not_independent(self) -> None:
        """White noise under Hann windows that overlap by half: one over the sum of all squared correlations."""
        window, at = np.hanning(2001), np.arange(2001)
        total = 0.0
        for shift in (0, 1000):
            product = window[shift:] * window[: 2001 - shift]
            lines = [np.sum(product * np.exp(2j * np.pi * k * at[: len(product)] / 2001)) for k in range(-9, 10)]
            total += (1 if shift == 0 else 2) * np.sum(np.abs(np.array(lines) / np.sum(window**2)) ** 2)
        assert pytest.approx(1 / total, rel=2e-3) == INDEPENDENT_LINES

    @pytest.mark.parametrize(("wheel", "delay"), [(1.2, 0.0), (1.0, 0.002), (1.0, -0.002)])
    def test_wrong_sensors_are(self, wheel: float, delay: float) -> None:
        curve = self.changed(0.0, wheel, delay)
        assert not curve.explains
        assert CurveCheck.FOLLOWS in {check.code for check in curve.verdict.doubts}
        assert curve.following > found("bilinear").following

    def test_wrong_sensors_are_not_taken_for_an_engine(self) -> None:
        t = 0.005 * np.arange(len(record("bilinear").time))
        curve = self.changed(0.1 * np.sin(2 * np.pi * 27 * t), delay=0.0005)
        assert not curve.explains


class TestResult:
    def test_the_strut_is_simulated(self) -> None:
        curve = found("digressive", 30.0)
        strut = curve.strut
        assert isinstance(strut, Strut)
        assert strut.friction == pytest.approx(30, abs=8)
        t = np.arange(0, 1, 0.005)
        made = simulate(curve.car, t, {"road": 0.01 * np.sin(9 * t)}, outputs=CHANNELS)
        assert np.all(np.isfinite(made.outputs))

    def test_json_keeps_every_number(self) -> None:
        curve = found("bilinear")
        content = json.loads(json.dumps(damper_curve_to_dict(curve)))
        jsonschema.validate(content, json_schema("damper"))
        assert [node["force"] for node in content["nodes"]] == curve.forces.tolist()
        low, high = curve.interval(0.95)
        assert content["nodes"][0]["lower"] == low[0]
        assert content["linear"]["accepted"] is False
        np.testing.assert_allclose(high - curve.forces, norm.ppf(0.975) * curve.std)

    def test_text_fits_a_screen(self) -> None:
        lines = str(found("digressive", 30.0)).splitlines()
        assert len(lines) < 30
        assert any(re.match(r"friction 3\d", line) for line in lines)

    def test_picture(self) -> None:
        curve = found("digressive", 30.0)
        ax = plot_damper_curve(curve, Figure().subplots())
        drawn = np.concatenate([line.get_ydata() for line in ax.get_lines()])
        assert np.isin(np.round(curve.totals[-1], 9), np.round(drawn, 9))


class TestForceOnTheBody:
    def test_it_is_not_taken_for_stiffness(self) -> None:
        """60 N between 1 and 3 Hz move a linear car: by superposition, as its transfer functions say."""
        one, rng = record("linear"), np.random.default_rng(4)
        count = one.outputs.shape[1]
        f = np.fft.rfftfreq(count, 0.005)
        force = np.where((f > 1) & (f < 3), rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size), 0)
        force *= 60.0 / np.std(np.fft.irfft(force, count))
        s = 2j * np.pi * f
        strut, tire = 1300 * s + 22e3, 60 * s + 210e3
        body, wheel = 350 * s**2 + strut, 50 * s**2 + strut + tire
        moved = np.array([wheel, strut]) / (body * wheel - strut**2) * s**2 * force
        pushed = as_response(one.time, one.outputs + np.fft.irfft(moved, count, axis=1), CHANNELS)
        curve = damper_curve(pushed, CAR, strut="chassis")
        # Four standard deviations of 20 s. With noise in both signals alone, nothing is determined.
        assert abs(curve.stiffness - 22e3) < min(4 * curve.stiffness_std, 0.02 * 22e3)
        assert np.all(np.abs(curve.forces - 1300 * curve.velocities) < 4 * curve.std + 1e-9)
        assert curve.explains
        assert CurveCheck.ADDED in {check.code for check in curve.verdict.notes}


class TestRefusals:
    @pytest.mark.parametrize(
        ("changes", "error", "message"),
        [
            ({"strut": "seat"}, InputError, "there is no strut 'seat'"),
            ({"strut": "tire"}, RecordError, "give 'tire_travel', or 'road_acceleration'"),
            ({"strut": "tire", "given": ["tire"]}, InputError, "acts on no sprung mass"),
            ({"strut": "chassis", "given": ["wheel"]}, InputError, "there is no coordinate 'wheel'"),
            ({"strut": "chassis", "nodes": 2}, InputError, "a whole number from 4"),
            ({"strut": "chassis", "nodes": 12.5}, InputError, "a whole number from 4"),
            ({"strut": "chassis", "nodes": 5000}, InputError, "to 100"),
            ({"strut": "chassis", "level": 1.5}, InputError, "must lie between 0 and 1"),
        ],
    )
    def test_what_is_asked(self, changes: dict[str, Any], error: type[Exception], message: str) -> None:
        with pytest.raises(error, match=message):
            damper_curve(record("linear"), CAR, **changes)

    def test_one_sensor(self) -> None:
        with pytest.raises(
            RecordError, match="motion of strut 'chassis' is not measured: give 'chassis_travel', or 'tire_acc"
        ):
            damper_curve(record("linear", names=CHANNELS[:1]), CAR, strut="chassis")
        with pytest.raises(RecordError, match="accelerations of the sprung masses .*are not measured"):
            damper_curve(record("linear", names=CHANNELS[1:]), CAR, strut="chassis")

    def test_short(self) -> None:
        one = record("linear")
        with pytest.raises(RecordError, match="at least 1000 are needed"):
            damper_curve(as_response(one.time[:500], one.outputs[:, :500], CHANNELS), CAR, strut="chassis")

    def test_struts_that_statics_do_not_tell_apart(self) -> None:
        second = Strut(name="bar", stiffness=1e3, damping=0.0, arms={"chassis": 1.0, "tire": -1.0})
        twin = Suspension(masses=CAR.masses, struts=[*CAR.struts, second])
        with pytest.raises(InputError, match=r"forces of 2 struts .* do not follow from"):
            damper_curve(record("linear"), twin, strut="chassis")


class TestSplines:
    """The spline of a sine, its derivatives and the filter, against the sine itself."""

    step, hertz = 0.005, 9.0
    t = 0.005 * np.arange(400)

    def test_derivatives(self) -> None:
        w = 2 * np.pi * self.hertz
        c = spline_through(np.sin(w * self.t))
        middle = slice(40, -40)
        np.testing.assert_allclose(at_samples(c, 0, self.step), np.sin(w * self.t), atol=1e-12)
        np.testing.assert_allclose(at_samples(c, 1, self.step)[middle] / w, np.cos(w * self.t)[middle], atol=2e-5)
        np.testing.assert_allclose(at_samples(c, 2, self.step)[middle] / w**2, -np.sin(w * self.t)[middle], atol=1e-3)
        fine = between_samples(c, 1, self.step)
        times = np.linspace(0, self.t[-1], len(fine))
        np.testing.assert_allclose(fine[200:-200] / w, np.cos(w * times)[200:-200], atol=2e-5)

    def test_weights_of_the_values_add_to_one(self) -> None:
        np.testing.assert_allclose(stencils(0).sum(axis=1), 1.0, atol=1e-12)
        np.testing.assert_allclose(stencils(1).sum(axis=1), 0.0, atol=1e-12)

    def test_both_filters_are_one(self) -> None:
        fine = np.linspace(0, self.t[-1], 399 * FINE_POINTS + 1)
        wave = np.sin(2 * np.pi * self.hertz * fine)
        a, b = filtered(wave, self.step, 60.0), filtered_samples(wave[::FINE_POINTS], self.step, 60.0)
        np.testing.assert_allclose(a[30:-30], b[30:-30], atol=1e-3)
        np.testing.assert_allclose(a[30:-30], wave[::FINE_POINTS][30:-30], atol=2e-3)


class TestBasis:
    def test_weights_reproduce_any_curve_that_is_straight_between_the_nodes(self) -> None:
        nodes, forces = np.array([-1.0, -0.2, 0.0, 0.5]), np.array([-500.0, -200.0, 0.0, 900.0])
        v = np.linspace(-0.99, 0.49, 50)
        np.testing.assert_allclose(node_weights(v, nodes) @ forces, np.interp(v, nodes, forces))

    def test_expected_weights_are_means_over_the_error(self) -> None:
        nodes, v = np.array([-1.0, -0.2, 0.0, 0.5]), np.array([-1.1, -0.21, 0.005, 0.6])
        drawn = v[:, None] + 0.05 * np.random.default_rng(1).standard_normal((4, 400_000))
        expected = node_weights(drawn.ravel(), nodes).reshape(4, -1, 4).mean(axis=1)
        np.testing.assert_allclose(smooth_weights(v, nodes, 0.05), expected, atol=1.5e-3)
        np.testing.assert_allclose(smooth_weights(v, nodes, 1e-9), node_weights(v, nodes), atol=1e-6)

    @pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
    def test_a_kink_between_nodes_is_in_the_intervals(self, share: float) -> None:
        """The best broken line of a kinked curve, by least squares: its error is within two standard deviations."""
        nodes, v = np.linspace(-0.4, 0.4, 9), np.linspace(-0.4, 0.4, 4001)
        kink = nodes[6] + share * 0.1
        forces = np.linalg.lstsq(node_weights(v, nodes), 1000 * np.maximum(v - kink, 0), rcond=None)[0]
        error = forces - 1000 * np.maximum(nodes - kink, 0)
        std = np.sqrt(np.diag(bend_covariance(nodes, forces)))
        assert np.all(np.abs(error[6:8]) < 2 * std[6:8])
        assert np.all(std < 10)

    def test_a_kink_at_a_node_adds_nothing(self) -> None:
        nodes = np.linspace(-0.4, 0.4, 9)
        np.testing.assert_allclose(bend_covariance(nodes, np.maximum(nodes, 0)), 0, atol=1e-12)
        np.testing.assert_allclose(bend_covariance(nodes, 3 * nodes), 0, atol=1e-12)

    def test_nodes_stand_where_there_are_samples(self) -> None:
        v = np.random.default_rng(1).normal(0, 0.15, 12_000)
        nodes = placed_nodes(v, 24, 0.03)
        assert len(nodes) == 25
        assert np.all(np.diff(nodes) > 0)
        assert 0.0 in nodes
        assert min(np.sum(v > nodes[-1]), np.sum(v < nodes[0])) >= 29
        assert np.min(np.abs(nodes[nodes != 0])) == pytest.approx(0.03)

    def test_expected_sign(self) -> None:
        """A slow passage through rest: the mean of the sign of normal velocities, by sampling."""
        v = np.linspace(-0.01, 0.01, 2001)
        drawn = v[::200, None] + 0.002 * np.random.default_rng(1).standard_normal((11, 100_000))
        np.testing.assert_allclose(sign_between(v, 0.002)[::200], np.sign(drawn).mean(axis=1), atol=0.015)

    def test_a_fast_passage_is_averaged(self) -> None:
        v = np.array([-0.3, -0.1, 0.3, 0.5])
        # Half of the mean over each of the neighbouring steps: (-1 + 1/2) / 2 and (1/2 + 1) / 2.
        np.testing.assert_allclose(sign_between(v, 1e-6), [-1.0, -0.25, 0.75, 1.0], atol=1e-4)


class TestNothingToTell:
    """What says nothing is refused with the reason, and no number is printed."""

    def test_a_sign_that_is_not_known(self) -> None:
        """A wheel's sensor that is upside down leaves intervals wider than all forces."""
        turned = record("bilinear")
        turned.outputs[1] *= -1
        with pytest.raises(EstimationError, match=r"not even the sign .* sensor is wrong"):
            damper_curve(turned, CAR, strut="chassis", nodes=12)

    @pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3))])
    def test_slow_forces_on_the_body(self, seed: int) -> None:
        """100 N from 1 to 3 Hz, which move the body: the forces are within their intervals, or nothing is said."""
        curve = None
        one, rng = record("bilinear"), np.random.default_rng(seed)
        f = np.fft.rfftfreq(len(one.time), 0.005)
        noise = np.fft.irfft(np.where((f > 1) & (f < 3), np.fft.rfft(rng.standard_normal(len(one.time))), 0))
        one.outputs[0] += 100.0 / 350 * noise / np.std(noise)
        with contextlib.suppress(EstimationError):
            curve = damper_curve(one, CAR, strut="chassis")
        if curve is not None:
            assert np.max(np.abs(curve.forces - LAWS["bilinear"].force(curve.velocities))) < np.max(curve.forces)
            error = (curve.forces - LAWS["bilinear"].force(curve.velocities))[curve.velocities != 0]
            assert np.mean(np.abs(error) < 1.96 * curve.std[curve.velocities != 0]) > 0.85
            assert abs(curve.stiffness - 22e3) < 2.6 * curve.stiffness_std

    @pytest.mark.parametrize("row", [0, 1])
    def test_a_sample_that_is_no_motion(self, row: int) -> None:
        spiked = record("bilinear")
        spiked.outputs[row, 1777] += 1e4
        with pytest.raises(RecordError, match=rf"{CHANNELS[row]} has samples that are no motion .* 8\.885 s"):
            damper_curve(spiked, CAR, strut="chassis")


class TestTurns:
    """Friction holds a strut at a turn until the other forces have changed by its double."""

    STEP = 0.005

    def motion(self) -> StrutMotion:
        t = self.STEP * np.arange(8000)
        noise = np.random.default_rng(4).standard_normal(len(t))
        # 40 N in each sample, up and down in turn, and a travel whose velocity is 0.25 m/s at most.
        force = 40.0 * np.abs((np.arange(len(t)) + 50) % 200 - 100.0)
        travel = 0.02 * np.sin(2 * np.pi * 2.0 * t) + 2e-5 * noise
        return StrutMotion(step=self.STEP, force=force, motion=travel, share=0.0, travel=True, channels=("a", "b"))

    def test_for_double_the_friction_over_the_change_of_force(self) -> None:
        # The filter rounds the corners, which are 2 of 100 samples.
        assert _turn_samples([self.motion()], 60.0) == pytest.approx(2 * 60.0 / 40.0, rel=0.02)

    @pytest.mark.parametrize("held", [True, False])
    def test_then_every_moment_near_rest_is_left_out(self, held: bool) -> None:
        """Where the velocity of the sine is within two errors, and four samples to either side."""
        moved = _expected(self.motion(), 2e-5, np.random.default_rng(1), held=held)
        t = self.STEP * np.arange(8000)
        speed = 0.02 * 2 * np.pi * 2.0 * np.abs(np.cos(2 * np.pi * 2.0 * t))
        passed = [i for i in np.flatnonzero(speed < 0.2 * moved.error) if 300 < i < 7700]
        first = 8000 - len(moved.moves)
        near = np.array([[moved.moves[i - first // 2 + k] for k in range(-4, 5)] for i in passed])
        assert len(passed) > 20
        assert np.all(near == 0) == held

    @pytest.mark.parametrize(("lasts", "held"), [([0.9], [False] * 5), ([0.9, 1.1, 0.9], [False] * 2 + [True] * 3)])
    def test_a_sample_or_more_counts(self, lasts: list[float], held: list[bool], monkeypatch: Any) -> None:
        """Round by round, and once found it stays so: the friction of the next round is another."""
        rounds, asked = iter(lasts), list[bool]()

        def expected(*given: Any, held: bool) -> Any:
            asked.append(held)
            return _expected(*given, held=held)

        monkeypatch.setattr(curve_travel, "_expected", expected)
        monkeypatch.setattr(curve_travel, "_turn_samples", lambda *_: next(rounds, lasts[-1]))
        damper_curve(record("digressive", 30.0, ("chassis_acceleration", "chassis_travel")), CAR, strut="chassis")
        assert asked == held
