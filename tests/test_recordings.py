"""Recordings: each channel on its own clock, as the file states it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import ArrayLike

from suspid import RecordError
from suspid.io.names import stated_rate
from suspid.io.tables import Table, TimeBase
from suspid.io.timing import as_recording
from suspid.recordings import RawChannel, Recording
from suspid.units import RealArray
from suspid.words import LeftOut, Remark

COLUMNS = {
    "t": np.arange(4) / 4,
    "seat": np.array([1.0, 2.0, 4.0, 8.0]),
    "speed": np.array([3.0, 5.0]),
    "gps": np.array([7.0, 8.0, 9.0]),
}
FAST = TimeBase(name="fast", start=10.0, rate=4.0)
SLOW = TimeBase(name="slow", stamps=lambda: np.array([10.0, 10.9]))


def table(clocks: dict[str, TimeBase] | None = None, *, names: Sequence[str] = tuple(COLUMNS), **rates: float) -> Table:
    def columns(wanted: Sequence[str]) -> list[RealArray]:
        return [COLUMNS[name] for name in wanted]

    sizes = {name: COLUMNS[name].size for name in names}
    return Table(
        sizes=sizes, columns=columns, unusable={"note": Remark(LeftOut.TEXT)}, rates=rates, clocks=clocks or {}
    )


def channel(timepts: Sequence[float], values: Sequence[float], rate: float | None = None) -> RawChannel:
    return RawChannel(name="x", unit="", timepts=np.array(timepts), values=np.array(values), rate=rate)


class TestClocks:
    def test_channels_of_one_clock_share_one_array(self) -> None:
        recording = as_recording(table({"seat": FAST, "t": FAST, "speed": SLOW}, names=["seat", "t", "speed"]))
        assert recording["seat"].timepts is recording["t"].timepts
        assert recording["seat"].timepts.tolist() == [10.0, 10.25, 10.5, 10.75]
        assert recording["speed"].timepts.tolist() == [10.0, 10.9]
        assert (recording["seat"].rate, recording["speed"].rate) == (4.0, None)

    def test_stamps_are_read_once_for_all_channels(self) -> None:
        asked: list[int] = []

        def stamps() -> RealArray:
            asked.append(1)
            return np.arange(4.0)

        clock = TimeBase(name="group", stamps=stamps)
        as_recording(table({"seat": clock, "t": clock}, names=["seat", "t"]))
        assert len(asked) == 1

    def test_without_a_clock_time_is_the_column_of_that_name(self) -> None:
        recording = as_recording(table({"speed": SLOW}))
        assert recording.names == ("seat", "speed")
        assert recording["seat"].timepts.tolist() == COLUMNS["t"].tolist()
        assert str(dict(recording.left_out)["gps"]) == "has 3 samples, time 't' has 4"

    def test_time_that_is_named_rules_out_other_clocks(self) -> None:
        recording = as_recording(table({"seat": FAST, "speed": SLOW}), channels=["seat"], time="t")
        assert recording["seat"].timepts.tolist() == COLUMNS["t"].tolist()
        assert as_recording(table({"seat": FAST, "speed": SLOW}), time="slow").names == ("speed",)

    def test_a_given_rate_replaces_that_of_a_clock_and_of_the_file(self) -> None:
        for source in (table({"seat": FAST}, names=["seat"]), table(names=["seat"], Fs=4.0)):
            recording = as_recording(source, fs=5.0)
            assert np.diff(recording["seat"].timepts) == pytest.approx([0.2] * 3)
            assert recording["seat"].rate == 5.0
            assert Remark(LeftOut.OTHER_RATE, {"rate": 4.0, "fs": 5.0}) in dict(recording.left_out).values()

    def test_stamps_that_are_too_few_are_refused(self) -> None:
        with pytest.raises(RecordError, match="clock 'slow' has 2 stamps for 4 samples"):
            as_recording(table({"seat": SLOW}), channels=["seat"])

    def test_a_rate_in_the_file_is_that_of_columns_without_a_clock(self) -> None:
        recording = as_recording(table({"speed": SLOW}, names=["seat", "speed"], Fs=8.0))
        assert recording["seat"].timepts.tolist() == [0.0, 0.125, 0.25, 0.375]
        assert recording["speed"].rate is None


class TestTimeIgnored:
    def test_a_column_of_time_gives_way_to_the_rate(self) -> None:
        recording = as_recording(table(names=["t", "seat"]), time="none", fs=100.0)
        assert recording.names == ("seat",)
        assert recording["seat"].timepts.tolist() == [0, 0.01, 0.02, 0.03]
        assert dict(recording.left_out)["t"].code is LeftOut.IGNORED_TIME

    def test_so_do_stamps_of_clocks(self) -> None:
        recording = as_recording(table({"speed": SLOW}, names=["speed"]), time="none", fs=10.0)
        assert recording["speed"].timepts.tolist() == [0, 0.1]

    def test_without_a_rate_nothing_tells_the_time(self) -> None:
        with pytest.raises(RecordError, match="sampling rate"):
            as_recording(table(names=["t", "seat"]), time="none")


class TestWhatIsNoChannel:
    def test_a_column_that_counts_the_rows_unless_it_is_asked_for(self) -> None:
        columns = {"t": np.arange(4) / 4, "Sample": np.arange(4.0) + 1, "seat": np.ones(4), "index": np.ones(4)}
        source = Table(
            sizes=dict.fromkeys(columns, 4), columns=lambda names: [columns[n] for n in names], unusable={}, rates={}
        )
        recording = as_recording(source)
        assert recording.names == ("seat", "index")
        assert dict(recording.left_out)["Sample"].code is LeftOut.ROW_COUNTER
        assert as_recording(source, channels=["Sample"]).names == ("Sample",)

    def test_an_array_of_a_length_unlike_the_others(self) -> None:
        sizes = {"a": 4, "b": 4, "window": 9}
        source = Table(sizes=sizes, columns=lambda names: [np.zeros(sizes[n]) for n in names], unusable={}, rates={})
        recording = as_recording(source, fs=10.0)
        assert recording.names == ("a", "b")
        assert recording.left_out == (("window", Remark(LeftOut.LENGTH, {"samples": 9, "others": 4})),)

    @pytest.mark.parametrize("name", ["ActualRate", "Sample_Rate", "fs", "SamplingFrequency", "scan rate"])
    def test_a_number_that_states_the_rate(self, name: str) -> None:
        assert stated_rate(name, 887.14) == 887.14


class TestUnitsOfTime:
    @staticmethod
    def read(name: str, stamps: ArrayLike, fs: float | None = None) -> Recording:
        columns = {name: np.asarray(stamps, float), "seat": np.ones(np.size(stamps))}
        sizes = {column: values.size for column, values in columns.items()}
        return as_recording(Table(sizes=sizes, columns=lambda names: [columns[n] for n in names]), fs=fs)

    @pytest.mark.parametrize(("unit", "seconds"), [("h", 3600), ("hours", 3600), ("min", 60), ("days", 86_400)])
    def test_long_units_are_multiples_of_a_second(self, unit: str, seconds: float) -> None:
        stamps = self.read(f"time [{unit}]", np.arange(9.0))["seat"].timepts
        assert stamps == pytest.approx(seconds * np.arange(9))

    def test_an_unknown_unit_is_refused_with_those_that_are_known(self) -> None:
        with pytest.raises(RecordError, match=r"unit of time in 'time \[furlong\]' is not known; known: s, ms"):
            self.read("time [furlong]", np.arange(9.0))

    @pytest.mark.parametrize("wrong", [np.inf, -np.inf, np.nan, 1e12, 1e18])
    def test_one_wrong_stamp_does_not_change_the_unit(self, wrong: float) -> None:
        stamps = np.arange(99) / 100
        stamps[50] = wrong
        assert np.delete(self.read("time", stamps)["seat"].timepts, 50).tolist() == np.delete(stamps, 50).tolist()

    def test_whole_numbers_without_a_unit_are_said_to_be_taken_as_milliseconds(self) -> None:
        for name, stamps, said in (
            ("time", np.arange(20.0), True), ("timestamp", 5 * np.arange(20.0), True),
            ("time [s]", np.arange(20.0), False), ("time", np.arange(20) / 10, False),
            ("time", np.floor(np.arange(200) / 10), False), ("time", 1.7e12 + 5 * np.arange(20), False),
        ):  # fmt: skip
            codes = [remark.code for _, remark in self.read(name, stamps).left_out]
            assert (LeftOut.FINER_UNIT in codes) == said


class TestNothingIsChanged:
    def test_samples_and_stamps_are_read_only(self) -> None:
        raw = as_recording(table(), channels=["seat"])["seat"]
        assert not raw.timepts.flags.writeable
        with pytest.raises(dataclasses.FrozenInstanceError):
            raw.rate = 1.0  # type: ignore[misc]  # that is the point

    def test_what_is_no_channel_is_told_with_all_the_rest(self) -> None:
        assert ("note", Remark(LeftOut.TEXT)) in as_recording(table()).left_out
        assert "left out" in str(as_recording(table()))


class TestWhatAChannelSaysOfItself:
    def test_rate_of_the_median_step(self) -> None:
        assert channel([0, 0.5, 1, 5, 5.5], [0] * 5).mean_rate == 2

    def test_a_stated_rate_comes_first(self) -> None:
        assert channel([0, 0.5, 1], [0] * 3, rate=7.0).mean_rate == 7

    def test_gaps_are_holes_in_time_and_runs_of_nan(self) -> None:
        nan = float("nan")
        assert channel([0, 0.5, 1, 5, 5.5, 6], [nan, nan, 1, 2, nan, 3]).gaps == 3

    def test_length_is_between_the_earliest_and_the_latest_stamp(self) -> None:
        assert channel([3.0, 1.0, 2.0, float("nan")], [0] * 4).duration == 2

    def test_the_text_has_the_numbers_of_the_table(self) -> None:
        """A rate that was stated, before that of the stamps; runs of NaN among the gaps."""
        nan = float("nan")
        raw = channel([0, 0.5, 1, 5, 5.5, 6], [nan, nan, 1, 2, nan, 3], rate=7.0)
        found = Recording(title="", channels=(raw,))
        row = str(found).splitlines()[2].split()
        assert [float(cell) for cell in row[-4:]] == found.to_pandas().iloc[0, 2:].tolist() == [7, 6, 6, 3]

    @pytest.mark.parametrize("timepts", [[], [1.0], [float("nan")] * 3, [2.0, 2.0]])
    def test_no_clock_to_speak_of(self, timepts: list[float]) -> None:
        raw = channel(timepts, [0.0] * len(timepts))
        assert np.isnan(raw.mean_rate)
        assert raw.gaps == 0

    def test_the_table_reads_a_clock_that_all_share_once(self, monkeypatch: pytest.MonkeyPatch) -> None:
        seen: list[RealArray] = []

        def read(stamps: RealArray) -> tuple[float, int]:
            seen.append(stamps)
            return 4.0, 0

        monkeypatch.setattr("suspid.recordings.rate_and_gaps", read)
        one, values = np.arange(9) / 4, np.zeros(9)
        raw = [RawChannel(name=name, unit="", timepts=one, values=values, rate=None) for name in "abc"]
        str(Recording(title="", channels=(*raw, dataclasses.replace(raw[0], name="d", timepts=one + 1))))
        assert len(seen) == 2

    def test_an_unknown_name_gets_the_nearest(self) -> None:
        with pytest.raises(RecordError, match="no channel 'seet'. Did you mean 'seat'"):
            as_recording(table())["seet"]
