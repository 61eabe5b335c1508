"""What estimates say where the cause of the motion was not stated, or was measured with noise."""

import numpy as np
import pytest
from test_greybox_wheels import HALF, driven, off, record_of

from suspid import EstimationError, estimate, quarter_car, simulate
from suspid.records import as_response
from suspid.signals import as_signal


def test_a_drive_that_counts_as_a_free_decay_is_told_to_be_none() -> None:
    motions, times = driven(HALF, 1, duration=30.0)
    rng, s = np.random.default_rng(1), 2j * np.pi * np.fft.rfftfreq(len(times), times[1])
    lines = np.fft.rfft(list(motions.values())) * (s.imag > 2) / np.maximum(s.imag, 2) ** 2
    heights = np.fft.irfft(lines, len(times))
    heights += 0.01 * np.std(heights, axis=1, keepdims=True) * rng.standard_normal(heights.shape)
    with pytest.raises(
        EstimationError, match=r"does not die down.* name them in given\. As a free decay the records do"
    ):
        estimate(record_of(dict(zip(HALF.coordinates, heights, strict=True)), times), off(HALF))


@pytest.mark.parametrize("noise", [0.0, 10.0])
def test_noise_of_a_known_force_is_named_where_the_car_does_not_explain_the_record(noise: float) -> None:
    car = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
    )
    times, rng = np.arange(0, 20, 0.005), np.random.default_rng(1)
    force = 800 * np.sin(2 * np.pi * (0.5 + 0.3 * times) * times)
    exact = simulate(car, times, {"chassis_force": force}, outputs=["chassis_acceleration", "chassis_travel"])
    values = as_signal(exact).values
    values = values + 1e-3 * np.std(values, axis=1, keepdims=True) * rng.standard_normal(values.shape)
    measured = {"chassis_force": force + noise * rng.standard_normal(len(times))}
    record = as_response(times, values, ["chassis_acceleration", "chassis_travel"], inputs=measured)
    found = estimate(record, car, given=["chassis_force"], fixed=["tire.damping"], noisy=())
    assert found.explains == (noise == 0)
    assert ("chassis_force counts as exactly known" in str(found.verdict)) == (noise > 0)


@pytest.mark.parametrize("loggers", [True, False])
def test_channels_of_two_loggers_that_are_taken_for_two_tests_are_told(loggers: bool) -> None:
    """A drive whose body and wheel are in two files; two stretches of one channel are two tests."""
    car = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
    )
    times, rng = np.arange(0, 20, 0.01), np.random.default_rng(1)
    road = {"road": 0.01 * np.cumsum(rng.standard_normal(len(times))) * 0.1}
    names = ["chassis_acceleration", "tire_acceleration"]
    values = as_signal(simulate(car, times, road, outputs=names)).values
    values = values + 0.02 * np.std(values, axis=1, keepdims=True) * rng.standard_normal(values.shape)
    half = len(times) // 2
    apart = [as_response(times, values[:1], names[:1]), as_response(times, values[1:], names[1:])]
    later = [as_response(times[:half], part, names[:1]) for part in (values[:1, :half], values[:1, half:])]
    found = estimate(apart if loggers else later, off(car), fixed=["tire.damping"])
    assert "The motion does not decay" in str(found.verdict)
    assert ("several loggers" in str(found.verdict)) == loggers
