"""A mode that swings beside its rest follows a drift, not the motion of a record."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid.identification.noise import noise_of
from suspid.identification.nonlinear.search import find_forces
from suspid.identification.nonlinear.standing import driven_stands
from suspid.identification.selection import select
from suspid.units import RealArray

TIME = np.arange(1500) / 1500


def test_a_mode_that_swings_beside_its_rest_is_none() -> None:
    """Drag slows a swing of 14 Hz; where the state drifts off by more than it swings, it follows no motion."""

    def moved(_: float, y: RealArray) -> RealArray:
        return np.array([y[1], -2.0 * y[1] - 5e-3 * abs(y[1]) * y[1] - 89.0**2 * y[0]])

    motion = solve_ivp(moved, (0.0, 1.0), [2.0, 0.0], t_eval=TIME, rtol=1e-9, atol=1e-10).y[:1]
    values = motion + 2e-3 * np.random.default_rng(1).standard_normal(motion.shape)
    values -= values.mean()
    noise = noise_of(values)
    bent = find_forces(values, noise=noise, selection=select(values, noise=noise))
    assert bent is not None
    fit = bent.fit
    assert fit.theta.imag * 1500 == pytest.approx([89.0], rel=2e-3)
    assert driven_stands(fit).tolist() == [True]
    swings = np.abs(fit.states)
    for share, stands in ((0.5, True), (1.5, False)):
        assert driven_stands(replace(fit, states=fit.states + share * swings)).tolist() == [stands]
