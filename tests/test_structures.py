"""Structures under forces that follow their motion, beside exact motions of rigs."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import analyse, clean, identify, read_recording
from suspid.identification import ForceKind, Identification
from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear import beginnings
from suspid.identification.nonlinear.amplitude import _part_pairs
from suspid.identification.nonlinear.beginnings import begun, stops_soon
from suspid.identification.nonlinear.bent_motion import BentSteps
from suspid.identification.nonlinear.descent import fitted
from suspid.identification.nonlinear.driven import Drive, DrivenFit, evaluate, maximize
from suspid.identification.nonlinear.feedback import Record, nonlinear_part
from suspid.identification.nonlinear.forces import Force
from suspid.identification.nonlinear.guesses import with_friction
from suspid.identification.nonlinear.linearised import mean_poles, modes_of_structure
from suspid.identification.nonlinear.motion import Structures, motion_of
from suspid.identification.nonlinear.structure import StructureFit, gains_of, structure_of
from suspid.identification.nonlinear.structure import evaluated as structure_evaluated
from suspid.identification.nonlinear.swings import swings_of
from suspid.records import as_response, cut, of_channels
from validation import rigs
from validation.friction import Rig, released

Real = NDArray[np.float64]

RIG = Rig(mass=(1.0, 2.0), stiffness=(4000.0, 3000.0), damping=(2.0, 1.5), friction=(8.0, 6.0))
LIGHT = replace(RIG, friction=(3.0, 2.0))
STEP = 1e-5
HELD = np.array([0.02, 0.05])
TIME = np.asarray(np.arange(260) / 250, float)


def structure(rig: Rig, held: Real, step: float) -> Structures:
    """Return the modes of a rig released from rest, per sample."""
    stiff, damp, friction = rig.accelerations()
    count = len(friction)
    system = np.block([[np.zeros((count, count)), np.eye(count)], [-stiff, -damp]])
    poles, vectors = np.linalg.eig(system)
    left = np.linalg.inv(vectors)
    upper = np.flatnonzero(poles.imag > 0)
    start = (left @ np.concatenate([held, np.zeros(count)]))[upper]
    push = (left @ np.vstack([np.zeros((count, count)), -np.diag(friction)]))[upper]
    return Structures(
        theta=np.asarray(poles[None, upper] * step, complex),
        shapes=(2 * vectors[:count, upper] * start).T[None],
        gains=(push / start[:, None])[None] * step,
        forces=tuple(Force(kind=ForceKind.FRICTION, channel=c, other=None) for c in range(count)),
        scales=np.ones(count),
    )


def test_a_pole_next_to_the_real_axis_has_no_amplitude_without_bound() -> None:
    """The sine of 1e-160 rad a sample is nothing: what is left of a decay would be 1e160 of it."""
    noise, values = WhiteNoise(least=np.zeros(1)), np.exp(-0.05 * np.arange(100.0))[None] + 0.01
    for turn, found in ((1e-160, False), (1e-2, True)):
        drive = Drive(
            theta=np.array([-0.05 + 1j * turn]), gains=np.zeros((1, 0), complex), forces=np.zeros((0, 100)),
            nuisances=np.zeros(1),
        )  # fmt: skip
        assert (evaluate(values, drive, noise) is not None) is found


def test_means_over_cycles_do_not_jump_where_one_more_has_room() -> None:
    """Of 2.4 to 2.6 cycles under friction; the means over two and over three side by side differ by a fifth."""
    of = structure(RIG, HELD, 1 / 250)
    values = np.asarray((of.shapes[0].T @ motion_of(of, 200).states[0]).real, float)
    record = Record(
        values=values + 1e-6 * np.random.default_rng(1).standard_normal(values.shape),
        noise=WhiteNoise(least=np.full(2, 1e-14)), theta=of.theta[0], amplitudes=of.shapes[0], nuisances=np.zeros(1),
    )  # fmt: skip
    fit, cycle = structure_evaluated(record, of, 0), 2 * np.pi / float(np.min(of.theta.imag))
    ends = [round(cycles * cycle) for cycles in (2.4, 2.45, 2.5, 2.55, 2.6)]
    poles = np.array([mean_poles(fit, of, fit.motion, slice(0, end))[0] for end in ends])
    zeta = -poles.real / np.abs(poles)
    assert np.all(zeta[:, 0] > 2 * -of.theta[0, 0].real / np.abs(of.theta[0, 0]))
    assert np.max(np.abs(np.diff(zeta, axis=0) / zeta[1:])) < 0.1


class TestSwingsOfWhatIsShown:
    """Forces that show in a channel at once, fitted freely: the swings are those of the channel, not of the state."""

    COUNT, THETA = 600, -0.002 + 0.21j

    def found(self, *, direct: float, gain: complex = 0.0) -> tuple[DrivenFit, NDArray[np.float64]]:
        """Return a fit with a cubic force and the logarithmic decrement of each of its channel's swings."""
        noise, state = WhiteNoise(least=np.zeros(1)), np.exp(self.THETA * np.arange(self.COUNT))
        plain = Drive(
            theta=np.array([self.THETA]), gains=np.zeros((1, 0), complex), forces=np.zeros((0, self.COUNT)),
            nuisances=np.zeros(1),
        )  # fmt: skip
        alone = evaluate(np.asarray(state.real[None]), plain, noise)
        assert alone is not None
        force = nonlinear_part(
            Force(kind=ForceKind.CUBIC, channel=0, other=None).sampled(state.real[None], state.imag[None]), alone
        )
        drive = replace(plain, forces=force[None], gains=np.array([[gain]]), through=True)
        motion = evaluate(np.asarray(state.real[None]), drive, noise)
        assert motion is not None
        values = motion.states[0].real + direct * force
        fit = evaluate(values[None], drive, noise)
        assert fit is not None
        turns = np.flatnonzero((np.diff(values)[1:] > 0) != (np.diff(values)[:-1] > 0)) + 1
        peaks = [np.polyfit(range(-3, 4), values[k - 3 : k + 4], 4) for k in turns if 3 <= k < self.COUNT - 3]
        tops = np.array([np.max(np.abs(np.polyval(each, np.linspace(-2, 2, 401)))) for each in peaks])
        return fit, np.log(tops[:-10] / tops[10:]) / (10 * np.pi)

    def test_they_fall_as_those_of_the_channel(self) -> None:
        fit, decrements = self.found(direct=0.05)
        assert np.ptp(decrements) > 0.2 * np.mean(decrements)
        swings = swings_of(fit, 0)
        assert swings is not None
        of_swings = np.log(swings.size[:-10] / swings.size[10:]) / (10 * np.pi)
        used = slice(5, min(len(of_swings), len(decrements)) - 5)
        # A cubic force has a third harmonic, which tops have and the swings of a mode have not.
        assert np.max(np.abs(of_swings[used] - decrements[used])) < 0.05 * np.mean(decrements)

    def test_without_a_force_they_are_those_of_the_state(self) -> None:
        fit, _ = self.found(direct=0.05)
        none = evaluate(fit.values, fit.drive.without_force(0), fit.noise)
        assert none is not None
        assert none.drive.through
        swings = swings_of(none, 0)
        assert swings is not None
        rate, turn = self.THETA.real, self.THETA.imag
        assert swings.size[:-10] / swings.size[10:] == pytest.approx(np.exp(-rate * 10 * np.pi / turn), rel=1e-4)

    @pytest.mark.parametrize("share", [0.0, 1.0])
    def test_what_the_gain_says_is_an_acceleration_and_changes_nothing(self, share: float) -> None:
        """Nor does a displacement, in which the force does not show at all."""
        gain = 0.002j
        direct = share * float(np.real(gain / self.THETA))
        fit, _ = self.found(direct=direct, gain=gain)
        without = replace(fit, drive=replace(fit.drive, through=False))
        one, other = swings_of(fit, 0), swings_of(without, 0)
        assert one is not None
        assert other is not None
        # A displacement is measured at its turns, of which the record may miss the last.
        assert len(one.size) >= len(other.size) - 1
        assert one.size == pytest.approx(other.size[: len(one.size)], rel=1e-3)


class TestMotion:
    def test_is_that_of_the_rig_with_masses_that_stop_and_break_loose(self) -> None:
        exact, stop = released(RIG, HELD, TIME)
        modes = structure(RIG, HELD, float(TIME[1]))
        motion = motion_of(modes, len(TIME))
        found = np.einsum("kc,kn->cn", modes.shapes[0], motion.states[0]).real
        assert stop < TIME[-1]
        # Events are placed to the square of a step: 3e-4 of the swing.
        assert np.max(np.abs(found - exact)) < 5e-4 * np.max(np.abs(exact))

    def test_accelerations_rest_where_the_ground_and_a_strut_hold_both_masses(self) -> None:
        """What holds one mass is beside what holds the other; derivatives to any size of change are the same there."""
        rig = replace(RIG, friction=(10.0, 10.0))
        plain = structure(rig, HELD, float(TIME[1]))
        forces = tuple(Force(kind=ForceKind.FRICTION, channel=c, other=other) for c, other in ((0, None), (1, 0)))
        slowed = np.array([[10.0, -10.0], [0.0, 10.0]]) / np.array(rig.mass)[:, None] * float(TIME[1]) ** 2
        modes = replace(plain, forces=forces, gains=gains_of(plain.theta, plain.shapes, slowed))
        motion = motion_of(modes, len(TIME))
        speeds = np.einsum("kc,kn->cn", modes.shapes[0] * modes.theta[0][:, None], motion.states[0]).real
        assert np.max(np.abs(speeds[:, -100:])) < 1e-12 * np.max(np.abs(speeds))
        assert np.all(np.ptp(motion.acting[0][:, -100:], axis=1) < 1e-9)
        assert np.max(np.abs(motion.acting[0][:, -100:])) < 1.0
        record = Record(
            values=speeds, noise=WhiteNoise(least=np.ones(2)), theta=modes.theta[0], amplitudes=modes.shapes[0],
            nuisances=np.zeros(1),
        )  # fmt: skip
        norms = []
        for change in (1e-7, 1e-6, 1e-5):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr("suspid.identification.nonlinear.structure.CHANGE", change)
                fit = structure_evaluated(record, modes, 2)
                norms.append(np.linalg.norm(fit.nearby.slopes(fit), axis=1))
        assert norms[0] == pytest.approx(norms[1], rel=0.02)
        assert norms[2] == pytest.approx(norms[1], rel=0.02)

    def test_what_rests_is_what_further_steps_would_give(self, monkeypatch: pytest.MonkeyPatch) -> None:
        modes = structure(RIG, HELD, float(TIME[1]))
        at_once = motion_of(modes, len(TIME))
        monkeypatch.setattr("suspid.identification.nonlinear.rubbed_motion.RubbedSteps.rests", lambda *_: False)
        by_steps = motion_of(modes, len(TIME))
        assert np.max(np.abs(at_once.states - by_steps.states)) < 1e-12
        assert np.max(np.abs(at_once.acting - by_steps.acting)) < 1e-9

    def test_friction_is_less_than_its_limit_where_a_mass_is_held(self) -> None:
        modes = structure(RIG, HELD, float(TIME[1]))
        acting = motion_of(modes, len(TIME)).acting[0]
        assert np.max(np.abs(acting)) <= 1.0
        assert np.all(np.ptp(acting[:, -20:], axis=1) < 1e-6)
        assert np.max(np.abs(acting[:, -20:])) < 1.0


def test_amplitudes_that_are_lost_in_the_noise_are_not_described() -> None:
    """Friction has stopped both masses well before the record ends: there a mode has an amplitude, but none is seen."""
    rig, time = replace(RIG, friction=(1.2, 0.9), damping=(0.5, 0.4)), np.arange(1200) / 250
    modes = structure(rig, HELD, float(time[1]))
    states = motion_of(modes, len(time)).states[0]
    exact = (modes.shapes[0].T @ states).real
    # The last third stands still.
    assert np.ptp(exact[:, 800:]) < 1e-3
    size = 0.02 * float(np.max(np.abs(exact)))
    values = exact + size * np.random.default_rng(3).standard_normal(exact.shape)
    noise = WhiteNoise(least=np.zeros(2))
    record = Record(values=values, noise=noise, theta=modes.theta[0], amplitudes=modes.shapes[0], nuisances=np.zeros(1))
    fit = structure_evaluated(record, modes, 0)
    _, _, described = modes_of_structure(fit, timepts=time, channels=("one", "two"))
    assert [len(each.amplitude) for each in described] == [5, 1]
    assert np.min(described[0].amplitude) > 3 * size
    assert described[0].spans[-1][1] < time[800]


def test_derivatives_of_driven_states_are_those_of_differences() -> None:
    """By each pole and by each gain, along the real axis: states are analytic in both."""
    rng = np.random.default_rng(6)
    theta, gains = np.array([-0.02 + 0.3j, -0.01 + 0.5j]), np.array([[0.02j, 0.01], [0.03, -0.01j]])
    drive = Drive(theta=theta, gains=gains, forces=rng.standard_normal((2, 200)), nuisances=np.zeros(1))

    def fit_of(changed: Drive) -> DrivenFit:
        fit = evaluate(rng.standard_normal((1, 200)), changed, WhiteNoise(least=np.zeros(1)))
        assert fit is not None
        return fit

    def change(**fields: NDArray[np.complex128]) -> NDArray[np.complex128]:
        there, back = (
            fit_of(replace(drive, **{k: getattr(drive, k) + s * v for k, v in fields.items()})) for s in (1, -1)
        )
        return np.asarray(there.states - back.states)

    fit, step = fit_of(drive), 1e-6
    shifts = [{"theta": step * np.eye(2, dtype=complex)[k]} for k in range(2)]
    shifts += [{"gains": step * np.eye(4, dtype=complex)[k].reshape(2, 2)} for k in range(4)]
    for slope, owner, shift in zip(fit.slopes, fit.owners, shifts, strict=True):
        expected = change(**shift)[owner] / (2 * step)
        assert np.max(np.abs(slope - expected)) < 1e-6 * np.max(np.abs(expected))


def test_the_parts_of_a_driven_mode_end_in_the_noise() -> None:
    """Two modes that fall from 1 through three standard deviations of .01 at samples 175 and 351 of 600."""
    theta, time = np.array([-0.02 + 0.3j, -0.01 + 0.5j]), np.arange(600)
    noise = 0.01 * np.random.default_rng(4).standard_normal((1, 600))
    drive = Drive(theta=theta, gains=np.zeros((2, 0), complex), forces=np.zeros((0, 600)), nuisances=np.zeros(1))
    values = np.exp(np.outer(theta, time)).real.sum(axis=0) + noise
    fit = evaluate(np.asarray(values), drive, WhiteNoise(least=np.zeros(1)))
    assert fit is not None
    ends = [_part_pairs(fit, pole)[-1][1] for pole in range(2)]
    assert ends == pytest.approx([np.log(1 / 0.03) / 0.02, np.log(1 / 0.03) / 0.01], rel=0.05)


class TestMotionOfSmoothForces:
    """Beside the simulator of `validation.rigs`, which knows nothing of modes."""

    RIG = rigs.Rig(
        mass=np.array([1.0, 2.0]),
        stiffness=np.array([4000.0, 3000.0]),
        damping=np.array([4.0, 6.0]),
        friction=np.zeros(2),
        cubic=np.zeros(2),
    )

    @pytest.mark.parametrize(
        ("kind", "changed"),
        [(ForceKind.BENT_DAMPER, {"rebound": 3.0}), (ForceKind.CUBIC, {"cubic": np.array([300.0, 150.0])})],
    )
    # Ten and four samples in a period of the second mode: steps within samples, and samples within steps.
    @pytest.mark.parametrize("step", [0.0008, 0.02])
    def test_is_that_of_the_rig(self, kind: ForceKind, changed: dict[str, Any], step: float) -> None:
        bent = replace(self.RIG, **changed)
        time = np.asarray(np.arange(round(1.0 / step)) * step, float)
        exact = rigs.released(bent, HELD, time).position
        modes = self.structure(bent, kind, step)
        motion = motion_of(modes, len(time))
        found = np.einsum("kc,kn->cn", modes.shapes[0], motion.states[0]).real
        linear = rigs.released(self.RIG, HELD, time).position
        # The steps leave a hundredth of what the force does.
        assert np.max(np.abs(found - exact)) < 0.02 * np.max(np.abs(linear - exact))

    @staticmethod
    def structure(rig: rigs.Rig, kind: ForceKind, step: float) -> Structures:
        """Return the modes of a rig and the force of each spring or damper."""
        count = len(rig.mass)
        inverse = np.diag(1 / rig.mass)
        stiff, damp = (inverse @ rig.links.T @ np.diag(each) @ rig.links for each in (rig.stiffness, rig.damping))
        size = (
            rig.stiffness * rig.cubic
            if kind is ForceKind.CUBIC
            else rig.damping * (rig.rebound - 1) / (rig.rebound + 1)
        )
        poles, vectors = np.linalg.eig(np.block([[np.zeros((count, count)), np.eye(count)], [-stiff, -damp]]))
        left, upper = np.linalg.inv(vectors), np.flatnonzero(poles.imag > 0)
        start = (left @ np.concatenate([HELD, np.zeros(count)]))[upper]
        push = (left @ np.vstack([np.zeros((count, count)), -inverse @ rig.links.T @ np.diag(size)]))[upper]
        return Structures(
            theta=np.asarray(poles[None, upper] * step, complex),
            # Speeds are per sample.
            shapes=(2 * vectors[:count, upper] * start).T[None],
            gains=(push / start[:, None])[None] * (step if kind is ForceKind.CUBIC else 1.0),
            forces=(Force(kind=kind, channel=0, other=None), Force(kind=kind, channel=1, other=0)),
            scales=np.ones(count),
        )


class TestBentSteps:
    """Newton's method over all steps at once, beside one step after the other."""

    @pytest.mark.parametrize("kind", [kind for kind in ForceKind if kind is not ForceKind.FRICTION])
    def test_all_steps_at_once_are_those_one_by_one(self, kind: ForceKind) -> None:
        steps, start = self.steps(kind), np.repeat([1.0, 0.0], 2)
        found, expected = steps.states(start, 400), steps.one_by_one(start, 400)
        # The force does something.
        free = BentSteps(kind=kind, rotation=steps.rotation, answer=0 * steps.answer, seen=steps.seen)
        assert np.max(np.abs(expected - free.one_by_one(start, 400))) > 0.02
        assert found is not None
        assert np.max(np.abs(found[0] - expected[0])) < 1e-12
        apart, changes = found[1:] - found[0], expected[1:] - expected[0]
        assert np.max(np.abs(apart - changes)) < 1e-3 * np.max(np.abs(changes))

    def test_a_motion_that_runs_away_is_none(self) -> None:
        steps = self.steps(ForceKind.CUBIC)
        pushed = BentSteps(kind=steps.kind, rotation=steps.rotation, answer=-80 * steps.answer, seen=steps.seen)
        with np.errstate(all="ignore"):
            assert pushed.states(np.repeat([1.0, 0.0], 2), 400) is None

    @staticmethod
    def steps(kind: ForceKind) -> BentSteps:
        """Return steps of two modes with a force each, and beside them those with a pole or a gain a little changed."""
        turn = np.tile([-0.003 + 0.11j, -0.006 + 0.31j], (3, 1))
        gain = np.tile(np.array([[-0.02j, 0.01j], [0.008j, -0.03j]]), (3, 1, 1))
        turn[1, 0] += 1e-6
        gain[2, 1, 1] += 1e-6
        held = np.swapaxes((np.expm1(turn) / turn)[:, :, None] * gain, 1, 2)
        place = np.tile(np.array([[1.0, 0.4], [0.3, -0.8]], complex), (3, 1, 1))
        return BentSteps.of(kind, powers=np.exp(turn), held=held, place=place)


class TestTwoMassesWithCubicSprings:
    """A tone alone raises its spring by 3/4 of the square of its amplitude; the truth is that of the simulator."""

    def test_both_modes_within_their_intervals(self) -> None:
        record = rigs.release("cubic", 2, seed=930_006)
        stamps, used = record.stamps, record.stamps > record.start
        found = identify(as_response(np.asarray(stamps[used]), record.values[:, used], ("x1", "x2")))
        wn, zeta = rigs.equivalent_modes(
            record.rig, record.motion, 0.0, float(stamps[-1]) - record.start, seen=record.step
        )
        modes = found.modes
        assert {force.kind for force in found.forces} == {ForceKind.CUBIC}
        assert modes.wn == pytest.approx(wn, rel=2e-3)
        assert modes.zeta == pytest.approx(zeta, rel=0.03)
        assert modes.wn_std is not None
        assert np.all(np.abs(modes.wn - wn) < 3 * modes.wn_std)

    # Along valleys that steps of fixed direction leave, beside a weak second mode, with one near a multiple of the
    # first, and beside a pole that does not turn: files of the simulator in `validation`, which shares nothing with the
    # library.
    @pytest.mark.parametrize(
        ("kind", "seed"),
        [
            ("cubic", 3200033),
            pytest.param("cubic", 3200022, marks=pytest.mark.slow),
            pytest.param("bilinear", 3200015, marks=pytest.mark.slow),
            pytest.param("bilinear", 3300014, marks=pytest.mark.slow),
        ],
    )
    def test_both_modes_from_the_release_on(self, kind: str, seed: int) -> None:
        record = rigs.release(kind, 2, seed=seed)
        stamps, used = record.stamps, record.stamps > record.start
        found = identify(as_response(np.asarray(stamps[used]), record.values[:, used], ("x1", "x2")))
        wn, zeta = rigs.equivalent_modes(
            record.rig, record.motion, 0.0, float(stamps[-1]) - record.start, seen=record.step
        )
        assert found.modes.wn == pytest.approx(wn, rel=5e-3)
        assert found.modes.zeta == pytest.approx(zeta, rel=0.05)


class TestTwoMassesWithFriction:
    """Friction alone changes no frequency: those without it are the truth."""

    @pytest.fixture(scope="class")
    @classmethod
    def found(cls) -> Identification:
        exact, _ = released(LIGHT, HELD, TIME)
        return identify(as_response(TIME, STEP * np.round(exact / STEP), ("x1", "x2")))

    def test_has_both_modes(self, found: Identification) -> None:
        assert found.modes.wn == pytest.approx(RIG.wn, rel=2e-3)

    def test_names_friction_at_both_masses(self, found: Identification) -> None:
        assert {(force.kind, force.channel, force.other) for force in found.forces} == {
            (ForceKind.FRICTION, 0, None),
            (ForceKind.FRICTION, 1, None),
        }

    def test_intervals_hold_the_truth(self, found: Identification) -> None:
        assert found.modes.wn_std is not None
        assert np.all(np.abs(found.modes.wn - RIG.wn) < 3 * found.modes.wn_std)

    def test_damping_rises_as_the_amplitude_falls(self, found: Identification) -> None:
        (_, large), (_, small) = found.amplitude_dependence[0].ends
        assert small > 1.5 * large


# One whose second mode lies at three times the first, where a linear fit has harmonics; one that the linear fit draws
# away from; one that no pole of the linear fit is near.
@pytest.mark.slow
@pytest.mark.parametrize("seed", [5300146, 5300131, 5300103])
def test_friction_does_not_hide_another_mode(seed: int, tmp_path: Path) -> None:
    record = rigs.release("friction", 2, seed=seed)
    rigs.write(record, tmp_path / "release.csv")
    found = analyse(tmp_path / "release.csv")
    assert found.modes.wn == pytest.approx(record.rig.wn / record.pace, rel=0.02)
    outcome = rigs.judged(record, found)
    assert max(outcome.sds) < 4


def test_a_fit_beyond_the_nyquist_frequency_is_no_mode_that_shifts(tmp_path: Path) -> None:
    """Of a few samples of friction a fit put its pole at nine times the sampling rate; that ended in a traceback."""
    record = rigs.release("friction", 2, seed=5300313)
    rigs.write(record, tmp_path / "release.csv")
    values = read_recording(tmp_path / "release.csv")
    part = cut(of_channels(clean(values).record, ["x2 [m]"]), start=0.6445, stop=0.7334)
    assert len(identify(part).response.time) == 58


def without_friction(truth: Structures, *, order: int = 0, damping: float = 1.0, count: int = 150) -> StructureFit:
    """Return a start without forces beside a record of the motion, with noise of 1 / 1000: the amplitudes fit best.

    Its damping is a multiple of the true one. Channels are displacements (0) or accelerations (2).
    """
    theta, shapes = truth.theta[0], truth.shapes[0]
    record = Record(
        values=np.zeros((shapes.shape[1], count)),
        noise=WhiteNoise(least=np.full(shapes.shape[1], 1e-30)),
        theta=theta,
        amplitudes=shapes * theta[:, None] ** order,
        nuisances=np.zeros(1),
    )
    none = structure_of(record, theta, record.amplitudes, truth.forces, order)
    exact = -none.with_structures(truth).residual
    noise = np.std(exact, axis=1, keepdims=True) * np.random.default_rng(1).standard_normal(exact.shape)
    values = exact + 1e-3 * noise
    damped = damping * theta.real + 1j * theta.imag
    powers = np.exp(np.outer(np.arange(count), damped))
    columns = np.column_stack([powers.real, -powers.imag, np.ones(count)])
    parts = np.linalg.lstsq(columns, values.T, rcond=None)[0]
    amplitudes = parts[: len(theta)] + 1j * parts[len(theta) : 2 * len(theta)]
    return structure_of(replace(record, values=values), damped, amplitudes, truth.forces, order)


def slowed_by(of: Structures) -> Real:
    """Return by how much the friction of each mass slows it, per sample squared."""
    speeds = np.einsum("kc,kj->cj", of.shapes[0] * of.theta[0][:, None], of.gains[0]).real
    return np.asarray(-np.diag(speeds))


class TestGuessesOfFriction:
    """Friction that stops both masses after two and a half cycles: the linear fit knows neither its poles nor sizes."""

    RIG = Rig(mass=(2.57, 1.04), stiffness=(4240.0, 1070.0), damping=(1.7, 1.71), friction=(5.9, 5.6))
    HELD = np.array([-0.031, 0.014])

    def test_gains_are_those_of_a_force_on_one_mass(self) -> None:
        modes = structure(RIG, HELD, 1e-3)
        slowed = np.array(RIG.friction) / np.array(RIG.mass) * 1e-6
        guessed = gains_of(modes.theta[0], modes.shapes[0], np.diag(slowed))
        assert guessed == pytest.approx(modes.gains[0], rel=1e-9)

    def test_the_best_start_has_the_friction_of_each_mass_to_a_factor_of_two(self) -> None:
        """Sizes that are tried are 2 to 2.5 times apart."""
        for friction in (self.RIG.friction, (8.0, 0.8)):
            truth = structure(replace(self.RIG, friction=friction), self.HELD, 1 / 300)
            plain = without_friction(truth)
            starts = with_friction(plain)
            losses = [start.loss for start in starts]
            assert len(starts) == 3
            assert losses == sorted(losses)
            assert losses[-1] < plain.loss
            assert np.all(np.abs(np.log2(slowed_by(starts[0].structures) / slowed_by(truth))) < 1)

    @pytest.mark.parametrize("factor", [1.0, 5.0])
    def test_damping_of_a_linear_fit_may_be_friction_or_its_own(self, factor: float) -> None:
        truth = structure(replace(self.RIG, friction=(8.0, 0.8)), self.HELD, 1 / 300)
        start = with_friction(without_friction(truth, damping=factor))[0]
        assert start.theta.real == pytest.approx(truth.theta[0].real)

    def test_accelerations_show_friction_at_once(self) -> None:
        truth = structure(self.RIG, self.HELD, 1 / 300)
        plain = without_friction(truth, order=2)
        start = with_friction(plain)[0]
        assert start.loss < plain.loss - 2 * plain.residual.size
        assert np.all(np.abs(np.log2(slowed_by(start.structures) / slowed_by(truth))) < 1)

    def test_three_masses_have_one_share(self) -> None:
        rig = Rig(
            mass=(2.57, 1.04, 1.5),
            stiffness=(4240.0, 1070.0, 3000.0),
            damping=(1.7, 1.71, 1.0),
            friction=(5.9, 5.6, 4.0),
        )
        truth = structure(rig, np.array([-0.031, 0.014, 0.02]), 1 / 300)
        start = with_friction(without_friction(truth))[0]
        assert abs(np.log2(np.median(slowed_by(start.structures) / slowed_by(truth)))) < 1

    def test_there_are_none_where_no_friction_explains_a_record(self) -> None:
        assert (
            with_friction(without_friction(structure(replace(self.RIG, friction=(0.0, 0.0)), self.HELD, 1 / 300))) == []
        )

    @pytest.mark.parametrize(
        ("cycles", "count", "soon"),
        [((8.0, 24.0), 300, True), ((12.0, 36.0), 300, False), ((4.0,), 300, False), ((4.0, 12.0), 30000, False)],
    )
    def test_are_made_of_several_masses_in_short_records(
        self, cycles: tuple[float, ...], count: int, soon: bool
    ) -> None:
        """Up to ten cycles of the slowest mode, and a thousand steps."""
        theta = 2j * np.pi * np.array(cycles) / count
        start = cast("DrivenFit", SimpleNamespace(drive=SimpleNamespace(theta=theta)))
        record = cast("Record", SimpleNamespace(values=np.zeros((len(cycles), count))))
        assert stops_soon(record, start) is soon

    def test_both_modes_are_found(self) -> None:
        time = np.asarray(np.arange(170) / 300, float)
        exact, stop = released(self.RIG, self.HELD, time)
        found = identify(as_response(time, 1e-4 * np.round(exact / 1e-4), ("x1", "x2")))
        assert 2 < stop * self.RIG.wn[0] / (2 * np.pi) < 2.6
        assert found.modes.wn == pytest.approx(self.RIG.wn, rel=0.01)
        assert {force.kind for force in found.forces} == {ForceKind.FRICTION}


class TestBegun:
    """What is returned is the best of all fits to the whole record."""

    def fits(
        self, truth: Structures, count: int, monkeypatch: pytest.MonkeyPatch
    ) -> tuple[StructureFit, list[StructureFit]]:
        """Return what a fit begins with that no structure explains, and all that were made."""
        plain, made = without_friction(truth, count=count), list[StructureFit]()
        of = plain.structures
        drive = Drive(
            theta=of.theta[0],
            gains=np.zeros((of.theta.shape[1], 0), complex),
            forces=np.zeros((0, count)),
            nuisances=np.zeros(1),
        )
        start = maximize(plain.record.values, drive, plain.record.noise, steps=10)
        assert start is not None

        def spied(*args: Any, **more: Any) -> StructureFit:
            made.append(fitted(*args, **more))
            return made[-1]

        monkeypatch.setattr(beginnings, "fitted", spied)
        return begun(plain.record, start, 0, of.kind, highest=-np.inf), made

    @pytest.mark.parametrize(
        ("cubic", "step", "parts"),
        [(2000.0, 0.01, [80, 32, 80]), (4000.0, 0.01, [80, 32, 80]), (2500.0, 0.01, [80])],
    )
    def test_where_something_is_missed_the_beginning_is_fitted_first(
        self, cubic: float, step: float, parts: list[int], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """With the first spring that is better, with the second worse; with the third nothing is missed."""
        rig = replace(TestMotionOfSmoothForces.RIG, cubic=np.array([cubic, cubic / 2]))
        truth = TestMotionOfSmoothForces.structure(rig, ForceKind.CUBIC, step)
        found, made = self.fits(truth, 80, monkeypatch)
        assert [fit.residual.shape[1] for fit in made] == parts
        assert found.bic == min(fit.bic for fit in made if fit.residual.shape[1] == 80)

    def test_with_guesses_of_friction(self, monkeypatch: pytest.MonkeyPatch) -> None:
        truth = structure(TestGuessesOfFriction.RIG, TestGuessesOfFriction.HELD, 1 / 300)
        found, made = self.fits(truth, 100, monkeypatch)
        assert len(made) > 4
        assert found.bic == min(fit.bic for fit in made)


# Masses that stop before their second or third cycle: friction promises nothing beside a linear fit, and first steps
# from it say little.
@pytest.mark.slow
@pytest.mark.parametrize("seed", [5300116, 5300303])
def test_friction_that_stops_masses_soon_is_tried(seed: int, tmp_path: Path) -> None:
    record = rigs.release("friction", 2, seed=seed)
    rigs.write(record, tmp_path / "release.csv")
    outcome = rigs.judged(record, analyse(tmp_path / "release.csv"))
    assert outcome.right
    assert abs(outcome.wn) < 0.002
    assert abs(outcome.zeta) < 0.05


# The first sample is of the hold before the release: a third mode follows it, and is none. Of two cycles before a dead
# stop a linear fit grows.
@pytest.mark.parametrize(
    ("seed", "late", "within"), [pytest.param(930_015, -0.003, 0.002, marks=pytest.mark.slow), (930_004, 0.002, 0.02)]
)
def test_what_is_left_of_the_first_samples_hides_no_modes(seed: int, late: float, within: float) -> None:
    record = rigs.release("friction", 2, seed=seed)
    moves = (record.stamps >= record.start + late) & (record.stamps <= record.stop)
    time = np.linspace(record.stamps[0], record.stamps[-1], len(record.stamps))[moves]
    found = identify(as_response(time, record.values[:, moves], ["x1", "x2"]))
    assert found.modes.wn == pytest.approx(record.rig.wn / record.pace, rel=within)
    assert {force.kind for force in found.forces} == {ForceKind.FRICTION}
