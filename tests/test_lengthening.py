"""A mode whose frequency shifts by many widths of its line is one mode, from the first sample to the last."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from suspid import analyse, as_record, identify
from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.driven import maximize
from suspid.identification.nonlinear.feedback import Bent, Record
from suspid.identification.nonlinear.lengthening import at_full_rate
from suspid.units import RealArray
from suspid.words import Level

# Frequency of small swings [Hz], sampling rate [Hz], standard deviation of the noise [rad].
SMALL, RATE, NOISE = 0.905, 30.0, 0.01


def pendulum(angle: float, duration: float, *, seed: int, order: int = 0) -> tuple[RealArray, RealArray]:
    """Return times and samples of a pendulum with viscous and quadratic damping, as an angle or its rate."""
    times = np.arange(0, duration, 1 / RATE)
    path = path_of(angle, times)
    noise = np.random.default_rng(seed).standard_normal(times.size)
    return times, path.y[order] + NOISE * (2 * np.pi * SMALL if order else 1) * noise


def path_of(angle: float, times: RealArray) -> Any:
    """Return the path of that pendulum, with its turning points as events."""
    omega = 2 * np.pi * SMALL

    def motion(_: float, state: RealArray) -> list[float]:
        turned, rate = state
        return [rate, -(omega**2) * np.sin(turned) - 0.0016 * omega * rate - 0.0012 * abs(rate) * rate]

    def rate_of(_: float, state: RealArray) -> float:
        return float(state[1])

    last = float(times[-1]) + 1 / RATE
    start = [angle, 0.0]
    return solve_ivp(motion, (0, last), start, t_eval=times, rtol=1e-9, atol=1e-9, method="DOP853", events=rate_of)


def pendulum_turns(angle: float, duration: float) -> RealArray:
    """Return the times at which that pendulum turns back [s]."""
    return np.asarray(path_of(angle, np.array([0.0, duration])).t_events[0])


def exact(angle: RealArray) -> RealArray:
    """Return the frequency of a pendulum of that amplitude [rad], by the complete elliptic integral [Hz]."""
    return np.asarray(SMALL * np.pi / 2 / ellipk(np.sin(angle / 2) ** 2))


class TestFrequencyOfAPendulum:
    @pytest.mark.parametrize(("angle", "duration"), [(1.5, 60.0), (1.3, 90.0)])
    def test_follows_the_elliptic_integral(self, angle: float, duration: float) -> None:
        times, samples = pendulum(angle, duration, seed=3)
        found = identify(as_record(samples, timepts=times))
        assert len(found.modes) == 1
        (dependence,) = found.amplitude_dependence
        # Its sine is a cubic spring but for a fifth power, which is 4 % of the stiffness at these angles.
        shift = exact(dependence.amplitude) / (dependence.wn / (2 * np.pi)) - 1
        np.testing.assert_allclose(shift, 0.0, rtol=0, atol=0.0025)
        # It is that of the cycles within each span.
        turned = pendulum_turns(angle, duration)
        cycles = np.diff(np.interp(dependence.spans, turned, np.arange(len(turned)) / 2), axis=1)[:, 0]
        frequency = cycles / np.diff(dependence.spans, axis=1)[:, 0]
        np.testing.assert_allclose(dependence.wn / (2 * np.pi), frequency, rtol=5e-4, atol=0)
        assert np.ptp(dependence.wn) > 0.06 * found.modes.wn[0]
        # The value of the table of modes holds the frequencies of the amplitudes about the middle.
        apart = found.modes.wn[0] - 2 * np.pi * float(exact(np.array([dependence.holds_at]))[0])
        assert found.modes.wn_std is not None
        assert abs(apart) < 2 * found.modes.wn_std[0]

    def test_of_a_long_record_that_is_thinned_on_the_way(self) -> None:
        times, samples = pendulum(1.5, 360.0, seed=4)
        found = identify(as_record(samples, timepts=times))
        assert len(found.modes) == 1
        (dependence,) = found.amplitude_dependence
        np.testing.assert_allclose(exact(dependence.amplitude), dependence.wn / (2 * np.pi), rtol=0.002, atol=0)

    def test_of_the_rate_of_a_gyroscope(self) -> None:
        times, samples = pendulum(1.4, 60.0, seed=5, order=1)
        found = identify(as_record(samples, timepts=times))
        assert len(found.modes) == 1
        (dependence,) = found.amplitude_dependence
        # The rate swings by the amplitude times the frequency, give or take what the third multiple adds.
        shift = exact(dependence.amplitude / dependence.wn) / (dependence.wn / (2 * np.pi)) - 1
        np.testing.assert_allclose(shift, 0.0, rtol=0, atol=0.02)


def test_the_first_command_finds_it(tmp_path: Path) -> None:
    times, samples = pendulum(1.5, 60.0, seed=6)
    path = tmp_path / "pendulum.csv"
    np.savetxt(path, np.column_stack([times, samples]), delimiter=",", header="time,angle", comments="", fmt="%.5f")
    found = analyse(path)
    assert len(found.modes) == 1
    assert found.verdict.level is Level.CARE


def test_a_mode_without_forces_is_followed_at_full_rate() -> None:
    """What seemed to shift may be linear once more of it is seen: no force is left, in means or in samples."""
    values = np.exp(-0.004 * np.arange(1200)) * np.cos(0.2 * np.arange(1200))
    values = (values + 1e-3 * np.random.default_rng(1).standard_normal(1200))[None]
    record = Record(
        values=values,
        noise=WhiteNoise(least=np.full(1, 1e-12)),
        theta=np.array([-0.004 + 0.2j]),
        amplitudes=np.array([[0.5]], complex),
        nuisances=np.zeros(1),
    )
    thinned = record.thinned(2, 1200)
    drive = replace(thinned.empty(), theta=np.array([-0.009 + 0.41j]), gains=np.zeros((1, 0), complex))
    linear = maximize(thinned.values, drive, thinned.noise, steps=20)
    assert linear is not None
    found = at_full_rate(record, Bent(fit=linear, forces=(), order=0), 2, 0.2)
    assert found is not None
    np.testing.assert_allclose(found.fit.theta, [-0.004 + 0.2j], rtol=1e-3)
