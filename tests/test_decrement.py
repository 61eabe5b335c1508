"""The decrement of a motion as another meaning of the equivalent damping, in the interval of the slowest mode."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.forces import Force, ForceKind
from suspid.identification.nonlinear.linearised import _decrement, modes_of_structure
from suspid.identification.nonlinear.motion import Structures, motion_of
from suspid.identification.nonlinear.structure import evaluated

# Two modes of two masses, with a cubic spring from the first mass to the ground.
RIG = Structures(
    theta=np.array([[-0.01 + 0.3j, -0.02 + 0.8j]]),
    shapes=np.array([[[0.5 + 0j, 0.8 + 0j], [0.5 + 0j, -0.4 + 0j]]]),
    gains=np.array([[[0.02j], [0.02j]]]),
    forces=(Force(kind=ForceKind.CUBIC, channel=0, other=None),),
    scales=np.ones(1),
)
STATES = motion_of(RIG, 400).states[0]
VALUES = (RIG.shapes[0].T @ STATES).real + 1e-3 * np.random.default_rng(1).standard_normal((2, 400))
SAMPLES = np.arange(2000)
GIVEN = np.array([-0.001 + 0.05j, -0.004 + 0.2j])


def fit_of(envelope: Any) -> Any:
    """Return a fit in which the slowest mode has this envelope, and the other follows it."""
    states = envelope * np.exp(0.05j * SAMPLES)
    motion = SimpleNamespace(states=np.array([[states, 0.01 * states]]))
    return SimpleNamespace(motion=motion, amplitudes=np.ones((2, 1)), variance=np.array([1e-4]))


def test_of_an_exponential_it_is_the_exponent() -> None:
    np.testing.assert_allclose(_decrement(fit_of(np.exp(-0.001 * SAMPLES)), GIVEN), GIVEN, rtol=0, atol=1e-12)


def test_friction_falls_by_equal_steps() -> None:
    """From the middle of the first cycle to that of the last that is seen: friction stops the motion at last."""
    envelope = np.maximum(1 - SAMPLES / 1700, 1e-9)
    found = _decrement(fit_of(envelope), GIVEN)
    cycle = round(2 * np.pi / 0.05)
    end = 13 * cycle
    middle = np.interp([cycle / 2, end - cycle / 2], SAMPLES, envelope)
    assert found[0].real == pytest.approx(np.log(middle[1] / middle[0]) / (end - cycle), rel=0.01)
    assert found[0].imag == pytest.approx(0.05, rel=1e-6)
    assert found[1] == GIVEN[1]


def test_it_is_in_the_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    """As another end or start of the stretch is."""
    name = "suspid.identification.nonlinear.linearised._decrement"
    stds = []
    for share in (1.0, 1.2):
        monkeypatch.setattr(name, lambda _, exponents, share=share: exponents * np.array([share, 1.0]))
        record = Record(
            values=VALUES, noise=WhiteNoise(least=np.full(2, 1e-6)), theta=RIG.theta[0], amplitudes=RIG.shapes[0],
            nuisances=np.zeros(1),
        )  # fmt: skip
        modes, _, _ = modes_of_structure(
            evaluated(record, RIG, 0), timepts=np.arange(VALUES.shape[1]) / 100, channels=("one", "two")
        )
        assert modes.wn_std is not None
        stds.append(modes.wn_std)
    assert stds[1][0] > stds[0][0] + 0.1 * modes.wn[0]
    assert stds[1][1] == pytest.approx(stds[0][1])


def test_few_cycles_tell_none() -> None:
    brief = fit_of(np.exp(-0.002 * SAMPLES))
    brief.motion.states = brief.motion.states[:, :, :300]
    np.testing.assert_array_equal(_decrement(brief, GIVEN), GIVEN)
