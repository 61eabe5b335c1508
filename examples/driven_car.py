"""
Springs and dampers from a drive
================================

A quarter car on a rough road, straight to its springs and dampers: on a rig whose road is known, then in a drive.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from suspid import add_noise, estimate, plot_estimate, quarter_car, road_profile, simulate

true = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
nominal = true.with_parameters(stiffness={"chassis": 16e3, "tire": 250e3}, damping={"chassis": 1700})

# A minute on a road of class B at 20 m/s, seen by two accelerometers with noise.
rng, t = np.random.default_rng(3), np.arange(0, 60, 0.005)
road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
sensors = ["chassis_acceleration", "tire_acceleration"]
clean = simulate(true, t, {"road": road - road[0]}, outputs=sensors, interpolation="cubic")
record = add_noise(clean, snr_db=30.0, rng=rng)

# The road is known, as on a rig: everything can be found.
rig = estimate(record, nominal, given=["road"])
print(f"on a rig\n{rig}\n")

# It is not: with the motion of the wheel given, road, tire and wheel cancel.
drive = estimate(record, nominal, given=["tire"])
print(f"in a drive\n{drive}\n")

for name, value in (("chassis.stiffness", 22e3), ("chassis.damping", 1300.0)):
    ends = [found.interval(0.999)[name] for found in (rig, drive)]
    print(f"{name}: both intervals hold {value:g}:", all(low <= value <= high for low, high in ends))
picture = sys.argv[1] if len(sys.argv) > 1 else f"{tempfile.mkdtemp()}/driven_car.png"
drawn = plot_estimate(drive, Figure(figsize=(8, 9)))
drawn.savefig(picture, dpi=120)
print(f"drawn to {Path(picture)}")
