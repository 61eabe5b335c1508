"""Clocks: stamps spoiled in a known way lead back to the clock they came from."""

from __future__ import annotations

import contextlib
from decimal import ROUND_HALF_DOWN, ROUND_HALF_EVEN, ROUND_HALF_UP, Decimal

import numpy as np
import pytest
from numpy.typing import ArrayLike

from suspid.cleaning import clean
from suspid.cleaning.clock import Clock
from suspid.cleaning.clocks import read_clock
from suspid.cleaning.following import share_followed
from suspid.errors import RecordError
from suspid.recordings import RawChannel, Recording
from suspid.stamps import grid_of, resolution
from suspid.stamps.digits import least_excess, line_within
from suspid.stamps.lines import _longest
from suspid.stamps.tracking import _beats
from suspid.units import RealArray
from suspid.words import Defect


def wave(times: RealArray, rng: np.random.Generator | None = None) -> RealArray:
    """A decay of 5 Hz, with noise 40 dB below its start."""
    noise = 0.0 if rng is None else 0.01 * rng.standard_normal(times.size)
    return np.asarray(np.exp(-0.5 * times) * np.sin(2 * np.pi * 5 * times) + noise)


def kinds(clock: Clock) -> list[str]:
    return [str(finding.kind) for finding in clock.findings]


class TestAUniformClockStays:
    @pytest.mark.parametrize("rate", [10.0, 333.0, 1000.0, 1280.0])
    @pytest.mark.parametrize("start", [0.0, 17.3, 1.6e9])
    def test_to_the_last_bit(self, rate: float, start: float) -> None:
        stamps = start + np.arange(500) / rate
        clock = read_clock(stamps, wave(stamps - start)[None])
        assert clock.timepts.tobytes() == stamps.tobytes()
        assert not clock.findings

    def test_stamps_of_a_grid_that_its_printing_keeps(self) -> None:
        stamps = np.array([float(f"{k / 500:.6f}") for k in range(400)])
        clock = read_clock(stamps, wave(stamps)[None])
        assert clock.timepts.tobytes() == stamps.tobytes()


class TestRoundedStamps:
    @pytest.mark.parametrize(
        ("rate", "quantum"),
        [(333.0, 1e-3), (101.3, 1e-3), (1280.0, 1e-3), (2000.0, 1e-3), (700.0, 1e-3), (37.7, 1e-2), (60.0, 5e-3)],
    )
    @pytest.mark.parametrize("way", [np.round, np.floor])
    def test_the_true_step_lies_in_the_interval_stated(self, rate: float, quantum: float, way: object) -> None:
        assert callable(way)
        true = 3.0 + np.arange(1500) / rate
        stamps = np.asarray(way(true / quantum + 1e-9) * quantum, float)
        grid = grid_of(stamps)
        assert grid is not None
        assert grid.places.tolist() == list(range(1500))
        # A uniform distribution reaches sqrt(3) standard deviations; a hundredth for the search.
        assert abs(grid.step - 1 / rate) <= 1.01 * np.sqrt(3) * grid.step_std
        # No grid can be told better than by a resolution over the whole record.
        assert grid.step_std <= 2 * quantum / (1499 / np.sqrt(12))

    def test_every_row_becomes_one_sample(self) -> None:
        stamps = np.round(np.arange(1000) / 333, 3)
        clock = read_clock(stamps, wave(stamps)[None])
        assert kinds(clock) == ["rounded stamps"]
        assert clock.places is not None
        assert clock.places.tolist() == list(range(1000))
        # Half the resolution, and a hundredth of it for stamps that lie on the border.
        assert np.max(np.abs(clock.timepts - stamps)) <= 0.51e-3

    @pytest.mark.parametrize("quantum", [1.0, 0.5, 0.02, 1e-3, 5e-5])
    def test_resolution_is_found(self, quantum: float) -> None:
        stamps = np.round(np.arange(300) * np.pi / 4 / quantum) * quantum
        assert resolution(stamps) == pytest.approx(quantum, rel=1e-9)

    def test_single_precision(self) -> None:
        true = 1000 + np.arange(2000) / 333
        clock = read_clock(true.astype(np.float32).astype(float), wave(true - 1000)[None])
        assert kinds(clock) in ([], ["rounded stamps"])
        assert 1 / clock.step == pytest.approx(333, rel=1e-5)


class TestRows:
    def test_missing_ones_leave_holes_in_their_places(self) -> None:
        rng = np.random.default_rng(1)
        kept = np.sort(rng.choice(np.arange(1, 1999), 1980, replace=False))
        for stamps in (kept / 100, np.round(kept / 333, 3)):
            clock = read_clock(stamps, wave(stamps)[None])
            assert clock.places is not None
            assert clock.places.tolist() == (kept - kept[0]).tolist()
            assert kinds(clock)[-1] == "missing rows"
            assert clock.findings[-1].samples == kept[-1] - kept[0] + 1 - kept.size

    def test_doubled_ones_are_dropped(self) -> None:
        rows = np.insert(np.arange(1000), [300, 700], [300, 700])
        values = wave(np.arange(1000) / 100)[rows]
        clock = read_clock(rows / 100, values[None])
        assert kinds(clock) == ["repeated rows"]
        assert clock.timepts.tolist() == (np.arange(1000) / 100).tolist()
        assert values[clock.rows].tolist() == wave(np.arange(1000) / 100).tolist()

    def test_swapped_ones_are_sorted(self) -> None:
        order = np.arange(1000)
        order[[400, 401]] = order[[401, 400]]
        values = wave(np.arange(1000) / 100)[order]
        clock = read_clock(order / 100, values[None])
        assert kinds(clock) == ["swapped rows"]
        assert values[clock.rows].tolist() == wave(np.arange(1000) / 100).tolist()

    @pytest.mark.parametrize("wrong", [3.0, -70.0, 7.99, 900.0])
    def test_one_stamp_out_of_line_does_not_move_its_row(self, wrong: float) -> None:
        stamps = np.arange(1000) / 100
        stamps[500] = wrong
        clock = read_clock(stamps, wave(np.arange(1000) / 100)[None])
        assert "wrong stamps" in kinds(clock)
        assert clock.rows.tolist() == list(range(1000))
        assert clock.timepts == pytest.approx(np.arange(1000) / 100, abs=1e-4)  # a hundredth of a step

    @pytest.mark.parametrize("wrong", [-999.0, -1e10, 1e12, np.inf, -np.inf, np.nan])
    @pytest.mark.parametrize("start", [0.0, 1.7e9])
    @pytest.mark.parametrize("rows", [[0], [999], [0, 1, 2], [0, 998, 999]])
    def test_wrong_stamps_at_the_ends_leave_the_other_rows_their_clock(
        self, wrong: float, start: float, rows: list[int]
    ) -> None:
        stamps = start + np.arange(1000) / 200
        kept = np.delete(np.arange(1000), rows)
        values = wave(stamps - start)[None]
        stamps[rows] = wrong
        clock = read_clock(stamps, values)
        assert clock.rows.tolist() == kept.tolist()
        assert clock.timepts == pytest.approx(stamps[kept], abs=1e-6)
        assert kinds(clock) == (["wrong stamps"] if abs(wrong) < np.inf else ["no stamp"])

    def test_a_gap_that_asks_for_more_memory_than_the_rows_deserve_is_refused(self) -> None:
        stamps = np.arange(1000) / 200
        stamps[500:] += 1e9
        with pytest.raises(RecordError, match=r"1e\+09 s after row 500, 2.495 s"):
            read_clock(stamps, wave(np.arange(1000) / 200)[None])

    @pytest.mark.parametrize("rate", [100.0, 887.0])
    def test_those_after_the_clock_has_stopped_are_left_out(self, rate: float) -> None:
        stamps = np.round(np.minimum(np.arange(1000), 599) / rate, 3)
        clock = read_clock(stamps, wave(np.arange(1000) / rate)[None])
        assert kinds(clock)[0] == "stopped clock"
        assert clock.rows.tolist() == list(range(600))
        assert clock.timepts[-1] == pytest.approx(599 / rate, abs=1e-3)

    def test_coarse_stamps_do_not_stop(self) -> None:
        stamps = np.floor(np.arange(1000) / 100)
        clock = read_clock(stamps, wave(np.arange(1000) / 100)[None])
        assert kinds(clock) == ["rounded stamps"]
        assert clock.rows.size == 1000

    def test_those_without_a_stamp_are_missing(self) -> None:
        stamps = np.arange(500) / 100
        stamps[77] = np.nan
        clock = read_clock(stamps, wave(np.arange(500) / 100)[None])
        assert kinds(clock) == ["no stamp", "missing rows"]
        assert clock.places is not None
        assert 77 not in clock.places

    def test_a_restart_is_refused_with_the_longest_run(self) -> None:
        stamps = np.concatenate([np.arange(1200), np.arange(800)]) / 100
        with pytest.raises(RecordError, match=r"after row 1200 .* rows 1 to 1200, 0 to 11.99 s"):
            read_clock(stamps, wave(stamps)[None])

    def test_two_samples_under_one_stamp_are_refused_unless_rounded(self) -> None:
        steps = np.full(999, 0.01)
        steps[[200, 500, 501, 502, 700]] = 0.0
        stamps = np.concatenate([[0.0], np.cumsum(steps)]) + np.sqrt(2) * np.linspace(0, 1e-6, 1000).round(9)
        stamps[201] = stamps[200]
        with pytest.raises(RecordError, match="time stamps repeat the one before|irregular"):
            read_clock(np.repeat(np.cumsum(np.random.default_rng(1).exponential(size=500)), 2), wave(stamps)[None])

    @pytest.mark.parametrize("rate", [None, 500.0])
    def test_a_mass_at_rest_repeats_samples_under_coarse_stamps(self, rate: float | None) -> None:
        # A spreadsheet shows whole seconds: it rounds half to even.
        times = np.arange(5754) / 500
        values = np.round(wave(times), 5)
        stamps = np.round(times)
        assert 0 < np.sum((np.diff(values) == 0) & (np.diff(stamps) == 0)) < 0.01 * times.size
        clock = read_clock(stamps, values[None], rate=rate, override=rate is not None)
        assert clock.rows.tolist() == list(range(5754))
        assert kinds(clock) == ["rounded stamps"]
        assert 1 / clock.step == pytest.approx(500, abs=0.1 if rate is None else 1e-9)  # a row in the record

    @pytest.mark.parametrize("seconds", [4.6, 11.2])
    def test_a_few_whole_seconds_with_hundreds_of_rows_each_show_the_rate(self, seconds: float) -> None:
        times = np.arange(int(500 * seconds)) / 500
        clock = read_clock(np.round(times), wave(times)[None])
        assert 1 / clock.step == pytest.approx(500, rel=2e-3 / seconds)  # a row in the record


SEEDS = [*range(3), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 10))]


class TestJitter:
    """The same stamps: wrong if the samples are regular, right if the samples were taken then."""

    def test_a_clock_that_wanders_under_rounded_stamps_keeps_its_samples(self) -> None:
        """A controller at about 887 Hz, whose rate changes by half a permille, stamped in whole milliseconds."""
        rates = np.repeat([887.4, 887.0, 886.6], 3300)
        true = np.cumsum(1 / rates)
        clock = read_clock(np.floor(true * 1000) / 1000, np.sin(15.5 * true)[None])
        assert clock.places is not None
        assert np.array_equal(clock.places, np.arange(true.size))
        assert 1 / clock.step == pytest.approx(887.0, rel=1e-3)
        assert kinds(clock) == ["jittering stamps"]

    def test_long_steps_at_a_beat_are_no_missing_rows(self) -> None:
        """The same controller, further off a line: the steps of 2 ms come after 7 or 8 rows, which is no chance."""
        rates = 886.3 + 1.0 * np.sin(np.arange(20_000) / 3000)
        true = np.cumsum(1 / rates)
        clock = read_clock(np.floor(true * 1000) / 1000, np.sin(15.5 * true)[None])
        assert clock.places is not None
        assert np.array_equal(clock.places, np.arange(true.size))
        assert 1 / clock.step == pytest.approx(886.3, rel=1e-3)
        lost = np.random.default_rng(1).random(20_000) < 0.1
        rows = np.flatnonzero(~lost)
        by_chance = read_clock(rows / 1000, np.sin(rows / 60)[None])
        assert by_chance.places is not None
        assert np.array_equal(by_chance.places, rows - rows[0])

    def test_long_steps_by_chance_are_no_beat(self) -> None:
        steps = np.where(np.random.default_rng(1).random(5000) < 0.1, 0.002, 0.001)
        assert not _beats(steps, 0.001)
        assert _beats(np.where(np.arange(5000) % 9 == 0, 0.002, 0.001), 0.001)

    def test_stamps_that_stray_further_are_irregular_still(self) -> None:
        rates = np.repeat([900.0, 887.0, 870.0], 3300)
        true = np.cumsum(1 / rates)
        assert read_clock(np.floor(true * 1000) / 1000, np.sin(15.5 * true)[None]).places is None

    @pytest.mark.parametrize("seed", SEEDS)
    @pytest.mark.parametrize("rounding", [3, 9])
    def test_told_from_irregular_sampling_by_the_samples(self, seed: int, rounding: int) -> None:
        rng = np.random.default_rng(seed)
        regular = np.arange(2000) / 100
        moved = regular + rng.uniform(-3e-3, 3e-3, 2000)
        stamps = np.round(moved, rounding)
        late = read_clock(stamps, wave(regular, rng)[None])
        assert kinds(late) == ["jittering stamps"]
        assert late.places is not None
        right = read_clock(stamps, wave(moved, rng)[None])
        assert kinds(right) == ["irregular stamps"]
        assert right.places is None

    def test_where_the_record_cannot_tell_no_sample_is_changed(self) -> None:
        rng = np.random.default_rng(0)
        stamps = np.arange(2000) / 100 + rng.uniform(-3e-3, 3e-3, 2000)
        clock = read_clock(stamps, rng.standard_normal((1, 2000)))
        assert kinds(clock) == ["jittering stamps"]
        assert "do not follow them" in clock.findings[0].text

    @pytest.mark.parametrize("seed", SEEDS)
    def test_rows_missing_among_jittering_stamps_are_counted(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        kept = np.delete(np.arange(3000), [50, 51, 1000, 2222])
        stamps = np.round(kept / 100 + rng.normal(0, 1.3e-3, kept.size), 3)
        clock = read_clock(stamps, wave(kept / 100, rng)[None])
        assert kinds(clock) == ["jittering stamps", "missing rows"]
        assert clock.places is not None
        assert clock.places.tolist() == kept.tolist()

    def test_steps_of_a_logger_that_often_waits_are_no_gaps(self) -> None:
        rng = np.random.default_rng(7)
        steps = rng.integers(7, 13, 8000) + np.where(rng.random(8000) < 0.09, rng.integers(14, 17, 8000), 0)
        stamps = np.cumsum(steps) / 1000
        swing = np.sin(2 * np.pi * 0.4 * stamps)
        raw = RawChannel(name="swing", unit="", timepts=stamps, values=swing, rate=None)
        cleaned = clean(Recording(title="", channels=(raw,)))
        assert [str(finding.kind) for finding in cleaned.findings] == ["irregular stamps", "missing"]
        # No more samples are missing than rows are on a clock of the mean rate between the waits.
        assert 0 < cleaned.findings[1].samples < 1.2 * (cleaned.record.time.size - stamps.size)
        assert np.max(np.abs(cleaned.record.y[0] - np.sin(2 * np.pi * 0.4 * cleaned.record.time))) < 1e-3

    @pytest.mark.parametrize(
        ("noisy", "said"),
        [
            ((False,), "% of the motion over all frequencies"),
            ((False, True), "% of the motion in 'c0' (rms, with noise); most of some other"),
            ((True, True), "but most of the record is faster: noise, or motion"),
        ],
    )
    def test_the_error_is_said_for_the_channel_that_moves(self, noisy: tuple[bool, ...], said: str) -> None:
        rng = np.random.default_rng(7)
        stamps = np.cumsum(rng.integers(7, 18, 4000)) / 1000
        raw = [
            RawChannel(name=f"c{k}", unit="", timepts=stamps, rate=None,
                       values=rng.standard_normal(4000) if noise else np.sin(2.5 * stamps))
            for k, noise in enumerate(noisy)
        ]  # fmt: skip
        assert said in clean(Recording(title="", channels=tuple(raw))).findings[0].text

    def test_event_driven_stamps_are_refused(self) -> None:
        stamps = np.cumsum(np.random.default_rng(2).exponential(0.01, 2000))
        with pytest.raises(RecordError, match="too irregular"):
            read_clock(stamps, wave(stamps)[None])

    def test_all_of_the_time_in_holes_is_100_per_cent(self) -> None:
        """Bursts of three rows, some seconds apart: all but 2 in 1000 of the time is in the waits."""
        stamps = np.cumsum(np.tile([2.0, 0.001, 0.001], 400) * (1 + 0.3 * np.random.default_rng(3).random(1200)))
        with pytest.raises(RecordError, match="but 100 % of the time is in steps above"):
            read_clock(stamps, wave(stamps)[None])


class TestAnyGrid:
    """Rows on a uniform clock, stamped, rounded and with rows lost: the rows come back to their places.

    The law: a row lies off the line by at most the resolution, a row behind a gap by a whole number of steps.
    """

    GRIDS = (
        (10.3, 0.1), (17.7, 1e-2), (60.7, 1e-3), (101.3, 1e-2), (433.1, 1e-3), (887.14, 1e-3), (887.14, 1e-4),
        (3333.3, 1e-4), (19_200.7, 1e-5),
    )  # fmt: skip
    COARSE = ((100.0, 1.0), (100.3, 1.0), (1280.0, 1e-3), (2000.3, 1e-2), (12_800.0, 1e-3), (1000.0, 1 / 64))

    @staticmethod
    def stamps(rate: float, quantum: float, kept: ArrayLike, *, way: str, ppm: float = 0.0) -> RealArray:
        times = 0.4321 + np.asarray(kept, float) / rate * (1 + 1e-6 * ppm)
        places = times / quantum
        rounded = np.floor(places) if way == "floor" else np.ceil(places) if way == "ceil" else np.round(places)
        return np.asarray(rounded * quantum)

    @pytest.mark.parametrize(("rate", "quantum"), GRIDS)
    @pytest.mark.parametrize("way", ["round", "floor", "ceil"])
    @pytest.mark.parametrize("lost", [1, 2, 17, 500])
    def test_a_gap_is_found_in_its_place(self, rate: float, quantum: float, way: str, lost: int) -> None:
        kept = np.delete(np.arange(4000), [*range(1234, 1234 + lost), *range(3000, 3005)])
        stamps = self.stamps(rate, quantum, kept, way=way)
        clock = read_clock(stamps, wave(kept / rate)[None])
        assert clock.places is not None
        assert clock.places.tolist() == kept.tolist()
        assert clock.step == pytest.approx(1 / rate, rel=quantum * rate / 4000)

    @pytest.mark.parametrize(("rate", "quantum"), [*GRIDS, *COARSE])
    @pytest.mark.parametrize("ppm", [1.0, 30.0, 1000.0])
    @pytest.mark.parametrize("way", ["round", "floor"])
    def test_a_clock_that_is_fast_or_slow_has_no_gap(self, rate: float, quantum: float, ppm: float, way: str) -> None:
        stamps = self.stamps(rate, quantum, np.arange(9000.0), way=way, ppm=ppm)
        clock = read_clock(stamps, wave(np.arange(9000) / rate)[None])
        assert set(kinds(clock)) <= {"rounded stamps"}
        assert clock.timepts.size == 9000
        # No grid is told better than by a resolution over the record.
        assert clock.step == pytest.approx((1 + 1e-6 * ppm) / rate, rel=1.01 * min(1.0, quantum * rate) / 9000)

    @pytest.mark.parametrize(("rate", "quantum"), COARSE)
    @pytest.mark.parametrize("way", ["round", "floor"])
    def test_where_many_rows_share_a_stamp_a_gap_is_found_to_within_the_resolution(
        self, rate: float, quantum: float, way: str
    ) -> None:
        kept = np.delete(np.arange(9000), range(4321, 4338))
        stamps = self.stamps(rate, quantum, kept, way=way)
        clock = read_clock(stamps, wave(kept / rate)[None])
        assert clock.places is not None
        # A beat with the stamps that is slower than the record leaves one row open.
        assert abs(clock.places[-1] - 8999) <= 1
        # The rows that share a stamp with the gap may stand on either side of it.
        assert np.sum(np.abs(clock.places - kept) > 1) <= 2 * quantum * rate

    @pytest.mark.parametrize(("rate", "quantum"), [(101.3, 1e-2), (433.1, 1e-3), (887.14, 1e-3)])
    @pytest.mark.parametrize("seed", range(3))
    def test_jitter_beyond_the_rounding_makes_no_gaps(self, rate: float, quantum: float, seed: int) -> None:
        rng = np.random.default_rng(seed)
        kept = np.delete(np.arange(6000), range(2000, 2020))
        stamps = self.stamps(rate, quantum, kept + 0.05 * rng.standard_normal(kept.size), way="floor")
        clock = read_clock(stamps, wave(kept / rate, rng)[None])
        assert clock.places is not None
        assert clock.places.tolist() == kept.tolist()

    def test_stamps_that_repeat_and_run_backwards_by_jitter_are_late(self) -> None:
        rng = np.random.default_rng(1)
        stamps = self.stamps(2000.3, 1e-3, np.arange(9000) + 0.3 * rng.standard_normal(9000), way="floor")
        assert np.any(np.diff(stamps) < 0)
        clock = read_clock(stamps, wave(np.arange(9000) / 2000.3)[None])
        assert kinds(clock) == ["jittering stamps"]
        assert clock.places is not None
        assert clock.places.tolist() == list(range(9000))

    @pytest.mark.parametrize("seed", range(3))
    def test_rows_that_arrive_in_packets_are_regular(self, seed: int) -> None:
        # A serial port is read every 62 ms or a little later; its rows get the time of reading.
        rng = np.random.default_rng(seed)
        read = 1103.4 + np.cumsum(0.062 + 0.04 * (rng.random(700) < 0.1) + 0.002 * rng.standard_normal(700))
        taken = 1103.4 + np.arange(11_000) / 259.7
        stamps = np.round(read[np.searchsorted(read, taken)], 3)
        clock = read_clock(stamps, wave((taken - 1103.4) / 10)[None])
        assert kinds(clock) == ["packets"]
        std = clock.findings[0].remark.numbers["rate_std"]
        assert isinstance(std, float)
        assert abs(1 / clock.step - 259.7) < 4 * std < 0.2
        assert clock.timepts.size == 11_000

    def test_packets_with_a_pause_between_them_are_refused(self) -> None:
        # The motion goes on while no rows are taken.
        read = np.cumsum(0.062 + 0.004 * np.random.default_rng(0).standard_normal(1000))
        taken = np.arange(11_000) / 259.7
        taken[6000:] += 9.0
        stamps = np.round(read[np.searchsorted(read, taken)], 3)
        with pytest.raises(RecordError, match="time stamps repeat the one before"):
            read_clock(stamps, wave(taken / 10)[None])

    @pytest.mark.parametrize(("rate", "quantum"), GRIDS)
    def test_a_doubled_row_is_dropped(self, rate: float, quantum: float) -> None:
        rows = np.insert(np.arange(3000), [700, 2100], [700, 2100])
        values = wave(np.arange(3000) / rate, np.random.default_rng(0))[rows]
        clock = read_clock(self.stamps(rate, quantum, rows.astype(float), way="round"), values[None])
        assert "repeated rows" in kinds(clock)
        assert clock.places is not None
        assert clock.places.tolist() == list(range(3000))

    def test_beats_of_a_slow_clock_are_no_missing_rows_but_single_holes_are(self) -> None:
        # 999.9 Hz in stamps of 1 ms: one step of 2 ms in ten seconds, evenly spaced.
        rows = np.arange(60_000.0)
        slow = read_clock(self.stamps(999.9, 1e-3, rows, way="floor"), wave(rows / 1e3)[None])
        assert kinds(slow) == ["rounded stamps"]
        assert 1 / slow.step == pytest.approx(999.9, rel=2e-5)
        kept = np.delete(np.arange(9000.0), [1000, 5000])
        lost = read_clock(self.stamps(1000.0, 1e-3, kept, way="floor"), wave(kept / 1e3)[None])
        assert kinds(lost) == ["missing rows"]

    def test_a_few_rows_missing_at_random_make_no_slower_clock(self) -> None:
        for seed in range(20):
            rows = np.sort(np.random.default_rng(seed).choice(400, 395, replace=False))
            grid = grid_of(np.round((rows - rows[0]) / 1000, 3))
            assert grid is not None
            np.testing.assert_array_equal(grid.places, rows - rows[0])

    @pytest.mark.parametrize("every", [5, 10, 20, 50, 100, 200])
    @pytest.mark.parametrize("rate", [100.0, 200.0, 1000.0])
    @pytest.mark.parametrize("way", ["missing", "without a stamp", "rounded"])
    def test_rows_missing_at_regular_intervals_are_told_from_a_slower_clock(
        self, every: int, rate: float, way: str
    ) -> None:
        # Both give the same stamps: every Nth row missing, or a clock slower by 1 - 1/N and rounded.
        kept = np.flatnonzero(np.arange(1000) % every != every // 2)
        stamps = np.round(kept / rate, 6)
        rng = np.random.default_rng(every)
        if way == "rounded":
            taken = kept[0] / rate + np.arange(kept.size) * every / (every - 1) / rate
            clock = read_clock(stamps, wave(taken, rng)[None])
            if "ambiguous stamps" not in kinds(clock):
                assert kinds(clock)[0] in ("rounded stamps", "jittering stamps")
                assert 1 / clock.step == pytest.approx(rate * (1 - 1 / every), rel=1e-3)
            return
        # More than a tenth of the rows without a stamp is refused.
        if way == "without a stamp" and every > 5:
            stamps = np.full(1000, np.nan)
            stamps[kept] = np.round(kept / rate, 6)
            kept_rows, values = kept, wave(np.arange(1000) / rate, rng)
        else:
            kept_rows, values = np.arange(kept.size), wave(kept / rate, rng)
        clock = read_clock(stamps, values[None])
        if "ambiguous stamps" in kinds(clock) and way == "missing" and rate in (100.0, 1000.0):
            return
        assert clock.places is not None
        assert clock.rows.tolist() == kept_rows.tolist()
        assert clock.places.tolist() == (kept - kept[0]).tolist()
        assert 1 / clock.step == pytest.approx(rate, rel=1e-6)

    def test_where_the_samples_cannot_tell_a_slower_clock_from_missing_rows_it_is_a_doubt(self) -> None:
        kept = np.flatnonzero(np.arange(1000) % 20 != 3)
        clock = read_clock(kept / 200, np.random.default_rng(0).standard_normal((1, kept.size)))
        assert Defect.AMBIGUOUS_STAMPS in [finding.kind for finding in clock.findings if not finding.repaired]

    @pytest.mark.parametrize(("rate", "quantum"), GRIDS)
    def test_the_list_of_channels_states_the_same_rate(self, rate: float, quantum: float) -> None:
        kept = np.delete(np.arange(4000.0), range(1000, 1003))
        stamps = self.stamps(rate, quantum, kept, way="round")
        raw = RawChannel(name="seat", unit="m", timepts=stamps, values=wave(kept / rate), rate=None)
        assert raw.mean_rate == pytest.approx(1 / read_clock(stamps, raw.values[None]).step, rel=1e-9)
        assert raw.gaps == 1


class TestARateThatOverrides:
    @pytest.mark.parametrize("lost", [[300, 301, 600], [*range(400, 500)], [*range(3, 1000, 20)]])
    def test_stamps_that_agree_still_tell_of_missing_rows(self, lost: list[int]) -> None:
        kept = np.delete(np.arange(1000), lost)
        clock = read_clock(kept / 200, wave(kept / 200)[None], rate=200.0, override=True)
        assert clock.places is not None
        assert clock.places.tolist() == kept.tolist()

    @pytest.mark.parametrize("rate", [330.0, 100.0, 666.0])
    def test_it_replaces_others_and_says_how_far_they_are_apart(self, rate: float) -> None:
        stamps = 5.0 + np.arange(1000) / 333
        clock = read_clock(stamps, wave(stamps)[None], rate=rate, override=True)
        assert clock.timepts.tolist() == (5.0 + np.arange(1000) / rate).tolist()
        (finding,) = clock.findings
        assert finding.kind is Defect.OVERRIDDEN_STAMPS
        assert finding.remark.numbers["stamps_rate"] == pytest.approx(333)
        assert finding.remark.numbers["apart"] == pytest.approx(999 / 333 - 999 / rate)

    def test_stamps_without_sense_do_not_matter(self) -> None:
        stamps = np.full(500, np.nan)
        clock = read_clock(stamps, wave(np.arange(500) / 50)[None], rate=50.0, override=True)
        assert clock.timepts.tolist() == (np.arange(500) / 50).tolist()
        assert "states none" in clock.findings[0].text


class TestShareFollowed:
    """The share by which samples follow their stamps is the true one, with the spread that is stated."""

    def test_share_and_its_spread(self) -> None:
        rng = np.random.default_rng(0)
        shares, stds = [], []
        for _ in range(200):
            off = rng.uniform(-0.3, 0.3, 600)
            times = (np.arange(600) + 0.5 * off) / 100
            values = np.sin(2 * np.pi * 4 * times) + 0.005 * rng.standard_normal(600)
            share, std = share_followed(values[None], off, np.arange(600))
            shares.append(share)
            stds.append(std)
        # The slope is taken from uniform samples, which leaves a few hundredths of offsets of 0.3 steps.
        assert np.mean(shares) == pytest.approx(0.5, abs=0.03)
        # Neighbouring misses share samples. Taken as independent, they give a std that is too small by sqrt(2).
        assert np.mean(stds) / np.std(shares) == pytest.approx(1.0, abs=0.2)


class TestTheRateStated:
    @pytest.mark.parametrize(("ppm", "one"), [(-90, True), (90, True), (-130, False), (130, False)])
    def test_two_crystals_may_differ_by_a_hundred_millionths(self, ppm: float, one: bool) -> None:
        # A thousand rows at 100 ppm end a tenth of a step off, ten times the jitter that is allowed besides.
        stamps = np.arange(1000) / (333 * (1 + 1e-6 * ppm))
        if one:
            clock = read_clock(stamps, wave(stamps)[None], rate=333.0)
            assert clock.timepts.tolist() == (np.arange(1000) / 333).tolist()
        else:
            with pytest.raises(RecordError, match="disagree"):
                read_clock(stamps, wave(stamps)[None], rate=333.0)

    def test_its_grid_stands_in_for_stamps_that_agree(self) -> None:
        stamps = np.round(np.arange(1000) / 333, 3)
        clock = read_clock(stamps, wave(stamps)[None], rate=333.0)
        assert clock.timepts.tolist() == (np.arange(1000) / 333).tolist()

    @pytest.mark.parametrize("rate", [330.0, 100.0, 666.0])
    def test_stamps_that_disagree_are_refused(self, rate: float) -> None:
        stamps = np.arange(1000) / 333
        with pytest.raises(RecordError, match=r"disagree: the stamps run at 33[23]"):
            read_clock(stamps, wave(stamps)[None], rate=rate)

    def test_rows_are_missing_from_it(self) -> None:
        kept = np.delete(np.arange(1000), [300, 301, 600])
        clock = read_clock(np.round(kept / 333, 3), wave(kept / 333)[None], rate=333.0)
        assert clock.places is not None
        assert clock.places.tolist() == kept.tolist()
        assert 1 / clock.step == pytest.approx(333, rel=1e-12)


class TestAnyStamps:
    def test_a_clock_or_an_error_and_no_warning(self) -> None:
        odd = [0.0, 1.0, 2.0, 0.5, 1e39, -1e39, np.nan, np.inf, 1e15, -1e14, 1e-320]
        for seed in range(300):
            rng = np.random.default_rng(seed)
            size = int(rng.integers(2, 30))
            stamps = (
                np.cumsum(10.0 ** rng.uniform(-13, 15, size)),
                np.sort(10.0 ** rng.uniform(-13, 15, size)),
                np.cumsum(rng.choice([1e-12, 1e-11, 1.0, 1e12, 1e-300, 1e14], size)),
                rng.choice(odd, size),
            )[seed % 4]
            rate = (None, 1.0, 1e12, 1e-12, 1e300, 1e-300)[seed % 6]
            with contextlib.suppress(RecordError):
                clock = read_clock(stamps, rng.standard_normal((2, size)), rate=rate)
                assert np.all(np.diff(clock.timepts) > 0)


class TestLines:
    """The stretch that one line explains is the longest that a linear program finds feasible."""

    @pytest.mark.parametrize(("quantum", "jitter"), [(1e-3, 0.0), (1e-3, 0.2), (5e-3, 0.0)])
    def test_a_stretch_ends_where_no_band_holds_one_more_point(self, quantum: float, jitter: float) -> None:
        from scipy.optimize import linprog

        def feasible(rows: RealArray, times: RealArray, slack: float) -> bool:
            """Whether a line of step s passes all points within a band of 1.01 quanta and jitter s."""
            one, x = np.ones(rows.size), rows - rows[0]
            above = np.column_stack([one, x - 0.5 * jitter])
            below = np.column_stack([-one, -x - 0.5 * jitter])
            half = 0.505 * slack * quantum
            limits = np.concatenate([times - times[0] + half, times[0] - times + half])
            return bool(linprog([0, 0], A_ub=np.vstack([above, below]), b_ub=limits, bounds=[(None, None)] * 2).success)

        rng = np.random.default_rng(0)
        times = np.sort(np.round((np.arange(900) + 0.05 * rng.standard_normal(900)) / 97.3 / quantum) * quantum)
        rows = np.arange(900.0)
        first, after = _longest(rows, times, quantum, jitter)
        assert after - first >= 12
        # The steps that are tried stand a few thousandths of the width apart.
        assert feasible(rows[first:after], times[first:after], 1.001)
        if after < rows.size:
            assert not feasible(rows[first : after + 1], times[first : after + 1], 0.995)


class TestSignificantDigits:
    """Stamps as ``%.3g`` writes them are rounded ten times as much from each power of ten on."""

    @pytest.mark.parametrize("digits", [3, 4])
    @pytest.mark.parametrize("rate", [29.97, 61.3, 100.0])
    def test_the_clock_rounds_to_all_of_them(self, digits: int, rate: float) -> None:
        rows = np.arange(900)
        stamps = np.array([float(f"{row / rate:.{digits}g}") for row in rows])
        grid = grid_of(stamps)
        assert grid is not None
        assert np.array_equal(grid.places, rows)
        # Rounded to w over n rows: no step is further from the truth than w / n.
        assert 1 / grid.step == pytest.approx(rate, abs=rate**2 * 10.0 ** (2 - digits) / 900)

    @pytest.mark.parametrize("way", [ROUND_HALF_UP, ROUND_HALF_DOWN, ROUND_HALF_EVEN])
    @pytest.mark.parametrize(
        ("start", "step", "count"),
        [("-0.025", "25e-6", 2000), ("0", "25e-6", 2000), ("0", "0.004", 3000), ("0.1", "0.005", 3000)],
    )
    def test_ties_go_either_way_and_the_clock_may_begin_before_zero(
        self, way: str, start: str, step: str, count: int
    ) -> None:
        """Every second or fifth time lies half way between two stamps of three digits; oscilloscopes round it up."""
        times = [Decimal(start) + k * Decimal(step) for k in range(count)]
        stamps = np.array([float(t and t.quantize(Decimal(1).scaleb(t.adjusted() - 2), way)) for t in times])
        grid = grid_of(stamps)
        assert grid is not None
        assert np.array_equal(grid.places, np.arange(count))
        # No stamp is further from its time than half of the coarsest resolution.
        assert grid.start + grid.step * (count - 1) == pytest.approx(float(times[-1]), abs=grid.resolution / 2 + 1e-12)

    def test_few_stamps_with_more_decimals_are_no_missing_rows(self) -> None:
        """Capstone writes 8,000E-4 and then 0,001, five times, at 5 kHz."""
        rows = np.arange(6000)
        grid = grid_of(np.where(rows < 5, rows / 5000, np.round(rows / 5000 + 1e-9, 3)))
        assert grid is not None
        assert np.array_equal(grid.places, rows)

    @pytest.mark.parametrize("at", [30, 400, 2500])
    def test_a_row_that_is_missing_shows_where_every_row_has_its_stamp(self, at: int) -> None:
        """Milliseconds of four digits and milliseconds are the same from 1 s on: there is one clock for both."""
        rows = np.delete(np.arange(4000), at)
        grid = grid_of(np.round(rows / 1000, 3))
        assert grid is not None
        assert np.array_equal(grid.places, rows)

    def test_the_bound_of_the_excess_is_below_that_of_the_nearest_line(self) -> None:
        rng = np.random.default_rng(2)
        for size in (0.0, 0.3, 3.0):
            stamps = np.array([float(f"{x:.3g}") for x in np.arange(900) / 30 + size * rng.standard_normal(900)])
            wide = 10.0 ** (np.floor(np.log10(np.maximum(np.abs(stamps), 1e-9))) - 2)
            assert least_excess(stamps, wide) <= line_within(stamps, wide)[3] + 1e-9
        assert least_excess(stamps, wide) > 1.0
