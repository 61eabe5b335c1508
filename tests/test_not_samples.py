"""Data that are no samples, or in another order, and calls that lack something: each error has the line to write."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import control
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import suspid
from suspid import (
    ModalSet,
    RecordError,
    RecordWarning,
    Settings,
    SuspidError,
    analyse,
    analyse_drive,
    as_record,
    compare,
    eigenmodes,
    identify,
)
from suspid.cli import main

FS = 100.0
TIME = np.arange(400) / FS
SEAT = np.exp(-0.5 * TIME) * np.cos(20 * TIME)
TIRE = 2 * np.exp(-0.5 * TIME) * np.sin(20 * TIME)
CAR = suspid.quarter_car(
    chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=2e5, chassis_damping=1500
)
STRUCTURED = np.array(list(zip(TIME, SEAT, strict=True)), dtype=[("t", float), ("seat", float)])
TWICE = pd.DataFrame(np.array([TIME, SEAT, TIRE]).T, columns=["t", "a", "a"])
TURNS = [lambda t: t[:, None], lambda t: t[None, :], np.ma.masked_array, list, np.asfortranarray]
S = control.tf("s")


@pytest.mark.parametrize(
    ("make", "way"),
    [
        (lambda: as_record((SEAT, TIME)), r"write as_record\(\(timepts, samples\)\)"),
        (lambda: as_record((FS, SEAT)), r"the number 100: write as_record\(data, fs=...\)"),
        (lambda: as_record((SEAT, int(FS))), r"the number 100: write as_record\(data, fs=...\)"),
        (lambda: as_record([TIME, SEAT, TIRE]), r"as_record\(\(data\[0\], data\[1:\]\)\)"),
        (lambda: as_record((TIME, SEAT, TIRE)), r"as_record\(\(data\[0\], data\[1:\]\)\)"),
        (lambda: as_record(np.array([TIME, SEAT]), fs=FS), r"row 0 .* is the time, in steps of 0.01: write as_record"),
        (lambda: as_record(np.array([1e3 * TIME, SEAT]), fs=FS), r"row 0 .* is the time, .* with times in s"),
        (lambda: as_record(SEAT, timepts=0.01), "give fs"),
        (lambda: as_record(SEAT, timepts=TIME[:100]), "100 time points, but 400 samples: .* give fs"),
        (
            lambda: as_record(STRUCTURED),
            r"'t', 'seat': .*pandas.DataFrame\(data\)",
        ),
        (lambda: as_record(None, fs=FS), "is None .* pass an array"),
        (lambda: as_record((y for y in SEAT), fs=FS), "type generator .* pass an array"),
        (lambda: identify(CAR), "type Suspension .* pass an array"),
        (lambda: identify(eigenmodes(CAR)), "pass an array"),
        (lambda: as_record(SEAT, fs=FS, channels="seat"), "must name 1 channel in a list"),
        (
            lambda: as_record(TWICE),
            "more than once: 'a'",
        ),
        (lambda: as_record(pd.Series(SEAT, index=1e3 * TIME)), r"steps of 10 s are too slow .* 'time \[ms\]'"),
        (lambda: analyse_drive(SEAT), r"record 1: .* write as_record\(data, fs="),
        (lambda: analyse_drive(None), "record 1: .* pass an array"),
    ],
)
def test_what_is_no_record_is_told_with_the_line_to_write(make: Callable[[], object], way: str) -> None:
    with pytest.raises(RecordError, match=way):
        make()


@pytest.mark.parametrize("turn", TURNS)
def test_times_as_matlab_writes_them(turn: Callable[[Any], Any]) -> None:
    """A row or a column of times is a vector of them."""
    for record in (as_record((turn(TIME), SEAT)), as_record(SEAT, timepts=turn(TIME))):
        np.testing.assert_array_equal(record.time, TIME)
        np.testing.assert_array_equal(np.ravel(record.y), SEAT)


def test_a_ramp_that_is_named_or_slower_is_a_channel() -> None:
    named = as_record(np.array([TIME, SEAT]), fs=FS, channels=["rack", "seat"])
    assert named.output_labels == ["rack", "seat"]
    assert len(as_record(np.array([0.3 * TIME, SEAT]), fs=FS).output_labels) == 2


def test_a_rate_beside_a_time_that_states_another_is_said() -> None:
    """The frequencies would be wrong by the ratio of the rates."""
    with pytest.warns(RecordWarning, match="fs = 50 Hz replaces the time in the data, which states 100 Hz"):
        record = as_record((TIME, SEAT), fs=50)
    assert record.time[1] == pytest.approx(1 / 50)
    # Fifty samples have 49 steps.
    for count in (len(TIME), 50):
        assert as_record((TIME[:count], SEAT[:count]), fs=FS).time[1] == pytest.approx(1 / FS)


@pytest.mark.parametrize(
    ("system", "way"),
    [
        (S**2 + 1, "degree of its numerator"),
        (control.tf([[[1], [1]]], [[[1, 0.2, 100], [1, 0.2, 400]]]), r"system\[0, 0\]"),
        (control.frd(1 / (S**2 + S + 1), [1.0, 2.0]), "without poles"),
        (np.eye(2), r"control.ss\(A, B, C, D\)"),
        ("examples/car.toml", "read_car"),
        (as_record(SEAT, fs=FS), "identify finds the modes"),
    ],
)
def test_what_has_no_eigenmodes_is_told_with_what_has(system: Any, way: str) -> None:
    with pytest.raises(SuspidError, match=way):
        eigenmodes(system)


@pytest.mark.parametrize(
    ("call", "way"),
    [
        (lambda: suspid.road("C"), r"'speed'; help\(suspid.road\)"),  # type: ignore[call-arg]
        (lambda: suspid.add_noise(SEAT), r"'rng'; help\(suspid.add_noise\)"),  # type: ignore[call-arg]
        (lambda: analyse(SEAT, fs=FS), r"settings=Settings\(fs=…\)"),  # type: ignore[call-arg]
        (lambda: analyse(SEAT, modes=1), r"settings=Settings\(modes=…\)"),  # type: ignore[call-arg]
        (lambda: suspid.ride(SEAT, fs=FS), r"pass as_record\(data, fs=…\)"),  # type: ignore[call-arg]
    ],
)
def test_what_a_call_lacks_or_has_elsewhere(call: Callable[[], object], way: str) -> None:
    with pytest.raises(TypeError, match=way):
        call()


def test_the_settings_that_an_error_names_are_taken() -> None:
    settings = Settings(fs=FS, modes=1)
    assert (settings.fs, settings.modes) == (FS, 1)


@pytest.mark.parametrize("rtol", [2, 1.5, {"wn": 0.01, "zeta": 5}])
def test_a_tolerance_in_percent_is_refused(rtol: Any) -> None:
    """A relative tolerance above one would pass a value of zero, and one that is twice as large."""
    modes = ModalSet.from_wn_zeta([10.0], [0.3])
    with pytest.raises(SuspidError, match="it is a ratio below 1, 1 % is 0.01"):
        compare(modes, modes, rtol=rtol)


def test_a_mode_beyond_the_last() -> None:
    with pytest.raises(IndexError, match="there are 1, numbered from 0"):
        ModalSet.from_wn_zeta([10.0], [0.3])[1]


def test_drives_are_taken_from_memory_as_from_a_recording() -> None:
    """A table and a response with the same samples give the same stretches as the recording made of them."""
    made = suspid.Recording(
        title="",
        channels=(suspid.RawChannel(name="chassis_acceleration", unit="", timepts=TIME, values=SEAT, rate=FS),),
    )
    record = as_record(SEAT, fs=FS, channels=["chassis_acceleration"])
    table = pd.DataFrame({"chassis_acceleration": SEAT}, index=TIME)
    expected = [str(one) for one in analyse_drive(made, car=CAR).drives]
    for given in (record, [record], table):
        assert [str(one) for one in analyse_drive(given, car=CAR).drives] == expected


def test_what_is_compared_is_made_by_another_command() -> None:
    shown = CliRunner().invoke(main, ["compare", "examples/quarter_car.csv", "examples/quarter_car.csv"])
    assert shown.exit_code == 1
    assert "`suspid identify RECORD --json FILE`" in " ".join(shown.output.split())


class TestFiles:
    def written(self, path: Path, head: str, *columns: Any) -> Path:
        path.write_text(head + "\n" + "".join(",".join(map(str, row)) + "\n" for row in zip(*columns, strict=True)))
        return path

    def test_times_of_day_in_whole_seconds_and_the_parts_of_each_second(self, tmp_path: Path) -> None:
        rows = np.arange(len(TIME))
        clock, parts = [f"10:20:{30 + k // 100}" for k in rows], 10 * (rows % 100)
        for name, per in (("Millisecond", 1), ("microseconds", 1000)):
            path = self.written(tmp_path / "a.csv", f"Time,{name},seat", clock, per * parts, SEAT)
            recording = suspid.read_recording(path)
            np.testing.assert_allclose(recording["seat"].timepts, TIME, rtol=0, atol=1e-9)
            assert str(dict(recording.left_out)[name]) == "holds the parts of a second, beside the time 'Time'"

    def test_milliseconds_that_do_not_start_again_are_the_time(self, tmp_path: Path) -> None:
        clock = [f"10:20:{30 + k // 100}" for k in range(len(TIME))]
        path = self.written(tmp_path / "a.csv", "Time,Millisecond,seat", clock, np.round(1e3 * TIME), SEAT)
        np.testing.assert_allclose(suspid.read_recording(path)["seat"].timepts, TIME, rtol=0, atol=1e-9)

    @pytest.mark.parametrize(
        ("heads", "factor", "called"),
        [
            ("t,seat\nsec,millimeter", 1e-3, "seat"),
            ("t,seat\nseconds,Degrees", np.pi / 180, "seat"),
            ("t,seat\ns,feet", 0.3048, "seat"),
            ("t/s,seat/mm", 1e-3, "seat/m"),
            ("t/s,v / cm/s", 1e-2, "v / m/s"),
            ("t/s,phi/°", np.pi / 180, "phi/rad"),
            ("t/s,strain_mm/mm", 1.0, "strain_mm/mm"),
            ("t/s,imu/g", 1.0, "imu/g"),
        ],
    )
    def test_units_in_words_and_behind_a_solidus(self, tmp_path: Path, heads: str, factor: float, called: str) -> None:
        path = self.written(tmp_path / "a.csv", heads, TIME, SEAT)
        record = suspid.analyse(path, settings=Settings(si=True)).record
        assert record.output_labels == [called]
        assert np.max(np.abs(record.y)) == pytest.approx(factor * np.max(np.abs(SEAT)), rel=1e-3)
