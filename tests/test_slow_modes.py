"""A weak slow mode beside strong fast ones: it is no steady tone where the record goes on, and else that is said."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from suspid import analyse, as_record, identify
from suspid.analysis.begun_tones import with_begun_tones
from suspid.identification import Considered, Identification
from suspid.identification.verdict import verdict_of
from suspid.records import as_response, cut
from suspid.units import RealArray
from suspid.words import Level, ModeCheck, Reason, Remark

RATE, RELEASE = 2000.0, 1.0
HZ, ZETA = np.array([3.3, 21.0, 58.0]), np.array([0.005, 0.012, 0.015])
SLOW = 0.2


def struck(
    seconds: float, *, seed: int = 0, noise: float = 0.1, hum: float = 0.0, rate: float = RATE, slow: float = SLOW
) -> tuple[RealArray, RealArray]:
    """Return times and the motion of a beam that is struck after a rest; ``hum`` is of the slow mode's frequency."""
    time = np.arange(0.0, RELEASE + seconds, 1 / rate)
    since = np.maximum(time - RELEASE, 0.0)
    w = 2 * np.pi * HZ[:, None]
    sizes = np.array([slow, 1.0, 1.0])[:, None]
    motion = sizes * np.exp(-ZETA[:, None] * w * since) * np.sin(w * np.sqrt(1 - ZETA[:, None] ** 2) * since)
    turns = hum * np.sin(2 * np.pi * HZ[0] * time)
    white = noise * np.random.default_rng(seed).standard_normal(time.size)
    return time, np.sum(motion[0 if not hum else 1 :], axis=0) + turns + white


def written(path: Path, time: RealArray, motion: RealArray) -> Path:
    np.savetxt(
        path, np.stack([time, motion], axis=1), delimiter=",", header="time [s],tip [m]", comments="", fmt="%.8g"
    )
    return path


@pytest.mark.parametrize("seed", range(3))
def test_it_is_found_where_the_record_goes_on_after_the_fast_ones(seed: int, tmp_path: Path) -> None:
    found = analyse(written(tmp_path / "beam.csv", *struck(6.0, seed=seed)))
    assert found.verdict.level > Level.DOUBTFUL
    np.testing.assert_allclose(found.modes.wn / (2 * np.pi), HZ, rtol=2e-3)
    np.testing.assert_allclose(found.modes.zeta, ZETA, rtol=0.25)


@pytest.mark.parametrize("seed", [0, 2])
def test_a_start_a_few_samples_before_the_blow_adds_no_modes(seed: int, tmp_path: Path) -> None:
    time, motion = struck(8.0, seed=seed, noise=0.05, rate=1000.0, slow=0.1)
    found = analyse(written(tmp_path / "beam.csv", time, motion))
    assert found.verdict.level > Level.DOUBTFUL
    np.testing.assert_allclose(found.modes.wn / (2 * np.pi), HZ, rtol=2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_a_hum_that_was_there_before_stays_a_tone(seed: int, tmp_path: Path) -> None:
    found = analyse(written(tmp_path / "hum.csv", *struck(6.0, seed=seed, hum=0.2)))
    assert found.verdict.level > Level.DOUBTFUL
    assert not any(check.remark.code is ModeCheck.FADING_TONES for check in found.verdict.checks)
    np.testing.assert_allclose(found.modes.wn / (2 * np.pi), HZ[1:], rtol=2e-3)


def test_what_a_short_record_shows_of_it_calls_for_care(tmp_path: Path) -> None:
    found = analyse(written(tmp_path / "short.csv", *struck(1.5, noise=0.08)))
    assert found.verdict.level is Level.CARE
    (said,) = [check for check in found.verdict.checks if check.remark.code is ModeCheck.FADING_TONES]
    assert str(said).startswith("A slow mode may be missing: motion at 3.")


def of_part(hum: float, *, first: float = 0.0) -> Identification:
    time, motion = struck(1.0, noise=0.16, hum=hum)
    record = as_response(time, motion[None], ["tip"])
    part = identify(cut(record, start=RELEASE))
    return with_begun_tones(part, cut(record, start=first))


class TestBegun:
    def tones(self, found: Identification) -> list[Remark]:
        return [one.remark for one in found.considered if one.removed and one.remark.code is Reason.TONE]

    def test_what_begins_with_the_decay(self) -> None:
        (tone,) = self.tones(of_part(0.0))
        assert tone.numbers == {"begun": True}

    def test_what_was_there_before(self) -> None:
        (tone,) = self.tones(of_part(0.2))
        assert not tone.numbers

    def test_two_cycles_before_do_not_tell(self) -> None:
        (tone,) = self.tones(of_part(0.0, first=RELEASE - 2.0 / HZ[0]))
        assert not tone.numbers

    def test_a_hum_that_jumps_in_phase_is_another(self) -> None:
        time, motion = struck(1.0, noise=0.16, hum=0.2)
        other, _ = struck(1.0, noise=0.0)
        turned = 0.2 * (np.sin(2 * np.pi * HZ[0] * other + 2.0) - np.sin(2 * np.pi * HZ[0] * other))
        record = as_response(time, (motion + np.where(other < RELEASE, turned, 0.0))[None], ["tip"])
        (tone,) = self.tones(with_begun_tones(identify(cut(record, start=RELEASE)), record))
        assert tone.numbers == {"begun": True}


@pytest.fixture(scope="module")
def found() -> Identification:
    time, motion = struck(6.0)
    return identify(cut(as_response(time, motion[None], ["tip"]), start=RELEASE))


class TestSaid:
    @pytest.mark.parametrize(("tones", "level"), [(2, Level.CARE), (3, Level.DOUBTFUL)])
    def test_as_many_tones_that_begin_with_a_decay_as_modes(
        self, found: Identification, tones: int, level: Level
    ) -> None:
        begun = Considered(pole=complex(0, 30.0), remark=Remark(Reason.TONE, {"begun": True}), removed=True)
        verdict = verdict_of(replace(found, considered=(begun,) * tones))
        codes = {ModeCheck.FADING_TONES, ModeCheck.BEGUN_TONES}
        assert [check.level for check in verdict.checks if check.remark.code in codes] == [level]

    def test_a_tone_that_fades(self, found: Identification) -> None:
        fades = Considered(pole=complex(0, 30.0), remark=Remark(Reason.TONE, {"share": 0.114}), removed=True)
        assert fades.reason == "a slow mode or a tone that fades: it loses 11.4 % within the record"
        verdict = verdict_of(replace(found, considered=(fades,)))
        assert verdict.level is Level.CARE


@pytest.mark.parametrize(("nepers", "fades"), [(0.02, False), (0.11, True)])
def test_a_pole_fades_if_it_loses_more_than_sources_of_hum_do(nepers: float, fades: bool) -> None:
    time = np.arange(2000) / 200
    # So much noise that the decay is known to five standard deviations: too few for a mode that loses so little.
    noise = 1.8 * nepers * np.random.default_rng(1).standard_normal(time.size)
    slow = np.exp(-nepers * time / time[-1]) * np.cos(9 * time)
    values = np.exp(-2 * time) * np.cos(40 * time) + slow + noise
    found = identify(as_response(time, values[None], ["tip"]))
    (tone,) = [one.remark for one in found.considered if one.remark.code is Reason.TONE]
    assert ("share" in tone.numbers) is fades


@pytest.mark.parametrize(("size", "level"), [(1.0, Level.DOUBTFUL), (6.0, Level.CARE)])
def test_a_tone_that_fades_and_moves_more_than_all_modes_is_what_was_recorded(size: float, level: Level) -> None:
    """Of the energies over ten seconds, the tone has 4.5 and the mode 0.4 times the square of its size."""
    time = np.arange(2000) / 200
    motion = size * np.exp((-0.6 + 60j) * time).imag + np.exp((-0.012 + 9j) * time).imag
    found = identify(as_record(motion + 0.3 * np.random.default_rng(1).standard_normal(time.size), timepts=time))
    (said,) = [check for check in found.verdict.checks if check.remark.code is ModeCheck.FADING_TONES]
    assert said.level is level
