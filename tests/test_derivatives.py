"""Channels that were computed from another are no measurements of their own; sensors are."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from suspid import Settings, analyse
from suspid.analysis.derivatives import without_derivatives
from suspid.analysis.stretch import stretch_of
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import Note

RATE, WN, DRAG = 100.0, 8.45, 0.5
TIME = np.asarray(np.arange(0, 25, 1 / RATE))


def swing() -> RealArray:
    """Return a mass on a spring with quadratic drag, ``x'' + DRAG |x'| x' + WN^2 x = 0``, by Runge-Kutta."""

    def slope(s: RealArray) -> RealArray:
        return np.array([s[1], -DRAG * abs(s[1]) * s[1] - WN**2 * s[0]])

    state, h, out = np.array([0.07, 0.0]), 1 / RATE, []
    for _ in TIME:
        out.append(state[0])
        a = slope(state)
        b = slope(state + h / 2 * a)
        c = slope(state + h / 2 * b)
        state = state + h / 6 * (a + 2 * b + 2 * c + slope(state + h * c))
    return np.array(out)


def smoothed_slope(values: RealArray, half: int) -> RealArray:
    """Return the slope of a least-squares line through some samples on either side, as programs of sensors have it."""
    shifts = np.arange(-half, half + 1)
    padded = np.pad(values, half, mode="reflect", reflect_type="odd")
    return np.asarray(np.correlate(padded, shifts / np.sum(shifts**2), mode="valid") * RATE)


def exported(half: int, *, seed: int) -> RealArray:
    """Return position, velocity and acceleration of a motion sensor, rounded as in a file."""
    position = swing() + 2e-4 * np.random.default_rng(seed).standard_normal(TIME.size)
    velocity = smoothed_slope(position, half)
    return np.asarray(np.round(np.stack([position, velocity, smoothed_slope(velocity, half)]), 4), float)


@pytest.mark.parametrize("half", [1, 2, 3])
@pytest.mark.parametrize("units", [1.0, 1e3])
def test_velocity_and_acceleration_that_were_computed_are_left_out(half: int, units: float) -> None:
    values = exported(half, seed=half) * np.array([[units], [1.0], [1.0]])
    left, notes = without_derivatives(as_response(TIME, values, ["x", "v", "a"]))
    assert list(left.output_labels) == ["x"]
    assert [(note.code, note.numbers["channel"]) for note in notes] == [
        (Note.DERIVED_CHANNEL, "v"),
        (Note.DERIVED_CHANNEL, "a"),
    ]


@pytest.mark.parametrize(("count", "told"), [(100, True), (52, True), (51, False)])
def test_so_are_those_of_short_records(count: int, told: bool) -> None:
    """Four samples for each of thirteen weights; fewer may be told by chance."""
    values = exported(2, seed=2)[:, :count]
    left, _ = without_derivatives(as_response(TIME[:count], values, ["x", "v", "a"]))
    assert list(left.output_labels) == (["x"] if told else ["x", "v", "a"])


@pytest.mark.parametrize("count", [52, 100, 200])
def test_sensors_of_few_samples_stay(count: int) -> None:
    """Position and speed of one swing, each with noise of its own."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        values = np.stack([swing(), np.gradient(swing(), TIME)])[:, :count]
        values = values + 0.003 * np.std(values, axis=1, keepdims=True) * rng.standard_normal(values.shape)
        left, _ = without_derivatives(as_response(TIME[:count], values, ["x", "v"]))
        assert list(left.output_labels) == ["x", "v"]


@pytest.mark.parametrize("noise", [0.0, 1e-4, 1e-2])
def test_sensors_of_the_same_motion_are_kept(noise: float) -> None:
    # Position, speed and acceleration of one decay, each with its own noise, rounded to six digits.
    poles = -0.1 + 1j * WN
    motion = np.array([(poles**n * np.exp(poles * TIME)).real / abs(poles) ** n for n in range(3)])
    rng = np.random.default_rng(1)
    scale = np.array([[0.05], [0.05 * WN], [0.05 * WN**2]])
    values = np.round(scale * (motion + noise * rng.standard_normal(motion.shape)), 6)
    record = as_response(TIME, values, ["x", "v", "a"])
    left, notes = without_derivatives(record)
    assert left is record
    assert not notes


def test_the_first_command_finds_one_mode_in_what_a_motion_sensor_exports() -> None:
    record = as_response(TIME, exported(2, seed=0), ["x", "v", "a"])
    found = analyse(record)
    assert len(found.modes) == 1
    assert found.modes.wn[0] == pytest.approx(WN, rel=0.002)
    assert Note.DERIVED_CHANNEL in {note.code for note in found.notes}


def test_a_motion_that_was_integrated_is_left_out_and_its_sensor_is_kept() -> None:
    """A program of an accelerometer exports velocity and position as well: their noise walks."""
    rng = np.random.default_rng(2)
    acceleration = np.exp(-TIME / 3) * np.cos(8 * TIME) + 0.02 * rng.standard_normal(TIME.size)
    velocity = cumulative_trapezoid(acceleration, TIME, initial=0)
    record = as_response(TIME, np.stack([velocity, acceleration]), ["v", "a"])
    left, notes = without_derivatives(record)
    assert list(left.output_labels) == ["a"]
    assert [(note.code, note.numbers["channel"]) for note in notes] == [(Note.INTEGRATED_CHANNEL, "v")]


def test_channels_that_are_named_are_used() -> None:
    record = as_response(TIME, exported(2, seed=0), ["x", "v", "a"])
    used = stretch_of(record, Settings(channels=("x", "v", "a"), decay="whole"))
    assert used.record is record


class TestCopies:
    """The same channel in another unit, or from another zero, is no second sensor."""

    MOTION = swing() + 2e-4 * np.random.default_rng(4).standard_normal(TIME.size)

    @pytest.mark.parametrize("digits", [None, 4])
    @pytest.mark.parametrize(("factor", "offset"), [(1.0, 0.0), (100.0, 0.0), (-2.54, 3.0)])
    def test_they_are_left_out_and_named(self, digits: int | None, factor: float, offset: float) -> None:
        values = 30 * np.stack([self.MOTION, factor * self.MOTION + offset])
        values = values if digits is None else np.asarray(np.round(values, digits))
        left, notes = without_derivatives(as_response(TIME, values, ["cm", "m"]))
        assert list(left.output_labels) == ["cm"]
        assert [(n.code, n.numbers["channel"], n.numbers["source"]) for n in notes] == [
            (Note.COPIED_CHANNEL, "m", "cm")
        ]

    @pytest.mark.parametrize("noise", [0.01, 1.0])
    def test_two_sensors_of_one_motion_stay(self, noise: float) -> None:
        """Beside noise of 2e-4, a hundredth of it is that of a second sensor; counted in steps of 1e-6 it shows."""
        other = self.MOTION + noise * 2e-4 * np.random.default_rng(5).standard_normal(TIME.size)
        record = as_response(TIME, np.asarray(np.round(np.stack([self.MOTION, 2 * other]), 6)), ["left", "right"])
        assert without_derivatives(record)[0] is record

    def test_two_coarse_sensors_that_agree_stay(self) -> None:
        """Of few steps of a converter, two sensors agree in each sample."""
        coarse = np.asarray(np.round(swing() / float(np.ptp(swing())) * 200), float)
        record = as_response(TIME, np.stack([coarse, coarse]), ["left", "right"])
        assert without_derivatives(record)[0] is record

    def test_channels_without_noise_stay(self) -> None:
        record = as_response(TIME, np.stack([swing(), 2 * swing()]), ["left", "right"])
        assert without_derivatives(record)[0] is record


@pytest.mark.parametrize("step", [1e-3, 2e-4, 1e-5])
def test_differences_of_an_encoder_are_computed_from_it(step: float) -> None:
    """The position is a number of steps; its differences are told by it, and it by their sum, to the last digit."""
    position = np.round(swing() / step)
    record = as_response(TIME, np.stack([position, RATE * np.diff(position, prepend=position[0])]), ["x", "v"])
    left, notes = without_derivatives(record)
    assert list(left.output_labels) == ["x"]
    assert [note.code for note in notes] == [Note.DERIVED_CHANNEL]
