"""Shapes of channels that measure displacement, velocity and acceleration of one motion."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from suspid import InputError, ModalSet, eigenmodes, plot_shapes, quarter_car
from suspid.model import scaled_shapes
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

    def test_units_that_are_alike_or_not_known_change_nothing(self) -> None:
        assert EXACT.shapes is not None
        for units in (None, ["m/s2"] * 3, [""] * 3):
            (group,) = shape_groups(EXACT, units)
            assert np.array_equal(group.shapes, scaled_shapes(EXACT.shapes))

    def test_a_pole_at_zero_leaves_each_unit_a_group(self) -> None:
        modes = ModalSet(poles=np.array([0.0]), shapes=np.ones((2, 1), complex), channels=["a", "b"])
        assert [group.unit for group in shape_groups(modes, ["m", "m/s"])] == ["m", "m/s"]


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
