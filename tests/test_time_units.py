"""Columns of time in other units than seconds: by their name, by their step, as a clock, or asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from suspid import RecordError, Settings, analyse, as_record, clean, read_record, read_recording
from suspid.io.epochs import counted_from_first
from suspid.recordings import RawChannel, Recording
from suspid.signals import as_signal
from suspid.words import LeftOut, Level, RecordCheck

# 200 Hz for two seconds; where the unit is not right, the step is not this.
STEP = 0.005
TIMES = STEP * np.arange(400)
SEAT = np.exp(-2 * TIMES) * np.cos(20 * TIMES)


def write(path: Path, name: str, stamps: list[str]) -> Path:
    path.write_text(f'"{name}",seat\n' + "".join(f"{t},{y:.6g}\n" for t, y in zip(stamps, SEAT, strict=True)))
    return path


def clock(seconds: float) -> str:
    return f"{int(seconds // 3600) % 24:02d}:{int(seconds // 60) % 60:02d}:{seconds % 60:06.3f}"


@pytest.mark.parametrize(
    ("name", "per_second"),
    [
        ("t_ms", 1e3),
        ("Time (ms)", 1e3),
        ("Time, ms", 1e3),
        ("time/ms", 1e3),
        ("time.ms", 1e3),
        ("TimeMs", 1e3),
        ("tms", 1e3),
        ("timestamp_ms", 1e3),
        ("elapsed ms", 1e3),
        ("Zeit in ms", 1e3),
        ("Millisekunden", 1e3),
        ("time_us", 1e6),
        ("time [min]", 1 / 60),
        ("t (min)", 1 / 60),
        ("time_min", 1 / 60),
        ("time [h]", 1 / 3600),
    ],
)
def test_the_name_says_the_unit(tmp_path: Path, name: str, per_second: float) -> None:
    recording = read_recording(write(tmp_path / "a.csv", name, [f"{t * per_second:.14g}" for t in TIMES]))
    assert recording["seat"].timepts == pytest.approx(TIMES, abs=1e-9)
    assert not recording.left_out


@pytest.mark.parametrize("step", [0.5, 0.9765625, 1.0, 1.25, 2.5, 3.90625, 5.0, 20.0])
def test_steps_that_can_only_be_milliseconds(tmp_path: Path, step: float) -> None:
    """As seconds, such a step is slower than any suspension moves; the reader says what it took them for."""
    recording = read_recording(write(tmp_path / "a.csv", "time", [f"{step * k:.10g}" for k in range(400)]))
    assert recording["seat"].timepts == pytest.approx(1e-3 * step * np.arange(400))
    ((name, why),) = recording.left_out
    assert name == "unit of 'time'"
    assert why.code is LeftOut.FINER_UNIT


@pytest.mark.parametrize(
    ("step", "level", "said"),
    [(5.0, Level.SOUND, ""), (1.25, Level.CARE, "800 if it is ms, fs=0.8 if it is s"), (64.0, Level.CARE, "fs=15625")],
)
def test_a_guessed_unit_calls_for_care_unless_a_clock_counts_so(
    tmp_path: Path, step: float, level: Level, said: str
) -> None:
    """Boards count milliseconds in whole numbers; with decimals they may be seconds, in large steps microseconds.

    No board that states no unit samples every 20 microseconds; many do so every 64.
    """
    time = step * np.arange(800)
    row = np.arange(800)
    samples = np.exp(-row / 400) * np.cos(2 * np.pi * row / 20) * 100
    samples += np.random.default_rng(1).standard_normal(800)
    path = tmp_path / "a.csv"
    np.savetxt(path, np.column_stack([time, samples]), fmt="%.8g", delimiter=",", header="time,seat", comments="")
    found = analyse(path)
    assert found.modes.wn == pytest.approx([2 * np.pi / (20e-3 * step)], rel=1e-3)
    guesses = [str(check) for check in found.verdict.checks if check.remark.code is RecordCheck.GUESSED_UNIT]
    assert (found.verdict.level, len(guesses)) == (level, int(level is Level.CARE))
    assert all(said in guess for guess in guesses)
    # A stated rate takes its place.
    stated = analyse(path, settings=Settings(fs=1e3 / step))
    assert RecordCheck.GUESSED_UNIT not in {check.remark.code for check in stated.verdict.checks}


def test_the_rate_to_give_is_that_of_the_whole_record(tmp_path: Path) -> None:
    """A timer in steps of 4 us: 64, 64, 60, … us are 62.67 us a row, and a rate 2 % off makes frequencies so."""
    stamps = np.cumsum(np.tile([64, 64, 60], 100))
    path = tmp_path / "a.csv"
    path.write_text("time,seat\n" + "".join(f"{t},{y:.6g}\n" for t, y in zip(stamps, SEAT[:300], strict=True)))
    ((_, why),) = read_recording(path).left_out
    assert f"fs={1e6 * 299 / (stamps[-1] - stamps[0]):.6g} if it is us" in str(why)


@pytest.mark.parametrize(("step", "rates"), [(510, ["1.96078", "1960.78"]), (1.0001, ["0.9999", "999.9"])])
def test_a_unit_in_which_the_record_is_too_short_is_not_guessed(tmp_path: Path, step: float, rates: list[str]) -> None:
    """A logger that writes a row each half second, or each second, is no record of microseconds or milliseconds."""
    path = tmp_path / "a.csv"
    path.write_text("time,seat\n" + "".join(f"{100 + step * k:.10g},{y:.6g}\n" for k, y in enumerate(SEAT[:100])))
    with pytest.raises(RecordError, match="the unit of 'time' is not stated; if it is .s, the record is only") as said:
        read_recording(path)
    for rate in rates:
        assert f"fs={rate} if it is" in str(said.value)
        # The rate that it says to give is that of the stamps, which it then takes in this unit.
        seat = read_recording(path, fs=float(rate))["seat"]
        assert np.diff(seat.timepts) == pytest.approx(1 / float(rate), rel=1e-5)


def test_that_few_rows_are_too_few_is_said_at_once(tmp_path: Path) -> None:
    """A table of twelve rows read by hand was to be given a rate, and refused with it."""
    path = tmp_path / "a.csv"
    path.write_text("time,seat\n" + "".join(f"{5.3 * k:.10g},{y:.6g}\n" for k, y in enumerate(SEAT[:12])))
    with pytest.raises(RecordError, match="it has 12 samples, and modes need 32"):
        read_recording(path)


@pytest.mark.parametrize(("step", "unit"), [(33.0, 1e3), (100.0, 1e3), (499.0, 1e3), (1872.0, 1e6), (20_000.0, 1e6)])
def test_the_unit_is_the_first_in_which_a_suspension_is_sampled_fast_enough(
    tmp_path: Path, step: float, unit: float
) -> None:
    """A board that counts microseconds and states no unit is not sampled every half hour."""
    recording = read_recording(
        write(tmp_path / "a.csv", "Time Stamp", [f"{19202812 + step * k:.0f}" for k in range(400)])
    )
    assert np.diff(recording["seat"].timepts) == pytest.approx(step / unit)
    ((_, why),) = recording.left_out
    assert why.code is LeftOut.FINER_UNIT


@pytest.mark.parametrize(("rate", "step"), [(5000.0, 2e-4), (5.0, 0.2), (0.005, 200.0)])
def test_large_steps_of_whole_numbers_may_be_nanoseconds(tmp_path: Path, rate: float, step: float) -> None:
    path = write(tmp_path / "a.csv", "time", [f"{200_000 * k}" for k in range(400)])
    assert f"fs={rate:g} if it is" in str(dict(read_recording(path).left_out)["unit of 'time'"])
    assert np.diff(read_recording(path, fs=rate)["seat"].timepts) == pytest.approx(step)


@pytest.mark.parametrize("rate", [50.0, 200.0, 1000.0])
def test_minutes_without_a_unit_are_asked_for(tmp_path: Path, rate: float) -> None:
    path = write(tmp_path / "a.csv", "time", [f"{k / rate / 60:.10g}" for k in range(400)])
    ((name, why),) = read_recording(path).left_out
    assert (name, why.code) == ("unit of 'time'", LeftOut.SHORT_SECONDS)
    assert f"fs={rate:g} if they are min" in str(why)


@pytest.mark.parametrize("step", [0.0005, 0.001, 0.01, 0.1, 0.4])
def test_steps_that_seconds_explain_stay_seconds(tmp_path: Path, step: float) -> None:
    recording = read_recording(write(tmp_path / "a.csv", "time", [f"{step * k:.10g}" for k in range(400)]))
    assert recording["seat"].timepts == pytest.approx(step * np.arange(400))
    assert not recording.left_out


def test_a_stated_unit_is_believed_whatever_the_step(tmp_path: Path) -> None:
    recording = read_recording(write(tmp_path / "a.csv", "time [s]", [f"{5.0 * k:g}" for k in range(400)]))
    assert recording["seat"].timepts == pytest.approx(5.0 * np.arange(400))


@pytest.mark.parametrize("name", ["time", "Uhrzeit", "stamp"])
@pytest.mark.parametrize("start", [39599.5, 86399.0], ids=["over an hour", "over midnight"])
@pytest.mark.parametrize("point", [".", ":"])
def test_a_clock(tmp_path: Path, name: str, start: float, point: str) -> None:
    stamps = [clock(start + t).replace(".", point) for t in TIMES]
    recording = read_recording(write(tmp_path / "a.csv", name, stamps))
    assert recording["seat"].timepts == pytest.approx(TIMES, abs=1e-9)


@pytest.mark.parametrize("name", ["ms", "min"])
def test_a_unit_alone_is_asked_for(tmp_path: Path, name: str) -> None:
    """min may be a minimum, ms a channel: --time says that it is the time, and its name then the unit."""
    per_second = {"ms": 1e3, "min": 1 / 60}[name]
    path = write(tmp_path / "a.csv", name, [f"{t * per_second:.14g}" for t in TIMES])
    with pytest.raises(RecordError, match=f"'{name}' increases like a time"):
        read_recording(path)
    assert read_recording(path, time=name)["seat"].timepts == pytest.approx(TIMES, abs=1e-9)


def test_a_unit_in_a_name_is_that_of_the_samples(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    t = np.arange(0, 4, 0.01)
    rows = [f"{a:.2f},{1e3 * b:.9g},{b:.9g}" for a, b in zip(t, np.exp(-t) * np.cos(20 * t), strict=True)]
    path.write_text("\n".join(["time [s],seat [mm],tire (g)", *rows]))
    found = analyse(path, settings=Settings(si=True, rename={"tire (g)": "wheel (g)"}))
    assert as_signal(found.record).channels == ("seat [m]", "wheel (m/s2)")


@pytest.mark.parametrize(("name", "step"), [("Time (ms)", 0.008), ("t_us", 0.01)])
def test_a_name_that_makes_seconds_microseconds_is_doubted(tmp_path: Path, name: str, step: float) -> None:
    stamps = [f"{step * k:.6g}" for k in range(400)]
    recording = read_recording(write(tmp_path / "a.csv", name, stamps))
    (said,) = dict(recording.left_out).values()
    assert said.code is LeftOut.TOO_FINE
    # What it says to type gives the time of the file in seconds.
    assert f"fs={1 / step:g}" in str(said)


@pytest.mark.parametrize("step", [0.05, 0.02, 5.0])
def test_fast_loggers_are_not_doubted(tmp_path: Path, step: float) -> None:
    assert not read_recording(write(tmp_path / "a.csv", "Time (ms)", [f"{step * k:.6g}" for k in range(400)])).left_out


class TestSeveralTimes:
    """Of columns that are named like times, the one that ascends evenly is the time, and is named."""

    NAMES = ("loggingTime", "gpsTimestamp_since1970(s)", "accTimestamp_sinceReboot(s)", "seat(m)")

    def table(self, tmp_path: Path, names: tuple[str, ...]) -> Recording:
        # The receiver has a position each second; the logger writes what is new now and then.
        columns = (3 * np.floor(TIMES / 3) + 0.1, 1.5e9 + np.floor(TIMES), 213_307.5 + TIMES, SEAT)
        rows = "".join(",".join(f"{x:.6f}" for x in row) + "\n" for row in zip(*columns, strict=True))
        path = tmp_path / "a.csv"
        path.write_text(",".join(names) + "\n" + rows)
        return read_recording(path)

    def test_the_same_time_in_another_unit_is_no_channel(self, tmp_path: Path) -> None:
        path = tmp_path / "a.csv"
        rows = "".join(f"{k / 500:.3f},{2 * k},{y:.6f}\n" for k, y in enumerate(SEAT))
        path.write_text(f"time_a,time_b,seat\n{rows}")
        assert [channel.name for channel in read_recording(path).channels] == ["seat"]

    def test_words_joined_by_capitals_are_words(self, tmp_path: Path) -> None:
        recording = self.table(tmp_path, self.NAMES)
        said = {name: remark.code for name, remark in recording.left_out}
        assert recording["seat(m)"].timepts == pytest.approx(213_307.5 + TIMES, abs=1e-9)
        assert said[self.NAMES[2]] is LeftOut.TAKEN_AS_TIME
        assert said[self.NAMES[1]] is LeftOut.LIKE_TIME

    def test_so_are_names_that_say_no_more(self, tmp_path: Path) -> None:
        recording = self.table(tmp_path, ("x", "timestamp", "time [s]", "seat"))
        said = {name: remark.code for name, remark in recording.left_out}
        assert recording["seat"].timepts == pytest.approx(213_307.5 + TIMES, abs=1e-9)
        assert said["timestamp"] is LeftOut.LIKE_TIME
        assert said["time [s]"] is LeftOut.TAKEN_AS_TIME


class TestSinceADate:
    """Stamps since 1970 or another date are counted from the first one: messages and options can name them."""

    @pytest.mark.parametrize(
        ("name", "per_second", "start"),
        [("time", 1.0, 1.7e9), ("time", 1e3, 1.7e12), ("time", 1e6, 1.7e15), ("t [s]", 1.0, 3.8e9)],
    )
    def test_the_first_stamp_is_zero_and_is_named(
        self, tmp_path: Path, name: str, per_second: float, start: float
    ) -> None:
        stamps = [f"{start + per_second * (0.25 + t):.3f}" for t in TIMES]
        recording = read_recording(write(tmp_path / "a.csv", name, stamps))
        # Of 3.8e9 s, doubles hold 5e-7 s.
        assert recording["seat"].timepts == pytest.approx(TIMES, abs=1e-9)
        said = {f"{part} {why}" for part, why in recording.left_out}
        assert f"start of {name!r} is {start / per_second + 0.25:.6f} s; times are counted from there" in said

    def test_stretches_are_chosen_and_named_in_it(self, tmp_path: Path) -> None:
        path = write(tmp_path / "a.csv", "time", [f"{1.7e9 + t:.3f}" for t in TIMES])
        assert clean(read_recording(path), start=0.5, stop=1.0).record.time[[0, -1]].tolist() == [0.5, 1.0]

    def test_clocks_keep_their_distance(self) -> None:
        raw = [
            RawChannel(name=name, unit="", timepts=np.asarray(1.7e9 + late + TIMES), values=SEAT, rate=None)
            for name, late in (("a", 0.125), ("b", 0.0))
        ]
        (first, second), _ = counted_from_first(raw, None)
        assert [first.timepts[0], second.timepts[0]] == [0.125, 0.0]

    def test_advice_on_late_times_can_be_typed(self) -> None:
        # Seconds of the week, as of GPS: six digits would not tell its times apart.
        rows = np.arange(4000)
        rows = rows[(rows < 1700) | (rows > 2100)]
        stamps = np.asarray(604_000.25 + STEP * rows, float)
        raw = RawChannel(name="seat", unit="m", timepts=stamps, values=np.sin(20 * stamps), rate=None)
        with pytest.raises(
            RecordError, match=r"start=604000\.25 and stop=604008\.745|start=604010\.755 and stop=604020\.245"
        ):
            clean(Recording(title="", channels=(raw,)))

    @pytest.mark.parametrize("start", [0.0, 604_000.0])
    def test_others_stay(self, tmp_path: Path, start: float) -> None:
        recording = read_recording(write(tmp_path / "a.csv", "time", [f"{start + t:.3f}" for t in TIMES]))
        assert recording["seat"].timepts.tolist() == [float(f"{start + t:.3f}") for t in TIMES]
        assert not recording.left_out


class TestTables:
    def test_a_column_of_milliseconds(self) -> None:
        record = as_record(pd.DataFrame({"t_ms": 1e3 * TIMES, "seat": SEAT}))
        assert np.asarray(record.time) == pytest.approx(TIMES)

    def test_a_step_that_can_only_be_milliseconds_is_asked_for(self) -> None:
        """A table in memory has no place for a remark, so nothing is guessed."""
        with pytest.raises(RecordError, match=r"call it 'time \[ms\]', or 'time \[s\]'"):
            as_record(pd.DataFrame({"time": 1e3 * TIMES, "seat": SEAT}))
        record = as_record(pd.DataFrame({"time [s]": 1e3 * TIMES, "seat": SEAT}))
        assert np.asarray(record.time) == pytest.approx(1e3 * TIMES)


@pytest.mark.parametrize(("pace", "outvoted"), [(1.01, False), (1.05, True)])
def test_stamps_outvote_a_stated_rate_that_is_further_off_than_clocks_are(
    tmp_path: Path, pace: float, outvoted: bool
) -> None:
    head = "LabVIEW Measurement\t\nX_Columns\tOne\n***End_of_Header***\t\nChannels\t2\nDelta_X\t0.01\t0.01\n"
    rows = "".join(f"{0.01 * pace * k:.6f}\t{np.sin(k):.6f}\t{np.cos(k):.6f}\n" for k in range(200))
    path = tmp_path / "a.lvm"
    path.write_text(f"{head}***End_of_Header***\t\t\nX_Value\tseat\ttire\n{rows}", encoding="utf-8")
    assert (LeftOut.OUTVOTED in [why.code for _, why in read_recording(path).left_out]) is outvoted


def test_stamps_of_rows_that_were_picked_outvote_the_rate_above_them(tmp_path: Path) -> None:
    """Every 16th row of a LabVIEW file was kept, and its header with the step of all rows."""
    head = "LabVIEW Measurement\t\nX_Columns\tOne\n***End_of_Header***\t\nChannels\t2\nDelta_X\t0.0001\t0.0001\n"
    rows = "".join(f"{0.0016 * k:.6f}\t{np.sin(k):.6f}\t{np.cos(k):.6f}\n" for k in range(200))
    path = tmp_path / "a.lvm"
    path.write_text(f"{head}***End_of_Header***\t\t\nX_Value\tseat\ttire\n{rows}", encoding="utf-8")
    recording = read_recording(path)
    assert recording["seat"].mean_rate == pytest.approx(625)
    assert LeftOut.OUTVOTED in [why.code for _, why in recording.left_out]
    assert np.diff(read_record(path).time) == pytest.approx(0.0016)


def test_a_unit_in_a_name_is_known_in_every_format(tmp_path: Path) -> None:
    t = np.arange(0, 4, 0.01)
    names, rows = ["seat [mm]", "tire_mm", "body"], np.exp(-t) * np.cos(20 * t) * np.array([[2.0], [1.0], [3.0]])
    np.savez(tmp_path / "a.npz", time=t, **dict(zip(names, rows, strict=True)))
    pd.DataFrame({"time": t, **dict(zip(names, rows, strict=True))}).to_csv(tmp_path / "a.csv", index=False)
    for path in (tmp_path / "a.npz", tmp_path / "a.csv"):
        found = analyse(path, settings=Settings(si=True, modes=1))
        signal = as_signal(found.record)
        assert signal.channels == ("seat [m]", "tire_m", "body")
        assert signal.values[:, 0] == pytest.approx([2e-3, 1e-3, 3.0])
        assert [str(note) for note in found.notes if "not converted" in str(note)] == [
            "channel 'body' was not converted: the file states no unit; scale multiplies it"
        ]


@pytest.mark.parametrize(("name", "per_second"), [("uptimeNanos", 1e9), ("Time since start in ms ", 1e3)])
def test_a_clock_of_a_telephone_is_no_channel(tmp_path: Path, name: str, per_second: float) -> None:
    """Beside a date in whole seconds, too: 808 s of a drive were judged by the jitter of such a column."""
    t = 0.02 * np.arange(400)
    lines = [f"14/05/2016 11:17:{9 + int(s):02d},{round(s * per_second + 5e12)},{np.sin(9 * s):.6f}" for s in t]
    (tmp_path / "a.csv").write_text("\n".join([f"timestamp,{name},z", *lines]))
    found = read_recording(tmp_path / "a.csv")
    assert [channel.name for channel in found.channels] == ["z"]
    np.testing.assert_allclose(np.diff(found["z"].timepts), 0.02, rtol=1e-6)


def test_of_a_column_without_a_name_it_is_guessed_that_it_is_a_time(tmp_path: Path) -> None:
    """A profile in steps of 10 mm reads the same; ms is the only unit that fits."""
    steps = np.arange(400)
    values = np.exp(-0.01 * steps) * np.cos(0.2 * steps) + 1e-3 * np.random.default_rng(1).standard_normal(400)
    path = tmp_path / "a.csv"
    path.write_text("".join(f"{10 * k},{y:.5f}\n" for k, y in zip(steps, values, strict=True)), encoding="utf-8")
    found = analyse(path)
    assert found.modes.wn == pytest.approx([20.0], rel=2e-3)
    assert found.verdict.level is Level.CARE
    (check,) = [check for check in found.verdict.checks if check.remark.code is RecordCheck.GUESSED_UNIT]
    assert "If it is another unit, or no time, all frequencies are wrong" in str(check)


def test_samples_too_slow_for_a_suspension_call_for_care(tmp_path: Path) -> None:
    """A step of 10 without a unit may be ms, and stamps in s may count the rows. A rate that is given is right."""
    from scipy.io import savemat

    motion = np.exp(-0.02 * np.arange(600)) * np.cos(0.3 * np.arange(600))
    motion = motion + 1e-3 * np.random.default_rng(1).standard_normal(600)
    savemat(tmp_path / "step.mat", {"y": motion, "dt": 10.0})
    checks = {check.remark.code: str(check) for check in analyse(tmp_path / "step.mat").verdict.checks}
    assert "10 s apart" in checks[RecordCheck.SLOW_SAMPLES]
    assert "100 if it is ms" in checks[RecordCheck.SLOW_SAMPLES]
    stated = analyse(tmp_path / "step.mat", settings=Settings(fs=0.1))
    assert RecordCheck.SLOW_SAMPLES not in {check.remark.code for check in stated.verdict.checks}


def test_a_clock_beside_its_channel_may_count_since_1970(tmp_path: Path) -> None:
    """Fields of one array in HDF5: whole microseconds, of which the size says the unit."""
    h5py = pytest.importorskip("h5py")
    rows = np.zeros(500, [("time", "<u8"), ("x", "<f4")])
    rows["time"] = 1_700_000_000_000_000 + 10_000 * np.arange(500, dtype=np.uint64)
    rows["x"] = np.cos(0.3 * np.arange(500))
    with h5py.File(tmp_path / "logger.h5", "w") as file:
        file["d"] = rows
    (channel,) = read_recording(tmp_path / "logger.h5").channels
    assert np.diff(channel.timepts) == pytest.approx(0.01, abs=1e-6)
