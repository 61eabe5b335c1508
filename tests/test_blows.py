"""Hammer blows: the channel of the hammer and inputs that do not move are left out; blows that bounce are one event."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

from suspid import Settings, analyse, find_decays
from suspid.analysis.blows import blows_of
from suspid.analysis.idle import idle
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import Level, Note

RATE, OVERSAMPLED, BLOW = 1651.0, 20, 0.003
WN, ZETA, GAINS = 2 * np.pi * np.array([19.8, 187.0, 560.0]), (0.018, 0.014, 0.02), (0.02, 0.05, 0.03)


def struck(seed: int, *, blows: tuple[float, ...] = (0.01, 0.052), rattle: float = 0.0) -> tuple[RealArray, RealArray]:
    """Return times, and an input that is not connected, the acceleration of a beam, and the force of the hammer.

    The force is sampled twenty times finer; the second blow is a third of the first. What rattles for .06 s is noise.
    """
    rng = np.random.default_rng(seed)
    fine = np.arange(int(2.5 * RATE) * OVERSAMPLED) / (OVERSAMPLED * RATE)
    force, motion = np.zeros(fine.size), np.zeros(fine.size)
    for size, start in zip((80.0, 25.0), blows, strict=False):
        inside = (fine >= start) & (fine < start + BLOW)
        force += size * np.where(inside, np.sin(np.pi * (fine - start) / BLOW) ** 2, 0.0)
    for wn, zeta, gain in zip(WN, ZETA, GAINS, strict=True):
        system = ([[0, 1], [-(wn**2), -2 * zeta * wn]], [[0], [1]], [[-gain * wn**2, -2 * gain * zeta * wn]], [[gain]])
        motion += lsim(system, force, fine)[1]
    t, force, motion = (values[::OVERSAMPLED] for values in (fine, force, motion))
    size = float(np.std(motion))
    motion = motion + rattle * np.where(t > blows[0], np.exp((blows[0] - t) / 0.06), 0.0) * rng.standard_normal(t.size)
    motion = motion + 0.003 * size * rng.standard_normal(t.size)
    force = force + 0.2 * rng.standard_normal(t.size)
    return t, np.stack([30.18 + 5e-4 * rng.standard_normal(t.size), motion, force])


def written(path: Path, t: RealArray, values: RealArray) -> Path:
    np.savetxt(
        path, np.column_stack([t, *values]), fmt="%.6g", delimiter=",", header="t [s],in 1,in 2,in 3", comments=""
    )
    return path


@pytest.mark.slow
def test_joined_tests_use_what_each_uses_alone(tmp_path: Path) -> None:
    """The channel of the hammer was in the joint fit, and the stretch began with the blow."""
    files = [written(tmp_path / f"{seed}.csv", *struck(seed)) for seed in (1, 3)]
    both = analyse(files)
    assert both.modes.channels == ("in 2",)
    assert both.repeats is not None
    for file, (start, stop) in zip(files, both.repeats.spans, strict=True):
        alone = analyse(file).identification.response.time
        assert (start, stop) == pytest.approx((alone[0], alone[-1]), abs=2 / RATE)
    assert len(both.modes) == 3
    assert both.modes.wn_std is not None
    assert np.all(np.abs(both.modes.wn - WN) < 4 * both.modes.wn_std)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_beam_that_is_struck_twice(seed: int, tmp_path: Path) -> None:
    found = analyse(written(tmp_path / "struck.csv", *struck(seed)))
    assert found.modes.channels == ("in 2",)
    assert found.verdict.level is Level.SOUND
    assert found.modes.wn_std is not None
    assert found.modes.zeta_std is not None
    assert np.all(np.abs(found.modes.wn - WN) < 4 * found.modes.wn_std)
    assert np.all(np.abs(found.modes.zeta - ZETA) < 4 * found.modes.zeta_std)
    said = {note.code: note.numbers["channel"] for note in found.notes if "channel" in note.numbers}
    assert said == {Note.BLOW_CHANNEL: "in 3", Note.IDLE_CHANNEL: "in 1"}
    assert next(note for note in found.notes if note.code is Note.BLOW_CHANNEL).numbers["blows"] == 2


def test_the_decay_begins_after_the_last_blow() -> None:
    t, values = struck(3)
    (decay, *_) = find_decays(as_response(t, values[1:2], ["in 2"]))
    assert not decay.doubts
    assert 0.052 < decay.start < 0.08
    assert decay.wn.size == 3


@pytest.mark.slow
@pytest.mark.parametrize("rattle", [0.1, 1.0])
def test_what_rattles_after_the_blows_dies_first(rattle: float, tmp_path: Path) -> None:
    found = analyse(written(tmp_path / "struck.csv", *struck(1, rattle=rattle)))
    assert found.modes.wn_std is not None
    assert abs(found.modes.wn[0] - WN[0]) < 4 * found.modes.wn_std[0]
    assert found.verdict.level >= Level.CARE


def test_channels_that_are_named_are_used(tmp_path: Path) -> None:
    path = written(tmp_path / "struck.csv", *struck(1))
    found = analyse(path, settings=Settings(channels=("in 2", "in 3"), start=0.08))
    assert found.modes.channels == ("in 2", "in 3")


class TestBlows:
    t = np.arange(4000) / 1000
    rings = np.exp(-3 * t) * np.sin(40 * t)

    def test_motion_that_dies_soon_is_no_blow(self) -> None:
        """Damped by .3, it goes a third as far the other way; it is as short as a blow."""
        soon = np.exp(-0.3 * 300 * self.t) * np.sin(300 * self.t)
        assert blows_of(np.stack([self.rings, soon])).tolist() == [0, 0]

    def test_what_pushes_alone_is_none(self) -> None:
        """Where nothing goes on for longer, it may be the motion."""
        pulse = np.where(self.t < 0.01, 1.0, 0.0)
        assert blows_of(pulse[None]).tolist() == [0]
        assert blows_of(np.stack([self.rings, -pulse])).tolist() == [0, 1]

    def test_many_pulses_are_none(self) -> None:
        pulses = np.where(np.arange(4000) % 500 == 0, 1.0, 0.0)
        assert blows_of(np.stack([self.rings, pulses])).tolist() == [0, 0]


class TestIdle:
    t = np.arange(4000) / 1000
    rings = np.exp(-3 * t) * np.sin(40 * t)

    @pytest.mark.parametrize("colour", [0.0, 0.9])
    @pytest.mark.parametrize("hum", [0.0, 5.0])
    def test_noise_and_hum_are_idle(self, colour: float, hum: float) -> None:
        from scipy.signal import lfilter

        out = []
        for seed in range(40):
            noise = np.random.default_rng(seed).standard_normal((2, 4000))
            noise = lfilter([1.0], [1.0, -colour], noise, axis=1) + hum * np.sin(2 * np.pi * 50 * self.t + seed)
            out.append(idle(np.stack([self.rings + 1e-3 * noise[0], noise[1]])))
        assert not np.any(np.array(out)[:, 0])
        # One in twenty is kept by chance.
        assert np.mean(np.array(out)[:, 1]) > 0.75

    def test_what_tells_of_a_mode_is_not(self) -> None:
        """A quarter of the amplitude that three standard deviations of noise have; the fit sees it."""
        other = np.exp(-5 * self.t) * np.sin(130 * self.t)
        for seed in range(20):
            noise = 0.01 * np.random.default_rng(seed).standard_normal((2, 4000))
            assert not idle(np.stack([self.rings, 0.03 * other]) + noise)[1]

    def test_what_may_tell_of_a_mode_is_kept_more_often_than_not(self) -> None:
        """A fit sees 7 of 10 of this size, of one standard deviation of the noise."""
        other, kept = np.exp(-5 * self.t) * np.sin(130 * self.t), 0
        for seed in range(40):
            noise = 0.01 * np.random.default_rng(seed).standard_normal((2, 4000))
            kept += not idle(np.stack([self.rings, 0.013 * other]) + noise)[1]
        assert kept > 20

    def test_what_moves_elsewhere_is_not(self) -> None:
        """Where one part alone moves far more than the calm ones, the others tell what is steady: not this."""
        moves = np.sin(40 * self.t) * np.repeat([0.2, 1.0, 1.0, 1.0], 1000)
        moves[2000:2100] *= 1.03
        jump = np.where(np.arange(4000) // 100 == 20, 6.0, 1.0)
        noise = np.random.default_rng(1).standard_normal((2, 4000))
        assert not idle(np.stack([moves + 0.1 * noise[0], jump * noise[1]])).any()

    def test_where_all_moves_throughout_none_is(self) -> None:
        noise = np.random.default_rng(1).standard_normal((3, 4000))
        assert not idle(noise).any()
        assert not idle(np.stack([np.sin(40 * self.t), noise[0]])).any()

    def test_what_moves_by_itself_is_not(self) -> None:
        late = np.where(self.t > 2, np.exp(6 - 3 * self.t), 0.0) * np.sin(70 * self.t)
        noise = 1e-3 * np.random.default_rng(1).standard_normal((2, 4000))
        assert not idle(np.stack([self.rings, late]) + noise).any()


def knocked(seed: int) -> tuple[RealArray, RealArray]:
    """Return times and motion of a mass on a spring that stiffens, knocked six times within a quarter of a second.

    ``q'' + .036 125 q' + 125^2 q (1 + .15 q^2) = 0`` in steps of a tenth of a sample.
    """
    t, rng, step = np.arange(3200) / 1600, np.random.default_rng(seed), 1 / 16000
    times = [0.02, *(0.02 + np.sort(rng.uniform(0.02, 0.25, 5)))]
    kicks = [125.0, *rng.uniform(-40, 40, 5)]
    q, v, out = 0.0, 0.0, []
    for k in range(10 * t.size):
        if times and k * step >= times[0]:
            v += kicks.pop(0)
            times.pop(0)
        v += step * (-0.036 * 125 * v - 125**2 * q * (1 + 0.15 * q * q))
        q += step * v
        if k % 10 == 0:
            out.append(q)
    return t, np.array(out) + 1e-3 * rng.standard_normal(t.size)


@pytest.mark.slow
def test_a_later_part_is_used_where_the_first_is_no_decay(tmp_path: Path) -> None:
    t, values = knocked(5)
    path = tmp_path / "knocked.csv"
    np.savetxt(path, np.column_stack([t, values]), fmt="%.6g", delimiter=",", header="t [s],a", comments="")
    found = analyse(path)
    assert len(found.modes) == 1
    assert found.verdict.level is Level.CARE
    (used,) = found.used
    assert used.start > 0.22
    (dependence,) = found.identification.amplitude_dependence
    # The first term of the series of Lindstedt and Poincaré.
    law = 125 * (1 + 3 / 8 * 0.15 * dependence.amplitude**2)
    assert np.max(np.abs(dependence.wn / law - 1)) < 1e-3
