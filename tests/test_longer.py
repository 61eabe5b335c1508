"""Of a decay that a record shows in parts, the whole is used where that tells more."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from suspid import Identification, analyse, identify
from suspid.analysis.choice import explained_by_forces, with_few_cycles
from suspid.analysis.longer import _from, longest
from suspid.analysis.shown_modes import shared_modes, shows_more, tells_tones
from suspid.analysis.used import used_of
from suspid.decays import find_decays
from suspid.identification import Considered, ForceKind
from suspid.identification.noise import noise_of
from suspid.identification.nonlinear import choice, motion, search, structure
from suspid.identification.nonlinear.feedback import Record
from suspid.records import as_response, cut
from suspid.words import DecayDoubt, Level, Reason, Remark
from validation import rigs


class TestTwoMasses:
    # Parts of one decay: its end alone, of two that overlap the later one, of one that is cut off where the fast mode
    # has died, of two with a pause between them, of one that is found late, and of one that is found late after others.
    # All are files of the simulator in `validation`, which shares nothing with the library.
    @pytest.mark.slow
    @pytest.mark.parametrize("seed", [3000003, 3000011, 3000020, 3000043, 3000052, 3200032])
    def test_both_modes_are_found_from_the_release_on(self, seed: int, tmp_path: Path) -> None:
        record = rigs.release("bilinear", 2, seed=seed)
        rigs.write(record, tmp_path / "release.csv")
        found = analyse(tmp_path / "release.csv")
        assert found.modes.wn == pytest.approx(record.rig.wn / record.pace, rel=0.01)
        # Within a period of the slowest mode after the release: the fast one has decayed after two or three.
        period = 2 * np.pi / float(record.rig.wn[0])
        (used,) = found.used
        assert record.start <= used.start < record.start + period

    # Of a decay of seven cycles the last alone looks like one, and has no doubts; a spring that stiffens leaves the
    # first two; of two cycles before a dead stop the second shows one mode.
    @pytest.mark.parametrize(
        ("kind", "seed"),
        [
            ("friction", 5300029),
            *(pytest.param(*one, marks=pytest.mark.slow) for one in [("cubic", 5300016), ("friction", 5300200)]),
        ],
    )
    def test_all_of_the_motion_is_used(self, kind: str, seed: int, tmp_path: Path) -> None:
        record = rigs.release(kind, 2, seed=seed)
        rigs.write(record, tmp_path / "release.csv")
        found = analyse(tmp_path / "release.csv")
        outcome = rigs.judged(record, found)
        assert outcome.right
        assert abs(outcome.wn) < 0.002
        period = 2 * np.pi / float(record.rig.wn[0])
        first, *_, last = found.identification.response.time
        assert first < record.start + 0.1 * period
        assert last > min(record.stop, float(record.stamps[-1])) - 0.2 * period

    # The last swings, or some of few, look like a linear decay of another mode.
    @pytest.mark.slow
    @pytest.mark.parametrize("seed", [940_013, 940_058])
    def test_a_few_cycles_of_what_friction_stops_are_no_other_mode(self, seed: int, tmp_path: Path) -> None:
        record = rigs.release("friction", 2, seed=seed)
        rigs.write(record, tmp_path / "release.csv")
        found = analyse(tmp_path / "release.csv").modes
        assert found.wn == pytest.approx(record.rig.wn / record.pace, rel=0.002)

    # Few cycles before a dead stop are doubtful from any start: more poles follow the part that is used as closely as
    # forces explain all of it. And a decay of eight cycles whose first sample is of the hold before it.
    @pytest.mark.slow
    @pytest.mark.parametrize("seed", [930004, 930018])
    def test_forces_that_explain_all_between_two_rests_are_preferred(self, seed: int, tmp_path: Path) -> None:
        record = rigs.release("friction", 2, seed=seed)
        rigs.write(record, tmp_path / "release.csv")
        found = analyse(tmp_path / "release.csv")
        assert found.modes.wn == pytest.approx(record.rig.wn / record.pace, rel=0.001)
        assert found.identification.response.time[0] > record.start
        assert [force.kind for force in found.identification.forces] == [ForceKind.FRICTION] * 2

    # A fast mode of a hundredth of the motion beside friction; one that a part of the record, one sample later, hides.
    @pytest.mark.slow
    @pytest.mark.parametrize("seed", [970065, 970045])
    def test_a_weak_mode_beside_friction_is_one(self, seed: int, tmp_path: Path) -> None:
        record = rigs.release("friction", 2, seed=seed)
        rigs.write(record, tmp_path / "release.csv")
        outcome = rigs.judged(record, analyse(tmp_path / "release.csv"))
        assert outcome.right
        assert abs(outcome.zeta) < 0.15

    @pytest.mark.slow
    def test_no_motion_is_computed_beyond_the_nyquist_frequency(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        # A fit to few samples put a pole at 25 times the sampling rate: its motion took minutes.
        turns = list[float]()

        def recorded(of: motion.Structures, count: int) -> motion.Motion:
            turns.append(float(np.max(np.abs(of.theta))))
            return motion.motion_of(of, count)

        search._found.cache_clear()
        monkeypatch.setattr(structure, "motion_of", recorded)
        rigs.write(rigs.release("bilinear", 2, seed=3000011), tmp_path / "release.csv")
        analyse(tmp_path / "release.csv")
        # A step of a fit may double a pole, and is then refused.
        assert turns
        assert max(turns) < 2 * np.pi

    @pytest.mark.slow
    def test_a_late_start_leaves_no_stretch_to_try(self, tmp_path: Path) -> None:
        # Masses that friction stops within a cycle: later starts that are tried end with the decay.
        record = rigs.release("friction", 2, seed=3000015)
        rigs.write(record, tmp_path / "release.csv")
        assert analyse(tmp_path / "release.csv").used


class TestSharedModes:
    @staticmethod
    def of(*hertz: float) -> Identification:
        time = np.arange(600) / 100
        values = sum(np.exp(-0.8 * time) * np.cos(2 * np.pi * each * time) for each in hertz)
        noise = 1e-3 * np.random.default_rng(1).standard_normal((1, time.size))
        return identify(as_response(time, values + noise, ["body"]))

    def test_what_one_decay_alone_shows_counts_against_it(self) -> None:
        odd, one, other = self.of(2.0, 7.0), self.of(1.2, 3.0), self.of(1.2, 3.0, 9.0)
        assert shared_modes([odd, one, other]) == pytest.approx([0.0, 1.0, 2 / 3])

    def test_a_lone_decay_shares_none(self) -> None:
        assert shared_modes([self.of(2.0), None]) == [0.0, 0.0]


def test_no_mode_is_followed_on_from_a_drift_in_the_first_samples() -> None:
    """A jolt that is gone in two samples is fitted by a pole that never turns: there are no cycles to follow."""
    turn = 0.6
    jolt = 10 * np.exp(-1.2 * np.arange(160))[None]
    values = jolt + 0.5 + 0.1 * np.random.default_rng(1).standard_normal(jolt.shape)
    record = Record(
        values=values,
        noise=noise_of(values),
        theta=np.array([-0.01 + 1j * turn]),
        amplitudes=np.ones((1, 1), complex),
        nuisances=np.zeros(1),
    )
    assert search._shifting(record, turn, 1000) is None


@pytest.mark.parametrize(("fast", "size", "beyond"), [(-1e-12 + 1j, 0.01, False), (-1e-12 + 1j, 2.0, True)])
def test_a_hum_that_never_fades_is_strong_by_what_it_is_within_the_record(
    fast: complex, size: float, *, beyond: bool
) -> None:
    """Two thousand samples of a slow mode are few steps; those of a hum of one radian a sample are many."""
    values = np.zeros((2, 2000))
    record = Record(
        values=values,
        noise=noise_of(values + 1.0),
        theta=np.array([-0.002 + 0.02j, fast]),
        amplitudes=np.array([[1.0], [size]]) * np.ones((2, 2), complex),
        nuisances=np.zeros(1),
    )
    assert choice.out_of_reach(record) is beyond


def test_forces_explain_what_is_longer_than_a_stretch_with_a_trace() -> None:
    """The end of a pendulum with drag looks like a linear decay; what is beside it there makes that no better."""
    time = np.arange(3000) / 100
    rng = np.random.default_rng(1)
    # A decay under drag alone: one over its amplitude rises along a line.
    bends = np.cos(7 * time) / (1 + 0.3 * time) + 1e-3 * rng.standard_normal(time.size)
    end = np.exp(-0.14 * time) * np.cos(7 * time) + 0.004 * np.exp(-0.26 * time) * np.cos(26 * time)
    longer = identify(as_response(time, bends[None], ["seat"]))
    found = identify(as_response(time, (end + 0.006 * rng.standard_normal(time.size))[None], ["seat"]))
    assert longer.forces
    assert any(one.remark.code is Reason.TRACE for one in found.considered)
    assert shows_more(longer, found) is explained_by_forces(longer) is True
    alone = replace(found, considered=())
    assert not shows_more(longer, alone)


def _followed(cycles: float, *others: float, seconds: float = 3.0, size: float = 1e-4) -> Identification:
    """Return what is identified in as many cycles of a mode with zeta .05, and of others beside it."""
    time = np.arange(100 * seconds) / 100
    speeds = 2 * np.pi * np.array([cycles, *others])[:, None] / seconds
    motion = np.sum(np.exp(-0.05 * speeds * time) * np.cos(speeds * time), axis=0)
    noise = size * np.random.default_rng(1).standard_normal(time.size)
    return identify(as_response(time, (motion + noise)[None], ["seat"]))


@pytest.mark.parametrize(
    ("end", "all_of_it", "preferred"),
    [((2.4,), 11.0, True), ((12.0,), 11.0, False), ((2.4,), 2.0, False), ((2.4, 17.0), 11.0, False)],
)
def test_a_few_cycles_of_another_mode_give_way_to_a_longer_decay(
    end: tuple[float, ...], all_of_it: float, preferred: bool
) -> None:
    """The last swings under friction are followed by a linear mode that is none; not so what is seen for longer."""
    longer, found = _followed(all_of_it, seconds=10.0, size=1e-3), _followed(*end)
    assert len(longer.modes) == 1
    assert len(found.modes) == len(end)
    assert with_few_cycles(found).tolist() == [each < 3 for each in end]
    assert shows_more(longer, found) is preferred


def test_few_cycles_before_a_dead_stop_give_way_to_forces_that_explain_all() -> None:
    """Their 9.09 Hz are none of 3.20 and 10.07 Hz, although they are better known than those of three cycles."""
    release = rigs.release("friction", 2, seed=980_016)
    time = np.arange(release.values.shape[1]) * (release.stamps[-1] / (release.values.shape[1] - 1))
    record = as_response(time, release.values, ["x1", "x2"])
    longer = identify(cut(record, start=release.start + 0.005, stop=release.stop))
    found = identify(cut(record, start=0.95, stop=1.235))
    assert longer.modes.wn == pytest.approx(release.rig.wn, rel=0.002)
    assert with_few_cycles(found).tolist() == [True]
    assert shows_more(longer, found)
    assert not shows_more(replace(longer, forces=()), found)


def test_a_start_that_is_earlier_has_not_the_few_cycles_of_the_end() -> None:
    """What was said of the fit to the end stays."""
    t = np.arange(1000) / 100
    few = (DecayDoubt.FEW_CYCLES, DecayDoubt.TOO_SHORT, DecayDoubt.FEW_SAMPLES)
    doubts = tuple(Remark(code, {"cycles": 1.0, "hertz": 2.0, "samples": 9, "modes": 2}) for code in few)
    (end, *_) = find_decays(as_response(t, np.where(t > 3, np.exp(3 - t) * np.sin(20 * (t - 3)), 0.0)[None], ["seat"]))
    end = replace(end, doubts=(*doubts, Remark(DecayDoubt.NONLINEAR, {"share": 0.1})))
    longer = _from(end, end.start - 1)
    assert longer.start == end.start - 1
    assert [doubt.code for doubt in longer.doubts] == [DecayDoubt.NONLINEAR]


def test_a_start_behind_the_hold_makes_no_longer_decay(monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.arange(1000) / 100
    record = as_response(t, np.where(t > 3, np.exp(3 - t) * np.sin(20 * (t - 3)), 0.0)[None], ["seat"])
    decays = find_decays(record)
    end = decays[0]
    monkeypatch.setattr("suspid.analysis.longer._later", lambda *_: iter(()))
    for start, is_longer in ((end.start + 0.02, False), (end.start - 0.02, True)):
        monkeypatch.setattr("suspid.analysis.longer._earlier", lambda *_, s=start: iter((replace(end, start=s),)))
        assert (longest(record, used_of(record, decays, end)) is not None) is is_longer


class TestTonesThatFade:
    """Two close modes of a frame; to a part that is too short, one of them is a tone."""

    @staticmethod
    def parts(*, rough: float = 0.0) -> tuple[Identification, Identification]:
        time = np.arange(6000) / 100
        first, second = (np.exp(-z * w * time) * np.cos(w * time) for w, z in ((9.0, 0.002), (9.4, 0.002)))
        rng = np.random.default_rng(1)
        other = rough * np.convolve(rng.standard_normal(time.size), np.ones(9) / 9, "same")
        values = np.array([first + 0.3 * second, 0.4 * first - second]) + 1e-3 * rng.standard_normal((2, time.size))
        record = as_response(time, values + other, ["x", "y"])
        whole, part = identify(record), identify(cut(record, stop=20.0))
        tone = Considered(pole=complex(part.modes.poles[0]), remark=Remark(Reason.TONE), removed=True)
        return whole, replace(part, modes=part.modes[1:], considered=(tone,))

    def test_are_modes_of_the_longer_decay_although_it_leaves_more_than_noise(self) -> None:
        whole, part = self.parts(rough=0.1)
        assert len(whole.modes) == 2
        assert np.max(whole.loudness) > 1
        assert tells_tones(whole, part)
        assert shows_more(whole, part)

    def test_without_a_tone_there_or_with_other_modes_it_tells_nothing_of_it(self) -> None:
        whole, part = self.parts()
        assert not tells_tones(whole, replace(part, considered=()))
        away = replace(part.considered[0], pole=part.considered[0].pole * 1.1)
        assert not tells_tones(whole, replace(part, considered=(away,)))
        assert not tells_tones(replace(whole, modes=whole.modes[:1]), part)
        assert whole.modes.wn_std is not None
        unsure = replace(whole.modes, covariance=1e12 * np.asarray(whole.modes.covariance))
        assert not tells_tones(replace(whole, modes=unsure), part)


@pytest.mark.parametrize("angle", [pytest.param(0.9, marks=pytest.mark.slow), 0.3])
def test_two_close_modes_of_a_frame_that_creeps_back(angle: float, tmp_path: Path) -> None:
    """They beat to the end of the record: no band rises above the others, and the creep is the largest event."""
    time = np.arange(0.0, 26.15, 0.005)
    since, creep = np.maximum(time - 2.05, 0.0), 0.04 * np.exp(-3 * time / time[-1])
    ends = ((np.cos(angle), 8.18, 0.0016), (np.sin(angle), 8.2716, 0.0048))
    one, other = (a * np.exp(-z * 2 * np.pi * f * since) * np.cos(2 * np.pi * f * since) for a, f, z in ends)
    path = tmp_path / "frame.csv"
    rows = np.stack([time, one + 0.15 * other + creep, 0.6 * other - 0.1 * one + creep], axis=1)
    np.savetxt(path, rows, delimiter=",", header="time [s],x [m],y [m]", comments="", fmt="%.9g")
    found = analyse(path)
    np.testing.assert_allclose(found.modes.wn / (2 * np.pi), [8.18, 8.2716], rtol=1e-3)
    np.testing.assert_allclose(found.modes.zeta, [0.0016, 0.0048], rtol=0.02)
    assert found.verdict.level > Level.DOUBTFUL


@pytest.mark.slow
def test_what_rises_where_modes_beat_is_no_other_event(tmp_path: Path) -> None:
    """Most of what looks like events is none; it is part of the decay."""
    time = np.arange(6745) / 391.015254
    since = time - 3.05303518
    ends = [(0.95443835, 14.087, 0.00325), (1.22485586, 15.422, 0.00389)]
    moves = sum(a * np.exp(-z * 2 * np.pi * f * since) * np.cos(2 * np.pi * f * since) for a, f, z in ends)
    values = np.where(since >= 0, moves, 0.0) + 0.0239 * np.random.default_rng(0).standard_normal(time.size)
    path = tmp_path / "beat.csv"
    np.savetxt(path, np.stack([time, values], axis=1), delimiter=",", header="time [s],x [m]", comments="", fmt="%.6g")
    found = analyse(path)
    np.testing.assert_allclose(found.modes.wn / (2 * np.pi), [14.087, 15.422], rtol=1e-3)
    np.testing.assert_allclose(found.modes.zeta, [0.00325, 0.00389], rtol=0.03)
    assert found.verdict.level > Level.DOUBTFUL
