"""Encoders that write a row whenever they count on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import Recording, analyse, clean
from suspid.cleaning.on_change import evenly
from suspid.recordings import RawChannel
from suspid.words import Defect

Real = NDArray[np.float64]
WN, ZETA = 8.07, 0.012


def swing(time: Real) -> Real:
    """A pendulum that is let go, in counts."""
    return np.asarray(180 * np.exp(-ZETA * WN * time) * np.cos(WN * np.sqrt(1 - ZETA**2) * time))


def written(*, until: float = 25.0, lost: int = 0, count: float = 0.0026, tick: float = 1e-6) -> RawChannel:
    """Rows when the count changes, some of which are lost, stamped in ticks."""
    fine = np.arange(0, until, 2e-5)
    counts = np.round(swing(fine))
    rows = np.flatnonzero(np.diff(counts, prepend=counts[0]))
    kept = np.delete(rows, np.random.default_rng(1).choice(len(rows) - 40, lost, replace=False))
    stamps = tick * np.round(fine[kept] / tick)
    return RawChannel(name="arm", unit="rad", timepts=stamps, values=count * counts[kept], rate=None)


def test_the_motion_between_the_rows_is_within_a_tenth_of_a_count() -> None:
    (even,), (finding,) = evenly([written()])
    assert finding.kind is Defect.ON_CHANGE
    assert np.ptp(np.diff(even.timepts)) < 1e-9
    off = even.values / 0.0026 - swing(even.timepts)
    assert np.max(np.abs(off)) < 0.6
    assert np.sqrt(np.mean(off**2)) < 0.1


def test_counts_that_are_lost_leave_the_others() -> None:
    channel = written(lost=20)
    assert np.max(np.abs(np.diff(channel.values))) > 0.005
    (even,), (finding,) = evenly([channel])
    assert finding.kind is Defect.ON_CHANGE
    assert np.sqrt(np.mean((even.values / 0.0026 - swing(even.timepts)) ** 2)) < 0.2


def test_the_first_command_finds_its_mode(tmp_path: Path) -> None:
    channel = written(until=12.0)
    rows = "".join(f"{time:.6f},{value:.6f}\n" for time, value in zip(channel.timepts, channel.values, strict=True))
    (tmp_path / "arm.csv").write_text("time [s],arm [rad]\n" + rows)
    found = analyse(tmp_path / "arm.csv")
    assert len(found.modes) == 1
    assert found.modes.wn_std is not None
    assert found.modes.wn[0] == pytest.approx(WN, abs=4 * found.modes.wn_std[0] + 1e-3)
    assert found.modes.zeta[0] == pytest.approx(ZETA, rel=0.05)


class TestOthersAreLeftAlone:
    def left(self, *channels: RawChannel) -> bool:
        out, findings = evenly(channels)
        return not findings and all(one is other for one, other in zip(out, channels, strict=True))

    def test_even_rows_of_a_coarse_encoder(self) -> None:
        time = np.arange(4000) / 200
        assert self.left(replace(written(), timepts=time, values=np.round(swing(time))))

    def test_a_ramp_of_single_counts_in_even_rows(self) -> None:
        time = np.arange(400) / 200
        assert self.left(replace(written(), timepts=time, values=np.arange(400.0)))

    def test_uneven_rows_of_a_sensor(self) -> None:
        time = np.cumsum(np.random.default_rng(1).exponential(0.01, 4000))
        assert self.left(replace(written(), timepts=time, values=swing(time)))

    def test_a_switch(self) -> None:
        time = np.cumsum(np.random.default_rng(1).exponential(0.3, 1500))
        assert self.left(replace(written(), timepts=time, values=np.arange(1500.0) % 2))

    def test_counts_of_which_many_are_lost_or_repeated(self) -> None:
        assert self.left(written(lost=400))
        one, again = written(), np.arange(0, written().values.size, 10)
        times, values = (np.insert(each, again, each[again]) for each in (one.timepts, one.values))
        assert self.left(replace(one, timepts=times, values=values))

    def test_steps_that_are_no_counts(self) -> None:
        one = written()
        third = np.where(np.arange(one.values.size) % 3, 1.0, 1.3)
        assert self.left(replace(one, values=np.cumsum(third * np.sign(np.diff(one.values, prepend=9.0)))))
        steps = np.random.default_rng(1).uniform(0.3, 3.0, one.values.size) * np.sign(np.diff(one.values, prepend=9.0))
        assert self.left(replace(one, values=np.cumsum(steps)))

    def test_a_ramp_whose_clock_jitters(self) -> None:
        time = (np.arange(400) + np.random.default_rng(1).uniform(-0.15, 0.15, 400)) / 200
        assert self.left(replace(written(), timepts=time, values=np.arange(400.0)))

    def test_rows_an_hour_after_the_motion(self) -> None:
        one = written()
        times, values = np.append(one.timepts, 3600.0), np.append(one.values, one.values[-1] + 0.0026)
        assert self.left(replace(one, timepts=times, values=values))

    def test_rows_that_are_too_few_or_not_in_order(self) -> None:
        short = written()
        assert self.left(replace(short, timepts=short.timepts[:99], values=short.values[:99]))
        assert self.left(replace(short, timepts=short.timepts[::-1].copy()))

    def test_rows_of_several_channels_and_of_a_stated_rate(self) -> None:
        one = written()
        assert self.left(one, replace(one, name="other"))
        assert self.left(replace(one, rate=100.0))


def test_stamps_in_ms_and_a_heartbeat_leave_the_motion() -> None:
    for tick, within in ((1e-6, 0.1), (1e-3, 0.5)):
        one = written(tick=tick)
        beats = np.searchsorted(one.timepts, np.arange(1.0, 25.0))
        beats = beats[beats < one.values.size]
        times, values = np.insert(one.timepts, beats, 0.0), np.insert(one.values, beats, 0.0)
        at = beats + np.arange(beats.size)
        times[at], values[at] = times[at - 1], values[at - 1]
        (even,), _ = evenly([replace(one, timepts=times, values=values)])
        late = even.timepts > 2
        off = even.values / 0.0026 - swing(even.timepts)
        assert np.sqrt(np.mean(off[late] ** 2)) < within


def test_a_swing_that_hardly_dies_is_read() -> None:
    fine = np.arange(0, 8, 2e-5)
    counts = np.round(180 * np.exp(-0.008 * fine) * np.cos(8 * fine))
    rows = np.flatnonzero(np.diff(counts, prepend=counts[0]))
    channel = RawChannel(name="arm", unit="", timepts=fine[rows], values=counts[rows], rate=None)
    (even,), _ = evenly([channel])
    off = even.values - 180 * np.exp(-0.008 * even.timepts) * np.cos(8 * even.timepts)
    assert np.max(np.abs(off)) < 0.05


def test_in_a_rest_nothing_swings_on() -> None:
    """Two swings with a rest of ten seconds between them: the count is held."""
    first, rest = written(until=3.0), 10.0
    later = written(until=12.0)
    times = np.concatenate([first.timepts, 3.0 + rest + later.timepts])
    start = first.values[-1] + 0.0026
    values = np.concatenate([first.values, start + later.values - later.values[0]])
    (even,), _ = evenly([replace(first, timepts=times, values=values)])
    held = (even.timepts > first.timepts[-1]) & (even.timepts < 3.0 + rest)
    assert np.all(np.abs(even.values[held] - first.values[-1]) < 0.51 * 0.0026)


@pytest.mark.parametrize("scale", [1e-310, 1e305])
def test_numbers_at_the_ends_of_what_there_is(scale: float) -> None:
    """Counts of any size are read; what is further off than there are rows is no count."""
    one = written()
    values = scale * np.round(one.values / 0.0026)
    (even,), _ = evenly([replace(one, values=values)])
    assert np.sqrt(np.mean((even.values / scale - swing(even.timepts)) ** 2)) < 0.1
    values[len(values) // 2] = 1e308
    (even,), _ = evenly([replace(one, values=values)])
    assert (even.values is values) == (scale < 1)


def test_a_rate_that_is_given_replaces_the_stamps() -> None:
    found = clean(Recording(title="swing", channels=(written(),)), fs=100.0)
    assert not [finding for finding in found.findings if finding.kind is Defect.ON_CHANGE]


def test_cleaning_says_so() -> None:
    cleaned = clean(Recording(title="swing", channels=(written(),)))
    (said,) = (finding for finding in cleaned.findings if finding.kind is Defect.ON_CHANGE)
    assert "each row is one count of 0.0026 from the last" in said.text
    assert said.check.level.label == "note"
