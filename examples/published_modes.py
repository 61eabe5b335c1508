"""
Springs from published modes
============================

From published natural frequencies and damping ratios to springs and dampers, checked as in a test.

Frequencies and damping alone may belong to two sets of springs; a nominal car that is roughly right says which.
"""

from suspid import ModalSet, compare, eigenmodes, quarter_car, reconstruct

# A quarter car as a catalogue gives it: two modes, their masses, and no mode shapes.
published = ModalSet.from_wn_zeta([6.81462, 73.3716], [0.231436, 0.259608])

# Known masses; springs and dampers as one would guess them. The tire's small damping is held at nothing.
nominal = quarter_car(
    chassis_mass=400,
    tire_mass=40,
    chassis_stiffness=25e3,
    tire_stiffness=160e3,
    chassis_damping=1200,
)
found = reconstruct(published, nominal, fixed=["tire.damping"])
print(found, "\n")
drawn = found.plot()


def test_the_springs_have_the_published_modes() -> None:
    """Six digits were published. If this fails, pytest shows the table of what is off and by how much."""
    c = compare(eigenmodes(found.suspension), published, rtol=1e-5)
    assert c.passed, c


def test_the_springs_are_those_of_the_car() -> None:
    """Which the publication knew, and we did not."""
    car = nominal.with_parameters(stiffness={"chassis": 20e3, "tire": 200e3}, damping={"chassis": 1500.0})
    c = compare(found.suspension, car, rtol=1e-4)
    assert c.passed, c


test_the_springs_have_the_published_modes()
test_the_springs_are_those_of_the_car()
