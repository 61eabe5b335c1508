"""Limits of the cleaning, each by a record on either side of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from suspid import add_noise, quarter_car, road, simulate
from suspid.cleaning.clipping import clipped_run
from suspid.cleaning.faults import on_rail
from suspid.cleaning.inspection import inspect
from suspid.cleaning.ordering import ordered, stamped, unrepeated
from suspid.cleaning.placing import interpolate
from suspid.errors import RecordError
from suspid.stamps import Indices
from suspid.units import RealArray
from suspid.words import Defect
from validation import rigs

K = np.arange(400)
SWING: RealArray = 0.5 * np.sin(0.37 * K) + 0.001 * np.cos(1.9 * K)
NONE: Indices = np.empty(0, np.intp)


class TestClipping:
    @pytest.mark.parametrize(("count", "clipped"), [(2, False), (3, True), (4, True), (40, True)])
    def test_three_samples_at_the_limit_between_jumps_are_clipped(self, count: int, clipped: bool) -> None:
        values = SWING.copy()
        values[200 : 200 + count] = 1.0
        found = (200, count) if clipped else None
        assert clipped_run(values, largest=True) == found
        assert clipped_run(-values, largest=False) == found

    @pytest.mark.parametrize(("share", "clipped"), [(0.45, True), (0.55, False)])
    def test_a_limit_that_is_held_for_most_of_a_record_is_its_rest(self, share: float, clipped: bool) -> None:
        values = np.where(share * 400 > K, 1.0, SWING)
        assert (clipped_run(values, largest=True) is not None) == clipped

    @pytest.mark.parametrize("turn", [0.1, 0.2, 0.4, 0.8])
    def test_a_mass_that_is_held_and_let_go_is_not_clipped(self, turn: float) -> None:
        """It leaves rest with half of the step by which its steps grow; a cosine does."""
        k = np.arange(300)
        values = np.concatenate([np.ones(40), np.exp(-0.01 * turn * k) * np.cos(turn * k)])
        assert clipped_run(values, largest=True) is None

    @pytest.mark.parametrize("limit", [0.3, 0.5])
    def test_a_sensor_that_is_read_too_often_is_clipped_too(self, limit: float) -> None:
        """Every fourth sample is the one before it, so that values repeat: only the limit has runs of them."""
        k = np.arange(900)
        swing = np.exp(-0.004 * k) * np.sin(0.37 * k) + 0.001 * np.cos(1.9 * k)
        values = np.clip(swing, -limit, limit)[k - (k % 4 == 3)]
        assert all(clipped_run(values, largest=largest) is not None for largest in (True, False))
        assert clipped_run(swing[k - (k % 4 == 3)], largest=True) is None

    @pytest.mark.parametrize("start", [0.0, 0.3, 0.6])
    def test_a_slow_crest_in_coarse_steps_with_values_between_two_is_not_clipped(self, start: float) -> None:
        """A sensor of .2 mm that turns back after 9 mm: every third sample is a mean of two, one lies between steps."""
        t = np.arange(2500) / 200 + start
        swing = 9 * np.exp(-0.05 * t) * np.cos(2 * np.pi * 0.6 * t)
        values = np.round(swing / 0.2) * 0.2
        values[::3] = np.round(swing[::3], 1)
        values[1203] += 0.01
        assert all(clipped_run(values, largest=largest) is None for largest in (True, False))
        cut_off = np.minimum(values, 0.6 * np.max(values))
        assert clipped_run(cut_off, largest=True) is not None

    def test_a_release_that_is_not_seen_from_its_first_sample_on_is_none(self) -> None:
        """However the samples lie about a release, a mass at rest leaves with a third of the next step at most."""
        k = np.arange(300)
        for late in np.linspace(0, 0.99, 12):
            moved = np.exp(-0.008 * (k + late)) * np.cos(0.7 * (k + late))
            assert clipped_run(np.concatenate([np.ones(40), moved]), largest=True) is None

    @pytest.mark.parametrize("seed", [50, 2411, 2582])
    def test_a_crest_within_two_steps_is_not_clipped_and_a_flat_one_is(self, seed: int) -> None:
        """Of 3000 videos of pendulums in pixels, three turn so; beside the turn they move by many in a picture."""
        rng = np.random.default_rng(seed)
        rate = float(rng.choice([30.0, 60.0, 100.0]))
        time = np.arange(int(rng.uniform(10, 40) * rate)) / rate
        size, wn, zeta = rng.uniform(300, 900), rng.uniform(3, 8), 10 ** rng.uniform(-2.7, -1.6)
        swing = rng.uniform(0.2, 0.6) * size * np.exp(-zeta * wn * time) * np.cos(wn * time + rng.uniform(0, 6))
        seen = np.round(swing + rng.normal(0, rng.choice([0.1, 0.3, 0.5]), time.size))
        assert clipped_run(seen, largest=True) is clipped_run(seen, largest=False) is None
        assert clipped_run(np.minimum(seen, 0.3 * np.max(seen)), largest=True) is not None

    def test_noise_of_a_few_steps_of_a_converter_is_not_clipped(self) -> None:
        rng = np.random.default_rng(1)
        noise = [np.round(0.6 * rng.standard_normal(3000)) for _ in range(20)]
        assert [clipped_run(values, largest=True) for values in noise] == [None] * 20


class TestOrder:
    STAMPS: RealArray = np.arange(100) / 10.0

    def order(self, stamps: RealArray) -> tuple[RealArray, list[object]]:
        values = np.random.default_rng(1).standard_normal((1, len(stamps)))
        times, _, findings = ordered(stamps, values, np.arange(len(stamps)), NONE)
        return times, [finding.kind for finding in findings]

    def swapped(self, rows: int, moved: int) -> RealArray:
        stamps = np.arange(rows) / 10.0
        for k in range(20, 20 + 5 * moved, 10):
            stamps[[k, k + 1]] = stamps[[k + 1, k]]
        return stamps

    @pytest.mark.parametrize(("lost", "fine"), [(10, True), (11, False)])
    def test_a_tenth_of_the_stamps_may_be_missing(self, lost: int, fine: bool) -> None:
        stamps = self.STAMPS.copy()
        stamps[5 : 5 + lost] = np.nan
        if fine:
            assert len(stamped(stamps)[0]) == 100 - lost
        else:
            with pytest.raises(RecordError, match="are not numbers"):
                stamped(stamps)

    def test_times_since_1970_in_any_unit_are_times(self) -> None:
        for per_second in (1.0, 1e3):
            assert len(stamped(1.7e9 * per_second + self.STAMPS)[0]) == 100

    @pytest.mark.parametrize(("rows", "far", "left_out"), [(100, 2, 2), (100, 3, 0), (12, 1, 1), (11, 1, 0)])
    def test_few_rows_at_the_ends_far_from_all_others_are_left_out(self, rows: int, far: int, left_out: int) -> None:
        stamps = self.STAMPS[:rows].copy()
        stamps[-far:] += 1e6
        assert rows - len(stamped(stamps)[0]) == left_out

    @pytest.mark.parametrize(("back", "defect"), [(8, Defect.SWAPPED_ROWS), (9, Defect.WRONG_STAMPS)])
    def test_a_row_that_comes_up_to_eight_rows_late_is_put_back(self, back: int, defect: Defect) -> None:
        """One that comes later has, as have those before it, a wrong stamp."""
        stamps = np.arange(1000) / 10.0
        stamps[500 : 501 + back] = np.append(stamps[501 : 501 + back], stamps[500])
        times, codes = self.order(stamps)
        assert codes == [defect]
        np.testing.assert_allclose(times, np.arange(1000) / 10.0)

    @pytest.mark.parametrize(("rows", "moved"), [(100, 4), (600, 4), (600, 6)])
    def test_four_rows_or_a_hundredth_of_them_are_put_back(self, rows: int, moved: int) -> None:
        times, codes = self.order(self.swapped(rows, moved))
        assert codes == [Defect.SWAPPED_ROWS]
        np.testing.assert_array_equal(times, np.arange(rows) / 10.0)

    @pytest.mark.parametrize(("rows", "moved"), [(100, 6), (600, 8)])
    def test_more_rows_out_of_order_are_refused(self, rows: int, moved: int) -> None:
        with pytest.raises(RecordError):
            self.order(self.swapped(rows, moved))

    def test_rows_are_not_put_where_they_nearly_double_others(self) -> None:
        """A stamp that lies beside an earlier one is a wrong stamp, not a late row."""
        stamps = self.STAMPS.copy()
        stamps[50] = stamps[45] + 0.01
        times, codes = self.order(stamps)
        assert codes == [Defect.WRONG_STAMPS]
        np.testing.assert_allclose(times, self.STAMPS, atol=1e-9)

    @pytest.mark.parametrize(("wrong", "fine"), [(2, True), (3, False)])
    def test_two_wrong_stamps_of_a_hundred_are_repaired(self, wrong: int, fine: bool) -> None:
        """Another stamp, half a step off, is among them."""
        stamps = self.STAMPS.copy()
        stamps[20] += 0.06
        stamps[50 : 50 + wrong - 1] = 1.03
        if fine:
            times, codes = self.order(stamps)
            assert codes == [Defect.WRONG_STAMPS]
            np.testing.assert_allclose(times, self.STAMPS, atol=0.01)
        else:
            with pytest.raises(RecordError, match="runs backwards"):
                self.order(stamps)

    def test_rows_in_reverse_are_told(self) -> None:
        with pytest.raises(RecordError, match=r"reverse order, from \S+ s down to 0 s; sort the rows by time"):
            self.order(self.STAMPS[::-1].copy())

    @pytest.mark.parametrize(("count", "removed"), [(5, 5), (6, 0)])
    def test_more_repeated_rows_than_asked_for_are_left(self, count: int, removed: int) -> None:
        stamps, values = self.STAMPS.copy(), np.random.default_rng(1).standard_normal((1, 100))
        again = 10 * np.arange(1, count + 1)
        stamps[again], values[:, again] = stamps[again - 1], values[:, again - 1]
        rows, _ = unrepeated(stamps, values, np.arange(100), most=0.05)
        assert 100 - len(rows) == removed


class TestChannels:
    @pytest.mark.parametrize("lost", [False, True])
    def test_spikes_beside_steps_of_the_converter_are_no_dropouts(self, *, lost: bool) -> None:
        # Printed to 1e-6, its steps of 0.0031165 differ in the last digit; a filter adds values between some of them.
        rng, quantum = np.random.default_rng(0), 0.0031165
        times = np.arange(20_000) / 5000
        motion = 0.6 * np.sin(9 * times) + quantum * rng.standard_normal(times.size).repeat(5)[: times.size]
        values = quantum * np.round(motion / quantum)
        spikes = rng.random(times.size) < 0.05
        values[spikes] += 4 * quantum
        between = rng.random(times.size) < 0.05
        values[between] += quantum * rng.random(int(np.sum(between)))
        if lost:
            values[9000:9040] = 0.0
            assert abs(values[8990]) > 50 * quantum
        kinds = [finding.kind for finding in inspect("z", times, np.round(values, 6)).findings]
        assert (Defect.DROPOUT in kinds) == lost

    @pytest.mark.parametrize(("count", "dropout"), [(3, False), (4, True)])
    def test_four_zeros_between_jumps_are_a_dropout(self, count: int, dropout: bool) -> None:
        values = 3.0 * np.sin(0.02 * K) + 0.01 * np.random.default_rng(1).standard_normal(400)
        values[78 : 78 + count] = 0.0
        found = inspect("seat", K / 100.0, values)
        assert (Defect.DROPOUT in [finding.kind for finding in found.findings]) == dropout

    @pytest.mark.parametrize("phase", [0.1, 0.7, 1.3, 2.0, 2.9])
    def test_silence_between_two_knocks_is_no_dropout(self, phase: float) -> None:
        """A sound that is cut off falls to zero at once; the next one begins from zero, where a motion goes on."""
        times = np.arange(2000) / 44100
        knock = np.exp(-20 * times) * np.sin(2 * np.pi * 400 * times)
        cut = int(np.argmax(2 * np.pi * 400 * times > 20 * np.pi + phase))
        silent = np.concatenate([knock[:cut], np.zeros(3000), knock])
        lost = np.concatenate([knock[:cut], np.zeros(3000), np.roll(knock, -28)])
        for values, dropout in ((silent, False), (lost, True)):
            found = inspect("channel 1", np.arange(values.size) / 44100, np.round(values * 2**15) / 2**15)
            assert (Defect.DROPOUT in [finding.kind for finding in found.findings]) == dropout

    def test_a_mass_that_is_pulled_held_and_let_go_is_no_dropout(self) -> None:
        """It leaves the hold by 14 steps and goes on by 47 and 73; a frozen value is left by what it missed."""
        release = rigs.release("friction", 2, seed=970_095)
        values = release.values[0] / release.step
        assert inspect("x1", release.stamps, values).findings == ()
        moved = np.flatnonzero(np.abs(np.diff(values)) > 13)[0] + 1
        frozen = np.concatenate([values[:moved], values[moved + 3 :]])
        found = inspect("x1", release.stamps[3:], frozen).findings
        assert [finding.kind for finding in found] == [Defect.DROPOUT]

    @pytest.mark.parametrize("length", [300, 23])
    def test_the_base_of_pulses_lasts_for_some_samples_by_chance(self, length: int) -> None:
        """Of 2000 samples, seven in ten lie on a base, or on the top of a pulse, and the others anywhere near it."""
        rng = np.random.default_rng(4)
        pulses = np.where(np.arange(2000) // length % 3 == 1, 3.0, 0.0) - 0.008
        values = pulses + np.where(rng.random(2000) < 0.7, 0.0, rng.uniform(-0.07, 0.07, 2000))
        assert inspect("1", np.arange(2000) / 200e3, values).findings == ()

    def test_a_value_that_motion_passes_often_is_no_such_base(self) -> None:
        """It is passed in single samples, 40 times: a run of five is improbable."""
        values = np.round(3.0 * np.sin(0.2 * np.arange(2000)), 3)
        values[7 + 47 * np.arange(40)] = 0.4
        values[912:917] = 0.4
        found = inspect("1", np.arange(2000) / 200, values).findings
        # What is off the motion are spikes.
        assert [(one.kind, one.samples) for one in found if one.kind is not Defect.SPIKES] == [(Defect.DROPOUT, 5)]

    @pytest.mark.parametrize("often", [1, 12])
    def test_a_value_at_which_a_sensor_sticks_is_no_such_base(self, often: int) -> None:
        """The sample behind a stuck value is far from it, since the motion has gone on; now and then it comes back."""
        values = np.round(3.0 * np.sin(0.2 * np.arange(2000)), 3)
        for k in range(often):
            values[150 * k + 50 : 150 * k + 56 + k % 3] = 0.4
        (found,) = inspect("1", np.arange(2000) / 200, values).findings
        assert found.kind is Defect.DROPOUT
        assert 0.7 * often < int(str(found.remark.numbers["runs"])) <= often

    @pytest.mark.parametrize(("value", "kept"), [(2.0, True), (1e31, False), (-1e31, False)])
    def test_what_no_quantity_reaches_is_missing(self, value: float, kept: bool) -> None:
        values = SWING + 0.0
        values[7] = value
        assert np.isfinite(inspect("seat", K / 100.0, values).values[7]) == kept

    @pytest.mark.parametrize(("ahead", "used"), [(0.8, False), (0.6, True)])
    def test_a_sample_beside_another_is_not_used_between_them(self, ahead: float, used: bool) -> None:
        """Its noise would become slope; a stamp that is four tenths of a step behind counts."""
        times, wanted = np.arange(30.0), np.array([15.5])
        plain = interpolate(wanted, times, np.sin(times), widest=3.0)
        more = np.insert(times, 16, 16 - ahead)
        other = interpolate(wanted, more, np.sin(more) + 0.1 * (more % 1 > 0), widest=3.0)
        assert (abs(float(other[0] - plain[0])) > 0.01) == used

    def test_a_limit_stays_one_between_irregular_stamps(self) -> None:
        """The spline through a crest that is cut off runs beyond the limit; the sensor did not."""
        times = np.arange(400.0) + 0.3 * np.sin(np.arange(400.0))
        wanted = np.arange(5.0, 390.0)
        swing = np.sin(0.31 * times)
        moved = interpolate(wanted, times, np.clip(swing, -0.6, 0.6), widest=3.0)
        assert (np.max(moved), np.min(moved)) == (0.6, -0.6)
        assert all(clipped_run(moved, largest=largest) is not None for largest in (True, False))
        away = np.abs(np.sin(0.31 * wanted)) < 0.3
        np.testing.assert_allclose(moved[away], np.sin(0.31 * wanted)[away], atol=0.02)
        whole = interpolate(wanted, times, swing, widest=3.0)
        assert np.max(whole) > 0.995


@pytest.mark.parametrize("seed", range(4))
def test_a_noisy_drive_is_not_clipped_and_its_clipped_copy_is(seed: int) -> None:
    """Crests of a rough motion under noise have three samples in the zone of a rail now and then."""
    car = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
    )
    times = np.arange(0, 60, 0.005)
    heights = road("B", speed=20.0, under=car).heights(times, rng=np.random.default_rng(seed))
    shown = ["chassis_acceleration", "tire_acceleration", "chassis"]
    driven = add_noise(simulate(car, times, heights, outputs=shown), snr_db=30.0, rng=np.random.default_rng(50 + seed))
    for row in np.asarray(driven.outputs, float):
        assert not np.any(on_rail(row))
        limit = float(np.quantile(np.abs(row), 0.995))
        assert np.any(on_rail(np.clip(row, -limit, limit)))


@pytest.mark.parametrize("hold", [2, 4, 10])
@pytest.mark.parametrize("seed", range(3))
def test_values_that_a_slow_bus_holds_count_once(seed: int, hold: int) -> None:
    """What is said of a channel and of each of its values held for some samples is the same."""
    noise = np.random.default_rng(seed).standard_normal(3000)
    motion = np.round(lfilter(*butter(2, [0.08, 0.24], "band"), noise), 3)
    cut = np.clip(motion, -9, 1.5 * np.std(motion))
    for values in (motion, cut):
        assert np.array_equal(on_rail(np.repeat(values, hold)), np.repeat(on_rail(values), hold))
    # Stamps of two clocks that drift: a value lasts one sample more now and then.
    lasts = np.full(motion.size, hold) + (np.arange(motion.size) % 7 == 0)
    assert not np.any(on_rail(np.repeat(motion, lasts)))
    assert np.any(on_rail(np.repeat(cut, lasts)))


class TestSingleRows:
    """One row of thousands that a phone sends twice, or with the stamp of another."""

    STAMPS: RealArray = np.asarray(np.arange(300) / 100 + 0.003 * np.sin(np.arange(300) / 40), float)
    VALUES = np.random.default_rng(2).standard_normal((2, 300))

    def order(self, stamps: RealArray, values: RealArray) -> tuple[RealArray, RealArray, list[object]]:
        times, rows, findings = ordered(stamps, values, np.arange(stamps.size), np.zeros(0, np.intp))
        return times, values[:, rows], [finding.kind for finding in findings]

    @pytest.mark.parametrize("back", [2, 8])
    def test_one_that_is_sent_again_is_dropped(self, back: int) -> None:
        stamps = np.insert(self.STAMPS, 150, self.STAMPS[150 - back])
        values = np.insert(self.VALUES, 150, self.VALUES[:, 150 - back], axis=1)
        times, left, codes = self.order(stamps, values)
        assert codes == [Defect.REPEATED_ROWS]
        np.testing.assert_array_equal(times, self.STAMPS)
        np.testing.assert_array_equal(left, self.VALUES)

    def test_a_mass_at_rest_is_not_sent_again_in_coarse_stamps(self) -> None:
        """Three rows of one stamp, the first and last with the same samples: nothing came later in between."""
        stamps, values = self.STAMPS.copy(), self.VALUES.copy()
        stamps[151:153] = stamps[150]
        values[:, 152] = values[:, 150]
        with pytest.raises(RecordError, match="2 time stamps repeat the one before"):
            self.order(stamps, values)

    def test_several_rows_are_dropped_where_all_of_them_are_sent_again(self) -> None:
        rows = np.concatenate([np.arange(150), np.arange(146, 300)])
        times, left, codes = self.order(self.STAMPS[rows], self.VALUES[:, rows])
        assert codes == [Defect.REPEATED_ROWS]
        np.testing.assert_array_equal(times, self.STAMPS)
        np.testing.assert_array_equal(left, self.VALUES)

    def test_one_with_an_earlier_stamp_is_set_between_its_neighbours(self) -> None:
        stamps = self.STAMPS.copy()
        stamps[150] = stamps[148]
        times, left, codes = self.order(stamps, self.VALUES)
        assert codes == [Defect.WRONG_STAMPS]
        np.testing.assert_allclose(times, self.STAMPS, atol=0.001)
        np.testing.assert_array_equal(left, self.VALUES)

    def test_a_second_recording_is_not(self) -> None:
        stamps = np.append(self.STAMPS, self.STAMPS)
        with pytest.raises(RecordError, match="runs backwards"):
            self.order(stamps, np.tile(self.VALUES, 2))

    @pytest.mark.parametrize(("tied", "fine"), [(2, True), (30, False)])
    def test_a_few_equal_stamps_of_an_irregular_clock_are_moved_apart(self, tied: int, fine: bool) -> None:
        """Stamps of whole milliseconds, steps of 1 to 9: two that are nearer than a millisecond are equal."""
        rng = np.random.default_rng(3)
        steps = rng.integers(1, 10, 300) / 1000
        steps[rng.choice(np.arange(2, 298, 2), tied, replace=False)] = 0.0
        stamps = np.asarray(np.round(np.cumsum(steps), 3), float)
        if not fine:
            with pytest.raises(RecordError, match="repeat the one before"):
                self.order(stamps, self.VALUES)
            return
        times, left, codes = self.order(stamps, self.VALUES)
        assert codes == [Defect.TIED_STAMPS]
        assert np.all(np.diff(times) > 0)
        assert np.max(np.abs(times - stamps)) < 0.0005
        np.testing.assert_array_equal(left, self.VALUES)

    @pytest.mark.parametrize(("later", "told"), [(0.0, "keep one of them"), (50.0, "take it with")])
    def test_of_two_recordings_one_can_be_taken_where_their_times_are_apart(self, later: float, told: str) -> None:
        stamps = np.append(self.STAMPS[:100] + later, self.STAMPS)
        values = np.append(self.VALUES[:, :100], self.VALUES, axis=1)
        with pytest.raises(RecordError, match=f"runs backwards.*{told}"):
            self.order(stamps, values)
