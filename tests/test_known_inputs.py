"""Gains and delays of channels beside known roads and forces, and noise of these, by laws and an independent motion."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from suspid import InputError, estimate, half_car
from suspid.greybox.further import INPUTS
from suspid.greybox.noisy_inputs import _score
from suspid.greybox.problem import Problem
from suspid.greybox.sensors_asked import further_asked
from suspid.greybox.transfers import Physics, layout_of, shown_by_causes, transfer
from suspid.greybox.trials import HOLDS, Hold, Trial, trials_of
from suspid.reconstruction import Unknowns, parameter_vector, unknowns_of
from suspid.records import as_response
from suspid.words import Level
from suspid.words.greybox import EstimateCheck
from validation.greybox_rows import NOISE, QUARTER, WHEEL_SENSOR, Row, rig_row, swept
from validation.motion import matrices

QUIET = dict.fromkeys(NOISE, 1e-6)
NONE: dict[str, Any] = {"gains": (), "delays": (), "mounts": ()}


def row(length: float = 6.0, channel: str = "road", **options: Any) -> Row:
    shape = swept(length) * (1.0 if channel == "road" else 1e5)
    return rig_row("", channel, shape, **{"std": NOISE, **options})


def fitted(one: Row, seed: int = 1, **options: Any) -> Any:
    record = one.record(np.random.default_rng(seed))
    return estimate(record, one.nominal, given=one.given, **{**one.options, **options})


def value(found: Any, name: str) -> float:
    return float(found.values[found.parameters.index(name)])


def holds(found: Any) -> bool:
    """Return whether nearly sure intervals of springs and dampers hold."""
    ends = found.interval(0.9999)
    truth = {"chassis.stiffness": 22e3, "tire.stiffness": 210e3, "chassis.damping": 1300.0, "tire.damping": 60.0}
    return all(ends[name][0] < true < ends[name][1] for name, true in truth.items())


def bare_unknowns() -> Unknowns:
    return unknowns_of(
        QUARTER, rate=10.0, fixed=[], bounds=None, ties=(), nominal_std=None, free_masses=["tire"]
    )  # fmt: skip


class TestDelays:
    @pytest.mark.parametrize("hold", HOLDS)
    def test_slopes_are_those_of_finite_differences(self, hold: Hold) -> None:
        record = row(1.0).record(np.random.default_rng(1))
        trials = trials_of(record, QUARTER, ["road"])
        names = ["tire_acceleration", "road"]
        unknowns, trials = further_asked(bare_unknowns(), trials, gains=names, delays=names, mounts=["chassis"])
        assert [channel for _, channel in unknowns.delays] == [1, INPUTS]  # type: ignore[attr-defined]
        problem = Problem(trials=trials, holds=(hold,), unknowns=unknowns)
        x = unknowns.nominal.copy()
        # The delays are neither whole steps nor of one sign.
        x[-4:] = [1.03, 0.97, 0.23, -0.67]
        # Of a record that the start and the offsets leave nothing of, the projection does not move.
        exact = trials[0].values - problem.errors(x, [np.ones(2)])[0].residual
        problem = replace(problem, trials=(replace(trials[0], values=exact),))
        slope = problem.errors(x, [np.ones(2)])[0].slope @ unknowns.spread[unknowns.rows]
        for i, size in enumerate(np.maximum(np.abs(x), 0.1) * 1e-5):
            step = np.eye(len(x))[i] * size
            high, low = (problem.errors(at, [np.ones(2)])[0].residual for at in (x + step, x - step))
            difference = (high - low) / (2 * size)
            np.testing.assert_allclose(slope[:, :, i], difference, atol=2e-6 * np.max(np.abs(difference)))

    @pytest.mark.parametrize("delay", [0.002, 0.0125])
    def test_a_late_channel_of_another_gain_is_found(self, delay: float) -> None:
        found = fitted(row(std=QUIET, sensor=(1.02, delay)), **WHEEL_SENSOR)
        assert found.parameters[-2:] == ("tire_acceleration.gain", "tire_acceleration.delay")
        assert value(found, "tire_acceleration.gain") == pytest.approx(1.02, rel=1e-5)
        assert value(found, "tire_acceleration.delay") == pytest.approx(delay, abs=1e-7)
        assert value(found, "chassis.stiffness") == pytest.approx(22e3, rel=1e-4)

    def test_both_are_found_where_nothing_is_asked(self) -> None:
        found = fitted(row(sensor=(1.04, 0.004)))
        assert found.explains
        assert found.verdict.level is Level.SOUND
        assert set(found.parameters[4:]) == {"tire_acceleration.gain", "tire_acceleration.delay"}
        (said,) = [one for one in found.verdict.checks if one.remark.code is EstimateCheck.NEEDED]
        assert set(said.remark.numbers["names"]) == set(found.parameters[4:])
        assert holds(found)
        # Held, they are missed and told.
        assert not fitted(row(sensor=(1.04, 0.004)), **NONE).explains

    @pytest.mark.parametrize("channel", ["road", "chassis_force"])
    def test_sensors_that_are_right_are_left_alone(self, channel: str) -> None:
        for seed in (1, 2):
            assert fitted(row(channel=channel), seed).parameters[4:] == ()

    def test_a_channel_that_is_late_by_many_cycles_is_found(self) -> None:
        found = fitted(row(10.0, sensor=(1.0, 1.2)))
        assert found.explains
        assert value(found, "tire_acceleration.delay") == pytest.approx(1.2, abs=1e-3)
        assert holds(found)

    def test_the_delay_of_the_road_is_that_of_all_channels_turned_round(self) -> None:
        late = fitted(row(sensor=(1.0, 0.003)), delays=["road", "tire_acceleration"], gains=(), mounts=())
        each = ["chassis_acceleration", "tire_acceleration"]
        other = fitted(row(sensor=(1.0, 0.003)), delays=each, gains=(), mounts=())
        assert -value(late, "road.delay") == pytest.approx(value(other, "chassis_acceleration.delay"), abs=1e-8)
        np.testing.assert_allclose(late.values[:4], other.values[:4], rtol=1e-6)

    @pytest.mark.parametrize("seed", [1, 2])
    def test_channels_that_are_all_late_need_no_mount(self, seed: int) -> None:
        record = row().record(np.random.default_rng(seed))
        # Every channel shows what it does a step later; the beginning is no rest.
        late = as_response(
            record.time[:-1], record.outputs[:, :-1], record.output_labels, inputs={"road": record.inputs.ravel()[1:]}
        )
        found = estimate(late, QUARTER, given=["road"])
        assert found.explains
        assert {name for name in found.parameters if name.endswith(".relaxation")} == set()
        assert value(found, "chassis_acceleration.delay") == pytest.approx(1 / 200, abs=6e-4)
        assert holds(found)

    def test_a_rigid_mount_differs_from_none_by_nothing(self) -> None:
        for seed in (1, 2):
            found = fitted(row(), seed, mounts=["chassis"])
            assert found.interval(0.95)["chassis.relaxation"][0] == 0
            assert "chassis.relaxation" not in found.beyond_chance()

    def test_what_cannot_be_told_is_refused(self) -> None:
        with pytest.raises(InputError, match="gains: of all channels together only ratios"):
            fitted(row(), gains=["road", "chassis_acceleration", "tire_acceleration"])
        with pytest.raises(InputError, match="delays: of all channels together only differences"):
            fitted(row(), delays=["road", "chassis_acceleration", "tire_acceleration"])
        car = half_car(
            chassis_mass=600, pitch_inertia=900, front_tire_mass=40, rear_tire_mass=40, cg_to_front=1.25,
            cg_to_rear=1.25, front_stiffness=21e3, rear_stiffness=22e3, front_tire_stiffness=190e3,
            rear_tire_stiffness=190e3, front_damping=1350, rear_damping=1350,
        )  # fmt: skip
        rng, times = np.random.default_rng(1), np.arange(400) / 200
        roads = {name: rng.standard_normal(400) for name in car.roads}
        record = as_response(times, rng.standard_normal((2, 400)), ["heave", "pitch"], inputs=roads)
        with pytest.raises(InputError, match=r"one of several known roads and forces.*'heave', 'pitch'"):
            estimate(record, car, given=["roads"], delays=[car.roads[0]])


class TestNoiseOfInputs:
    @pytest.mark.parametrize("channel", ["road", "chassis_force"])
    def test_transfers_are_those_of_the_independent_equations(self, channel: str) -> None:
        record = row(1.0, channel).record(np.random.default_rng(1))
        trial = trials_of(record, QUARTER, [channel])[0].with_noisy_inputs()
        layout, s = layout_of(QUARTER, trial), 2j * np.pi * np.array([0.7, 3.0, 12.0, 24.0])
        p = parameter_vector(QUARTER)
        physics = _physics(p)
        A, B, P, Q = matrices(QUARTER)
        column = [B[:, 0] + one * B[:, 1] if channel == "road" else B[:, 2] for one in s]
        direct = [Q[:, 0] + one * Q[:, 1] if channel == "road" else Q[:, 2] for one in s]
        expected = [
            P @ np.linalg.solve(one * np.eye(4) - A, b) + q for one, b, q in zip(s, column, direct, strict=True)
        ]
        np.testing.assert_allclose(shown_by_causes(layout, s, physics)[:, :, 0], expected, rtol=1e-9)
        made = transfer(layout, s, physics, list(range(6)), mounts=[], gains=[], delays=[])
        for i in range(6):
            step = np.eye(6)[i] * 1e-5 * p
            high, low = (shown_by_causes(layout, s, _physics(at)) for at in (p + step, p - step))
            slope, expected = (
                made.left[:, :, i] * made.right[:, made.places[i], :1],
                (high - low)[:, :, 0] / (2e-5 * p[i]),
            )
            np.testing.assert_allclose(slope, expected, atol=1e-7 * np.max(np.abs(expected)))

    @pytest.mark.parametrize("channel", ["road", "chassis_force"])
    def test_its_level_is_found_and_allowed_for(self, channel: str) -> None:
        # A force is small beside what moves a car at the same share.
        share = 0.05 if channel == "road" else 0.3
        one = row(20.0, channel, input_noise=share)
        found, blind = fitted(one), fitted(one, noisy=(), **NONE)
        assert found.explains
        assert found.verdict.level is Level.SOUND
        assert holds(found)
        assert not blind.explains
        assert EstimateCheck.NOISY_INPUTS in {check.remark.code for check in found.verdict.checks}
        assert found.causes == ((channel,),)
        assert found.fitted[0].output_labels[-1] == channel
        scale = 1.0 if channel == "road" else 1e5
        # 0.003 / sqrt(2) of a sweep, of which 500 lines are used.
        assert found.noise_std[0][-1] == pytest.approx(share * 0.003 / np.sqrt(2) * scale, rel=0.1)
        asked = fitted(one, noisy=[channel])
        np.testing.assert_allclose(asked.values, found.values, rtol=1e-9)

    @pytest.mark.slow
    def test_a_late_channel_beside_a_noisy_road_is_found(self) -> None:
        found = fitted(row(20.0, input_noise=0.05, sensor=(1.05, 0.006)))
        assert found.explains
        assert {EstimateCheck.NOISY_INPUTS, EstimateCheck.NEEDED} <= {c.remark.code for c in found.verdict.checks}
        assert value(found, "tire_acceleration.delay") == pytest.approx(0.006, abs=2e-4)
        assert holds(found)

    @pytest.mark.slow
    def test_noise_that_a_late_channel_hides_is_found(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("suspid.greybox.fitted_in_time.noise_told", lambda *_: False)
        found = fitted(row(20.0, input_noise=0.05, sensor=(1.05, 0.006)))
        assert found.explains
        assert value(found, "tire_acceleration.delay") == pytest.approx(0.006, abs=2e-4)
        assert holds(found)

    def test_it_is_asked_for_where_it_applies(self) -> None:
        with pytest.raises(InputError, match=r"noisy: 'rode'.*'road'"):
            fitted(row(), noisy=["rode"])
        record = row().record(np.random.default_rng(1))
        decay = as_response(record.time, record.outputs, record.output_labels)
        with pytest.raises(InputError, match="noisy: the records have no known road or force"):
            estimate(decay, QUARTER, noisy=["road"])
        still = as_response(
            record.time, record.outputs, record.output_labels, inputs={"road": np.zeros(record.time.size)}
        )
        with pytest.raises(InputError, match="noisy: 'road' of record 1 never change"):
            estimate(still, QUARTER, given=["road"], noisy=["road"])
        with pytest.raises(InputError, match="noisy: the noise of measured motion is always allowed for"):
            estimate(record, QUARTER, given=["tire"], noisy=["tire_acceleration"])

    def test_the_score_of_its_level_has_its_mean_and_variance(self) -> None:
        # Of errors S + q T T^H the score has the mean q times its variance; wrong levels of the outputs do not move it.
        rng, std, level, draws = np.random.default_rng(1), np.array([0.5, 2.0]), 0.05, 1500
        T = (rng.standard_normal((60, 2, 1)) + 1j * rng.standard_normal((60, 2, 1))) * np.linspace(0.3, 2, 60)[
            :, None, None
        ]

        def normal(*shape: int) -> Any:
            return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)

        size = np.mean(np.sum(np.abs(T[:, :, 0] / std) ** 2, axis=1))
        for q, off in ((0.0, 1.0), (level, 1.0), (0.0, 1.1)):
            scores = []
            for _ in range(draws):
                left = off * std * normal(60, 4, 2) + np.sqrt(q) * normal(60, 4, 1) * T[:, None, :, 0]
                w: Any = SimpleNamespace(transfer=SimpleNamespace(T=T), left=left)
                score, variance = _score(w, std, 0)
                scores.append(score)
            error = np.sqrt(variance / draws)
            assert np.mean(scores) == pytest.approx(q * size * variance, abs=6 * error)
            if not q:
                assert np.var(scores) == pytest.approx(off**4 * variance, rel=0.2)


def _physics(p: Any) -> Physics:
    return Physics(
        stiffness=p[:2], damping=p[2:4], masses=p[4:], relaxation=np.zeros(2), gains=np.ones(3), delays=np.zeros(3)
    )


def test_a_trial_is_whole_again() -> None:
    record = row(1.0).record(np.random.default_rng(1))
    (trial,) = trials_of(record, QUARTER, ["road"])
    cut: Trial = trial.within(7)
    assert cut.count == trial.count - 14
    np.testing.assert_array_equal(cut.known["road"], trial.known["road"][7:-7])
    np.testing.assert_array_equal(cut.whole.values, trial.values)
    assert cut.whole.start == pytest.approx(trial.start)
