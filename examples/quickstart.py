"""
From a record to modes to springs
=================================

A car you know, its noisy free decay, the modes found in it, and the springs found from those.

Run it as ``python examples/quickstart.py``.
"""

import numpy as np

from suspid import add_noise, compare, eigenmodes, free_decay, identify, quarter_car, reconstruct

# The car of Table 1. Its printed damping is a tenth of what Table 2 belongs to; this is the latter.
car = quarter_car(
    seat_mass=200,
    chassis_mass=200,
    tire_mass=200,
    seat_stiffness=200e3,
    chassis_stiffness=400e3,
    tire_stiffness=800e3,
    seat_damping=300,
    chassis_damping=200,
    tire_damping=100,
)

# Ten seconds after a kick at the tire, at 500 Hz, with noise 20 dB below the motion.
decay = free_decay(car, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})
record = add_noise(decay, snr_db=20.0, rng=np.random.default_rng(1))

found = identify(record, modes=3)
print(found, "\n")

# The truth is known here. By its own uncertainty, every value found should lie well within 2 % of it.
print(compare(found.modes, eigenmodes(car), rtol=0.02), "\n")

# Masses are known; springs and dampers only roughly.
nominal = car.with_parameters(stiffness={"seat": 260e3, "tire": 600e3}, damping={"chassis": 260.0})
print(reconstruct(found.modes, nominal))

# Every result draws itself; in a notebook the last line of a cell does so without a call.
drawn = found.plot()
