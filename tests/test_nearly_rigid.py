"""Mounts that are nearly rigid: covariances follow the profile of the likelihood, not its curvature at one point."""

import numpy as np
import pytest
from test_greybox_wheels import NOISE, QUARTER, driven, record_of

from suspid.greybox.frequency_domain import _sandwich
from suspid.greybox.measured_causes import WheelProblem, first_levels
from suspid.greybox.nearly_rigid import share_to_rigid, toward_rigid
from suspid.greybox.settling import descended, released, settled
from suspid.greybox.trials import trials_of
from suspid.greybox.wheel_problem import wheel_problem
from suspid.levels import EXACT, NORMAL_95
from suspid.reconstruction import unknowns_of
from suspid.units import RealArray


def problem_of(mount: float, seed: int) -> WheelProblem:
    motions, times = driven(QUARTER, seed, noise=NOISE, mount=mount)
    fixed = ["tire.stiffness", "tire.damping"]
    unknowns = unknowns_of(
        QUARTER, rate=8.0, fixed=fixed, bounds=None, ties=(), nominal_std=None, free_masses=()
    )  # fmt: skip
    trials = trials_of(record_of(motions, times), QUARTER, ("tire",))
    return wheel_problem(
        QUARTER, trials, unknowns, gains=None, delays=None, mounts=None, band=None, stretch=None
    )  # fmt: skip


@pytest.mark.parametrize("deviations", [2.5, 4.0, 40.0])
@pytest.mark.parametrize("steepness", [1.0, 1.4, 2.0])
def test_the_share_is_where_the_deviation_has_fallen_by_what_is_asked(deviations: float, steepness: float) -> None:
    left = 1 - share_to_rigid(deviations, steepness)
    deviation = deviations * ((2 - steepness) * left + (steepness - 1) * left**2)
    assert deviations - deviation == pytest.approx(NORMAL_95)


# Class B, 60 s: a rigid mount is as unlikely as 1 to 5 standard deviations.
@pytest.mark.parametrize(("mount", "seed"), [(1.2e6, 1), (1.2e6, 2), (2e6, 3)])
def test_intervals_toward_a_rigid_mount_are_those_of_the_profile_of_the_likelihood(mount: float, seed: int) -> None:
    problem = problem_of(mount, seed)
    z0 = np.concatenate([problem.unknowns.nominal, problem.extras.start])
    found, levels = released(problem, *settled(problem, z0, [first_levels(s) for s in problem.sources]))
    plain, curvature = _sandwich(found.every, np.zeros((0, len(z0))))
    covariance = toward_rigid(problem, found, levels, plain, curvature=curvature)
    at = len(problem.unknowns)
    # In deviations by the scatter of the lines, which is not quite that of the curvature.
    allowed = NORMAL_95**2 * plain[at, at] / curvature[at, at]

    def held(tau: float) -> tuple[float, RealArray]:
        low, high = problem.extras.lower.copy(), problem.extras.upper.copy()
        low[0], high[0] = tau, tau + EXACT
        point = descended(problem, found.z, levels, extras=(low, high))
        return point.cost - found.cost - allowed, point.z

    low, high = 0.0, float(found.z[at])
    if held(low)[0] > 0:
        for _ in range(20):
            middle = (low + high) / 2
            low, high = (middle, high) if held(middle)[0] > 0 else (low, middle)
        reach, end = NORMAL_95, held(high)[1]
    else:
        reach, end = float(np.sqrt(held(0.0)[0] + allowed) / np.sqrt(allowed)) * NORMAL_95, held(0.0)[1]
    along = covariance[:, at] / np.sqrt(covariance[at, at])
    predicted = found.z - reach * along
    # The profile is followed by a parabola through what is known of it at both its ends.
    std = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose((predicted - end) / std, 0.0, atol=0.15)
    # The curvature at the best fit alone would end too early.
    assert found.z[at] - reach * np.sqrt(plain[at, at]) > end[at] + 0.2 * std[at]
