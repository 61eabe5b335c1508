"""The simulator of rigs with friction, by the laws of one mass on a spring with Coulomb friction, and by energy."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from suspid import InputError, find_decays, free_decay, identify, quarter_car, read_record
from suspid.records import as_response, cut
from suspid.signals import as_signal
from validation.friction import Rig, release, released, write


class TestOneMass:
    RIG = Rig(mass=(1.0,), stiffness=(100.0,), damping=(0.0,), friction=(1.0,))

    def test_turns_every_half_period_closer_by_twice_friction_over_stiffness(self) -> None:
        time = np.asarray(np.arange(6) * np.pi / 10, float)
        motion, stop = released(self.RIG, np.array([0.105]), time)
        np.testing.assert_allclose(motion[0], [0.105, -0.085, 0.065, -0.045, 0.025, -0.005], atol=1e-12)
        # At 0.005 m the spring pulls with 0.5 N against a friction of 1 N.
        assert stop == pytest.approx(5 * np.pi / 10, abs=1e-12)

    def test_stays_where_friction_holds_it(self) -> None:
        motion, stop = released(self.RIG, np.array([0.0099]), np.linspace(0, 1, 11))
        np.testing.assert_array_equal(motion, 0.0099)
        assert stop == 0.0

    def test_without_friction_it_decays_as_damped_oscillators_do(self) -> None:
        rig = Rig(mass=(2.0,), stiffness=(200.0,), damping=(4.0,), friction=(0.0,))
        time = np.linspace(0, 3, 301)
        motion, stop = released(rig, np.array([0.1]), time)
        turn = np.sqrt(99.0)
        exact = 0.1 * np.exp(-time) * (np.cos(turn * time) + np.sin(turn * time) / turn)
        np.testing.assert_allclose(motion[0], exact, atol=1e-12)
        assert stop == np.inf


class TestTwoMasses:
    @pytest.mark.slow
    @pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
    def test_the_energy_lost_is_the_work_of_friction_and_dampers(self, seed: int) -> None:
        rig = release(2, 12, seed=seed).rig
        bare = Rig(mass=rig.mass, stiffness=rig.stiffness, damping=(0.0, 0.0), friction=rig.friction)
        start, time = np.array([0.02, 0.03]), np.linspace(0, 0.4, 20001)
        motion, _ = released(bare, start, time)
        speed = np.gradient(motion, time, axis=1)
        stretch = np.diff(motion, axis=0, prepend=0.0)
        energy = 0.5 * (np.array(rig.mass) @ speed**2 + np.array(rig.stiffness) @ stretch**2)
        path = np.cumsum(np.abs(np.diff(motion, axis=1)), axis=1)
        lost = np.array(rig.friction) @ path
        # Differences over 20 us leave the speed off by (wn h)^2, and by half a step of friction at each turn.
        np.testing.assert_allclose(energy[1:-1], energy[1] - (lost[:-1] - lost[0]), atol=2e-3 * energy[1])


def test_files_hold_the_record(tmp_path: Path) -> None:
    record = release(2, 10, seed=1)
    write(record, tmp_path / "release.csv")
    signal = as_signal(read_record(tmp_path / "release.csv"))
    np.testing.assert_allclose(signal.values, record.position, atol=1e-9)
    assert len(np.unique(record.position[0])) <= 2**10


class TestStartsAndEnds:
    """The decay is found between the release and the dead stop, although no damped exponentials fit friction."""

    @pytest.mark.parametrize(
        ("masses", "bits", "seed"),
        [
            (1, 8, 1),
            (1, 12, 3),
            *(pytest.param(2, bits, seed, marks=pytest.mark.slow) for bits, seed in ((8, 3), (12, 0))),
        ],
    )
    def test_of_the_best_decay_are_those_of_the_rig(self, masses: int, bits: int, seed: int) -> None:
        record = release(masses, bits, seed=seed)
        names = [f"x{k}" for k in range(masses)]
        step = float(record.timepts[-1] / (len(record.timepts) - 1))
        time = np.asarray(step * np.arange(len(record.timepts)), float)
        best = find_decays(as_response(time, record.position, names))[0]
        # A quarter of a period of the first mode: two blocks.
        assert abs(best.start - record.start) < 0.5 * np.pi / record.rig.wn[0]
        assert best.stop < record.stop + 2 * step


class TestHeldAndStopped:
    """Few cycles between a hold and a dead stop: no sum of damped exponentials follows them."""

    @pytest.mark.parametrize("swings", [5, pytest.param(7, marks=pytest.mark.slow)])
    def test_a_decay_begins_where_a_mass_is_let_go_and_has_one_mode(self, swings: int) -> None:
        held, wn, step = 0.02, 40.0, 0.01
        # Each swing of pi / wn ends 2 F / k nearer to rest.
        rig = Rig(mass=(1.0,), stiffness=(wn**2,), damping=(0.0,), friction=(held * wn**2 / (2 * swings + 1),))
        time = np.asarray(step * np.arange(200), float)
        free, stop = released(rig, np.array([held]), np.maximum(time - 0.5, 0.0))
        values = np.where(time < 0.5, held * np.clip((time - 0.1) / 0.1, 0.0, 1.0), free[0])
        values = np.asarray(1e-5 * np.round(values / 1e-5), float)
        found = find_decays(as_response(time, values, ["x"]))
        assert found[0].start == pytest.approx(0.5, abs=2 * step)
        assert found[0].stop == pytest.approx(0.5 + stop, abs=2 * step)
        modes = identify(cut(as_response(time, values, ["x"]), start=found[0].start, stop=found[0].stop)).modes
        np.testing.assert_allclose(modes.wn, [wn], rtol=0.02)


@pytest.mark.parametrize(
    "more",
    [
        {"friction": {"chassis": 1e12}},
        {"curve": {"chassis": [(-1.0, -1e300), (0.0, 0.0), (1.0, 1e300)]}},
        {"curve": {"chassis": [(-1e-300, -1.0), (0.0, 0.0), (1e-300, 1.0)]}},
    ],
)
def test_what_cannot_be_computed_is_refused(more: dict[str, Any]) -> None:
    """In place of a run without an end, and of numbers that are none."""
    car = quarter_car(
        chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
    )
    with pytest.raises(InputError, match="far too stiff for the masses|beyond 1e"):
        free_decay(car.with_parameters(**more), np.arange(0, 1, 0.005), initial_state={"v_tire": 1.0})
