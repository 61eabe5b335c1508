"""Modes that stand for a force at the start of a decay: when later starts are tried, and which are taken."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import control
import numpy as np
import pytest

from suspid import ModalSet, analyse, as_record, identify
from suspid.analysis.forced_start import FLASH_OVER, SAME_POLE, behind_blow, freed, later_starts, without_start
from suspid.identification import Considered, Identification
from suspid.records import as_response, cut
from suspid.units import RealArray
from suspid.words import Level, Reason, Remark

TIME = np.arange(1000) / 100
START, NOISE = 5.0, 0.01
# Periods of 0.8 s and 0.4 s, and of a mode that may stand for a force.
WN = np.array([2 * np.pi / 0.8, 2 * np.pi / 0.4, 30.0])
# Motion that goes on until the decay begins: 100 times the noise.
DRIVEN = np.sin(40 * TIME)


def identified(
    record: control.TimeResponseData, wn: RealArray, std: Sequence[float], *, channels: Sequence[str] = ("a",)
) -> Identification:
    """Return what these functions read of an identification from `START` on: modes, residual and noise."""
    part = cut(record, start=START)
    residual = as_response(np.asarray(part.time), np.zeros((len(channels), len(part.time))), channels)
    modes = ModalSet.from_wn_zeta(
        wn, np.full(len(wn), 0.1), wn_std=np.asarray(std) * wn, zeta_std=0.01 * np.ones(len(wn))
    )
    fields = {"noise_std": np.full(len(channels), NOISE), "halves": np.zeros(len(modes))}
    return cast(
        "Identification", SimpleNamespace(modes=modes, considered=(), _residual=residual, _response=residual, **fields)
    )


def starts(before: RealArray, std: Sequence[float] = (0.001, 0.001, 0.05), **more: Sequence[str]) -> list[float]:
    """Return how much later the decay is tried where the record moves before as given."""
    values = np.atleast_2d(np.where(TIME < START, before, np.exp(START - TIME)))
    record = as_response(TIME, values, ["a", "b"][: len(values)])
    return list(later_starts(record, identified(record, WN, std, **more)))


class TestLaterStarts:
    def test_are_a_quarter_to_one_and_a_half_periods_of_the_slowest_known_mode_later(self) -> None:
        assert starts(DRIVEN) == pytest.approx(0.8 * np.array([0.25, 0.5, 1.0, 1.5]))
        # The slowest mode itself may be the force.
        assert starts(DRIVEN, (0.05, 0.001, 0.001)) == pytest.approx(0.4 * np.array([0.25, 0.5, 1.0, 1.5]))

    @pytest.mark.parametrize("std", [(0.001, 0.001, 0.01), (0.05, 0.05, 0.05)])
    def test_are_none_where_all_modes_are_known_or_none_is(self, std: Sequence[float]) -> None:
        assert starts(DRIVEN, std) == []

    @pytest.mark.parametrize(("times", "driven"), [(3.0, False), (30.0, True)])
    def test_noise_is_no_motion(self, times: float, driven: bool) -> None:
        noise = times * NOISE * np.random.default_rng(1).standard_normal(TIME.size)
        assert bool(starts(noise)) is driven

    @pytest.mark.parametrize(("begin", "end", "driven"), [(2.0, 1.0, True), (0.45, 0.0, True), (0.18, 0.0, False)])
    def test_a_bump_is_shorter_than_a_fifth_of_a_period(self, begin: float, end: float, driven: bool) -> None:
        """Times are in periods before the decay."""
        moves = (START - 0.8 * begin < TIME) & (START - 0.8 * end > TIME)
        assert bool(starts(np.where(moves, DRIVEN, 0.0))) is driven

    def test_one_channel_that_moves_is_enough_if_it_was_fitted(self) -> None:
        one = np.array([0 * DRIVEN, DRIVEN])
        assert starts(one, channels=("a", "b"))
        assert starts(one, channels=("b",))
        assert not starts(one, channels=("a",))

    def test_are_none_where_the_record_begins_with_the_decay(self) -> None:
        record = as_response(TIME[500:], np.exp(START - TIME[None, 500:]), ["a"])
        assert not list(later_starts(record, identified(record, WN, (0.001, 0.001, 0.05))))


class TestFreed:
    """The third mode stands for a force."""

    @pytest.mark.parametrize(
        ("later", "free"),
        [
            (WN[:2] * [1.02, 0.98], True),
            (WN[:2] * [1.0, 1.2], False),
            (WN[:1], False),
            (WN, False),
            (WN[1:], False),
        ],
    )
    def test_the_known_modes_are_left_and_no_others(self, later: RealArray, free: bool) -> None:
        record = as_response(TIME, DRIVEN[None], ["a"])
        found = identified(record, WN, (0.001, 0.001, 0.05))
        assert freed(found, identified(record, later, [0.001] * len(later))) is free


class TestBehindBlow:
    @pytest.mark.parametrize(
        ("reason", "removed"), [(Reason.BEGINNING, True), (Reason.BEGINNING, False), (Reason.DRIFT, True)]
    )
    def test_is_when_the_slowest_pole_of_a_blow_has_fallen(self, reason: Reason, removed: bool) -> None:
        rates = (40.0, 200.0)
        blow = tuple(Considered(pole=complex(-rate, 0), remark=Remark(reason), removed=removed) for rate in rates)
        late = behind_blow(cast("Identification", SimpleNamespace(considered=blow)))
        of_blow = reason is Reason.BEGINNING and removed
        assert late == (pytest.approx(FLASH_OVER[-1] / 40.0) if of_blow else None)


class TestWithoutStart:
    def test_names_the_modes_that_a_later_start_does_without(self) -> None:
        time = np.arange(600) / 100
        slow, fast = np.exp((-1 + 12j) * time).real, np.exp((-9 + 40j) * time).real
        noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
        both, one = (identify(as_record(motion + noise, timepts=time)) for motion in (slow + fast, slow))
        assert (len(both.modes), len(one.modes)) == (2, 1)
        lost = [c for c in without_start(both, one).considered if c.remark.code is Reason.OF_START]
        assert [c.removed for c in lost] == [False]
        assert abs(lost[0].pole - (-9 + 40j)) < SAME_POLE * 41
        assert not [c for c in without_start(one, one).considered if c.remark.code is Reason.OF_START]


@pytest.mark.parametrize("periods", [0.5, 0.8, 1.1])
def test_one_mass_that_is_let_go_slowly_has_one_mode(periods: float, tmp_path: Path) -> None:
    """The force that holds it falls to zero over a good part of a period; the response is that of a convolution."""
    wn, zeta, step = 2 * np.pi * 5.0, 0.04, 1e-3
    time = np.arange(0.0, 4.0, step)
    force = np.clip(1 - (time - 1.0) / (periods / 5.0), 0.0, 1.0)
    wd = wn * np.sqrt(1 - zeta**2)
    since = time - 1.0
    impulse = np.where(since >= 0, np.exp(-zeta * wn * since) * np.sin(wd * since) / wd, 0.0)
    # What was held is at rest: only the change of the force moves it.
    change = np.convolve(wn**2 * (force - 1.0), impulse[1000:])[: time.size] * step
    motion = (1.0 + change)[::5] + 2e-3 * np.random.default_rng(1).standard_normal(time.size // 5)
    path = tmp_path / "slow.csv"
    np.savetxt(path, np.stack([time[::5], motion], axis=1), delimiter=",", header="time [s],z [m]", comments="")
    found = analyse(path)
    assert found.modes.wn == pytest.approx([wn], rel=0.01)
    assert found.modes.zeta == pytest.approx([zeta], rel=0.15)
    assert found.verdict.level > Level.DOUBTFUL
