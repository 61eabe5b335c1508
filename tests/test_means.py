"""Records sampled far faster than they move, of rigs that are not linear: means over several samples tell the modes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from suspid import Settings, analyse, identify
from suspid.analysis import means
from suspid.analysis.used import Used
from suspid.records import as_response
from suspid.words import Level, Note, Remark

RATE = 887.0


def dragged(path: Path, drag: tuple[float, float], *, rate: float = RATE) -> Path:
    """Write two masses under drag, let go at .3 s by a motor that holds them, for two cycles; finely integrated."""
    from scipy.integrate import solve_ivp

    mass, stiffness = np.diag([1.0, 1.2]), np.array([[520.0, -260.0], [-260.0, 260.0]])
    linear = np.array([[2.6, -0.4], [-0.4, 0.9]])

    def slope(_: float, state: np.ndarray) -> np.ndarray:
        place, speed = np.split(state, 2)
        force = -stiffness @ place - linear @ speed - np.array(drag) * speed * np.abs(speed)
        return np.concatenate([speed, np.linalg.solve(mass, force)])

    time = np.arange(int(2.1 * rate)) / rate
    free = time >= 0.3
    held = np.array([0.02, 0.045])
    moved = solve_ivp(slope, (0.0, 2.0), np.r_[held, 0, 0], t_eval=time[free] - 0.3, rtol=1e-10, atol=1e-13).y[:2]
    place = np.repeat(held[:, None], len(time), axis=1)
    place[:, free] = moved
    table = np.column_stack([time, np.round(place.T / 2e-6)])
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header="time [s],enc1,enc2", comments="")
    return path


def undragged() -> np.ndarray:
    """Return natural frequencies of the masses without damping, from their stiffness [rad/s]."""
    mass, stiffness = np.diag([1.0, 1.2]), np.array([[520.0, -260.0], [-260.0, 260.0]])
    return np.asarray(np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)))


@pytest.mark.slow
@pytest.mark.parametrize("drag", [(8.0, 4.0), (12.0, 5.0), (20.0, 20.0)])
def test_drag_after_a_release_leaves_two_modes(drag: tuple[float, float], tmp_path: Path) -> None:
    found = analyse(dragged(tmp_path / "drag.csv", drag))
    np.testing.assert_allclose(found.modes.wn, undragged(), rtol=0.005)
    assert found.verdict.level is Level.CARE


def test_means_have_their_law() -> None:
    time = np.arange(1000) / 500
    motion = np.exp((-0.4 + 9.0j) * time)
    of_seven = means.means_of(as_response(time, motion.real[None], ["seat"]), 7)
    theta = (-0.4 + 9.0j) / 500
    factor = np.mean(np.exp(theta * (np.arange(7) - 3)))
    np.testing.assert_allclose(of_seven.y[0], (factor * np.exp((-0.4 + 9.0j) * of_seven.time)).real, atol=1e-12)


@pytest.mark.parametrize(("second", "used"), [(31.0, True), (37.0, False)])
def test_means_over_two_lengths_must_agree(second: float, used: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    time, tones = np.arange(4000) / 1000, []

    def decay(wn: float, rate: float) -> object:
        rng, t = np.random.default_rng(1), np.arange(int(4 * rate)) / rate
        values = np.exp(-0.8 * t) * np.cos(wn * t) + 1e-4 * rng.standard_normal(t.size)
        return as_response(t, values[None], ["seat"])

    def doubtful_first(record: object, _: Settings) -> object:
        tones.append(record)
        return identify(decay((31.0, second, 43.0)[len(tones) - 1], 1 / (record.time[1] - record.time[0])))  # type: ignore[attr-defined]

    levels = iter([Level.DOUBTFUL, Level.CARE, Level.CARE, Level.CARE])
    monkeypatch.setattr(means, "tried", doubtful_first)
    monkeypatch.setattr(means, "level_of", lambda *_: next(levels))
    noise = as_response(time, np.random.default_rng(2).standard_normal((1, 4000)), ["seat"])
    doubted = identify(decay(31.0, 1000.0))
    best = Used(record=noise, decays=(), used=(), notes=(), identification=doubted)
    found = means.with_means(noise, best, Settings())
    assert [note.code for note in found.notes] == ([Note.MEANS] if used else [])


@pytest.mark.parametrize(("zeta", "used"), [(0.5, True), (0.93, False)])
def test_a_mode_that_never_swings_is_none_of_means(zeta: float, used: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A car that is pushed again and again left one of zeta 0.93 beside its own, in means over two lengths."""
    time = np.arange(4000) / 1000
    rng = np.random.default_rng(1)

    def two_modes(record: object, _: Settings) -> object:
        t = np.asarray(record.time)  # type: ignore[attr-defined]
        fast = np.exp(-zeta * 60 * t) * np.cos(60 * np.sqrt(1 - zeta**2) * t)
        values = np.exp(-0.8 * t) * np.cos(9 * t) + fast + 1e-4 * rng.standard_normal(t.size)
        return identify(as_response(t, values[None], ["seat"]))

    levels = iter([Level.DOUBTFUL, *[Level.CARE] * 3])
    monkeypatch.setattr(means, "tried", two_modes)
    monkeypatch.setattr(means, "level_of", lambda *_: next(levels))
    record = as_response(time, rng.standard_normal((1, 4000)), ["seat"])
    doubted = two_modes(record, Settings())
    best = Used(record=record, decays=(), used=(), notes=(), identification=doubted)  # type: ignore[arg-type]
    found = means.with_means(record, best, Settings())
    assert [note.code for note in found.notes] == ([Note.MEANS] if used else [])


def test_means_call_for_care() -> None:
    time = np.arange(800) / 200
    values = np.exp(-0.8 * time) * np.cos(31 * time) + 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = analyse(as_response(time, values[None], ["seat"]))
    assert found.verdict.level is Level.SOUND
    note = Remark(Note.MEANS, {"size": 4, "rate": 50.0})
    cautious = replace(found, notes=(*found.notes, note)).verdict
    assert cautious.level is Level.CARE
    assert "Means over 4 samples are used" in "".join(str(check.remark) for check in cautious.checks)
