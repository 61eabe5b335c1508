"""Channels that spoil a result: a sensor that hardly moves, a mark of a video; they are left out, and that is said."""

from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest

from suspid import RecordError, Settings, analyse, identify
from suspid.analysis.fewer_channels import _loses_a_close_mode, with_fewer_channels
from suspid.analysis.used import Used
from suspid.records import as_response, cut, of_channels
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Check, Level, Note, RecordCheck, Remark

RATE = 113.0
TIME = np.arange(700) / RATE


def swing() -> np.ndarray:
    """Return a mass that is released at 1 s and stopped by friction, in counts of an encoder: turn by turn, exact."""
    from validation.friction import Rig, released

    rig = Rig(mass=(1.0,), stiffness=(250.0,), damping=(1.0,), friction=(0.6,))
    motion, _ = released(rig, np.array([0.1]), TIME[TIME >= 1.0] - 1.0)
    rest = np.full(int(np.sum(TIME < 1.0)), 0.1)
    return np.asarray(np.round(np.concatenate([rest, motion[0]]) / 1e-4))


def touched(seed: int) -> np.ndarray:
    """Return a clamped encoder beside it: some counts of play that follow, and steps where somebody touches the rig."""
    rng = np.random.default_rng(seed)
    steps = np.cumsum(rng.choice([0.0, 0.0, 1.0, -1.0], TIME.size) * (rng.random(TIME.size) < 0.05))
    return np.asarray(np.round(0.02 * np.roll(swing(), 3) + steps + 6 * np.tanh(np.sin(3 * TIME) * 4)))


def written(path: Path, *channels: np.ndarray, names: tuple[str, ...] = ("Encoder 1", "Encoder 2")) -> Path:
    header = ",".join(["time [s]", *names[: len(channels)]])
    np.savetxt(path, np.column_stack([TIME, *channels]), fmt="%.9g", delimiter=",", header=header, comments="")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_a_sensor_that_hardly_moves_is_left_out(seed: int, tmp_path: Path) -> None:
    found = analyse(written(tmp_path / "two.csv", swing(), touched(seed)))
    alone = analyse(written(tmp_path / "one.csv", swing()))
    assert len(found.modes) == 1
    assert found.modes.channels == ("Encoder 1",)
    np.testing.assert_allclose(found.modes.poles, alone.modes.poles, rtol=1e-6)
    assert found.verdict.level is Level.CARE
    assert RecordCheck.FEWER_CHANNELS in {check.remark.code for check in found.verdict.checks}
    (note,) = [note for note in found.notes if note.code is Note.FEWER_CHANNELS]
    assert note.numbers["names"] == ("Encoder 2",)
    assert "channel 'Encoder 2' is left out" in str(note)


@pytest.mark.slow
def test_what_touches_leave_open_is_in_the_interval(tmp_path: Path) -> None:
    """Tones within the linewidth of the mode follow its friction and the touches: nothing says which channel errs.

    The truth of this one record lies 2.06 standard deviations off.
    """
    found = analyse(written(tmp_path / "two.csv", swing(), touched(1)))
    assert len(found.modes) == 1
    assert found.verdict.level <= Level.CARE
    assert found.modes.wn_std is not None
    # The natural frequency of the mass without friction.
    assert abs(found.modes.wn[0] - np.sqrt(250.0)) < 3 * found.modes.wn_std[0]


@pytest.mark.slow
def test_channels_that_are_named_are_all_used(tmp_path: Path) -> None:
    path = written(tmp_path / "two.csv", swing(), touched(2))
    found = analyse(path, settings=Settings(channels=("Encoder 1", "Encoder 2")))
    assert Note.FEWER_CHANNELS not in {note.code for note in found.notes}


@pytest.mark.slow
def test_good_channels_stay(tmp_path: Path) -> None:
    # A multiple is no second measurement.
    other = np.round(0.7 * swing()) + np.random.default_rng(1).integers(-1, 2, TIME.size)
    found = analyse(written(tmp_path / "good.csv", swing(), other))
    assert found.modes.channels == ("Encoder 1", "Encoder 2")


def test_a_command_that_follows_a_sensor_is_no_measurement(tmp_path: Path) -> None:
    """A controller that is switched off lets it follow, some counts beside it."""
    follows = swing() + np.random.default_rng(1).integers(-3, 4, TIME.size)
    found = analyse(written(tmp_path / "open_loop.csv", swing(), follows, names=("Encoder 1", "Commanded Pos")))
    assert found.modes.channels == ("Encoder 1",)
    assert Note.COMMAND_CHANNEL in {note.code for note in found.notes}
    alone = analyse(written(tmp_path / "alone.csv", follows, names=("Commanded Pos",)))
    assert alone.modes.channels == ("Commanded Pos",)


def test_a_clipped_channel_beside_others_is_left_out(tmp_path: Path) -> None:
    """A sensor at its limit from swing to swing cannot be used; those beside it can."""
    t = np.arange(900) / 100
    motion = np.exp(-0.15 * t) * np.cos(6 * t) + 2e-3 * np.random.default_rng(1).standard_normal(t.size)
    columns = np.column_stack([t, motion, np.clip(1.3 * motion, -0.3, 0.3)])
    path = tmp_path / "clipped.csv"
    np.savetxt(path, columns, fmt="%.6g", delimiter=",", header="t [s],seat,chassis", comments="")
    found = analyse(path)
    assert found.modes.channels == ("seat",)
    assert found.modes.wn == pytest.approx([6.0], rel=1e-3)
    (note,) = [note for note in found.notes if note.code is Note.CLIPPED_CHANNEL]
    assert note.numbers["channel"] == "chassis"
    with pytest.raises(RecordError, match="'chassis' is clipped"):
        analyse(path, settings=Settings(channels=("seat", "chassis")))


@pytest.mark.parametrize(
    ("loud", "left", "kept"), [(20.0, 3.0, ("x",)), (5.0, 3.0, ("x", "y")), (20.0, 1.5, ("x", "y"))]
)
def test_a_channel_beside_which_the_fit_to_others_is_far_closer_is_left_out(
    loud: float, left: float, kept: tuple[str, ...]
) -> None:
    """The height of a pendulum, which forces of a fit follow at the cost of its swing; noise alone is no reason."""
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, TIME.size))
    swing = np.exp(-0.3 * TIME) * np.cos(12 * TIME)
    record = as_response(TIME, np.stack([swing, 0.3 * np.exp(-TIME)]) + noise, ["x", "y"])
    both, alone = identify(record), identify(of_channels(record, ["x"]))
    both = replace(
        both,
        modes=both.modes[both.modes.wn > 5],
        loudness=np.array([loud]),
        noise_std=both.noise_std * left,
    )
    assert both.verdict.level is Level.CARE

    def of_one(part: control.TimeResponseData, _: Settings) -> Used:
        assert as_signal(part).channels == ("x",)
        return Used(record=part, decays=(), used=(), notes=(), identification=alone)

    before = Used(record=record, decays=(), used=(), notes=(), identification=both)
    after = with_fewer_channels(record, before, Settings(), of_one)
    assert as_signal(after.record).channels == kept


@pytest.mark.parametrize(
    ("loud", "of_all", "explained", "kept"),
    [
        (33.0, 3.0, 0.9995, 2),
        (3.0, 3.0, 0.9995, 1),
        (33.0, 40.0, 0.9995, 1),
        (33.0, 3.0, 0.5, 1),
    ],
)
def test_what_fewer_channels_leave_is_no_more_than_noise(
    loud: float, of_all: float, explained: float, kept: int
) -> None:
    """A mode of one channel, with 33 times the power of noise beside it, is no clearer than two that explain both."""
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, TIME.size))
    slow, fast = np.exp(-0.3 * TIME) * np.cos(12 * TIME), np.exp(-0.5 * TIME) * np.cos(31 * TIME)
    record = as_response(TIME, np.stack([slow + 0.2 * fast, slow - 0.3 * fast]) + noise, ["x", "y"])
    both, alone = identify(record), identify(of_channels(record, ["x"]), modes=1)
    alone, noisy = replace(alone, loudness=np.array([loud])), as_signal(held(both, "residual"))
    # What is left of the second channel sets the share that is explained of it.
    more = np.sqrt((1 - explained) * np.mean(noisy.values[1] ** 2 + as_signal(record).values[1] ** 2))
    left = noisy.values * np.array([[1.0], [more / np.std(noisy.values[1])]])
    both = replace(both, loudness=np.array([of_all, of_all]), residual=as_response(TIME, left, ["x", "y"]))
    assert both.explained[1] == pytest.approx(explained, abs=0.05)
    # As one of few cycles is.
    doubt = Check(Remark(RecordCheck.NEVER_SWINGS), Level.DOUBTFUL)
    vars(both)["verdict"] = replace(both.verdict, checks=(*both.verdict.checks, doubt))
    assert alone.verdict.level is Level.CARE

    def of_one(part: control.TimeResponseData, _: Settings) -> Used:
        return Used(record=part, decays=(), used=(), notes=(), identification=alone)

    before = Used(record=record, decays=(), used=(), notes=(), identification=both)
    after = with_fewer_channels(record, before, Settings(), of_one)
    assert len(as_signal(after.record).channels) == kept


@pytest.mark.parametrize(("other", "kept"), [(9.95, 2), (9.8, 1)])
def test_a_channel_that_shows_another_mode_close_by_is_not_left_out(other: float, kept: int) -> None:
    """A frame bends in two directions at nearly the same frequency: of one channel alone, one mode that bends."""
    time = np.arange(6000) / 100
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, time.size))
    one, two = np.exp(-0.011 * time) * np.cos(9.8 * time), np.exp(-0.012 * time) * np.sin(other * time)
    record = as_response(time, np.stack([one + 0.1 * two, 0.2 * one + two]) + noise, ["x", "y"])
    both = identify(record)
    doubt = Check(Remark(RecordCheck.NEVER_SWINGS), Level.DOUBTFUL)
    vars(both)["verdict"] = replace(both.verdict, checks=(*both.verdict.checks, doubt))

    def of_one(part: control.TimeResponseData, _: Settings) -> Used:
        alone = replace(identify(part, modes=1), loudness=np.array([1.0]))
        vars(alone)["verdict"] = replace(alone.verdict, checks=())
        return Used(record=part, decays=(), used=(), notes=(), identification=alone)

    before = Used(record=record, decays=(), used=(), notes=(), identification=both)
    after = with_fewer_channels(record, before, Settings(), of_one)
    assert len(as_signal(after.record).channels) == kept


class TestCloseModes:
    """Pitch and bounce of a car: one channel is fitted by a single mode between them, several tell them by shapes."""

    @staticmethod
    def record(shapes: RealArray, *, noise: float = 1e-2) -> control.TimeResponseData:
        time = np.arange(800) / 200
        poles = 2 * np.pi * np.array([[1.1345], [1.2192]]) * (-0.22 + 0.975j)
        values = shapes @ np.exp(poles * time).real
        values += noise * np.random.default_rng(1).standard_normal(values.shape)
        return as_response(time, values, ["front", "rear", "middle"][: len(values)])

    def test_are_not_given_up_for_one_channel(self) -> None:
        record = self.record(np.array([[1.0, 0.4], [0.5, -0.9], [0.8, 0.2]]))
        found, fewer = identify(record), identify(of_channels(record, ["front"]))
        assert (len(found.modes), len(fewer.modes)) == (2, 1)
        assert _loses_a_close_mode(of_channels(record, ["rear", "middle"]), fewer, found)

    def test_a_channel_without_the_other_mode_does_not_tell(self) -> None:
        record = self.record(np.array([[1.0, 0.0], [0.5, 0.0], [0.2, 0.9]]))
        found, fewer = identify(record), identify(of_channels(record, ["front"]))
        assert len(found.modes) == 2
        assert not _loses_a_close_mode(of_channels(record, ["rear"]), fewer, found)
        assert _loses_a_close_mode(of_channels(record, ["middle"]), fewer, found)

    def test_stretches_apart_are_not_compared(self) -> None:
        record = self.record(np.array([[1.0, 0.4], [0.5, -0.9], [0.8, 0.2]]))
        found, fewer = identify(cut(record, stop=1.5)), identify(of_channels(cut(record, start=1.6), ["front"]))
        assert not _loses_a_close_mode(of_channels(record, ["rear", "middle"]), fewer, found)
