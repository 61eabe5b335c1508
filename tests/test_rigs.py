"""The simulator of rigs that are not quite linear, by laws and by a second one, and what is found in its files."""

from __future__ import annotations

import numpy as np
import pytest

from validation import friction, rigs


def rig(**changed: object) -> rigs.Rig:
    none = np.zeros(1)
    values = {"mass": np.ones(1), "stiffness": np.array([400.0]), "damping": none, "friction": none, "cubic": none}
    return rigs.Rig(**{**values, **changed})  # type: ignore[arg-type]  # whatever the test gives


@pytest.mark.parametrize("masses", [1, 2])
def test_friction_moves_as_the_event_exact_simulator_says(masses: int) -> None:
    one, held = rigs.random_rig("friction", masses, np.random.default_rng(masses))
    other = friction.Rig(
        mass=tuple(one.mass),
        stiffness=tuple(one.stiffness),
        damping=tuple(one.damping),
        friction=tuple(one.friction),
    )
    time = np.arange(0, 2, 0.002)
    exact, stop = friction.released(other, held, time)
    moved = rigs.released(one, held, time)
    np.testing.assert_allclose(moved.position, exact, atol=1e-7 * np.max(np.abs(held)))
    assert moved.stop == pytest.approx(stop, abs=1e-5)


def test_friction_in_struts_moves_as_small_steps_with_impulses_say() -> None:
    """A time-stepping scheme: in each step the impulses of friction stop the contacts, or are at their limits."""
    one, held = rigs.random_rig(rigs.IN_STRUTS, 2, np.random.default_rng(1))
    assert np.all(one.friction > 0)
    time, step, per = np.arange(0, 1.3, 0.002), 2e-4, 10
    inverse, contacts = 1 / one.mass, one.contacts
    moves = contacts * inverse @ contacts.T
    x, v, seen = held.copy(), np.zeros(2), [held.copy()]
    for _ in range((len(time) - 1) * per):
        free, impulse = v + step * one.force(x, v) * inverse, np.zeros(2)
        for k in [0, 1] * 15:
            slides = contacts[k] @ (free - inverse * (contacts.T @ impulse))
            impulse[k] = np.clip(impulse[k] + slides / moves[k, k], -one.friction[k] * step, one.friction[k] * step)
        v = free - inverse * (contacts.T @ impulse)
        x = x + step * v
        seen.append(x)
    moved = rigs.released(one, held, time)
    np.testing.assert_allclose(moved.position.T, seen[::per], atol=5e-3 * np.max(np.abs(held)))
    assert 1.2 < moved.stop < 1.3
    assert moved.stuck < moved.stop


def test_a_strut_that_is_locked_at_once_leaves_the_motion_of_one_mass() -> None:
    none, time = np.zeros(2), np.arange(0, 3, 0.01)
    two = rigs.Rig(
        mass=np.array([1.0, 3.0]), stiffness=np.array([400.0, 100.0]), damping=np.array([0.4, 0.1]),
        friction=np.array([0.0, 1e3]), cubic=none, struts=True,
    )  # fmt: skip
    one = rig(mass=np.array([4.0]), damping=np.array([0.4]))
    moved = rigs.released(two, np.array([1.0, 1.5]), time)
    np.testing.assert_allclose(
        moved.position - [[0], [0.5]], rigs.released(one, np.ones(1), time).position[[0, 0]], atol=1e-6
    )
    assert moved.stuck == 0.0


def test_a_linear_rig_decays_as_its_pole_says() -> None:
    one, time = rig(damping=np.array([0.8])), np.arange(0, 3, 0.01)
    pole = -0.4 + 1j * np.sqrt(400 - 0.4**2)
    other = np.conj(pole)
    exact = ((other * np.exp(pole * time) - pole * np.exp(other * time)) / (other - pole)).real
    np.testing.assert_allclose(rigs.released(one, np.ones(1), time).position[0], exact, atol=1e-7)


def test_a_cubic_spring_turns_faster_by_the_first_term_of_its_series() -> None:
    """Lindstedt and Poincare: ``wn (1 + 3/8 cubic A^2)`` at small amplitudes."""
    moved = rigs.released(rig(cubic=np.array([0.01])), np.ones(1), np.arange(0, 3, 0.01))
    period = 2 * np.mean(np.diff(moved.turns[0][:, 0]))
    assert 2 * np.pi / period / 20 - 1 == pytest.approx(3 / 8 * 0.01, rel=0.01)


def test_a_bilinear_damper_loses_what_the_mean_of_both_ways_does() -> None:
    """At light damping a cycle loses the mean of compression and rebound, whatever their ratio."""
    one = rig(damping=np.array([0.4]), rebound=3.0)
    turns = rigs.released(one, np.ones(1), np.arange(0, 3, 0.01)).turns[0]
    swing = np.abs(np.diff(turns[:, 1]))
    assert np.log(swing[0] / swing[-1]) / (turns[-2, 0] - turns[0, 0]) == pytest.approx(0.2, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("kind", rigs.KINDS)
def test_the_first_command_finds_the_mode_of_one_mass(kind: str) -> None:
    """At least four files of five: the number of modes, wn within 1 % and zeta within 15 % of the mean over cycles."""
    found = [rigs.outcome(kind, 1, seed) for seed in range(700, 705)]
    good = [one.right and abs(one.wn) < 0.01 and abs(one.zeta) < 0.15 for one in found]
    assert sum(good) >= 4, found


@pytest.mark.slow
def test_the_first_command_finds_the_second_mode_beside_parts_of_one_that_friction_bends() -> None:
    """Parts of the first mode, whose damping friction changes, are stronger in the linear fit than the second mode."""
    one = rigs.outcome("friction", 2, 975_010)
    assert one.right
    assert abs(one.wn) < 0.01
