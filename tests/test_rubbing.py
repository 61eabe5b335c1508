"""Friction in struts and against the ground: equations of motion, and where it acts."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import Identification, identify
from suspid.analysis.shown_modes import known_modes
from suspid.identification.covariance import with_changes
from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear import choice
from suspid.identification.nonlinear.descent import Around, _along, _moved_by_fits, _placed, fitted
from suspid.identification.nonlinear.driven import DrivenFit, maximize
from suspid.identification.nonlinear.equations import Measured, _start, equations_of, from_equations, rubbing
from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.forces import Force, ForceKind, forces_of
from suspid.identification.nonlinear.rubbing import by_equations, followed_on
from suspid.identification.nonlinear.structure import StructureFit, _with_turns, jumps_of, parameters_of
from suspid.model import ModalSet
from suspid.records import as_response
from validation import rigs

Real = NDArray[np.float64]

STEP = 1 / 400
# Both masses slide against each other for 9 cycles of the slower mode.
RIG = rigs.Rig(
    mass=np.array([2.0, 1.0]),
    stiffness=np.array([3000.0, 2000.0]),
    damping=np.array([1.5, 1.0]),
    friction=np.array([0.4, 0.8]),
    cubic=np.zeros(2),
    struts=True,
)
HELD = np.array([0.03, 0.06])
# About what a linear fit has.
LINEAR = np.asarray((-0.03 + 1j) * RIG.wn * STEP, complex)
GROUND = forces_of(ForceKind.FRICTION, 2, most=2)
STRUTS, TURNED = rubbing(np.array([[5.0, -2.0], [-3.0, 3.0]]))


def moved(rig: rigs.Rig, count: int = 400, order: int = 0) -> Real:
    """Return the displacements of a rig (order 0), its speeds or its accelerations, (mass, sample)."""
    motion = rigs.released(rig, HELD, np.asarray(STEP * np.arange(count), float))
    return (motion.position, motion.velocity, rigs.accelerations(rig, motion))[order][:, 1:]


def measured(values: Real, order: int = 0) -> Measured:
    return Measured.of(values, order, LINEAR, 0.0, 3000)


def record_of(rig: rigs.Rig, *, noise: float = 3e-4, order: int = 0) -> tuple[Record, DrivenFit]:
    """Return a record of the motion in noise, a share of its largest value, and a linear fit with two modes."""
    values = moved(rig, order=order)
    values = values - values.mean(axis=1, keepdims=True)
    values = values + noise * np.max(np.abs(values)) * np.random.default_rng(3).standard_normal(values.shape)
    record = Record(
        values=values,
        noise=WhiteNoise(least=np.full(2, 1e-14)),
        theta=np.zeros(0, complex),
        amplitudes=np.zeros((0, 2), complex),
        nuisances=np.zeros(1),
    )
    start = record.empty()
    for wn in rig.wn:
        start = start.with_pole(complex(-0.03 + 1j) * wn * STEP)
    plain = maximize(values, start, record.noise, steps=10)
    assert plain is not None
    return record, plain


def start_of(record: Record, forces: tuple[Force, ...]) -> StructureFit:
    """The start from equations with friction at a place."""
    of = measured(record.values)
    equations = equations_of(of, forces, 12)
    assert equations is not None
    start = _start(record, of, equations)
    assert start is not None
    return start


class TestEquations:
    def test_are_those_of_the_rig(self) -> None:
        """Newton's law: what was not told is regressed on the motion."""
        values, half = moved(RIG), 12
        found = equations_of(measured(values), STRUTS, half)
        assert found is not None
        assert np.all(found.told > 0.99)
        inverse, links = np.diag(1 / RIG.mass), RIG.links
        stiffness = inverse @ links.T @ np.diag(RIG.stiffness) @ links * STEP**2
        slowed = inverse @ links.T @ np.diag(RIG.friction) * STEP**2
        assert found.stiffness == pytest.approx(stiffness, rel=0.03)
        assert found.slowed == pytest.approx(slowed, rel=0.15, abs=0.02 * np.max(np.abs(slowed)))

    def test_starts_have_the_modes_and_begin_where_the_motion_does(self) -> None:
        record, plain = record_of(RIG)
        first = next(from_equations(record, plain.drive.theta, longest=3000))[0][0]
        assert first.forces == STRUTS
        assert first.order == 0
        assert np.abs(first.theta) == pytest.approx(RIG.wn * STEP, rel=0.02)
        left = np.sqrt(np.mean(first.residual**2, axis=1))
        assert np.all(left < 0.1 * np.std(record.values, axis=1))

    def test_none_of_too_few_samples(self) -> None:
        values = moved(RIG, 55)
        assert equations_of(measured(values), STRUTS, 10) is None

    @pytest.mark.parametrize("order", [1, 2])
    def test_of_speeds_and_accelerations_are_the_same(self, order: int) -> None:
        found = equations_of(measured(moved(RIG, order=order), order), STRUTS, 12)
        assert found is not None
        assert found.modes is not None
        assert np.abs(found.modes[0]) == pytest.approx(RIG.wn * STEP, rel=0.02)
        slowed = np.diag(1 / RIG.mass) @ RIG.links.T @ np.diag(RIG.friction) * STEP ** (2 - order)
        assert found.slowed == pytest.approx(slowed, rel=0.2, abs=0.05 * np.max(np.abs(slowed)))

    @pytest.mark.parametrize("order", [0, 1, 2])
    def test_what_was_measured_is_tried_first(self, order: int) -> None:
        record, plain = record_of(RIG, order=order)
        first = next(from_equations(record, plain.drive.theta, longest=3000))[0][0]
        assert first.order == order
        assert first.forces == STRUTS

    def test_they_must_tell_most_where_that_is_asked_for(self) -> None:
        record, plain = record_of(RIG)
        noise = replace(record, values=np.random.default_rng(4).standard_normal(record.values.shape))
        assert any(any(ranks) for ranks in from_equations(noise, plain.drive.theta, longest=3000))
        assert not any(any(ranks) for ranks in from_equations(noise, plain.drive.theta, longest=3000, least=0.6))
        assert any(any(ranks) for ranks in from_equations(record, plain.drive.theta, longest=3000, least=0.6))


class TestRubbing:
    def test_a_chain_goes_to_the_mass_that_is_coupled_most(self) -> None:
        """Channels are the upper mass, the lower one and the one between them."""
        links = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 1.0], [1.0, 0.0, -1.0]])
        stiffness = links.T @ np.diag([3000.0, 2000.0, 1000.0]) @ links / np.array([[1.0], [2.0], [0.5]])
        places = [[(force.channel, force.other) for force in forces] for forces in rubbing(stiffness)]
        assert places[0] == [(1, None), (2, 1), (0, 2)]
        assert len(places) == 3

    @pytest.mark.slow
    def test_three_masses(self) -> None:
        """The fit finds three modes that a linear one does not, of any order of channels."""
        record = rigs.release(rigs.IN_STRUTS, 3, seed=2)
        moves = (record.stamps > record.start + 0.003) & (record.stamps < record.stuck - 0.002)
        time = np.linspace(record.stamps[0], record.stamps[-1], len(record.stamps))[moves]
        found = identify(as_response(time, record.values[::-1, moves], ["x3", "x2", "x1"]))
        assert found.modes.wn == pytest.approx(record.rig.wn / record.pace, rel=0.005)


class TestWhereFrictionActs:
    @pytest.mark.parametrize(("struts", "where"), [(True, STRUTS), (False, GROUND)])
    def test_is_told(self, struts: bool, where: tuple[object, ...]) -> None:
        record, plain = record_of(replace(RIG, struts=struts))
        best, *others = by_equations(record, plain, most=6, highest=plain.bic - 1000, longest=3000, followed=True)
        assert best.forces == where
        assert np.abs(fitted(best).theta) == pytest.approx(RIG.wn * STEP, rel=1e-3)
        assert all(other.bic > best.bic + 50 for other in others)

    def test_the_mass_above_may_be_the_first_channel(self) -> None:
        record, plain = record_of(RIG)
        other = replace(record, values=record.values[::-1])
        turned = maximize(other.values, plain.drive, other.noise, steps=5)
        assert turned is not None
        assert (
            by_equations(other, turned, most=6, highest=turned.bic - 1000, longest=3000, followed=True)[0].forces
            == TURNED
        )

    def test_where_it_does_not_a_fit_is_left(self) -> None:
        record, plain = record_of(RIG)
        best = by_equations(record, plain, most=6, highest=plain.bic - 1000, longest=3000, followed=True)[0]
        reached = best.loss / best.residual.size
        for forces, left in ((GROUND, True), (STRUTS, False)):
            start = start_of(record, forces)
            assert (followed_on(start, reached=reached) is None) is left

    def test_nothing_is_tried_where_a_linear_fit_leaves_noise(self) -> None:
        record, plain = record_of(replace(RIG, friction=np.zeros(2)))
        assert by_equations(record, plain, most=6, highest=plain.bic, longest=3000, followed=True) == []

    def test_nor_where_fewer_modes_are_asked_for(self) -> None:
        record, plain = record_of(RIG)
        assert by_equations(record, plain, most=1, highest=plain.bic, longest=3000, followed=True) == []


def test_where_a_record_does_not_tell_where_friction_acts_intervals_hold_both() -> None:
    """Three cycles in steps of a seventieth of the motion: two places explain them as well."""
    record = rigs.release(rigs.IN_STRUTS, 2, seed=920_069)
    moves = (record.stamps > record.start + 0.004) & (record.stamps < record.stuck - 0.002)
    time = np.linspace(record.stamps[0], record.stamps[-1], len(record.stamps))[moves]
    found = identify(as_response(time, record.values[:, moves], ["x1", "x2"]))
    truth = record.rig.wn / record.pace
    assert found.modes.wn_std is not None
    assert len(found.modes) == 2
    assert np.all(np.abs(found.modes.wn - truth) < 2.5 * found.modes.wn_std)


class TestFit:
    def start(self) -> StructureFit:
        record, _ = record_of(RIG)
        return start_of(record, STRUTS)

    def test_no_force_moves_a_mass_at_once(self) -> None:
        fit = fitted(self.start())
        assert np.max(np.abs(jumps_of(fit.structures))) < 1e-12 * np.max(np.abs(fit.structures.shapes))

    def test_derivatives_are_those_of_small_steps(self) -> None:
        of = self.start().structures
        at = _moved_by_fits(of)
        along = _along(of, at)
        for k in range(len(at)):
            step = 1e-4 * (abs(at[k]) + 1e-3 * np.max(np.abs(at)))
            apart = [parameters_of(_placed(of, (at + side * step * np.eye(len(at))[k])[None]))[0] for side in (1, -1)]
            assert along[k] == pytest.approx((apart[0] - apart[1]) / (2 * step), rel=1e-4, abs=1e-6 * np.max(along[k]))

    def test_stays_around_what_is_known(self) -> None:
        start = self.start()
        near = fitted(start, around=Around.of(start.structures, share=1e-9, none=1e-9))
        assert near.theta == pytest.approx(start.theta, rel=1e-6)
        free = fitted(start)
        assert np.max(np.abs(free.theta - start.theta)) > 1e-4 * np.max(np.abs(start.theta))


class TestAccelerations:
    """Friction shows in them at once: samples next to which it turns tell when."""

    def test_what_it_is_where_it_turns_is_told_by_the_samples(self) -> None:
        record, plain = record_of(RIG, order=2)
        best = by_equations(record, plain, most=6, highest=plain.bic - 1000, longest=3000, followed=True)[0]
        assert best.order == 2
        assert best.structures.turns
        means = best.with_structures(replace(best.structures, turns=False))
        assert means.loss > best.loss + 2 * best.residual.size
        noise = 3e-4 * np.max(np.abs(record.values))
        assert np.sqrt(np.mean(best.residual**2, axis=1)) == pytest.approx(np.full(2, noise), rel=0.3)
        assert np.abs(best.theta) == pytest.approx(RIG.wn * STEP, rel=1e-3)

    def test_it_stays_between_what_it_is_about_them(self) -> None:
        acting = np.array([[1.0, 1.0, -0.2, -1.0, -1.0, 0.3, 0.3, 0.3]])
        about = 0.5 * (acting[:, [0, 0, 1, 2, 3, 4, 5, 6]] + acting)[None]
        left = np.array([[0.0, 0.0, 9.0, -9.0, 0.0, 0.0, 0.0, 9.0]])
        found = _with_turns(about, acting, np.ones((1, 1)), left)[0, 0]
        assert found[:2].tolist() == [1.0, 1.0]
        assert found[2] == 1.0
        assert found[3] == -1.0
        # What is held, and not about to slide, has its mean whatever is left.
        assert found[7] == pytest.approx(0.3)

    def test_of_displacements_nothing_is_told(self) -> None:
        record, plain = record_of(RIG)
        best = by_equations(record, plain, most=6, highest=plain.bic - 1000, longest=3000, followed=True)[0]
        assert not best.structures.turns

    @pytest.mark.parametrize("followed", [True, False])
    def test_a_car_whose_wheel_no_linear_mode_follows(self, followed: bool) -> None:
        """Friction of a fiftieth of the spring force, two cycles of the body: each stop rings the wheel."""
        car = rigs.Rig(
            mass=np.array([35.0, 300.0]),
            stiffness=np.array([150e3, 20e3]),
            damping=np.array([100.0, 1200.0]),
            friction=np.array([0.0, 30.0 if not followed else 6.0]),
            cubic=np.zeros(2),
            struts=True,
        )
        motion = rigs.released(car, np.array([0.004, 0.04]), np.arange(400) / 250)
        felt = rigs.accelerations(car, motion)[:, 1 : int(min(motion.stuck, 1.6) * 250) - 1]
        felt = felt + 3e-3 * np.max(np.abs(felt), axis=1)[:, None] * np.random.default_rng(5).standard_normal(
            felt.shape
        )
        found = identify(as_response(np.arange(felt.shape[1]) / 250, felt, ["wheel", "body"]))
        exact = np.linalg.eigvals(
            np.block(
                [
                    [np.zeros((2, 2)), np.eye(2)],
                    [
                        -(car.links.T @ np.diag(each) @ car.links) / car.mass[:, None]
                        for each in (car.stiffness, car.damping)
                    ],
                ]
            )
        )
        assert found.modes.wn == pytest.approx(np.sort(np.abs(exact))[::2], rel=0.02)
        assert "friction" in str(found.forces)


def test_damping_that_depends_on_the_choice_of_a_stretch_leaves_the_frequency_known() -> None:
    """The poles lie on a circle about zero, not on its tangent."""
    pole = 10 * np.exp(1j * np.arccos(-0.4))
    other = 10 * np.exp(1j * np.arccos(-0.1))
    modes = ModalSet(poles=np.array([pole]), shapes=np.ones((1, 1), complex), covariance=1e-8 * np.eye(4))
    both = with_changes(modes, [np.array([other - pole])])
    assert both.wn_std is not None
    assert both.zeta_std is not None
    assert both.wn_std[0] == pytest.approx(0.0, abs=2e-4)
    assert both.zeta_std[0] == pytest.approx(0.3)


def test_a_structure_is_none_where_another_fit_explains_more() -> None:
    record, plain = record_of(RIG)
    best = choice.chosen(record, plain, None, most=6, highest=plain.bic - 1000, followed=True, rubs=True)
    assert best is not None
    assert choice.chosen(record, plain, None, most=6, highest=best.bic - 5, followed=True, rubs=True) is None
    assert choice.chosen(record, plain, None, most=6, highest=best.bic + 5, followed=True, rubs=True) is not None


@pytest.fixture(scope="module")
def rubbed() -> Identification:
    """What is found of two masses whose upper strut is locked after six cycles."""
    record = rigs.release(rigs.IN_STRUTS, 2, seed=3033)
    moves = (record.stamps > record.start + 0.003) & (record.stamps < record.stuck - 0.002)
    time = np.linspace(record.stamps[0], record.stamps[-1], len(record.stamps))[moves]
    return identify(as_response(time, record.values[:, moves], ["x1", "x2"]))


class TestDampingThatChanges:
    """Of modes that friction damps the ratio differs from part to part by more than itself, and is known in each."""

    def test_is_a_mode(self, rubbed: Identification) -> None:
        assert len(rubbed.modes) == 2
        assert rubbed.modes.zeta_std is not None
        assert np.all(rubbed.modes.zeta_std > 0.25 * rubbed.modes.zeta)

    def test_counts_as_known(self, rubbed: Identification) -> None:
        assert known_modes(rubbed) >= 1
        assert known_modes(replace(rubbed, amplitude_dependence=())) == 0
