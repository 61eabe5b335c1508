from collections.abc import Callable
from typing import Any

import control
import mpmath
import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from suspid import (
    InputError,
    RecordError,
    Strut,
    Suspension,
    add_noise,
    eigenmodes,
    free_decay,
    quarter_car,
    statespace,
)

# What is asked of an exact response, relative to its peak.
EXACT = 1e-9


def paper_car(seat: float = 300.0, chassis: float = 200.0, tire: float = 100.0) -> Suspension:
    return quarter_car(
        seat_mass=200,
        chassis_mass=200,
        tire_mass=200,
        seat_stiffness=200e3,
        chassis_stiffness=400e3,
        tire_stiffness=800e3,
        seat_damping=seat,
        chassis_damping=chassis,
        tire_damping=tire,
    )


def heavy_car(factor: float = 1.0) -> Suspension:
    return quarter_car(
        seat_mass=80,
        chassis_mass=400,
        tire_mass=40,
        seat_stiffness=16e3,
        chassis_stiffness=20e3,
        tire_stiffness=200e3,
        seat_damping=500 * factor,
        chassis_damping=1500 * factor,
        tire_damping=50,
    )


def oscillator(*, mass: float, stiffness: float, damping: float) -> Suspension:
    strut = Strut(name="strut", stiffness=stiffness, damping=damping, arms={"mass": 1.0, "road": -1.0})
    return Suspension(masses={"mass": mass}, struts=[strut])


def motion(suspension: Suspension) -> control.StateSpace:
    """The system seen at all its states."""
    names = suspension.coordinates
    return statespace(suspension, outputs=[*names, *(f"{name}_velocity" for name in names)])


def mpmath_states(A: Any, start: Any, elapsed: float) -> NDArray[np.float64]:
    """Return exp(A t) x0 by mpmath with 50 digits."""
    with mpmath.workdps(50):
        matrix = mpmath.matrix(np.asarray(A, float).tolist()) * mpmath.mpf(float(elapsed))
        state = mpmath.expm(matrix, method="pade") * mpmath.matrix([float(x) for x in start])
        return np.array([float(x) for x in state])


CARS = {
    "Table 1 as printed": paper_car(30, 20, 10),
    "Table 1, ten times the damping": paper_car(),
    "undamped": paper_car(0, 0, 0),
    "heavily damped": heavy_car(),
    "overdamped": heavy_car(20.0),
}


class TestMatrixExponential:
    @pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())
    def test_long_records_end_where_fifty_digits_do(self, car: Suspension) -> None:
        step, count = 0.002, 200_000
        start = np.array([0.01, 0.0, -0.02, 0.0, 0.3, 1.0])
        system = motion(car)
        found = free_decay(system, step * np.arange(count), initial_state=start).y
        peak = np.max(np.abs(found), axis=1)
        # Either side of the powers of two at which the record is doubled, and the end.
        for k in (1, 2, 3, 1023, 1024, 65_535, 65_537, 131_072, 199_999):
            assert np.max(np.abs(found[:, k] - mpmath_states(system.A, start, step * k)) / peak) < EXACT, k

    @pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())
    def test_irregular_times(self, car: Suspension) -> None:
        times = 3.0 + np.array([0.0, 1e-6, 0.013, 0.0131, 0.5, 2.0, 40.0])
        start = np.array([0.01, 0.0, -0.02, 0.0, 0.3, 1.0])
        system = motion(car)
        found = free_decay(system, times, initial_state=start).y
        expected = np.stack([mpmath_states(system.A, start, t - times[0]) for t in times], axis=1)
        assert np.max(np.abs(found - expected) / np.max(np.abs(expected), axis=1, keepdims=True)) < EXACT

    def test_many_irregular_times_cross_the_blocks(self) -> None:
        times = np.sort(np.random.default_rng(7).uniform(0, 2, 9001))
        system = statespace(heavy_car())
        start = np.array([0.01, 0.0, -0.02, 0.0, 0.3, 1.0])
        found = free_decay(system, times, initial_state=start).y
        for k in (0, 1, 4499, 4500, 4501, 9000):
            expected = (scipy.linalg.expm(system.A * (times[k] - times[0])) @ start)[:3]
            assert np.max(np.abs(found[:, k] - expected)) < EXACT * np.max(np.abs(found))

    def test_uniform_and_irregular_ways_agree(self) -> None:
        system = statespace(heavy_car())
        times = 0.01 * np.arange(300)
        uniform = free_decay(system, times, impulse="road").y
        irregular = free_decay(system, [*times, 3.1234], impulse="road").y
        np.testing.assert_allclose(irregular[:, :300], uniform, rtol=0, atol=1e-12 * np.max(np.abs(uniform)))

    def test_control_s_own_response_agrees(self) -> None:
        system = statespace(heavy_car())
        times = np.linspace(0, 3, 601)
        start = [0.01, 0.0, -0.02, 0.0, 0.3, 1.0]
        expected = control.initial_response(system, times, start).y
        found = free_decay(system, times, initial_state=start).y
        np.testing.assert_allclose(found, expected, rtol=0, atol=EXACT * np.max(np.abs(expected)))

    def test_a_late_start_shifts_the_response_alone(self) -> None:
        times = 0.01 * np.arange(200)
        early = free_decay(paper_car(), times, impulse="road").y
        late = free_decay(paper_car(), 1000.0 + times, impulse="road").y
        # Stamps near 1000 s are rounded to 1e-13 s, on a phase of 84 rad/s.
        np.testing.assert_allclose(late, early, rtol=0, atol=1e-10 * np.max(np.abs(early)))

    def test_an_unstable_system_grows_exactly(self) -> None:
        system = control.ss([[0.3, 5.0], [-5.0, 0.3]], [[0], [1]], [[1, 0]], 0)
        times = 0.01 * np.arange(5000)
        found = free_decay(system, times, initial_state=[1.0, 0.0]).y[0]
        expected = np.exp(0.3 * times) * np.cos(5 * times)
        # Relative to the envelope, at every sample: an early error is not hidden by the later growth.
        assert np.max(np.abs(found - expected) / np.exp(0.3 * times)) < EXACT


class TestClosedForms:
    def test_critical_damping_is_exactly_defective(self) -> None:
        # k = 100 m, c = 20 m: both poles at -10, one eigenvector.
        car = oscillator(mass=2.0, stiffness=200.0, damping=40.0)
        times = 1e-4 * np.arange(30_000)
        found = free_decay(car, times, initial_state={"z_mass": 0.5, "v_mass": 3.0}).y[0]
        expected = (0.5 + (3.0 + 10 * 0.5) * times) * np.exp(-10 * times)
        np.testing.assert_allclose(found, expected, rtol=0, atol=EXACT)

    @pytest.mark.parametrize("off", [1e-13, 1e-10, 1e-7, -1e-10], ids=str)
    def test_nearly_critical_damping(self, off: float) -> None:
        car = oscillator(mass=1.0, stiffness=100.0, damping=20.0 * (1 + off))
        times = 1e-3 * np.arange(1000)
        found = free_decay(car, times, initial_state={"z_mass": 0.5, "v_mass": 3.0}).y[0]
        A = statespace(car).A
        for k in (0, 1, 100, 999):
            assert abs(found[k] - mpmath_states(A, [0.5, 3.0], times[k])[0]) < EXACT

    def test_a_triple_real_pole(self) -> None:
        system = control.ss([[-4, 1, 0], [0, -4, 1], [0, 0, -4]], [[0], [0], [1]], [[1, 0, 0]], 0)
        times = 0.001 * np.arange(2000)
        found = free_decay(system, times, initial_state=[1.0, 2.0, 3.0]).y[0]
        expected = (1 + 2 * times + 1.5 * times**2) * np.exp(-4 * times)
        np.testing.assert_allclose(found, expected, rtol=0, atol=EXACT)

    def test_free_masses_drift_with_their_centre(self) -> None:
        # Two free masses: the centre of mass moves uniformly, the elongation rings. The rounding of k / m
        # acts as a weak spring to the ground, whose effect grows with the cube of the time: 100 s, not 1000.
        ma, mb, k, c = 2.0, 3.0, 1000.0, 4.0
        strut = Strut(name="link", stiffness=k, damping=c, arms={"a": 1.0, "b": -1.0})
        car = Suspension(masses={"a": ma, "b": mb}, struts=[strut])
        times = 0.01 * np.arange(10_000)
        za, zb = free_decay(car, times, initial_state={"z_a": 0.1, "v_b": 1.5}).y
        reduced = ma * mb / (ma + mb)
        decay, wn = c / (2 * reduced), np.sqrt(k / reduced)
        wd = np.sqrt(wn**2 - decay**2)
        ringing = np.exp(-decay * times) * (0.1 * np.cos(wd * times) + (-1.5 + decay * 0.1) / wd * np.sin(wd * times))
        centre = ma * 0.1 / (ma + mb) + mb * 1.5 / (ma + mb) * times
        assert np.max(np.abs((ma * za + mb * zb) / (ma + mb) - centre)) < EXACT * np.max(centre)
        # The elongation is a difference of displacements that have grown to the drift's size.
        assert np.max(np.abs(za - zb - ringing)) < EXACT * np.max(centre)

    def test_an_undamped_oscillator_keeps_its_phase(self) -> None:
        times = 0.002 * np.arange(200_000)
        found = free_decay(oscillator(mass=1, stiffness=84.0**2, damping=0), times, initial_state=[1.0, 0.0]).y[0]
        np.testing.assert_allclose(found, np.cos(84.0 * times), rtol=0, atol=EXACT)


class TestStarts:
    def test_an_impulse_is_the_state_it_leaves(self) -> None:
        car = paper_car()
        times = 0.002 * np.arange(500)
        by_impulse = free_decay(car, times, impulse="road_rate").y
        by_state = free_decay(car, times, initial_state={"v_tire": 100.0 / 200.0}).y
        np.testing.assert_allclose(by_impulse, by_state, rtol=1e-14, atol=0)

    @pytest.mark.parametrize("road", ["road_front", "road_rear"])
    def test_an_impulse_agrees_with_control(self, road: str) -> None:
        struts = [
            Strut(name="f", stiffness=18e3, damping=900.0, arms={"z": 1, "pitch": -1.2, "road_front": -1}),
            Strut(name="r", stiffness=22e3, damping=800.0, arms={"z": 1, "pitch": 1.5, "road_rear": -1}),
        ]
        system = statespace(Suspension(masses={"z": 500.0, "pitch": 800.0}, struts=struts), road_rate=False)
        times = np.linspace(0, 2, 401)
        index = system.input_labels.index(road)
        expected = control.impulse_response(system, times, input=index).y[:, 0, :]
        found = free_decay(system, times, impulse=road).y
        np.testing.assert_allclose(found, expected, rtol=0, atol=EXACT * np.max(np.abs(expected)))

    def test_the_response_is_linear_in_its_start(self) -> None:
        times = 0.01 * np.arange(200)
        a = free_decay(heavy_car(), times, initial_state={"z_seat": 1.0}).y
        b = free_decay(heavy_car(), times, initial_state={"v_tire": 1.0}).y
        both = free_decay(heavy_car(), times, initial_state={"z_seat": 2.0, "v_tire": -3.0}).y
        np.testing.assert_allclose(both, 2 * a - 3 * b, rtol=0, atol=1e-13)

    def test_labels_and_a_single_time(self) -> None:
        response = free_decay(paper_car(), [5.0], initial_state={"z_seat": 0.25})
        assert response.output_labels == ["seat", "chassis", "tire"]
        np.testing.assert_array_equal(response.y, [[0.25], [0.0], [0.0]])
        np.testing.assert_array_equal(response.time, [5.0])

    def test_one_output_is_squeezed_as_control_does(self) -> None:
        response = free_decay(statespace(paper_car(), outputs=["seat"]), [0.0, 0.1], impulse="road")
        assert response.outputs.shape == (2,)
        assert response.y.shape == (1, 2)

    def test_arguments_are_left_as_they_were(self) -> None:
        times, start = np.array([0.0, 0.1, 0.2]), np.arange(6.0)
        response = free_decay(paper_car(), times, initial_state=start)
        response.time[0] = 7.0
        np.testing.assert_array_equal(times, [0.0, 0.1, 0.2])
        np.testing.assert_array_equal(start, np.arange(6.0))


class TestEnergy:
    @staticmethod
    def energy(car: Suspension, states: NDArray[np.float64]) -> NDArray[np.float64]:
        z, v = np.split(states, 2)
        return np.asarray(0.5 * np.sum(z * (car.K @ z) + v * (car.M @ v), axis=0))

    def test_an_undamped_car_conserves_it(self) -> None:
        car = paper_car(0, 0, 0)
        states = free_decay(motion(car), 0.002 * np.arange(200_000), initial_state={"v_tire": 1.0}).y
        np.testing.assert_allclose(self.energy(car, states), 0.5 * 200 * 1.0**2, rtol=EXACT, atol=0)

    @pytest.mark.parametrize("car", [paper_car(), heavy_car()], ids=["paper", "heavy"])
    def test_the_loss_is_the_power_of_the_dampers(self, car: Suspension) -> None:
        step = 2e-4
        states = free_decay(motion(car), step * np.arange(20_001), initial_state={"z_seat": 0.05, "v_tire": 1.0}).y
        velocity = states[3:]
        power = np.sum(velocity * (car.C @ velocity), axis=0)
        dissipated = step / 3 * (power[0] + 4 * power[1:-1:2].sum() + 2 * power[2:-2:2].sum() + power[-1])
        energy = self.energy(car, states)
        # Simpson's rule errs by step^4 / 180 of the fourth derivative of the power: (2 x 100 rad/s)^4 of its peak.
        rtol = 4.0 * step**4 / 180 * 200.0**4
        np.testing.assert_allclose(energy[0] - energy[-1], dissipated, rtol=rtol, atol=0)
        assert np.all(np.diff(energy) <= 0)


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "neither start": (lambda: free_decay(paper_car(), [0, 1]), "give either"),
    "both starts": (lambda: free_decay(paper_car(), [0, 1], initial_state=np.ones(6), impulse="road"), "give either"),
    "unknown state": (
        lambda: free_decay(paper_car(), [0, 1], initial_state={"v_tyre": 1.0}),
        r"no state 'v_tyre'\. Did you mean 'v_tire'",
    ),
    "unknown input": (
        lambda: free_decay(paper_car(), [0, 1], impulse="raod"),
        r"no input 'raod'\. Did you mean 'road'",
    ),
    "wrong length": (
        lambda: free_decay(paper_car(), [0, 1], initial_state=[1.0]),
        r"shape \(1,\); the states are z_seat",
    ),
    "nan state": (lambda: free_decay(paper_car(), [0, 1], initial_state={"z_seat": np.nan}), "is not finite"),
    "time goes back": (lambda: free_decay(paper_car(), [0, 1, 0.5], impulse="road"), "increase strictly"),
    "time repeats": (lambda: free_decay(paper_car(), [0, 1, 1], impulse="road"), "increase strictly"),
    "nan time": (lambda: free_decay(paper_car(), [0, np.nan], impulse="road"), "finite"),
    "no time": (lambda: free_decay(paper_car(), [], impulse="road"), "at least one time"),
    "matrix of times": (lambda: free_decay(paper_car(), np.ones((2, 2)), impulse="road"), r"shape \(2, 2\)"),
    "sampled": (
        lambda: free_decay(control.ss([[0.5]], [[1]], [[1]], 0, dt=0.1), [0, 1], initial_state=[1.0]),
        r"dt = 0\.1",
    ),
    "transfer function": (
        lambda: free_decay(control.tf([1], [1, 1]), [0, 1], initial_state=[1.0]),
        "not TransferFunction",
    ),
    "impulse straight through": (
        lambda: free_decay(statespace(paper_car(), outputs=["seat", "tire_acceleration"]), [0, 1], impulse="road"),
        r"'road' passes directly to output 'tire_acceleration'",
    ),
    "grows beyond floats": (
        lambda: free_decay(control.ss([[1.0]], [[1]], [[1]], 0), np.arange(1000.0), initial_state=[1.0]),
        r"unstable: its response exceeds the largest float before t = 710 s",
    ),
    "grows beyond floats at irregular times": (
        lambda: free_decay(control.ss([[1.0]], [[1]], [[1]], 0), [0.0, 1.0, 800.0], initial_state=[1.0]),
        r"before t = 800 s",
    ),
}


class TestRefusals:
    @pytest.mark.parametrize(("make", "message"), REFUSED.values(), ids=REFUSED.keys())
    def test_refused(self, make: Callable[[], object], message: str) -> None:
        with pytest.raises(InputError, match=message):
            make()


class TestNoise:
    TIMES = 0.002 * np.arange(20_000)

    def clean(self) -> control.TimeResponseData:
        return free_decay(paper_car(), self.TIMES, impulse="road")

    @pytest.mark.parametrize("snr_db", [2.0, 20.0, -10.0])
    def test_the_ratio_is_that_asked_for_in_every_channel(self, snr_db: float) -> None:
        clean = self.clean()
        noise = add_noise(clean, snr_db=snr_db, rng=np.random.default_rng(3)).y - clean.y
        ratio = np.mean(clean.y**2, axis=1) / np.mean(noise**2, axis=1)
        # The noise power over n samples scatters by sqrt(2 / n); five of these.
        assert np.max(np.abs(ratio / 10 ** (snr_db / 10) - 1)) < 5 * np.sqrt(2 / self.TIMES.size)

    def test_the_noise_is_white_gaussian_and_independent(self) -> None:
        clean, n = self.clean(), self.TIMES.size
        noise = add_noise(clean, snr_db=20.0, rng=np.random.default_rng(4)).y - clean.y
        noise = noise / np.std(noise, axis=1, keepdims=True)
        bound = 5 / np.sqrt(n)
        assert np.max(np.abs(np.mean(noise, axis=1))) < bound
        between_channels = noise @ noise.T / n - np.eye(3)
        assert np.max(np.abs(between_channels)) < bound + 1e-9
        for lag in (1, 2, 10):
            assert np.max(np.abs(np.mean(noise[:, lag:] * noise[:, :-lag], axis=1))) < bound
        # Fourth moment 3, of variance 96 / n.
        assert np.max(np.abs(np.mean(noise**4, axis=1) - 3)) < 5 * np.sqrt(96 / n)

    def test_a_seed_repeats_and_another_does_not(self) -> None:
        clean = self.clean()
        one, same, other = (add_noise(clean, snr_db=20.0, rng=np.random.default_rng(s)).y for s in (1, 1, 2))
        np.testing.assert_array_equal(one, same)
        assert np.all(one != other)

    def test_the_generator_moves_on(self) -> None:
        rng = np.random.default_rng(1)
        first, second = (add_noise(self.clean(), snr_db=20.0, rng=rng).y for _ in range(2))
        assert np.all(first != second)

    def test_the_original_is_untouched_and_its_labels_kept(self) -> None:
        clean = self.clean()
        before = clean.y.copy()
        noisy = add_noise(clean, snr_db=2.0, rng=np.random.default_rng(1))
        noisy.y[:] = 0.0
        np.testing.assert_array_equal(clean.y, before)
        assert noisy.output_labels == clean.output_labels
        np.testing.assert_array_equal(noisy.time, clean.time)

    def test_what_cannot_be_noisy_is_refused(self) -> None:
        rng = np.random.default_rng(1)
        silent = free_decay(paper_car(0, 0, 0), [0, 1], initial_state=np.zeros(6))
        with pytest.raises(InputError, match="channel 'seat' is zero throughout"):
            add_noise(silent, snr_db=20.0, rng=rng)
        with pytest.raises(InputError, match="snr_db=nan dB must be finite"):
            add_noise(self.clean(), snr_db=float("nan"), rng=rng)
        with pytest.raises(InputError, match="rng=3 is not a random generator"):
            add_noise(self.clean(), snr_db=20.0, rng=3)  # type: ignore[arg-type]
        with pytest.raises(RecordError, match="has 1 samples"):
            add_noise(free_decay(paper_car(), [0.0], initial_state=np.ones(6)), snr_db=20.0, rng=rng)
        with pytest.raises(RecordError, match="not ndarray"):
            add_noise(np.ones(4), snr_db=20.0, rng=rng)


class TestModesAndDecayAgree:
    def test_the_decay_is_the_sum_of_its_modes(self) -> None:
        car = heavy_car()
        modes, system = eigenmodes(car), statespace(car)
        poles, shapes = modes.poles, modes.shapes
        assert shapes is not None
        start = np.array([0.01, 0.0, -0.02, 0.0, 0.3, 1.0])
        # Amplitudes of mode and conjugate from displacements and velocities at the start.
        vectors = np.vstack([shapes, shapes * poles])
        full = np.hstack([vectors, vectors.conj()])
        amplitudes = np.linalg.solve(full, start)
        times = 0.01 * np.arange(300)
        expected = 2 * np.real((shapes * amplitudes[:3]) @ np.exp(poles[:, None] * times))
        found = free_decay(system, times, initial_state=start).y
        np.testing.assert_allclose(found, expected, rtol=0, atol=EXACT * np.max(np.abs(expected)))
