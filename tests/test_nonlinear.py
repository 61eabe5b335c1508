"""Modes that depend on their amplitude, by the laws of one mass with friction, drag or a cubic spring.

The motions are those of an integrator of their own (event-exact for friction), and the expected values the textbook's:
energy lost in a cycle for damping, the first term of Lindstedt and Poincaré for frequency.
"""

import json
from collections.abc import Callable
from dataclasses import replace

import control
import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from suspid import add_noise, free_decay, identify, plot_amplitude, quarter_car
from suspid.identification import ForceKind, Identification, identification_to_dict
from suspid.identification.noise import noise_of
from suspid.identification.nonlinear.driven import Drive, evaluate
from suspid.identification.nonlinear.swings import Swings, _changed_by_forces, swings_of
from suspid.identification.nonlinear.turns import extremes
from suspid.records import as_response
from suspid.words import Level, ModeCheck, Reason
from validation import no_decay
from validation.friction import Rig, release, released

Real = NDArray[np.float64]


def response(time: Real, values: Real, *names: str) -> control.TimeResponseData:
    return as_response(time, np.atleast_2d(values), names or ("x",))


def noisy(values: Real, seed: int, share: float = 1e-3) -> Real:
    return np.asarray(
        values + share * np.max(np.abs(values)) * np.random.default_rng(seed).standard_normal(values.shape)
    )


def integrated(time: Real, force: Callable[[float, float], float], start: float = 1.0) -> Real:
    """Return the displacement of a unit mass on a unit spring that runs 2 pi times faster, released from ``start``."""
    wn = 2 * np.pi

    def rate(_: float, state: Real) -> list[float]:
        return [state[1], -(wn**2) * state[0] - force(state[0], state[1])]

    out = solve_ivp(rate, (0, time[-1]), [start, 0.0], t_eval=time, rtol=1e-10, atol=1e-12)
    return np.asarray(out.y[0], float)


def from_bilinear_damper(time: Real, zetas: tuple[float, float], wn: float) -> Real:
    """Return the motion from 1 on of a mass with a damping ratio while it falls and another while it rises: exact."""
    out, begun, size = np.empty_like(time), 0.0, 1.0
    for zeta in [*zetas] * int(time[-1] * wn):
        turned = np.sqrt(1 - zeta**2)
        since = wn * (time - begun)
        swing = np.cos(turned * since) + zeta / turned * np.sin(turned * since)
        out = np.where(since >= 0, size * np.exp(-zeta * np.maximum(since, 0.0)) * swing, out)
        begun, size = begun + np.pi / (wn * turned), -size * np.exp(-zeta * np.pi / turned)
    return np.asarray(out)


def kinds(found: Identification) -> set[ForceKind]:
    return {force.kind for force in found.forces}


class TestFriction:
    """One mass: friction loses ``4 F A`` in a cycle, as a damper of ``zeta = 2 F / (pi k A)`` does."""

    rig = Rig(mass=(1.0,), stiffness=(400.0,), damping=(0.4,), friction=(2.0,))
    time = np.asarray(np.arange(0, 2.4, 0.004), float)

    def found(self, seed: int = 0) -> Identification:
        motion, stop = released(self.rig, np.array([0.3]), self.time)
        assert stop > self.time[-1]
        return identify(response(self.time, noisy(motion, seed)))

    def test_one_mode_with_its_frequency(self) -> None:
        found = self.found()
        assert ForceKind.FRICTION in kinds(found)
        assert len(found.modes) == 1
        assert found.modes.wn[0] == pytest.approx(20.0, rel=0.01)
        assert found.verdict.level in (Level.CARE, Level.DOUBTFUL)
        assert ModeCheck.AMPLITUDE in {check.remark.code for check in found.verdict.checks}

    @pytest.mark.parametrize("seed", range(3))
    def test_damping_over_amplitude_follows_the_energy_lost(self, seed: int) -> None:
        (each,) = self.found(seed).amplitude_dependence
        large = each.amplitude > 0.1
        law = 0.4 / (2 * 20.0) + 2 * 2.0 / (np.pi * 400.0 * each.amplitude[large])
        assert np.sum(large) >= 2
        np.testing.assert_allclose(each.zeta[large], law, rtol=0.06)

    def test_text_and_verdict_have_the_numbers_of_the_table(self) -> None:
        found = self.found()
        (each,) = found.amplitude_dependence
        lines = str(found).splitlines() + str(found.details()).splitlines()
        hertz, std = each.wn[0] / (2 * np.pi), each.wn_std[0] / (2 * np.pi)
        row = f"{each.amplitude[0]:.3g} {hertz:.5g} {std:.2g} {each.zeta[0]:.3g}"
        assert any(" ".join(line.split()).startswith(row) for line in lines)
        (check,) = [one for one in found.verdict.checks if one.remark.code is ModeCheck.AMPLITUDE]
        for end, wn in zip(("high", "low"), (each.ends[0][0], each.ends[1][0]), strict=True):
            assert check.remark.numbers[f"{end}_hz"] == pytest.approx(wn / (2 * np.pi))

    def test_the_residual_is_the_noise(self) -> None:
        found = self.found()
        assert found.noise_std[0] == pytest.approx(3e-4, rel=0.2)

    def test_two_masses_have_two_modes(self) -> None:
        record = release(2, 12, seed=907)
        first = int(np.searchsorted(record.timepts, record.start)) + 1
        last = int(np.searchsorted(record.timepts, record.stop))
        found = identify(
            response(record.timepts[first:last] - record.timepts[first], record.position[:, first:last], "a", "b")
        )
        assert len(found.modes) == 2
        np.testing.assert_allclose(found.modes.wn, record.rig.wn, rtol=0.01)


class TestSmooth:
    time = np.asarray(np.arange(0, 20, 0.02), float)

    @pytest.mark.parametrize("seed", range(2))
    def test_a_cubic_spring_raises_the_frequency(self, seed: int) -> None:
        wn, zeta, hard = 2 * np.pi, 0.02, 0.1
        motion = integrated(self.time, lambda d, v: 2 * zeta * wn * v + hard * wn**2 * d**3)
        found = identify(response(self.time, noisy(motion, seed)))
        (each,) = found.amplitude_dependence
        assert len(found.modes) == 1
        # wn(A) = wn (1 + 3/8 hard A^2), to the first order in it.
        np.testing.assert_allclose(each.wn, wn * (1 + 0.375 * hard * each.amplitude**2), rtol=2e-3)
        np.testing.assert_allclose(each.zeta, zeta, rtol=0.06)

    def test_drag_falls_with_the_amplitude(self) -> None:
        wn, drag = 2 * np.pi, 0.05
        motion = integrated(self.time, lambda _, v: 2 * 0.005 * wn * v + drag * abs(v) * v)
        found = identify(response(self.time, noisy(motion, 1)))
        (each,) = found.amplitude_dependence
        # Energy lost in a cycle: 8/3 drag A^3 wn^2 = 2 pi zeta wn^2 A^2.
        law = 0.005 + 4 * drag * each.amplitude / (3 * np.pi)
        np.testing.assert_allclose(each.zeta, law, rtol=0.05)

    def test_a_pendulum_of_large_swings_is_one_mode(self) -> None:
        wn = 2 * np.pi
        motion = integrated(self.time, lambda d, v: 2 * 0.01 * wn * v + wn**2 * (np.sin(d) - d), start=0.9)
        found = identify(response(self.time, noisy(motion, 2)))
        (each,) = found.amplitude_dependence
        np.testing.assert_allclose(each.wn, wn * (1 - each.amplitude**2 / 16), rtol=2e-3)


class TestSwings:
    def test_slopes_of_the_mean_pole_are_its_differences(self) -> None:
        """Mean wn and zeta of the cycles, computed here from the exponents that are a little off."""
        real, imaginary = 0.3 * np.random.default_rng(1).standard_normal((2, 1, 6))
        slopes = np.asarray(real + 1j * imaginary, complex)
        swings = Swings(
            time=np.array([0.0, 10.0, 20.5, 31.0, 41.5, 52.5]),
            size=np.array([1.0, 0.6, 0.42, 0.3, 0.2, 0.17]),
            slopes=slopes,
            own=np.array([0]),
            free=2,
        )

        def mean(change: Real) -> complex:
            cycles = [swings.pole(first, first + 2) for first in range(4)]
            exponents = np.array([pole + complex(*(by @ change)) for pole, by in cycles])
            wn, zeta = np.mean(np.abs(exponents)), np.mean(-exponents.real / np.abs(exponents))
            return complex(wn * (-zeta + 1j * np.sqrt(1 - zeta**2)))

        pole, by = swings.mean()
        assert pole == pytest.approx(mean(np.zeros(2)))
        for own, step in enumerate(1e-6 * np.eye(2)):
            difference = (mean(step) - mean(-step)) / 2e-6
            assert complex(*by[:, own]) == pytest.approx(difference, rel=1e-6)

    @pytest.mark.parametrize("missed", [0.4, 2.6])
    def test_a_turn_just_before_the_record_is_where_the_motion_turned(self, missed: float) -> None:
        theta = 0.1 * (-0.03 + 1j * np.sqrt(1 - 0.03**2))
        # The speed, which is that of theta times the state, is 0 at -missed.
        turned = 1j * np.exp(theta * missed) / theta
        values = np.real(turned * np.exp(theta * np.arange(200)))[None]
        drive = Drive(
            theta=np.array([theta]),
            gains=np.zeros((1, 0), complex),
            forces=np.zeros((0, 200)),
            nuisances=np.zeros(0),
        )
        fit = evaluate(values, drive, noise_of(values))
        assert fit is not None
        swings = swings_of(fit, 0)
        assert swings is not None
        # Its middle is a quarter of a period after it.
        assert swings.time[0] == pytest.approx(np.pi / 2 / theta.imag - missed, abs=2e-3)
        np.testing.assert_allclose(np.diff(np.log(swings.size)), -0.03 * np.pi / np.sqrt(1 - 0.03**2), rtol=2e-3)

    @pytest.mark.parametrize("as_acceleration", [False, True])
    def test_the_swings_are_those_of_the_channel_unless_that_is_an_acceleration(self, as_acceleration: bool) -> None:
        theta = 0.1 * (-0.02 + 1j * np.sqrt(1 - 0.02**2))
        plain = np.exp(theta * np.arange(400)).real
        gain, shown = (0.003j, 0.03) if as_acceleration else (0.0, 0.2)
        drive = Drive(
            theta=np.array([theta]),
            gains=np.array([[gain]], complex),
            forces=plain[None] ** 3,
            nuisances=np.zeros(0),
            through=True,
        )
        state = evaluate(plain[None], replace(drive, through=False), noise_of(plain[None]))
        assert state is not None
        mode = state.states[0].real
        values = (mode + shown * drive.forces[0])[None] + 1e-6 * np.random.default_rng(1).standard_normal(400)
        fit = evaluate(values, drive, noise_of(values))
        assert fit is not None
        swings = swings_of(fit, 0)
        assert swings is not None
        # The turning points of the samples themselves: a crest between two samples is higher by less than 1 %.
        of = mode if as_acceleration else values[0]
        turns = of[1:-1][np.diff(np.sign(np.diff(of))) != 0]
        np.testing.assert_allclose(swings.size[-len(turns) + 1 :], np.abs(np.diff(turns)) / 2, rtol=4e-3)
        fall = np.log(swings.size[:-1] / swings.size[1:])
        assert (np.ptp(fall) > 0.01) is not as_acceleration

    @pytest.mark.parametrize("times", [[1.9, 2.0, 2.1], [3.1, 3.3, 3.4, 5.0], [1.0, 4.0, 8.8, 9.45]])
    def test_turns_between_the_same_samples_share_them(self, times: list[float]) -> None:
        motion = np.sin(np.arange(10.0))
        found = extremes(motion, np.array(times))
        assert found.shape == (len(times),)
        assert np.all(np.abs(found) <= 1.01)

    def test_the_pole_of_a_mode_is_told_by_the_middles_of_its_swings(self) -> None:
        """The logarithm of its state changes with the exponent as time goes on."""
        theta = 0.1 * (-0.02 + 1j * np.sqrt(1 - 0.02**2))
        values = np.exp(theta * np.arange(400)).real[None]
        none = Drive(
            theta=np.array([theta]), gains=np.zeros((1, 0), complex), forces=np.zeros((0, 400)), nuisances=np.zeros(0)
        )
        fit = evaluate(values, none, noise_of(values))
        assert fit is not None
        swings = swings_of(fit, 0)
        assert swings is not None
        # The first turn is just before the record.
        np.testing.assert_allclose(swings.slopes[0, 1:], swings.time[1:], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(swings.time, (np.arange(len(swings.time)) + 0.5) * np.pi / theta.imag, atol=0.3)

    def test_forces_that_cancel_each_other_change_no_swing(self) -> None:
        """Two of them are alike to a thousandth; what they show together is what the gain says."""
        theta = 0.1 * (-0.02 + 1j * np.sqrt(1 - 0.02**2))
        time = np.arange(400)
        force = np.exp(theta * time).real ** 3
        drive = Drive(
            theta=np.array([theta]),
            gains=np.array([[0.003j, 0.0]]),
            forces=np.array([force, force + 1e-3 * np.sin(3.3 * time)]),
            nuisances=np.zeros(0),
            through=True,
        )
        alone = evaluate(force[None], replace(drive, through=False), noise_of(force[None]))
        assert alone is not None
        values = (alone.states[0].real + np.array([-2.97, 3.0]) @ drive.forces)[None]
        fit = evaluate(values, drive, noise_of(values))
        assert fit is not None
        assert np.max(np.abs(fit.coefficients[-2:])) > 1
        assert not _changed_by_forces(fit, 0, 0)

    def test_a_pole_that_falls_at_once_is_not_continued_before_the_record(self) -> None:
        """Steps of a descent meet such poles; exp(2000) overflows, and users saw the warning of NumPy."""
        forces = np.cos(0.1 * np.arange(200))[None]
        drive = Drive(
            theta=np.array([-2000 + 1j]), gains=np.ones((1, 1), complex), forces=forces, nuisances=np.zeros(0)
        )
        fit = evaluate(forces, drive, noise_of(forces))
        assert fit is not None
        with np.errstate(over="raise", invalid="raise"):
            assert swings_of(fit, 0) is not None


class TestRounded:
    def test_steps_of_an_encoder_leave_no_bias(self) -> None:
        """An optimum at which the residual is less than rounding leaves on average is still an optimum."""
        time, zetas, wn = np.arange(0, 2, 0.005), (0.0137, 0.0411), 2 * np.pi * 6.77
        decrement = np.mean([zeta / np.sqrt(1 - zeta**2) for zeta in zetas])
        step, errors = 0.0022, []
        for seed in range(10, 16):
            rng = np.random.default_rng(seed)
            values = from_bilinear_damper(time + 0.01 * rng.uniform(), zetas, wn)
            modes = identify(response(time, step * np.round(values / step + rng.uniform(-0.5, 0.5)))).modes
            assert modes.zeta_std is not None
            errors.append((modes.zeta[0] - decrement / np.hypot(1, decrement)) / modes.zeta_std[0])
        # The mean square of six standard normal variables is below 2.8 with probability .99.
        assert np.mean(np.square(errors)) < 2.8


class TestLinear:
    @pytest.mark.parametrize("seed", range(6))
    def test_a_linear_decay_has_no_forces(self, seed: int) -> None:
        car = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=400
        )
        record = free_decay(car, np.arange(0, 6, 0.005), initial_state={"v_chassis": 1.0})
        found = identify(add_noise(record, snr_db=40.0, rng=np.random.default_rng(seed)))
        assert found.forces == ()
        assert found.amplitude_dependence == ()

    def test_two_close_modes_in_one_channel_are_no_friction(self) -> None:
        time = np.asarray(np.arange(0, 20, 0.01), float)
        values = np.exp(-0.3 * time) * np.cos(10 * time) + 0.8 * np.exp(-0.25 * time) * np.cos(11 * time + 1)
        found = identify(response(time, noisy(values, 3)))
        assert len(found.modes) == 2
        assert found.forces == ()


class TestShown:
    def found(self) -> Identification:
        return TestFriction().found()

    def test_in_text_json_and_picture(self) -> None:
        found = self.found()
        (each,) = found.amplitude_dependence
        rows = [f"{amplitude:.3g}" for amplitude in each.amplitude]
        for text, shown in ((str(found), 5), (found.details(), len(rows))):
            table = text.partition("amplitude in x")[2].partition("\n\n")[0]
            assert [line.split()[0] for line in table.splitlines()[2 : 2 + shown]][:: shown - 1] == [rows[0], rows[-1]]
            assert ("more in .details()" in table) is (shown < len(rows))
            held = f"the frequency is that at an amplitude of {each.holds_at:.3g} in x, others are below"
            assert f"mode 1: means over all cycles; {held}" in text.splitlines()
        content = json.loads(json.dumps(identification_to_dict(found, file="x.csv", warnings=())))
        assert content["forces"][0]["kind"] == "friction"
        assert len(content["amplitude_dependence"][0]["zeta"]) == len(found.amplitude_dependence[0].zeta)
        axes = Figure().subplots(2, 1, squeeze=False)
        plot_amplitude(found, axes=axes)
        np.testing.assert_allclose(
            np.sort(axes[1, 0].lines[0].get_ydata()), np.sort(found.amplitude_dependence[0].zeta)
        )

    def test_poles_of_the_linear_fit_are_named(self) -> None:
        codes = {each.remark.code for each in self.found().considered}
        assert codes <= {Reason.SAME_MODE, Reason.HARMONIC, Reason.DISTORTION}
        assert codes


class TestMeans:
    def test_of_friction_alone_are_those_of_its_cycles(self) -> None:
        # Each turn is 2 F / k nearer to rest, each swing lasts pi / wn: from 20 mm on, nearer by 2.4 mm a swing.
        wn, size, loss = 2 * np.pi * 5.0, 20.0, 2.4
        time = np.arange(0.0, 8 * np.pi / wn, 1e-3)
        swing = (time * wn / np.pi).astype(int)
        middle = 0.5 * loss * (-1.0) ** swing
        values = (size - loss * (swing + 0.5)) * np.cos(wn * time) + middle
        values += 0.01 * np.random.default_rng(1).standard_normal(len(time))
        modes = identify(as_response(time, values, ["x [mm]"])).modes
        swings = size - loss * (np.arange(8) + 0.5)
        zeta = np.log(swings[:-2] / swings[2:]) / (2 * np.pi)
        zeta /= np.sqrt(1 + zeta**2)
        np.testing.assert_allclose(modes.zeta, [np.mean(zeta)], rtol=5e-3)
        np.testing.assert_allclose(modes.wn, [np.mean(wn / np.sqrt(1 - zeta**2))], rtol=2e-4)


@pytest.mark.parametrize(("first", "last"), [(1185, 1219), (1866, 1902)])
def test_in_few_noisy_samples_no_forces_are_found(first: int, last: int) -> None:
    """Noise through two resonances, 35 samples of it: of many forces, some explain it by chance."""
    time, values = no_decay.KINDS["speech-like modulation"](np.random.default_rng(1_000_003))
    part = as_response(time[first:last], values[:, first:last], ["a", "b", "c"])
    assert not identify(part).forces
