"""Records that end with free motion after a drive."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from suspid import Identification, Level, Settings, analyse, identify
from suspid.analysis.free_end import at_free_end
from suspid.analysis.other_parts import other_part
from suspid.analysis.used import Used
from suspid.records import as_response

Real = NDArray[np.float64]

WN, ZETA = 59.7, 0.014


def shaken(*stops: float, seed: int = 1) -> tuple[Real, Real]:
    """Return times and motion near resonance of a shaker that runs for 1.2 s up to each of some times."""
    time = np.arange(1200) / 100
    drives = np.any([(time > stop - 1.2) & (time < stop) for stop in stops], axis=0)
    pole = np.exp((-ZETA + 1j * np.sqrt(1 - ZETA**2)) * WN / 100)
    motion = lfilter([1.0], np.poly([pole, pole.conj()]).real, np.where(drives, np.sin(57.5 * time), 0.0))
    return time, motion + 0.02 * np.std(motion) * np.random.default_rng(seed).standard_normal(time.size)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_shaker_near_resonance_that_is_switched_off_twice(seed: int, tmp_path: Path) -> None:
    time, motion = shaken(2.2, 7.0, seed=seed)
    table, path = np.column_stack([time, motion]), tmp_path / "shaker.csv"
    np.savetxt(path, table, delimiter=",", header="time [s],body [m/s^2]", comments="", fmt="%.7g")
    found = analyse(path)
    assert found.modes.wn == pytest.approx([WN], rel=2e-3)
    assert found.modes.zeta == pytest.approx([ZETA], rel=0.05)
    assert found.verdict.level > Level.DOUBTFUL


class TestFreeEnd:
    NONE = identify(as_response(np.arange(400) / 100, np.random.default_rng(3).standard_normal((1, 400)), ["a"]))

    def end(self, time: Real, motion: Real, found: Identification = NONE) -> Used | None:
        record = as_response(time, motion[None], ["a"])
        return at_free_end(record, Used(record=record, decays=(), used=(), notes=()), found, Settings())

    def test_it_begins_where_the_shaker_is_switched_off(self) -> None:
        used = self.end(*shaken(2.2, 7.0))
        assert used is not None
        assert used.identification is not None
        assert used.record.time[0] == pytest.approx(7.0, abs=0.1)
        assert used.identification.modes.wn == pytest.approx([WN], rel=2e-3)

    def test_it_is_all_that_is_tried_where_the_motion_is_one_smooth_wave(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("suspid.analysis.other_parts.OTHER_PARTS", ())
        time, motion = shaken(2.2, 7.0)
        record = as_response(time, motion[None], ["a"])
        used = Used(record=record, decays=(), used=(), notes=())
        found = [other_part(record, used, self.NONE, Settings(), wave=wave) for wave in (True, False)]
        assert found[0] is not None
        assert found[0].record.time[0] == pytest.approx(7.0, abs=0.1)
        assert found[1] is None

    def test_there_is_none_where_it_runs_to_the_end(self) -> None:
        assert self.end(*shaken(2.2, 12.5)) is None

    def test_nothing_is_sought_where_modes_are_found(self) -> None:
        time, motion = shaken(2.2, 7.0)
        late = identify(as_response(time[710:], motion[None, 710:], ["a"]))
        assert len(late.modes) == 1
        assert self.end(time, motion, late) is None
