"""A structure that is pushed by hand: the decay behind the push is used, not what looks like a decay beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import Level, Settings, analyse, as_record, identify
from suspid.analysis.far_larger import far_larger
from suspid.analysis.fewer_channels import multiples_alone, with_fewer_channels
from suspid.analysis.used import Used
from suspid.model import ModalSet
from suspid.records import as_response, cut
from suspid.units import RealArray


def knocked(knock: float) -> tuple[Used, Used, Used]:
    """Return a record of a decay of size 1 and a knock later on as used in whole, and its parts of each."""
    times, rng = np.arange(0, 30, 0.02), np.random.default_rng(1)
    values = 1e-4 * rng.standard_normal((1, times.size))
    for start, size, wn, zeta in ((1.0, 1.0, 6.0, 0.05), (26.0, knock, 60.0, 0.05)):
        since = np.maximum(times - start, 0.0)
        values[0] += (times >= start) * size * np.exp(-zeta * wn * since) * np.sin(wn * since)
    record = as_response(times, values, ["seat"])
    parts = [cut(record, start=a, stop=b) for a, b in ((0.0, 30.0), (1.02, 20.0), (26.02, 30.0))]
    used = [Used(record=part, decays=(), used=(), notes=(), identification=identify(part)) for part in parts]
    return used[0], used[1], used[2]


class TestOfTwoDoubtfulDecays:
    @pytest.mark.parametrize(("size", "larger"), [(0.03, True), (0.8, False)])
    def test_one_that_holds_far_more_of_the_motion_is_used(self, size: float, larger: bool) -> None:
        whole, decay, knock = knocked(size)
        # Energy goes with the square of the size over zeta wn, which is 10 times as large for the knock.
        assert (1 / size**2 * 10 > 100) == larger
        assert far_larger(whole.record, [knock, decay]) is (decay if larger else knock)

    def test_a_channel_that_a_part_has_not_does_not_count(self) -> None:
        """One that stands still in a decay was left out of it."""
        whole, decay, knock = knocked(0.03)
        steps = np.floor(whole.record.time / 7)[None]
        both = as_response(whole.record.time, np.concatenate([steps, whole.record.y[:1]]), ["asked", "seat"])
        assert far_larger(both, [knock, decay]) is decay

    def test_the_first_stays_where_it_is_the_larger(self) -> None:
        whole, decay, knock = knocked(0.03)
        assert far_larger(whole.record, [decay, knock]) is decay


def ringing(*wn: float) -> ModalSet:
    """Return the modes of a record of decays at these natural frequencies."""
    times = np.arange(0, 12, 0.01)
    values = sum(np.exp(-0.02 * each * times) * np.cos(each * times) for each in wn)
    noise = 1e-3 * np.random.default_rng(2).standard_normal(times.size)
    return identify(as_record(values + noise, timepts=times)).modes


class TestChannelsLeftOut:
    @pytest.mark.parametrize(
        ("fewer", "alone"),
        [((12.0,), True), ((18.1,), True), ((6.0, 12.0), False), ((9.0,), False), ((12.0, 9.0), False)],
    )
    def test_multiples_of_a_mode_that_others_show_are_none(self, fewer: tuple[float, ...], alone: bool) -> None:
        assert multiples_alone(ringing(6.0, 12.0), ringing(*fewer)) == alone


@pytest.mark.parametrize(("multiple", "used"), [(2.0, False), (1.6, True)])
def test_a_channel_that_shows_a_multiple_alone_is_not_kept_alone(multiple: float, used: bool) -> None:
    """Two channels of a heavy, doubtful decay; alone, one shows a clear one at another frequency."""
    time, rng = np.arange(600) / 200, np.random.default_rng(3)

    def ring(wn: float, zeta: float, shape: tuple[float, ...]) -> Used:
        values = np.outer(shape, np.exp(-zeta * wn * time) * np.cos(wn * np.sqrt(1 - zeta**2) * time))
        record = as_response(time, values + 0.03 * rng.standard_normal(values.shape), ["x", "y"][: len(shape)])
        return Used(record=record, decays=(), used=(), notes=(), identification=identify(record))

    both = ring(3 * np.pi, 0.5, (1.0, 0.7))
    assert both.identification is not None
    assert both.identification.verdict.level is Level.DOUBTFUL
    alone = ring(multiple * float(both.identification.modes.wn[0]), 0.02, (1.0,))
    kept = with_fewer_channels(both.record, both, Settings(), lambda *_: alone)
    assert (len(kept.record.output_labels) == 1) is used


def tower(seed: int) -> RealArray:
    """Return times and three accelerations of a slender tower after a push: it softens, and its top rings at 10 Hz."""
    rng, times = np.random.default_rng(seed), np.arange(0, 22.5, 0.02)
    slow, fast = 2 * np.pi * 1.08, 62.8

    def motion(t: float, state: RealArray) -> list[float]:
        x, v, a, b = state
        push = 60 * np.exp(-(((t - 2.2) / 0.12) ** 2))
        soft = slow**2 * x * (1 - 0.25 * min(x * x / 0.04, 1.0))
        bent = push - soft - 0.07 * slow * v - 0.6 * abs(v) * v
        return [v, bent, b, push * 8 * (np.sin(70 * t) + 0.5) - fast**2 * a - 0.14 * fast * b]

    path = solve_ivp(motion, (0, times[-1]), [0.0] * 4, t_eval=times, max_step=0.01).y
    x, top = 9.8 * path[0] / np.max(np.abs(path[0])), 4 * path[2] / np.max(np.abs(path[2]))
    sway = np.convolve(np.cumsum(rng.standard_normal(times.size)), np.ones(8) / 8, "same")
    sway -= np.convolve(sway, np.ones(60) / 60, "same")
    values = np.array([x + top, 0.04 * sway / sway.std() + 0.3 * top, 9.75 + x**2 / 30 + 0.2 * top])
    knock = np.where(times > 21, 0.35 * np.exp(-11.9 * (times - 21)) * np.sin(119 * (times - 21)), 0.0)
    values += np.outer([0.0, 1.0, 0.5], knock) + 0.02 * rng.standard_normal(values.shape)
    return np.column_stack([times, *values])


@pytest.mark.slow
def test_a_decay_that_begins_like_a_pulse_is_tried_from_later_on(tmp_path: Path) -> None:
    path = tmp_path / "tower.csv"
    np.savetxt(path, tower(0), delimiter=",", header="time,x,y,z", comments="", fmt="%.4f")
    found = analyse(path)
    assert len(found.modes) == 1
    # It softens by at most a quarter in stiffness.
    assert 1.08 * np.sqrt(0.75) < found.modes.wn[0] / (2 * np.pi) < 1.08
