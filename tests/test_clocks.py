"""Clocks: stamps spoiled in a known way lead back to the clock they came from."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

from suspid.cleaning.clocks import Clock, read_clock
from suspid.errors import RecordError
from suspid.stamps import grid_of, resolution
from suspid.units import RealArray


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
        with pytest.raises(RecordError, match="twice|irregular"):
            read_clock(np.repeat(np.cumsum(np.random.default_rng(1).exponential(size=500)), 2), wave(stamps)[None])


class TestJitter:
    """The same stamps: wrong if the samples are regular, right if the samples were taken then."""

    @pytest.mark.parametrize("seed", range(10))
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
        assert "too noisy to tell" in clock.findings[0].text

    @pytest.mark.parametrize("seed", range(10))
    def test_rows_missing_among_jittering_stamps_are_counted(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        kept = np.delete(np.arange(3000), [50, 51, 1000, 2222])
        stamps = np.round(kept / 100 + rng.normal(0, 1.3e-3, kept.size), 3)
        clock = read_clock(stamps, wave(kept / 100, rng)[None])
        assert kinds(clock) == ["jittering stamps", "missing rows"]
        assert clock.places is not None
        assert clock.places.tolist() == kept.tolist()

    def test_event_driven_stamps_are_refused(self) -> None:
        stamps = np.cumsum(np.random.default_rng(2).exponential(0.01, 2000))
        with pytest.raises(RecordError, match="too irregular"):
            read_clock(stamps, wave(stamps)[None])


class TestTheRateStated:
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
