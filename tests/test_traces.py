"""What a sensor leaves beside a strong mode is a trace and no mode; weak modes that are well known stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from suspid import as_record, identify
from suspid.identification.noise import noise_of
from suspid.identification.selection import select
from suspid.identification.traces import traces
from suspid.units import RealArray
from suspid.words import Level, ModeCheck, Reason

TIME = np.arange(3000) / 100


def decay(size: float, *, noise: float, seed: int = 1) -> RealArray:
    """Return a mode at 7 rad/s and zeta .02, with another of a size at 26 rad/s and zeta .01."""
    motion = np.exp(-0.14 * TIME) * np.cos(7 * TIME) + size * np.exp(-0.26 * TIME) * np.cos(26 * TIME)
    return motion + noise * np.random.default_rng(seed).standard_normal(TIME.size)


@pytest.mark.parametrize(
    ("size", "noise", "modes", "trace"),
    [(0.004, 0.006, 1, True), (0.004, 0.0002, 2, False), (0.2, 0.3, 2, False)],
)
def test_weak_and_hardly_known(size: float, noise: float, modes: int, trace: bool) -> None:
    found = identify(as_record(decay(size, noise=noise), timepts=TIME))
    assert len(found.modes) == modes
    reasons = [one.remark.code for one in found.considered if one.removed]
    assert reasons == ([Reason.TRACE] if trace else [])
    # It stays in the fit, and calls for care.
    assert found.whiteness[0] < 0.1
    said = [check for check in found.verdict.checks if check.remark.code is ModeCheck.TRACES]
    assert [check.level for check in said] == [Level.CARE] * trace
    assert all("1 trace (4.1" in str(check.remark) for check in said)


def test_several_channels_show_the_shape_of_what_is_weaker() -> None:
    """It has 3e-4 of the energy of the strongest mode."""
    channels = np.array([decay(0.02, noise=0.03, seed=k) for k in (1, 2, 3)])
    assert len(identify(as_record(channels, timepts=TIME)).modes) == 2
    alone = identify(as_record(channels[1], timepts=TIME))
    assert len(alone.modes) == 1
    assert [one.remark.code for one in alone.considered if one.removed] == [Reason.TRACE]


@pytest.mark.parametrize(
    ("channels", "size", "trace"),
    [(1, 0.025, True), (1, 0.06, False), (3, 0.008, True), (3, 0.025, False)],
)
@pytest.mark.parametrize("known", [True, False])
def test_the_share_that_makes_a_trace(channels: int, size: float, trace: bool, known: bool) -> None:
    """The energy of the other mode is about half of the square of its size, as it fades twice as fast."""
    values = np.array([decay(size, noise=1e-3, seed=k) for k in range(channels)])
    values -= values.mean(axis=1, keepdims=True)
    selection = select(values, noise=noise_of(values))
    modes = identify(as_record(values, timepts=TIME)).modes
    assert modes.covariance is not None
    assert modes.zeta_std is not None
    factor = 1.0 if known else (0.7 * modes.zeta[1] / (1.96 * modes.zeta_std[1])) ** 2
    rough = replace(modes, covariance=factor * modes.covariance)
    assert traces(selection, rough).tolist() == [False, trace and not known]


def test_what_is_asked_for_is_returned() -> None:
    found = identify(as_record(decay(0.004, noise=0.006), timepts=TIME), modes=2)
    np.testing.assert_allclose(found.modes.wn, [7, 26], rtol=0.01)


@pytest.mark.parametrize(("part", "trace"), [(3, True), (1, False)])
def test_a_frequency_that_is_hardly_known_is_enough(part: int, trace: bool) -> None:
    """The variance of the imaginary part of one of two poles is that of a frequency known to a third."""
    values = decay(0.01, noise=1e-3)[None]
    values -= values.mean()
    modes = identify(as_record(values, timepts=TIME)).modes
    assert modes.covariance is not None
    covariance = modes.covariance.copy()
    covariance[part, part] = (modes.wn[part // 2] / 3 / 1.96) ** 2
    selection = select(values, noise=noise_of(values))
    assert traces(selection, replace(modes, covariance=covariance)).tolist() == [False, trace]


def test_what_falls_fast_has_little_energy_however_large_it_begins() -> None:
    """It has a tenth of the first amplitude and falls in a fiftieth of the time: 2e-4 of the energy."""
    values = decay(0.0, noise=1e-3) + 0.1 * np.exp(-7 * TIME) * np.cos(40 * TIME)
    values = (values - values.mean())[None]
    modes = identify(as_record(values, timepts=TIME)).modes
    assert modes.covariance is not None
    assert modes.zeta_std is not None
    factor = (0.7 * modes.zeta[1] / (1.96 * modes.zeta_std[1])) ** 2
    rough = replace(modes, covariance=factor * modes.covariance)
    assert traces(select(values, noise=noise_of(values)), rough).tolist() == [False, True]
