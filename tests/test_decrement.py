"""The decrement of a motion as another meaning of the equivalent damping, in the interval of the slowest mode."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from suspid.identification.nonlinear.linearised import _decrement

SAMPLES = np.arange(2000)
GIVEN = np.array([-0.001 + 0.05j, -0.004 + 0.2j])


def fit_of(envelope: Any) -> Any:
    """Return a fit in which the slowest mode has this envelope, and the other follows it."""
    states = envelope * np.exp(0.05j * SAMPLES)
    return SimpleNamespace(motion=SimpleNamespace(states=np.array([[states, 0.01 * states]])))


def test_of_an_exponential_it_is_the_exponent() -> None:
    np.testing.assert_allclose(_decrement(fit_of(np.exp(-0.001 * SAMPLES)), GIVEN), GIVEN, rtol=0, atol=1e-12)


def test_friction_falls_by_equal_steps() -> None:
    """From the middle of the first cycle to that of the last, 126 samples each, which follow other damping."""
    envelope = 1 - SAMPLES / 2500
    found = _decrement(fit_of(envelope), GIVEN)
    cycle = round(2 * np.pi / 0.05)
    middle = np.interp([cycle / 2, 2000 - cycle / 2], SAMPLES, envelope)
    assert found[0].real == pytest.approx(np.log(middle[1] / middle[0]) / (2000 - cycle), rel=0.01)
    assert found[0].imag == pytest.approx(0.05, rel=1e-6)
    assert found[1] == GIVEN[1]


def test_few_cycles_tell_none() -> None:
    brief = fit_of(np.exp(-0.002 * SAMPLES))
    brief.motion.states = brief.motion.states[:, :, :300]
    np.testing.assert_array_equal(_decrement(brief, GIVEN), GIVEN)
