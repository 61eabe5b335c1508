"""A mode that changes with its amplitude is one mode, not a steady tone and a decay beside it."""

import numpy as np
import pytest

from suspid import Identification, identify
from suspid.records import as_response

TIME = np.arange(500) / 40.5
WN = 12.4


def found(least: float, constant: float, shift: float, channels: int) -> tuple[Identification, float, float]:
    """Identify a swing whose damping ends; also return its mean frequency and damping ratio by their definition.

    Beside it, in other directions, are two modes. Within a band the fit is linear: no forces are looked for.
    """
    size = least + (1 - least) * np.exp(-TIME / constant)
    phase = np.cumsum(WN * (1 + shift * (1 - size))) * TIME[1]
    swing = size * np.cos(phase)
    beside = [(0.1, -0.05, 8.86, 1.0, 0.03), (0.2, -0.07, 9.57, 2.0, 0.05)]
    rest = [a * np.exp(rate * TIME) * np.cos(w * TIME + p) + share * swing for a, rate, w, p, share in beside]
    values = np.array([swing, *rest])[:channels]
    values += 0.015 * np.random.default_rng(1).standard_normal(values.shape)
    record = as_response(TIME, values, list("yxz")[:channels])
    turned = float(phase[-1] - phase[0])
    return identify(record, band_hz=(0.1, 19.0)), turned / TIME[-1], -float(np.log(size[-1])) / turned


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize(("least", "constant", "shift"), [(0.6, 3, 0.01), (0.5, 3, 0.02), (0.5, 2, 0.015)])
def test_poles_that_decay_together_are_one_mode(least: float, constant: float, shift: float, channels: int) -> None:
    modes, wn, zeta = found(least, constant, shift, channels)
    assert len(modes.modes) == channels
    # Its poles alone are a tone and a part of it.
    assert modes.modes.wn[-1] == pytest.approx(wn, rel=2e-3)
    assert modes.modes.zeta[-1] == pytest.approx(zeta, rel=0.15)
    # What one pole leaves is said, and widens the interval to the truth.
    assert modes.loudness[-1] > 3
    assert modes.verdict.level.label == "care"
    assert modes.modes.zeta_std is not None
    assert abs(modes.modes.zeta[-1] - zeta) < 4 * modes.modes.zeta_std[-1]


def test_a_tone_beside_a_small_decay_stays_a_tone() -> None:
    tone = np.cos(WN * TIME) + 0.1 * np.exp(-0.3 * TIME) * np.cos(0.99 * WN * TIME)
    record = as_response(TIME, tone[None] + 0.01 * np.random.default_rng(2).standard_normal((1, TIME.size)), ["y"])
    assert not len(identify(record, band_hz=(0.1, 19.0)).modes)


@pytest.mark.slow
@pytest.mark.parametrize(("channels", "share"), [(4, 1e-6), (2, 0.05)])
def test_the_value_of_a_mode_is_the_mean_of_its_table(channels: int, share: float) -> None:
    # A swing whose damping falls with its size, beside two linear modes in other directions: forces are found. In a few
    # channels they act in a structure of masses, whose values are means over cycles of the slowest mode.
    size = 0.6 + 0.4 * np.exp(-TIME / 3)
    swing = size * np.cos(np.cumsum(WN * (1 + 0.01 * (1 - size))) * TIME[1])
    other = 0.1 * np.exp(-0.05 * TIME) * np.cos(8.86 * TIME + 1) + 0.03 * swing
    motion = np.array([swing, other, 0.5 * swing + 0.3 * other, 0.5 * other - 0.4 * swing])[:channels]
    values = motion + 0.015 * np.random.default_rng(1).standard_normal(motion.shape)
    modes = identify(as_response(TIME, values, ["y", "x", "u", "v"][:channels]))
    assert modes.forces
    for zeta, each in zip(modes.modes.zeta, modes.amplitude_dependence, strict=True):
        lengths = [stop - start for start, stop in each.spans]
        assert zeta == pytest.approx(np.average(each.zeta, weights=lengths), rel=share)
