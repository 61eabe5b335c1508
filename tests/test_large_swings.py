"""A pendulum that swings too far for a cubic spring: its exact period is an elliptic integral."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk

from suspid import Analysis, analyse
from suspid.decays.fading import decay_of_fading, falling
from suspid.identification import AmplitudeDependence
from suspid.signals import Signal
from suspid.words import DecayDoubt

WN, DAMPING, RATE, REST = 6.1, 0.03, 50, 3


def written(path: Path, amplitude: float) -> Path:
    """Write ``x'' + 2 DAMPING x' + WN^2 sin x = 0`` after a rest, by Runge-Kutta, with noise."""

    def slope(x: float, v: float) -> tuple[float, float]:
        return v, -(WN**2) * math.sin(x) - 2 * DAMPING * v

    x, v, h, angles = amplitude, 0.0, 1 / RATE, [amplitude] * (REST * RATE)
    for _ in range(50 * RATE):
        angles.append(x)
        a, b = slope(x, v)
        c, d = slope(x + h / 2 * a, v + h / 2 * b)
        e, f = slope(x + h / 2 * c, v + h / 2 * d)
        g, k = slope(x + h * e, v + h * f)
        x, v = x + h / 6 * (a + 2 * c + 2 * e + g), v + h / 6 * (b + 2 * d + 2 * f + k)
    noisy = np.array(angles) + 0.002 * np.random.default_rng(1).standard_normal(len(angles))
    return recorded(path, noisy)


def recorded(path: Path, angles: np.ndarray) -> Path:
    """Write angles as a file."""
    rows = [f"{n / RATE:.3f},{angle:.5f}" for n, angle in enumerate(angles)]
    path.write_text("\n".join(["time [s],angle [rad]", *rows]) + "\n")
    return path


def one_mode(found: Analysis, *, rtol: float) -> tuple[AmplitudeDependence, np.ndarray, np.ndarray]:
    """Check the frequencies of a single mode; return it, and which amplitudes are large, with the exact frequencies.

    Below 0.1 rad noise counts.
    """
    assert len(found.modes) == 1
    assert found.verdict.level.label == "care"
    (mode,) = found.identification.amplitude_dependence
    exact = WN * np.pi / (2 * ellipk(np.sin(mode.amplitude / 2) ** 2))
    large = mode.amplitude > 0.1
    assert np.sum(large) > 3
    np.testing.assert_allclose(mode.wn[large], exact[large], rtol=rtol)
    return mode, large, exact


@pytest.mark.slow
def test_a_pendulum_has_one_mode_whose_frequency_falls_with_its_swing(tmp_path: Path) -> None:
    found = analyse(written(tmp_path / "swing.csv", 1.6))
    assert DecayDoubt.LATER in {doubt.code for doubt in found.used[0].doubts}
    # A cubic spring is not quite the sine: half a percent, less than the frequency changes.
    one_mode(found, rtol=0.005)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 5))])
def test_noise_that_fades_is_no_decay(seed: int) -> None:
    time = np.arange(3000) / RATE
    values = np.exp(-0.05 * time) * np.random.default_rng(seed).standard_normal((1, time.size))
    fading = Signal(start=0.0, step=1 / RATE, values=values, channels=("angle",))
    assert falling(fading) is not None
    assert decay_of_fading(fading, level=20.0) is None


@pytest.mark.parametrize(("lost", "found"), [(0.95, False), (1.05, True)])
def test_a_motion_falls_if_its_amplitude_loses_a_factor_e(lost: float, found: bool) -> None:
    # From the first of 16 parts to the last, each of 50 whole cycles.
    time = np.arange(16000)
    values = np.exp(-lost * time / 15000) * np.cos(2 * np.pi * time / 20)
    signal = Signal(start=0.0, step=0.01, values=values[None], channels=("angle",))
    assert (falling(signal) is not None) == found


def test_a_swing_that_keeps_its_size_does_not_fall() -> None:
    steady = np.sin(WN * np.arange(3000) / RATE)[None]
    assert falling(Signal(start=0.0, step=1 / RATE, values=steady, channels=("angle",))) is None


@pytest.mark.parametrize("amplitude", [0.6, pytest.param(1.0, marks=pytest.mark.slow)])
def test_friction_drag_and_large_swings_together_are_one_mode(tmp_path: Path, amplitude: float) -> None:
    """Three forces that are not linear at once, as pendulums on encoders have them; exact by its turning points."""
    from scipy.integrate import solve_ivp

    friction, drag = 0.02, 0.015

    def slope(_: float, state: np.ndarray) -> list[float]:
        x, v = state
        return [v, -(WN**2) * math.sin(x) - 2 * DAMPING * v - drag * abs(v) * v - friction * math.tanh(v / 1e-4)]

    time = np.arange(40 * RATE) / RATE
    swing = solve_ivp(slope, (0.0, time[-1]), [amplitude, 0.0], t_eval=time, rtol=1e-9, atol=1e-10, method="LSODA").y[0]
    steps = np.round(swing / 0.0015) * 0.0015
    mode, large, exact = one_mode(analyse(recorded(tmp_path / "encoder.csv", steps)), rtol=0.002)
    # Decay rates of the work over a cycle: of a damper, of drag and of friction.
    size = mode.amplitude[large]
    lost = DAMPING + 4 / (3 * np.pi) * drag * size * exact[large] + 2 * friction / (np.pi * size * exact[large])
    np.testing.assert_allclose(mode.zeta[large] * mode.wn[large], lost, rtol=0.06)
