"""Speeds that a logger holds between the values that it is sent."""

from __future__ import annotations

import numpy as np
import pytest

from suspid import find_drives
from suspid.greybox.held_speed import released
from suspid.recordings import RawChannel
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words.drives import DriveRemark

TIME = np.arange(6000) / 100


def channel(values: RealArray) -> RawChannel:
    return RawChannel(name="speed", unit="m/s", timepts=TIME, values=values, rate=None)


def held(speed: RealArray, sent: RealArray) -> RealArray:
    """Return the last value that was sent, at each time."""
    return np.asarray(np.interp(sent, TIME, speed)[np.searchsorted(sent, TIME + 1e-9) - 1])


class TestReleased:
    @pytest.mark.parametrize("jitter", [0.0, 0.03])
    def test_a_straight_speed_is_straight(self, jitter: float) -> None:
        """However the moments jitter at which it comes: each value stands at its moment, to a sample."""
        speed = 10 + TIME / 10
        sent = np.arange(60.0)
        sent[1:] += jitter * np.random.default_rng(2).uniform(-1, 1, 59)
        free = released(channel(held(speed, sent)))
        assert len(free.values) == 60
        np.testing.assert_allclose(free.values, 10 + free.timepts / 10, atol=0.1 * 0.0101)

    def test_a_value_that_is_sent_again_stands_again(self) -> None:
        """At a constant speed the values between are no straight line to the next change."""
        speed = np.where((TIME >= 20) & (TIME < 30), 12.0, 10 + TIME / 10)
        free = released(channel(held(speed, np.arange(60.0))))
        np.testing.assert_allclose(free.timepts, np.arange(60.0), atol=1e-9)
        assert np.all(free.values[20:30] == 12.0)

    @pytest.mark.parametrize("step", [0.01, 0.1, 1.0])
    def test_rounded_speeds_are_not_held(self, step: float) -> None:
        one = channel(np.round((20 + 3 * np.sin(TIME / 3) + np.sin(TIME)) / step) * step)
        assert released(one) is one

    def test_lost_samples(self) -> None:
        """A logger that writes the speed beside other channels leaves gaps."""
        values = held(10 + TIME / 10, np.arange(60.0))
        values[::3] = np.nan
        free = released(channel(values))
        np.testing.assert_allclose(free.values, 10 + free.timepts / 10, atol=0.1 * 0.0101)


def test_drives_have_the_speed_of_the_car() -> None:
    """Half a second late, the speed would be off by 0.05 m/s throughout."""
    body = np.random.default_rng(1).standard_normal(len(TIME))
    rows = np.vstack([body, held(10 + TIME / 10, np.arange(60.0))])
    found = find_drives(as_response(TIME, rows, ("az [m/s2]", "speed [m/s]")))
    inside = slice(200, 5700)  # At its ends a drive has no middles of blocks to either side.
    np.testing.assert_allclose(found.speeds[0][inside], (10 + TIME / 10)[inside], atol=0.01)


@pytest.mark.parametrize(("speed", "shakes", "said"), [(0.0, 3.0, True), (0.0, 0.1, False), (20.0, 3.0, False)])
def test_a_dead_channel_is_said(speed: float, shakes: float, said: bool) -> None:
    """A car that shakes moves; one that only idles may stand."""
    rows = np.vstack([shakes * np.random.default_rng(1).standard_normal(len(TIME)), np.full(len(TIME), speed)])
    found = find_drives(as_response(TIME, rows, ("az [m/s2]", "speed [m/s]")))
    assert (DriveRemark.DEAD_SPEED in [one.remark.code for one in found.remarks]) == said
