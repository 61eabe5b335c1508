"""Which stretch of a record is identified: a clear decay, or none."""

from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.signal import lfilter

from suspid import Level, Settings, analyse, free_decay
from suspid.analysis.choice import explains, holds
from suspid.analysis.past_clipping import past_clipping
from suspid.decays import Decay
from suspid.identification import by_likelihood, identify_linear
from suspid.records import as_response, cut, late_start
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import DecayDoubt, Note, Remark
from validation import cars


def people_in_a_parked_car(seed: int) -> tuple[RealArray, RealArray]:
    """Acceleration of a car at rest in which people move now and then, by a sensor of coarse steps."""
    rng = np.random.default_rng(seed)
    values = np.zeros((2, 3000))
    at = 200
    while at < 2750:
        length = int(rng.uniform(30, 160))
        memory = rng.uniform(0.8, 0.98)
        size = rng.uniform(1, 4)
        drawn = rng.standard_normal((2, length))
        drawn[1] += 0.5 * drawn[0]
        values[:, at : at + length] += (
            size * np.hanning(length) * lfilter([np.sqrt(1 - memory**2)], [1, -memory], drawn)
        )
        at += length + int(rng.uniform(60, 250))
    return np.arange(3000) / 100, np.round(values * 4 + 0.05 * rng.standard_normal(values.shape)) / 4


@pytest.mark.slow
def test_one_of_many_events_that_looks_like_a_short_decay_is_a_coincidence() -> None:
    time, values = people_in_a_parked_car(2)
    found = analyse(as_response(time, values, ["x", "z"]))
    assert DecayDoubt.COMPANY in {doubt.code for decay in found.decays for doubt in decay.doubts}
    assert not found.used
    assert not len(found.modes)
    assert next(str(note) for note in found.notes if note.code is Note.WHOLE_RECORD).startswith("no clear decay")


def decay_of(seed: int, *, rest: int) -> control.TimeResponseData:
    """Decay of a car after a kick at its wheel, after samples of rest: every coordinate moves most later than that."""
    rng = np.random.default_rng(seed)
    moved = free_decay(cars.random_car(rng), np.arange(2000 - rest) / 500, initial_state={"v_tire": 1.0})
    values = np.hstack([np.zeros((3, rest)), moved.y.reshape(3, -1)])
    noise = 0.1 if rest == 0 else 0.01
    values += noise * np.sqrt(np.mean(values**2, axis=1))[:, None] * rng.standard_normal(values.shape)
    return as_response(np.arange(2000) / 500, values, ["tire", "chassis", "seat"])


@pytest.mark.slow
def test_a_decay_whose_first_swings_are_clipped_begins_after_them() -> None:
    time = np.arange(4000) / 1000
    swing = np.where(time < 1, 0.0, np.exp(-2.0 * (time - 1)) * np.sin(40 * (time - 1)))
    values = np.clip(swing + 1e-3 * np.random.default_rng(1).standard_normal(time.size), -0.7, 0.7)
    found = analyse(as_response(time, values[None], ["body"]))
    (used,) = found.used
    clipped = time[np.flatnonzero(np.abs(values) >= 0.7)[-1]]
    assert clipped < used.start < clipped + 0.2
    assert not {doubt.code for doubt in used.doubts} & {DecayDoubt.CLIPPED, DecayDoubt.NOT_IDENTIFIED}
    np.testing.assert_allclose(found.modes.wn, [np.hypot(2, 40)], rtol=1e-3)
    np.testing.assert_allclose(found.modes.zeta, [2 / np.hypot(2, 40)], rtol=0.02)


@pytest.mark.parametrize(("until", "moved"), [(0.8, True), (2.6, False)])
def test_only_clipped_samples_in_the_first_part_of_a_decay_are_left_out(until: float, moved: bool) -> None:
    time = np.arange(4000) / 1000
    values = np.exp(-0.3 * time) * np.sin(40 * time)
    values = np.where(time < until, np.clip(values, -0.4, 0.4), np.clip(values, -0.39, 0.39))
    decay = Decay(
        start=0.0,
        stop=3.999,
        rank=1,
        kind=None,
        level=40.0,
        cycles=20.0,
        strength=90.0,
        wn=np.array([40.0]),
        zeta=np.array([0.01]),
        doubts=(Remark(DecayDoubt.CLIPPED, {"samples": 9}), Remark(DecayDoubt.CUT_OFF)),
    )
    record = as_response(time, np.where(time < until, values, 0.5 * values)[None], ["body"])
    later = past_clipping(record, decay)
    clipped = time[np.flatnonzero(np.abs(record.y[0]) >= 0.4)[-1]]
    assert bool(clipped < later.start < clipped + 0.01) is moved
    assert [doubt.code for doubt in later.doubts] == (
        [DecayDoubt.CUT_OFF] if moved else [DecayDoubt.CLIPPED, DecayDoubt.CUT_OFF]
    )


class TestLaterThanTheFirstSample:
    @pytest.mark.parametrize("seed", [4, 11, 19])
    def test_a_decay_from_the_first_sample_on_is_used_whole(self, seed: int) -> None:
        record = decay_of(seed, rest=0)
        assert late_start(as_signal(record)) is not None
        found = analyse(record)
        assert not found.used
        assert found.verdict.level is Level.SOUND
        assert len(found.modes) == 3

    def test_the_candidates_that_were_asked_for_are_those_of_its_scalogram(self) -> None:
        found = analyse(decay_of(4, rest=0), settings=Settings(candidates=(3.0, 5.0)))
        assert found.identification.steps.candidates == (3.0, 5.0)

    @pytest.mark.parametrize("rest", [10, 50])
    def test_friction_is_not_looked_for_across_a_release(self, rest: int, monkeypatch: pytest.MonkeyPatch) -> None:
        sought = []

        def find_forces(values: RealArray, **_: object) -> None:
            sought.append(values.shape[1])

        monkeypatch.setattr(by_likelihood, "find_forces", find_forces)
        found = analyse(decay_of(4, rest=rest))
        assert found.used[0].start == pytest.approx(rest / 500, abs=0.004)
        assert max(sought, default=0) < 2000


class TestPolesOfTheWholeInAPart:
    """What holds of a decay from its first sample on holds of any part in which all modes are still seen."""

    @staticmethod
    def record(*, changed: float = 1.0, noise: float = 0.01) -> control.TimeResponseData:
        """A mode at 20 rad/s, and one at 90 rad/s that is gone after 1 s; behind 0.5 s the first one is another."""
        time = np.arange(1000) / 200
        omega = np.where(time < 0.5, 20.0, 20.0 * changed)
        slow = np.exp(-0.4 * time) * np.cos(np.cumsum(omega) / 200)
        fast = np.exp(-8.0 * time) * np.sin(90 * time)
        drawn = noise * np.random.default_rng(8).standard_normal((2, time.size))
        return as_response(time, np.array([slow + fast, slow - 0.5 * fast]) + drawn, ["a", "b"])

    def test_all_are_seen(self) -> None:
        record = self.record()
        assert holds(identify_linear(record), cut(record, start=0.05))

    def test_one_is_gone(self) -> None:
        record = self.record()
        assert len(identify_linear(record).modes) == 2
        assert not holds(identify_linear(record), cut(record, start=2.0))

    def test_the_part_begins_before(self) -> None:
        """The samples of both are compared, not none."""
        record = self.record()
        part, later = (identify_linear(cut(record, start=start)) for start in (0.0, 0.015))
        assert explains(later, part)
        left = as_signal(held(later, "residual"))
        more = as_response(left.timepts, 1.5 * left.values, left.channels)
        assert not explains(replace(later, residual=more), part)

    def test_what_is_left_before_a_part_does_not_tell(self) -> None:
        record = self.record()
        whole, part = (identify_linear(cut(record, start=start)) for start in (0.0, 0.1))
        left = as_signal(held(whole, "residual"))
        for before, explained in ((True, True), (False, False)):
            louder = np.where((left.timepts < 0.1) == before, 3.0, 1.0) * left.values
            again = replace(whole, residual=as_response(left.timepts, louder, left.channels))
            assert explains(again, part) is explained

    @pytest.mark.parametrize(("stop", "explained"), [(4.0, True), (2.0, False)])
    def test_most_of_the_part_is_compared(self, stop: float, *, explained: bool) -> None:
        record = self.record()
        begun, part = identify_linear(cut(record, start=0.0, stop=stop)), identify_linear(cut(record, start=0.1))
        assert explains(begun, part) is explained

    def test_the_part_is_of_another_frequency(self) -> None:
        """The fit to the whole lies between; the part alone tells the frequencies apart."""
        record = self.record(changed=1.005)
        assert not holds(identify_linear(record), cut(record, start=0.5))
