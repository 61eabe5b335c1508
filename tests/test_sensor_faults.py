"""Sensors that are dead or recorded twice are named, and not taken for one with a wrong sign."""

import numpy as np
import pytest
from scipy.signal import lfilter

from suspid import EstimationError, estimate, half_car, quarter_car
from suspid.greybox.sensor_faults import AVERAGED, DEAD_SHARE, fault_of
from suspid.records import as_response
from suspid.units import ComplexArray
from suspid.words.greybox import EstimateCheck

NAMES = ("body", "front", "rear")


def drawn(count: int, seed: int) -> ComplexArray:
    """Return independent spectra, (channel, line, stretch)."""
    real, imaginary = np.random.default_rng(seed).standard_normal((2, count, 400, 8))
    return np.asarray(real + 1j * imaginary)


def code_of(values: ComplexArray) -> object:
    found = fault_of(np.moveaxis(values, 0, 2), (2, 2, 2), NAMES)
    return None if found is None else (found.code, found.numbers["names"])


class TestFaults:
    @pytest.mark.parametrize("seed", range(3))
    def test_a_channel_is_dead_below_the_share_that_it_has_in_common(self, seed: int) -> None:
        """Of ``x + a y`` the coherence with y is ``a^2 / (1 + a^2)``."""
        front, rear, own = drawn(3, seed)
        lag = np.exp(1j * np.linspace(0, 40, 400))[:, None]  # of a body, whose phase turns
        for share, dead in ((0.5 * DEAD_SHARE, True), (2 * DEAD_SHARE, False)):
            a = np.sqrt(share / (1 - share))
            made = np.stack([lag * (rear + 0.3 * own), front + a * rear, rear])
            assert code_of(made) == ((EstimateCheck.DEAD, ("front",)) if dead else None)
        assert code_of(np.stack([own, front, rear])) == (EstimateCheck.APART, NAMES)

    @pytest.mark.parametrize("factor", [1.0, -3.0])
    def test_copies_are_one_motion_up_to_a_factor_and_noise(self, factor: float) -> None:
        front, rear, noise = drawn(3, 7)
        lag = np.exp(1j * np.linspace(0, 40, 400))[:, None]
        copied = factor * (front + 0.2 * noise)
        assert code_of(np.stack([lag * (front + rear), front, copied])) == (EstimateCheck.COPIED, ("front", "rear"))
        assert code_of(np.stack([lag * (front + rear), front, lag * front + rear])) is None

    def test_the_chance_that_is_taken_off_is_that_of_the_average(self) -> None:
        """Coherence of independent channels is one over the number of values that it averages."""
        made = np.moveaxis(drawn(2, 3), 0, 2).reshape(-1, AVERAGED, 2)
        power = np.abs(np.mean(made[..., 0].conj() * made[..., 1], axis=1)) ** 2
        power = power / np.prod(np.mean(np.abs(made) ** 2, axis=1), axis=1)
        assert abs(np.mean(power) * AVERAGED - 1) < 5 / np.sqrt(len(power))


class TestEstimates:
    def test_a_dead_wheel_is_said(self) -> None:
        car = quarter_car(
            chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
        )
        rows = np.random.default_rng(2).standard_normal((2, 1000))
        body = lfilter([0.1], [1.0, -0.9], rows[0])
        names = ["chassis_acceleration", "tire_acceleration"]
        record = as_response(np.arange(1000) / 100, np.array([body, 0.1 * rows[1]]), names)
        with pytest.raises(EstimationError, match="have nothing in common") as told:
            estimate(record, car, given=["tire"])
        assert "reversed" not in str(told.value)

    def test_one_wheel_recorded_twice_is_said(self) -> None:
        car = half_car(
            chassis_mass=600, pitch_inertia=900, front_tire_mass=40, rear_tire_mass=40, cg_to_front=1.25,
            cg_to_rear=1.25, front_stiffness=21e3, rear_stiffness=23e3, front_tire_stiffness=190e3,
            rear_tire_stiffness=190e3, front_damping=1350, rear_damping=1400,
        )  # fmt: skip
        names = [f"{name}_acceleration" for name in ("heave", "pitch", "front", "rear")]
        made = np.random.default_rng(2).standard_normal((4, 1000))
        record = as_response(np.arange(1000) / 100, made[[0, 1, 2, 2]], names)
        with pytest.raises(EstimationError, match="front_acceleration, rear_acceleration show the same motion"):
            estimate(record, car, given=["front", "rear"])
