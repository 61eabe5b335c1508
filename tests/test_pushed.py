"""Cars that are pushed and let go again and again: the simulator, by laws, and what is found in its files."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import analyse, find_decays
from suspid.decays.envelopes import finest
from suspid.decays.releases import releases
from suspid.records import as_response
from suspid.signals import as_signal
from validation import pushed


class TestSimulator:
    def test_it_moves_as_an_integrator_says(self) -> None:
        car, step = pushed.random_car(np.random.default_rng(1)), 1 / 400
        force = np.zeros(800)
        force[40:200] = -300.0
        column = np.zeros(8)
        column[4:] = np.linalg.solve(car.mass, np.array([*car.ends[1], 0, 0]))

        def slope(time: float, state: np.ndarray) -> np.ndarray:
            return np.asarray(car.state @ state + column * (-300.0 if 0.1 <= time < 0.5 else 0.0))

        exact = solve_ivp(slope, (0, 799 * step), np.zeros(8), t_eval=np.arange(800) * step, max_step=step / 2)
        moved = pushed.moved(car, force, 1, step)
        np.testing.assert_allclose(moved[:2], exact.y[:2], atol=2e-3 * np.max(np.abs(moved[:2])))

    def test_a_car_that_is_let_go_decays_with_its_poles(self) -> None:
        record = pushed.pushed(3)
        assert np.all(record.poles.real < 0)
        assert len(record.releases) == len(record.pushes)
        assert all(push < release for push, release in zip(record.pushes, record.releases, strict=True))


class TestReleases:
    @pytest.mark.slow
    @pytest.mark.parametrize("seed", [5, 9, 16])
    def test_each_is_found_where_the_hands_leave(self, seed: int) -> None:
        record = pushed.pushed(seed)
        signal = as_signal(as_response(record.time, record.values, list(record.names)))
        found, looked = releases(signal, finest(signal.values))
        starts = signal.start + signal.step * np.array([first for first, _ in found])
        # A period of the body is 0.6 to 1 s.
        late = np.min(np.abs(starts[:, None] - np.array(record.releases)), axis=1)
        assert len(found) >= 0.5 * looked
        assert np.median(late) < 0.2

    def test_a_steady_shake_has_none(self) -> None:
        time = np.arange(3000) / 100
        values = np.sin(8 * time) + 0.02 * np.random.default_rng(1).standard_normal((1, 3000))
        assert releases(as_signal(as_response(time, values, ["z"])), np.zeros(1)) == ([], 0)

    def test_what_is_pushed_down_slowly_and_held_is_released_each_time(self) -> None:
        """Four times in 28 s; what was pushed to swings back, damped, at 1.3 Hz."""
        time = np.arange(2800) / 100
        height = np.zeros(time.size)
        for first in (1.0, 8.0, 15.0, 21.5):
            down, free = np.clip((time - first) / 0.7, 0, 1), time - first - 1.2
            swing = np.exp(-1.6 * free) * (np.cos(8 * free) + 0.2 * np.sin(8 * free))
            held = -12 * np.sin(0.5 * np.pi * down) ** 2
            height += np.where(free < 0, held, np.where(free < 5, -12 * swing, 0.0))
        noise = 0.1 * np.random.default_rng(1).standard_normal((2, time.size))
        signal = as_signal(as_response(time, np.stack([height, 0.5 * height]) + noise, ["front", "rear"]))
        found, looked = releases(signal, finest(signal.values))
        starts = time[[first for first, _ in found]]
        assert looked == 4
        assert len(starts) >= 3
        assert np.all(np.min(np.abs(starts[:, None] - np.array([2.2, 9.2, 16.2, 22.7])), axis=1) < 0.3)

    def test_noise_in_bursts_has_none(self) -> None:
        time = np.arange(4000) / 100
        loud = 1 + 20 * (np.sin(0.8 * time) > 0)
        values = loud * np.random.default_rng(2).standard_normal((2, 4000))
        assert releases(as_signal(as_response(time, values, ["y", "z"])), np.zeros(2))[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 5, 9])
def test_the_first_command_finds_the_body(seed: int, tmp_path: Path) -> None:
    record = pushed.pushed(seed)
    pushed.write(record, tmp_path / "pushed.csv")
    found = pushed.judged(record, analyse(tmp_path / "pushed.csv"))
    assert found.free
    assert found.body
    assert not found.other


def test_releases_that_agree_are_several_decays() -> None:
    record = pushed.pushed(5)
    decays = find_decays(as_response(record.time, record.values, list(record.names)))
    assert sum(not decay.doubts for decay in decays) >= 2


def test_a_start_moved_behind_the_hands_stays_there() -> None:
    """Of the pitch alone the search begins .3 s before the hands leave, where two more modes stand for them."""
    record = pushed.pushed(881019)
    pitch = record.names.index("pitch [rad/s]")
    found = analyse(as_response(record.time, record.values[[pitch]], ["pitch"]))
    assert found.identification.response.time[0] >= record.releases[0]
    np.testing.assert_allclose(found.modes.wn, np.abs(record.poles[:1]), rtol=0.01)
