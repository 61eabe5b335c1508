"""The largest motion of a record is tried where the search for decays ends without a result."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lfilter
from scipy.special import ellipk

from suspid import Identification, Settings, analyse, as_record, identify
from suspid.analysis.choice import damping_known
from suspid.analysis.largest import STARTS_TRIED, _as_damped_later, _largest, _motions, _plain, of_largest
from suspid.analysis.shrinking import longest_shrinking, shrinking
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.signals import Signal, as_signal
from suspid.units import RealArray
from suspid.words import Check, Level, Note, RecordCheck, Remark
from validation import rigs

RATE = 1000


def ruler(seed: int, *, bend: float = 0.35) -> tuple[RealArray, RealArray]:
    """Return times and the motion of a ruler at the edge of a table, plucked at .5 s, as a sensor that bends has it.

    15.1 Hz; where it hits the edge the clamp loses more of it in large swings. Steps of a fifth of a sample.
    """
    rng = np.random.default_rng(seed)
    wn, step, q, v, out = 2 * np.pi * 15.1, 1 / (5 * RATE), 1.0, 0.0, []
    for k in range(int(2.5 * RATE) * 5):
        if k % 5 == 0:
            out.append(q)
        v += step * (-2 * (0.005 + 0.006 * abs(q)) * wn * v - wn**2 * q * (1 - 0.02 * abs(q)))
        q += step * v
    motion = np.concatenate([np.zeros(RATE // 2), out])
    t = np.arange(motion.size) / RATE
    since = np.maximum(t - 0.5, 0.0)
    knock = np.where(t > 0.5, np.exp(-since / 0.02), 0.0) * rng.standard_normal(t.size)
    drift = 0.03 * np.cumsum(rng.standard_normal(t.size)) / np.sqrt(RATE)
    y = motion + bend * motion**2 + 0.3 * knock + drift + 0.03 * np.sin(2 * np.pi * 50 * t) * rng.random(t.size)
    return t, np.asarray(np.round(31000 + 9000 * y))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_plucked_ruler(seed: int, tmp_path: Path) -> None:
    t, values = ruler(seed)
    path = tmp_path / "ruler.csv"
    np.savetxt(path, np.column_stack([t, values]), fmt="%.6g", delimiter=",", header="t [s],level", comments="")
    found = analyse(path)
    assert len(found.modes)
    assert abs(found.modes.wn[0] / (2 * np.pi) - 15.05) < 0.1
    assert 0.005 < found.modes.zeta[0] < 0.012


class TestOfLargest:
    t = np.arange(3000) / 100
    swing = np.where(t > 5, np.exp(-0.3 * np.maximum(t - 5, 0)) * np.sin(12 * (t - 5)), 0.0)
    noise = 2e-3 * np.random.default_rng(1).standard_normal(3000)

    def stretch(self, start: float, values: RealArray) -> tuple[Used, Used]:
        record = as_response(self.t, values[None], ["seat"])
        part = cut(record, start=start, stop=start + 2.0)
        return Used(record=record, decays=(), used=(), notes=()), Used(record=part, decays=(), used=(), notes=())

    def test_what_is_far_larger_is_used_instead_of_nothing(self) -> None:
        whole, calm = self.stretch(1.0, self.swing + self.noise)
        none = identify(calm.record)
        assert not len(none.modes)
        used = of_largest(whole.record, calm, none, Settings())
        assert used is not None
        assert used.identification is not None
        assert used.identification.modes.wn == pytest.approx([12.0], rel=2e-3)
        assert [note.code for note in used.notes] == [Note.LARGEST_USED]
        assert 4 < as_signal(used.record).start < 7

    def test_modes_that_are_not_doubtful_stay_where_the_larger_motion_has_them_too(self) -> None:
        whole, part = self.stretch(20.0, self.swing + 0.02 * self.noise)
        found = identify(part.record)
        assert found.verdict.level > Level.DOUBTFUL
        assert of_largest(whole.record, part, found, Settings()) is None

    def test_those_of_a_knock_give_way_to_a_far_larger_motion(self) -> None:
        """Two modes beat, and a knock fifty times as small comes at the end."""
        since, late = np.maximum(self.t - 5, 0), np.maximum(self.t - 25, 0)
        beats = np.exp(-0.2 * since) * (np.sin(12 * since) + 0.9 * np.sin(13.1 * since)) * (self.t < 22)
        knock = np.where(self.t >= 25, np.exp(-1.2 * late) * np.sin(50 * late), 0.0)
        whole, part = self.stretch(25.0, beats + 0.02 * knock + 0.002 * self.noise)
        found = identify(part.record)
        assert found.modes.wn == pytest.approx([50], rel=0.01)
        assert found.verdict.level > Level.DOUBTFUL
        used = of_largest(whole.record, part, found, Settings())
        assert used is not None
        assert used.identification is not None
        assert used.identification.modes.wn == pytest.approx([12, 13.1], rel=0.01)

    def test_modes_among_which_those_of_the_larger_motion_are_stay(self) -> None:
        """It goes on at the end, as loud as the knock."""
        since, late = np.maximum(self.t - 5, 0), np.maximum(self.t - 25, 0)
        beats = np.exp(-0.2 * since) * (np.sin(12 * since) + 0.9 * np.sin(13.1 * since))
        knock = np.where(self.t >= 25, np.exp(-1.2 * late) * np.sin(50 * late), 0.0)
        whole, part = self.stretch(25.0, beats + 0.02 * knock + 1e-4 * self.noise)
        found = identify(part.record)
        assert found.modes.wn == pytest.approx([12, 13.1, 50], rel=0.01)
        assert of_largest(whole.record, part, found, Settings()) is None

    def test_a_swing_of_many_is_no_result_where_all_of_them_are(self) -> None:
        """Two modes beat: the swing is as large as any other, and the record does not move more elsewhere."""
        since = np.maximum(self.t - 5, 0)
        lasting = np.exp(-0.02 * since) * (np.sin(12 * since) + 0.9 * np.sin(13.1 * since))
        whole, _ = self.stretch(1.0, lasting + self.noise)
        part, found = cut(whole.record, start=20.3, stop=20.8), identify(cut(whole.record, start=5.3, stop=6.0))
        assert len(found.modes)
        assert found.verdict.level is Level.DOUBTFUL
        used = of_largest(whole.record, Used(record=part, decays=(), used=(), notes=()), found, Settings())
        assert used is not None
        assert used.identification is not None
        assert used.identification.modes.wn == pytest.approx([12, 13.1], rel=1e-3)
        assert used.identification.modes.zeta == pytest.approx([0.02 / 12, 0.02 / 13.1], rel=0.05)

    @pytest.mark.parametrize("settings", [Settings(start=1.0), Settings(modes=1), Settings(decay="whole")])
    def test_what_the_settings_choose_stays(self, settings: Settings) -> None:
        whole, calm = self.stretch(1.0, self.swing + self.noise)
        assert of_largest(whole.record, calm, identify(calm.record), settings) is None

    def test_modes_of_one_start_alone_are_none(self) -> None:
        """A sweep has another frequency from each start on."""
        sweep = np.where(self.t > 5, np.exp(-0.05 * (self.t - 5)) * np.sin(0.8 * (self.t - 5) ** 2), 0.0)
        whole, calm = self.stretch(1.0, sweep + self.noise)
        assert of_largest(whole.record, calm, identify(calm.record), Settings()) is None

    @pytest.mark.parametrize(("apart", "used"), [(0.0, True), (0.1, False)])
    def test_another_start_shows_the_same(self, apart: float, used: bool, monkeypatch: pytest.MonkeyPatch) -> None:
        """Each start has a mode of its own where they are apart, as sure as if it were one."""
        whole, calm = self.stretch(1.0, self.swing + self.noise)
        none, time, tries = identify(calm.record), np.arange(600) / 100, iter(range(6))

        def tried(_part: object, _settings: Settings) -> Identification:
            wn = 12 * (1 + apart) ** next(tries)
            values = np.exp(-0.3 * time) * np.sin(wn * time) + self.noise[:600]
            return identify(as_response(time, values[None], ["seat"]))

        monkeypatch.setattr("suspid.analysis.largest.tried", tried)
        assert (of_largest(whole.record, calm, none, Settings()) is not None) is used

    @pytest.mark.parametrize(("rate", "start"), [(2.5, 2), (0.3, 0)])
    def test_what_dies_at_once_and_few_starts_show_is_still_held(
        self, rate: float, start: int, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """The first two of six starts show a second mode; one that swings for long is a mode."""
        whole, calm = self.stretch(1.0, self.swing + self.noise)
        none, time, tries = identify(calm.record), np.arange(600) / 100, iter(range(6))

        def tried(_part: object, _settings: Settings) -> Identification:
            beside = np.exp(-rate * time) * np.sin(20 * time) if next(tries) < 2 else 0.0
            return identify(as_response(time, (np.exp(-0.3 * time) * np.sin(12 * time) + beside)[None], ["seat"]))

        starts: list[float] = []

        def noted(record: Any, *, start: float, stop: float) -> Any:
            starts.append(start)
            return cut(record, start=start, stop=stop)

        monkeypatch.setattr("suspid.analysis.largest.tried", tried)
        monkeypatch.setattr("suspid.analysis.largest.cut", noted)
        used = of_largest(whole.record, calm, none, Settings())
        assert used is not None
        assert as_signal(used.record).start == pytest.approx(sorted(starts)[start], abs=0.02)

    def test_the_channel_that_has_most_of_it_is_tried_alone_too(self) -> None:
        """A hand that lets go moves the other axes of a sensor for as long as it likes."""
        rng = np.random.default_rng(3)
        hand = 0.05 * (self.t > 5) * lfilter([0.2], [1, -0.8], rng.standard_normal((2, self.t.size)))
        values = np.stack([self.swing, *hand]) + 1e-3 * rng.standard_normal((3, self.t.size))
        record = as_response(self.t, values, ["x", "y", "z"])
        whole, alone = list(_motions(record, largest=True, beside=True))[:2]
        assert as_signal(whole.record).channels == ("x", "y", "z")
        assert whole.first > 10
        assert as_signal(alone.record).channels == ("x",)
        assert alone.first < 5.5

    def test_of_two_that_move_alike_none_is(self) -> None:
        values = np.stack([self.swing, 0.8 * self.swing]) + self.noise
        motions = _motions(as_response(self.t, values, ["x", "y"]), largest=True, beside=True)
        assert next(as_signal(motion.record).channels for motion in motions) == ("x", "y")
        assert [as_signal(motion.record).channels for motion in motions] in ([], [("x",)])

    def test_noise_has_no_largest_motion(self) -> None:
        whole, _ = self.stretch(1.0, self.noise)
        assert _largest(as_signal(whole.record)) is None
        short = cut(whole.record, stop=2.0)
        assert _largest(as_signal(short)) is None

    def test_it_lasts_until_the_record_is_calm_again(self) -> None:
        whole, _ = self.stretch(1.0, self.swing + self.noise)
        span = _largest(as_signal(whole.record))
        assert span is not None
        assert 4 < span[0] < 5.3
        assert 15 < span[1] < 29


def test_a_pendulum_held_far_up_and_never_at_rest(tmp_path: Path) -> None:
    """No stretch is calm, and each swing of a decay that bends looks like a new event; its swings shrink one by one."""
    wn, damping, drag, held = 2 * np.pi * 1.72, 0.005, 0.02, 0.4
    t = np.arange(5000) / RATE

    def slope(_: float, state: RealArray) -> list[float]:
        x, v = state
        return [v, -(wn**2) * np.sin(x) - 2 * damping * wn * v - drag * v * abs(v)]

    def turns(_: float, state: RealArray) -> float:
        return float(state[1])

    swing: Any = solve_ivp(
        slope, (0, 5), [np.radians(150), 0.0], rtol=1e-9, atol=1e-10, dense_output=True, events=turns
    )
    degrees = np.degrees(swing.sol(np.maximum(t - held, 0.0))[0]) + 0.3 * np.random.default_rng(1).standard_normal(5000)
    path = tmp_path / "far_up.csv"
    steps = np.round(degrees / 0.35) * 0.35
    np.savetxt(path, np.column_stack([t, steps]), fmt="%.6g", delimiter=",", header="t [s],angle [deg]", comments="")
    found = analyse(path)
    assert len(found.modes) == 1
    assert found.verdict.level is Level.CARE
    (mode,) = found.identification.amplitude_dependence
    size = np.radians(mode.amplitude)
    exact = wn * np.pi / 2 / ellipk(np.sin(size / 2) ** 2)
    np.testing.assert_allclose(mode.wn, exact, rtol=0.003)
    # Logarithmic decrements of the exact turning points.
    swings = np.log(np.abs(np.diff(swing.y_events[0][:, 0])) / 2)
    decrement = np.interp(-np.log(size), -0.5 * (swings[:-2] + swings[2:]), (swings[:-2] - swings[2:]) / 2)
    zeta = decrement / np.hypot(np.pi, decrement)
    assert np.all(np.abs(mode.zeta - zeta) < np.maximum(0.02 * zeta, 2 * mode.zeta_std))
    np.testing.assert_allclose(mode.zeta, zeta, rtol=0.03)


@pytest.mark.parametrize("later", [1.2, 2.0])
def test_damping_that_grows_is_that_of_a_beat(later: float) -> None:
    first, last = (
        identify(
            as_record(
                np.exp(-rate * TestOfLargest.t) * np.sin(12 * TestOfLargest.t) + TestOfLargest.noise,
                timepts=TestOfLargest.t,
            )
        )
        for rate in (0.2, 0.2 * later)
    )
    assert _as_damped_later([first, None, last]) is (later < 1.5)
    assert not _as_damped_later([first, None])


def test_another_mode_late_in_a_motion_does_not_tell_its_damping() -> None:
    time, noise = TestOfLargest.t, TestOfLargest.noise
    swing = np.exp(-0.2 * time) * np.sin(12 * time)
    beside = 0.1 * np.exp(-0.02 * time) * np.sin(31 * time)
    first, last = (identify(as_record(values + noise, timepts=time)) for values in (swing, swing + beside))
    assert len(last.modes) == 2
    assert _as_damped_later([first, last])


@pytest.mark.parametrize(("hum", "brief", "used"), [(1.0, False, True), (0.3, False, False), (0.3, True, True)])
def test_a_smaller_motion_beside_a_doubtful_decay_is_not_tried(
    hum: float, brief: bool, used: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fan whose tone falls slowly, and a blow in the middle of it, whose decay is doubtful.

    Where its modes are so of themselves, as of the hand that catches a swing, it may be larger.
    """
    time, noise = TestOfLargest.t, TestOfLargest.noise
    since = np.maximum(time - 2, 0)
    blow = np.where(time > 2, 2 * np.exp(-6 * since) * np.sin(100 * since), 0.0)
    record = as_response(time, (hum * np.exp(-0.03 * time) * np.sin(12 * time) + blow + noise)[None], ["body"])
    doubtful = Check(Remark(RecordCheck.NEVER_SWINGS), Level.DOUBTFUL)
    monkeypatch.setattr("suspid.analysis.choice.doubts_of", lambda *_: (doubtful,))
    part = cut(record, start=2.0, stop=4.0)
    count, wn = (40, 30) if brief else (200, 100)
    after = 2 * np.exp(-6 * time[:count]) * np.sin(wn * time[:count])
    found = identify(as_response(time[:count], (after + noise[:count])[None], ["body"]))
    assert len(found.modes)
    assert (found.verdict.level is Level.DOUBTFUL) is brief
    stretch = Used(record=part, decays=(), used=(), notes=())
    monkeypatch.setattr("suspid.analysis.largest._plain", lambda _, level: level is Level.DOUBTFUL)
    assert (of_largest(record, stretch, found, Settings()) is not None) is used


@pytest.mark.parametrize(("short", "used"), [(True, True), (False, False)])
def test_swings_that_shrink_far_longer_than_a_doubtful_stretch_are_used_doubtful(
    short: bool, used: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The stretch is sound of itself and doubtful as a decay; every start of the swings is doubtful as well."""
    time = TestOfLargest.t
    record = as_response(time, (np.exp(-0.03 * time) * np.sin(12 * time) + TestOfLargest.noise)[None], ["seat"])
    doubtful = Check(Remark(RecordCheck.NEVER_SWINGS), Level.DOUBTFUL)
    monkeypatch.setattr("suspid.analysis.choice.doubts_of", lambda *_: (doubtful,))
    monkeypatch.setattr("suspid.analysis.largest._plain", lambda _, level: level is Level.DOUBTFUL)
    part = cut(record, start=20.0, stop=24.0 if short else 29.0)
    stretch = Used(record=part, decays=(), used=(), notes=())
    assert (of_largest(record, stretch, identify(part), Settings()) is not None) is used


@pytest.mark.parametrize(("grows", "used"), [(1.0, True), (1.2, False)])
def test_where_nothing_is_calm_the_last_start_shows_the_same_damping(
    grows: float, used: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    time = TestOfLargest.t
    fills = np.exp(-0.05 * time) * np.sin(3 * time) + TestOfLargest.noise
    record = as_response(time, fills[None], ["seat"])
    stretch = Used(record=record, decays=(), used=(), notes=())
    calm = identify(as_response(time, TestOfLargest.noise[None], ["seat"]))

    def tried(part: control.TimeResponseData, _settings: Settings) -> Identification:
        start = int(np.argmin(np.abs(np.array(STARTS_TRIED) - part.time[0] / time[-1])))
        values = np.exp(-0.1 * grows**start * time) * np.sin(12 * time) + TestOfLargest.noise
        return identify(as_response(time, values[None], ["seat"]))

    monkeypatch.setattr("suspid.analysis.largest.tried", tried)
    assert (of_largest(record, stretch, calm, Settings()) is not None) is used


class TestShrinking:
    t = np.arange(1000) / 100

    def span(self, values: RealArray) -> tuple[float, float] | None:
        return shrinking(Signal(start=2.0, step=0.01, values=np.atleast_2d(values), channels=("a", "b")[: values.ndim]))

    def test_from_the_largest_swing_to_the_last_sample(self) -> None:
        fall = np.exp(-0.1 * self.t) * np.cos(2 * np.pi * self.t)
        assert self.span(fall) == pytest.approx((2.5, 11.99), abs=0.02)

    def test_to_where_another_motion_begins(self) -> None:
        fall = np.exp(-0.2 * self.t) * np.cos(2 * np.pi * self.t) + np.where(self.t > 8, 0.3, 0.0)
        assert self.span(fall) == pytest.approx((2.5, 9.5), abs=0.05)

    def test_a_first_swing_that_takes_longer_is_left_out(self) -> None:
        late = np.exp(-0.1 * self.t) * np.cos(2 * np.pi * (self.t - 0.35 * np.clip(self.t, 0, 1.3)))
        assert self.span(late) == pytest.approx((3.455, 11.99), abs=0.02)

    def test_not_before_the_largest_swing(self) -> None:
        """A knock of seven swings, and at 5 s a release three times as large."""
        knock = np.where(self.t < 3.7, np.exp(-0.5 * self.t) * np.sin(2 * np.pi * self.t), 0.0)
        since = np.maximum(self.t - 3.7, 0)
        assert self.span(knock + 3 * np.exp(-0.3 * since) * np.sin(2 * np.pi * since)) == pytest.approx(
            (5.95, 11.99), abs=0.06
        )

    @pytest.mark.parametrize("second", [1.0, 0.85])
    def test_half_of_a_beat_and_what_swells_after_it_are_none(self, second: float) -> None:
        """Two tones that meet at the first sample and are apart by half a turn after 10 s."""
        both = np.cos(20 * self.t) + second * np.cos((20 + np.pi / 10) * self.t)
        assert self.span(both) is None
        free = np.exp(-0.2 * self.t) * np.cos(10 * self.t)
        assert self.span(free) is not None
        swells = np.where(self.t > 8, 0.6 * np.sin(10 * (self.t - 8)), 0.0)
        assert self.span(free + swells) is None

    def test_few_swings_and_those_that_swell_again_are_none(self) -> None:
        beat = np.cos(0.7 * self.t) * np.cos(20 * self.t)
        few = np.exp(-0.1 * self.t) * np.cos(2 * np.pi * 0.35 * self.t)
        assert self.span(beat) is None
        assert self.span(few) is None


def test_it_calls_for_care() -> None:
    swing = TestOfLargest.swing + TestOfLargest.noise
    found = analyse(as_response(TestOfLargest.t, swing[None], ["seat"]))
    assert found.verdict.level is Level.SOUND
    used = replace(found, notes=(*found.notes, Remark(Note.LARGEST_USED, {"start": 1.0, "stop": 2.0})))
    assert RecordCheck.LARGEST_USED in {check.remark.code for check in used.verdict.checks}
    assert used.verdict.level is Level.CARE


class TestLongestShrinking:
    t = np.arange(6000) / 100
    free = np.where(t > 5, np.exp(-0.03 * np.maximum(t - 5, 0)) * np.sin(2 * np.pi * 0.6 * (t - 5)), 0.0)

    def found(self, *values: RealArray) -> tuple[str, float, float] | None:
        channels = ("a", "b")[: len(values)]
        return longest_shrinking(Signal(start=2.0, step=0.01, values=np.array(values), channels=channels))

    def noise(self, seed: int, size: float = 0.01) -> RealArray:
        return np.asarray(size * np.random.default_rng(seed).standard_normal(self.t.size))

    @pytest.mark.parametrize("seed", [1, 2, 3])
    def test_beside_a_knock_at_the_end(self, seed: int) -> None:
        knock = np.where(self.t > 59, 5 * np.exp(-8 * np.maximum(self.t - 59, 0)) * np.sin(90 * (self.t - 59)), 0.0)
        run = self.found(self.noise(seed), self.free + knock + self.noise(seed + 10))
        assert run is not None
        name, first, last = run
        assert name == "b"
        assert first == pytest.approx(7.0, abs=2.5)
        assert 58 < last < 62

    @pytest.mark.parametrize("size", [0.01, 0.04])
    def test_in_noise_that_makes_single_swings_larger(self, size: float) -> None:
        """3 Hz, which falls by 1.3 % in a cycle."""
        fast = np.exp(-0.04 * self.t) * np.sin(2 * np.pi * 3 * self.t)
        run = self.found(fast + self.noise(7, size))
        assert run is not None
        assert run[2] - run[1] > 45

    def test_under_a_ripple_with_turns_of_its_own(self) -> None:
        """A bag that swings on its strap: 4.7 Hz on .6 Hz, a seventh as large as the first swings."""
        ripple = 0.07 * np.sin(2 * np.pi * 4.7 * self.t) * (1 + 0.5 * np.sin(0.9 * self.t))
        run = self.found(self.free + ripple + self.noise(8, 0.003))
        assert run is not None
        assert run[2] - run[1] > 30
        assert self.found(ripple + self.noise(8, 0.003)) is None

    def test_swings_that_noise_drives_are_none(self) -> None:
        """A resonance of 1.5 Hz and zeta .02 in white noise: in a minute its swings shrink for seven seconds."""
        poles = np.exp(0.01 * 2 * np.pi * 1.5 * np.array([-0.02 + 1j, -0.02 - 1j]))
        for seed in range(20):
            drive = np.random.default_rng(seed).standard_normal(self.t.size)
            assert self.found(np.asarray(lfilter([1.0], np.poly(poles).real, drive))) is None

    def test_what_swells_lasts_or_shrinks_for_a_part_is_none(self) -> None:
        steady = np.sin(2 * np.pi * 0.6 * self.t) + self.noise(4)
        assert self.found(steady) is None
        assert self.found(self.free[::-1].copy()) is None
        brief = np.exp(-0.2 * self.t) * np.sin(2 * np.pi * 1.2 * self.t) + self.noise(5)
        assert self.found(brief) is None
        # Half of a beat falls most at its end.
        assert self.found(np.cos(np.pi / 2 * self.t / 60) * np.sin(2 * np.pi * 0.6 * self.t)) is None

    def test_swings_of_other_times_are_none(self) -> None:
        """A sweep, whose swings take half the time at its end."""
        sweep = np.exp(-0.02 * self.t) * np.sin(2 * np.pi * (0.4 + 0.01 * self.t) * self.t)
        assert self.found(sweep) is None


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 4, 5])
def test_a_phone_that_swings_and_is_caught(seed: int, tmp_path: Path) -> None:
    """Handled at first, then .465 Hz, zeta .006, and a hand that stops it, with far larger accelerations."""
    rng, t = np.random.default_rng(seed), np.arange(0, 60, 1 / 125)
    swing = 0.4 * np.exp(-0.006 * 2 * np.pi * 0.465 * t) * np.cos(2 * np.pi * 0.465 * t)
    across = 0.08 * np.exp(-0.012 * 2 * np.pi * 0.465 * t) * np.cos(2 * np.pi * 0.93 * t + 0.3)
    handled = np.convolve(rng.standard_normal(t.size), np.hanning(30), "same") * np.exp(-t / 2) * 0.3
    hand = np.convolve(rng.standard_normal(t.size), np.hanning(9), "same") * np.exp(-8 * np.maximum(t - 59.5, 0))
    stopped = np.where(t > 59.5, 0.2 * hand, 0.0)
    noise = 0.012 * rng.standard_normal((3, t.size))
    rows = (
        np.array([0.3 * handled + 9 * stopped, across + handled - 2 * stopped, swing + handled + 4 * stopped]) + noise
    )
    header = '"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)","Acceleration z (m/s^2)"'
    path = tmp_path / "phone.csv"
    np.savetxt(path, np.column_stack([t, rows.T]), fmt="%.9E", delimiter=",", header=header, comments="")
    found = analyse(path)
    near = np.abs(found.modes.wn / (2 * np.pi * 0.465) - 1) < 0.01
    assert near.sum() == 1
    assert found.modes.zeta[near] == pytest.approx([0.006], rel=0.15)


def test_friction_that_explains_all_may_leave_the_damping_open() -> None:
    """A start whose interval reaches zero has both modes; a later one that is known better had lost one of them."""
    release = rigs.release("friction", 2, seed=990_004)
    time = np.arange(release.values.shape[1]) * (release.stamps[-1] / (release.values.shape[1] - 1))
    found = identify(cut(as_response(time, release.values, ["x1", "x2"]), start=0.7626, stop=1.5797))
    assert found.modes.wn == pytest.approx(release.rig.wn, rel=0.002)
    assert not damping_known(found)
    assert _plain(found, Level.CARE)
    assert not _plain(replace(found, forces=()), Level.CARE)
