"""What a sensor leaves beside a strong mode is a trace and no mode; weak modes that are well known stay."""

from __future__ import annotations

import numpy as np
import pytest

from suspid import as_record, identify
from suspid.units import RealArray
from suspid.words import Reason

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
    # It stays in the fit.
    assert found.whiteness[0] < 0.1


def test_what_is_asked_for_is_returned() -> None:
    found = identify(as_record(decay(0.004, noise=0.006), timepts=TIME), modes=2)
    np.testing.assert_allclose(found.modes.wn, [7, 26], rtol=0.01)
