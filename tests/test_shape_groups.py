"""Shapes of channels that measure displacement, velocity and acceleration of one motion."""

from __future__ import annotations

import control
import numpy as np
import pytest
from matplotlib.figure import Figure

from suspid import InputError, ModalSet, eigenmodes, free_decay, identify, plot_shapes, quarter_car, statespace
from suspid.model import scaled_shapes
from suspid.records import as_response
from suspid.reporting.shape_groups import shape_groups

CAR = quarter_car(
    seat_mass=200, chassis_mass=200, tire_mass=200, seat_stiffness=200e3, chassis_stiffness=400e3,
    tire_stiffness=800e3, seat_damping=300, chassis_damping=200, tire_damping=100,
)  # fmt: skip
EXACT = eigenmodes(CAR)


def measured(orders: list[int], factors: list[float]) -> ModalSet:
    """Modes as sensors of derivatives of the displacement see them, in units of these sizes."""
    assert EXACT.shapes is not None
    by = np.array([EXACT.poles**order / factor for order, factor in zip(orders, factors, strict=True)])
    return ModalSet(poles=EXACT.poles, shapes=EXACT.shapes * by, channels=EXACT.channels)


class TestCommonMotion:
    def test_derivatives_come_back_to_the_shapes_of_displacements(self) -> None:
        """d/dt multiplies a component by the pole: mm, m/s and g together give the shape that metres give."""
        modes = measured([0, 1, 2], [1e-3, 1.0, 9.80665])
        (group,) = shape_groups(modes, ["mm", "m/s", "g"])
        assert EXACT.shapes is not None
        assert group.shapes == pytest.approx(scaled_shapes(EXACT.shapes), abs=1e-12)
        assert group.brought

    def test_so_do_those_of_angles(self) -> None:
        (group,) = shape_groups(measured([0, 1, 2], [1.0, np.pi / 180, np.pi / 180]), ["rad", "deg/s", "deg/s^2"])
        assert EXACT.shapes is not None
        assert group.shapes == pytest.approx(scaled_shapes(EXACT.shapes), abs=1e-12)
        assert group.unit == "rad"

    def test_units_that_are_alike_or_not_known_change_nothing(self) -> None:
        assert EXACT.shapes is not None
        for units in (None, ["m/s2"] * 3, [""] * 3):
            (group,) = shape_groups(EXACT, units)
            assert np.array_equal(group.shapes, scaled_shapes(EXACT.shapes))

    def test_a_pole_at_zero_leaves_each_unit_a_group(self) -> None:
        modes = ModalSet(poles=np.array([0.0]), shapes=np.ones((2, 1), complex), channels=["a", "b"])
        assert [group.unit for group in shape_groups(modes, ["m", "m/s"])] == ["m", "m/s"]


class TestNames:
    def test_words_keep_quantities_apart_where_units_are_missing(self) -> None:
        modes = ModalSet(poles=EXACT.poles, shapes=EXACT.shapes, channels=["disp", "vel", "acc_body"])
        ax = plot_shapes(modes, ax=Figure().subplots())
        labels = ["disp [disp.]", "vel [vel.]", "acc_body [acc.]"]
        assert [label.get_text() for label in ax.get_yticklabels()] == labels
        assert ax.get_title(loc="left") == "shapes [1 = largest by unit]"

    def test_letters_keep_quantities_apart_where_they_stand_before_one_name(self) -> None:
        modes = ModalSet(poles=EXACT.poles, shapes=EXACT.shapes, channels=["z_seat_m", "z_wheel_m", "a_seat"])
        assert [group.channels for group in shape_groups(modes, None)] == [(0, 1), (2,)]
        apart = ModalSet(poles=EXACT.poles, shapes=EXACT.shapes, channels=["z_seat_m", "z_wheel_m", "a_tire"])
        assert len(shape_groups(apart, None)) == 1

    def test_bars_that_cannot_be_seen_are_said_to_be_without_units(self) -> None:
        small = measured([0, 0, 0], [1.0, 1.0, 1000.0])
        assert "without units" in plot_shapes(small, ax=Figure().subplots()).get_title(loc="left")
        alike = plot_shapes(small, ax=Figure().subplots(), units=["m"] * 3).get_title(loc="left")
        assert alike == plot_shapes(EXACT, ax=Figure().subplots()).get_title(loc="left") == "shapes [1 = largest]"

    def test_collinearity_is_that_of_displacements(self) -> None:
        """A velocity leads its displacement by a quarter turn: that is no phase between masses."""
        t = np.arange(0, 6, 0.005)
        plain = free_decay(CAR, t, initial_state={"v_tire": 1.0})
        moved = control.initial_response(
            statespace(CAR, outputs=["seat", "chassis_velocity", "tire_acceleration"]), t, [0.0] * 5 + [1.0]
        )
        names = ["seat", "chassis_velocity", "acc tire [m/s2]"]
        mixed = identify(as_response(t, moved.outputs, names), candidates=[8.0])
        assert mixed.collinearity == pytest.approx(identify(plain, candidates=[8.0]).collinearity, abs=1e-6)
        # What some channels do not say is what the others do.
        alike = identify(as_response(t, plain.outputs, ["a", "acc b", "c [m/s2]"]), candidates=[8.0])
        assert alike.collinearity == pytest.approx(identify(plain, candidates=[8.0]).collinearity, abs=1e-12)
        assert min(identify(as_response(t, moved.outputs, ["a", "b", "c"]), candidates=[8.0]).collinearity) < 0.95


class TestGroups:
    def test_lengths_and_angles_stand_apart_with_one_phase(self) -> None:
        """Pitch in antiphase to heave stays so, though each group has a largest of its own."""
        shapes = np.array([[2.0], [-0.01], [1.0]])
        modes = ModalSet(poles=np.array([-1 + 10j]), shapes=shapes, channels=["front", "pitch", "rear"])
        lengths, angles = shape_groups(modes, ["m", "rad", "m"])
        assert lengths.channels == (0, 2)
        assert lengths.shapes.ravel() == pytest.approx([1.0, 0.5])
        assert angles.shapes.ravel() == pytest.approx([-1.0])

    def test_the_picture_says_what_is_shown(self) -> None:
        ax = plot_shapes(measured([0, 2, 0], [1.0, 1.0, 1.0]), ax=Figure().subplots(), units=["m", "m/s^2", "V"])
        assert ax.get_title(loc="left") == "shapes as displacement [1 = largest by unit]"
        assert [label.get_text() for label in ax.get_yticklabels()] == ["seat [m]", "chassis [m]", "tire [V]"]

    def test_a_unit_for_each_channel(self) -> None:
        with pytest.raises(InputError, match="2 units for 3 channels"):
            shape_groups(EXACT, ["m", "m"])
