"""Swings that fall late, grow again or take longer and longer are not those of free motion."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import analyse, identify
from suspid.analysis.free_swings import _falls_late, _is_stopped, _runs_down, _swings, doubts_of_swings
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import Level, RecordCheck

T = np.arange(3000) / 100
SWINGS = np.sin(2 * np.pi * 1.3 * T)


@pytest.mark.parametrize(
    "envelope",
    [
        np.exp(-0.1 * T),
        1 - 0.9 * T / 30,
        # Friction that doubles as the speed falls to zero.
        np.interp(T, [0, 10, 20, 30], [1.0, 0.75, 0.46, 0.12]),
        1 / (1 + T / 3),
        # Hardly anything falls: drifts decide.
        1 - 0.3 * (T / 30) ** 3,
    ],
)
def test_of_free_motion_they_fall_most_at_first(envelope: RealArray) -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    assert not _falls_late(_swings(envelope * SWINGS + noise)[0])


@pytest.mark.parametrize("envelope", [np.cos(np.pi / 2 * 0.98 * T / 30), 1 + 0.9 * np.cos(2 * np.pi * T / 60)])
def test_of_a_beat_and_of_what_is_driven_by_less_and_less_they_do_not(envelope: RealArray) -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    assert _falls_late(_swings(envelope * SWINGS + noise)[0])


@pytest.mark.parametrize(
    ("envelope", "stopped"),
    [
        (np.where(T < 20, 1.0, np.exp(-3 * np.maximum(T - 20, 0))), True),  # a motor that is switched off
        (np.where(T < 20, np.exp(-0.02 * T), 0.0), True),  # a hand
        (np.ones(T.size), False),  # a tone
        (np.where(T < 29, 1.0, 0.0), False),  # hardly anything is seen after it
        (np.exp(-0.3 * T), False),
        (np.maximum(1 - T / 20, 0.0), False),  # friction
        (np.where(T < 3, 1.0, 0.0), False),  # few swings
    ],
)
def test_many_that_hardly_fall_and_then_are_gone_are_stopped(envelope: RealArray, *, stopped: bool) -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    samples = envelope * SWINGS + noise
    assert _is_stopped(samples, *_swings(samples)) is stopped


def test_a_motor_that_is_switched_off_is_doubted_though_forces_follow_it() -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    runs = np.where(T < 20, 1.0, np.exp(-3 * np.maximum(T - 20, 0))) * SWINGS + noise
    found = identify(as_response(T[1500:], runs[None, 1500:], ["a"]))
    assert len(found.modes) == 1
    assert not _falls_late(_swings(runs[1500:])[0])
    assert [check.level for check in doubts_of_swings(found)] == [Level.DOUBTFUL]


def test_what_falls_into_loud_noise_is_not_stopped() -> None:
    """Swings down to half of the largest are seen above eight standard deviations of the noise."""
    noise = np.random.default_rng(1).standard_normal(T.size) / 7
    samples = np.exp(-0.1 * T) * SWINGS + noise
    assert not _is_stopped(samples, *_swings(samples))


def test_those_that_grow_again_are_not_free() -> None:
    assert _falls_late(_swings((1.2 + np.cos(2 * np.pi * T / 40)) * SWINGS)[0])


def test_few_swings_do_not_tell() -> None:
    assert not _falls_late(_swings(np.cos(np.pi / 2 * T / 30) * np.sin(2 * np.pi * 0.12 * T))[0])


def test_a_modulated_tone_is_doubted(tmp_path: Path) -> None:
    """A fan of 2 Hz whose speed stays, and whose push wanes and comes back."""
    t = np.arange(5000) / 100
    pushed = (1 + 0.9 * np.cos(2 * np.pi * t / 60)) * np.sin(2 * np.pi * 2 * t)
    noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    path = tmp_path / "fan.csv"
    np.savetxt(
        path, np.column_stack([t, pushed + noise]), fmt="%.5f", delimiter=",", header="t [s],a [m/s2]", comments=""
    )
    verdict = analyse(path).verdict
    assert verdict.level <= Level.DOUBTFUL
    assert not len(verdict.checks) or RecordCheck.FALLS_LATE in {check.remark.code for check in verdict.checks}


def stiff(cubic: float) -> RealArray:
    """Return the motion on a spring whose force is ``x + cubic x^3``, 1.3 Hz at small amplitudes, zeta .02."""

    def slope(_: float, s: RealArray) -> list[float]:
        wn = 2 * np.pi * 1.3
        return [s[1], -(wn**2) * s[0] * (1 + cubic * s[0] ** 2) - 2 * 0.02 * wn * s[1]]

    return np.asarray(solve_ivp(slope, (0, 30), [1.0, 0.0], t_eval=T, rtol=1e-8, atol=1e-10).y[0])


@pytest.mark.parametrize("cubic", [0.2, 1.0, 4.0])
def test_a_spring_that_stiffens_slows_down_most_at_first(cubic: float) -> None:
    """From 7 % to twice the frequency."""
    assert not _runs_down(*_swings(stiff(cubic)))


@pytest.mark.parametrize(("end", "down"), [(0.95, False), (0.8, True), (0.5, True), (1.5, False)])
def test_a_machine_that_runs_down(end: float, down: bool) -> None:
    """Its speed falls along a line, or rises."""
    phase = 2 * np.pi * 2.6 * (T + (end - 1) * T**2 / 60)
    assert _runs_down(*_swings(np.exp(-0.08 * T) * np.sin(phase))) is down


@pytest.mark.slow
def test_a_rotor_that_coasts_is_doubted(tmp_path: Path) -> None:
    t = np.arange(5000) / 100
    coasts = np.exp(-3 * t / 50) * np.sin(2 * np.pi * 8 * (t - 0.25 * t**2 / 50))
    path = tmp_path / "rotor.csv"
    values = coasts + 0.003 * np.random.default_rng(1).standard_normal(t.size)
    np.savetxt(path, np.column_stack([t, values]), fmt="%.5f", delimiter=",", header="t [s],a [m/s2]", comments="")
    assert analyse(path).verdict.level <= Level.DOUBTFUL


def test_one_that_is_caught_at_last_is_free() -> None:
    """A hand stops the last of fifteen swings halfway, and brings it back a little."""
    motion = np.exp(-0.11 * T) * np.cos(2 * np.pi * 1.3 * T)
    turn = round(14 / 2.6 * 100)
    caught = motion[turn] * (1 - np.interp(np.arange(60), [0, 25, 40, 60], [0.0, 0.6, 0.4, 0.4]))
    swings = np.concatenate([motion[:turn], caught])
    sizes, _ = _swings(swings)
    assert len(sizes) > 9
    assert not _falls_late(sizes)
