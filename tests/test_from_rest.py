"""Decays that begin where a rest ends: modes that die soon, forces that fall, friction that stops what was let go."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from suspid import Analysis, analyse
from suspid.decays.rests import rests_until
from suspid.words import Level, Note, RecordCheck

Real = NDArray[np.floating]

STEP, REST = 0.005, 0.6
# A seat on a body on a wheel on the ground [kg, N/m, N s/m].
MASS = np.array([60.0, 300.0, 35.0])
STIFFNESS, DAMPING = np.array([30e3, 20e3, 200e3]), np.array([1000.0, 1500.0, 60.0])


def chain(values: Real) -> Real:
    """Return the matrix of a chain of masses whose last one is tied to the ground."""
    ties = np.eye(len(values)) - np.eye(len(values), k=-1)
    return np.asarray(ties @ np.diag(values) @ ties.T)


def released(*, falls: float, seed: int = 1) -> tuple[Real, Real, np.ndarray[tuple[int], np.dtype[np.complex128]]]:
    """Return times, heights [mm] of three masses of which the body is pulled, held and let go, and the poles.

    The force falls as half a cosine over some seconds. Within a tenth of a sample it is constant; the motion is exact.
    """
    fine, masses = 10, len(MASS)
    lower = -np.linalg.solve(np.diag(MASS), np.hstack([chain(STIFFNESS), chain(DAMPING)]))
    state = np.vstack([np.hstack([np.zeros((masses, masses)), np.eye(masses)]), lower])
    entry = np.concatenate([np.zeros(masses), np.eye(masses)[1] / MASS])
    both = np.zeros((2 * masses + 1, 2 * masses + 1))
    both[:-1, :-1], both[:-1, -1] = state, entry
    one = expm(both * STEP / fine)
    x = np.append(-np.linalg.solve(state, 700.0 * entry), 0.0)
    times, heights = STEP * np.arange(1000), np.empty((masses, 1000))
    for k in range(1000 * fine):
        since = k * STEP / fine - REST
        share = np.clip(since / falls, 0.0, 1.0) if falls else float(since >= 0)
        x[-1] = 700.0 * 0.5 * (1 + np.cos(np.pi * share))
        if k % fine == 0:
            heights[:, k // fine] = 1e3 * x[:masses]
        x[:-1] = (one @ x)[:-1]
    noise = 0.003 * np.max(np.ptp(heights, axis=1)) * np.random.default_rng(seed).standard_normal(heights.shape)
    poles = np.linalg.eigvals(state)
    poles = poles[poles.imag > 0]
    return times, heights + noise, poles[np.argsort(np.abs(poles))]


def written(path: Path, time: Real, values: Real, header: str) -> Path:
    np.savetxt(path, np.column_stack([time, *values]), delimiter=",", header=header, comments="", fmt="%.6g")
    return path


def of_start(found: Analysis) -> list[Level]:
    return [check.level for check in found.verdict.checks if check.remark.code is RecordCheck.OF_START]


@pytest.mark.parametrize(
    ("seed", "falls"), [pytest.param(1, 0.0, marks=pytest.mark.slow), (2, 0.0), (3, 0.0), (1, 0.1)]
)
def test_modes_that_die_within_a_part_of_the_first_cycle_are_found(seed: int, falls: float, tmp_path: Path) -> None:
    """Of the last record, the search for decays begins one where the second mode has died."""
    time, values, poles = released(falls=falls, seed=seed)
    found = analyse(written(tmp_path / "car.csv", time, values, "time [s],seat [mm],body [mm],wheel [mm]"))
    assert len(found.modes) >= 2
    std = found.modes.wn_std
    assert std is not None
    assert np.all(np.abs(found.modes.wn - np.abs(poles[: len(std)])) < 3 * std)
    assert found.verdict.level > Level.DOUBTFUL


@pytest.mark.parametrize("falls", [0.05, pytest.param(0.15, marks=pytest.mark.slow)])
def test_a_force_that_falls_is_no_mode(falls: float, tmp_path: Path) -> None:
    time, values, poles = released(falls=falls)
    found = analyse(written(tmp_path / "car.csv", time, values, "time [s],seat [mm],body [mm],wheel [mm]"))
    std = found.modes.wn_std
    assert std is not None
    assert np.all(np.min(np.abs(found.modes.wn[:, None] - np.abs(poles)), axis=1) < 3 * std)
    assert found.modes.wn[0] == pytest.approx(abs(poles[0]), rel=0.01)


@pytest.mark.parametrize("seed", [2, 3])
def test_that_a_force_may_look_the_same_as_modes_is_said(seed: int, tmp_path: Path) -> None:
    time, values, poles = released(falls=0.2, seed=seed)
    found = analyse(written(tmp_path / "car.csv", time, values, "time [s],seat [mm],body [mm],wheel [mm]"))
    assert found.modes.wn == pytest.approx([abs(poles[0])], rel=0.01)
    assert of_start(found) == [Level.CARE]


def stopped(share: float) -> tuple[Real, Real]:
    """Return times and heights of a mass that is let go at 0.6 s, and what friction stops.

    Between two turns it swings, damped, about a level that friction moves by a share of how far it was pulled.
    """
    wn, zeta, pulled = 10.1, 0.14, -33.0
    wd, decay = wn * np.sqrt(1 - zeta**2), zeta * wn
    time = 0.002 * np.arange(3000)
    height = np.full(time.size, pulled)
    turn, at, way = REST, pulled, 1.0
    while True:
        level = -way * share * abs(pulled)
        part = (time >= turn) & (time < turn + np.pi / wd)
        since = time[part] - turn
        course = np.exp(-decay * since) * (np.cos(wd * since) + decay / wd * np.sin(wd * since))
        height[part] = level + (at - level) * course
        turn, at = turn + np.pi / wd, level - (at - level) * float(np.exp(-decay * np.pi / wd))
        height[time >= turn] = at
        if abs(at) <= share * abs(pulled):
            return time, height
        way = -way


def test_few_cycles_that_friction_stops_are_one_mode(tmp_path: Path) -> None:
    time, height = stopped(0.05)
    noise = 0.03 * np.random.default_rng(1).standard_normal(height.size)
    found = analyse(written(tmp_path / "rig.csv", time, (height + noise)[None], "time [s],body [mm]"))
    assert len(found.modes) == 1
    # Friction leaves the time between two turns as it is.
    wd = found.modes.wn * np.sqrt(1 - found.modes.zeta**2)
    assert wd == pytest.approx([10.1 * np.sqrt(1 - 0.14**2)], rel=0.01)
    # Friction adds to the damping of the dashpot.
    assert 0.14 < found.modes.zeta[0] < 0.35
    assert "friction" in str(found.identification.forces)
    assert Note.BETWEEN_RESTS in {note.code for note in found.notes}


@pytest.mark.parametrize("cycles", [pytest.param(0.5, marks=pytest.mark.slow), 1.0])
def test_a_pulse_between_two_rests_is_none(cycles: float, tmp_path: Path) -> None:
    time = 0.001 * np.arange(4000)
    pulse = np.where((time > 1) & (time < 1.5), 20 * np.sin(2 * np.pi * cycles * (time - 1) / 0.5) ** 2, 0.0)
    noise = 0.03 * np.random.default_rng(1).standard_normal(time.size)
    found = analyse(written(tmp_path / "pulse.csv", time, (pulse + noise)[None], "time [s],body [mm]"))
    assert not len(found.modes) or found.verdict.level is Level.DOUBTFUL
    assert Note.BETWEEN_RESTS not in {note.code for note in found.notes}


def test_a_rest_takes_at_most_a_share() -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(400)
    held = np.where(np.arange(400) < 300, 1.0, np.cos(0.1 * (np.arange(400) - 300)))
    assert rests_until((held + noise)[None]) == 0
    assert abs(rests_until((held + noise)[None], most=0.9) - 300) < 5
