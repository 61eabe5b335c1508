"""Cleaning: what is clean stays as it is, what is spoiled in a known way comes back, and all of it is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import Suspension, add_noise, find_decays, free_decay, identify
from suspid.cleaning.clean import clean
from suspid.cleaning.cleaned import Cleaned
from suspid.cleaning.gaps import fill
from suspid.cleaning.inspection import inspect
from suspid.cleaning.placing import faithful_below, interpolate
from suspid.errors import RecordError
from suspid.model import ModalSet
from suspid.recordings import RawChannel, Recording
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Defect, Level
from validation.cars import HATCHBACK, PAPER, SALOON, VAN, random_car

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


def channel(name: str, times: RealArray, values: RealArray, *, unit: str = "m") -> RawChannel:
    return RawChannel(name=name, unit=unit, timepts=times, values=values, rate=None)


def recording(times: RealArray, *rows: RealArray) -> Recording:
    return Recording(title="bump", channels=tuple(channel(f"c{k}", times, row) for k, row in enumerate(rows)))


def kinds(cleaned: Cleaned) -> list[str]:
    return [str(finding.kind) for finding in cleaned.findings]


def decay(times: RealArray, *, frequency: float = 3.0, noise: float = 0.0, seed: int = 0) -> RealArray:
    rough = noise * np.random.default_rng(seed).standard_normal(times.size)
    return np.asarray(np.exp(-0.4 * times) * np.cos(2 * np.pi * frequency * times) + rough)


T = np.arange(2000) / 200


class TestNoFalseAlarm:
    def test_decays_as_converters_write_them(self) -> None:
        rng, alarms = np.random.default_rng(7), []
        for k in range(200):
            car: Suspension = [PAPER, HATCHBACK, SALOON, VAN, random_car(rng)][k % 5]
            rate = float(rng.choice([100, 125, 200, 256, 500, 1000, 2000]))
            times = np.arange(0, rng.choice([2, 5, 10]), 1 / rate)
            states: list[dict[str, float]] = [
                {"v_tire": 1.0},
                {"z_chassis": 0.02},
                {"v_chassis": 0.3},
                {"v_seat": -1.0},
            ]
            record = free_decay(car, times, initial_state=states[rng.integers(4)])
            if rng.random() < 0.6:
                record = add_noise(record, snr_db=float(rng.choice([10, 20, 40, 60])), rng=rng)
            values = np.array(record.y)
            values = np.concatenate([np.zeros((len(values), int(rng.choice([0, 0, 20, int(rate)])))), values], axis=1)
            full = np.max(np.abs(values), axis=1, keepdims=True) * rng.uniform(1.05, 4)
            step = full / 2 ** (int(rng.choice([12, 16, 24])) - 1)
            values = np.round(values / step) * step
            stamps = np.arange(values.shape[1]) / rate
            cleaned = clean(recording(stamps, *values))
            alarms += [f"{k}: {finding}" for finding in cleaned.findings]
            assert np.asarray(cleaned.record.y).tobytes() == values.tobytes()
            assert np.asarray(cleaned.record.time).tobytes() == stamps.tobytes()
        assert not alarms

    @pytest.mark.parametrize(
        "values",
        [
            np.where(T > 4, 1.0, 0.0),  # a trigger
            np.floor(T),  # a counter
            np.exp(-20 * T) * np.cos(60 * T) * np.where(T > 0, 1, 30),  # a blow in the first sample
            np.round(decay(T) * 50) / 50,  # coarse steps
        ],
    )
    def test_what_is_odd_but_true_stays(self, values: RealArray) -> None:
        cleaned = clean(recording(T, values, decay(T)))
        assert "sentinel" not in kinds(cleaned)
        assert "dropout" not in kinds(cleaned)
        assert "clipped" not in kinds(cleaned)
        assert cleaned.record.y.tobytes() == np.array([values, decay(T)]).tobytes()


class TestImpossibleSamples:
    @pytest.mark.parametrize("value", [-64.0, -9999.0, 1e30, np.inf, -np.inf, 32767.0, -32768.0, 9999.0])
    @pytest.mark.parametrize("places", [(700,), (300, 900, 1400)])
    def test_are_found_and_bridged(self, value: float, places: tuple[int, ...]) -> None:
        clean_values = decay(T, noise=1e-3)
        values = clean_values.copy()
        values[list(places)] = value
        cleaned = clean(recording(T, values))
        assert kinds(cleaned) == ["sentinel", "missing"]
        assert [finding.samples for finding in cleaned.findings] == [len(places)] * 2
        assert all(finding.repaired for finding in cleaned.findings)
        others = np.delete(np.arange(T.size), places)
        assert cleaned.record.y[0, others].tobytes() == clean_values[others].tobytes()
        # A cubic over a gap of 10 ms in 3 Hz errs by noise: five of its standard deviations.
        assert np.max(np.abs(cleaned.record.y[0] - clean_values)) < 5 * 1.4e-3

    def test_the_wraps_of_a_counter_in_a_speed_that_is_computed_from_it(self) -> None:
        angle = 3.0 * np.sin(2 * np.pi * 0.7 * T) * np.exp(-0.05 * T)
        wrapped = (angle + 1.0) % 2.0 - 1.0
        speed, true = np.diff(1e4 * wrapped) + 0.01, np.diff(1e4 * angle) + 0.01
        wraps = np.flatnonzero(np.abs(np.diff(wrapped)) > 1)
        # The unit of the encoder makes each wrap a thousand times what it turns by in a sample.
        speed[wraps] *= 100
        cleaned = clean(recording(T[1:], speed))
        assert kinds(cleaned) == ["spikes", "missing"]
        assert [finding.samples for finding in cleaned.findings] == [len(wraps)] * 2
        np.testing.assert_allclose(cleaned.record.y[0], true, atol=1e-3 * np.max(np.abs(true)))

    @pytest.mark.parametrize("length", [1, 2, 3])
    @pytest.mark.parametrize("first", [100, 900])
    def test_a_fault_of_some_samples_does_not_begin_a_decay(self, first: int, length: int) -> None:
        """Motion that goes on as before was not caused by it; the release stays where it was."""
        times = np.arange(0, 12, 0.005)
        since = np.maximum(times - 3.0, 0.0)
        values = np.exp(-0.8 * since) * np.sin(3 * np.pi * since)
        values += 2e-3 * np.random.default_rng(1).standard_normal(times.size)
        true = values.copy()
        values[first : first + length] = 25.0
        cleaned = clean(recording(times, values))
        assert kinds(cleaned) == ["sentinel", "missing"]
        np.testing.assert_allclose(cleaned.record.y[0], true, atol=0.02)
        assert [round(one.start, 1) for one in find_decays(cleaned.record)] == [3.0]

    def test_a_blow_beyond_the_range_is_no_fault(self) -> None:
        """Two samples at the rail, and then what it excited."""
        values = 1e-3 * np.random.default_rng(1).standard_normal(T.size)
        values[900:] += np.exp(-2 * (T[900:] - T[900])) * np.sin(20 * (T[900:] - T[900]))
        values[900:902] = 25.0
        assert Defect.SENTINEL not in {finding.kind for finding in inspect("body", T, values).findings}

    def test_a_blow_that_rings_is_no_spike(self) -> None:
        values = 1e-3 * np.random.default_rng(1).standard_normal(T.size)
        for first in (300, 800, 1300, 1700):
            values[first : first + 100] += 50 * (-0.6) ** np.arange(100)
        assert Defect.SPIKES not in {finding.kind for finding in inspect("body", T, values).findings}

    @pytest.mark.parametrize("sign", [1, -1])
    def test_the_peak_of_a_blow_is_no_sentinel(self, sign: int) -> None:
        values = 1e-3 * np.random.default_rng(2).standard_normal(T.size)
        values[398:403] = [-0.8, 1.6, 10.9, 0.8, -0.5]
        assert Defect.SENTINEL not in {finding.kind for finding in inspect("force", T, sign * values).findings}

    def test_zeros_in_a_signal_that_stays_far_from_zero(self) -> None:
        values = 9.81 + 0.1 * decay(T, noise=1e-2)
        values[800:803] = 0.0
        cleaned = clean(recording(T, values))
        assert "sentinel" in kinds(cleaned) or "dropout" in kinds(cleaned)
        assert np.min(cleaned.record.y) > 9.6

    @pytest.mark.parametrize(("share", "found"), [(0.45, True), (0.55, False)])
    def test_a_mark_in_more_than_half_of_the_samples_is_a_value(self, share: float, found: bool) -> None:
        values = decay(T, noise=1e-3)
        values[: int(share * T.size)] = -9999.0
        findings = inspect("seat", T, np.random.default_rng(0).permutation(values)).findings
        assert [(f.kind, f.samples) for f in findings if f.kind is Defect.SENTINEL] == (
            [(Defect.SENTINEL, int(share * T.size))] if found else []
        )

    @pytest.mark.parametrize(
        ("beyond", "mark", "found"), [(2.9, False, False), (3.1, False, True), (0.2, True, False), (0.3, True, True)]
    )
    def test_a_lone_value_is_far_from_three_ranges_on_and_a_mark_from_a_quarter(
        self, beyond: float, mark: bool, found: bool
    ) -> None:
        values = np.sin(2 * np.pi * 3 * T + 0.1)
        span = float(np.ptp(values))
        far = float(np.max(values)) + beyond * span
        scale = 9999.0 / far if mark else 1.0
        values = scale * values
        values[700] = 9999.0 if mark else far
        kinds_found = [f.kind for f in inspect("seat", T, values).findings]
        assert (Defect.SENTINEL in kinds_found) is found


def lagrange_at(knots: RealArray, at: RealArray) -> RealArray:
    """Return the weights (at, knot) of the polynomial through the knots, by solving for its coefficients."""
    powers = np.arange(knots.size)
    return np.asarray(np.linalg.solve((knots[:, None] ** powers).T, (at[:, None] ** powers).T).T)


class TestGaps:
    @pytest.mark.parametrize("length", [1, 2, 3, 5])
    def test_the_error_stated_is_that_made(self, length: int) -> None:
        true = decay(T, noise=0.01, seed=4)
        values = true.copy()
        for first in range(100, 1900, 60):
            values[first : first + length] = np.nan
        cleaned = clean(recording(T, values))
        made = np.sqrt(np.mean((cleaned.record.y[0] - true)[np.isnan(values)] ** 2))
        stated = float(str(cleaned.findings[0].remark.numbers["error"]))
        # 30 gaps: the rms of 30 normal numbers lies within 0.6 to 1.5 of the truth.
        assert 0.6 < made / stated < 1.5

    def test_a_sinusoid_bears_a_sixth_of_its_period_but_not_a_half(self) -> None:
        values = np.sin(2 * np.pi * 5 * T)  # 40 samples a period
        values[500:506] = np.nan
        cleaned = clean(recording(T, values))
        assert kinds(cleaned) == ["missing"]
        values[500:520] = np.nan
        with pytest.raises(RecordError, match="too long to fill"):
            clean(recording(T, values))

    @pytest.mark.parametrize("period", [100, 1000])
    def test_a_sinusoid_bears_a_third_of_its_period_however_many_samples(self, period: int) -> None:
        for share, filled in ((0.3, True), (0.4, False)):
            times = np.arange(40 * period) / 200
            values = np.sin(2 * np.pi * np.arange(times.size) / period)
            values[20 * period : 20 * period + int(share * period)] = np.nan
            assert bool(fill("seat", times, values).findings) is filled

    @pytest.mark.parametrize("period", [15.0, 25.0, 40.0])
    def test_a_gap_is_filled_up_to_five_percent_and_half_again_the_error_of_one_sample(self, period: float) -> None:
        def error(length: int) -> float:
            """Rms error, over all phases, of the better of cubic and line across a gap in a sinusoid of rms 1."""
            turn = np.exp(2j * np.pi * np.arange(-1, length + 3) / period)
            inside = np.arange(1.0, length + 1)
            errors = []
            for knots in ([-1, 0, length + 1, length + 2], [0, length + 1]):
                fit = lagrange_at(np.array(knots, float), inside) @ turn[np.array(knots) + 1]
                errors.append(np.sqrt(np.mean(np.abs(fit - turn[2 : length + 2]) ** 2)))
            return float(min(errors))

        longest = max(length for length in range(2, 21) if error(length) <= 0.05 + 1.5 * error(1))
        for length, filled in ((longest, True), (longest + 1, False)):
            times = np.arange(4000) / 200
            values = np.sin(2 * np.pi * np.arange(4000) / period)
            values[2000 : 2000 + length] = np.nan
            assert bool(fill("seat", times, values).findings) is filled

    def test_a_slow_motion_bears_a_long_gap_and_the_error_stated_is_about_that_made(self) -> None:
        times = np.arange(10_000) / 100
        rng = np.random.default_rng(3)
        true = np.exp(-times / 60) * np.sin(2 * np.pi * 0.4 * times) + 5e-3 * rng.standard_normal(times.size)
        values = true.copy()
        values[3000:3070] = np.nan  # 28 % of the period of 250 samples
        for first in range(40, 9900, 100):
            values[first : first + 3] = np.nan
        filled = fill("swing", times, values)
        (finding,) = filled.findings
        assert (finding.kind, finding.remark.numbers["longest"]) == (Defect.MISSING, 70)
        made = float(np.sqrt(np.mean((filled.values - true)[np.isnan(values)] ** 2)))
        assert 0.4 < made / float(str(finding.remark.numbers["error"])) < 1.5
        values[3000:3125] = np.nan
        assert int(np.sum(np.isnan(fill("swing", times, values).values))) == 125

    def test_long_ones_in_noise_and_in_fast_motion_are_not_filled(self) -> None:
        times = np.arange(4000) / 100
        slow, rng = np.sin(2 * np.pi * 0.4 * times), np.random.default_rng(5)
        for other in (0.3 * np.sin(2 * np.pi * 9 * times), 0.3 * rng.standard_normal(times.size)):
            values = slow + other
            values[2000:2040] = np.nan
            assert not fill("swing", times, values).findings

    def test_a_gap_after_rest_is_judged_by_the_motion_behind_it(self) -> None:
        times = np.arange(4000) / 100
        values = np.where(times < 20, 0.0, np.sin(2 * np.pi * 2 * times))
        values[1960:2000] = np.nan
        assert not fill("swing", times, values).findings

    def test_the_stretch_to_take_is_that_between_the_gaps_of_most(self) -> None:
        channels = [decay(T, frequency=f) for f in (3, 4, 5, 6)]
        for values in channels:
            values[500:600] = np.nan
        channels[2][1000:1100] = np.nan
        with pytest.raises(RecordError, match=r"start=3 and stop=9\.995"):
            clean(recording(T, *channels))
        cleaned = clean(recording(T, *channels), start=3, stop=9.995)
        assert [(f.kind, f.channel) for f in cleaned.findings] == [(Defect.GAPPY_CHANNEL, "c2")]

    @pytest.mark.parametrize(("after", "kept"), [(380, True), (420, False)])
    def test_four_fifths_behind_a_long_one_are_taken(self, after: int, kept: bool) -> None:
        values = decay(T)
        values[after - 100 : after] = np.nan
        if not kept:
            with pytest.raises(RecordError, match="too long to fill"):
                clean(recording(T, values))
            return
        cleaned = clean(recording(T, values))
        assert (kinds(cleaned), cleaned.record.time[0]) == (["cut"], T[after])

    def test_long_ones_at_the_ends_are_cut_off(self) -> None:
        values, other = decay(T), decay(T, frequency=5)
        values[:150], other[1900:] = np.nan, np.nan
        cleaned = clean(recording(T, values, other))
        assert kinds(cleaned) == ["cut"]
        assert cleaned.record.time.tolist() == T[150:1900].tolist()
        assert cleaned.record.y[0].tolist() == decay(T)[150:1900].tolist()

    def test_a_long_one_within_is_refused_with_the_stretch_to_take(self) -> None:
        values = decay(T)
        values[600:700] = np.nan
        with pytest.raises(RecordError, match=r"start=3.5 and stop=9.995"):
            clean(recording(T, values))
        assert not clean(recording(T, values), start=3.5, stop=9.995).findings

    def test_a_channel_with_a_long_one_is_left_out_beside_one_without(self) -> None:
        true, other = decay(T, frequency=5), decay(T)
        other[1500:1600] = np.nan
        cleaned = clean(recording(T, true, other))
        assert [(f.kind, f.channel, f.samples) for f in cleaned.findings] == [(Defect.GAPPY_CHANNEL, "c1", 100)]
        assert cleaned.record.y.tolist() == [true.tolist()]
        with pytest.raises(RecordError, match="too long to fill"):
            clean(recording(T, true, other), channels=["c0", "c1"])

    def test_a_channel_is_left_out_beside_one_without_before_more_than_a_tenth_is_cut(self) -> None:
        true, other = decay(T, frequency=5), decay(T)
        other[200:300] = np.nan
        cleaned = clean(recording(T, true, other))
        assert [(f.kind, f.channel) for f in cleaned.findings] == [(Defect.GAPPY_CHANNEL, "c1")]

    def test_a_channel_with_more_short_ones_than_are_filled_is_left_out_beside_one_without(self) -> None:
        true, other = decay(T, frequency=5), decay(T)
        other[3:1997:4] = np.nan
        (finding,) = clean(recording(T, true, other)).findings
        assert (finding.kind, finding.channel, finding.samples) == (Defect.GAPPY_CHANNEL, "c1", 499)
        assert finding.text.startswith(f"499 of {T.size} samples missing, 25 %, of which at most 10 % are filled")

    def test_a_long_one_in_most_channels_is_refused(self) -> None:
        gappy = [decay(T, frequency=f) for f in (3, 4)]
        for k, values in enumerate(gappy):
            values[600 + 300 * k : 700 + 300 * k] = np.nan
        with pytest.raises(RecordError, match="too long to fill"):
            clean(recording(T, decay(T), *gappy))

    def test_a_channel_that_stops_before_the_middle_is_left_out(self) -> None:
        stopped = decay(T, frequency=5)
        stopped[1100:] = np.nan
        assert kinds(clean(recording(T, decay(T), stopped))) == ["cut"]
        stopped[980:] = np.nan
        cleaned = clean(recording(T, decay(T), stopped, decay(T, frequency=4)))
        assert cleaned.record.y.shape == (2, T.size)

    def test_missing_rows_come_back(self) -> None:
        true = decay(T)
        kept = np.sort(np.random.default_rng(0).choice(np.arange(1, 1999), 1980, replace=False))
        cleaned = clean(recording(T[kept], true[kept]))
        assert kinds(cleaned) == ["missing rows", "missing"]
        # 3/128 (w h)^4 of a cubic through four points 10 ms apart: 3e-5; where two rows are lost together, 16 times.
        assert cleaned.record.y[0] == pytest.approx(true[kept[0] : kept[-1] + 1], abs=8e-4)

    def test_a_channel_with_too_many_is_refused(self) -> None:
        values = decay(T)
        values[1:-1:5] = np.nan
        with pytest.raises(RecordError, match="20 % of its samples"):
            clean(recording(T, values))

    def test_samples_that_are_not_believed_are_no_gaps_of_the_file(self) -> None:
        """Every eighth sample is stuck: the file has these samples, and the message says why they are not used."""
        values = decay(T, noise=0.05)
        for start in range(50, 1950, 40):
            values[start : start + 5] = 2.0 + values[start]
        with pytest.raises(
            RecordError,
            match=r"gaps in 1[12] % of its samples; up to 10 % are filled; 2\d\d samples of the file "
            r"are treated as missing, as faults of the sensor: \d+ runs of exactly one value, up to 5 samples long, "
            r"ended by a jump; take a better stretch",
        ):
            clean(recording(T, values))

    def test_of_channels_that_all_have_too_many_none_is_to_be_left_out(self) -> None:
        """As where rows are lost: without one of them the others are refused alike."""
        values = decay(T)
        values[1:-1:5] = np.nan
        with pytest.raises(RecordError, match=r"^every channel has gaps in 20 %.*filled; take a better stretch"):
            clean(recording(T, values, values))


class TestReportedAndLeft:
    def test_clipping(self) -> None:
        cleaned = clean(recording(T, np.clip(decay(T), -0.6, 0.6)))
        assert set(kinds(cleaned)) == {"clipped"}
        assert cleaned.record.y.tobytes() == np.clip(decay(T), -0.6, 0.6).tobytes()
        assert not any(finding.repaired for finding in cleaned.findings)

    def test_what_is_clipped_throughout_is_not_cut(self) -> None:
        """A swing without end has no part that is not clipped; a decay has, behind its first cycles."""
        steady = np.clip(np.sin(2 * np.pi * 3.0 * T + 0.2), -0.9, 0.9)
        for values, said, unsaid in (
            (steady, "larger range", "after"),
            (np.clip(decay(T), -0.6, 0.6), "use it after", "range"),
        ):
            texts = [finding.text for finding in clean(recording(T, values)).findings]
            assert texts
            assert all(said in text and unsaid not in text for text in texts)

    def test_offset(self) -> None:
        cleaned = clean(recording(T, 9.81 + decay(T)))
        assert kinds(cleaned) == ["offset"]
        assert "9.81" in cleaned.findings[0].text

    def test_drift(self) -> None:
        cleaned = clean(recording(T, 0.5 * T + 0.1 * decay(T)))
        assert "drift" in kinds(cleaned)

    @pytest.mark.parametrize(("share", "told"), [(0.55, False), (0.65, True)])
    def test_a_drift_is_told_from_the_share_of_the_energy_on(self, share: float, told: bool) -> None:
        # A ramp of range s has the variance s^2 / 12, an oscillation of amplitude a has a^2 / 2.
        times = np.arange(4000) / 100
        ramp = np.sqrt(12 * share / (1 - share) / 2) * times / times[-1]
        cleaned = clean(recording(times, ramp + np.sin(2 * np.pi * 3.0 * times) - 1.0))
        assert ("drift" in kinds(cleaned)) is told

    @pytest.mark.parametrize(("rate", "slower"), [(99.3, False), (98.0, True)])
    def test_one_part_in_a_hundred_is_another_rate(self, rate: float, slower: bool) -> None:
        fast, slow = np.arange(1000) / 100, np.arange(round(9.98 * rate)) / rate
        channels = (channel("a", fast, decay(fast)), channel("b", slow, decay(slow)))
        cleaned = clean(Recording(title="two clocks", channels=channels))
        assert (Defect.SLOWER_CLOCK in [finding.kind for finding in cleaned.findings]) is slower

    def test_held_samples(self) -> None:
        cleaned = clean(recording(T, np.repeat(decay(T)[::4], 4)))
        assert kinds(cleaned) == ["one of each"]
        assert "in 4 rows" in cleaned.findings[0].text
        # Beside a channel that has all, nothing is done.
        both = clean(recording(T, np.repeat(decay(T)[::4], 4), decay(T, noise=1e-3)))
        assert kinds(both) == ["held samples"]
        assert "4 samples" in both.findings[0].text

    def test_a_frozen_stretch_is_struck_out_if_short(self) -> None:
        values = decay(T, noise=1e-3)
        values[320:328] = values[319]
        cleaned = clean(recording(T, values))
        assert kinds(cleaned)[0] == "dropout"

    def test_the_table_says_all(self) -> None:
        values = 9.81 + decay(T)
        values[700] = -9999.0
        text = str(clean(recording(T, values)))
        for word in ("sentinel", "missing", "offset", "c0", "3.5", "yes", "no"):
            assert word in text
        assert str(clean(recording(T, decay(T)))).startswith("Verdict: no defect found, record unchanged: sound.")


class TestVerdict:
    """Defects left alone call for care, repairs do not; an offset is allowed for by identification."""

    def test_nothing_found(self) -> None:
        assert clean(recording(T, decay(T))).verdict.level is Level.SOUND

    def test_a_repair_is_a_note(self) -> None:
        values = decay(T, noise=1e-3)
        values[700] = -9999.0
        verdict = clean(recording(T, values)).verdict
        assert verdict.level is Level.SOUND
        assert [remark.code for remark in verdict.notes] == [Defect.SENTINEL, Defect.MISSING]

    def test_a_defect_left_alone_is_a_doubt_with_its_place(self) -> None:
        verdict = clean(recording(T, np.clip(decay(T), -0.6, 2.0))).verdict
        assert verdict.level is Level.CARE
        (doubt,) = verdict.doubts
        assert doubt.code is Defect.CLIPPED
        assert str(doubt).startswith("channel 'c0' from 0.1")
        assert dict(verdict.headline.numbers) == {"repaired": 0, "left": 1}

    def test_an_offset_is_a_note(self) -> None:
        assert clean(recording(T, 9.81 + decay(T))).verdict.level is Level.SOUND


class TestDeadChannels:
    @pytest.mark.parametrize("values", [np.zeros(2000), np.full(2000, 4.2), np.full(2000, np.nan)])
    def test_are_left_out_but_refused_by_name(self, values: RealArray) -> None:
        cleaned = clean(recording(T, decay(T), values))
        assert cleaned.record.output_labels == ["c0"]
        assert [(f.kind, f.channel) for f in cleaned.findings] == [(Defect.DEAD_CHANNEL, "c1")]
        with pytest.raises(RecordError, match="'c1' .* leave it out"):
            clean(recording(T, decay(T), values), channels=["c0", "c1"])
        with pytest.raises(RecordError, match="no channel moves"):
            clean(recording(T, values))


class TestSeveralClocks:
    def test_a_slower_one_is_left_out_unless_asked_for(self) -> None:
        slow = np.arange(11.0)
        both = Recording(title="car", channels=(channel("a", T, decay(T)), channel("speed", slow, slow**2)))
        cleaned = clean(both)
        assert cleaned.record.output_labels == ["a"]
        assert kinds(cleaned) == ["slower clock"]
        (finding,) = cleaned.findings
        # One sample a second, beside those of T.
        assert [finding.remark.numbers["rate"], finding.remark.numbers["onto"]] == pytest.approx(
            [1.0, (T.size - 1) / np.ptp(T)]
        )
        assert cleaned.record.y[0].tolist() == decay(T).tolist()
        asked = clean(both, channels=["a", "speed"])
        # A cubic spline is exact for a square.
        assert asked.record.y[1] == pytest.approx(asked.record.time**2, abs=1e-9)
        assert not clean(both, channels=["speed"]).findings

    def test_one_rate_at_another_phase_is_shifted(self) -> None:
        later = T + 0.0017
        cleaned = clean(Recording(title="car", channels=(channel("a", T, decay(T)), channel("b", later, decay(later)))))
        assert "shifted clock" in kinds(cleaned)
        assert "cut" in kinds(cleaned)
        # Away from the edges a cubic spline errs by 5/384 (w h)^4 = 1e-6 of the amplitude.
        assert cleaned.record.y[1, 5:-5] == pytest.approx(cleaned.record.y[0, 5:-5], abs=1e-6)

    def test_no_common_time_is_refused(self) -> None:
        with pytest.raises(RecordError, match="do not overlap in time"):
            clean(Recording(title="x", channels=(channel("a", T, decay(T)), channel("b", T + 50, decay(T)))))


class TestIrregularSampling:
    def test_comes_back_to_within_the_law_of_splines(self) -> None:
        rng = np.random.default_rng(3)
        moved = np.sort(T + rng.uniform(-1.5e-3, 1.5e-3, T.size))
        cleaned = clean(recording(moved, decay(moved)))
        assert kinds(cleaned) == ["irregular stamps"]
        # 5/384 (2 pi 3 Hz 8 ms)^4 = 7e-6, away from the edges.
        assert cleaned.record.y[0, 5:-5] == pytest.approx(decay(cleaned.record.time)[5:-5], abs=1e-5)

    def test_faithful_below_is_where_a_spline_errs_by_one_percent_at_most(self) -> None:
        limit = faithful_below(np.full(100, 0.01))
        knots = np.arange(400) / 100
        fine = np.arange(5000, 35000) / 1e4
        for frequency, factor in ((limit, 1.0), (0.5 * limit, 1 / 16)):
            wave = interpolate(fine, knots, np.sin(2 * np.pi * frequency * knots), widest=1.0)
            assert np.max(np.abs(wave - np.sin(2 * np.pi * frequency * fine))) <= 0.01 * factor


def modes_of(times: RealArray, values: RealArray) -> ModalSet:
    cleaned = clean(recording(times, *values))
    return identify(cleaned.record, modes=3).modes


class TestWhatRepairsCost:
    """Modes of a spoiled and repaired record lie within one standard deviation of those of the unspoiled one."""

    @pytest.mark.parametrize("spoil", ["rounded", "missing rows", "not a number", "sentinels", "late", "irregular"])
    def test_less_than_one_standard_deviation(self, spoil: str) -> None:
        rng = np.random.default_rng(11)
        rate, count = 333.0, 2664
        times = np.arange(count) / rate
        moved = times + rng.uniform(-3e-4, 3e-4, count)
        record = add_noise(free_decay(PAPER, times, initial_state={"v_tire": 1.0}), snr_db=20.0, rng=rng)
        whole, stamps = np.array(record.y), times.copy()
        values = whole.copy()
        holes = np.sort(rng.choice(np.arange(10, count - 10), count // 100, replace=False))
        if spoil == "rounded":
            stamps = np.round(times, 3)
        elif spoil == "missing rows":
            stamps, values = np.delete(np.round(times, 3), holes), np.delete(values, holes, axis=1)
        elif spoil == "not a number":
            values[:, holes] = np.nan
        elif spoil == "sentinels":
            values[1, holes] = -9999.0
        elif spoil == "late":
            stamps = moved
        else:
            exact = free_decay(PAPER, moved - moved[0], initial_state={"v_tire": 1.0})
            values = np.array(exact.y) + (whole - np.array(free_decay(PAPER, times, initial_state={"v_tire": 1.0}).y))
            stamps = moved
        truth = identify(as_response(times, whole, ["c0", "c1", "c2"]), modes=3).modes
        found = modes_of(stamps, values)
        assert found.wn_std is not None
        assert found.zeta_std is not None
        assert np.max(np.abs(found.wn - truth.wn) / found.wn_std) < 1
        assert np.max(np.abs(found.zeta - truth.zeta) / found.zeta_std) < 1


class TestInput:
    def test_unknown_channels_are_named(self) -> None:
        with pytest.raises(RecordError, match="there is no channel 'c7'"):
            clean(recording(T, decay(T)), channels=["c7"])

    @pytest.mark.parametrize("fs", [0.0, -1.0, np.nan, np.inf])
    def test_rates_that_are_none(self, fs: float) -> None:
        with pytest.raises(RecordError, match="fs"):
            clean(recording(T, decay(T)), fs=fs)

    def test_order_and_units_follow_the_request(self) -> None:
        both = Recording(title="x", channels=(channel("a", T, decay(T)), channel("b", T, 2 * decay(T), unit="g")))
        cleaned = clean(both, channels=["b", "a"])
        assert (cleaned.record.output_labels, cleaned.units) == (["b", "a"], ("g", "m"))

    def test_anything_becomes_a_record_or_an_error(self) -> None:
        rng = np.random.default_rng(5)
        for _ in range(300):
            count = int(rng.choice([0, 1, 2, 3, 5, 10, 50, 300]))
            times = rng.choice([0, 1e3, 1.6e9]) + np.arange(count) / 10 ** rng.uniform(-1, 5)
            values = np.sin(np.arange(count) * rng.uniform(0, 3)) + rng.choice([0, 1e-3, 1]) * rng.standard_normal(
                count
            )
            for _ in range(rng.integers(0, 4) if count > 1 else 0):
                k = int(rng.integers(count))
                spoiled = int(rng.integers(8))
                if spoiled == 0:
                    times = np.round(times, int(rng.integers(0, 6)))
                elif spoiled == 1:
                    times = rng.permutation(times)
                elif spoiled == 2:
                    times[k] = rng.choice([np.nan, 0, 1e30, -1e300, np.inf, 5e-324])
                elif spoiled == 3:
                    values[k] = rng.choice([np.nan, np.inf, -9999, 1e30, 1.7e308, -1.7e308])
                elif spoiled == 4:
                    values[k:] = np.nan
                elif spoiled == 5:
                    values = np.where(rng.random(count) < 10 ** rng.uniform(-3, 0), np.nan, values)
                elif spoiled == 6:
                    times = np.concatenate([times[k:], times[:k]])
                else:
                    values = np.clip(values, -0.5, 0.5)
            try:
                cleaned = clean(recording(times, values))
            except RecordError:
                continue
            as_signal(cleaned.record)
            assert str(cleaned)


class TestCarOnTheRoad:
    """The recorded car: sensors at about 101 Hz with jitter, invalid samples of -64, speed at 1 Hz."""

    @pytest.mark.skipif(not (DATA / "css_canedge_car_mf4").is_dir(), reason="the shared data are not here")
    def test_as_an_engineer_would_have_it(self) -> None:
        asammdf = pytest.importorskip("asammdf")
        folder = DATA / "css_canedge_car_mf4"
        with pytest.MonkeyPatch.context():
            import warnings

            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                raw = asammdf.MDF(folder / "00000164_00000001-60FE3F04.MF4")
                decoded = raw.extract_bus_logging(database_files={"CAN": [(folder / "canmod-gps.dbc", 0)]})
                names = ["AccelerationX", "AccelerationY", "AccelerationZ", "Speed"]
                signals = [decoded.get(name) for name in names]
        found = clean(
            Recording(
                title="car",
                channels=tuple(
                    channel(n, s.timestamps, s.samples.astype(float)) for n, s in zip(names, signals, strict=True)
                ),
            )
        )
        assert found.record.output_labels == names[:3]
        assert sorted(set(kinds(found))) == ["irregular stamps", "sentinel", "slower clock"]
        assert [f.samples for f in found.findings if f.kind is Defect.SENTINEL] == [1, 1, 1]
        assert np.median(found.record.y[0]) == pytest.approx(9.6, abs=0.1)
        assert np.min(found.record.y[0]) > 0
        assert 1 / (found.record.time[1] - found.record.time[0]) == pytest.approx(101.3, abs=0.1)
