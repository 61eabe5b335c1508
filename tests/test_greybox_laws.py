"""Laws of stated errors of estimates: each was seen red with the term that it is about taken out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import resample_poly
from test_greybox_wheels import QUARTER, at_rest, corner_of_half, driven, off, record_of

from suspid import estimate, free_decay, quarter_car
from suspid.greybox import frequency_domain
from suspid.greybox.frequency_domain import _sandwich
from suspid.greybox.judgement import folded
from suspid.greybox.leftover import Leftover
from suspid.greybox.misfit import Misfit
from suspid.records import as_response
from suspid.words import Level
from suspid.words.greybox import EstimateCheck
from validation.motion import LEVELS, STEP, integrated, road_heights


def test_lines_that_scatter_three_times_as_much_widen_deviations_threefold() -> None:
    problem, z, levels, _ = at_rest(0.3, 0.03)
    z = z.copy()
    found = problem.whitened(z, 0, levels)
    # A car that moves: at rest the information is that of noise alone, which is subtracted.
    moving = replace(found, motion=found.motion * 100)
    loud = replace(moving, residual=moving.residual * 3)
    (one, curve), (three, same) = _sandwich([moving], np.zeros((0, len(z)))), _sandwich([loud], np.zeros((0, len(z))))
    np.testing.assert_allclose(three, 9 * one, rtol=1e-9)
    np.testing.assert_allclose(same, curve, rtol=1e-9)


def test_noise_of_the_wheels_sensors_is_no_information() -> None:
    problem, z, levels, _ = at_rest(0.02, 0.3)
    found = problem.whitened(z, 0, levels)
    size = found.motion.shape
    rng = np.random.default_rng(8)
    true = rng.standard_normal(size) + 1j * rng.standard_normal(size)
    # A true motion as large as the noise, to which the noise of the best motion comes.
    true *= np.sqrt(np.mean(np.abs(found.motion) ** 2)) / np.sqrt(2)
    clean = replace(found, motion=true).rows()[1]
    _, curve = _sandwich([replace(found, motion=true + found.motion)], np.zeros((0, len(z))))
    np.testing.assert_allclose(np.diag(np.linalg.inv(curve)) / np.sum(clean**2, axis=0), 1.0, atol=0.15)


def test_levels_of_the_lowest_lines_are_those_of_the_noise() -> None:
    problem, z, levels, _ = at_rest(0.3, 0.03, stretch=1.5)
    (found,) = problem.levels(problem.every(z, [levels]), [levels])
    # The ends take up four fifths of the lowest lines: without a share for them a level would be a third.
    assert float(found.outputs[0, 0] - levels.outputs[0, 0]) == pytest.approx(0.0, abs=0.3)


def test_noise_of_short_decays_is_stated_without_bias() -> None:
    car = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
    )
    times = np.linspace(0.0, 0.78, 40)
    motion = np.asarray(free_decay(car, times, initial_state={"v_tire": 1.0}).y)[:2]
    ratio = []
    for seed in range(60):
        record = motion + 1e-4 * np.random.default_rng(seed).standard_normal(motion.shape)
        found = estimate(as_response(times, record, ["chassis", "tire"]), car, fixed=["tire.damping"])
        ratio.append(np.mean(found.noise_std[0] ** 2) / 1e-8)
    # 80 samples, 4 states, 2 offsets and 3 parameters: a biased one would be 0.89; the mean of 60 is known to 0.022.
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.055)


def test_coloured_noise_of_a_decay_widens_what_lies_where_it_is_loud() -> None:
    times = np.linspace(0.0, 9.99, 1000)
    motion = np.asarray(free_decay(QUARTER, times, initial_state={"v_tire": 1.0}).y)[:2]
    rng, turn = np.random.default_rng(4), 0.9
    white = rng.standard_normal((2, 3000))
    red = np.zeros_like(white)
    for i in range(1, white.shape[1]):
        red[:, i] = turn * red[:, i - 1] + np.sqrt(1 - turn**2) * white[:, i]
    stds = [
        estimate(as_response(times, motion + 1e-4 * e[:, -1000:], ["chassis", "tire"]), QUARTER, fixed=["tire.damping"])
        for e in (white, red)
    ]
    # Where the body moves, at 1.2 Hz, this noise has some 12 times the power of white noise of its variance.
    at = stds[0].parameters.index("chassis.stiffness")
    assert 2.3 < stds[1].std[at] / stds[0].std[at] < 4.5


def test_the_band_begins_below_the_lowest_mode_and_ends_above_the_highest() -> None:
    motions, times = driven(QUARTER, 6, noise={"chassis": 0.03, "tire": 0.1}, duration=20.0)
    found = estimate(record_of(motions, times), QUARTER, given=("tire",))
    assert found.band_hz is not None
    # A resonance is as wide as twice its damping ratio, here 0.2 and more.
    body, wheel = 1.2, 10.8
    assert found.band_hz[0] < body * (1 - 2 * 0.22)
    assert found.band_hz[1] > wheel * (1 + 2 * 0.3)


def test_what_a_car_lacks_widens_deviations_by_what_is_left_in_each_direction() -> None:
    part = Leftover(chi_square=400.0, freedom=40, directions=16.0, error=0.1, hertz=2.0)
    assert Misfit(parts=(part,)).inflation == pytest.approx(400 / 16)
    assert Misfit(parts=(part._replace(chi_square=41.0),)).inflation == 1.0


def test_what_passes_for_gain_delay_and_mount_of_a_lacking_car_is_in_its_errors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    record, corner = corner_of_half(0.71)
    free = estimate(record, corner, given=("tire",))
    held = estimate(record, corner, given=("tire",), gains=(), delays=(), mounts=())
    monkeypatch.setattr(frequency_domain, "from_held", lambda _problem, z, _levels: np.zeros_like(z))
    bare = estimate(record, corner, given=("tire",))
    for name in held.parameters:
        i, j = free.parameters.index(name), held.parameters.index(name)
        more = np.sqrt(free.std[i] ** 2 - bare.std[i] ** 2) / free.values[i]
        # With noise levels of its own the held car lies elsewhere by some tenths of the distance.
        assert 0.5 < more / abs(np.log(free.values[i] / held.values[j])) < 1.5


@pytest.mark.parametrize("seed", [7001, 7008])
def test_a_mount_that_a_delay_stands_in_for_is_found_behind_the_ridge(seed: int) -> None:
    # From 30 % off the descent of these ends at a rigid mount and a sensor that is late; chi-square rules that out.
    motions, times = driven(QUARTER, seed, noise={"chassis": 0.03, "tire": 0.1}, mount=1e6)
    found = estimate(record_of(motions, times), off(QUARTER), given=("tire",))
    low, high = found.interval()["chassis.relaxation"]
    assert low < 1300 / 1e6 < high
    assert low > 0


@pytest.mark.parametrize(
    ("relaxation", "delay", "told"), [(1.2e-3, 1.21e-3, True), (1.2e-3, 0.0, False), (0.3e-3, 0.3e-3, False)]
)
def test_a_mount_that_a_delay_cancels_is_told_to_be_folded_motion(relaxation: float, delay: float, told: bool) -> None:
    """Where it is beyond chance, three standard deviations; a mount without a delay is one."""
    names = ("chassis.relaxation", "tire_acceleration.gain", "tire_acceleration.delay")
    checks = list(folded(names, np.array([relaxation, 1.0, delay]), np.array([0.2e-3, 0.01, 0.2e-3])))
    assert [one.remark.code for one in checks] == [EstimateCheck.FOLDED] * told


@pytest.mark.parametrize("filtered", [True, False])
def test_edges_of_potholes_that_a_logger_folds_are_told(filtered: bool) -> None:
    """Twelve potholes of 2 cm with edges of 20 ms in 60 s; the motion is that of `validation.motion` at 2 kHz."""
    half_steps = round(60.0 / STEP) * 2 + 1
    t, rng = np.asarray(STEP / 2 * np.arange(half_steps), float), np.random.default_rng(3)
    heights = road_heights(np.asarray(20.0 * t), LEVELS["B"], rng)
    for start in 2 + 4.7 * np.arange(12):
        heights -= 0.02 * (np.clip((t - start) / 0.02, 0, 1) - np.clip((t - start - 0.05) / 0.02, 0, 1))
    inputs = np.zeros((4, half_steps))
    inputs[0], inputs[1] = heights, np.gradient(heights, STEP / 2)
    rows = integrated(QUARTER, inputs, np.zeros(4), keep=1)[1]
    rows = resample_poly(rows, 1, 10, axis=1) if filtered else rows[:, ::10]
    rows = rows + np.array([[0.03], [0.1]]) * rng.standard_normal(rows.shape)
    record = as_response(np.arange(rows.shape[1]) / 200, rows, ["chassis_acceleration", "tire_acceleration"])
    found = estimate(record, off(QUARTER), given=("tire",))
    assert (found.verdict.level is Level.CARE) is not filtered
    assert (EstimateCheck.FOLDED in {one.remark.code for one in found.verdict.checks}) is not filtered
