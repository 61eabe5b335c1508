"""Step responses with their command: about where it settles, a motion is free while the command holds its value."""

from typing import Literal

import numpy as np
import pytest
from scipy.signal import cont2discrete

from suspid import Analysis, Level, Settings, analyse
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Note, RecordCheck

RATE, WN = 20.0, 4.0
TIME = np.arange(500) / RATE


def commanded(*levels: float) -> RealArray:
    """Return a command that takes these values, each for the same time."""
    return np.repeat(np.asarray(levels, float), -(-TIME.size // len(levels)))[: TIME.size]


def response(zeta: float, command: RealArray, *, noise: float = 0.01) -> RealArray:
    """Return the exact response of a mass on a spring to a command that is held from sample to sample."""
    A = np.array([[0.0, 1.0], [-(WN**2), -2 * zeta * WN]])
    step, push, *_ = cont2discrete((A, np.array([[0.0], [WN**2]]), np.eye(2), np.zeros((2, 1))), 1 / RATE)
    state, out = np.zeros(2), []
    for value in command.tolist():
        out.append(float(state[0]))
        state = step @ state + push[:, 0] * value
    return np.asarray(out) + noise * np.random.default_rng(1).standard_normal(TIME.size)


def found(motion: RealArray, command: RealArray, *, decay: Literal["auto", "all"] = "auto") -> Analysis:
    record = as_response(TIME, np.stack([motion, command]), ["y", "u"])
    return analyse(record, settings=Settings(decay=decay))


@pytest.mark.parametrize("zeta", [0.3, 0.5])
def test_steps_of_a_heavily_damped_mass_show_its_mode_jointly(zeta: float) -> None:
    command = commanded(0.0, 1.0, 0.3, 1.2, -0.5)
    one = found(response(zeta, command), command)
    assert (len(one.modes), one.verdict.level, one.modes.channels) == (1, Level.CARE, ("y",))
    wn_std, zeta_std = one.modes.wn_std, one.modes.zeta_std
    assert wn_std is not None
    assert zeta_std is not None
    assert abs(one.modes.wn[0] - WN) < 3 * wn_std[0]
    assert abs(one.modes.zeta[0] - zeta) < 3 * zeta_std[0] < 0.1 * zeta
    if zeta > 0.4:
        assert one.repeats is not None
        assert len(one.repeats.spans) == 4
        assert "what follows 4 changes of channel 'u' is used" in [str(note) for note in one.notes]
        assert RecordCheck.COMMANDED in {check.remark.code for check in one.verdict.checks}


@pytest.mark.parametrize(("moves", "used"), [(0.0, True), (0.3, False)])
def test_one_step_must_begin_from_rest(moves: float, *, used: bool) -> None:
    """What moves before it is driven by something else."""
    command = commanded(0.0, 1.0)
    motion = response(0.55, command) + np.where(TIME < 12.5, moves * np.sin(1.7 * TIME), 0.0)
    one = found(motion, command)
    assert (Note.COMMANDED in {note.code for note in one.notes}) is used
    assert (one.verdict.level is Level.CARE) is used


def test_moves_that_a_drive_leads_are_no_modes() -> None:
    """From one place to the next without a jerk, in a second, as robots go."""
    command, motion = commanded(0.0, 1.0, 0.3, 1.2, -0.5), np.zeros(TIME.size)
    for k in np.flatnonzero(np.diff(command)):
        share = np.clip((TIME - TIME[k + 1]) / 2.0, 0.0, 1.0)
        motion += (command[k + 1] - command[k]) * share**3 * (10 - 15 * share + 6 * share**2)
    one = found(motion + 0.003 * np.random.default_rng(2).standard_normal(TIME.size), command)
    assert not len(one.modes)


@pytest.mark.parametrize("seed", [pytest.param(7015, marks=pytest.mark.slow), 7019])
def test_a_flag_beside_driven_motion_is_no_command(seed: int) -> None:
    """Noise, and a channel that jumps at a time of its own."""
    from validation import no_decay

    rng = np.random.default_rng(seed)
    time, values = no_decay.KINDS["autoregression, 0.9"](rng)
    changes = np.sort(rng.choice(time.size, int(rng.integers(1, 7)), replace=False))
    flag = np.searchsorted(changes, np.arange(time.size), side="right") % 2
    names = [*(f"y{k}" for k in range(len(values))), "flag"]
    one = analyse(as_response(time, np.stack([*values, flag]), names))
    assert not len(one.modes)
    assert Note.COMMANDED not in {note.code for note in one.notes}


def test_decays_that_are_joined_leave_the_command_out() -> None:
    command = commanded(0.0, 1.0, 0.0, 1.0)
    one = found(response(0.1, command), command, decay="all")
    assert as_signal(one.identification.response).channels == ("y",)
    assert one.modes.channels == ("y",)
