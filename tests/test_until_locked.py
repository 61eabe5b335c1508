"""Masses that friction in a strut locks to each other."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import Settings, analyse, as_record, identify
from suspid.analysis import stretch
from suspid.analysis.until_locked import _goes_on, _stops, after_lock, released_and_locked, until_locked
from suspid.analysis.used import Used
from suspid.identification import identify_linear
from suspid.model import ModalSet
from suspid.records import as_response, cut, of_channels
from suspid.signals import as_signal
from suspid.words import Level, Note, Remark

Real = NDArray[np.float64]

MASS = np.array([1.2, 0.8])


def released(stiffness: Real, damping: Real, friction: float) -> tuple[Real, Real, Real]:
    """Return times, positions of two masses on each other that are held and let go at 0.5 s, and the linear poles' wn.

    Friction acts in the strut between them: in each short step it is what stops it, or as much as it can be.
    """
    step, every, held = 2e-5, 100, np.array([0.02, 0.045])
    x, v, out = held.copy(), np.zeros(2), []
    shared = MASS[0] * MASS[1] / MASS.sum()
    for k in range(int(3 / step)):
        if k % every == 0:
            out.append(x.copy())
        if k * step < 0.5:
            continue
        lower = -stiffness[0] * x[0] - damping[0] * v[0]
        upper = -stiffness[1] * (x[1] - x[0]) - damping[1] * (v[1] - v[0])
        rate = np.array([(lower - upper) / MASS[0], upper / MASS[1]])
        stop = -((v[1] - v[0]) / step + rate[1] - rate[0]) * shared
        rub = min(max(stop, -friction), friction)
        v = v + step * (rate + np.array([-rub, rub]) / MASS)
        x = x + step * v
    matrix = np.array([[stiffness.sum(), -stiffness[1]], [-stiffness[1], stiffness[1]]]) / MASS[:, None]
    times = np.asarray(every * step * np.arange(len(out)), float)
    return times, np.array(out).T, np.sqrt(np.sort(np.linalg.eigvals(matrix).real))


def written(path: Path, time: Real, values: Real, header: str) -> Path:
    np.savetxt(path, np.column_stack([time, *values]), delimiter=",", header=header, comments="", fmt="%.7g")
    return path


STIFFNESS, DAMPING = np.array([3000.0, 2000.0]), np.array([0.5, 0.5])


@pytest.fixture(scope="module")
def rig() -> tuple[Real, Real, Real]:
    """Times and positions of a rig whose strut friction locks at 1.8 s, in coarse steps, and its frequencies."""
    time, position, wn = released(STIFFNESS, DAMPING, 4.0)
    return time, 2e-4 * np.round(position / 2e-4), wn


def test_of_what_goes_on_behind_it_the_motion_before_is_used(rig: tuple[Real, Real, Real]) -> None:
    time, position, wn = rig
    record = as_response(time, position, ["x1 [m]", "x2 [m]"])
    late = cut(record, start=1.9)
    found = identify(late)
    used = until_locked(record, Used(record=late, decays=(), used=(), notes=()), found, Settings())
    assert used is not None
    assert used.identification is not None
    assert used.identification.modes.wn == pytest.approx(wn, rel=0.01)
    assert "friction" in str(used.identification.forces)
    assert used.record.time[0] == pytest.approx(0.5, abs=0.02)
    assert used.record.time[-1] == pytest.approx(1.8, abs=0.05)


class TestAfterLock:
    """What is found behind a lock holds for what is locked."""

    def note(self, rig: tuple[Real, Real, Real], start: float) -> tuple[Remark, ...]:
        time, position, _ = rig
        record = as_response(time, position, ["x1 [m]", "x2 [m]"])
        modes = ModalSet(
            poles=np.array([-1 + 30j]), shapes=np.array([[1.0 + 0j], [1.0]]), channels=("x1 [m]", "x2 [m]")
        )
        return after_lock(record, Used(record=cut(record, start=start), decays=(), used=(), notes=()), modes)

    def test_a_stretch_behind_it_is_said_to_be_of_both_as_one(self, rig: tuple[Real, Real, Real]) -> None:
        (note,) = self.note(rig, 1.81)
        assert note.code is Note.AFTER_LOCK
        assert float(str(note.numbers["time"])) == pytest.approx(1.8, abs=0.05)

    def test_one_that_begins_before_it_is_not(self, rig: tuple[Real, Real, Real]) -> None:
        assert self.note(rig, 0.5) == ()
        assert self.note(rig, 1.6) == ()

    def test_a_linear_decay_whose_fast_mode_died_early_is_not(self, tmp_path: Path) -> None:
        time = np.arange(4000) / 200
        low = np.exp(-0.08 * time) * np.cos(8 * time)
        apart = 0.5 * np.exp(-5.4 * time) * np.cos(44.7 * time)
        values = np.stack([low + apart, low - apart]) + 1e-3 * np.random.default_rng(5).standard_normal((2, time.size))
        found = analyse(written(tmp_path / "l.csv", time, values, "time [s],hub,frame"))
        assert len(found.modes) == 2
        assert found.verdict.level is Level.SOUND

    def test_without_modes_nothing_is_said(self, rig: tuple[Real, Real, Real]) -> None:
        time, position, _ = rig
        record = as_response(time, position, ["x1 [m]", "x2 [m]"])
        none = ModalSet(poles=np.empty(0, complex), shapes=np.zeros((2, 0), complex), channels=("x1 [m]", "x2 [m]"))
        late = Used(record=cut(record, start=1.9), decays=(), used=(), notes=())
        assert after_lock(record, late, none) == ()

    def test_a_channel_that_rests_alone_is_not(self) -> None:
        time = np.arange(2000) / 500
        swing, other = np.sin(20 * time), np.where(time < 1.5, np.sin(33 * time), np.sin(33 * 1.5))
        values = np.stack([swing, other]) + 1e-3 * np.random.default_rng(2).standard_normal((2, time.size))
        record = as_response(time, values, ["a", "b"])
        modes = ModalSet(poles=np.array([-0.1 + 20j]), shapes=np.array([[1.0 + 0j], [0.1]]), channels=("a", "b"))
        assert after_lock(record, Used(record=cut(record, start=2.0), decays=(), used=(), notes=()), modes) == ()

    def test_two_that_never_move_against_each_other_are_not(self) -> None:
        time = np.arange(2000) / 500
        low = np.exp(-0.4 * time) * np.cos(9 * time)
        values = np.stack([low, 1.2 * low]) + 1e-3 * np.random.default_rng(2).standard_normal((2, time.size))
        record = as_response(time, values, ["a", "b"])
        modes = ModalSet(poles=np.array([-0.4 + 9j]), shapes=np.array([[1.0 + 0j], [1.0]]), channels=("a", "b"))
        assert after_lock(record, Used(record=cut(record, start=0.4), decays=(), used=(), notes=()), modes) == ()

    def test_it_calls_for_care(self) -> None:
        time = np.arange(400) / 100
        noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
        found = analyse(as_record(np.exp(-time) * np.cos(20 * time) + noise, timepts=time, channels=["seat"]))
        assert found.verdict.level is Level.SOUND
        note = Remark(Note.AFTER_LOCK, {"first": "hub", "second": "frame", "time": 0.2})
        late = replace(found, notes=(*found.notes, note))
        assert late.verdict.level is Level.CARE
        assert "'hub' and 'frame' move as one from 0.2 s on" in str(late.verdict)


def test_both_modes_are_found_by_the_first_command(
    rig: tuple[Real, Real, Real], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the release to the lock, before any search for decays."""

    def never(*_: object) -> None:
        raise AssertionError("decays were sought")

    monkeypatch.setattr(stretch, "find_decays", never)
    time, position, wn = rig
    found = analyse(written(tmp_path / "rig.csv", time, position, "time [s],x1 [m],x2 [m]"))
    assert found.modes.wn == pytest.approx(wn, rel=0.01)
    assert Note.UNTIL_LOCKED in {note.code for note in found.notes}
    assert found.verdict.level is Level.CARE


class TestReleasedAndLocked:
    def record(self, rig: tuple[Real, Real, Real]) -> control.TimeResponseData:
        time, position, _ = rig
        return as_response(time, position, ["x1 [m]", "x2 [m]"])

    def test_nothing_else_is_used_where_more_is_asked_for(self, rig: tuple[Real, Real, Real]) -> None:
        assert released_and_locked(self.record(rig), Settings()) is not None
        for settings in (Settings(modes=2), Settings(band_hz=(1, 20)), Settings(method="ridge")):
            assert released_and_locked(self.record(rig), settings) is None

    def test_a_linear_decay_is_left_to_the_search(self) -> None:
        """Held, let go, its fast mode dies early: two channels move as one, and no friction is needed for that."""
        time = np.arange(2000) / 500
        after = np.maximum(time - 0.3, 0.0)
        slow, fast = np.exp(-0.4 * after) * np.cos(9 * after), np.exp(-4 * after) * np.cos(60 * after)
        values = 1e-3 * np.round(1e3 * np.stack([slow + fast, slow - fast]))
        record = as_response(time, values, ["a", "b"])
        assert min(_stops(as_signal(record)))[0] < 1500
        assert released_and_locked(record, Settings()) is None

    def test_a_linear_motion_until_a_lock_is_tried_once(
        self, rig: tuple[Real, Real, Real], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Where modes explain it without friction, fewer samples of it need none either."""
        record = self.record(rig)
        time = np.arange(1000) / 500
        noise = 1e-3 * np.random.default_rng(1).standard_normal((2, time.size))
        swings = np.exp(-time) * (np.cos(19 * time) + np.outer([1, -1], np.cos(43 * time)))
        part = as_response(time, swings + noise, ["a", "b"])
        linear, tries = identify(part), list[None]()

        def shortened(*_: object) -> Iterator[tuple[object, object]]:
            for _k in range(3):
                tries.append(None)
                yield part, linear

        monkeypatch.setattr("suspid.analysis.until_locked.shortened", shortened)
        assert released_and_locked(record, Settings()) is None
        assert len(tries) == 1

    def test_one_channel_tells_nothing(self, rig: tuple[Real, Real, Real]) -> None:
        assert released_and_locked(of_channels(self.record(rig), ["x2 [m]"]), Settings()) is None

    def test_linear_modes_that_go_on_beyond_the_lock_make_way(self, rig: tuple[Real, Real, Real]) -> None:
        record = self.record(rig)
        late = cut(record, start=0.51)
        beyond = replace(identify_linear(late), forces=())
        used = until_locked(record, Used(record=late, decays=(), used=(), notes=()), beyond, Settings())
        assert used is not None
        assert used.identification is not None
        assert used.identification.modes.wn == pytest.approx(rig[2], rel=0.01)
        # Friction explains what is locked, too.
        rubs = replace(beyond, forces=used.identification.forces)
        assert not _goes_on(rubs, Used(record=late, decays=(), used=(), notes=()), 1.8)
        assert _goes_on(beyond, Used(record=late, decays=(), used=(), notes=()), 1.8)


class TestStops:
    TIME = np.arange(3000) / 1000

    def stop(self, *channels: Real) -> float:
        noise = 1e-3 * np.random.default_rng(1).standard_normal((len(channels), self.TIME.size))
        response = as_response(self.TIME, np.stack(channels) + noise, [f"y{k}" for k in range(len(channels))])
        return min(_stops(as_signal(response)))[0] / 1000

    def test_one_that_rests_while_another_moves(self) -> None:
        swings = np.sin(20 * self.TIME)
        assert self.stop(swings, np.where(self.TIME < 1.5, swings, np.sin(30.0))) == pytest.approx(1.5, abs=0.05)

    def test_two_that_move_as_one(self) -> None:
        low, apart = np.sin(20 * self.TIME), np.cos(0.5 * np.pi * np.minimum(self.TIME / 0.1, 17))
        assert self.stop(low, low + apart) == pytest.approx(1.7, abs=0.05)

    def test_none_where_all_move_to_the_end(self) -> None:
        assert self.stop(np.sin(20 * self.TIME), np.sin(31 * self.TIME)) == 3.0


def test_a_linear_decay_whose_fast_mode_has_died_is_left_alone() -> None:
    """Then two channels move as one, too; nothing is tried beside what leaves only noise."""
    time = np.arange(2000) / 500
    slow, fast = np.exp(-0.4 * time) * np.cos(9 * time), np.exp(-4 * time) * np.cos(60 * time)
    values = np.stack([slow + fast, slow - fast]) + 1e-3 * np.random.default_rng(2).standard_normal((2, time.size))
    record = as_response(time, values, ["a", "b"])
    assert min(_stops(as_signal(record)))[0] < 1500
    found = identify(record)
    assert len(found.modes) == 2
    used = Used(record=record, decays=(), used=(), notes=(), identification=found)
    assert until_locked(record, used, found, Settings()) is None


@pytest.mark.parametrize("held", [0.0, 0.4])
def test_of_a_linear_decay_beyond_doubt_no_part_is_tried(held: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """All channels rest within their noise in the end: what they do before is not tried again."""

    def never(*_: object) -> None:
        raise AssertionError("a part was tried")

    monkeypatch.setattr("suspid.analysis.until_locked.shortened", never)
    time = np.arange(2500) / 500
    after = np.maximum(time - held, 0.0)
    slow, fast = np.exp(-3 * after) * np.cos(9 * after), np.exp(-8 * after) * np.cos(60 * after)
    values = np.stack([slow + fast, slow - fast]) + 1e-2 * np.random.default_rng(3).standard_normal((2, time.size))
    record = as_response(time, values, ["a", "b"])
    assert min(_stops(as_signal(record)))[0] < 2000
    found = analyse(record)
    assert found.verdict.level is Level.SOUND
    assert found.modes.wn == pytest.approx([np.hypot(9, 3), np.hypot(60, 8)], rel=0.05)
