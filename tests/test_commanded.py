"""Step responses with their command: about where it settles, a motion is free while the command holds its value."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from scipy.signal import cont2discrete

from suspid import Analysis, Identification, Level, ModalSet, Settings, analyse, identify
from suspid.analysis import commanded as module
from suspid.analysis.used import Used
from suspid.identification import Considered
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Note, Reason, RecordCheck, Remark

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


@pytest.mark.slow
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


class TestWhatIsAskedOfStretches:
    """Four of them, of which identifications are made up: one decay that is beyond doubt, and what spoils it."""

    @staticmethod
    def single(hertz: float, zeta: float = 0.2) -> Identification:
        time, wn = np.arange(120) / RATE, 2 * np.pi * hertz
        values = np.exp(-zeta * wn * time) * np.cos(wn * np.sqrt(1 - zeta**2) * time)
        noise = 0.003 * np.random.default_rng(1).standard_normal(time.size)
        return identify(as_response(time, (values + noise)[None], ["y"]))

    @staticmethod
    def used(
        monkeypatch: pytest.MonkeyPatch,
        shown: Sequence[Identification | None],
        later: Identification,
        before: Identification | None = None,
    ) -> bool:
        """Return whether stretches are used that show these, and the first of them this from later on."""
        command = commanded(0.0, 1.0, 0.3, 1.2, -0.5)
        rest = np.where(command == 0, 0.0, np.sin(3 * TIME))
        record = as_response(TIME, np.stack([rest, command]), ["y", "u"])
        made = iter([*shown, later])
        monkeypatch.setattr(module, "tried", lambda *_: next(made))
        none = identify(as_response(TIME, 0.1 * np.random.default_rng(1).standard_normal((1, TIME.size)), ["y"]))
        found = before or none
        stretch = Used(record=as_response(TIME, rest[None], ["y"]), decays=(), used=(), notes=(), identification=found)
        return module.after_commands(record, stretch, found, Settings()) is not None

    def test_half_of_them_show_the_mode_from_later_on_too(self, monkeypatch: pytest.MonkeyPatch) -> None:
        good = self.single(1.0)
        assert self.used(monkeypatch, [good, good, None, None], good)
        assert not self.used(monkeypatch, [good, None, None, None], good)
        assert not self.used(monkeypatch, [good] * 4, self.single(1.1))

    def test_it_is_the_one_that_was_doubtful_before(self, monkeypatch: pytest.MonkeyPatch) -> None:
        good, again, other = self.single(1.0), self.single(1.0, 0.55), self.single(2.0, 0.55)
        assert again.verdict.level is other.verdict.level is Level.DOUBTFUL
        assert self.used(monkeypatch, [good] * 4, good, again)
        assert not self.used(monkeypatch, [good] * 4, good, other)

    @pytest.mark.parametrize("spoilt", ["tone", "two", "no swing", "row"])
    def test_it_is_alone_and_swings_and_is_known(self, monkeypatch: pytest.MonkeyPatch, spoilt: str) -> None:
        good = self.single(1.0)
        pole = complex(good.modes.poles[0])
        tone = Considered(pole=3j * pole.imag, remark=Remark(Reason.TONE), removed=True)
        two = Considered(pole=pole, remark=Remark(Reason.UNRESOLVED, {"gain": 30.0, "needed": 40.0}), removed=False)
        row = ModalSet(
            poles=np.asarray(pole + 1j * np.arange(4), complex), shapes=np.ones((1, 4), complex), channels=("y",)
        )
        bad = {
            "tone": replace(good, considered=(tone,)),
            "two": replace(good, considered=(two,)),
            "no swing": self.single(1.0, 0.7),
            "row": replace(good, modes=row, loudness=np.ones(4), considered=()),
        }[spoilt]
        assert not self.used(monkeypatch, [bad] * 4, bad)
