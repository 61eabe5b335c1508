"""Finding decays: laws of what is none, exact starts of those that are, and records made by others."""

from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import RecordError, eigenmodes, free_decay, identify, quarter_car, statespace
from suspid.decays import Decay, Decays, find_decays, is_grave
from suspid.records import as_response, cut
from suspid.words import DecayDoubt, DecayKind, DecayRemark, Level, Remark
from validation import cars

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
Real = NDArray[np.float64]
PUSHED = quarter_car(chassis_mass=320, tire_mass=38, chassis_stiffness=18e3, tire_stiffness=190e3, chassis_damping=1300)
# Natural frequencies of the hatchback [rad/s].
EXACT = eigenmodes(cars.HATCHBACK).wn
ZETA = eigenmodes(cars.HATCHBACK).zeta
MASSES = ("seat", "chassis", "tire")


def noise(seed: int, channels: int = 2, samples: int = 12000) -> Real:
    return np.random.default_rng(seed).standard_normal((channels, samples))


def codes(decay: Decay) -> list[object]:
    return [doubt.code for doubt in decay.doubts]


def response(values: Real, fs: float = 200.0) -> control.TimeResponseData:
    return as_response(np.arange(values.shape[1]) / fs, values, [f"y{i}" for i in range(len(values))])


def released(
    starts: tuple[float, ...], *, seconds: float = 60.0, fs: float = 200.0, std: float = 2e-5, seed: int = 1
) -> control.TimeResponseData:
    """A car that is set moving at given times, exact, in white noise."""
    count = round(seconds * fs)
    values = std * noise(seed, 3, count)
    for start in starts:
        first = round(start * fs)
        values[:, first:] += free_decay(
            cars.HATCHBACK, np.arange(count - first) / fs, initial_state={"v_tire": 2.0, "v_chassis": 0.5}
        ).y
    return as_response(np.arange(count) / fs, values, MASSES)


class TestWords:
    def test_more_than_the_motion_is_a_multiple_of_it(self) -> None:
        assert "by 26 times the size of the motion" in str(Remark(DecayDoubt.FORCED, {"share": 26.2}))
        assert "leave it out (without)" in str(Remark(DecayDoubt.DRIVEN, {"share": 28.0, "channel": "hammer"}))
        assert "41 % of the motion of 'seat'" in str(Remark(DecayDoubt.DRIVEN, {"share": 0.41, "channel": "seat"}))
        assert "is 13 % of the motion" in str(Remark(DecayDoubt.NONLINEAR, {"share": 0.13}))

    @pytest.mark.parametrize(("share", "level"), [(0.018, Level.CARE), (0.05, Level.DOUBTFUL)])
    def test_a_first_part_that_hardly_deviates_calls_for_care(self, share: float, level: Level) -> None:
        """Joints of a beam that slip show beside little noise: it is a decay all the same."""
        decay = find_decays(released((20.0,)))[0]
        doubted = replace(decay, doubts=(Remark(DecayDoubt.FORCED, {"share": share}),))
        assert Decays((doubted,)).verdict.level is level
        assert is_grave(doubted.doubts[0]) == (level is Level.DOUBTFUL)
        # What remains of all of it is none of the first part.
        assert is_grave(Remark(DecayDoubt.DRIVEN, {"share": share, "channel": "seat"}))


class TestNothingDecays:
    """What is stationary has no decay, and the remarks say what was seen."""

    @pytest.mark.parametrize("seed", range(3))
    def test_white_noise(self, seed: int) -> None:
        decays = find_decays(response(noise(seed)))
        assert not decays
        assert [remark.code for remark in decays.remarks] == [DecayRemark.NO_EVENT]
        assert decays.verdict.level is Level.NONE

    @pytest.mark.slow
    @pytest.mark.parametrize("seed", range(3))
    def test_a_random_walk_and_its_rate_through_a_resonance(self, seed: int) -> None:
        from scipy.signal import lfilter

        pole = np.exp((-0.3 + 1j) * 2 * np.pi * 1.5 / 200)
        rolling = lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], noise(seed), axis=1)
        assert not find_decays(response(rolling))
        assert not find_decays(response(np.cumsum(noise(seed), axis=1)))

    def test_a_steady_tone(self) -> None:
        tone = np.sin(2 * np.pi * 21.3 * np.arange(12000) / 200)
        assert not find_decays(response(tone + 0.1 * noise(1)))

    def test_a_quantised_sensor_at_rest(self) -> None:
        assert not find_decays(response(0.125 * np.round(0.3 * noise(1))))

    def test_a_burst_of_noise_is_refused_with_a_reason(self) -> None:
        values = noise(1)
        values[:, 4000:6000] *= 40
        decays = find_decays(response(values))
        assert not [decay for decay in decays if not decay.doubts]
        assert decays.remarks


class TestStart:
    """A decay that begins at a known sample begins there, to within a few samples of it, or later by a little."""

    @pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
    def test_three_releases(self, seed: int) -> None:
        starts = (11.0, 27.3, 44.1)
        decays = find_decays(released(starts, seed=seed))
        assert [decay.rank for decay in decays] == [1, 2, 3]
        found = sorted(decay.start for decay in decays)
        # Within the noise the first samples may be missed, and samples before it in which nothing moves may be kept.
        np.testing.assert_allclose(found, starts, atol=0.05)
        for decay in decays:
            assert decay.level > 20
            # The body bounce at 1.1 Hz, the seat, the wheel: each to a fifth, from seconds of data.
            nearest = np.min(np.abs(decay.wn[:, None] / EXACT - 1), axis=0)
            assert np.all(nearest < 0.2)

    def test_forcing_is_left_out(self) -> None:
        """A bump of 80 ms over the road: the decay starts at its end, not at its crest."""
        from validation.decays import Case, recording

        _, record, ends = recording(Case(quantity="acceleration", rolling=0.0, snr_db=60.0, bumps=1), seed=3)
        decays = find_decays(record)
        assert len(decays) == len(ends) == 1
        late = np.array(sorted(decay.start for decay in decays)) - np.array(ends)
        # Sampled at 250 Hz; at 60 dB a forced sample is not consistent with noise.
        assert np.all(late > -0.02)
        assert np.all(late < 0.08)

    @pytest.mark.parametrize("gap", [0.5, 1.0])
    def test_a_second_release_while_the_first_still_rings(self, gap: float) -> None:
        decays = find_decays(released((20.0, 20.0 + gap), seconds=45.0))
        found = sorted(decays, key=lambda decay: decay.start)
        # The motion before a sample at 200 Hz is exact; the first few samples of a mode may hide in what still rings.
        np.testing.assert_allclose([decay.start for decay in found], [20.0, 20.0 + gap], atol=0.02)
        assert found[0].stop < 20.0 + gap
        assert DecayDoubt.CUT_OFF in codes(found[0])
        assert found[1].doubts == ()

    def test_a_pushed_car_let_go(self) -> None:
        """Pushing is slow and no decay: from the start that is found, `identify` gives the modes of the car."""
        fs, first, count = 100.0, 3270, 6000
        system = statespace(PUSHED, outputs=["chassis_acceleration"])
        time = np.arange(count) / fs
        values = 0.015 * noise(5, 1, count)
        values[:, first:] += np.atleast_2d(
            free_decay(system, time[: count - first], initial_state={"z_chassis": -0.035, "z_tire": -0.003}).y
        )
        pushing = np.arange(first - 300, first)
        values[0, pushing] += 0.15 * np.sin(2.2 * np.pi * (time[pushing] - time[first])) * np.hanning(300)
        (decay,) = find_decays(response(values, fs=fs))
        assert decay.doubts == ()
        # No sample of the pushing is kept; the wheel is gone after a tenth of a second.
        assert -0.005 < decay.start - time[first] < 0.1
        modes = identify(cut(response(values, fs=fs), start=decay.start, stop=decay.stop)).modes
        truth, interval = eigenmodes(PUSHED), modes.interval(0.999)
        assert interval.wn[0, 0] < truth.wn[0] < interval.wn[0, 1]
        assert interval.zeta[0, 0] < truth.zeta[0] < interval.zeta[0, 1]

    def test_a_given_stretch_is_not_moved(self) -> None:
        (decay,) = find_decays(released((11.0,)), given=[(11.5, 14.0)])
        assert (decay.start, decay.stop) == (11.5, 14.0)

    def test_a_given_stretch_must_lie_within(self) -> None:
        with pytest.raises(RecordError, match="not within the record"):
            find_decays(released((11.0,)), given=[(50.0, 70.0)])


class TestDoubts:
    def test_the_record_begins_with_it(self) -> None:
        (decay,) = find_decays(released((0.0,)))
        assert decay.start < 0.05
        assert DecayDoubt.AT_START in codes(decay)

    def test_clipped(self) -> None:
        record = released((11.0,))
        values = np.array(record.y)
        limit = 0.3 * np.max(np.abs(values[2]))
        values[2] = np.clip(values[2], -limit, limit)
        decays = find_decays(as_response(np.asarray(record.time), values, MASSES))
        # Either it starts after the clipped samples, or says that there are some.
        for decay in decays:
            inside = (record.time >= decay.start) & (record.time <= decay.stop)
            clipped = np.sum(np.abs(values[2, inside]) == limit) >= 3
            assert not clipped or DecayDoubt.CLIPPED in codes(decay)

    def test_few_cycles_are_said(self) -> None:
        values = 1e-3 * noise(1, 1, 8000)
        time = np.arange(4000) / 200
        values[0, 4000:] += np.exp(-0.75 * 2 * np.pi * 1.5 * time) * np.cos(2 * np.pi * 1.0 * time)
        decays = find_decays(response(values))
        assert all(DecayDoubt.FEW_CYCLES in codes(decay) for decay in decays)

    @pytest.mark.slow
    def test_what_is_mostly_driven_casts_doubt_on_the_rest(self) -> None:
        """A car on a rough road, its road's roughness in bursts: nothing is beyond doubt."""
        from scipy.signal import lfilter

        pole = np.exp((-0.2 + 1j) * 2 * np.pi * 1.5 / 200)
        loud = 1 + 30 * (np.arange(6000) % 1500 < 300)
        rolling = lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], loud * noise(1)[:, :6000], axis=1)
        assert all(decay.doubts for decay in find_decays(response(rolling)))

    def test_a_mode_slower_than_the_stretch_is_said(self) -> None:
        (decay,) = find_decays(released((11.0,)), given=[(11.0, 12.2)])
        # The bounce at 1.11 Hz makes 1.3 cycles in it.
        (doubt,) = [doubt for doubt in decay.doubts if doubt.code is DecayDoubt.TOO_SHORT]
        assert doubt.numbers["cycles"] == pytest.approx(
            1.2 * EXACT[0] * np.sqrt(1 - ZETA[0] ** 2) / (2 * np.pi), rel=0.2
        )

    @pytest.mark.slow
    def test_a_given_start_before_the_release_is_said(self) -> None:
        (decay,) = find_decays(released((11.0,)), given=[(10.9, 16.0)])
        assert decay.doubts


class TestKind:
    """The places of rest before and after tell a step of the road from a release."""

    def moved(self, offsets: tuple[float, float, float]) -> Decays:
        count, first = 8000, 3000
        values = 2e-5 * noise(1, 3, count)
        values[:, :first] += np.array(offsets)[:, None]
        values[:, first:] += free_decay(
            cars.HATCHBACK,
            np.arange(count - first) / 200,
            initial_state=dict(zip(("z_seat", "z_chassis", "z_tire"), offsets, strict=True)),
        ).y
        return find_decays(as_response(np.arange(count) / 200, values, MASSES))

    def test_all_masses_move_alike_after_a_step(self) -> None:
        (decay,) = self.moved((0.05, 0.05, 0.05))
        assert decay.kind is DecayKind.STEP

    def test_masses_held_apart_are_released(self) -> None:
        (decay,) = self.moved((0.05, 0.05, 0.01))
        assert decay.kind is DecayKind.RELEASE

    def test_back_where_it_was_after_an_impulse(self) -> None:
        (decay,) = find_decays(released((11.0,)))
        assert decay.kind in (None, DecayKind.IMPULSE)


class TestResult:
    def test_text_shows_frequencies_in_hertz_and_what_set_it_off(self) -> None:
        wn, zeta = 2 * np.pi * np.array([1.5, 12.25]), np.array([0.1, 0.2])
        one, other = (
            Decay(
                start=1.0, stop=2.0, rank=rank, kind=kind, level=30.0, cycles=4.0, strength=50.0, wn=wn, zeta=zeta,
                doubts=doubts,
            )
            for rank, kind, doubts in ((1, DecayKind.STEP, ()), (2, None, (Remark(DecayDoubt.GROWING),)))
        )  # fmt: skip
        *_, first, second, doubt = str(Decays((one, other))).splitlines()
        assert first.split() == ["1", "1", "2", "step", "30", "4.0", "1.5,", "12.2", "none"]
        assert "?" in second
        assert doubt == "decay 2: part of the motion grows: still driven"

    def test_decays_are_a_sequence_that_survives_pickling(self) -> None:
        import pickle

        decays = find_decays(released((11.0,), seconds=20.0), given=[(11.0, 13.0), (2.0, 6.0)])
        again = pickle.loads(pickle.dumps(decays))
        assert isinstance(again, Decays)
        assert (len(again), bool(again), next(iter(again)) is again[0]) == (1, True, True)
        assert [d.start for d in again] == [d.start for d in decays]
        assert again.remarks == decays.remarks
        assert len(again.remarks) == 1
        assert again[0].doubts == decays[0].doubts
        assert str(again) == str(decays)

    @pytest.mark.slow
    def test_the_best_decay_decides_the_verdict(self) -> None:
        record = released((11.0,), seconds=20.0)
        sound, slow = find_decays(record), find_decays(record, given=[(11.0, 12.2)])
        forced = find_decays(record, given=[(10.9, 16.0)])
        assert sound.verdict.level is Level.SOUND
        assert slow.verdict.level is Level.CARE
        assert forced.verdict.level is Level.DOUBTFUL
        assert slow.verdict.doubts == slow[0].doubts

    def test_scale_and_sign_of_the_channels_do_not_matter(self) -> None:
        record = released((11.0, 30.0))
        scaled = as_response(
            np.asarray(record.time), np.asarray(record.y) * np.array([[1e3], [-2.0], [1e-6]]) + 5.0, MASSES
        )
        one, other = find_decays(record), find_decays(scaled)
        # Rounding may decide between two samples.
        assert [d.start for d in one] == pytest.approx([d.start for d in other], abs=0.0051)


@pytest.mark.skipif(not DATA.is_dir(), reason="the data of others are not there")
@pytest.mark.slow
class TestRecordsOfOthers:
    def simulated(self, name: str) -> control.TimeResponseData:
        path = DATA / "rizoit_seat3dof_sim" / f"{name}.csv"
        names = path.read_text().splitlines()[0].split(",")[1:]
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        return as_response(table[:, 0], table[:, 1:].T, names)

    def test_a_road_step(self) -> None:
        (decay,) = find_decays(self.simulated("step50mm"))
        assert decay.start == pytest.approx(1.0, abs=0.0015)
        assert decay.kind is DecayKind.STEP
        np.testing.assert_allclose(decay.wn / (2 * np.pi), [1.2522, 2.6343, 9.5142], rtol=1e-3)
        assert decay.doubts == ()

    def test_a_release_from_its_first_sample(self) -> None:
        record = self.simulated("release")
        (decay,) = find_decays(as_response(np.asarray(record.time), np.asarray(record.y)[:6], record.output_labels[:6]))
        assert decay.start == 0.0
        np.testing.assert_allclose(decay.wn / (2 * np.pi), [1.2522, 2.6343, 9.5142], rtol=1e-3)

    def test_a_measured_ring_down(self) -> None:
        from scipy.io import loadmat

        values = loadmat(DATA / "vibtest_inout_mat" / "case1.mat")["Time_chan_2"].reshape(1, -1).astype(float)
        (decay,) = find_decays(response(values, fs=1280.0))
        assert decay.start < 0.2
        assert np.min(np.abs(decay.wn / (2 * np.pi) - 212.1)) < 0.5
        assert decay.doubts

    def test_a_drive_holds_nothing_beyond_doubt(self) -> None:
        """Twenty minutes of road, as others recorded it; nobody released anything."""
        pytest.importorskip("asammdf")
        from suspid.analysis import Settings
        from suspid.analysis.reading import read

        folder = DATA / "css_canedge_car_mf4"
        settings = Settings(channels=("AccelerationX",), dbc=folder / "canmod-gps.dbc")
        for path in sorted(folder.glob("0000*.MF4")):
            assert all(decay.doubts for decay in find_decays(read(path, settings).cleaned.record))

    def test_a_running_machine(self) -> None:
        pyuff = pytest.importorskip("pyuff")
        path = next((DATA / "pyuff_uff58_mps").glob("MPSTD*.uff"))
        file = pyuff.UFF(str(path))
        values = np.array([file.read_sets(i)["data"] for i in range(4)], float)
        assert not find_decays(response(values, fs=3200.0))
